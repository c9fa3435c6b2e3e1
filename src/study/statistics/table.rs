//! Table of the agreement between heights and labels.

use serde::Serialize;

use super::StatisticsSettings;
use super::basins::{Basins, Part};
use crate::agreement::{
    Correlation, Dendrogram, Outcome, PairMatrix, Permutations, Tested,
    adjusted_mutual_information, adjusted_rand, agreement_of_cuts, anosim_of_ranks, assortativity,
    barrier_ratio, bootstrap, cuts_between, highest, indicator, mantel, morans_i, permanova,
    permdisp, silhouette, test_labels,
};
use crate::evaluation::taxonomy::{Category, Taxonomy};
use crate::figure::chart::{Axis, Chart, Corner, Panel, Series};
use crate::figure::theme;

#[derive(Debug, Clone, Serialize)]
pub(super) struct Row {
    pub(super) name: String,
    /// Description of the statistic and its minima.
    pub(super) about: &'static str,
    pub(super) statistic: Option<f64>,
    /// Value expected by chance.
    pub(super) chance: Option<f64>,
    pub(super) p: Option<f64>,
    /// 95 % over resampled minima.
    pub(super) interval: Option<[f64; 2]>,
    /// Reason why there is no value.
    pub(super) missing: Option<String>,
}

#[derive(Debug)]
pub(super) struct Table {
    pub(super) rows: Vec<Row>,
    /// Adjusted Rand index and mutual information of each cut with the categories, as (clusters, value).
    pub(super) cuts: [(&'static str, Vec<(usize, f64)>); 2],
}

impl Table {
    pub(super) fn chart(&self) -> Chart {
        let series = self.cuts.iter().enumerate().map(|(index, (name, curve))| {
            let points = curve
                .iter()
                .map(|(clusters, value)| [*clusters as f64, *value])
                .collect();
            Series::line(points)
                .named(name)
                .coloured(theme::series(index))
        });
        let values = self.cuts.iter().flat_map(|(_, curve)| curve);
        let lowest = values.map(|(_, value)| *value).fold(-0.1, f64::min);
        let panel = Panel {
            legend: Some(Corner::UpperLeft),
            ..Panel::new(
                "",
                Axis::linear("clusters of the tree"),
                // The full range: 0 is chance, 1 is agreement.
                Axis::linear("adjusted agreement (0 chance, 1 full)").with_range(lowest, 1.0),
                series.collect(),
            )
        };
        Chart {
            panel_size: [900, 560],
            ..Chart::new("", vec![panel])
        }
    }
}

const CATEGORIES: [Category; 3] = [Category::Power, Category::Intermediate, Category::Precision];

struct Asked<'a> {
    part: Part,
    settings: &'a StatisticsSettings,
    permutations: Permutations,
}

impl Asked<'_> {
    fn row(
        &self,
        name: &str,
        about: &'static str,
        statistic: impl Fn(&[usize]) -> f64 + Sync,
    ) -> Row {
        let Part { labels, blocks, .. } = &self.part;
        let tested = test_labels(labels, blocks, &self.permutations, statistic);
        Row::of_categories(name, about, labels, tested)
    }

    /// Like [`Asked::row`], with the 95 % interval over resampled minima.
    fn drawn(
        &self,
        name: &str,
        about: &'static str,
        (matrix, same): (&PairMatrix, f64),
        statistic: impl Fn(&PairMatrix, &[usize]) -> f64 + Sync,
    ) -> Row {
        let Part { labels, blocks, .. } = &self.part;
        let mut row = self.row(name, about, |labels| statistic(matrix, labels));
        if row.statistic.is_some() {
            let draws = self.settings.bootstrap_draws;
            let drawn = bootstrap(blocks, draws, self.permutations.seed, |cases| {
                let labels: Vec<usize> = cases.iter().map(|&i| labels[i]).collect();
                statistic(&matrix.chosen(cases, same), &labels)
            });
            row.interval = Some(drawn.interval(0.95));
        }
        row
    }
}

/// Statistics of the categories, then of the types.
pub(super) fn table(basins: &Basins, settings: &StatisticsSettings, seed: u64) -> Table {
    let part = Part::new(basins, settings, |basin| basin.category);
    let tree = Dendrogram::new(&part.saddles);
    let ranks = part.saddles.ranks();
    let graph = part.graph(basins.family_barrier);
    let cuts = cuts_between(&tree, settings.cuts);
    let curve = |compare| agreement_of_cuts(&tree, &part.labels, settings.cuts, compare);
    let curves = [
        ("Rand index", curve(adjusted_rand)),
        ("mutual information", curve(adjusted_mutual_information)),
    ];
    let asked = Asked {
        part,
        settings,
        permutations: settings.permutations(seed),
    };
    let Part {
        saddles, weights, ..
    } = &asked.part;
    let mut rows = vec![
        asked.row(
            "dendrogram purity",
            "of the categories in the tree",
            |labels| tree.purity(labels, weights),
        ),
        asked.row("ANOSIM R", "saddle heights by category", |labels| {
            anosim_of_ranks(&ranks, labels)
        }),
        asked.row("PERMANOVA F", "saddle heights by category", |labels| {
            permanova(saddles, labels)
        }),
        asked.row(
            "PERMDISP F",
            "unlike spreads of categories, which raise the two above",
            |labels| permdisp(saddles, labels),
        ),
        asked.row(
            "highest adjusted Rand index",
            "of a cut of the tree",
            |labels| highest(&cuts, labels, adjusted_rand),
        ),
        asked.row(
            "highest adjusted mutual information",
            "of a cut of the tree",
            |labels| highest(&cuts, labels, adjusted_mutual_information),
        ),
        asked.drawn(
            "assortativity",
            "of categories on the barrier graph",
            (&graph, 0.0),
            |graph, labels| assortativity(graph, labels).0,
        ),
    ];
    for (class, category) in CATEGORIES.into_iter().enumerate() {
        rows.push(asked.row(
            &format!("Moran's I of {}", category.name()),
            "likeness of neighbours on the barrier graph",
            |labels| morans_i(&graph, &indicator(labels, class)),
        ));
    }
    rows.extend(silhouettes(&asked.part));
    rows.extend(ratios(&asked));
    rows.push(of_types(basins, settings, seed));
    rows.extend(censored(basins, settings, seed));
    Table { rows, cuts: curves }
}

fn silhouettes(part: &Part) -> Vec<Row> {
    let all = silhouette(&part.saddles, &part.labels);
    let row = |(class, category): (usize, Category)| {
        let own = all.iter().zip(&part.labels);
        let own: Vec<f64> = own
            .filter(|(value, label)| **label == class && !value.is_nan())
            .map(|(value, _)| *value)
            .collect();
        Row {
            statistic: (!own.is_empty()).then(|| own.iter().sum::<f64>() / own.len() as f64),
            ..Row::named(
                &format!("mean silhouette of {}", category.name()),
                "on saddle heights",
            )
        }
    };
    CATEGORIES.into_iter().enumerate().map(row).collect()
}

fn ratios(asked: &Asked<'_>) -> Vec<Row> {
    let pairs = [(0, 1), (0, 2), (1, 2)];
    let row = |(a, b): (usize, usize)| {
        let name = format!(
            "barrier ratio {}–{}",
            CATEGORIES[a].name(),
            CATEGORIES[b].name()
        );
        let about = "median relative barrier between over within";
        asked.drawn(
            &name,
            about,
            (&asked.part.barriers, f64::NAN),
            |matrix, labels| barrier_ratio(matrix, labels, [a, b]).ratio,
        )
    };
    pairs.into_iter().map(row).collect()
}

fn typed(basins: &Basins, settings: &StatisticsSettings) -> Part {
    Part::new(basins, settings, |basin| basin.grasp_type.map(usize::from))
}

/// Compares the tree of heights with the taxonomy's tree of types.
fn of_types(basins: &Basins, settings: &StatisticsSettings, seed: u64) -> Row {
    let part = typed(basins, settings);
    let about = "Spearman, saddle heights against the taxonomy's tree of types";
    let row = Row::named("Baker's gamma", about);
    let kinds = part
        .labels
        .iter()
        .collect::<std::collections::BTreeSet<_>>();
    let (cases, needed) = (part.cases.len(), settings.least_per_class);
    let lacking = if cases < needed {
        let there = if cases == 1 { "is" } else { "are" };
        Some(format!(
            "{needed} minima with types are needed, there {there} {cases}"
        ))
    } else {
        (kinds.len() < 2).then(|| {
            format!("two types are needed, but all {cases} minima with a type have the same one")
        })
    };
    if lacking.is_some() {
        return Row {
            missing: lacking,
            ..row
        };
    }
    let types: Vec<_> = part
        .labels
        .iter()
        .filter_map(|number| Taxonomy::feix().numbered(u8::try_from(*number).ok()?))
        .collect();
    let taxonomy = PairMatrix::from_fn(types.len(), |i, j| f64::from(types[i].distance(types[j])));
    let permutations = settings.permutations(seed);
    let tested = mantel(
        &taxonomy,
        &part.saddles,
        Correlation::Spearman,
        &part.blocks,
        &permutations,
    );
    Row::known(&row.name, about, tested)
}

/// The main statistic without unconnected pairs, if there are any.
fn censored(basins: &Basins, settings: &StatisticsSettings, seed: u64) -> Option<Row> {
    if basins.saddles.unknown() == 0 {
        return None;
    }
    let part = Part::new(basins, settings, |basin| basin.category);
    let ranks = basins.saddles.chosen(&part.cases, f64::NAN).ranks();
    let permutations = settings.permutations(seed);
    let tested = test_labels(&part.labels, &part.blocks, &permutations, |labels| {
        anosim_of_ranks(&ranks, labels)
    });
    let about = "saddle heights by category, pairs without a path left out";
    let labels = &part.labels;
    Some(Row::of_categories(
        "ANOSIM R, known pairs",
        about,
        labels,
        tested,
    ))
}

impl Row {
    fn named(name: &str, about: &'static str) -> Self {
        Self {
            name: name.to_owned(),
            about,
            statistic: None,
            chance: None,
            p: None,
            interval: None,
            missing: None,
        }
    }

    fn known(name: &str, about: &'static str, tested: Tested) -> Self {
        Self {
            statistic: Some(tested.statistic),
            chance: Some(tested.chance),
            p: Some(tested.p),
            ..Self::named(name, about)
        }
    }

    /// A test of the categories `labels`.
    fn of_categories(
        name: &str,
        about: &'static str,
        labels: &[usize],
        outcome: Outcome<Tested>,
    ) -> Self {
        match outcome {
            Outcome::Known(tested) => Self::known(name, about, tested),
            Outcome::Insufficient { needed, .. } => Self {
                missing: Some(lacking_categories(labels, needed)),
                ..Self::named(name, about)
            },
        }
    }
}

/// Why the categories cannot be tested.
fn lacking_categories(labels: &[usize], needed: usize) -> String {
    let sizes = CATEGORIES.iter().enumerate().map(|(class, category)| {
        let own = labels.iter().filter(|label| **label == class);
        format!("{} {}", category.name(), own.count())
    });
    format!(
        "two categories are needed, and {needed} minima in each that occurs; here: {}",
        sizes.collect::<Vec<_>>().join(", ")
    )
}
