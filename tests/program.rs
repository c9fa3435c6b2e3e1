//! The whole program and its files. All these files form one test program, because each program must be linked.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

mod architecture;
mod claims;
mod described;
mod desk;
mod exchange;
mod folder;
mod inspect;
mod labels;
mod mended_meshes;
mod messages;
mod object_files;
mod object_sizes;
mod pages;
#[expect(dead_code, reason = "what only `write` calls reads whole landscapes")]
#[path = "../analysis/paper_claims/claims/mod.rs"]
mod paper_claims;
mod parts;
mod pickled;
mod skipped;
mod store;
mod surface;
mod table;
mod thermodynamics;
mod toy_hand;
mod trees;
mod way;
