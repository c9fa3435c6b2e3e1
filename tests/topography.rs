//! Energies, spaces and their landscapes. All these files form one test program, because each program must be linked.
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod agreement;
mod barriers;
mod completeness;
mod gradients;
mod growing;
mod kinetics;
mod lennard_jones;
mod muller_brown;
mod odd_energies;
mod paths;
mod pruning;
mod random_surfaces;
#[path = "../analysis/roc.rs"]
mod roc;
mod saddles;
mod sampler;
mod sequential;
mod spaces;
mod units;
#[path = "../analysis/completeness/waves.rs"]
mod waves;
