//! What `landscape surface` says of a search: the tables, the manifest and the summary.

use std::collections::BTreeMap;

use serde_json::json;

use super::Subject;
use crate::cli::digits::Digits;
use crate::cli::drawing::not_drawn;
use crate::cli::landscape::{Mapped, Merge, Titles};
use crate::cli::run::tally;
use crate::cli::uncertainty::Unseen;
use crate::store::{Counts, LandscapeFiles, Manifest, StationaryRow};
use crate::topography::{
    Audit, Coverage, Doubt, Exploration, SearchSettings, TransitionState, Verdict,
};

/// Rows of a table of the summary.
const SHOWN: usize = 20;

/// What is said of descents that ended at kinks.
pub(super) const KINKS: &str = "descents ended at the bottom of a kink: the gradient jumps there and does not vanish, so that \
                                it is no minimum of a smooth surface (round the kink off)";

/// What was found and everything that describes it.
pub(super) struct Report<'a> {
    pub(super) mapped: Mapped<'a>,
    pub(super) unseen: Unseen,
    pub(super) found: &'a Exploration,
    pub(super) subject: &'a Subject<'a>,
    pub(super) settings: &'a SearchSettings,
    pub(super) command: String,
    pub(super) measuring: u64,
}

impl Report<'_> {
    pub(super) fn titles(&self) -> Titles<'static> {
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

    pub(super) fn tables(&self) -> anyhow::Result<LandscapeFiles> {
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
        findings.insert("rarefaction".to_owned(), self.unseen.to_json()?);
        let manifest = Manifest {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.clone(),
            seed: self.settings.seed,
            source: self.subject.source.clone(),
            hand: None,
            object: None,
            scale: 1.0,
            energy: json!({
                "surface": self.subject.name,
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
    pub(super) fn stationary(&self) -> Vec<StationaryRow> {
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
        let stopped = coverage.searches >= self.settings.max_searches;
        if stopped {
            warnings.push(format!(
                "the search was stopped after {} searches, before it ended by itself (--searches allows more)",
                coverage.searches
            ));
        }
        let rare = coverage.once + coverage.joined;
        if rare > 0 {
            warnings.push(format!(
                "{rare} of {} saddles were met by one search or by none: more may be missing{}",
                self.found.saddles.len(),
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
                "{minima} minima and {saddles} saddles are not isolated (`degenerate` in the tables): each stands for a ring, \
                 a trough or a plateau, whose points of one energy are counted once"
            ));
        }
        let kinks = kinks(self.found);
        if kinks > 0 {
            warnings.push(format!("{kinks} {KINKS}"));
        }
        if components > 1 {
            warnings.push(format!(
                "no saddle was found between {components} groups of minima"
            ));
        }
        warnings
    }

    pub(super) fn summary(&self) -> String {
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
                 saddles, no duplicates{}",
                self.settings.audit().gradient_tolerance,
                match self.degenerate().iter().sum() {
                    0 => String::new(),
                    some =>
                        format!("; **{some} of them are not isolated**: rings, troughs or plateaus"),
                }
            ),
            format!(
                "- {} searches, {} of which ended at a saddle; the last new point came with search {}",
                coverage.searches, coverage.arrived, coverage.last_new
            ),
            format!(
                "- minima: {} descents from random points ended in {} of them{}",
                coverage.draws,
                found.minima.len() - coverage.undrawn,
                if coverage.undrawn > 0 {
                    ", the others were reached from saddles only"
                } else {
                    ""
                }
            ),
            format!(
                "- saddles: {} met once, {} twice, {} only by a path between two minima; the next search that ends at a saddle \
                 ends at a new one with a chance of {:.2} % (Good and Turing), at most {:.2} % (95 % limit)",
                coverage.once,
                coverage.twice,
                coverage.joined,
                100.0 * coverage.chance_of_news,
                100.0 * coverage.chance_of_news_below
            ),
            format!("- completeness: {}", completeness(coverage)),
            format!("- ends of searches: {}", spell(&fates(found))),
        ];
        lines.extend(not_drawn(found.minima.len()).map(|sentence| format!("- {sentence}")));
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

    /// Minima and saddles that are not isolated.
    fn degenerate(&self) -> [usize; 2] {
        let degenerate = |audit: &&Audit| audit.verdict == Verdict::Degenerate;
        [
            self.found.audits.iter().filter(degenerate).count(),
            (self.found.saddles.iter().map(|saddle| &saddle.audit))
                .filter(degenerate)
                .count(),
        ]
    }

    /// The digits of energies.
    fn digits(&self) -> Digits {
        let minima = self.found.minima.iter().map(|minimum| minimum.energy);
        Digits::of(minima.chain(self.found.saddles.iter().map(|saddle| saddle.energy)))
    }

    fn minima_table(&self) -> Vec<String> {
        let merges = joined_at(&self.mapped.merges(), self.found);
        let digits = self.digits();
        let softest = |audit: &Audit| audit.curvatures.first().copied();
        let curvatures = Digits::of(self.found.audits.iter().filter_map(softest));
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
                "| m{id}{} | {} | {} | {} |",
                isolation(audit),
                digits.show(minimum.energy),
                joined.map_or_else(String::new, |height| digits.show(height)),
                softest(audit).map_or_else(String::new, |curvature| curvatures.show(curvature))
            )
        }));
        lines
    }

    fn saddle_table(&self) -> Vec<String> {
        let mut lines = vec![
            "\n## Lowest saddles\n".to_owned(),
            "| energy | joins | negative curvature | searches |\n|---|---|---|---|".to_owned(),
        ];
        let digits = self.digits();
        let negative = |saddle: &TransitionState| saddle.audit.curvatures[0];
        let curvatures = Digits::of(self.found.saddles.iter().map(negative));
        lines.extend(self.found.saddles.iter().take(SHOWN).map(|saddle| {
            format!(
                "| {}{} | m{}, m{} | {} | {} |",
                digits.show(saddle.energy),
                isolation(&saddle.audit),
                saddle.ends[0].0,
                saddle.ends[1].0,
                curvatures.show(negative(saddle)),
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

/// Descents and climbs that ended at kinks.
pub(super) fn kinks(found: &Exploration) -> usize {
    let refused = found.refused.iter();
    refused
        .filter(|refused| refused.audit.verdict == Verdict::Kink)
        .count()
}

/// What marks a point that is not isolated in a table.
fn isolation(audit: &Audit) -> &'static str {
    if audit.verdict == Verdict::Degenerate {
        " (not isolated)"
    } else {
        ""
    }
}

/// What is claimed of completeness.
fn completeness(coverage: &Coverage) -> String {
    let limits = "as far as numbers of hits can tell: a saddle much harder to meet than all of these is not covered";
    let unseen = format!(
        "at least {:.1} (Chao) and at most {} (95 %) more saddles are to be expected, and the minima behind them",
        coverage.unseen,
        coverage
            .unseen_below
            .map_or_else(|| "any number of".to_owned(), |bound| bound.to_string())
    );
    let doubted = |reason: &str| format!("nothing is claimed, since {reason}; {unseen}");
    match coverage.doubt {
        Some(Doubt::Stopped) => doubted("the search was stopped"),
        Some(Doubt::Apart) => doubted("some minima are joined to the others by no saddle"),
        Some(Doubt::Degenerate) => {
            "nothing is claimed, since rings, troughs and plateaus have no number of points"
                .to_owned()
        }
        Some(Doubt::Kinks) => "nothing is claimed, since the surface has kinks".to_owned(),
        None if coverage.sure >= 0.99 => {
            format!("**99 % sure** of all minima and saddles, {limits}")
        }
        None if coverage.sure >= 0.95 => format!("95 % sure of all minima and saddles, {limits}"),
        None => format!("{unseen} (--patience looks longer)"),
    }
}

pub(super) fn fates(found: &Exploration) -> Vec<(String, usize)> {
    let fates = found.fates.iter();
    fates
        .map(|(fate, count)| (fate.name().to_owned(), *count))
        .collect()
}

pub(super) fn spell(counts: &[(String, usize)]) -> String {
    let parts: Vec<String> = counts
        .iter()
        .map(|(name, count)| format!("{count} {name}"))
        .collect();
    parts.join(", ")
}
