//! Which friction the energy should have, and how much a hand may give → `figures/holding_chosen.md`
//!
//! `cargo run --release --example holding_chosen -- FOLDER` makes 24 chains of the human hand on each of the objects in
//! `analysis/holding/objects`, for two frictions, without bounds of the compliance, so that
//! grasps of all compliances are kept. Both simulations judge all of them. The objects were made for this choice:
//! none of them comes with the program. Everything that is in FOLDER already is
//! kept, so that an interrupted run goes on. It takes ten minutes on two cores.

mod outcome;

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use outcome::{Failure, Row, outcome, percent, text};

const SEED: &str = "301";
const CHAINS: &str = "24";
/// Friction, and torque of the loads relative to their force at the object's radius.
const TRIED: [[f64; 2]; 2] = [[0.25, 0.1], [0.18, 0.1]];
/// Greatest compliance under a force, and under torques in the mean.
const BOUNDS: [[f64; 2]; 8] = [
    [0.2, 0.4],
    [0.25, 0.4],
    [0.3, 0.3],
    [0.3, 0.4],
    [0.3, 0.5],
    [0.3, 1.0],
    [0.4, 0.4],
    [1.0, 1.0],
];

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("name the folder for the grasps")?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut objects: Vec<PathBuf> = fs::read_dir(root.join("analysis/holding/objects"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    objects.sort();
    let mut table = format!(
        "# Friction, torque and compliance\n\nHow many grasps hold, by the friction and the torque of the loads of the energy, and \
         by the two compliances that the strict filter allows. {CHAINS} chains of the human hand with seed {SEED} on each of {} objects \
         that were made for this choice (`analysis/holding/objects`), by `cargo run --release --example holding_chosen`. Both \
         simulations have friction 0.25.\n\n\
         | friction | torque | force at most | torque at most | grasps | hold in the drop test, % | hold when pushed, % | not power, % | \
         precision, % | of no type, % |\n|---|---|---|---|---|---|---|---|---|---|\n",
        objects.len()
    );
    for [friction, torque] in TRIED {
        let tried = folder.join(format!("{friction}_{torque}"));
        fs::create_dir_all(&tried)?;
        let settings = tried.join("settings.toml");
        let given = format!(
            "[energy.layer]\nfriction = {friction}\ntorque_share = {torque}\nmost_force_compliance = 1.0\nmost_torque_compliance = 1.0\n"
        );
        fs::write(&settings, given)?;
        let mut rows: Vec<Row> = Vec::new();
        for object in &objects {
            let name = object.file_stem().unwrap_or_default().to_string_lossy();
            let words = [
                "--object",
                text(object)?,
                "-n",
                CHAINS,
                "--seed",
                SEED,
                "--config",
                text(&settings)?,
            ];
            let found = outcome(&tried, &name, &words)?;
            let held = found
                .rows
                .iter()
                .filter(|row| row.holds && row.withstands)
                .count();
            println!(
                "{friction} {torque} {name}: {} of {} kept in {:.0} s, {held} hold",
                found.rows.len(),
                found.chains,
                found.seconds
            );
            rows.extend(found.rows);
        }
        for [force, turn] in BOUNDS {
            let holds = |row: &&Row| row.gives.force <= force && row.gives.torque <= turn;
            let rows: Vec<&Row> = rows.iter().filter(holds).collect();
            let share = |test: fn(&Row) -> bool| {
                percent(rows.iter().filter(|row| test(row)).count(), rows.len())
            };
            writeln!(
                table,
                "| {friction} | {torque} | {force} | {turn} | {} | {} | {} | {} | {} | {} |",
                rows.len(),
                share(|row| row.holds),
                share(|row| row.withstands),
                share(|row| row.category != "power"),
                share(|row| row.category == "precision"),
                share(|row| row.label == "unlisted"),
            )?;
        }
    }
    fs::write(root.join("figures/holding_chosen.md"), table)?;
    Ok(())
}
