//! The texts of reports, made from the same JSON documents that `--json` prints.

use std::fmt::Write;

use serde_json::{Map, Value};

/// Entries for programs only: paths that are named elsewhere, settings, hashes, and ids that a note counts.
const HIDDEN: [&str; 4] = ["wrote", "protocol", "content_hash", "repeated"];
/// Counts of what seldom occurs: nothing is said if there is none.
const UNLESS_ZERO: [&str; 3] = ["agreeing", "disagreeing", "left_out"];
/// Entries that stand first, in this order.
const FIRST: &str = "id name measure term link kind part hand object scale format lowest_way_found what_it_is strict_filter \
                     before after height energy start top end human rule agrees mean least 10_% median 90_% greatest size_m \
                     mass_kg mass_given folder limits rest chains grasps found read kept stable reasons \
                     verdicts judged labels categories one_type one_cell one_category category cell type certainty answers \
                     labeller_share labeller_interval_share rule_share rule_interval_share commonest_share gain_share \
                     gain_interval_share";
/// Entries that stand last, in this order.
const LAST: &str = "scales notes preparation_seconds seconds";
/// Greatest number of rows of a table in a text. Of more rows a text has only the number.
const ROWS: usize = 40;
/// Numbers of a list that are smaller than this share of the largest are zero.
const ROUNDING: f64 = 1e-9;
/// Entries of joints that are radians for hinges and metres for slides.
const JOINT_VALUES: [&str; 3] = ["limits", "rest", "deviation"];
/// Longest entry that stands on the line of its name.
const SHORT: usize = 100;

/// Names that say too little to a reader, and what texts call them. The ends give the units.
const NAMES: [(&str, &str); 39] = [
    ("agreeing", "agreeing with a human"),
    ("best", "most probable types"),
    ("bytes", "size_bytes"),
    ("cut_m", "pieces fall short by_m"),
    ("deepest_m", "depth_m"),
    ("deviation", "usual deviation"),
    ("disagreeing", "disagreeing with a human"),
    ("faced_m", "shift toward the fingers_m"),
    ("faces", "direction it faces"),
    ("filled_m", "pieces stand out by_m"),
    ("fingers", "direction of the fingers"),
    ("found", "grasps found"),
    ("gain_interval_share", "interval_share"),
    ("gain_share", "labeller less rule_share"),
    ("high_m", "highest corner_m"),
    ("human", "by a human"),
    ("labeller_interval_share", "interval_share"),
    ("length", "arms divided by"),
    ("low_m", "lowest corner_m"),
    ("most_bytes", "greatest size_bytes"),
    ("one_category", "of one category"),
    ("one_cell", "of one cell"),
    ("one_concavity", "contacts in one hollow"),
    ("one_type", "of one type"),
    ("overlapping", "pieces overlap"),
    ("passes_published", "passes Eq. 11 as printed"),
    ("passes_released", "passes Eq. 11 as in the authors' code"),
    ("passes_strict", "passes the strict filter"),
    ("published", "passes Eq. 11 as printed"),
    ("reasons", "outcomes"),
    ("released", "passes Eq. 11 as in the authors' code"),
    ("rule", "by the rule"),
    ("rule_interval_share", "interval_share"),
    ("self_pairs", "pairs checked for self-penetration"),
    ("strict", "passes the strict filter"),
    (
        "symmetry_deviation_m",
        "deviation from the symmetry found_m",
    ),
    ("thin_share", "thinner than a finger_share"),
    ("violation", "beyond the friction cones"),
    ("volume_error", "volume error_share"),
];

/// Ends of names, and factor and unit of the numbers in texts.
const UNITS: [(&str, f64, &str); 8] = [
    ("_m3", 1e6, " (cm³)"),
    ("_m2", 1e4, " (cm²)"),
    ("_m", 1e3, " (mm)"),
    ("_kg", 1.0, " (kg)"),
    ("_rad", 180.0 / std::f64::consts::PI, " (°)"),
    ("_share", 100.0, " (%)"),
    ("_s", 1.0, " (s)"),
    ("_bytes", 1e-6, " (MB)"),
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
    let shown: Vec<(&String, &Value, Option<String>)> = (ordered(entries).into_iter())
        .map(|(name, value)| (name, value, in_line(name, value)))
        .collect();
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

/// What a reader sees of an object, in the order of reading.
fn ordered(entries: &Map<String, Value>) -> Vec<(&String, &Value)> {
    let none = |name: &str, value: &Value| UNLESS_ZERO.contains(&name) && *value == 0;
    let mut shown: Vec<(&String, &Value)> = (entries.iter())
        .filter(|(name, value)| !is_hidden(name) && !is_empty(value) && !none(name, value))
        .collect();
    shown.sort_by_key(|(name, _)| place(name));
    shown
}

fn is_hidden(name: &str) -> bool {
    HIDDEN.contains(&name)
}

/// Where an entry stands. Those of one place follow by name.
fn place(name: &str) -> (u8, usize) {
    let within = |names: &str| names.split_whitespace().position(|known| known == name);
    let first = within(FIRST).map(|place| (0, place));
    let last = || within(LAST).map(|place| (2, place));
    first.or_else(last).unwrap_or((1, 0))
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
    let (name, _, unit) = measured(name);
    name.replace('_', " ") + unit
}

/// The name of an entry as texts have it, with factor and unit of its numbers.
fn measured(name: &str) -> (&str, f64, &'static str) {
    let plain = NAMES.iter().find(|(known, _)| *known == name);
    let name = plain.map_or(name, |(_, plain)| *plain);
    let of = |(end, factor, unit): &(&str, f64, &'static str)| {
        Some((name.strip_suffix(end)?, *factor, *unit))
    };
    UNITS.iter().find_map(of).unwrap_or((name, 1.0, ""))
}

/// A name in words and a number in the unit of this name.
pub(super) fn in_words(name: &str, value: f64) -> (String, f64) {
    let (_, factor, _) = measured(name);
    (title(name), factor * value)
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
        Value::Number(found) => {
            let value = found.as_f64().unwrap_or(f64::NAN);
            match measured(name) {
                (_, 1.0, _) if found.is_f64() => number(value),
                (_, 1.0, _) => found.to_string(),
                (_, factor, _) => trimmed(&format!("{:.2}", factor * value)),
            }
        }
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
            let entries = ordered(entries).into_iter();
            let entries =
                entries.map(|(name, value)| format!("{} {}", title(name), cell(name, value)));
            entries.collect::<Vec<_>>().join(", ")
        }
    }
}

/// Objects as aligned rows: first what stands first everywhere, then texts, numbers and lists.
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
    let names = names.filter(|name| !is_hidden(name));
    let mut columns: Vec<(u8, &String)> =
        names.filter_map(|name| Some((kind(name)?, name))).collect();
    columns.sort_by_key(|(kind, name)| (place(name), *kind));
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
            "agreeing": 0,
            "bytes": 18_009_540,
            "gap_m": 0.00125,
            "label": null,
            "notes": ["one", "two"],
            "rows": [{ "id": 3, "name": "μ", "mass_kg": 0.5 }, { "id": 12, "name": "depth", "mass_kg": null }],
            "stable": true,
            "strict": 7,
            "joints": [{ "kind": "hinge", "limits": [0.0, std::f64::consts::PI] }, { "kind": "slide", "limits": [-1e-20, 0.05] }],
            "normal": [1.0, -1e-17],
            "terms": { "self_penetration": 0.0, "energy": 0.5 },
            "files": [{ "content_hash": "c0de", "grasps": 2, "rule": "x" }],
            "wrote": ["a.png"],
        });
        let expected = "stable                    yes\nsize (MB)                 18.01\ngap (mm)                  1.25\nnormal  \
                        \x20                 1, 0\npasses the strict filter  7\nterms                     energy 0.5, self \
                        penetration 0\nnotes                     one, two\n";
        let tables = "files\n  by the rule  grasps\n  x                 2\njoints\n  kind   limits\n  hinge  0, 180 °\n  \
                      slide  0, 50 mm\nrows\n  id  name   mass (kg)\n   3  μ            0.5\n  12  depth\n";
        assert_eq!(text(&document), expected.to_owned() + tables);
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
