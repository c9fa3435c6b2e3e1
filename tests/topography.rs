//! Energies, spaces and their landscapes. All these files form one test program, because each program must be linked.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod agreement;
mod barriers;
mod completeness;
mod diagram;
mod gradients;
mod lennard_jones;
mod models;
mod muller_brown;
mod paths;
mod pruning;
mod saddles;
mod sequential;
mod spaces;
