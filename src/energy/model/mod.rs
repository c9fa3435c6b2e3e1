//! Reference surfaces with known minima and saddles.

mod muller_brown;

pub use muller_brown::MullerBrown;
