//! Messages are plain English: no literal of the sources has one of the turns that readers stumble over.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::architecture::add_files;

/// Turns that messages do without, in lower case. After a final space, a letter follows: "is not a", "has no" or "without"
/// is meant.
const TURNS: [&str; 8] = [
    "is no ", "are no ", "tell", "tells", "told", "knows", "anew", "but for",
];

/// The literals of a file outside of comments and of items that only tests compile, each with its line; names of such
/// modules in files of their own are added to `tests`.
fn literals(source: &str, tests: &mut Vec<String>) -> Vec<(usize, String)> {
    let mut literals = Vec::new();
    // Number of open brackets since the beginning of an item of tests.
    let mut item: Option<(usize, usize)> = None;
    let mut place = 0;
    while place < source.len() {
        let rest = &source[place..];
        let letter = rest.chars().next().unwrap();
        let within_word = source[..place]
            .chars()
            .next_back()
            .is_some_and(|c| c.is_alphanumeric() || c == '_');
        let mut length = letter.len_utf8();
        if rest.starts_with("//") {
            length = rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            length = comment(rest);
        } else if let Some((text, end)) = raw(rest).filter(|_| !within_word) {
            if item.is_none() {
                literals.push((line(source, place), text.to_owned()));
            }
            length = end;
        } else if letter == '"' {
            let end = closing(rest);
            if item.is_none() {
                literals.push((line(source, place), unescaped(&rest[1..end])));
            }
            length = end + 1;
        } else if letter == '\'' {
            length = character(rest);
        } else if item.is_none()
            && (rest.starts_with("#[cfg(test)]") || rest.starts_with("#[cfg(all(test"))
        {
            length = rest.find(']').unwrap() + 1;
            item = Some((0, place + length));
        } else if let Some((depth, start)) = item {
            item = match letter {
                '(' | '[' | '{' => Some((depth + 1, start)),
                '}' if depth <= 1 => None,
                ')' | ']' | '}' => Some((depth.saturating_sub(1), start)),
                ';' if depth == 0 => {
                    let name = source[start..place].rsplit_once("mod ");
                    tests.extend(name.map(|(_, name)| name.to_owned()));
                    None
                }
                _ => item,
            };
        }
        place += length;
    }
    literals
}

/// The number of the line of a place.
fn line(source: &str, place: usize) -> usize {
    1 + source[..place].matches('\n').count()
}

/// Length of the block comment that a text begins with.
fn comment(text: &str) -> usize {
    let (mut depth, mut place) = (0, 0);
    loop {
        let rest = &text[place..];
        if rest.starts_with("/*") {
            (depth, place) = (depth + 1, place + 2);
        } else if rest.starts_with("*/") {
            (depth, place) = (depth - 1, place + 2);
        } else {
            place += rest.chars().next().map_or(1, char::len_utf8);
        }
        if depth == 0 || place >= text.len() {
            return place.min(text.len());
        }
    }
}

/// Content and length of the raw literal that a text begins with.
fn raw(text: &str) -> Option<(&str, usize)> {
    let rest = text.strip_prefix("br").or_else(|| text.strip_prefix('r'))?;
    let marks = rest.len() - rest.trim_start_matches('#').len();
    let content = rest[marks..].strip_prefix('"')?;
    let end = format!("\"{}", "#".repeat(marks));
    let content = &content[..content.find(&end)?];
    let head = text.len() - rest.len() + marks + 1;
    Some((content, head + content.len() + end.len()))
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

/// Length of the character that a text begins with, or of the mark of a lifetime.
fn character(text: &str) -> usize {
    let mut letters = text[1..].char_indices();
    let end = match (letters.next(), letters.next()) {
        (Some((_, '\\')), Some((place, escaped))) => {
            let place = place + escaped.len_utf8();
            text[1 + place..].find('\'').map(|more| place + more)
        }
        (Some(_), Some((place, '\''))) => Some(place),
        _ => None,
    };
    end.map_or(1, |end| end + 2)
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

/// The number of literals of `files` (paths below `src`, and texts) outside of tests, and those with a turn.
fn faults(files: &BTreeMap<String, String>) -> (usize, Vec<String>) {
    let mut tests = Vec::new();
    let mut all = Vec::new();
    let is_rust = |path: &str| {
        Path::new(path)
            .extension()
            .is_some_and(|ending| ending == "rs")
    };
    for (path, source) in files.iter().filter(|(path, _)| is_rust(path)) {
        let folder = path.strip_suffix("mod.rs").map_or_else(
            || format!("{}/", path.trim_end_matches(".rs")),
            str::to_owned,
        );
        let mut modules = Vec::new();
        let found = literals(source, &mut modules);
        all.extend(found.into_iter().map(|found| (path, found)));
        tests.extend(modules.into_iter().map(|name| folder.clone() + &name));
    }
    all.retain(|(path, _)| {
        let below = |test: &String| path.strip_prefix(test.as_str());
        !(tests.iter().filter_map(below)).any(|rest| rest == ".rs" || rest.starts_with('/'))
    });
    let faults = all.iter().flat_map(|(path, (line, literal))| {
        let found = turns(literal).into_iter();
        found.map(move |turn| format!("{path}:{line}: \"{}\": {literal}", turn.trim_end()))
    });
    (all.len(), faults.collect())
}

#[test]
fn messages_are_plain() {
    let mut files = BTreeMap::new();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    assert!(fs::exists(sources.join("cli/mod.rs")).unwrap());
    add_files(&sources, "", &mut files);
    let (read, found) = faults(&files);
    assert!(read > 4000, "only {read} literals were read");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn turns_are_found() {
    let long = r##"
        #[error("{told} \
                 tells it")]
        fn a<'a>(quote: char, of: &'a str) {
            // "knows"
            let quote = ['"', '\'', '\\', 'é'];
            let known = r#"this "is no
                file"#;
            /* "told" /* "told" */ "told" */
            let b = b"but for \"this\"";
            let fine = "there is no \u{2014} {anew:?} teller {{";
        }
        #[cfg(test)]
        const MARKS: [u8; 2] = *b"told";
        #[cfg(test)]
        mod tests {
            const A: &str = "} told";
        }
        const LAST: &str = "Are no \"words\", are no words anew";
    "##;
    let files = [
        ("long.rs", long),
        (
            "part/mod.rs",
            "#[cfg(test)]\n#[path = \"b.rs\"]\nmod tests;\nmod b;",
        ),
        ("part/tests.rs", "const A: &str = \"told\";"),
        ("part/b.rs", "const A: &str = \"told\";"),
        ("part/b.js", "\"told"),
    ];
    let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let (read, found) = faults(&BTreeMap::from(files));
    assert_eq!(read, 6);
    let found: Vec<&str> = found
        .iter()
        .map(|fault| fault.split_once("\": ").unwrap().0)
        .collect();
    let expected = [
        "long.rs:2: \"tells",
        "long.rs:7: \"is no",
        "long.rs:10: \"but for",
        "long.rs:19: \"are no",
        "long.rs:19: \"anew",
        "part/b.rs:1: \"told",
    ];
    assert_eq!(found, expected);
}
