//! How often does a grasp fall into a minimum that is known already? → `figures/coverage.md`
//!
//! The arguments are files of `landscape synth`, one hand and one object each. Every grasp descends as in
//! `landscape build`, and ends within 5 mm of each other are one minimum. The chance that one more grasp falls into a known
//! minimum is Good's and Turing's estimate: one minus the share of grasps that are alone in their minimum. Each descent goes
//! on to a gradient norm of 10⁻⁵ to see whether it converges. The files of the committed table were made by
//! `landscape synth --hand human --object OBJECT -n 400 --seed 20261126`.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::optimize::StopReason;
use landscape::store::{GraspFile, Overrides};
use landscape::study::settings_for_grasps;
use landscape::topography::{Rarefaction, Run, distinct, quench_all};

const GRADIENT: f64 = 1e-5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# Coverage\n\nGrasps of the default energy, one row for each file of `landscape synth`, made by \
         `cargo run --release --example coverage OBJECT.parquet ...`. All grasps descend; ends within 5 mm of each other are \
         one minimum. Coverage is the chance that one more grasp falls into a known minimum (Good and Turing). The last \
         column is the share of descents that reach a gradient norm of 10⁻⁵ (the cost of letting go is 1, lengths are \
         metres).\n\n\
         | object | grasps | minima | alone | coverage | converged |\n|---|---|---|---|---|---|\n",
    );
    for path in std::env::args().skip(1) {
        let path = Path::new(&path);
        let (file, _) = GraspFile::read(path, Overrides::default())?;
        let population = file.landscapes().into_iter().next();
        let population = population.ok_or("the file is empty")?;
        let energy = population.energy()?;
        let settings = settings_for_grasps(&energy);
        let grasps = population.grasps.iter();
        let starts: Vec<Vec<f64>> = grasps.map(|row| row.grasp.pose.to_vec()).collect();
        let ends = quench_all(&energy, &starts, &settings.quench, &Run::default())?;
        let (minima, _) = distinct(&energy, &ends, &settings.sameness, f64::INFINITY);
        let sizes: Vec<usize> = minima.iter().map(|m| m.members.len()).collect();
        let found = Rarefaction::new(&sizes, 2)
            .estimate
            .ok_or("at least thirty grasps are needed")?;
        let exact = settings.quench.clone().with_gradient_tolerance(GRADIENT);
        let starts: Vec<Vec<f64>> = ends.into_iter().map(|end| end.x).collect();
        let ends = quench_all(&energy, &starts, &exact, &Run::default())?;
        let reached = ends.iter().filter(|end| end.stop == StopReason::Converged);
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} |",
            starts.len(),
            minima.len(),
            sizes.iter().filter(|size| **size == 1).count(),
            percent(found.coverage),
            percent(reached.count() as f64 / starts.len() as f64)
        )?;
        print!("{}", text.lines().last().unwrap_or_default());
        println!();
    }
    fs::write("figures/coverage.md", text)?;
    Ok(())
}
