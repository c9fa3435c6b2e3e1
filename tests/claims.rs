//! Every measured number in the README and in `figures/README.md` comes from a file that a program wrote.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;

/// A sentence of a page with its measured numbers in braces.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    /// The sentence, without line breaks: `firm: {96} %, with σ < 0.0005 m {98} %`.
    says: String,
    /// Source of each number, in order: file (of `figures/`, if it is a bare name), the text that only the number's line of
    /// the file contains, and the index of the number after that text.
    values: Vec<(String, String, usize)>,
}

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path))
        .unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The numbers in a text, as written.
fn numbers(text: &str) -> Vec<&str> {
    text.split(|c: char| !c.is_ascii_digit() && c != '.')
        .map(|word| word.trim_matches('.'))
        .filter(|word| word.parse::<f64>().is_ok())
        .collect()
}

fn decimals(number: &str) -> i32 {
    let after = number.split_once('.').map_or(0, |(_, after)| after.len());
    i32::try_from(after).unwrap()
}

/// Half a unit of the last digit.
fn rounding(number: &str) -> f64 {
    0.5 * 10f64.powi(-decimals(number))
}

/// Whether a stated number is the measured one, or a hundred times it (a percentage), rounded.
fn tells(told: &str, measured: &str) -> bool {
    let [told_value, value] = [told, measured].map(|number| number.parse::<f64>().unwrap());
    [1.0, 100.0].into_iter().any(|factor| {
        let tolerance =
            rounding(told) + factor * rounding(measured) * f64::from(decimals(measured).min(1));
        (factor * value - told_value).abs() <= tolerance * (1.0 + 1e-9)
    })
}

/// The number in a file that a claim refers to.
fn measured<'a>(file: &'a str, (name, fragment, index): &(String, String, usize)) -> &'a str {
    let mut lines = file.lines().filter(|line| line.contains(fragment.as_str()));
    let (Some(line), None) = (lines.next(), lines.next()) else {
        panic!("{name}: one line with `{fragment}` is needed");
    };
    let (_, rest) = line.split_once(fragment.as_str()).unwrap();
    let found = numbers(rest);
    found
        .get(*index)
        .unwrap_or_else(|| panic!("{name}: {} numbers after `{fragment}`", found.len()))
}

#[test]
fn measured_numbers_of_pages_stand_in_the_files_of_programs() {
    let claims: BTreeMap<String, Vec<Claim>> = toml::from_str(&read("tests/claims.toml")).unwrap();
    for (page, claims) in claims {
        let whole = read(&page);
        let mut text = whole.clone();
        for Claim { says, values } in claims {
            let told: Vec<&str> = says
                .split('{')
                .skip(1)
                .map(|rest| rest.split_once('}').unwrap().0)
                .collect();
            assert_eq!(told.len(), values.len(), "{says}");
            for (told, value) in told.into_iter().zip(&values) {
                let file = if value.0.contains('/') {
                    value.0.clone()
                } else {
                    format!("figures/{}", value.0)
                };
                let content = read(&file);
                let measured = measured(&content, value);
                assert!(
                    tells(told, measured),
                    "{page} says {told}, {file} {measured}: {says}"
                );
                assert!(
                    whole.contains(beside(&page, &file)),
                    "{page} does not name {file}, which holds its numbers"
                );
            }
            let sentence = says.replace(['{', '}'], "");
            assert!(text.contains(&sentence), "{page} does not say: {sentence}");
            text = text.replacen(&sentence, "", 1);
        }
        let unguarded: Vec<&str> = text.lines().filter(|line| has_measured(line)).collect();
        assert!(
            unguarded.is_empty(),
            "numbers of {page} that tests/claims.toml does not know: {unguarded:#?}"
        );
    }
}

/// A file as a page in the same folder names it.
fn beside<'a>(page: &str, file: &'a str) -> &'a str {
    let folder = page.rsplit_once('/').map_or("", |(folder, _)| folder);
    file.strip_prefix(folder)
        .and_then(|rest| rest.strip_prefix('/'))
        .unwrap_or(file)
}

/// Whether a line states a share, a p-value or a duration.
fn has_measured(line: &str) -> bool {
    let mut before = None;
    let words = line
        .split([' ', '|', '[', ']', '(', ')', ';'])
        .filter(|word| !word.is_empty());
    for word in words {
        let is_number = |word: &str| word.trim_end_matches(',').parse::<f64>().is_ok();
        let is_unit = ["%", "times", "µs"]
            .iter()
            .any(|unit| word.starts_with(unit));
        let is_share = is_unit && before.is_some_and(is_number);
        if is_share || before == Some("p") && is_number(word) {
            return true;
        }
        before = Some(word);
    }
    false
}

#[test]
fn a_wrong_number_is_found() {
    assert!(tells("96", "95.8") && tells("98", "0.985") && tells("0.17", "0.173"));
    assert!(!tells("95", "95.8") && !tells("97", "0.985") && !tells("0.18", "0.173"));
    assert!(has_measured("holds 66 % of them") && !has_measured("at 100 grasps"));
}
