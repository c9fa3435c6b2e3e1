//! Grasps of a thousand objects that nobody here chose → `figures/thousand_objects.md`, `figures/thousand_objects.{svg,png}`
//!
//! `cargo run --release --example thousand_objects -- OBJECTS FOLDER [COUNT]` makes twelve chains of the human hand on each of
//! the random objects in OBJECTS, labels what passes the strict filter, and judges it with both simulations. OBJECTS is the
//! folder `random_urdfs` of `pybullet_data`, which the Python package `pybullet` installs: it holds 1,000 objects, each
//! in a folder of its number with an OBJ file and a URDF file that tells its scale. COUNT takes evenly spaced ones only.
//! Everything that is in FOLDER already is kept, so that an interrupted run goes on.

mod outcome;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use landscape::agreement::wilson;
use landscape::figure::chart::{Axis, Chart, Panel, Series};
use outcome::{Failure, Outcome, outcome, percent, text};

const SEED: &str = "57";
const CHAINS: &str = "12";
const WORST: usize = 20;

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let objects = arguments.next().ok_or("name the folder random_urdfs")?;
    let folder = arguments.next().ok_or("name the folder for the grasps")?;
    let mut paths: Vec<PathBuf> = fs::read_dir(&objects)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    paths.sort();
    if let Some(count) = arguments.next() {
        let count: usize = text(&count)?.parse()?;
        let step = paths.len().div_ceil(count.max(1));
        paths = paths.into_iter().step_by(step).collect();
    }
    let mut found: Vec<(String, Outcome)> = Vec::new();
    for path in &paths {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let scale = scale(&path.join(format!("{name}.urdf")))?;
        let mesh = path.join(format!("{name}.obj"));
        let words = [
            "--object",
            text(&mesh)?,
            "--scale",
            &scale,
            "-n",
            CHAINS,
            "--seed",
            SEED,
        ];
        let outcome = outcome(&folder, &name, &words)?;
        let held = outcome.rows.iter().filter(|row| row.holds).count();
        println!(
            "{name}: {} of {CHAINS} kept, {held} hold",
            outcome.rows.len()
        );
        found.push((name, outcome));
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("figures");
    fs::write(root.join("thousand_objects.md"), report(&found)?)?;
    let picture = chart(&found).draw()?;
    for end in ["svg", "png"] {
        picture.save(&root.join(format!("thousand_objects.{end}")))?;
    }
    Ok(())
}

/// The scale of the mesh in a description of one object, which is the same along each axis.
fn scale(path: &Path) -> Result<String, Failure> {
    let description = fs::read_to_string(path)?;
    let scale = description.split("scale=\"").nth(1);
    let scale = scale.and_then(|text| text.split(['"', ' ']).next());
    Ok(scale
        .ok_or_else(|| format!("{}: no scale", path.display()))?
        .to_owned())
}

fn report(found: &[(String, Outcome)]) -> Result<String, Failure> {
    let chains: u64 = found.iter().map(|(_, one)| one.chains).sum();
    let rows = || found.iter().flat_map(|(_, one)| &one.rows);
    let kept = rows().count();
    let seconds: f64 = found.iter().map(|(_, one)| one.seconds).sum();
    let told = |test: fn(&outcome::Row) -> bool| {
        let count = rows().filter(|row| test(row)).count();
        let [low, high] = wilson(count as f64, kept.max(1) as f64);
        format!(
            "{} % [{:.1}, {:.1}]",
            percent(count, kept),
            100.0 * low,
            100.0 * high
        )
    };
    let mut forces: Vec<f64> = rows().map(|row| row.gives.force).collect();
    forces.sort_by(f64::total_cmp);
    let chains_told = usize::try_from(chains)?;
    let [low, high] = wilson(kept as f64, chains as f64);
    let mut text = format!(
        "# Objects that nobody here chose\n\n{CHAINS} chains of the human hand with seed {SEED} on each of {} random objects of \
         `pybullet_data`, by `cargo run --release --example thousand_objects`. Intervals are Wilson's, 95 %, over grasps.\n\n\
         | | |\n|---|---|\n\
         | chains that give a grasp | {kept} of {chains}: {} % [{:.1}, {:.1}] |\n\
         | grasps that hold in the drop test | {} |\n\
         | grasps that hold when pushed in six directions | {} |\n\
         | power | {} |\n| precision | {} |\n| intermediate | {} |\n| of no type | {} |\n\
         | compliance under the worst force, median | {:.3} |\n\
         | seconds for an object, mean | {:.2} |\n\n\
         ![Distributions](thousand_objects.png)\n\n## The worst\n\n\
         | object | kept | hold | hold when pushed |\n|---|---|---|---|\n",
        found.len(),
        percent(kept, chains_told),
        100.0 * low,
        100.0 * high,
        told(|row| row.holds),
        told(|row| row.withstands),
        told(|row| row.category == "power"),
        told(|row| row.category == "precision"),
        told(|row| row.category == "intermediate"),
        told(|row| row.label == "unlisted"),
        forces.get(kept / 2).copied().unwrap_or(f64::NAN),
        seconds / found.len().max(1) as f64,
    );
    let holding = |one: &Outcome| one.rows.iter().filter(|row| row.holds).count();
    let mut worst: Vec<&(String, Outcome)> = found.iter().collect();
    worst.sort_by_key(|(name, one)| (holding(one), name.clone()));
    for (name, one) in worst.into_iter().take(WORST) {
        let pushed = one.rows.iter().filter(|row| row.withstands).count();
        writeln!(
            text,
            "| {name} | {} | {} | {pushed} |",
            one.rows.len(),
            holding(one)
        )?;
    }
    Ok(text)
}

/// How many objects have each share of chains that give a grasp, and of grasps that hold and that are precision grasps.
fn chart(found: &[(String, Outcome)]) -> Chart {
    let panel = |title: &str, share: &dyn Fn(&Outcome) -> Option<f64>| {
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for value in found.iter().filter_map(|(_, one)| share(one)) {
            *counts.entry(bin(value)).or_default() += 1;
        }
        let total: usize = counts.values().sum();
        // The share of objects with at most this value.
        let mut below = 0;
        let mut steps = vec![[0.0, 0.0]];
        for (bin, count) in counts {
            let before = 100.0 * below as f64 / total.max(1) as f64;
            below += count;
            let at = f64::from(bin);
            steps.push([at, before]);
            steps.push([at, 100.0 * below as f64 / total.max(1) as f64]);
        }
        Panel::new(
            title,
            Axis::linear("% of an object's chains or grasps").with_range(0.0, 100.0),
            Axis::linear("% of objects with at most this").with_range(0.0, 100.0),
            vec![Series::line(steps)],
        )
    };
    let of_rows = |test: fn(&outcome::Row) -> bool| {
        move |one: &Outcome| {
            let count = one.rows.iter().filter(|row| test(row)).count();
            (!one.rows.is_empty()).then(|| count as f64 / one.rows.len() as f64)
        }
    };
    let mut chart = Chart::new(
        "",
        vec![
            panel("chains that give a grasp", &|one| {
                Some(one.rows.len() as f64 / one.chains as f64)
            }),
            panel(
                "grasps that hold in the drop test",
                &of_rows(|row| row.holds),
            ),
            panel(
                "grasps that hold when pushed",
                &of_rows(|row| row.withstands),
            ),
            panel(
                "precision grasps",
                &of_rows(|row| row.category == "precision"),
            ),
        ],
    );
    chart.columns = 2;
    chart
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share from 0 to 1"
)]
fn bin(share: f64) -> u32 {
    (100.0 * share).round() as u32
}
