//! `landscape compare`: a landscape beside the taxonomy of grasps, with statistics; or two landscapes' types beside each other.

mod basins;
mod experiments;
mod hypotheses;
mod report;
mod statistics;

use std::path::{Path, PathBuf};

use anyhow::Context;
use basins::Basins;
use experiments::Experiments;
use hypotheses::Settings;
use serde_json::{Value, json};

use super::args::{Common, Compare};
use super::{check_output, complain, print};
use crate::figure::chart::Chart;
use crate::grasp::taxonomy::Rule;
use crate::store::write_atomic;

pub(super) fn run(command: &Compare, common: &Common) -> anyhow::Result<()> {
    let rule = Rule::standard();
    let settings = Settings::standard()?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => beside(command)?,
    };
    check_output(&output)?;
    let first = Basins::read(&command.landscape, rule)?;
    if let Some(other) = &command.other {
        let other = Basins::read(other, rule)?;
        let (text, value) = report::coverage(&first, &other);
        return finish(&output, &text, &value, None, common);
    }
    let table = statistics::table(&first, &settings, command.seed);
    let experiments = Experiments::new(&command.landscape, rule, settings.least_per_class)?;
    let findings = hypotheses::examine(&first, &experiments, &settings, rule, command.seed)?;
    let text = report::markdown(&first, &table, &findings, rule);
    let value = json!({
        "landscape": first.name,
        "rule": rule.version,
        "settings": settings,
        "seed": command.seed,
        "statistics": table.rows,
        "cuts": table.cuts,
        "hypotheses": findings,
    });
    finish(&output, &text, &value, Some(report::chart(&table)), common)
}

/// `NAME.comparison` beside the landscape.
fn beside(command: &Compare) -> anyhow::Result<PathBuf> {
    let stem = command.landscape.file_stem();
    let stem = stem.with_context(|| format!("{} names no folder", command.landscape.display()))?;
    let name = format!("{}.comparison", stem.to_string_lossy());
    Ok(command.landscape.with_file_name(name))
}

fn finish(
    output: &Path,
    text: &str,
    value: &Value,
    chart: Option<Chart>,
    common: &Common,
) -> anyhow::Result<()> {
    let named = |ending: &str| {
        let mut name = output.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    if let Some(chart) = chart {
        let sheet = chart.draw()?;
        for ending in [".svg", ".png"] {
            sheet.save(&named(ending))?;
        }
    }
    write_atomic(&named(".json"), format!("{value:#}\n").as_bytes())?;
    write_atomic(&named(".md"), text.as_bytes())?;
    if !common.quiet {
        print(text);
        complain(&format!("wrote {}", named(".md").display()));
    }
    Ok(())
}
