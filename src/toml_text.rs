//! TOML that strangers wrote: objects, mappings, experiments, protocols, signatures.

use serde::de::{DeserializeOwned, Error};

/// Longest text, bytes.
const LONGEST: usize = 1 << 20;
/// Most brackets open at once, those in strings and comments included; at thousands the stack of the parser would overflow.
const DEEPEST: usize = 500;

/// Parses TOML.
///
/// # Errors
/// Where it is no TOML, does not describe a `T`, or is far longer or deeper than a description that a human wrote.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, toml::de::Error> {
    if text.len() > LONGEST {
        let problem = format!("it is longer than {} MB", LONGEST >> 20);
        return Err(toml::de::Error::custom(problem));
    }
    let (mut open, mut deepest) = (0_usize, 0);
    for byte in text.bytes() {
        match byte {
            b'[' | b'{' => open += 1,
            b']' | b'}' => open = open.saturating_sub(1),
            _ => {}
        }
        deepest = deepest.max(open);
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
        for bracket in ["{a=", "[", "[\n"] {
            let text = format!("a = {}", bracket.repeat(100_000));
            assert!(refused(&text).contains("brackets"), "{bracket}");
        }
        assert!(refused(&"#".repeat(LONGEST + 1)).contains("longer"));
        let fair = format!("a = {}{}\n", "[".repeat(20), "]".repeat(20));
        assert_eq!(parse::<toml::Table>(&fair).unwrap().len(), 1);
    }
}
