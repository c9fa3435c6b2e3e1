//! YAML as a tree of texts, lists and maps.
//!
//! Aliases are refused, because with them a small file can describe a very large tree.

use std::collections::BTreeSet;

use saphyr_parser::{Event, Parser, ScalarStyle};

/// Largest depth of nested lists and maps.
const DEEPEST: usize = 64;

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Yaml {
    /// A text, and whether it has quotes, so that it is no number.
    Scalar {
        text: String,
        quoted: bool,
    },
    List(Vec<Self>),
    /// Entries in the order of the file; each name is there once.
    Map(Vec<(String, Self)>),
}

impl Yaml {
    /// The entry of a map with this name.
    pub(crate) fn get(&self, name: &str) -> Option<&Self> {
        let entries = self.entries()?;
        entries
            .iter()
            .find(|(key, _)| key == name)
            .map(|(_, value)| value)
    }

    /// The entries of a map.
    pub(crate) fn entries(&self) -> Option<&[(String, Self)]> {
        match self {
            Self::Map(entries) => Some(entries),
            _ => None,
        }
    }

    /// A text, with or without quotes.
    pub(crate) fn text(&self) -> Option<&str> {
        match self {
            Self::Scalar { text, .. } => Some(text),
            _ => None,
        }
    }

    /// A number without quotes.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            Self::Scalar {
                text,
                quoted: false,
            } => match text.as_str() {
                ".nan" | ".NaN" | ".NAN" => Some(f64::NAN),
                ".inf" | ".Inf" | ".INF" | "+.inf" => Some(f64::INFINITY),
                "-.inf" | "-.Inf" | "-.INF" => Some(f64::NEG_INFINITY),
                // YAML has no other words for numbers, but Rust has.
                text if text.contains(|c: char| c.is_alphabetic() && !"eE".contains(c)) => None,
                text => text.parse().ok(),
            },
            _ => None,
        }
    }

    /// A list of numbers.
    pub(crate) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::List(items) => items.iter().map(Self::number).collect(),
            _ => None,
        }
    }
}

/// A list or map whose end has not been read.
enum Open {
    List(Vec<Yaml>),
    Map {
        entries: Vec<(String, Yaml)>,
        known: BTreeSet<String>,
        key: Option<String>,
    },
}

/// Reads the only document of a text. Errors are half a sentence that states the problem.
pub(crate) fn parse(text: &str) -> Result<Yaml, String> {
    let mut open: Vec<Open> = Vec::new();
    let mut whole = None;
    for event in Parser::new_from_str(text) {
        let (event, _) = event.map_err(|error| format!("it is not valid YAML: {error}"))?;
        let done = match event {
            Event::Scalar(text, style, ..) => Some(Yaml::Scalar {
                text: text.into_owned(),
                quoted: style != ScalarStyle::Plain,
            }),
            Event::SequenceStart(..) => {
                open.push(Open::List(Vec::new()));
                None
            }
            Event::MappingStart(..) => {
                open.push(Open::Map {
                    entries: Vec::new(),
                    known: BTreeSet::new(),
                    key: None,
                });
                None
            }
            Event::SequenceEnd | Event::MappingEnd => open.pop().map(|ended| match ended {
                Open::List(items) => Yaml::List(items),
                Open::Map { entries, .. } => Yaml::Map(entries),
            }),
            Event::Alias(_) => {
                return Err("it refers to a value by its anchor (*name), which is not read: write the value again".to_owned());
            }
            Event::DocumentStart(_) if whole.is_some() => {
                return Err(
                    "it holds several documents (---): write each into its own file".to_owned(),
                );
            }
            _ => None,
        };
        if open.len() > DEEPEST {
            return Err(format!(
                "more than {DEEPEST} lists and maps are nested in it"
            ));
        }
        let Some(done) = done else { continue };
        match open.last_mut() {
            None => whole = Some(done),
            Some(Open::List(items)) => items.push(done),
            Some(Open::Map {
                entries,
                known,
                key,
            }) => match key.take() {
                Some(name) => entries.push((name, done)),
                None => match done {
                    Yaml::Scalar { text, .. } if known.insert(text.clone()) => *key = Some(text),
                    Yaml::Scalar { text, .. } => {
                        return Err(format!("`{text}` is there twice in one map"));
                    }
                    _ => return Err("a name in one of its maps is not a text".to_owned()),
                },
            },
        }
    }
    whole.ok_or_else(|| "it is empty".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_brackets_are_the_same_tree() {
        let block = parse("a:\n  - 1\n  - -2.5e-3\nb: {c: \"1\", d: yes}\n").unwrap();
        assert_eq!(
            block,
            parse("{a: [1, -2.5e-3], b: {c: '1', d: yes}}").unwrap()
        );
        assert_eq!(block.get("a").unwrap().numbers(), Some(vec![1.0, -0.0025]));
        let b = block.get("b").unwrap();
        assert_eq!(b.get("c").unwrap().number(), None);
        assert_eq!(b.get("d").unwrap().text(), Some("yes"));
        for (text, problem) in [
            ("a: &x [1]\nb: *x\n", "anchor"),
            ("a: 1\na: 2\n", "twice"),
            ("--- 1\n--- 2\n", "several documents"),
            ("a: [1", "not valid YAML"),
            ("", "empty"),
        ] {
            let said = parse(text).unwrap_err();
            assert!(said.contains(problem), "{said}");
        }
        let deep = parse(&"[".repeat(100)).unwrap_err();
        assert!(deep.contains("nested"), "{deep}");
    }
}
