//! The claims of one paper about a hand's landscape and the grasp taxonomy. Their thresholds were fixed before the first run
//! (`data/taxonomy/hypotheses.toml`).

mod energies;
mod heights;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::agreement::holm;
use landscape::evaluation::taxonomy::Rule;
use landscape::figure::MAKER;
use landscape::store::LandscapeFiles;
use landscape::study::{NamedLandscape, StatisticsSettings, compare_with_taxonomy};
use serde::Deserialize;
use toml::Value;

const TEXT: &str = include_str!("../../../data/taxonomy/hypotheses.toml");

/// Why claims cannot be examined.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// A claim with its thresholds.
#[derive(Debug, Clone, Deserialize)]
struct Claim {
    /// `H1` to `H10`.
    #[serde(skip)]
    id: String,
    #[serde(rename = "claim")]
    text: String,
    #[serde(flatten)]
    thresholds: BTreeMap<String, Value>,
}

impl Claim {
    fn number(&self, threshold: &str) -> f64 {
        float(&self.thresholds[threshold])
    }

    fn pair(&self, thresholds: &str) -> [f64; 2] {
        [0, 1].map(|place| float(&self.thresholds[thresholds][place]))
    }

    /// Whether a list of grasp types has this one.
    fn has(&self, list: &str, number: Option<u8>) -> bool {
        let types = self.thresholds[list].as_array();
        (types.into_iter().flatten()).any(|entry| entry.as_integer() == number.map(i64::from))
    }

    fn finding(&self, verdict: Verdict, p: Option<f64>, measured: String) -> Finding {
        Finding {
            id: self.id.clone(),
            claim: self.text.clone(),
            verdict,
            p,
            measured,
        }
    }

    fn insufficient(&self, why: &str) -> Finding {
        self.finding(Verdict::Insufficient, None, why.to_owned())
    }
}

fn float(value: &Value) -> f64 {
    let whole = || value.as_integer().map(|number| number as f64);
    (value.as_float().or_else(whole)).expect("data/taxonomy/hypotheses.toml has a number there")
}

/// The claims, and settings of the statistics.
#[derive(Debug, Clone)]
pub(crate) struct Claims {
    all: BTreeMap<String, Claim>,
    statistics: StatisticsSettings,
}

impl Claims {
    /// The claims with the thresholds that were fixed before the first run.
    pub(crate) fn standard() -> Self {
        let read: BTreeMap<String, Claim> =
            toml::from_str(TEXT).expect("data/taxonomy/hypotheses.toml is complete");
        let named = |(id, claim): (String, Claim)| (id.clone(), Claim { id, ..claim });
        Self {
            all: read.into_iter().map(named).collect(),
            statistics: StatisticsSettings::default(),
        }
    }

    fn get(&self, id: &str) -> &Claim {
        &self.all[id]
    }
}

/// Verdict on a claim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    Holds,
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
}

/// A claim and its test.
#[derive(Debug, Clone)]
pub(crate) struct Finding {
    id: String,
    claim: String,
    verdict: Verdict,
    /// p-value of one test.
    p: Option<f64>,
    /// Description of the measurement.
    measured: String,
}

/// Examines the landscape in `folder` and writes `NAME.md`: labels, claims and statistics. p-values are corrected over all
/// claims (Holm).
pub(crate) fn write(folder: &Path, name: &str, seed: u64) -> Result<(), Failure> {
    let files = LandscapeFiles::read(folder)?;
    let landscape = NamedLandscape::of(&files, folder, Rule::standard())?;
    let claims = Claims::standard();
    let comparison = compare_with_taxonomy(&landscape, &claims.statistics, None, seed)?;
    let mut findings = heights::examine(&comparison.basins, &claims, landscape.rule, seed);
    findings.extend(energies::examine(&landscape, &claims)?);
    let p = findings.iter().map(|finding| finding.p.unwrap_or(f64::NAN));
    let corrected = holm(&p.collect::<Vec<_>>());
    let mut text = comparison.types();
    text.push_str(
        "\n## Hypotheses\n\n| | claim | verdict | p | p (Holm) | measured |\n|---|---|---|---|---|---|\n",
    );
    for (finding, holm) in findings.iter().zip(corrected) {
        let number = |p: Option<f64>| p.map_or(String::new(), |p| format!("{p:.4}"));
        let verdict = match finding.verdict {
            Verdict::Holds => "holds",
            Verdict::Fails => "does not hold",
            Verdict::Insufficient => "insufficient data",
            Verdict::NotTested => "not tested",
        };
        writeln!(
            text,
            "| {} | {} | {verdict} | {} | {} | {} |",
            finding.id,
            finding.claim,
            number(finding.p),
            number(Some(holm).filter(|p| !p.is_nan())),
            finding.measured
        )?;
    }
    text.push_str(
        "\nThresholds stand in data/taxonomy/hypotheses.toml and were fixed before the first run, but for those of H5, which \
         were rescaled with the rule. A case is a minimum; p by permutation of labels among minima.\n\n## Statistics\n\n",
    );
    text += &comparison.statistics();
    fs::write(
        format!("{name}.md"),
        format!("{text}\n<!-- Made by {MAKER}. -->\n"),
    )?;
    Ok(())
}
