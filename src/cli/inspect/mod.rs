//! `landscape inspect`: how good grasps or bare contacts are.

use std::fmt::Write;

use anyhow::Context;

use super::args::{Common, Inspect};
use super::{print, print_json};

mod contacts;
mod grasps;
mod path;
mod summary;

pub(super) fn run(command: &Inspect, common: &Common) -> anyhow::Result<()> {
    if let Some(ends) = &command.path {
        return path::run(command, ends, common);
    }
    let name = command.file.display();
    anyhow::ensure!(
        !command.file.is_dir(),
        "{name} is a folder: name two minima of a landscape with --path m0 m1, or a file of grasps"
    );
    let bytes = std::fs::read(&command.file).with_context(|| format!("cannot read {name}"))?;
    let first = bytes.trim_ascii_start().first();
    anyhow::ensure!(
        first != Some(&b'['),
        "{name} holds a list: bare contacts are told as {{\"contacts\": [...]}} (see `landscape inspect --help`)"
    );
    if first != Some(&b'{') {
        return grasps::run(command, common);
    }
    let flags = [
        ("--grasp", !command.grasp.is_empty()),
        ("--each", command.each),
        ("--hand", command.of.hand.is_some()),
        ("--object", command.of.object.is_some()),
    ];
    if let Some((flag, _)) = flags.iter().find(|(_, given)| *given) {
        anyhow::bail!("{flag}: {name} holds bare contacts, not grasps");
    }
    let contacts = contacts::Contacts::read(&bytes).with_context(|| format!("{name}"))?;
    let report = contacts.judge();
    if command.json {
        print_json(&report)?;
    } else {
        print(&report.text());
    }
    Ok(())
}

/// Columns aligned: the first to the left, the others to the right.
fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            if column == 0 {
                let _ = write!(line, "{cell:<width$}");
            } else {
                let _ = write!(line, "  {cell:>width$}");
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Four significant digits and no more than that many decimals, powers of ten from ten millions on; `inf` for infinity.
fn number(value: f64) -> String {
    if value.is_infinite() {
        return if value > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    if value.abs() >= 1e7 {
        return format!("{value:.3e}");
    }
    let decimals = match value.abs() {
        size if size < 10.0 => 4,
        size if size < 100.0 => 3,
        size if size < 1000.0 => 2,
        _ => 0,
    };
    let text = format!("{value:.decimals$}");
    // No minus in front of nothing.
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        text.trim_start_matches('-').to_owned()
    } else {
        text
    }
}

fn yes(is: bool) -> &'static str {
    if is { "yes" } else { "no" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_tables() {
        assert_eq!(number(f64::INFINITY), "inf");
        assert_eq!(number(-1e-9), "0.0000");
        assert_eq!(number(-0.12345), "-0.1235");
        assert_eq!(number(123.456), "123.46");
        assert_eq!(number(-123_456_789.0), "-1.235e8");
        let rows = [vec!["μ", "1.5", "x"], vec!["depth", "10.5"]]
            .map(|row| row.into_iter().map(str::to_owned).collect());
        assert_eq!(table(&rows), "μ       1.5  x\ndepth  10.5\n");
    }
}
