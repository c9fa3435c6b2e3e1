//! The claims H1 to H10 of one paper about a hand's landscape and the grasp taxonomy. Their thresholds were fixed before
//! the first run (`data/taxonomy/hypotheses.toml`).

mod energies;
mod heights;
mod report;

use energies::{Experiments, Lifted, Smooth, Thumbless};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::error::StudyError;
use super::statistics::{Basins, NamedLandscape, StatisticsSettings, Table, table};
use crate::agreement::holm;
use crate::evaluation::taxonomy::Rule;
use crate::figure::MAKER;
use crate::figure::chart::Chart;

const TEXT: &str = include_str!("../../../data/taxonomy/hypotheses.toml");

/// Settings of [`compare_with_taxonomy`]: those of the statistics and the thresholds of the claims.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ClaimSettings {
    /// Settings of the statistics.
    #[serde(flatten)]
    pub statistics: StatisticsSettings,
    #[serde(rename = "H1")]
    alike: Alike,
    #[serde(rename = "H2")]
    all: All,
    #[serde(rename = "H3")]
    apart: Apart,
    #[serde(rename = "H4")]
    scattered: Scattered,
    #[serde(rename = "H5")]
    unlisted: Unlisted,
    #[serde(rename = "H6")]
    nearest: Nearest,
    #[serde(rename = "H8")]
    tripods: Tripods,
    #[serde(rename = "H7")]
    smooth: Smooth,
    #[serde(rename = "H9")]
    lifted: Lifted,
    #[serde(rename = "H10")]
    thumbless: Thumbless,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Alike {
    claim: String,
    least_correlation: f64,
    level: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct All {
    claim: String,
    least_share: f64,
    least_minima: usize,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Apart {
    claim: String,
    least_ratio: f64,
    least_anosim: f64,
    level: f64,
    purity_level: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Scattered {
    claim: String,
    level: f64,
    least_minima: usize,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Unlisted {
    claim: String,
    share: [f64; 2],
    other_thresholds: [f64; 2],
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Nearest {
    claim: String,
    spheres: Vec<u8>,
    others: Vec<u8>,
    most_delta: f64,
    level: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tripods {
    claim: String,
    spheres: Vec<u8>,
    near: Vec<u8>,
    most_ratio: f64,
    level: f64,
}

impl ClaimSettings {
    /// The settings that were fixed before the first run.
    ///
    /// # Panics
    /// Never: a test reads the built-in file.
    pub fn standard() -> Self {
        toml::from_str(TEXT).expect("data/taxonomy/hypotheses.toml is complete")
    }
}

/// Verdict on a claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The claim holds.
    Holds,
    /// The claim does not hold.
    Fails,
    /// There are too few minima of a class.
    Insufficient,
    /// The claim is about another hand.
    NotTested,
}

impl Verdict {
    fn of(holds: bool) -> Self {
        if holds { Self::Holds } else { Self::Fails }
    }

    fn words(&self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Insufficient => "insufficient data",
            Self::NotTested => "not tested",
        }
    }
}

/// A claim and its test.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// `H1` to `H10`.
    pub id: &'static str,
    /// Text of the claim.
    pub claim: String,
    /// Verdict on the claim.
    pub verdict: Verdict,
    /// p-value of one test.
    pub p: Option<f64>,
    /// p-value after Holm's correction over all tested claims.
    pub p_holm: Option<f64>,
    /// Description of the measurement.
    pub measured: String,
}

impl Finding {
    fn new(
        id: &'static str,
        claim: &str,
        verdict: Verdict,
        p: Option<f64>,
        measured: String,
    ) -> Self {
        Self {
            id,
            claim: claim.to_owned(),
            verdict,
            p,
            p_holm: None,
            measured,
        }
    }
}

fn insufficient(id: &'static str, claim: &str, why: &str) -> Finding {
    Finding::new(id, claim, Verdict::Insufficient, None, why.to_owned())
}

/// Comparison of a landscape of grasps with the taxonomy.
#[derive(Debug)]
pub struct TaxonomyComparison<'a> {
    /// Findings for all claims, H1 first.
    pub findings: Vec<Finding>,
    basins: Basins,
    table: Table,
    settings: &'a ClaimSettings,
    rule: &'a Rule,
    seed: u64,
}

/// Tests by permutation whether heights between the minima of a landscape correlate with their categories and types, and
/// examines the claims. p-values are corrected over all claims (Holm). `group_barrier` replaces the landscape's own group
/// barrier; `seed` is for permutations and resamplings.
///
/// # Errors
/// If the landscape has no group barrier, or if its energy or a path between two minima is missing or invalid.
pub fn compare_with_taxonomy<'a>(
    landscape: &NamedLandscape<'a>,
    settings: &'a ClaimSettings,
    group_barrier: Option<f64>,
    seed: u64,
) -> Result<TaxonomyComparison<'a>, StudyError> {
    let rule = landscape.rule;
    let basins = Basins::of(landscape, group_barrier)?;
    let table = table(&basins, &settings.statistics, seed);
    let experiments = Experiments::new(landscape, settings.statistics.least_per_class)?;
    let mut findings = heights::examine(&basins, settings, rule, seed);
    findings.push(experiments.smooth(&settings.smooth)?);
    findings.push(experiments.lifted(&settings.lifted)?);
    findings.push(experiments.thumbless(&settings.thumbless)?);
    findings.sort_by_key(|finding| finding.id[1..].parse::<u32>().unwrap_or(u32::MAX));
    let p = findings.iter().map(|finding| finding.p.unwrap_or(f64::NAN));
    let corrected = holm(&p.collect::<Vec<_>>());
    for (finding, p) in findings.iter_mut().zip(corrected) {
        finding.p_holm = (!p.is_nan()).then_some(p);
    }
    Ok(TaxonomyComparison {
        findings,
        basins,
        table,
        settings,
        rule,
        seed,
    })
}

impl TaxonomyComparison<'_> {
    /// Labels, statistics and claims as Markdown.
    pub fn markdown(&self) -> String {
        report::markdown(&self.basins, &self.table, &self.findings, self.rule)
    }

    /// The whole comparison as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "made_by": MAKER,
            "landscape": self.basins.name,
            "rule": self.rule.version,
            "settings": self.settings,
            "seed": self.seed,
            "group_barrier": self.basins.group_barrier,
            "groups": self.basins.groups,
            "statistics": self.table.rows,
            "cuts": self.table.cuts,
            "hypotheses": self.findings,
        })
    }

    /// Chart of the agreement of cuts of the tree with the categories.
    pub fn chart(&self) -> Chart {
        self.table.chart()
    }
}
