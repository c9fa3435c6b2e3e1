//! Looks of the labels of the taxonomy. They are the same in every picture and on every page.

use serde_json::{Map, Value, json};

use crate::evaluation::taxonomy::{Category, Taxonomy};
use crate::figure::{HEART, Hue, Key, Look, Symbol};

/// The looks of all categories, types and cells. The hue tells the category. A category is a disc, and its types have other
/// shades and symbols. A cell, the label of a grasp that several types fit, looks like its first type with a white heart.
pub(super) fn key() -> Key {
    let feix = Taxonomy::feix();
    let hues = [
        (Category::Precision, Hue::Green),
        (Category::Intermediate, Hue::Yellow),
        (Category::Power, Hue::Red),
    ];
    let mut known = Vec::new();
    for (category, hue) in hues {
        known.push((category.name().to_owned(), Look::of_hue(hue, 0)));
        let types = || (feix.types.iter()).filter(|entry| entry.category == category);
        let looks: Vec<_> = types().zip((1..).map(|k| Look::of_hue(hue, k))).collect();
        known.extend((looks.iter()).map(|(entry, look)| (entry.name.clone(), *look)));
        let mut cells: Vec<(String, Look)> = Vec::new();
        for (entry, look) in looks {
            if cells.iter().all(|(cell, _)| *cell != entry.cell) {
                cells.push((entry.cell.clone(), look.opened()));
            }
        }
        known.extend(cells);
    }
    Key {
        known,
        ..Key::default()
    }
}

/// The looks for pages: the corners of the symbols for a radius of 1, the key, and what other labels take in turn.
pub(super) fn packed() -> Value {
    let packed = |look: Look| {
        let [red, green, blue] = look.colour.rgb;
        json!({
            "colour": format!("#{red:02x}{green:02x}{blue:02x}"),
            "symbol": look.symbol.name(),
            "open": look.open,
        })
    };
    let symbols = Symbol::ALL.map(|symbol| {
        let corners = symbol.corners(1.0, 0.0).unwrap_or_default();
        (symbol.name().to_owned(), json!(corners))
    });
    let key = key();
    let entries = |entries: &[(String, Look)]| -> Value {
        let packed = entries
            .iter()
            .map(|(label, look)| json!([label, packed(*look)]));
        packed.collect()
    };
    let in_turn = (0..Look::IN_TURN).map(|number| packed(Look::in_turn(number)));
    json!({
        "symbols": symbols.into_iter().collect::<Map<_, _>>(),
        "heart": HEART,
        "known": entries(&key.known),
        "greys": entries(&key.greys),
        "in_turn": in_turn.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::taxonomy::{NOT_APPLICABLE, UNLISTED};

    #[test]
    fn no_two_labels_of_the_taxonomy_look_alike() {
        let key = key();
        let looks: Vec<_> = key.entries().collect();
        for (k, (label, look)) in looks.iter().enumerate() {
            let twin = looks[..k]
                .iter()
                .find(|(other, own)| own == look || other == label);
            assert_eq!(twin, None, "{label}");
        }
        let feix = Taxonomy::feix();
        let types = feix.types.iter().map(|entry| entry.name.as_str());
        let labels = types
            .chain(feix.cells())
            .chain([UNLISTED, NOT_APPLICABLE, "other"]);
        for label in labels {
            assert!(key.look(label).is_some(), "{label}");
        }
        assert_eq!(looks.len(), 3 + 33 + 17 + 3);
    }

    #[test]
    fn categories_keep_their_look_without_types() {
        for (label, look) in Key::default().entries() {
            assert_eq!(key().look(label), Some(look));
        }
    }
}
