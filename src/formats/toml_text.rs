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
    toml::from_str(text)
}

#[cfg(test)]
mod tests {
    use super::*;

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
