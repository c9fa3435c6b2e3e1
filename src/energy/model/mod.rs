//! Reference surfaces with known minima and saddles.

mod double_well;
mod lennard_jones;
mod muller_brown;
mod named;
mod orientation;
mod three_hole;
mod torsion;

pub use double_well::DoubleWell;
pub use lennard_jones::LennardJones;
pub use muller_brown::MullerBrown;
pub use named::{MODELS, Model, ModelError, Surface, named};
pub use orientation::Orientation;
pub use three_hole::ThreeHole;
pub use torsion::Torsion;
