//! Half two: maps any energy. Minima, paths between them, barriers, the tree.
