//! Report of `landscape surface`: the tables, the manifest and the summary of a search.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::connected::ConnectedPair;
use super::drawing::{Titles, Views, not_drawn};
use super::error::StudyError;
use super::lowest;
use super::markdown::table;
use super::report::{WrittenLandscape, conclude};
use super::searched::{Searched, SurfaceSearch};
use super::settings::StudyRun;
use super::surface_space::{Coordinates, in_region};
use super::tables::{Input, Mapped};
use super::uncertainty::Uncertainty;
use super::{Digits, json as value, tally};
use crate::energy::Energy;
use crate::printable::counted;
use crate::space::Copies;
use crate::store::{AtomicFolder, Counts, LandscapeFiles, Manifest, Source, StationaryRow};
use crate::topography::exchange::{Database, points};
use crate::topography::{
    Audit, Coverage, Doubt, Exploration, FamilySettings, Landscape, LowestReport, Merge, SearchEnd,
    SearchSettings, TransitionState, Verdict, explore_from, explore_lowest,
};

/// Greatest number of rows of a table in the summary.
const SHOWN: usize = 20;

const KINKS: &str = "ended at the bottom of a kink: the gradient jumps there and does not vanish, so it is not a minimum of a \
                                smooth surface (round the kink off)";
const UNFINISHED: &str = "from random points ended where the gradient does not vanish: the energy jumps there, \
                          its domain ends there, it has no lower bound, its gradient is wrong, or a valley is so stiff that the \
                          evaluations of a descent did not suffice (`max_evaluations` in --config)";

/// The searched surface.
#[derive(Clone)]
pub struct Subject<'a> {
    /// Name of the model, or of the program that computes the energy.
    pub name: &'a str,
    /// The surface.
    pub energy: &'a dyn Energy,
    /// Kind of coordinates: the name of one of [`Coordinates`].
    pub coordinates: String,
    /// Lower bounds of the box of random starts.
    pub low: Vec<f64>,
    /// Upper bounds of this box.
    pub high: Vec<f64>,
    /// Origin of the energy: the model, or the program and the files named in its command.
    pub source: Source,
}

/// A searched surface and its results.
pub struct SurfaceReport<'a> {
    /// The searched surface.
    pub subject: &'a Subject<'a>,
    /// The results, with at least one minimum.
    pub found: &'a Exploration,
    /// Its landscape.
    pub landscape: &'a Landscape,
    /// The settings of the search.
    pub settings: &'a SearchSettings,
    /// How the search for the lowest minima went, if only these were sought.
    pub lowest: Option<&'a LowestReport>,
    /// The command line that repeats the search.
    pub command: String,
    /// Energy evaluations used to measure the scales of the surface.
    pub measuring: u64,
}

impl std::fmt::Debug for Subject<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (formatter.debug_struct("Subject").field("name", &self.name)).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for SurfaceReport<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut told = formatter.debug_struct("SurfaceReport");
        told.field("subject", &self.subject).finish_non_exhaustive()
    }
}

/// Searches a surface for minima and saddles and builds their landscape.
///
/// # Errors
/// [`StudyError::NoMinimum`] if nothing was found, [`StudyError::Journal`] if a finished task cannot be stored.
///
/// # Examples
/// The Müller–Brown surface, and the folder that `landscape surface muller-brown` writes.
///
/// ```
/// use landscape::energy::model;
/// use landscape::store::{AtomicFolder, Source};
/// use landscape::study::{StudyRun, Subject, SurfaceReport, SurfaceSearch, search_surface};
/// use landscape::topography::{FamilySettings, SearchSettings, in_box};
///
/// let surface = model::named(&["muller-brown".to_owned()])?;
/// let subject = Subject {
///     name: &surface.name,
///     energy: &*surface.energy,
///     coordinates: surface.coordinates.to_owned(),
///     low: surface.low.clone(),
///     high: surface.high.clone(),
///     source: Source::default(),
/// };
/// let draw = in_box(&subject.low, &subject.high);
/// let settings = SearchSettings::measured(subject.energy, &draw, 0);
/// let families = FamilySettings::default();
/// let search = SurfaceSearch { settings: &settings, lowest: None, known: &[], pair: None };
/// let searched = search_surface(&subject, &search, &families, &StudyRun::default())?;
/// let found = &searched.found;
/// assert_eq!((found.minima.len(), found.saddles.len()), (3, 2));
///
/// let report = SurfaceReport {
///     subject: &subject,
///     found,
///     landscape: &searched.landscape,
///     settings: &settings,
///     lowest: None,
///     command: String::new(),
///     measuring: 0,
/// };
/// let place = tempfile::tempdir()?;
/// let folder = AtomicFolder::open(&place.path().join("muller-brown.landscape"), true)?;
/// assert!(report.write(&folder)?.text.contains("**3 minima** and **2 saddles**"));
/// let finished = folder.finish()?;
/// assert!(finished.join("disconnectivity.svg").is_file() && finished.join("minima.parquet").is_file());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn search_surface(
    subject: &Subject<'_>,
    search: &SurfaceSearch<'_>,
    families: &FamilySettings,
    run: &StudyRun<'_>,
) -> Result<Searched, StudyError> {
    let draw = in_region(subject.energy.space(), (&subject.low, &subject.high));
    let (energy, settings) = (subject.energy, search.settings);
    let (found, lowest) = match search.lowest {
        Some(lowest) => {
            let (found, report) =
                explore_lowest(energy, &draw, search.known, settings, lowest, &run.run)?;
            (found, Some(report))
        }
        None => (
            explore_from(energy, &draw, search.known, search.pair, settings, &run.run)?,
            None,
        ),
    };
    (run.stage_ended)("search", found.evaluations);
    if found.minima.is_empty() {
        let mut why = String::new();
        for reason in no_minima(&found) {
            let _ = write!(why, "; {reason}");
        }
        return Err(StudyError::NoMinimum {
            surface: subject.name.to_owned(),
            searches: found.coverage.searches,
            ends: format!("({}){why}", told_ends(&found)),
        });
    }
    let landscape = found.landscape(subject.energy, families);
    Ok(Searched {
        found,
        landscape,
        lowest,
    })
}

impl Subject<'_> {
    /// What a manifest says of the energy.
    pub(super) fn described(&self) -> Value {
        json!({
            "surface": self.name,
            "coordinates": self.coordinates,
            "low": self.low,
            "high": self.high,
        })
    }
}

impl SurfaceReport<'_> {
    fn mapped(&self) -> Mapped<'_> {
        Mapped {
            landscape: self.landscape,
            energy: self.subject.energy,
            // Hops count as one input.
            inputs: (0..self.found.coverage.searches.max(1) as u64)
                .map(|id| Input { id, label: None })
                .collect(),
            ways: Vec::new(),
        }
    }

    /// Writes the tables, pictures, texts and summary of `landscape surface` into `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written, or a number is not finite.
    pub fn write(&self, folder: &AtomicFolder) -> Result<WrittenLandscape, StudyError> {
        let mapped = self.mapped();
        let merges = mapped.landscape.merges();
        let uncertainty = Uncertainty::of(self.landscape, "random starts");
        let files = self.files(&mapped, &merges, &uncertainty);
        StationaryRow::write(&self.stationary(), folder)?;
        let minima = self.found.minima.iter();
        let minima = points(minima.map(|minimum| minimum.coordinates.as_slice()));
        folder.write("points.min", &minima)?;
        let saddles = self.found.saddles.iter();
        let saddles = points(saddles.map(|saddle| saddle.coordinates.as_slice()));
        folder.write("points.ts", &saddles)?;
        let kind = Coordinates::named(&self.subject.coordinates);
        let kinds = kind.as_ref().and_then(Coordinates::kinds);
        let mut database = Database::from_exploration(self.found, kinds.as_deref());
        if let Some(copies) = kind.and_then(|kind| kind.copies(self.subject.low.len())) {
            self.count_copies(&copies, &mut database);
        }
        let title = format!(
            "{}: {}, {}",
            self.subject.name,
            counted(self.found.minima.len(), "minimum"),
            counted(self.found.distinct_saddles().count(), "saddle")
        );
        let titles = Titles::of_surface(title, "random starts", self.settings.seed);
        let views = Views {
            lowest: self.lowest.map(|report| report.sought),
            ..Views::default()
        };
        mapped.draw(&titles, views, &database, Vec::new(), folder)?;
        uncertainty.unseen.draw(&titles.title, folder)?;
        conclude(files, &self.summary(&merges), folder)
    }

    /// Sets the orders of point groups: a point that more symmetries leave in place has fewer copies.
    fn count_copies(&self, copies: &Copies, database: &mut Database) {
        let reach = self.settings.sameness.distance;
        let minima = database.minima.iter_mut().zip(&self.found.minima);
        let minima = minima.map(|(entry, minimum)| (&mut entry.vibrations, &minimum.coordinates));
        let saddles = database
            .transition_states
            .iter_mut()
            .zip(&self.found.saddles);
        let saddles = saddles.map(|(entry, saddle)| (&mut entry.vibrations, &saddle.coordinates));
        for (vibrations, point) in minima.chain(saddles) {
            if let Some(vibrations) = vibrations {
                let order = u32::try_from(copies.stabiliser(point, reach));
                vibrations.point_group_order = order.unwrap_or(u32::MAX);
            }
        }
    }

    fn files(
        &self,
        mapped: &Mapped<'_>,
        merges: &[Merge],
        uncertainty: &Uncertainty,
    ) -> LandscapeFiles {
        let mut findings = mapped.findings(merges, uncertainty);
        let mut tell = |name: &str, value| findings.insert(name.to_owned(), value);
        tell("saddles", json!(self.found.distinct_saddles().count()));
        tell("coverage", value(self.found.coverage));
        tell("limits", value(self.found.limits));
        tell("ends_of_searches", json!(ends_of_searches(self.found)));
        tell("refused", value(&self.found.refused));
        if let Some(lowest) = self.lowest {
            tell("lowest", value(lowest));
        }
        if let Some(connected) = self.connected() {
            tell("connected", value(connected));
        }
        mapped.files(Manifest {
            command: self.command.clone(),
            seed: self.settings.seed,
            source: self.subject.source.clone(),
            scale: 1.0,
            energy: self.subject.described(),
            settings: value(self.settings),
            terms: self.terms(),
            counts: Counts {
                evaluations: self.found.evaluations as u64 + self.measuring,
                ..Counts::default()
            },
            findings,
            warnings: self.warnings(),
            ..Manifest::default()
        })
    }

    fn terms(&self) -> Vec<String> {
        let terms = self.subject.energy.terms(&self.found.minima[0].coordinates);
        terms.into_iter().map(|(name, _)| name).collect()
    }

    /// Minima, then saddles, each sorted by energy.
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

    /// Why the search was stopped before it ended by itself, if it was.
    fn why_stopped(&self) -> Option<String> {
        let (coverage, stopped) = (&self.found.coverage, self.found.stopped);
        if stopped && coverage.searches >= self.settings.max_searches {
            return Some(format!(
                "the search was stopped after {}, before it ended by itself (--searches allows more)",
                counted(coverage.searches, "search")
            ));
        }
        if stopped && coverage.searches == 0 {
            return Some(
                "the search was stopped by --budget while it still sought the lowest minima; none of them are joined, and the \
                 result depends on the speed of the machine"
                    .to_owned(),
            );
        }
        if self.lowest.is_some_and(|report| report.hopping_stopped) {
            return Some(
                "half of the time of --budget was over before the hops to the lowest minima ended by themselves; lower ones \
                 are likely, and the result depends on the speed of the machine"
                    .to_owned(),
            );
        }
        let kind = if self.lowest.is_some() {
            "lowest"
        } else {
            "all"
        };
        stopped.then(|| {
            format!(
                "the search was stopped by --budget after {}, before it ended by itself, so the result depends on the speed of \
                 the machine; `--search {kind} --searches {}` without --budget repeats it on any machine",
                counted(coverage.searches, "search"),
                coverage.searches
            )
        })
    }

    fn warnings(&self) -> Vec<String> {
        let (coverage, components) = (&self.found.coverage, self.found.components());
        let mut warnings: Vec<String> = self.why_stopped().into_iter().collect();
        let stopped = self.found.stopped;
        let rare = coverage.once + coverage.joined;
        if rare > 0 && self.lowest.is_none() {
            warnings.push(format!(
                "{rare} of {} {} met by one search or by none: more may be missing{}",
                counted(self.found.distinct_saddles().count(), "saddle"),
                if rare == 1 { "was" } else { "were" },
                if stopped {
                    ""
                } else {
                    " (--patience looks longer)"
                }
            ));
        }
        let [minima, saddles] = self.degenerate();
        if minima + saddles > 0 {
            warnings.push(format!(
                "{} and {} are not isolated (`degenerate` in the tables): each stands for a ring, a trough or a plateau. \
                 Points of one energy count as one if a walk along the level directions joins them. Otherwise they are \
                 distinguished only if descents from between them end on both sides of a ridge, so some may be counted as one",
                counted(minima, "minimum"),
                counted(saddles, "saddle")
            ));
        }
        if self.found.distinct_saddles().count() < self.found.saddles.len() {
            warnings.push(
                "more than two valleys meet in a saddle whose curvatures vanish: it is listed once for each valley except one, \
                 and its rows after the first are `duplicate` in the tables. Rates over it are not harmonic"
                    .to_owned(),
            );
        }
        let [minima, saddles] = self.on_faces();
        if minima + saddles > 0 {
            warnings.push(format!(
                "on a face of the box, curvatures are not given. Minima there: {minima}; saddles there: {saddles}. min.data \
                 and ts.data contain placeholders, and `thermodynamics` and `rates` cannot count these points (--without-faces \
                 leaves such minima out)"
            ));
        }
        warnings.extend(no_minima(self.found));
        if components > 1 && self.lowest.is_none() {
            warnings.push(format!(
                "no saddle was found between {components} components of minima: {}",
                self.why_apart()
            ));
        }
        let limits = self.found.limits.filter(|limits| limits.rises > 0);
        warnings.extend(limits.map(|limits| {
            format!(
                "more searches ended at the limit of steps than at a saddle, as on a stiff surface, so that it was raised to {} \
                 steps{}",
                limits.steps,
                if limits.are_low() {
                    "; it still ends most searches (`steps` in --config raises it further)"
                } else {
                    ""
                }
            )
        }));
        let bounds = self.found.bounds.len();
        if bounds > 0 {
            warnings.push(format!(
                "{} between these components {} a relaxed path over no verified saddle: its height is an upper bound, dashed \
                 in the pictures, and not a transition state, so that ts.data, `thermodynamics` and `rates` leave it out",
                counted(bounds, "connection"),
                if bounds == 1 { "is" } else { "are each" }
            ));
        }
        warnings
    }

    /// The most likely reason why minima are joined by no saddle, as far as counts show it.
    fn why_apart(&self) -> String {
        let found = self.found;
        let ended = |end| found.search_ends.get(&end).copied().unwrap_or(0);
        let kinks = found.refused.iter().filter(|refused| refused.is_kink());
        let limits = found.limits.unwrap_or_default();
        if found.stopped {
            return "the search was stopped before it ended by itself".to_owned();
        }
        if limits.are_low() {
            return format!(
                "of the last {} searches {} ended at the limit of {} steps, as on a stiff surface (`steps` in --config raises it)",
                limits.searches, limits.cut, limits.steps
            );
        }
        let (kinks, jumps) = (kinks.count(), found.coverage.unfinished);
        if kinks + jumps > 0 {
            return "the energy has kinks, jumps or gaps (see the descents above), and no saddle can be verified if the ridge \
                    between the minima is a kink"
                .to_owned();
        }
        let outside = ended(SearchEnd::Outside);
        if outside > 0 {
            return format!(
                "{outside} searches left the domain, and it may have a gap between them"
            );
        }
        let flat = ended(SearchEnd::Flat);
        if flat > found.coverage.arrived {
            return format!(
                "{flat} searches ended where the surface is flat along the way up; the saddle between them may be degenerate \
                 (without curvature in some direction) and cannot be verified then"
            );
        }
        "one is missing (--patience looks longer), or it lies on a kink, where it cannot be verified".to_owned()
    }

    fn summary(&self, merges: &[Merge]) -> String {
        let found = self.found;
        let mut lines = vec![format!("# {}\n", self.subject.name)];
        lines.extend(self.what_was_found());
        match self.lowest {
            Some(report) => lines.extend(lowest::told(found, report, merges)),
            None => lines.extend(self.how_complete_it_is()),
        }
        let not_drawn = match self.lowest {
            Some(report) => lowest::not_drawn(report, found.minima.len()),
            None => not_drawn(found.minima.len()),
        };
        lines.extend(not_drawn.map(|sentence| format!("- {sentence}")));
        let digits = self.digits();
        let connected = self.connected();
        lines.extend(connected.map(|pair| format!("- {}", pair.spell(|h| digits.show(h)))));
        let refused = found.refused.iter();
        let verdicts = tally(refused.map(|refused| refused.audit.verdict.told()));
        if !verdicts.is_empty() {
            lines.push(format!(
                "- points that are not what a search took them for, and are not listed: {}",
                spell(&verdicts)
            ));
        }
        lines.push(format!(
            "- {} energy evaluations\n",
            found.evaluations as u64 + self.measuring
        ));
        let warnings = self.warnings();
        lines.extend(warnings.iter().map(|warning| format!("Note: {warning}.\n")));
        if let Some(report) = self.lowest {
            lines.push(lowest::deepest(found, report, merges, self.digits()));
        }
        lines.push(self.minima_table(merges));
        lines.push(self.saddle_table());
        lines.push(format!(
            "Made by `{}`, landscape {}.\n",
            self.command,
            env!("CARGO_PKG_VERSION")
        ));
        lines.join("\n")
    }

    /// What the further searches between two minima found, if any were made.
    fn connected(&self) -> Option<ConnectedPair> {
        let further = self.found.further.as_ref();
        further.map(|further| ConnectedPair::of_surface(self.landscape, further))
    }

    fn what_was_found(&self) -> [String; 2] {
        let found = self.found;
        let loops = found
            .distinct_saddles()
            .filter(|saddle| saddle.ends[0] == saddle.ends[1]);
        // Pairs far above the lowest minima, which were met by the way, hang in the air.
        let families = &self.landscape.families;
        let components = match self.lowest {
            Some(_) => String::new(),
            None => format!(
                "; {}; {}",
                counted(found.components(), "component"),
                if found.minima.len() > 1 && families.members.len() == found.minima.len() {
                    "no families, since no height divides the barriers".to_owned()
                } else {
                    format!(
                        "{} (relative barrier up to {})",
                        counted(families.members.len(), "family"),
                        Digits::of([families.barrier]).show(families.barrier)
                    )
                }
            ),
        };
        let degenerate = match self.degenerate().iter().sum() {
            0 => String::new(),
            1 => "; **1 of them is not isolated**: a ring, a trough or a plateau".to_owned(),
            some => format!("; **{some} of them are not isolated**: rings, troughs or plateaus"),
        };
        [
            format!(
                "- **{}** and **{}**, {} of which join two copies of one minimum{components}",
                counted(found.minima.len(), "minimum"),
                counted(found.distinct_saddles().count(), "saddle"),
                loops.count(),
            ),
            format!(
                "- every one passed its audit: gradient below {:.1e}, index of the Hessian, descents on both sides of \
                 saddles, no duplicates{degenerate}",
                self.settings.audit().gradient_tolerance,
            ),
        ]
    }

    fn how_complete_it_is(&self) -> [String; 5] {
        let (found, coverage) = (self.found, &self.found.coverage);
        let others = if coverage.undrawn > 0 {
            ", the others were reached from saddles only"
        } else {
            ""
        };
        [
            format!(
                "- {}, {} of which ended at a saddle near which they had not begun; the last new point came with search {}{}",
                counted(coverage.searches, "search"),
                coverage.arrived,
                coverage.last_new,
                if 2 * coverage.last_new < coverage.searches && coverage.doubt.is_none() {
                    format!(
                        ", and those after it only make sure (a --patience below {} makes fewer of them)",
                        self.settings.patience
                    )
                } else {
                    String::new()
                }
            ),
            format!(
                "- minima: {} from random points ended in {} of them{others}",
                counted(coverage.draws, "descent"),
                found.minima.len() - coverage.undrawn,
            ),
            format!(
                "- saddles: {} met once, {} twice, {} only by a path between two minima; {}",
                coverage.once,
                coverage.twice,
                coverage.joined,
                chance_of_news(coverage)
            ),
            format!("- completeness: {}", completeness(found)),
            format!("- searches ended: {}", told_ends(found)),
        ]
    }

    /// Numbers of minima and saddles that are not isolated.
    fn degenerate(&self) -> [usize; 2] {
        self.audited(|audit| audit.verdict == Verdict::Degenerate)
    }

    /// Numbers of minima and saddles of this kind.
    fn audited(&self, is: impl Fn(&Audit) -> bool) -> [usize; 2] {
        let saddles = self.found.saddles.iter().map(|saddle| &saddle.audit);
        let minima = self.found.audits.iter().filter(|audit| is(audit)).count();
        [minima, saddles.filter(|audit| is(audit)).count()]
    }

    /// Numbers of minima and saddles without curvatures, which lie on a face of a box.
    fn on_faces(&self) -> [usize; 2] {
        if Coordinates::named(&self.subject.coordinates) != Some(Coordinates::Box) {
            return [0; 2];
        }
        self.audited(|audit| audit.curvatures.is_empty())
    }

    fn digits(&self) -> Digits {
        let minima = self.found.minima.iter().map(|minimum| minimum.energy);
        let energies = minima.chain(self.found.saddles.iter().map(|saddle| saddle.energy));
        Digits::within(self.settings.sameness.energy, energies)
    }

    fn minima_table(&self, merges: &[Merge]) -> String {
        // Height at which each minimum joins a deeper one.
        let mut joined_at = vec![None; self.found.minima.len()];
        for merge in merges {
            joined_at[merge.shallower.0] = Some(merge.height);
        }
        let digits = self.digits();
        let softest = |audit: &Audit| audit.curvatures.first().copied();
        let curvatures = Digits::measured(self.found.audits.iter().filter_map(softest));
        let minima = self.found.minima.iter().zip(&self.found.audits);
        let rows = minima.zip(&joined_at).enumerate().take(SHOWN);
        let rows = rows.map(|(id, ((minimum, audit), joined))| {
            vec![
                format!("m{id}{}", mark(audit)),
                digits.show(minimum.energy),
                joined.map_or_else(String::new, |height| digits.show(height)),
                softest(audit).map_or_else(String::new, |curvature| curvatures.show(curvature)),
            ]
        });
        let head = [
            "minimum",
            "energy",
            "joins a deeper one at",
            "softest curvature",
        ];
        format!("## Lowest minima\n\n{}", table(&head, rows))
    }

    fn saddle_table(&self) -> String {
        let digits = self.digits();
        let negative = |saddle: &TransitionState| saddle.audit.curvatures.first().copied();
        let curvatures = Digits::measured(self.found.saddles.iter().filter_map(negative));
        let rows = self.found.saddles.iter().take(SHOWN).map(|saddle| {
            vec![
                format!("{}{}", digits.show(saddle.energy), mark(&saddle.audit)),
                format!("m{}, m{}", saddle.ends[0].0, saddle.ends[1].0),
                negative(saddle).map_or_else(String::new, |curvature| curvatures.show(curvature)),
                saddle.hits.to_string(),
            ]
        });
        let head = ["energy", "joins", "negative curvature", "searches"];
        format!("## Lowest saddles\n\n{}", table(&head, rows))
    }
}

/// Why descents ended at points that are no minima, one sentence for each reason.
fn no_minima(found: &Exploration) -> Vec<String> {
    let refused = found.refused.iter();
    let kinks = refused.filter(|refused| refused.is_kink());
    let reasons = [
        (kinks.count(), KINKS),
        (found.coverage.unfinished, UNFINISHED),
    ];
    let told = reasons.iter().filter(|(count, _)| *count > 0);
    told.map(|(count, reason)| format!("{} {reason}", counted(*count, "descent")))
        .collect()
}

/// Mark for a point that is not isolated, or the saddle of an earlier row.
fn mark(audit: &Audit) -> &'static str {
    match audit.verdict {
        Verdict::Degenerate => " (not isolated)",
        Verdict::Duplicate => " (the same saddle)",
        _ => "",
    }
}

fn completeness(found: &Exploration) -> String {
    let coverage = &found.coverage;
    // Enough digits for a share that is small.
    let share = |share: f64| format!("{:.*} %", usize::from(share < 0.1), 100.0 * share);
    let limits = format!(
        "Not covered are saddles much harder to meet than these, and minima with small basins: those in which no descent ended hold \
         at most {} of the region (95 % limit)",
        share(coverage.undrawn_share_below)
    );
    if coverage.planned > 0 {
        return format!(
            "nothing is claimed, since the search was stopped before {} planned searches, most of them along modes of known \
             minima, which find most saddles: how many are missing cannot be estimated",
            coverage.planned
        );
    }
    let unseen = coverage.unseen.map(|least| {
        let expected = if least < 0.5 {
            "numbers of hits show no missing saddle".to_owned()
        } else {
            format!("about {least:.0} saddles or more are missing (Chao's lower bound), and the minima behind them")
        };
        let bound = coverage.unseen_below.map_or_else(
            || "a useful upper limit cannot be given".to_owned(),
            |bound| format!("up to {bound} may be missing (95 % limit)"),
        );
        format!("{expected}; {bound}")
    });
    let doubted = |reason: &str| match &unseen {
        Some(unseen) => format!("nothing is claimed, since {reason}; {unseen}"),
        None => format!("nothing is claimed, since {reason}"),
    };
    match coverage.doubt {
        Some(Doubt::Stopped) => doubted("the search was stopped"),
        Some(Doubt::Sampled) => doubted("only the lowest part of the landscape was searched"),
        Some(Doubt::Apart) => doubted("some minima are joined to the others by no saddle"),
        Some(Doubt::Degenerate) => {
            "nothing is claimed, since rings, troughs and plateaus have no number of points"
                .to_owned()
        }
        Some(Doubt::Alone) if coverage.draws == 0 => {
            "nothing is claimed, since no search ended at a saddle".to_owned()
        }
        Some(Doubt::Alone) => format!(
            "nothing is claimed, since no saddle was met; other minima have at most {} of the region as their basins (95 % limit of \
             {}; --patience looks longer)",
            share(coverage.undrawn_share_below),
            counted(coverage.draws, "descent"),
        ),
        Some(Doubt::Few) => {
            let [arrived, all] = found.limits.unwrap_or_default().few().unwrap_or_default();
            format!(
                "nothing is claimed, since only {arrived} of {all} searches ended at a saddle: on such a surface (stiff, as a rule) \
                 saddles are easily missed"
            )
        }
        Some(Doubt::Undecided) => {
            "nothing is claimed, since searches ended where a minimum and a saddle would be too close together to be distinguished"
                .to_owned()
        }
        Some(Doubt::Kinks) => "nothing is claimed, since the surface has kinks".to_owned(),
        Some(Doubt::Unfinished) => {
            "nothing is claimed, since descents ended where the gradient does not vanish".to_owned()
        }
        None if coverage.sure >= 0.99 => {
            format!("**99 % sure** of all minima and saddles. {limits}")
        }
        None if coverage.sure >= 0.95 => format!("95 % sure of all minima and saddles. {limits}"),
        None => format!(
            "{} (--patience looks longer)",
            unseen.unwrap_or_else(
                || "nothing is claimed, since no search ended at a saddle".to_owned()
            )
        ),
    }
}

fn chance_of_news(coverage: &Coverage) -> String {
    if coverage.arrived == 0 {
        return "no search ended at a saddle, so that nothing is known of the next one".to_owned();
    }
    let limit = if coverage.chance_of_news_below < 1.0 {
        format!(
            ", at most {:.2} % (95 % limit)",
            100.0 * coverage.chance_of_news_below
        )
    } else {
        String::new()
    };
    format!(
        "the next search that ends at a saddle ends at a new one with a chance of {:.2} % (Good and Turing){limit}",
        100.0 * coverage.chance_of_news
    )
}

pub(super) fn ends_of_searches(found: &Exploration) -> Vec<(String, usize)> {
    let fates = found.search_ends.iter();
    fates
        .map(|(fate, count)| (fate.name().to_owned(), *count))
        .collect()
}

/// How many searches ended where, in words.
pub(super) fn told_ends(found: &Exploration) -> String {
    let ends = found.search_ends.iter();
    let told: Vec<String> = ends
        .map(|(end, count)| format!("{count} {}", end.told()))
        .collect();
    told.join(", ")
}

pub(super) fn spell(counts: &[(String, usize)]) -> String {
    let parts: Vec<String> = counts
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    parts.join(", ")
}
