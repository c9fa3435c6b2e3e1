//! How often does a grasp fall into a minimum that is known already? → `figures/coverage.md`
//!
//! The arguments are files of `landscape synth`, one hand and one object each. Every grasp descends as in
//! `landscape build`, and ends within 5 mm of each other are one minimum. The chance that one more grasp falls into a known
//! minimum is Good's and Turing's estimate: one minus the share of grasps that are alone in their minimum. Each descent goes
//! on to a gradient norm of 10⁻⁵ to see whether it converges. A second table counts the labels of all grasps. The files of
//! the committed tables were made by `landscape synth --object OBJECT -n 420 --seed 7`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::evaluation::taxonomy::{Rule, Taxonomy, UNLISTED};
use landscape::optimize::StopReason;
use landscape::store::{GraspFile, Overrides};
use landscape::study::{label_all, settings_for_grasps};
use landscape::topography::{Rarefaction, Run, distinct, quench_all};

const GRADIENT: f64 = 1e-5;
/// Number of grasps from which a type counts as one that the population has.
const OFTEN: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# Coverage\n\nGrasps of the default energy, one row for each file of `landscape synth`, made by \
         `cargo run --release --example coverage OBJECT.parquet ...`. All grasps descend; ends within 5 mm of each other are \
         one minimum. Coverage is the chance that one more grasp falls into a known minimum (Good and Turing). Then follow the \
         share of descents that reach a gradient norm of 10⁻⁵ (the cost of letting go is 1, lengths are metres), and the share \
         of grasps of no type.\n\n\
         | object | grasps | minima | alone | coverage | converged | of no type |\n|---|---|---|---|---|---|---|\n",
    );
    let mut labels = Labels::default();
    for path in std::env::args().skip(1) {
        let path = Path::new(&path);
        let (file, _) = GraspFile::read(path, Overrides::default())?;
        let unlisted = labels.count(&file)?;
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
            "| {name} | {} | {} | {} | {} | {} | {} |",
            starts.len(),
            minima.len(),
            sizes.iter().filter(|size| **size == 1).count(),
            percent(found.coverage),
            percent(reached.count() as f64 / starts.len() as f64),
            percent(unlisted as f64 / starts.len() as f64)
        )?;
        print!("{}", text.lines().last().unwrap_or_default());
        println!();
    }
    text += &labels.table()?;
    fs::write("figures/coverage.md", text)?;
    Ok(())
}

/// How often each label, and each cell of the taxonomy, was given, and in how many files.
#[derive(Default)]
struct Labels {
    grasps: usize,
    unlisted: usize,
    counts: BTreeMap<String, (usize, usize)>,
    cells: BTreeMap<&'static str, usize>,
}

impl Labels {
    /// Labels the grasps of a file by the built-in rule; returns how many are of no type.
    fn count(&mut self, file: &GraspFile) -> Result<usize, Box<dyn Error>> {
        let mut here: BTreeMap<String, usize> = BTreeMap::new();
        let before = self.unlisted;
        for label in label_all(file, Rule::standard(), |_| true, &Run::default())?.values() {
            *here.entry(label.text().to_owned()).or_default() += 1;
            if let Some(cell) = label.listed_cell() {
                *self.cells.entry(cell).or_default() += 1;
            }
            self.grasps += 1;
            self.unlisted += usize::from(label.text() == UNLISTED);
        }
        for (name, count) in here {
            let all = self.counts.entry(name).or_default();
            *all = (all.0 + count, all.1 + 1);
        }
        Ok(self.unlisted - before)
    }

    fn table(&self) -> Result<String, Box<dyn Error>> {
        let taxonomy = Taxonomy::feix();
        let types = taxonomy
            .types
            .iter()
            .filter_map(|entry| self.counts.get(&entry.name));
        let counts: Vec<usize> = types.map(|(grasps, _)| *grasps).collect();
        let often = |counts: &[usize]| counts.iter().filter(|count| **count >= OFTEN).count();
        let cells: Vec<usize> = self.cells.values().copied().collect();
        let mut text = format!(
            "\n## Grasp types\n\nLabels of all {} grasps by the built-in rule. {} of {} types occur, {} of them in at least {OFTEN} \
             grasps. {} of {} cells occur, {} of them in at least {OFTEN} grasps. {:.1} % of the grasps are of no type. A grasp \
             whose best types are too close is labelled by their cell or category.\n\n| label | grasps | objects |\n|---|---|---|\n",
            self.grasps,
            counts.len(),
            taxonomy.types.len(),
            often(&counts),
            cells.len(),
            taxonomy.cells().len(),
            often(&cells),
            100.0 * self.unlisted as f64 / self.grasps as f64,
        );
        let mut rows: Vec<_> = self.counts.iter().collect();
        rows.sort_by(|(a, x), (b, y)| y.cmp(x).then(a.cmp(b)));
        for (name, (grasps, objects)) in rows {
            writeln!(text, "| {name} | {grasps} | {objects} |")?;
        }
        Ok(text)
    }
}
