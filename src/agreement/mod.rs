//! How well numbers agree with what is true: the statistics.

mod roc;

pub use roc::{Roc, RocError, RocPoint};
