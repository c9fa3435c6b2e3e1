//! What `landscape build` says of grasps: the manifest and the summary.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;

use super::drawing::not_drawn;
use super::landscape::{Mapped, Merge, Titles, median, upper_bounds};
use super::magnetisation::Choice;
use super::run::tally;
use super::uncertainty::{self, Unseen};
use crate::grasp::GraspEnergy;
use crate::grasp::hover::HoverCost;
use crate::store::{Counts, LandscapeFiles, Manifest, Population, Source};
use crate::topography::{Evidence, MapSettings, MinimumId};

/// A mapped population and everything that describes it.
pub(super) struct Report<'a> {
    pub(super) mapped: Mapped<'a>,
    pub(super) unseen: Unseen,
    pub(super) energy: &'a GraspEnergy,
    pub(super) population: &'a Population<'a>,
    pub(super) settings: &'a MapSettings,
    /// Minima in their order of arrival, where the order mattered: sequential ADELM.
    pub(super) arrivals: Option<&'a [MinimumId]>,
    /// How temperature and force were chosen.
    pub(super) choice: &'a Choice,
    pub(super) hover: &'a [HoverCost],
    pub(super) source: Source,
    pub(super) command: String,
    pub(super) seed: u64,
    pub(super) quench_evaluations: usize,
    pub(super) warnings: Vec<String>,
}

impl Report<'_> {
    fn grasps(&self) -> usize {
        self.mapped.inputs.len()
    }

    pub(super) fn titles(&self) -> Titles<'static> {
        Titles {
            title: format!(
                "{} grasps, {} hand on {}",
                self.grasps(),
                self.population.hand.name,
                self.population.object.name
            ),
            energy: "energy E(H, O)",
            members: "grasps",
            seed: self.seed,
        }
    }
}

/// The Parquet tables and the manifest.
pub(super) fn tables(report: &Report<'_>) -> anyhow::Result<LandscapeFiles> {
    let edges = report.mapped.edges();
    Ok(LandscapeFiles {
        manifest: manifest(report, edges.len())?,
        minima: report.mapped.minima(),
        edges,
        paths: report.mapped.paths(),
    })
}

fn manifest(report: &Report<'_>, pairs: usize) -> anyhow::Result<Manifest> {
    let landscape = report.mapped.landscape;
    let merges = report.mapped.merges();
    let mut findings: BTreeMap<_, _> = report.mapped.findings(&merges)?.into_iter().collect();
    findings.insert("hover_cost".to_owned(), serde_json::to_value(report.hover)?);
    let method = match report.arrivals {
        Some(_) => "sequential ADELM",
        None => "relaxed connections",
    };
    findings.insert("method".to_owned(), method.into());
    if let Some(arrivals) = report.arrivals {
        findings.insert("arrivals".to_owned(), serde_json::to_value(arrivals)?);
    }
    findings.insert("chosen".to_owned(), report.choice.spell().into());
    if let Some(diagram) = &report.choice.diagram {
        findings.insert(
            "recommended".to_owned(),
            serde_json::to_value(&diagram.recommended)?,
        );
    }
    if let Some(tuning) = &report.choice.tuning {
        findings.insert("tuning".to_owned(), serde_json::to_value(tuning)?);
    }
    findings.insert("rarefaction".to_owned(), report.unseen.to_json()?);
    Ok(Manifest {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        command: report.command.clone(),
        seed: report.seed,
        source: report.source.clone(),
        hand: Some(report.population.hand.clone()),
        object: Some(report.population.object.clone()),
        scale: report.population.scale,
        energy: serde_json::to_value(report.energy.settings())?,
        settings: serde_json::to_value(report.settings)?,
        terms: report.energy.term_names(),
        group_barrier: Some(landscape.groups.barrier),
        counts: Counts {
            grasps: report.grasps() as u64,
            minima: landscape.network.node_count() as u64,
            groups: landscape.groups.members.len() as u64,
            pairs: pairs as u64,
            components: landscape.tree.roots.len() as u64,
            evaluations: (landscape.evaluations
                + report.quench_evaluations
                + report.choice.evaluations()) as u64,
        },
        evidence: landscape
            .tally()
            .into_iter()
            .map(|(evidence, count)| (evidence.name().to_owned(), count as u64))
            .collect(),
        findings,
        warnings: warnings(report, &merges),
    })
}

/// The cost of a hand that touches nothing any more by the strict filter's own measure, 2 mm off the object: what a barrier
/// above it is crossed by is letting go, so that it tells no grasps apart.
pub(super) fn letting_go(hover: &[HoverCost]) -> Option<f64> {
    let cost = hover.first()?.quartiles[1];
    Some(cost.max(0.0)).filter(|_| !cost.is_nan())
}

/// What a reader should know before trusting the landscape.
fn warnings(report: &Report<'_>, merges: &[Merge]) -> Vec<String> {
    let mut warnings = report.warnings.clone();
    let depth = median(merges.iter().map(|merge| merge.depth).collect());
    if let (Some(depth), Some(hover)) = (depth, report.hover.get(1))
        && hover.quartiles[1] < depth
    {
        warnings.push(format!(
            "hovering {:.0} mm off the object costs {:.3}, less than the median merge depth {depth:.3}: barriers \
             measure letting go, not force closure",
            hover.clearance_m * 1e3,
            hover.quartiles[1]
        ));
    }
    let barrier = report.mapped.landscape.groups.barrier;
    if let Some(cost) = letting_go(report.hover).filter(|cost| barrier > *cost) {
        warnings.push(format!(
            "groups join minima over relative barriers up to {barrier:.3}, but hovering {:.0} mm off the object costs only \
             {cost:.3}: a group is whatever can be reached by letting go",
            report.hover[0].clearance_m * 1e3
        ));
    }
    let unrelaxed = merges
        .iter()
        .filter(|merge| merge.evidence > Evidence::Path)
        .count();
    if unrelaxed > 0 {
        warnings.push(format!(
            "{unrelaxed} of {} merges rest on an upper bound (evidence `chain`): drawn dashed, listed in summary.md",
            merges.len()
        ));
    }
    warnings
}

/// `summary.md`, which is also what the terminal shows.
pub(super) fn summary(report: &Report<'_>, files: &LandscapeFiles) -> String {
    let merges = report.mapped.merges();
    let mut lines = overview(report, files, &merges);
    lines.extend(
        files
            .manifest
            .warnings
            .iter()
            .map(|warning| format!("Note: {warning}.\n")),
    );
    lines.extend(not_drawn(files.minima.len()).map(|sentence| format!("Note: {sentence}.\n")));
    lines.extend(largest_groups(&report.mapped));
    lines.extend(upper_bounds(&merges));
    lines.push(format!(
        "\nMade by `{}`, landscape {}.\n",
        files.manifest.command, files.manifest.program_version
    ));
    lines.join("\n")
}

fn overview(report: &Report<'_>, files: &LandscapeFiles, merges: &[Merge]) -> Vec<String> {
    let counts = &files.manifest.counts;
    let spell = |counts: &[(String, usize)]| {
        let parts: Vec<String> = counts
            .iter()
            .map(|(name, n)| format!("{n} {name}"))
            .collect();
        parts.join(", ")
    };
    let barrier = report.mapped.landscape.groups.barrier;
    let rule = if report.arrivals.is_some() {
        format!(
            "assigned one by one, in the order of the grasps, by sequential ADELM; greatest relative raw barrier {barrier:.3}"
        )
    } else {
        let groups = &report.settings.groups;
        let why = match (groups.barrier, groups.highest) {
            (Some(_), _) => "as given with --group-barrier".to_owned(),
            (None, None) => "chosen".to_owned(),
            (None, Some(highest)) => {
                format!("chosen, at most {highest:.3}, the cost of hovering 2 mm off the object")
            }
        };
        format!(
            "minima joined by relaxed connections with relative barrier up to {barrier:.3}: {why}"
        )
    };
    let chain = &report.settings.chain;
    let mut lines = vec![
        format!(
            "# {} grasps of the {} hand on {}\n",
            counts.grasps, report.population.hand.name, report.population.object.name
        ),
        format!(
            "- **{} minima** in **{} groups** ({rule})",
            counts.minima, counts.groups
        ),
        format!(
            "- attraction–diffusion at T = {:.4}, F = αT = {:.0}/m (α = {:.0}/m): {}",
            chain.temperature,
            chain.force,
            chain.alpha(),
            report.choice.spell()
        ),
        format!(
            "- {} pairs connected; no path joins {} component(s) to the rest",
            counts.pairs,
            counts.components - 1
        ),
        format!(
            "- evidence of connections: {}",
            spell(&tally(
                files.edges.iter().map(|edge| edge.evidence.as_str())
            ))
        ),
        format!(
            "- evidence of merges: {}",
            spell(&tally(merges.iter().map(|merge| merge.evidence.name())))
        ),
        format!(
            "- what dominates the tops of merges: {}",
            spell(&tally(
                merges.iter().filter_map(|merge| merge.term.as_deref())
            ))
        ),
    ];
    if let Some(depth) = median(merges.iter().map(|merge| merge.depth).collect()) {
        lines.push(format!("- median merge depth: {depth:.3}"));
    }
    lines.push(report.unseen.line());
    lines.extend(uncertainty::lines(report.mapped.landscape));
    lines.extend(report.hover.iter().map(|hover| {
        format!(
            "- hovering {:.0} mm off the object costs {:.3} (quartiles {:.3} to {:.3}; {:.1} mm reached)",
            hover.clearance_m * 1e3,
            hover.quartiles[1],
            hover.quartiles[0],
            hover.quartiles[2],
            hover.reached_m * 1e3
        )
    }));
    lines.push(format!("- {} energy evaluations\n", counts.evaluations));
    lines
}

fn largest_groups(mapped: &Mapped<'_>) -> Vec<String> {
    let minimum = |id: &MinimumId| &mapped.landscape.network[NodeIndex::new(id.0)];
    let mut groups: Vec<(usize, usize, Vec<usize>, f64)> = mapped
        .landscape
        .groups
        .members
        .iter()
        .enumerate()
        .map(|(group, members)| {
            let rows = members
                .iter()
                .flat_map(|id| minimum(id).members.clone())
                .collect();
            let energies = members.iter().map(|id| minimum(id).energy);
            (
                group,
                members.len(),
                rows,
                energies.fold(f64::INFINITY, f64::min),
            )
        })
        .collect();
    groups.sort_by_key(|(group, _, rows, _)| (std::cmp::Reverse(rows.len()), *group));
    let mut lines = vec![
        "## Largest groups\n".to_owned(),
        "| group | minima | grasps | lowest energy | label |\n|---|---|---|---|---|".to_owned(),
    ];
    lines.extend(
        groups
            .into_iter()
            .take(12)
            .map(|(group, minima, rows, lowest)| {
                format!(
                    "| {group} | {minima} | {} | {lowest:.3} | {} |",
                    rows.len(),
                    mapped.label(&rows).unwrap_or_default()
                )
            }),
    );
    lines
}
