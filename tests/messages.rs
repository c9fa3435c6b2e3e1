//! Messages are plain English: no literal of the sources has one of the turns that readers stumble over.

use std::collections::BTreeMap;
use std::path::Path;

use super::architecture::{add_files, before_tests, is_code};

/// Turns that messages do without, in lower case. After a final space, a letter follows: "is not a", "has no" or "without"
/// is meant.
const TURNS: [&str; 8] = [
    "is no ", "are no ", "tell", "tells", "told", "knows", "anew", "but for",
];

/// The string literals of a file before its tests, each with its line.
fn literals(source: &str) -> Vec<(usize, String)> {
    let source = before_tests(source);
    let mut literals = Vec::new();
    let mut place = 0;
    while place < source.len() {
        let rest = &source[place..];
        let line = 1 + source[..place].matches('\n').count();
        let quoted = ["'\"'", r#"'\"'"#]
            .into_iter()
            .find(|quote| rest.starts_with(quote));
        place += if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if let Some(quote) = quoted {
            quote.len()
        } else if let Some((text, end)) = raw(rest) {
            literals.push((line, text.to_owned()));
            end
        } else if rest.starts_with('"') {
            let end = closing(rest);
            literals.push((line, unescaped(&rest[1..end])));
            end + 1
        } else {
            rest.chars().next().map_or(1, char::len_utf8)
        };
    }
    literals
}

/// Content and length of the raw literal that a text begins with.
fn raw(text: &str) -> Option<(&str, usize)> {
    let rest = text.strip_prefix('r')?;
    let marks = rest.len() - rest.trim_start_matches('#').len();
    let content = rest[marks..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(marks));
    let content = &content[..content.find(&end)?];
    Some((content, 2 + marks + content.len() + end.len()))
}

/// Place of the quotation mark that closes the literal.
fn closing(text: &str) -> usize {
    let mut escaped = false;
    let after = &text[1..];
    let end = after.find(|letter| {
        let ends = letter == '"' && !escaped;
        escaped = letter == '\\' && !escaped;
        ends
    });
    1 + end.unwrap()
}

/// The literal as it is read, but with a space for each escaped character.
fn unescaped(literal: &str) -> String {
    let mut text = String::new();
    let mut letters = literal.chars().peekable();
    while let Some(letter) = letters.next() {
        if letter != '\\' {
            text.push(letter);
        } else if letters.next() == Some('\n') {
            while letters.next_if(|next| next.is_whitespace()).is_some() {}
        } else {
            text.push(' ');
        }
    }
    text
}

/// The words of a literal in lower case: without what is put in for values, and with single spaces.
fn words(literal: &str) -> String {
    let mut text = String::new();
    let mut rest = literal;
    while let Some((before, after)) = rest.split_once('{') {
        text.push_str(before);
        let value = after.split_once('}');
        let value = value.filter(|(name, _)| !name.contains([' ', '\n', '{']));
        if let Some((_, after)) = value {
            text.push('…');
            rest = after;
        } else {
            text.push('{');
            rest = after;
        }
    }
    text.push_str(rest);
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").to_lowercase()
}

/// The turns that a literal has.
fn turns(literal: &str) -> Vec<&'static str> {
    let text = words(literal);
    let part_of_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    let has = |turn: &&str| {
        text.match_indices(*turn).any(|(place, _)| {
            let before = text[..place].chars().next_back();
            let after = text[place + turn.len()..].chars().next();
            let ends = if turn.ends_with(' ') {
                after.is_some_and(|letter| letter.is_ascii_lowercase())
            } else {
                !after.is_some_and(part_of_word)
            };
            ends && !before.is_some_and(part_of_word)
        })
    };
    TURNS.into_iter().filter(has).collect()
}

#[test]
fn messages_are_plain() {
    let mut files = BTreeMap::new();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    add_files(&sources, "", &mut files);
    files.retain(|path, _| is_code(path));
    let (mut read, mut found) = (0, Vec::new());
    for (path, source) in &files {
        for (line, literal) in literals(source) {
            read += 1;
            let turns = turns(&literal);
            found.extend(
                turns
                    .iter()
                    .map(|turn| format!("{path}:{line}: \"{turn}\": {literal}")),
            );
        }
    }
    assert!(read > 4000, "only {read} literals were read");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn turns_are_found() {
    let source = r##"
        #[error("{told} \
                 tells it")]
        fn a<'a>(quote: char, of: &'a str) {
            // "knows"
            let quote = ['"', '\'', '\\', 'é'];
            let known = r#"this "is no
                file"#;
            let fine = "there is no \u{2014} {anew:?} teller {{";
        }
        const LAST: &str = "Are no \"words\", are no words anew";
#[cfg(test)]
mod tests {
    const A: &str = "told";
"##;
    let found = literals(source);
    assert_eq!(found.len(), 4, "{found:?}");
    let found = found.iter().flat_map(|(line, literal)| {
        let turns = turns(literal).into_iter();
        turns.map(move |turn| (*line, turn))
    });
    let found: Vec<(usize, &str)> = found.collect();
    assert_eq!(
        found,
        [(2, "tells"), (7, "is no "), (11, "are no "), (11, "anew")]
    );
}
