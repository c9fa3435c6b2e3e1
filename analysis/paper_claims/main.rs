//! A landscape of grasps beside the taxonomy, with the claims of a paper → `NAME.md`
//!
//! `cargo run --release --example paper_claims LANDSCAPE NAME [SEED]`: `data/grasps.landscape figures/taxonomy_comparison`
//! gives the figure of that name. The statistics are those of `landscape compare`. Two claims evaluate the
//! energy: after fingers have been lifted, and on hands without a thumb.

mod claims;

use std::path::Path;

fn main() -> Result<(), claims::Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, name, seed) = match &arguments[..] {
        [folder, name] => (folder, name, 0),
        [folder, name, seed] => (folder, name, seed.parse()?),
        _ => return Err("usage: paper_claims LANDSCAPE NAME [SEED]".into()),
    };
    claims::write(Path::new(folder), name, seed)
}
