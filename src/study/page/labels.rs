//! Labels of the grasps or minima of a page, and the name under which a browser keeps those that are given on it.

use serde_json::{Value, json};

use super::pack::{Pack, Texts};
use crate::evaluation::taxonomy::Category;
use crate::store::content_hash;
use crate::study::names::MinimumName;

/// The labels of all items: as the file has them, and where it has some of a person, those by the rule alone as well, for an
/// item whose label is taken away on the page. Each item has the label of a person, if there is one, and its name. The page asks
/// first for labels of items of low certainty.
pub(super) fn labels(items: &[(Option<&str>, MinimumName)], pack: &mut Pack) -> Value {
    let shown = items
        .iter()
        .map(|(given, name)| (shown_text(*given, name), name));
    let mut told = columns(&shown.collect::<Vec<_>>(), pack);
    let given: Texts = items.iter().map(|(given, _)| given.unwrap_or("")).collect();
    told["given"] = given.packed(pack);
    told["rule"] = items
        .iter()
        .map(|(_, name)| name.rule.best_text())
        .collect();
    let certainties: Vec<f64> = items.iter().map(|(_, name)| certainty(name)).collect();
    told["certainty"] = pack.floats(&certainties);
    if items.iter().any(|(given, _)| given.is_some()) {
        let by_rule: Vec<MinimumName> = (items.iter())
            .map(|(_, name)| MinimumName::new(None, name.rule.clone()))
            .collect();
        let by_rule: Vec<_> = by_rule.iter().map(|name| (name.text(), name)).collect();
        told["by_rule"] = columns(&by_rule, pack);
    }
    told
}

fn columns(names: &[(&str, &MinimumName)], pack: &mut Pack) -> Value {
    let texts: Texts = names.iter().map(|(text, _)| *text).collect();
    let category = |name: &MinimumName| name.category.map_or("", Category::name);
    let categories: Texts = names.iter().map(|(_, name)| category(name)).collect();
    let cells: Texts = names
        .iter()
        .map(|(_, name)| name.cell.as_deref().unwrap_or(""))
        .collect();
    json!({
        "label": texts.packed(pack),
        "category": categories.packed(pack),
        "cell": cells.packed(pack),
        "type": pack.bytes(names.iter().map(|(_, name)| name.number.unwrap_or(0))),
    })
}

/// The probability of the labeller's answer, 0 to 1; 0 if it has none.
fn certainty(name: &MinimumName) -> f64 {
    name.rule.best.first().map_or(0.0, |answer| answer.score)
}

/// The type; for a label of the user that the taxonomy does not know, the label itself.
fn shown_text<'a>(given: Option<&'a str>, name: &'a MinimumName) -> &'a str {
    match given {
        Some(text) if name.number.is_none() && name.cell.is_none() => text,
        _ => name.text(),
    }
}

/// Tells sets of grasps apart by their content. A browser keeps labels under this key, because files of one name, such as
/// `grasps.parquet`, may hold different grasps. Labels and outcomes of simulations are no part of it.
#[derive(Debug, Default)]
pub(super) struct Key(Vec<u8>);

impl Key {
    /// Adds a text: a name, an id, a checksum.
    pub(super) fn text(&mut self, text: &str) {
        self.0.extend((text.len() as u64).to_le_bytes());
        self.0.extend(text.as_bytes());
    }

    /// Adds numbers.
    pub(super) fn numbers(&mut self, numbers: &[f64]) {
        self.0.extend((numbers.len() as u64).to_le_bytes());
        self.0
            .extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    /// The key, in hexadecimal digits.
    pub(super) fn finish(&self) -> String {
        content_hash(&[&self.0])
    }
}
