//! `landscape surface`: every minimum and saddle of a model, or of an energy that another program computes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use clap::ValueEnum;
use rand::RngExt;
use serde_json::json;

use super::args::{Common, Coordinates, Surface};
use super::landscape::{Input, Mapped, Merge, Titles};
use super::run::{DiskJournal, Unfinished, Watch, check_resumable, tally, until_unwritable};
use super::{check_output, complain, print};
use crate::energy::{Counted, Energy, External, model};
use crate::sample::{Task, stream};
use crate::space::{Cluster, Euclidean, Rotation, Space, Torus};
use crate::store::{Counts, LandscapeFiles, Manifest, Source, StationaryRow, content_hash};
use crate::topography::exchange::Database;
use crate::topography::{
    self, Exploration, GroupSettings, PathMethod, SearchSettings, explore, in_box,
};

/// Length over which energies are differenced, as a share of the shortest side of the region.
const DIFFERENCE: f64 = 1e-5;
/// Random points at which the gradient of a program is checked.
const CHECKED: u64 = 8;
/// Rows of a table of the summary.
const SHOWN: usize = 20;

/// What is to be mapped.
struct Subject<'a> {
    name: &'a str,
    energy: &'a dyn Energy,
    /// What its coordinates are, as `--coordinates` names it.
    coordinates: String,
    /// Where random starts are drawn.
    low: Vec<f64>,
    high: Vec<f64>,
    /// What made the energy: the model, or the program and the files its command names.
    source: Source,
    /// The words that ask for it.
    words: String,
    /// What went wrong with the energy, if anything did.
    check: &'a (dyn Fn() -> anyhow::Result<()> + Sync),
}

pub(super) fn run(command: &Surface, common: &Common) -> anyhow::Result<()> {
    for (flag, value) in [
        ("patience", command.patience),
        ("searches", command.searches),
    ] {
        ensure!(value != Some(0), "--{flag} 0: at least 1 is needed");
    }
    if let Some(output) = &command.output {
        check_output(output)?;
    }
    let region = command.region.as_deref().map(region).transpose()?;
    match &command.command {
        None => run_model(command, common, region),
        Some(program) => {
            let region = region.context("--command needs --region")?;
            run_program(command, common, program, region)
        }
    }
}

/// The least and the greatest value of each coordinate.
type Region = (Vec<f64>, Vec<f64>);

fn run_model(command: &Surface, common: &Common, region: Option<Region>) -> anyhow::Result<()> {
    let surface = model::named(&command.model)?;
    let needed = surface.low.len();
    let (low, high) = region.unwrap_or((surface.low, surface.high));
    ensure!(
        low.len() == needed,
        "--region: `{}` has {needed} coordinates, not {}",
        surface.name,
        low.len()
    );
    let subject = Subject {
        name: &surface.name,
        energy: &*surface.energy,
        coordinates: surface.coordinates.to_owned(),
        low,
        high,
        source: Source {
            name: surface.name.clone(),
            content_hash: content_hash(&[surface.name.as_bytes()]),
        },
        words: surface.name.clone(),
        check: &|| Ok(()),
    };
    until_unwritable(|| map(command, common, &subject))?
}

fn run_program(
    command: &Surface,
    common: &Common,
    program: &str,
    (low, high): Region,
) -> anyhow::Result<()> {
    let sides = low.iter().zip(&high).map(|(low, high)| high - low);
    let side = sides.fold(f64::INFINITY, f64::min);
    let space = space(command.coordinates, low.len())?;
    let external = External::start(program, space, DIFFERENCE * side)?;
    check_gradient(&external, (&low, &high), command.seed, DIFFERENCE * side)?;
    let coordinates = command.coordinates.to_possible_value();
    let coordinates = coordinates.map_or_else(String::new, |value| value.get_name().to_owned());
    let subject = Subject {
        name: program,
        energy: &external,
        coordinates: coordinates.clone(),
        low,
        high,
        source: Source {
            name: program.to_owned(),
            content_hash: command_hash(program),
        },
        words: format!("--command '{program}' --coordinates {coordinates}"),
        check: &|| Ok(external.check()?),
    };
    until_unwritable(|| map(command, common, &subject))?
}

/// Searches the surface and writes its folder.
fn map(command: &Surface, common: &Common, subject: &Subject<'_>) -> anyhow::Result<()> {
    let draw = in_box(&subject.low, &subject.high);
    let measuring = Counted::new(subject.energy);
    let mut settings = SearchSettings::measured(&measuring, &draw, command.seed);
    (subject.check)()?;
    settings.patience = command.patience.unwrap_or(settings.patience);
    settings.max_searches = command.searches.unwrap_or(settings.max_searches);
    settings.paths = command.paths.into();

    let output = match &command.output {
        Some(output) => output.clone(),
        None => PathBuf::from(format!("{}.landscape", file_name(subject.name))),
    };
    let fingerprint = content_hash(&[
        subject.source.content_hash.as_bytes(),
        subject.words.as_bytes(),
        format!("{:?}", (&subject.low, &subject.high)).as_bytes(),
        serde_json::to_string(&settings)?.as_bytes(),
        env!("CARGO_PKG_VERSION").as_bytes(),
    ]);
    check_resumable(&command.again, std::slice::from_ref(&output))?;
    let unfinished = Unfinished::open(&output, &fingerprint, &command.again, common.quiet)?;
    let folder = &unfinished.folder;
    let journal = Guarded {
        journal: DiskJournal(&unfinished.journal),
        check: subject.check,
    };
    let mut watch = Watch::new(common.quiet);
    let found = explore(subject.energy, &draw, &settings, &journal, &|p| {
        watch.see(p);
    });
    watch.lap("search", found.evaluations);
    (subject.check)()?;
    if found.minima.is_empty() {
        unfinished.discard()?;
        bail!(
            "{}: {} searches from random points of the region found no minimum ({})",
            subject.name,
            found.coverage.searches,
            spell(&fates(&found))
        );
    }
    let landscape = found.landscape(subject.energy, &GroupSettings::default());
    let report = Report {
        mapped: Mapped {
            landscape: &landscape,
            energy: subject.energy,
            inputs: (0..found.coverage.searches as u64)
                .map(|id| Input { id, label: None })
                .collect(),
            choices_below: f64::INFINITY,
        },
        found: &found,
        subject,
        settings: &settings,
        command: command_line(subject, &settings),
        measuring: measuring.evaluations(),
    };
    let files = report.tables()?;
    files.write(folder)?;
    StationaryRow::write(&report.stationary(), folder)?;
    let database = Database::from_exploration(&found, subject.coordinates == "atoms");
    report.mapped.draw(&report.titles(), &database, folder)?;
    let text = report.summary();
    folder.write("summary.md", text.as_bytes())?;
    watch.lap("write", 0);
    watch.timings().write(folder)?;
    let finished = unfinished.finish()?;
    if !common.quiet {
        print(&text);
        complain(&format!("wrote {}", finished.display()));
    }
    Ok(())
}

/// A journal that takes nothing more once the energy failed: what was found since is worth nothing.
struct Guarded<'a> {
    journal: DiskJournal<'a>,
    check: &'a (dyn Fn() -> anyhow::Result<()> + Sync),
}

impl topography::Journal for Guarded<'_> {
    fn get(&self, key: &str) -> Option<Vec<u8>> {
        self.journal.get(key)
    }

    fn put(&self, key: &str, record: &[u8]) {
        if (self.check)().is_ok() {
            self.journal.put(key, record);
        }
    }
}

/// What was found and everything that describes it.
struct Report<'a> {
    mapped: Mapped<'a>,
    found: &'a Exploration,
    subject: &'a Subject<'a>,
    settings: &'a SearchSettings,
    command: String,
    measuring: u64,
}

impl Report<'_> {
    fn titles(&self) -> Titles<'static> {
        Titles {
            title: format!(
                "{}: {} minima, {} saddles",
                self.subject.name,
                self.found.minima.len(),
                self.found.saddles.len()
            ),
            energy: "energy",
            members: "random starts",
            seed: self.settings.seed,
        }
    }

    fn tables(&self) -> anyhow::Result<LandscapeFiles> {
        let landscape = self.mapped.landscape;
        let edges = self.mapped.edges();
        let merges = self.mapped.merges();
        let mut findings: BTreeMap<_, _> = self.mapped.findings(&merges)?.into_iter().collect();
        findings.insert("saddles".to_owned(), json!(self.found.saddles.len()));
        findings.insert(
            "coverage".to_owned(),
            serde_json::to_value(self.found.coverage)?,
        );
        findings.insert("ends_of_searches".to_owned(), json!(fates(self.found)));
        findings.insert(
            "refused".to_owned(),
            serde_json::to_value(&self.found.refused)?,
        );
        let manifest = Manifest {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.clone(),
            seed: self.settings.seed,
            source: self.subject.source.clone(),
            hand: None,
            object: None,
            scale: 1.0,
            energy: json!({
                "surface": self.subject.words,
                "coordinates": self.subject.coordinates,
                "low": self.subject.low,
                "high": self.subject.high,
            }),
            settings: serde_json::to_value(self.settings)?,
            terms: self.terms(),
            group_barrier: Some(landscape.groups.barrier),
            counts: Counts {
                grasps: 0,
                minima: self.found.minima.len() as u64,
                groups: landscape.groups.members.len() as u64,
                pairs: edges.len() as u64,
                components: landscape.tree.roots.len() as u64,
                evaluations: self.found.evaluations as u64 + self.measuring,
            },
            evidence: (landscape.tally().into_iter())
                .map(|(evidence, count)| (evidence.name().to_owned(), count as u64))
                .collect(),
            findings,
            warnings: self.warnings(),
        };
        Ok(LandscapeFiles {
            manifest,
            minima: self.mapped.minima(),
            edges,
            paths: self.mapped.paths(),
        })
    }

    fn terms(&self) -> Vec<String> {
        let terms = self.subject.energy.terms(&self.found.minima[0].coordinates);
        terms.into_iter().map(|(name, _)| name).collect()
    }

    /// Minima, then saddles, by rising energy.
    fn stationary(&self) -> Vec<StationaryRow> {
        let minima = self.found.minima.iter().zip(&self.found.audits).enumerate();
        let minima = minima.map(|(id, (minimum, audit))| StationaryRow {
            index: 0,
            id: id as u64,
            ends: [id as u64; 2],
            energy: minimum.energy,
            coordinates: minimum.coordinates.clone(),
            gradient_norm: audit.gradient_norm,
            curvatures: audit.curvatures.clone(),
            searches: minimum.members.len() as u64,
            verdict: audit.verdict.name().to_owned(),
        });
        let saddles = self.found.saddles.iter().enumerate();
        let saddles = saddles.map(|(id, saddle)| StationaryRow {
            index: 1,
            id: id as u64,
            ends: saddle.ends.map(|end| end.0 as u64),
            energy: saddle.energy,
            coordinates: saddle.coordinates.clone(),
            gradient_norm: saddle.audit.gradient_norm,
            curvatures: saddle.audit.curvatures.clone(),
            searches: saddle.hits as u64,
            verdict: saddle.audit.verdict.name().to_owned(),
        });
        minima.chain(saddles).collect()
    }

    fn warnings(&self) -> Vec<String> {
        let (coverage, components) = (&self.found.coverage, self.mapped.landscape.tree.roots.len());
        let mut warnings = Vec::new();
        if coverage.searches >= self.settings.max_searches {
            warnings.push(format!(
                "the search was stopped after {} searches, before it ended by itself",
                coverage.searches
            ));
        }
        if coverage.once > 0 {
            warnings.push(format!(
                "{} of {} saddles were met by one search only: more may be missing (--patience looks longer)",
                coverage.once,
                self.found.saddles.len()
            ));
        }
        if components > 1 {
            warnings.push(format!(
                "no saddle was found between {components} groups of minima"
            ));
        }
        warnings
    }

    fn summary(&self) -> String {
        let (found, coverage) = (self.found, &self.found.coverage);
        let loops = found
            .saddles
            .iter()
            .filter(|saddle| saddle.ends[0] == saddle.ends[1]);
        let mut lines = vec![
            format!("# {}\n", self.subject.name),
            format!(
                "- **{} minima** and **{} saddles**, {} of which join two copies of one minimum; {} component(s)",
                found.minima.len(),
                found.saddles.len(),
                loops.count(),
                self.mapped.landscape.tree.roots.len()
            ),
            format!(
                "- every one passed its audit: gradient below {:.1e}, index of the Hessian, descents on both sides of \
                 saddles, no duplicates",
                self.settings.audit().gradient_tolerance
            ),
            format!(
                "- {} searches, {} of which ended at a saddle; the last new point came with search {}",
                coverage.searches, coverage.arrived, coverage.last_new
            ),
            format!(
                "- coverage: {} saddles met once, {} twice; the chance that one more search that ends at a saddle ends \
                 at a new one is about {:.2} % (Good and Turing), and about {:.1} are still unseen (Chao, a lower bound)",
                coverage.once,
                coverage.twice,
                100.0 * coverage.chance_of_news,
                coverage.unseen
            ),
            format!("- ends of searches: {}", spell(&fates(found))),
        ];
        let verdicts = tally(
            found
                .refused
                .iter()
                .map(|refused| refused.audit.verdict.name()),
        );
        if !verdicts.is_empty() {
            lines.push(format!(
                "- points refused by their audit: {}",
                spell(&verdicts)
            ));
        }
        lines.push(format!(
            "- {} energy evaluations\n",
            found.evaluations as u64 + self.measuring
        ));
        lines.extend(
            self.warnings()
                .iter()
                .map(|warning| format!("Note: {warning}.\n")),
        );
        lines.extend(self.minima_table());
        lines.extend(self.saddle_table());
        lines.push(format!(
            "\nMade by `{}`, landscape {}.\n",
            self.command,
            env!("CARGO_PKG_VERSION")
        ));
        lines.join("\n")
    }

    fn minima_table(&self) -> Vec<String> {
        let merges = joined_at(&self.mapped.merges(), self.found);
        let mut lines = vec![
            "## Lowest minima\n".to_owned(),
            "| minimum | energy | joins a deeper one at | softest curvature |\n|---|---|---|---|"
                .to_owned(),
        ];
        let rows = self
            .found
            .minima
            .iter()
            .zip(&self.found.audits)
            .zip(&merges)
            .enumerate();
        lines.extend(rows.take(SHOWN).map(|(id, ((minimum, audit), joined))| {
            format!(
                "| m{id} | {:.6} | {} | {} |",
                minimum.energy,
                joined.map_or_else(String::new, |height| format!("{height:.6}")),
                audit
                    .curvatures
                    .first()
                    .map_or_else(String::new, |c| format!("{c:.4}"))
            )
        }));
        lines
    }

    fn saddle_table(&self) -> Vec<String> {
        let mut lines = vec![
            "\n## Lowest saddles\n".to_owned(),
            "| energy | joins | negative curvature | searches |\n|---|---|---|---|".to_owned(),
        ];
        lines.extend(self.found.saddles.iter().take(SHOWN).map(|saddle| {
            format!(
                "| {:.6} | m{}, m{} | {:.4} | {} |",
                saddle.energy,
                saddle.ends[0].0,
                saddle.ends[1].0,
                saddle.audit.curvatures[0],
                saddle.hits
            )
        }));
        lines
    }
}

/// Height at which each minimum joins a deeper one, by rising merges.
fn joined_at(merges: &[Merge], found: &Exploration) -> Vec<Option<f64>> {
    let count = found.minima.len();
    let mut joined = vec![None; count];
    // Minima come by rising energy, so the deepest of a set has the lowest number.
    let mut deepest: Vec<usize> = (0..count).collect();
    for merge in merges {
        let [a, b] = merge.ends.map(|end| deepest[end]);
        joined[a.max(b)] = Some(merge.height);
        for place in &mut deepest {
            if *place == a.max(b) {
                *place = a.min(b);
            }
        }
    }
    joined
}

fn fates(found: &Exploration) -> Vec<(String, usize)> {
    let fates = found.fates.iter();
    fates
        .map(|(fate, count)| (fate.name().to_owned(), *count))
        .collect()
}

fn spell(counts: &[(String, usize)]) -> String {
    let parts: Vec<String> = counts
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    parts.join(", ")
}

/// A file name made of a name.
fn file_name(name: &str) -> String {
    let parts = name.split(|c: char| !c.is_alphanumeric() && c != '.');
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    parts.join("-")
}

fn command_line(subject: &Subject<'_>, settings: &SearchSettings) -> String {
    let sides = subject.low.iter().zip(&subject.high);
    let sides: Vec<String> = sides.map(|(low, high)| format!("{low}:{high}")).collect();
    let paths = match settings.paths {
        PathMethod::String => "",
        PathMethod::Band => " --paths band",
    };
    format!(
        "landscape surface {} --region={} --patience {} --searches {}{paths} --seed {}",
        subject.words,
        sides.join(","),
        settings.patience,
        settings.max_searches,
        settings.seed
    )
}

/// `-1.5:1,-0.3:1.8`, or `-1:1x21` for 21 alike.
fn region(flag: &str) -> anyhow::Result<Region> {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for part in flag.split(',') {
        let (side, count) = part.split_once('x').unwrap_or((part, "1"));
        let ends = side.split_once(':').and_then(|(low, high)| {
            let ends: (f64, f64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
            (ends.0 < ends.1 && (ends.1 - ends.0).is_finite()).then_some(ends)
        });
        let count = count
            .trim()
            .parse()
            .ok()
            .filter(|count| (1..=10_000).contains(count));
        let Some(((least, most), count)) = ends.zip(count) else {
            bail!("--region {flag}: `{part}` is not low:high with low < high (or low:highxN)");
        };
        low.extend(vec![least; count]);
        high.extend(vec![most; count]);
    }
    Ok((low, high))
}

/// The space of coordinates of this kind.
pub(super) fn space(
    coordinates: Coordinates,
    count: usize,
) -> anyhow::Result<Box<dyn Space + Send>> {
    Ok(match coordinates {
        Coordinates::Flat => Box::new(Euclidean::new(count)),
        Coordinates::Angles => Box::new(Torus::new(count)),
        Coordinates::Atoms => {
            ensure!(
                count.is_multiple_of(3),
                "--coordinates atoms: --region has {count} coordinates, and an atom has three"
            );
            Box::new(Cluster::new(count / 3))
        }
        Coordinates::Rotation => {
            ensure!(
                count == 4,
                "--coordinates rotation: --region has {count} coordinates, and a quaternion has four"
            );
            Box::new(Rotation::new(1.0))
        }
    })
}

/// Hash of a command and of the files it names: a changed program is another one.
fn command_hash(program: &str) -> String {
    let files = program
        .split_whitespace()
        .filter(|word| Path::new(word).is_file());
    let mut parts: Vec<Vec<u8>> = files.filter_map(|file| std::fs::read(file).ok()).collect();
    parts.push(program.as_bytes().to_vec());
    content_hash(&parts.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// Compares the gradient with differences of the energy at random points of the region.
fn check_gradient(
    energy: &External,
    (low, high): (&[f64], &[f64]),
    seed: u64,
    step: f64,
) -> anyhow::Result<()> {
    let draw = in_box(low, high);
    let space = energy.space();
    let (mut good, mut wrong) = (0, None);
    for id in 0..CHECKED {
        let mut rng = stream(seed, Task::Start, u64::MAX / 2 + id);
        let x = draw(&mut rng);
        let direction = rng.random_range(0..space.tangents());
        let mut gradient = vec![0.0; space.tangents()];
        let here = energy.evaluate(&x, &mut gradient);
        let side = |length: f64| {
            let (mut there, mut tangent) = (x.clone(), vec![0.0; space.tangents()]);
            tangent[direction] = length;
            space.shift(&mut there, &tangent);
            energy.evaluate(&there, &mut vec![0.0; space.tangents()])
        };
        let (ahead, behind) = (side(step), side(-step));
        energy.check()?;
        let (told, measured) = (gradient[direction], (ahead - behind) / (2.0 * step));
        if !(here.is_finite() && measured.is_finite()) {
            continue;
        }
        // Differences of an energy are good to its rounding over the step.
        let noise = 1e-13 * (ahead.abs() + behind.abs()) / step;
        if (told - measured).abs() <= 0.02 * (told.abs() + measured.abs()) + 100.0 * noise {
            good += 1;
        } else {
            wrong.get_or_insert((x, direction, told, measured));
        }
    }
    match wrong {
        // A point next to a kink or a wall says nothing.
        Some((x, direction, told, measured)) if good == 0 => bail!(
            "the gradient is not the derivative of the energy: at {x:?} component {direction} is told as {told}, but \
             differences of the energy give {measured}"
        ),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_read() {
        assert_eq!(
            region("-1.5:1,0:2x2").unwrap(),
            (vec![-1.5, 0.0, 0.0], vec![1.0, 2.0, 2.0])
        );
        for wrong in [
            "", "1", "1:0", "0:0", "a:b", "0:1x0", "0:1,", "0:inf", "nan:1",
        ] {
            let error = region(wrong).unwrap_err().to_string();
            assert!(error.contains("low:high"), "{error}");
        }
    }

    #[test]
    fn names_become_file_names() {
        assert_eq!(file_name("lj 7"), "lj-7");
        assert_eq!(
            file_name("python3 ./a b/my_energy.py"),
            "python3-.-a-b-my-energy.py"
        );
    }
}
