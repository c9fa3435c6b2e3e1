//! How often does a grasp fall into a minimum that is known already? → `figures/coverage.md`
//!
//! The arguments are files of `landscape synth`, one hand and one object each. Every grasp descends as in
//! `landscape build`, and ends within 5 mm of each other are one minimum. The chance that one more grasp falls into a known
//! minimum is Good's and Turing's estimate: one minus the share of grasps that are alone in their minimum. Each descent goes
//! on to a gradient norm of 10⁻⁵ to see whether it converges. Distinct stable grasps are counted in files that
//! `landscape stability` has simulated. A second table counts the labels of all grasps. The files of the committed tables
//! were made by `landscape synth --object OBJECT -n 420 --seed 20261129`, `landscape label` and `landscape stability`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::energy::Energy;
use landscape::evaluation::taxonomy::{Category, Rule, Taxonomy, UNLISTED};
use landscape::optimize::StopReason;
use landscape::space::Space;
use landscape::store::{GraspFile, Overrides};
use landscape::study::{label_all, settings_for_grasps};
use landscape::topography::{Rarefaction, Run, distinct, quench_all};

const GRADIENT: f64 = 1e-5;
/// Number of grasps from which a type counts as one that the population has.
const OFTEN: usize = 5;
/// Grasps that are nearer to each other are one, metres of the pose space.
const APART_M: f64 = 0.005;
const CATEGORIES: [Category; 3] = [Category::Power, Category::Precision, Category::Intermediate];

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::from(
        "# Coverage\n\nGrasps of the default energy, one row for each file of `landscape synth`, made by \
         `cargo run --release --example coverage OBJECT.parquet ...`. All grasps descend; ends within 5 mm of each other are \
         one minimum. Coverage is the chance that one more grasp falls into a known minimum (Good and Turing). Then follow the \
         share of descents that reach a gradient norm of 10⁻⁵ (the cost of letting go is 1, lengths are metres), how many \
         grasps hold in the drop test, how many of these are distinct (more than 5 mm from each other), the shares of power, \
         precision and intermediate grasps, and the share of grasps of no type.\n\n\
         | object | grasps | minima | alone | coverage | converged | hold | distinct and stable | power | precision | \
         intermediate | of no type |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut labels = Labels::default();
    for path in std::env::args().skip(1) {
        let path = Path::new(&path);
        let (file, _) = GraspFile::read(path, Overrides::default())?;
        let [power, precision, intermediate, unlisted] = labels.count(&file)?;
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
        let share = |count: usize| percent(count as f64 / starts.len() as f64);
        let simulated = population.grasps.iter().all(|row| row.stable.is_some());
        let held = simulated.then(|| {
            let held = population
                .grasps
                .iter()
                .filter(|row| row.stable == Some(true));
            held.map(|row| &row.grasp.pose[..]).collect::<Vec<_>>()
        });
        let distinct = held.as_ref().map(|held| apart(energy.space(), held));
        writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            starts.len(),
            minima.len(),
            sizes.iter().filter(|size| **size == 1).count(),
            percent(found.coverage),
            percent(reached.count() as f64 / starts.len() as f64),
            held.map_or("–".to_owned(), |held| held.len().to_string()),
            distinct.map_or("–".to_owned(), |count| count.to_string()),
            share(power),
            share(precision),
            share(intermediate),
            share(unlisted),
        )?;
        print!("{}", text.lines().last().unwrap_or_default());
        println!();
    }
    text += &labels.table()?;
    fs::write("figures/coverage.md", text)?;
    Ok(())
}

/// How many poses are left if each counts only where it is farther than [`APART_M`] from all that counted before.
fn apart(space: &dyn Space, poses: &[&[f64]]) -> usize {
    let mut counted: Vec<&[f64]> = Vec::new();
    for pose in poses {
        if counted
            .iter()
            .all(|other| space.distance(other, pose) > APART_M)
        {
            counted.push(pose);
        }
    }
    counted.len()
}

/// How often each label, and each cell of the taxonomy, was given, and in how many files.
#[derive(Default)]
struct Labels {
    grasps: usize,
    unlisted: usize,
    categories: [usize; 3],
    counts: BTreeMap<String, (usize, usize)>,
    cells: BTreeMap<&'static str, usize>,
}

impl Labels {
    /// Labels the grasps of a file by the built-in rule; returns how many are power, precision and intermediate grasps, and of
    /// no type.
    fn count(&mut self, file: &GraspFile) -> Result<[usize; 4], Box<dyn Error>> {
        let mut here: BTreeMap<String, usize> = BTreeMap::new();
        let (before, mut categories) = (self.unlisted, [0; 3]);
        for label in label_all(file, Rule::standard(), |_| true, &Run::default())?.values() {
            *here.entry(label.text().to_owned()).or_default() += 1;
            if let Some(cell) = label.listed_cell() {
                *self.cells.entry(cell).or_default() += 1;
            }
            if let Some(category) = label.category {
                let place = CATEGORIES.iter().position(|one| *one == category);
                categories[place.ok_or("a category is missing")?] += 1;
            }
            self.grasps += 1;
            self.unlisted += usize::from(label.text() == UNLISTED);
        }
        for (name, count) in here {
            let all = self.counts.entry(name).or_default();
            *all = (all.0 + count, all.1 + 1);
        }
        for (all, here) in self.categories.iter_mut().zip(categories) {
            *all += here;
        }
        let [power, precision, intermediate] = categories;
        Ok([power, precision, intermediate, self.unlisted - before])
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
        let share = |count: usize| 100.0 * count as f64 / self.grasps as f64;
        let mut text = format!(
            "\n## Grasp types\n\nLabels of all {} grasps by the built-in rule. {} of {} types occur, {} of them in at least {OFTEN} \
             grasps. {} of {} cells occur, {} of them in at least {OFTEN} grasps. {:.1} % are power, {:.1} % precision and {:.1} % \
             intermediate grasps. {:.1} % of the grasps are of no type; they have a nearest category, too. A grasp \
             whose best types are too close is labelled by their cell or category.\n\n| label | grasps | objects |\n|---|---|---|\n",
            self.grasps,
            counts.len(),
            taxonomy.types.len(),
            often(&counts),
            cells.len(),
            taxonomy.cells().len(),
            often(&cells),
            share(self.categories[0]),
            share(self.categories[1]),
            share(self.categories[2]),
            share(self.unlisted),
        );
        let mut rows: Vec<_> = self.counts.iter().collect();
        rows.sort_by(|(a, x), (b, y)| y.cmp(x).then(a.cmp(b)));
        for (name, (grasps, objects)) in rows {
            writeln!(text, "| {name} | {grasps} | {objects} |")?;
        }
        Ok(text)
    }
}
