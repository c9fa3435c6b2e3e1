//! Dependence of the map of the committed grasps on our choices → `figures/sensitivity.md`
//!
//! `cargo run --release --example sensitivity [GRASPS]` maps GRASPS grasps (40), taken in turn from each category and from
//! those without one. They are mapped again with each weight of the energy, its friction and the distance of its patches
//! halved and raised by half. Two searches look for a lower way across each merge. Numbers that change little depend little on
//! the choice. Finished maps are kept below `target/sensitivity`.

mod command;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use command::landscape;
use landscape::store::{GraspFile, Overrides};
use serde_json::Value;

const GRASPS: &str = "data/grasps.parquet";
const FOLDER: &str = "target/sensitivity";
/// Settings of the maps: searches across each merge.
const MAP: &str = "[map]\nsearches = 2\n";
/// Settings of the energy.
const SETTINGS: [&str; 7] = [
    "layer.compliance_weight",
    "layer.reach_weight",
    "layer.pressing_weight_per_m",
    "self_penetration_weight",
    "prior_weight",
    "layer.friction",
    "layer.patch_spacing_m",
];
const FACTORS: [f64; 2] = [0.5, 1.5];

/// A changed choice.
enum Change {
    None,
    Setting(&'static str, f64),
}

impl Change {
    fn name(&self) -> String {
        match self {
            Self::None => "as it is".to_owned(),
            Self::Setting(name, factor) => format!("{name} × {factor}"),
        }
    }

    /// Writes the chosen grasps with this change into a file.
    fn write(&self, mut file: GraspFile, path: &Path) -> Result<(), Box<dyn Error>> {
        if let Self::Setting(name, factor) = self {
            let mut settings = serde_json::to_value(file.metadata.energy_settings()?)?;
            let place = format!("/{}", name.replace('.', "/"));
            let value = settings.pointer_mut(&place).ok_or("no such setting")?;
            *value = (value.as_f64().ok_or("a setting that is no number")? * factor).into();
            file.metadata.energy = settings;
        }
        file.write(path)?;
        Ok(())
    }
}

/// The first `count` grasps, taken in turn from each category and from those without one, so that every category occurs.
fn chosen(count: usize) -> Result<GraspFile, Box<dyn Error>> {
    let labelled = format!("{FOLDER}/labelled.parquet");
    landscape(&["label", GRASPS, "-q", "-o", &labelled])?;
    let (mut file, _) = GraspFile::read(labelled.as_ref(), Overrides::default())?;
    let mut met: BTreeMap<Option<String>, usize> = BTreeMap::new();
    let mut turns = Vec::new();
    for grasp in std::mem::take(&mut file.grasps) {
        let turn = met.entry(grasp.label_category.clone()).or_default();
        *turn += 1;
        turns.push((*turn, grasp));
    }
    turns.sort_by_key(|(turn, _)| *turn);
    file.grasps = turns
        .into_iter()
        .map(|(_, grasp)| grasp)
        .take(count)
        .collect();
    file.grasps.sort_by_key(|grasp| grasp.id);
    Ok(file)
}

fn main() -> Result<(), Box<dyn Error>> {
    let count: usize = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 40,
    };
    fs::create_dir_all(FOLDER)?;
    fs::write(format!("{FOLDER}/map.toml"), MAP)?;
    let grasps = chosen(count)?;
    let settings = SETTINGS
        .iter()
        .flat_map(|name| FACTORS.map(|factor| Change::Setting(name, factor)));
    let changes: Vec<Change> = std::iter::once(Change::None).chain(settings).collect();
    let mut text = format!(
        "# What the map depends on\n\n`cargo run --release --example sensitivity {count}`: {count} grasps of {GRASPS}, taken in turn \
         from each category and those of none, mapped anew under each change, with two searches for lower ways across \
         each merge. Depth: height of a merge above the shallower side's lowest minimum.\n\n\
         | change | grasps | minima | families | median merge depth |\n|---|---|---|---|---|\n"
    );
    for (number, change) in changes.iter().enumerate() {
        text += &row(change, &grasps, &format!("{FOLDER}/{count}_{number}"))?;
        fs::write("figures/sensitivity.md", &text)?;
    }
    print!("{text}");
    Ok(())
}

/// The row of a map, which is made unless it is there.
fn row(change: &Change, chosen: &GraspFile, stem: &str) -> Result<String, Box<dyn Error>> {
    let [grasps, map] = ["parquet", "landscape"].map(|ending| format!("{stem}.{ending}"));
    if !Path::new(&map).exists() {
        change.write(chosen.clone(), grasps.as_ref())?;
        let config = format!("{FOLDER}/map.toml");
        landscape(&[
            "build", &grasps, "--config", &config, "-q", "--fresh", "-o", &map,
        ])?;
    }
    let manifest: Value = serde_json::from_slice(&fs::read(format!("{map}/landscape.json"))?)?;
    let count = |name: &str| &manifest["counts"][name];
    let depth = manifest["findings"]["median_merge_depth"].as_f64();
    Ok(format!(
        "| {} | {} | {} | {} | {} |\n",
        change.name(),
        count("grasps"),
        count("minima"),
        count("families"),
        depth.map_or("–".to_owned(), |depth| format!("{depth:.3}")),
    ))
}
