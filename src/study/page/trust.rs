//! How far a landscape is to be trusted, in plain words.

use serde_json::{Value, json};

use crate::printable::counted;
use crate::store::{LandscapeFiles, Manifest};
use crate::study::median;
use crate::topography::{Evidence, Node, Tree, support};

/// A merge is well supported if at least this fraction of the resamplings makes it.
const WELL: f64 = 0.95;
/// It is doubtful below this fraction.
const DOUBTFUL: f64 = 0.7;

/// A statement about trust.
struct Statement {
    /// `good`, `care` or `warning`.
    tone: &'static str,
    /// A few words.
    short: String,
    /// Sentences for someone who meets these notions for the first time.
    long: String,
}

/// All statements about a landscape, the most important first.
pub(super) fn statements(files: &LandscapeFiles, tree: &Tree, resampled: &[Tree]) -> Value {
    let manifest = &files.manifest;
    let mut statements = Vec::new();
    statements.extend(passes(tree));
    statements.extend(supported(tree, resampled));
    statements.extend(unseen(manifest));
    statements.extend(searched(manifest));
    statements.extend(hovering(manifest, tree));
    statements.extend(apart(tree));
    statements.extend(notes(&manifest.warnings));
    let told = statements.iter().map(
        |Statement { tone, short, long }| json!({ "tone": tone, "short": short, "long": long }),
    );
    told.collect()
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
    let (verified, given) = (
        of(&[Evidence::Saddle, Evidence::Seam]),
        of(&[Evidence::Given]),
    );
    let (relaxed, bounds) = (
        of(&[Evidence::Path]),
        of(&[Evidence::Chain, Evidence::None]),
    );
    let all = merges.len();
    Some(Statement {
        tone: if bounds + given == 0 { "good" } else { "care" },
        short: format!("{verified} of {all} passes verified"),
        long: format!(
            "Two branches of the tree meet at the energy of the lowest known pass between them. {verified} of the {all} \
             passes are verified: the slope vanishes there, and both sides lead down to the two minima. {relaxed} are the \
             tops of relaxed paths. {bounds} are upper bounds: the true pass may lie lower (dashed lines).{}",
            if given == 0 {
                String::new()
            } else {
                format!(" {given} are transition states of another program, taken at its word.")
            }
        ),
    })
}

/// How often the merges come again when the chains are resampled.
fn supported(tree: &Tree, resampled: &[Tree]) -> Option<Statement> {
    let known: Vec<f64> = support(tree, resampled).into_iter().flatten().collect();
    if known.is_empty() {
        return None;
    }
    let well = known.iter().filter(|share| **share >= WELL).count();
    let doubtful = known.iter().filter(|share| **share < DOUBTFUL).count();
    Some(Statement {
        tone: if doubtful == 0 { "good" } else { "care" },
        short: format!("{well} of {} merges well supported", known.len()),
        long: format!(
            "The searches for passes use random chains. To see how much depends on their luck, the tree was made again {} \
             times from random choices of these chains. {well} of the {} merges join the same minima in at least {:.0} % of \
             these trees, and {doubtful} in less than {:.0} % (hollow dots): do not build on those.",
            resampled.len(),
            known.len(),
            100.0 * WELL,
            100.0 * DOUBTFUL
        ),
    })
}

/// Groups that the grasps did not show.
fn unseen(manifest: &Manifest) -> Option<Statement> {
    manifest.hand.as_ref()?;
    let groups = &manifest.findings.get("rarefaction")?["groups"];
    let number = |name: &str| groups[name].as_f64();
    let interval = &groups["unseen_interval"];
    let (Some(unseen), Some(coverage)) = (number("unseen"), number("coverage")) else {
        return Some(Statement {
            tone: "care",
            short: "too few grasps to tell what is missing".to_owned(),
            long: "With this few grasps it cannot be estimated how many groups they did not show."
                .to_owned(),
        });
    };
    let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap_or(f64::NAN));
    Some(Statement {
        tone: if high < 1.0 { "good" } else { "care" },
        short: format!("about {unseen:.0} groups unseen"),
        long: format!(
            "From how many groups were met once or twice one can estimate how many were never met: at least about \
             {unseen:.0} (95 % interval {low:.0} to {high:.0}). One more grasp falls into a known group with a chance of {:.0} %. \
             This takes the grasps for independent draws.",
            100.0 * coverage
        ),
    })
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

/// What hovering off the object costs, the scale of barriers. It asks for caution by the rule of the program's note: if a hand
/// farther off costs less than the median merge depth.
fn hovering(manifest: &Manifest, tree: &Tree) -> Option<Statement> {
    let costs = manifest.findings.get("hover_cost")?.as_array()?;
    let cost = costs.first()?;
    let middle = cost["quartiles"][1].as_f64()?;
    let clearance_mm = 1e3 * cost["clearance_m"].as_f64()?;
    let farther = costs.get(1).and_then(|cost| cost["quartiles"][1].as_f64());
    let cheap = farther.zip(median(depths(tree)));
    let cheap = cheap.is_some_and(|(cost, depth)| cost < depth);
    let meaning = match manifest.letting_go {
        Some(cost) => format!(
            "The elastic layer of this energy reaches farther than that, so the hand still holds weakly; a hand that has let \
             go costs {cost:.3}. For a pass that is higher than the cost of hovering, see what happens on the way."
        ),
        None => "Such a hand touches nothing. A pass that is higher than that may be crossed by letting go and grasping anew, \
                 so compare heights with this number."
            .to_owned(),
    };
    Some(Statement {
        tone: if cheap { "care" } else { "good" },
        short: format!("hovering {clearance_mm:.0} mm off costs {middle:.2}"),
        long: format!(
            "A hand that hovers {clearance_mm:.0} mm off the object costs {middle:.3} in energy (median over the minima). \
             {meaning}"
        ),
    })
}

/// By how much the merges lie above the lowest minima of their branches, except for the lowest branch.
fn depths(tree: &Tree) -> Vec<f64> {
    let lowest = tree.fold(|node, branches: &[f64]| {
        let least = branches.iter().copied().reduce(f64::min);
        least.unwrap_or(tree.nodes[node.0].energy)
    });
    let of_merge = |node: &Node| {
        let mut below: Vec<f64> = node.children.iter().map(|child| lowest[child.0]).collect();
        below.sort_by(f64::total_cmp);
        let height = node.energy;
        below.into_iter().skip(1).map(move |least| height - least)
    };
    tree.nodes.iter().flat_map(of_merge).collect()
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
    use crate::topography::NodeId;

    /// Three minima at 0, 1 and 3; the latter two merge at 4, and the first joins them at 9.
    #[test]
    fn depths_are_measured_from_the_higher_branches() {
        let node = |energy: f64, children: &[usize]| Node {
            energy,
            minimum: None,
            children: children.iter().copied().map(NodeId).collect(),
            parent: None,
            evidence: Evidence::Saddle,
        };
        let leaves = [0.0, 1.0, 3.0].map(|energy| node(energy, &[]));
        let mut nodes = leaves.to_vec();
        nodes.extend([node(4.0, &[2, 1]), node(9.0, &[0, 3])]);
        let roots = vec![NodeId(4)];
        assert_eq!(depths(&Tree { nodes, roots }), [1.0, 8.0]);
    }

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
            ("care", "0 of 1 passes verified")
        );
        assert!(
            told.long
                .contains("1 are transition states of another program"),
            "{}",
            told.long
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
