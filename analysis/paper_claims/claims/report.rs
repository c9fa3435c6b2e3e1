//! Text of the claims.

use std::fmt::Write;

use super::{Examined, Finding};

/// The comparison with the taxonomy, with the claims before the statistics, as Markdown.
pub(super) fn markdown(examined: &Examined<'_>) -> String {
    let comparison = &examined.comparison;
    let mut text = comparison.types();
    text.push_str("\n## Hypotheses\n\n| | claim | verdict | p | p (Holm) | measured |\n|---|---|---|---|---|---|\n");
    for finding in &examined.findings {
        line(&mut text, finding);
    }
    text.push_str(
        "\nThresholds stand in data/taxonomy/hypotheses.toml and were fixed before the first run, but for those of H5, which \
         were rescaled with the rule. A case is a minimum; p by permutation of labels among minima.\n\n## Statistics\n\n",
    );
    text + &comparison.statistics()
}

fn line(text: &mut String, finding: &Finding) {
    let number = |p: Option<f64>| p.map_or(String::new(), |p| format!("{p:.4}"));
    let _ = writeln!(
        text,
        "| {} | {} | {} | {} | {} | {} |",
        finding.id,
        finding.claim,
        finding.verdict.words(),
        number(finding.p),
        number(finding.p_holm),
        finding.measured
    );
}
