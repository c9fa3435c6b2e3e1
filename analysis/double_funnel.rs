//! The double funnel of 38 Lennard-Jones atoms: how low a barrier `landscape surface lj 38` finds, beside the published one →
//! `figures/double_funnel.md`, `figures/double_funnel.png` and `figures/double_funnel_thermodynamics.png`
//!
//! `cargo run --release --example double_funnel -- BUDGET SEED...` searches with each seed for at most the time BUDGET (such as
//! 10m) unless `target/double_funnel` holds its landscape. The picture is that of the first seed.

#[path = "command.rs"]
mod command;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use command::landscape;
use landscape::store::LandscapeFiles;
use landscape::topography::{Evidence, MinimumId, Tree};
use serde_json::Value;

/// The truncated octahedron, the lowest icosahedral minimum, and the highest saddle of the lowest way between them: J. P. K.
/// Doye, M. A. Miller and D. J. Wales, J. Chem. Phys. 110, 6896 (1999).
const PUBLISHED: [f64; 3] = [-173.928427, -173.252378, -169.709];

fn main() -> Result<(), Box<dyn Error>> {
    let mut seeds: Vec<String> = std::env::args().skip(1).collect();
    if seeds.len() < 2 {
        return Err("which budget of time, and which seeds?".into());
    }
    let budget = seeds.remove(0);
    let mut text = format!(
        "# The double funnel of 38 Lennard-Jones atoms\n\nMade by `cargo run --release --example double_funnel -- {budget} {}`: each seed is one run of \
         `landscape surface lj 38 --seed SEED --budget {budget}`, from random starts and without any published number. The \
         lowest minimum is the truncated octahedron, and the bottom of the other funnel is icosahedral. Barriers are the heights \
         of the lowest way found, all over verified saddles, and so upper bounds. “Joined” are the minima from which a way to the octahedron is known. A run ends by its own rule, or when its time is over. Published: Doye, Miller and Wales, J. Chem. \
         Phys. 110, 6896 (1999).\n\n| run | octahedron | icosahedral | highest saddle between them | barrier from the octahedron | \
         barrier from the icosahedral minimum | minima | of these joined | saddles | million evaluations | seconds | threads |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
        seeds.join(" ")
    );
    let [octahedron, icosahedral, saddle] = PUBLISHED;
    writeln!(
        text,
        "| published | {octahedron:.6} | {icosahedral:.6} | {saddle:.3} | {:.2} | {:.2} | 6000 | | 8633 | | | |",
        saddle - octahedron,
        saddle - icosahedral
    )?;
    let mut first_height = None;
    for (number, seed) in seeds.iter().enumerate() {
        let folder = PathBuf::from(format!("target/double_funnel/lj-38-seed-{seed}.landscape"));
        if !folder.exists() {
            let output = folder.display().to_string();
            landscape(&[
                "surface",
                "lj",
                "38",
                "--seed",
                seed,
                "--budget",
                &budget,
                "--no-report",
                "-q",
                "-o",
                &output,
            ])?;
        }
        let files = LandscapeFiles::read(&folder)?;
        let tree = Tree::from_network(&files.network(&folder)?, Evidence::Chain);
        let minimum = |energy: f64| {
            let minima = files.minima.iter();
            minima
                .map(|minimum| minimum.energy)
                .position(|e| (e - energy).abs() < 1e-5)
        };
        let ends = [minimum(octahedron), minimum(icosahedral)].map(|end| end.map(MinimumId));
        let height = match ends {
            [Some(a), Some(b)] => tree.minimax(a, b),
            _ => None,
        };
        let others = (0..files.minima.len()).map(MinimumId);
        let joined = ends[0].map_or(0, |a| {
            others.filter(|b| tree.minimax(a, *b).is_some()).count()
        });
        let shown = |value: Option<f64>, digits: usize| {
            value.map_or("not found".to_owned(), |v| format!("{v:.digits$}"))
        };
        let energy = |end: Option<MinimumId>| shown(end.map(|end| files.minima[end.0].energy), 6);
        let timings: Value =
            serde_json::from_str(&fs::read_to_string(folder.join("timings.json"))?)?;
        let seconds = timings["phases"].as_array().into_iter().flatten();
        let seconds: f64 = seconds.filter_map(|phase| phase["seconds"].as_f64()).sum();
        writeln!(
            text,
            "| seed {seed} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1} | {seconds:.0} | {} |",
            energy(ends[0]),
            energy(ends[1]),
            shown(height, 3),
            shown(height.map(|height| height - octahedron), 2),
            shown(height.map(|height| height - icosahedral), 2),
            files.minima.len(),
            joined,
            files.manifest.findings["saddles"],
            files.manifest.counts.evaluations as f64 / 1e6,
            timings["threads"],
        )?;
        if number == 0 {
            first_height = height;
            fs::copy(
                folder.join("disconnectivity.png"),
                "figures/double_funnel.png",
            )?;
        }
    }
    text.push_str("\n![Disconnectivity graph of the lowest minima](double_funnel.png)\n\nThe 150 lowest minima of the first run.\n");
    text += &thermodynamics(&seeds[0], first_height)?;
    fs::write("figures/double_funnel.md", text)?;
    Ok(())
}

/// Heat capacity and occupation of the funnels of one run.
fn thermodynamics(seed: &str, height: Option<f64>) -> Result<String, Box<dyn Error>> {
    let folder = format!("target/double_funnel/lj-38-seed-{seed}.landscape");
    let output = format!("target/double_funnel/lj-38-seed-{seed}.thermodynamics");
    // Just below the way between the two funnels, where they are apart.
    let level = format!(
        "--level={}",
        height.ok_or("the funnels are not joined")? - 1e-6
    );
    landscape(&[
        "thermodynamics",
        &folder,
        "-q",
        "-o",
        &output,
        "--temperatures",
        "0.03:0.25x221",
        &level,
    ])?;
    let picture = "figures/double_funnel_thermodynamics.png";
    fs::copy(format!("{output}/thermodynamics.png"), picture)?;
    let found: Value = serde_json::from_str(&fs::read_to_string(format!(
        "{output}/thermodynamics.json"
    ))?)?;
    let peaks = found["peaks_of_heat_capacity"].as_array();
    let peaks = peaks.into_iter().flatten().map(|peak| {
        let [temperature, height] = [0, 1].map(|k| peak[k].as_f64().unwrap_or(f64::NAN));
        format!("{height:.0} k at kT = {temperature:.3}")
    });
    Ok(format!(
        "\n## Thermodynamics\n\nHarmonic superposition of the minima of the first run (`landscape thermodynamics`). The heat \
         capacity has peaks of {}. Published: the transition from the octahedral to the icosahedral funnel is near 0.12, and \
         melting is near 0.18 (J. P. K. Doye, D. J. Wales and M. A. Miller, J. Chem. Phys. 109, 8143 (1998)). The sample lacks \
         most of the liquid minima, so the height of the second peak is that of the sample.\n\n\
         ![Heat capacity, occupation of the funnels, superbasins](double_funnel_thermodynamics.png)\n",
        peaks.collect::<Vec<_>>().join(" and ")
    ))
}
