//! The texts of reports, made from the same JSON documents that `--json` prints.

use std::fmt::Write;

use serde_json::{Map, Value};

/// Entries for programs only: paths that are named elsewhere, and settings.
const HIDDEN: [&str; 2] = ["wrote", "protocol"];
/// Entries that stand first, in this order. The others follow by name.
const FIRST: [&str; 4] = ["id", "name", "hand", "object"];
/// Greatest number of rows of a table in a text. Of more rows a text has only the number.
const ROWS: usize = 40;
/// Numbers of a list that are smaller than this share of the largest are zero.
const ROUNDING: f64 = 1e-9;
/// Entries of joints that are radians for hinges and metres for slides.
const JOINT_VALUES: [&str; 3] = ["limits", "rest", "deviation"];
/// Longest entry that stands on the line of its name.
const SHORT: usize = 100;

/// Ends of names, and factor and unit of the numbers in texts.
const UNITS: [(&str, f64, &str); 7] = [
    ("_m3", 1e6, " (cm³)"),
    ("_m2", 1e4, " (cm²)"),
    ("_m", 1e3, " (mm)"),
    ("_kg", 1.0, " (kg)"),
    ("_rad", 180.0 / std::f64::consts::PI, " (°)"),
    ("_share", 100.0, " (%)"),
    ("_s", 1.0, " (s)"),
];

/// The text of a document, without the paths of what was written.
pub(super) fn text(document: &Value) -> String {
    let mut text = String::new();
    if let Value::Object(entries) = document {
        block(&mut text, entries, "");
    }
    text
}

fn block(text: &mut String, entries: &Map<String, Value>, indent: &str) {
    let mut shown: Vec<(&String, &Value, Option<String>)> = (entries.iter())
        .filter(|(name, value)| !HIDDEN.contains(&name.as_str()) && !is_empty(value))
        .map(|(name, value)| (name, value, in_line(name, value)))
        .collect();
    let place = |name: &str| FIRST.iter().position(|first| *first == name);
    shown.sort_by_key(|(name, ..)| place(name).unwrap_or(FIRST.len()));
    let width = |(name, ..): &(&String, &Value, Option<String>)| title(name).chars().count();
    let lines = shown.iter().filter(|(.., line)| line.is_some());
    let width = lines.clone().map(width).max().unwrap_or(0);
    for (name, _, line) in lines {
        let line = line.as_deref().unwrap_or_default();
        let _ = writeln!(text, "{indent}{:<width$}  {line}", title(name));
    }
    for (name, value, _) in shown.iter().filter(|(.., line)| line.is_none()) {
        let _ = writeln!(text, "{indent}{}", title(name));
        let below = format!("{indent}  ");
        match value {
            Value::Object(entries) => block(text, entries, &below),
            Value::Array(items) if items.iter().all(Value::is_object) => {
                *text += &indented(&table(items), &below);
            }
            Value::Array(items) => {
                for item in items {
                    let item = in_line(name, item).unwrap_or_else(|| cell(name, item));
                    *text += &indented(&item, &below);
                }
            }
            value => *text += &indented(&cell(name, value), &below),
        }
    }
}

fn indented(text: &str, indent: &str) -> String {
    let lines = text.lines().map(|line| format!("{indent}{line}\n"));
    lines.collect()
}

fn is_empty(value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => items.is_empty(),
        Value::Object(entries) => entries.is_empty(),
        _ => false,
    }
}

/// The name in words, with the unit.
fn title(name: &str) -> String {
    match UNITS.iter().find(|(end, ..)| name.ends_with(end)) {
        Some((end, _, unit)) => name.trim_end_matches(end).replace('_', " ") + unit,
        None => name.replace('_', " "),
    }
}

/// An entry on one line, if it fits there.
fn in_line(name: &str, value: &Value) -> Option<String> {
    let fits = match value {
        Value::Array(items) if items.len() > ROWS => {
            return Some(format!("{} (--json has them)", items.len()));
        }
        Value::Array(items) => !items.iter().any(|item| item.is_object() || item.is_array()),
        Value::Object(entries) => !entries
            .values()
            .any(|item| item.is_object() || item.is_array()),
        _ => true,
    };
    let text = fits.then(|| cell(name, value))?;
    (text.chars().count() <= SHORT && !text.contains('\n')).then_some(text)
}

/// A value in a cell of a table.
fn cell(name: &str, value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::Bool(is) => if *is { "yes" } else { "no" }.to_owned(),
        Value::Number(found) if found.is_f64() => {
            let value = found.as_f64().unwrap_or(f64::NAN);
            match UNITS.iter().find(|(end, ..)| name.ends_with(end)) {
                Some((_, 1.0, _)) | None => number(value),
                Some((_, factor, _)) => trimmed(&format!("{:.2}", factor * value)),
            }
        }
        Value::Number(found) => found.to_string(),
        Value::String(text) => text.clone(),
        Value::Array(items) => {
            let sizes = items.iter().filter_map(|item| Some(item.as_f64()?.abs()));
            let largest = sizes.fold(0.0, f64::max);
            let lost = |item: &Value| {
                item.is_f64()
                    && item.as_f64() < Some(ROUNDING * largest)
                    && item.as_f64() > Some(-ROUNDING * largest)
            };
            let shown = |item: &Value| {
                if lost(item) {
                    "0".to_owned()
                } else {
                    cell(name, item)
                }
            };
            items.iter().map(shown).collect::<Vec<_>>().join(", ")
        }
        Value::Object(entries) => {
            let entries = entries.iter().filter(|(_, value)| !is_empty(value));
            let entries = entries.map(|(name, value)| format!("{name} {}", cell(name, value)));
            entries.collect::<Vec<_>>().join(", ")
        }
    }
}

/// Objects as aligned rows: the id first, then texts, numbers and lists.
pub(super) fn table(rows: &[Value]) -> String {
    let rows: Vec<&Map<String, Value>> = rows.iter().filter_map(Value::as_object).collect();
    let kind = |name: &str| {
        let values = rows.iter().filter_map(|row| row.get(name));
        let known = values.filter(|value| !is_empty(value));
        known
            .map(|value| match value {
                Value::String(_) => 0,
                Value::Array(_) | Value::Object(_) => 2,
                _ => 1,
            })
            .max()
    };
    let names = rows.first().into_iter().flat_map(|row| row.keys());
    let mut columns: Vec<(u8, &String)> =
        names.filter_map(|name| Some((kind(name)?, name))).collect();
    columns.sort_by_key(|(kind, name)| (*name != "id", *kind));
    let head = columns.iter().map(|(_, name)| title(name));
    let mut cells: Vec<Vec<String>> = vec![head.collect()];
    cells.extend(rows.iter().map(|row| {
        let value = |name: &str| row.get(name).unwrap_or(&Value::Null);
        let unit = match value("kind").as_str() {
            Some("hinge") => Some(("_rad", "°")),
            Some("slide") => Some(("_m", "mm")),
            _ => None,
        };
        let row = columns.iter().map(|(_, name)| match unit {
            Some((end, unit)) if JOINT_VALUES.contains(&name.as_str()) => {
                cell(end, value(name)) + " " + unit
            }
            _ => cell(name, value(name)),
        });
        row.collect()
    }));
    let widths: Vec<usize> = (0..columns.len())
        .map(|column| cells.iter().map(|row| row[column].chars().count()).max())
        .map(Option::unwrap_or_default)
        .collect();
    let mut text = String::new();
    for row in cells {
        let mut line = String::new();
        for ((cell, width), (kind, _)) in row.iter().zip(&widths).zip(&columns) {
            let _ = match kind {
                1 => write!(line, "{cell:>width$}  "),
                _ => write!(line, "{cell:<width$}  "),
            };
        }
        text.extend([line.trim_end(), "\n"]);
    }
    text
}

/// A number with four significant digits and at most four decimals, as a power of ten from 10⁷.
fn number(value: f64) -> String {
    if value.abs() >= 1e7 || (value != 0.0 && value.abs() < 5e-5) {
        return format!("{value:.3e}");
    }
    let decimals = match value.abs() {
        size if size < 10.0 => 4,
        size if size < 100.0 => 3,
        size if size < 1000.0 => 2,
        _ => 0,
    };
    trimmed(&format!("{value:.decimals$}"))
}

/// A number without zeros at its end, and zero without a minus sign.
fn trimmed(number: &str) -> String {
    if !number.contains('.') {
        return number.to_owned();
    }
    let short = number.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0" } else { short }.to_owned()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn documents_become_texts() {
        let document = json!({
            "gap_m": 0.00125,
            "label": null,
            "notes": ["one", "two"],
            "rows": [{ "id": 3, "name": "μ", "mass_kg": 0.5 }, { "id": 12, "name": "depth", "mass_kg": null }],
            "stable": true,
            "joints": [{ "kind": "hinge", "limits": [0.0, std::f64::consts::PI] }, { "kind": "slide", "limits": [-1e-20, 0.05] }],
            "normal": [1.0, -1e-17],
            "wrote": ["a.png"],
        });
        let expected = "gap (mm)  1.25\nnormal    1, 0\nnotes     one, two\nstable    yes\njoints\n  kind   limits\n  hinge  0, 180 °\n  \
                        slide  0, 50 mm\nrows\n  id  name   mass (kg)\n   3  μ            0.5\n  12  \
                        depth\n";
        assert_eq!(text(&document), expected);
        let many = json!({ "grasps": vec![document; ROWS + 1] });
        assert_eq!(text(&many), "grasps  41 (--json has them)\n");
    }

    #[test]
    fn numbers_are_short() {
        for (value, short) in [
            (-1e-9, "-1.000e-9"),
            (-0.0, "0"),
            (-0.12345, "-0.1235"),
            (123.456, "123.46"),
            (70.0, "70"),
            (1200.0, "1200"),
            (-123_456_789.0, "-1.235e8"),
        ] {
            assert_eq!(number(value), short);
        }
    }
}
