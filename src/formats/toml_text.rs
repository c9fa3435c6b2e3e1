//! Untrusted TOML: objects, mappings, experiments, protocols, rules of labels.

use serde::de::{DeserializeOwned, Error};
use toml_parser::Source;
use toml_parser::lexer::TokenKind;

/// Greatest length of a text, bytes.
const LONGEST: usize = 1 << 20;
/// Largest depth of nested brackets. The parser overflows its stack at thousands of mismatched nested brackets.
const DEEPEST: usize = 500;

/// Parses TOML.
///
/// # Errors
/// If the text is not TOML, does not describe a `T`, or is far longer or deeper than a text that a human wrote.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, toml::de::Error> {
    if text.len() > LONGEST {
        let problem = format!("it is longer than {} MB", LONGEST >> 20);
        return Err(toml::de::Error::custom(problem));
    }
    let (mut open, mut deepest) = (Vec::new(), 0);
    for token in Source::new(text).lex() {
        match token.kind() {
            TokenKind::LeftSquareBracket => open.push(TokenKind::RightSquareBracket),
            TokenKind::LeftCurlyBracket => open.push(TokenKind::RightCurlyBracket),
            kind if open.last() == Some(&kind) => {
                open.pop();
            }
            _ => {}
        }
        deepest = deepest.max(open.len());
    }
    if deepest > DEEPEST {
        let problem = format!("more than {DEEPEST} brackets are open at once");
        return Err(toml::de::Error::custom(problem));
    }
    toml::from_str(text).map_err(in_plain_words)
}

/// The error, with what was expected instead of the name of its type.
fn in_plain_words(error: toml::de::Error) -> toml::de::Error {
    let shown = error.to_string();
    let Some((found, expected)) = shown.trim_end().rsplit_once("expected ") else {
        return error;
    };
    let expected = match expected {
        "usize" | "u64" | "u32" | "u16" | "u8" => "a whole number that is not negative",
        "i64" | "i32" => "a whole number",
        "f64" | "f32" => "a number",
        other if other.starts_with("struct ") => "a section",
        _ => return error,
    };
    toml::de::Error::custom(format!("{found}expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_told_in_plain_words() {
        #[derive(Debug, serde::Deserialize)]
        struct File {
            #[serde(rename = "count")]
            _count: Option<usize>,
            #[serde(rename = "length")]
            _length: Option<f64>,
            #[serde(rename = "inner")]
            _inner: Option<Box<Self>>,
        }
        let refused = |text: &str| parse::<File>(text).unwrap_err().to_string();
        for (text, words) in [
            (
                "\ncount = 2.5",
                "expected a whole number that is not negative",
            ),
            (
                "\ncount = -1",
                "expected a whole number that is not negative",
            ),
            ("\nlength = \"long\"", "expected a number"),
            ("\ninner = 3", "expected a section"),
        ] {
            let told = refused(text);
            assert!(
                told.trim_end().ends_with(words) && told.contains("line 2"),
                "{told}"
            );
        }
    }

    #[test]
    fn depth_and_length_have_bounds() {
        let refused = |text: &str| parse::<toml::Table>(text).unwrap_err().to_string();
        // Found by fuzzing: brackets that others close, really or in a string.
        for bracket in ["{a=", "[", "[\n", "{a=[}]", "{a=]\n", "[\"]\","] {
            let text = format!("a = {}", bracket.repeat(100_000));
            assert!(refused(&text).contains("brackets"), "{bracket}");
        }
        assert!(refused(&"#".repeat(LONGEST + 1)).contains("longer"));
        let fair = format!("a = {}{}\n", "[".repeat(20), "]".repeat(20));
        assert_eq!(parse::<toml::Table>(&fair).unwrap().len(), 1);
    }
}
