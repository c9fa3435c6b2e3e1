//! Makes text from files safe to show: a terminal, a picture or a page must show it and never execute its commands.

use std::borrow::Cow;
use std::error::Error;
use std::fmt::Write;

/// Replaces a character that is not passed on.
const REPLACEMENT: char = '\u{fffd}';

/// `text` with � in place of control characters, characters that change the direction of writing or end lines invisibly (N.
/// Boucher and R. Anderson, Trojan Source, 2021), and code points that are not characters. Characters in `kept` stay, for
/// text with line breaks of our own.
pub fn printable<'a>(text: &'a str, kept: &[char]) -> Cow<'a, str> {
    let commands = |c: char| is_command(c) && !kept.contains(&c);
    if text.contains(commands) {
        Cow::Owned(text.replace(commands, REPLACEMENT.encode_utf8(&mut [0; 4])))
    } else {
        Cow::Borrowed(text)
    }
}

/// The text of a JSON document with the same characters escaped, so that its meaning is unchanged.
pub fn printable_json(document: &str) -> String {
    let mut shown = String::with_capacity(document.len());
    for c in document.chars() {
        if is_command(c) && c != '\n' {
            // All these characters have at most sixteen bits.
            write!(shown, "\\u{:04x}", u32::from(c)).expect("text grows without fail");
        } else {
            shown.push(c);
        }
    }
    shown
}

/// A count and its noun: `1 grasp`, `3 grasps`, `2 minima`, `4 searches`, `2 families`.
#[cfg(any(feature = "cli", feature = "topography"))]
pub(crate) fn counted(count: usize, noun: &str) -> String {
    match noun.strip_suffix("minimum") {
        _ if count == 1 => format!("1 {noun}"),
        Some(kind) => format!("{count} {kind}minima"),
        None if noun.ends_with("ch") || noun.ends_with("sh") => format!("{count} {noun}es"),
        None if noun.ends_with("ily") => format!("{count} {}ies", noun.trim_end_matches('y')),
        None => format!("{count} {noun}s"),
    }
}

/// How many there are and their names: `there is 1 family, g0`, `there are 3 minima, m0 to m2`.
#[cfg(feature = "cli")]
pub(crate) fn numbered(count: usize, noun: &str, letter: char) -> String {
    let counted = counted(count, noun);
    match count {
        1 => format!("there is {counted}, {letter}0"),
        _ => format!(
            "there are {counted}, {letter}0 to {letter}{}",
            count.saturating_sub(1)
        ),
    }
}

/// Greatest length of a sentence, in characters.
const LONGEST: usize = 2000;

/// One sentence of an error and its causes, without repetitions. Long quotations from files are cut.
pub fn sentence(error: &dyn Error) -> String {
    let (mut text, mut next) = (String::new(), Some(error));
    while let Some(cause) = next {
        let words = cause.to_string();
        let words = words.trim_end();
        if text.is_empty() {
            words.clone_into(&mut text);
        } else if !text.ends_with(words) {
            text.push_str(": ");
            text.push_str(words);
        }
        next = cause.source();
    }
    let mut short: String = text.chars().take(LONGEST).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    short
}

/// Whether a character is not shown but commands a terminal or the direction of writing, ends lines invisibly, or is none.
pub(crate) fn is_command(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{fffe}' | '\u{ffff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(feature = "cli")]
    fn counts_have_their_nouns() {
        let nouns = ["saddle", "minimum", "search", "lowest minimum", "family"];
        assert_eq!(
            nouns.map(|noun| counted(1, noun)),
            [
                "1 saddle",
                "1 minimum",
                "1 search",
                "1 lowest minimum",
                "1 family"
            ]
        );
        assert_eq!(
            nouns.map(|noun| counted(0, noun)),
            [
                "0 saddles",
                "0 minima",
                "0 searches",
                "0 lowest minima",
                "0 families"
            ]
        );
        assert_eq!(numbered(1, "family", 'g'), "there is 1 family, g0");
        assert_eq!(numbered(3, "minimum", 'm'), "there are 3 minima, m0 to m2");
    }

    #[test]
    fn what_commands_is_replaced_and_all_else_stays() {
        let hostile = "\u{1b}[2J\u{7}\u{9b}31m\u{202e}x\0\n";
        assert_eq!(printable(hostile, &[]), "�[2J��31m�x��");
        assert_eq!(printable("a\n\tb", &['\n', '\t']), "a\n\tb");
        for plain in ["", "Müller–Brown", "שלום \u{200f}עולם", "👩🏽‍🚀", "<!--'\"&"]
        {
            assert!(matches!(printable(plain, &[]), Cow::Borrowed(same) if same == plain));
        }
    }

    #[test]
    fn json_keeps_its_meaning() {
        let value = serde_json::json!({ "a\u{9b}": ["\u{7f}\u{202e}\u{1b}\n", "👩🏽‍🚀"] });
        let shown = printable_json(&format!("{value:#}"));
        assert!(!shown.contains(|c: char| is_command(c) && c != '\n'));
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&shown).unwrap(),
            value
        );
    }
}
