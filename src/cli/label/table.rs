//! Human labels as CSV with the columns `id` and `label`; other columns are ignored.

use std::collections::BTreeMap;
use std::path::Path;

use crate::evaluation::taxonomy::Taxonomy;
use crate::formats::csv_text;
use crate::study::{HumanLabel, human_label};
use anyhow::Context;

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Given {
    pub(super) id: u64,
    /// Name of the type in the taxonomy, or `unlisted`.
    pub(super) label: &'static str,
    /// Line number in the file.
    pub(super) line: usize,
}

/// Reads and checks a file of labels. Rows without a label are ignored.
pub(super) fn read(path: &Path) -> anyhow::Result<Vec<Given>> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--from: cannot read {}", path.display()))?;
    parse(&text).with_context(|| path.display().to_string())
}

fn parse(text: &str) -> anyhow::Result<Vec<Given>> {
    // In some countries spreadsheets use semicolons.
    let header = text.lines().next().unwrap_or_default();
    let delimiter = if header.contains(';') { ';' } else { ',' };
    let (header, records) = csv_text::table(text, delimiter, None).map_err(anyhow::Error::msg)?;
    let column = |name: &str| {
        header
            .iter()
            .position(|header| header == name)
            .with_context(|| {
                format!("there is no column `{name}`: the first line must be `id,label`")
            })
    };
    let (ids, labels) = (column("id")?, column("label")?);
    let mut seen: BTreeMap<u64, usize> = BTreeMap::new();
    let mut given = Vec::new();
    for (line, fields) in records {
        let (id, label) = (&fields[ids], &fields[labels]);
        let id = id
            .parse()
            .ok()
            .with_context(|| format!("line {line}: the id `{id}` is not a whole number"))?;
        if let Some(before) = seen.insert(id, line) {
            anyhow::bail!("lines {before} and {line} both label grasp {id}");
        }
        if label.is_empty() {
            continue;
        }
        let label = human_label(label)
            .map(HumanLabel::name)
            .with_context(|| unknown(line, label))?;
        given.push(Given { id, label, line });
    }
    Ok(given)
}

fn unknown(line: usize, label: &str) -> String {
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
    format!("line {line}: no grasp type is called `{label}`: {hint}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_read_by_name_alias_and_number() {
        let text = "\u{feff}note,label,id\n\"a, b\",medium wrap,4\n,\"Sphere 4-Finger\",7\n,14,2\n,,3\n,Unlisted,9\n";
        let given = parse(text).unwrap();
        let told: Vec<(u64, &str)> = given.iter().map(|label| (label.id, label.label)).collect();
        let expected = [
            (4, "Medium Wrap"),
            (7, "Sphere 4 Finger"),
            (2, "Tripod"),
            (9, "unlisted"),
        ];
        assert_eq!(told, expected);
        assert_eq!(parse("id;label\n4;Ring\n").unwrap()[0].label, "Ring");
        assert_eq!(parse("id,label\n").unwrap(), []);
    }

    #[test]
    fn mistakes_name_their_line() {
        let refused = |text: &str| format!("{:#}", parse(text).unwrap_err());
        assert!(refused("id,type\n").contains("no column `label`"));
        assert!(refused("").contains("no column `id`"));
        assert!(refused("id,label\n3,Ring\n4,Prismatic\n").contains("line 3"));
        assert!(refused("id,label\n4,Prismatic\n").contains("Prismatic 2 Finger"));
        assert!(refused("id,label\n4,??\n").contains("1 to 33"));
        assert!(refused("id,label\nx,Ring\n").contains("`x` is not a whole number"));
        assert!(refused("id,label\n1,Ring\n1,Ring\n").contains("lines 2 and 3"));
        assert!(refused("id,label\n\n1\n").contains("line 3 has 1 fields"));
        assert!(refused("id,label\n1,\"Ring\n").contains("line 2: a quote"));
    }
}
