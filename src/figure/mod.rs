//! Pictures: layout is pure geometry, painting is plotters.
