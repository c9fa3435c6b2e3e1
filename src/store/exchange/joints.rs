//! Matching of a file's joints with those of a hand, by name.

use std::collections::BTreeSet;

use super::listed;

/// For each joint of the hand, the index of its joint in the file.
///
/// Names match if they are equal, or if they are equal without the part before a colon or slash (`robot0:FFJ3`) and without
/// `rh_`, `lh_`, `right_` or `left_`. Every joint of both sides must have exactly one partner, because an additional or
/// missing joint may mean that the same names denote other joints.
pub(super) fn matched(file: &[&str], hand: &[String]) -> Result<Vec<usize>, String> {
    let exact: Option<Vec<usize>> = hand
        .iter()
        .map(|name| file.iter().position(|other| other == name))
        .collect();
    let partners = match exact {
        Some(partners) => partners,
        None => by_bare_name(file, hand)?,
    };
    let used: BTreeSet<usize> = partners.iter().copied().collect();
    let extra: Vec<&str> = (0..file.len())
        .filter(|i| !used.contains(i))
        .map(|i| file[i])
        .collect();
    if !extra.is_empty() {
        return Err(mismatch(file, hand, &[], &extra));
    }
    Ok(partners)
}

fn by_bare_name(file: &[&str], hand: &[String]) -> Result<Vec<usize>, String> {
    let bare_file: Vec<String> = file.iter().map(|name| bare(name)).collect();
    let mut partners = Vec::with_capacity(hand.len());
    let mut missing = Vec::new();
    for name in hand {
        let wanted = bare(name);
        let mut found = (0..file.len()).filter(|&i| bare_file[i] == wanted);
        match (found.next(), found.next()) {
            (Some(place), None) => partners.push(place),
            (Some(_), Some(_)) => {
                return Err(format!(
                    "joint {name} of the hand matches several joints of the file: name them in a mapping"
                ));
            }
            (None, _) => missing.push(name.as_str()),
        }
    }
    if missing.is_empty() {
        return Ok(partners);
    }
    let extra: Vec<&str> = (0..file.len())
        .filter(|i| !partners.contains(i))
        .map(|i| file[i])
        .collect();
    Err(mismatch(file, hand, &missing, &extra))
}

fn mismatch(file: &[&str], hand: &[String], missing: &[&str], extra: &[&str]) -> String {
    let mut parts = Vec::new();
    if !missing.is_empty() {
        let missing = listed(missing.iter().copied());
        parts.push(format!("joints in the hand but not in the file: {missing}"));
    }
    if !extra.is_empty() {
        let extra = listed(extra.iter().copied());
        parts.push(format!("joints in the file but not in the hand: {extra}"));
    }
    let text = format!("its joints are not those of the hand: {}", parts.join("; "));
    let shifted: Vec<String> = file
        .iter()
        .filter_map(|name| counted_up(&bare(name)))
        .collect();
    let own: BTreeSet<String> = hand.iter().map(|name| bare(name)).collect();
    let [up, down] = [
        shifted.len() == own.len() && shifted.iter().all(|name| own.contains(name)),
        {
            let own: Vec<String> = own.iter().filter_map(|name| counted_up(name)).collect();
            own.len() == file.len() && file.iter().all(|name| own.contains(&bare(name)))
        },
    ];
    if !up && !down {
        return text;
    }
    let (zero, one) = if up {
        ("file", "hand")
    } else {
        ("hand", "file")
    };
    format!(
        "{text} (the {zero} counts joints from 0, the {one} from 1: a mapping with `joint_names` can rename them)"
    )
}

/// Whether a joint of the file is one of those that follow others: `hand` has the names of all others.
pub(super) fn follows(name: &str, hand: &[String], following: &[String]) -> bool {
    let is = |other: &String| other == name || bare(other) == bare(name);
    following.iter().any(is) && !hand.iter().any(is)
}

/// A name without its prefixes for the model and the side.
fn bare(name: &str) -> String {
    let name = name
        .rsplit([':', '/'])
        .next()
        .unwrap_or(name)
        .to_lowercase();
    for side in ["rh_", "lh_", "right_", "left_"] {
        if let Some(rest) = name.strip_prefix(side) {
            return rest.to_owned();
        }
    }
    name
}

/// A name whose last digit is increased by one, if it ends in a digit.
fn counted_up(name: &str) -> Option<String> {
    let digit = name.chars().last()?.to_digit(10)?;
    Some(format!("{}{}", &name[..name.len() - 1], digit + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hand(names: &[&str]) -> Vec<String> {
        names.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn names_match_in_any_order() {
        let joints = hand(&["robot0:A1", "robot0:B2"]);
        assert_eq!(
            matched(&["robot0:B2", "robot0:A1"], &joints).unwrap(),
            [1, 0]
        );
        assert_eq!(matched(&["rh_B2", "rh_a1"], &joints).unwrap(), [1, 0]);
    }

    #[test]
    fn mismatches_are_explained() {
        let joints = hand(&["FFJ1", "FFJ2", "FFJ3"]);
        let said = matched(&["FFJ0", "FFJ1", "FFJ2"], &joints).unwrap_err();
        assert!(
            said.contains("not in the file: FFJ3") && said.contains("not in the hand: FFJ0"),
            "{said}"
        );
        assert!(said.contains("the file counts joints from 0"), "{said}");
        let said = matched(&["FFJ1", "FFJ2", "FFJ3", "WRJ"], &joints).unwrap_err();
        assert!(
            said.contains("joints in the file but not in the hand: WRJ"),
            "{said}"
        );
        let said = matched(
            &["a:FFJ1", "b:FFJ1", "FFJ2", "FFJ3"],
            &hand(&["rh_FFJ1", "rh_FFJ2", "rh_FFJ3"]),
        )
        .unwrap_err();
        assert!(said.contains("several"), "{said}");
    }
}
