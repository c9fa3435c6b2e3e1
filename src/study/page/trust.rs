//! How far a landscape is to be trusted, in plain words.

use serde_json::{Value, json};

use crate::printable::counted;
use crate::store::{LandscapeFiles, Manifest};
use crate::study::uncertainty::share_known;
use crate::topography::{Attempts, Evidence, Searched, Tree};

/// A merge is well supported if the chance that a lower way exists is at most 1 − this.
const WELL: f64 = 0.95;
/// It is doubtful below this support.
const DOUBTFUL: f64 = 0.7;

/// A statement about trust.
pub(super) struct Statement {
    /// `good`, `care` or `warning`.
    pub(super) tone: &'static str,
    /// A few words.
    pub(super) short: String,
    /// Sentences for someone who meets these notions for the first time.
    pub(super) long: String,
}

/// Statements as entries of the header.
pub(super) fn told(statements: Vec<Statement>) -> Value {
    let told = statements.into_iter().map(
        |Statement { tone, short, long }| json!({ "tone": tone, "short": short, "long": long }),
    );
    told.collect()
}

/// All statements about a landscape, the most important first.
pub(super) fn statements(files: &LandscapeFiles, tree: &Tree, attempts: &Attempts) -> Value {
    let manifest = &files.manifest;
    let mut statements = Vec::new();
    statements.extend(passes(tree));
    statements.extend(supported(tree, attempts));
    statements.extend(unseen(manifest));
    statements.extend(searched(manifest));
    statements.extend(apart(tree));
    statements.extend(notes(&manifest.warnings));
    told(statements)
}

/// What the program noted while it worked.
fn notes(notes: &[String]) -> Option<Statement> {
    let told: Vec<String> = notes.iter().map(|note| sentence(note)).collect();
    (!notes.is_empty()).then(|| Statement {
        tone: "warning",
        short: match notes.len() {
            1 => "a note of the program".to_owned(),
            several => format!("{several} notes of the program"),
        },
        long: told.join(" "),
    })
}

/// A sentence from a note, which begins with a small letter and has no full stop.
fn sentence(note: &str) -> String {
    let mut letters = note.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// On what the heights of the merges rest.
fn passes(tree: &Tree) -> Option<Statement> {
    let merges: Vec<Evidence> = (tree.nodes.iter())
        .filter(|node| node.minimum.is_none())
        .map(|node| node.evidence)
        .collect();
    if merges.is_empty() {
        return None;
    }
    let of = |kinds: &[Evidence]| merges.iter().filter(|kind| kinds.contains(kind)).count();
    let (verified, given) = (of(&[Evidence::Saddle]), of(&[Evidence::Given]));
    let (relaxed, bounds) = (
        of(&[Evidence::Path]),
        of(&[Evidence::Chain, Evidence::None]),
    );
    let all = merges.len();
    let checked = "the slope is zero there, and both sides lead down to the two minima";
    let mut long = format!(
        "Two branches of the tree meet at the energy of the lowest pass that was found between them. {}. A pass that was not \
         found may be lower still.",
        match (verified, all) {
            (0, _) => "None was verified".to_owned(),
            (1, 1) => format!("It is verified: {checked}"),
            (1, _) => format!("1 of the {all} passes is verified: {checked}"),
            _ if verified == all => format!("All {all} passes are verified: {checked}"),
            _ => format!("{verified} of the {all} passes are verified: {checked}"),
        },
    );
    // What there is none of is not mentioned.
    for (count, one, several) in [
        (
            relaxed,
            "is the top of a relaxed path",
            "are the tops of relaxed paths",
        ),
        (
            bounds,
            "is an upper bound: its pass may lie lower (dashed lines)",
            "are upper bounds: their passes may lie lower (dashed lines)",
        ),
        (
            given,
            "is a transition state of another program, not verified here",
            "are transition states of another program, not verified here",
        ),
    ] {
        match count {
            0 => {}
            1 => long.extend([" One ", one, "."]),
            _ => long.extend([" ", &count.to_string(), " ", several, "."]),
        }
    }
    Some(Statement {
        tone: if bounds + given == 0 { "good" } else { "care" },
        short: format!("{verified} of {} verified", passes_of(all)),
        long,
    })
}

/// `1 pass`, `3 passes`.
fn passes_of(count: usize) -> String {
    if count == 1 {
        "1 pass".to_owned()
    } else {
        format!("{count} passes")
    }
}

/// How well searches support the merges.
fn supported(tree: &Tree, attempts: &Attempts) -> Option<Statement> {
    let found = attempts.of_merges(tree);
    let merges = tree
        .nodes
        .iter()
        .filter(|node| !node.children.is_empty())
        .count();
    let known: Vec<f64> = (found.iter().flatten()).map(Searched::support).collect();
    if known.is_empty() {
        return None;
    }
    let well = known.iter().filter(|share| **share >= WELL).count();
    let doubtful = known.iter().filter(|share| **share < DOUBTFUL).count() + merges - known.len();
    Some(Statement {
        tone: if doubtful == 0 { "good" } else { "care" },
        short: format!("{well} of {merges} heights well supported"),
        long: format!(
            "Each join was searched again by independent chains, which were free to find a lower way. The more often they end \
             at the same height and find nothing lower, the less likely a lower way is. For {well} of the {} the chance that a \
             lower way exists is at most {:.0} %{}.",
            counted(merges, "join"),
            100.0 * (1.0 - WELL),
            match doubtful {
                0 => String::new(),
                _ => format!(
                    "; for {doubtful} it is more than {:.0} %, or no search crossed the merge (hollow dots): {} may be lower",
                    100.0 * (1.0 - DOUBTFUL),
                    if doubtful == 1 { "that one" } else { "those" }
                ),
            }
        ),
    })
}

/// Families that the grasps did not show.
fn unseen(manifest: &Manifest) -> Option<Statement> {
    manifest.hand.as_ref()?;
    let families = &manifest.findings.get("rarefaction")?["families"];
    let number = |name: &str| families[name].as_f64();
    let interval = &families["unseen_interval"];
    let (Some(unseen), Some(coverage), Some(members)) =
        (number("unseen"), number("coverage"), number("members"))
    else {
        return Some(Statement {
            tone: "care",
            short: "too few grasps to estimate what is missing".to_owned(),
            long: "With so few grasps, the number of unseen families cannot be estimated."
                .to_owned(),
        });
    };
    let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap_or(f64::NAN));
    let kind = ["family", "families"];
    Some(missing(kind, [unseen, low, high], coverage, members))
}

/// How many kinds of grasps were probably never met: the name of a kind and its plural, the estimate with its interval, the
/// coverage, and the number of grasps.
pub(super) fn missing(
    [kind, kinds]: [&str; 2],
    [unseen, low, high]: [f64; 3],
    coverage: f64,
    grasps: f64,
) -> Statement {
    let none = unseen < 0.5;
    Statement {
        tone: if none || high < 1.0 { "good" } else { "care" },
        short: if none {
            format!("probably no {kind} unseen")
        } else {
            format!(
                "about {unseen:.0} {} unseen",
                if unseen < 1.5 { kind } else { kinds }
            )
        },
        long: format!(
            "From how many {kinds} were met once or twice one can estimate how many were never met: {}. One more grasp falls \
             into a known {kind} with a chance of {} %. This takes the grasps for independent draws.",
            if high < 0.5 {
                "probably none".to_owned()
            } else if none {
                format!("probably none (at most {high:.0}, with 95 % confidence)")
            } else {
                format!("at least about {unseen:.0} (95 % interval {low:.0} to {high:.0})")
            },
            share_known(coverage, grasps)
        ),
    }
}

/// How complete the search of a surface is.
fn searched(manifest: &Manifest) -> Option<Statement> {
    let coverage = manifest.findings.get("coverage")?;
    let (searches, last_new) = (
        coverage["searches"].as_u64()?,
        coverage["last_new"].as_u64()?,
    );
    let (chance, once) = (
        coverage["chance_of_news"].as_f64()?,
        usize::try_from(coverage["once"].as_u64()?).ok()?,
    );
    let doubted = !coverage["doubt"].is_null();
    Some(Statement {
        tone: if once == 0 && !doubted {
            "good"
        } else {
            "care"
        },
        short: format!("nothing new after search {last_new} of {searches}"),
        long: format!(
            "{searches} searches were made, and the last new minimum or saddle came with search {last_new}. {} {} \
             met only once.{}{}",
            counted(once, "saddle"),
            if once == 1 { "was" } else { "were" },
            if coverage["planned"].as_u64().unwrap_or(0) > 0 || coverage["arrived"] == 0 {
                String::new()
            } else {
                format!(
                    " The next search that ends at a saddle ends at a new one with a chance of {:.2} %.",
                    100.0 * chance
                )
            },
            if doubted {
                " Completeness is not claimed, for a reason that summary.md gives."
            } else {
                ""
            }
        ),
    })
}

fn apart(tree: &Tree) -> Option<Statement> {
    let parts = tree.roots.len();
    (parts > 1).then(|| Statement {
        tone: "care",
        short: format!("{parts} parts without a path"),
        long: format!(
            "The minima fall into {parts} parts between which no path was found. There may be one: not finding it proves \
             nothing."
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::Node;

    /// Nothing of an imported landscape was verified.
    #[test]
    fn given_passes_are_not_verified() {
        let (database, _) = crate::topography::exchange::Database::parse(
            "0 1 1 0 0 0\n1 1 1 0 0 0\n",
            "2 1 1 1 2 0 0 0\n",
        )
        .unwrap();
        let told = passes(&Tree::from_network(&database.network(), Evidence::Chain)).unwrap();
        assert_eq!(
            (told.tone, told.short.as_str()),
            ("care", "0 of 1 pass verified")
        );
        assert!(
            told.long
                .contains("One is a transition state of another program"),
            "{}",
            told.long
        );
    }

    /// What there is none of is not mentioned, and one thing is in the singular.
    #[test]
    fn counts_of_passes_are_told_as_people_do() {
        let merge = |evidence| Node {
            energy: 1.0,
            minimum: None,
            children: Vec::new(),
            parent: None,
            evidence,
        };
        let of = |evidence: &[Evidence]| {
            let nodes = evidence.iter().map(|kind| merge(*kind)).collect();
            let tree = Tree {
                nodes,
                roots: Vec::new(),
            };
            let told = passes(&tree).unwrap();
            (told.tone, told.short, told.long)
        };
        let (tone, short, long) = of(&[Evidence::Saddle, Evidence::Saddle, Evidence::Path]);
        assert_eq!((tone, short.as_str()), ("good", "2 of 3 passes verified"));
        assert!(long.contains("2 of the 3 passes are verified"), "{long}");
        assert!(
            long.ends_with("One is the top of a relaxed path."),
            "{long}"
        );
        let (tone, _, long) = of(&[Evidence::Saddle, Evidence::Chain, Evidence::Chain]);
        assert_eq!(tone, "care");
        assert!(
            long.contains("1 of the 3 passes is verified") && !long.contains("relaxed"),
            "{long}"
        );
        assert!(long.contains(" 2 are upper bounds"), "{long}");
        let (_, short, long) = of(&[Evidence::Saddle]);
        assert_eq!(short, "1 of 1 pass verified");
        assert!(
            !long.contains(" 0 ") && !long.contains("true pass"),
            "{long}"
        );
    }

    /// An estimate of nothing asks for no caution.
    #[test]
    fn nothing_unseen_is_good_news() {
        let family = ["family", "families"];
        let none = missing(family, [0.0, 0.0, 2.0], 0.98, 100.0);
        assert_eq!(
            (none.tone, none.short.as_str()),
            ("good", "probably no family unseen")
        );
        assert!(
            none.long
                .contains("probably none (at most 2, with 95 % confidence)"),
            "{}",
            none.long
        );
        let some = missing(family, [15.2, 4.0, 60.0], 0.9, 100.0);
        assert_eq!(
            (some.tone, some.short.as_str()),
            ("care", "about 15 families unseen")
        );
        assert!(
            some.long
                .contains("at least about 15 (95 % interval 4 to 60)")
        );
        assert_eq!(
            missing(family, [1.0, 0.0, 4.0], 0.9, 100.0).short,
            "about 1 family unseen"
        );
    }

    /// A sample of N that shows no rare kind bounds the share of the others by 3/N: they are never excluded.
    #[test]
    fn no_chance_is_certain() {
        let all = missing(["family", "families"], [0.0, 0.0, 0.2], 1.0, 60.0);
        assert!(
            all.long
                .contains("never met: probably none. One more grasp falls into a known family")
                && all.long.contains("with a chance of at least 95 %."),
            "{}",
            all.long
        );
    }

    #[test]
    fn notes_become_sentences() {
        assert_eq!(sentence("3 of 4 rest"), "3 of 4 rest.");
        assert_eq!(sentence("ähnlich"), "Ähnlich.");
        let both = notes(&["one".to_owned(), "two".to_owned()]).unwrap();
        assert_eq!(
            (both.short.as_str(), both.long.as_str()),
            ("2 notes of the program", "One. Two.")
        );
        assert!(notes(&[]).is_none());
        assert_eq!(sentence(""), ".");
    }
}
