//! Labels that a human gives to grasps.

use std::collections::BTreeMap;

use super::human_label;
use crate::evaluation::taxonomy::Taxonomy;
use crate::formats::csv_text;

/// What a table says of the label of one grasp.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GivenLabel {
    /// Id of the grasp.
    pub id: u64,
    /// Name of the type in the taxonomy, or `unlisted`; `None` takes the label of the grasp away.
    pub label: Option<&'static str>,
    /// Line number in the text.
    pub line: usize,
}

/// Reason why a table of labels is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GivenLabelError {
    /// The text is not a table.
    #[error("{0}")]
    Table(String),
    /// A column is missing.
    #[error("column `{0}` is missing: the first line must be `id,label`")]
    NoColumn(&'static str),
    /// The id of a grasp is not a whole number.
    #[error("line {line}: the id `{id}` is not a whole number")]
    Id {
        /// Line number.
        line: usize,
        /// The text of the id.
        id: String,
    },
    /// A grasp is labelled twice.
    #[error("lines {before} and {line} both label grasp {id}")]
    Twice {
        /// Id of the grasp.
        id: u64,
        /// Number of the first line.
        before: usize,
        /// Number of the second line.
        line: usize,
    },
    /// The taxonomy has no such type.
    #[error("line {line}: no grasp type is called `{label}`: {hint}")]
    Unknown {
        /// Line number.
        line: usize,
        /// The label.
        label: String,
        /// What may be meant or is needed.
        hint: String,
    },
}

/// Reads a table (CSV) with the columns `id` and `label`. Other columns are ignored. An empty label takes that of the grasp away.
///
/// # Errors
/// If the text is not such a table, a type is unknown, or a grasp has two rows.
pub fn given_labels(text: &str) -> Result<Vec<GivenLabel>, GivenLabelError> {
    // In some countries spreadsheets use semicolons.
    let header = text.lines().next().unwrap_or_default();
    let delimiter = if header.contains(';') { ';' } else { ',' };
    let (header, records) =
        csv_text::table(text, delimiter, None).map_err(GivenLabelError::Table)?;
    let column = |name| {
        let place = header.iter().position(|header| header == name);
        place.ok_or(GivenLabelError::NoColumn(name))
    };
    let (ids, labels) = (column("id")?, column("label")?);
    let mut seen: BTreeMap<u64, usize> = BTreeMap::new();
    let mut given = Vec::new();
    for (line, fields) in records {
        let (id, label) = (fields[ids].clone(), &fields[labels]);
        let Ok(id) = id.parse() else {
            return Err(GivenLabelError::Id { line, id });
        };
        if let Some(before) = seen.insert(id, line) {
            return Err(GivenLabelError::Twice { id, before, line });
        }
        let label = if label.is_empty() {
            None
        } else {
            let known = human_label(label).ok_or_else(|| unknown(line, label))?;
            Some(known.name())
        };
        given.push(GivenLabel { id, label, line });
    }
    Ok(given)
}

fn unknown(line: usize, label: &str) -> GivenLabelError {
    let wanted = label.to_lowercase();
    let types = Taxonomy::feix().types.iter();
    // Types that share a word.
    let near: Vec<&str> = types
        .map(|entry| entry.name.as_str())
        .filter(|name| {
            let words = name.to_lowercase();
            wanted
                .split_whitespace()
                .any(|word| word.len() > 2 && words.contains(word))
        })
        .collect();
    let hint = if near.is_empty() {
        "a name or number (1 to 33) of the taxonomy or `unlisted` is needed".to_owned()
    } else {
        format!("perhaps {}", near.join(", "))
    };
    let label = label.to_owned();
    GivenLabelError::Unknown { line, label, hint }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_read_by_name_alias_and_number() {
        let text = "\u{feff}note,label,id\n\"a, b\",medium wrap,4\n,\"Sphere 4-Finger\",7\n,14,2\n,,3\n,Unlisted,9\n";
        let given = given_labels(text).unwrap();
        let told: Vec<(u64, Option<&str>)> =
            given.iter().map(|label| (label.id, label.label)).collect();
        let expected = [
            (4, Some("Medium Wrap")),
            (7, Some("Sphere 4 Finger")),
            (2, Some("Tripod")),
            (3, None),
            (9, Some("unlisted")),
        ];
        assert_eq!(told, expected);
        let given = given_labels("id;label\n4;Ring\n").unwrap();
        assert_eq!(given[0].label, Some("Ring"));
        assert_eq!(given_labels("id,label\n").unwrap(), []);
    }

    #[test]
    fn mistakes_name_their_line() {
        let refused = |text: &str| given_labels(text).unwrap_err().to_string();
        assert!(refused("id,type\n").contains("column `label` is missing"));
        assert!(refused("").contains("column `id` is missing"));
        assert!(refused("id,label\n3,Ring\n4,Prismatic\n").contains("line 3"));
        assert!(refused("id,label\n4,Prismatic\n").contains("Prismatic 2 Finger"));
        assert!(refused("id,label\n4,??\n").contains("1 to 33"));
        assert!(refused("id,label\nx,Ring\n").contains("`x` is not a whole number"));
        assert!(refused("id,label\n1,Ring\n1,Ring\n").contains("lines 2 and 3"));
        assert!(refused("id,label\n\n1\n").contains("line 3 has 1 fields"));
        assert!(refused("id,label\n1,\"Ring\n").contains("line 2: a quote"));
    }
}
