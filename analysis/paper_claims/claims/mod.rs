//! The claims H1 to H10 of one paper about a hand's landscape and the grasp taxonomy. Their thresholds were fixed before
//! the first run (`data/taxonomy/hypotheses.toml`).

mod energies;
mod fisher;
mod heights;
mod report;

use std::error::Error;
use std::fs;
use std::path::Path;

use energies::{Experiments, Lifted, Smooth, Thumbless};
use landscape::agreement::holm;
use landscape::evaluation::taxonomy::Rule;
use landscape::figure::MAKER;
use landscape::store::LandscapeFiles;
use landscape::study::{
    NamedLandscape, StatisticsSettings, TaxonomyComparison, compare_with_taxonomy,
};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

const TEXT: &str = include_str!("../../../data/taxonomy/hypotheses.toml");

/// Why claims cannot be examined.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// Settings of the statistics, and the thresholds of the claims.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ClaimSettings {
    /// Settings of the statistics.
    #[serde(flatten)]
    statistics: StatisticsSettings,
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
    pub(crate) fn standard() -> Self {
        toml::from_str(TEXT).expect("data/taxonomy/hypotheses.toml is complete")
    }
}

/// Verdict on a claim.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
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
pub(crate) struct Finding {
    /// `H1` to `H10`.
    id: &'static str,
    /// Text of the claim.
    claim: String,
    /// Verdict on the claim.
    verdict: Verdict,
    /// p-value of one test.
    p: Option<f64>,
    /// p-value after Holm's correction over all tested claims.
    p_holm: Option<f64>,
    /// Description of the measurement.
    measured: String,
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

/// A landscape of grasps beside the taxonomy, with the findings of the claims.
#[derive(Debug)]
pub(crate) struct Examined<'a> {
    /// Findings for all claims, H1 first.
    findings: Vec<Finding>,
    comparison: TaxonomyComparison<'a>,
    settings: &'a ClaimSettings,
}

impl<'a> Examined<'a> {
    /// Compares a landscape with the taxonomy and examines the claims. p-values are corrected over all claims (Holm).
    pub(crate) fn of(
        landscape: &NamedLandscape<'a>,
        settings: &'a ClaimSettings,
        seed: u64,
    ) -> Result<Self, Failure> {
        let comparison = compare_with_taxonomy(landscape, &settings.statistics, None, seed)?;
        let experiments = Experiments::new(landscape, settings.statistics.least_per_class)?;
        let mut findings = heights::examine(&comparison.basins, settings, landscape.rule, seed);
        findings.push(experiments.smooth(&settings.smooth)?);
        findings.push(experiments.lifted(&settings.lifted)?);
        findings.push(experiments.thumbless(&settings.thumbless)?);
        findings.sort_by_key(|finding| finding.id[1..].parse::<u32>().unwrap_or(u32::MAX));
        let p = findings.iter().map(|finding| finding.p.unwrap_or(f64::NAN));
        let corrected = holm(&p.collect::<Vec<_>>());
        for (finding, p) in findings.iter_mut().zip(corrected) {
            finding.p_holm = (!p.is_nan()).then_some(p);
        }
        Ok(Self {
            findings,
            comparison,
            settings,
        })
    }

    /// Labels, claims and statistics as Markdown.
    pub(crate) fn markdown(&self) -> String {
        report::markdown(self)
    }

    /// The whole comparison as JSON.
    pub(crate) fn to_json(&self) -> Value {
        let mut value = self.comparison.to_json();
        value["settings"] = json!(self.settings);
        value["hypotheses"] = json!(self.findings);
        value
    }
}

/// Examines the landscape in `folder` and writes `NAME.md` and `NAME.json`.
pub(crate) fn write(folder: &Path, name: &str, seed: u64) -> Result<(), Failure> {
    let files = LandscapeFiles::read(folder)?;
    let landscape = NamedLandscape::of(&files, folder, Rule::standard())?;
    let settings = ClaimSettings::standard();
    let examined = Examined::of(&landscape, &settings, seed)?;
    let text = format!("{}\n<!-- Made by {MAKER}. -->\n", examined.markdown());
    fs::write(format!("{name}.md"), text)?;
    fs::write(
        format!("{name}.json"),
        format!("{:#}\n", examined.to_json()),
    )?;
    Ok(())
}
