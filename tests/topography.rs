//! Energies, spaces and their landscapes. One program for all these files: each program of tests costs a link.

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
