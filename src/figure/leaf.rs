//! Description of a minimum (or a family of minima) in a picture: its number of members and its label.

use super::canvas::Canvas;
use super::legend::Legend;
use super::look::{Key, Look, Symbol};
use super::style::{Anchor, Colour, TextFace};
use super::theme::{INK, MARGIN, TITLE, UNLABELLED, WHITE};
use crate::topography::Network;

/// Least radius of marks whose form is to be seen, canvas units.
pub(super) const LEAST_SYMBOL: f64 = 6.0;

/// A mark of a picture: a disc or another symbol.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Leaf {
    /// Number of members. The area of the mark is proportional to it; 0 draws a hollow dot.
    pub members: usize,
    /// What the look of the mark tells. The [`Key`] of the picture has the looks of known labels; others take looks in turn.
    pub label: Option<String>,
    /// Short text beside the mark, drawn if there is room.
    pub caption: Option<String>,
}

/// One unlabelled leaf per minimum, in order.
pub fn leaves_of(network: &Network) -> Vec<Leaf> {
    network
        .node_weights()
        .map(|minimum| Leaf {
            members: minimum.members.len(),
            ..Leaf::default()
        })
        .collect()
}

/// Leaves of families. Members add up. The label is that of the most members (ties: first in the alphabet). Captions stay
/// only on families of one leaf.
///
/// # Panics
/// If `family_of` does not have one entry per leaf.
pub fn leaves_of_families(leaves: &[Leaf], family_of: &[usize]) -> Vec<Leaf> {
    assert_eq!(leaves.len(), family_of.len(), "one family a leaf");
    let count = family_of.iter().max().map_or(0, |largest| largest + 1);
    let mut members: Vec<Vec<&Leaf>> = vec![Vec::new(); count];
    for (leaf, family) in leaves.iter().zip(family_of) {
        members[*family].push(leaf);
    }
    (members.into_iter())
        .map(|inside| {
            let votes = |label: &str| -> usize {
                inside
                    .iter()
                    .filter(|leaf| leaf.label.as_deref() == Some(label))
                    .map(|leaf| leaf.members)
                    .sum()
            };
            let mut labels: Vec<&str> = inside
                .iter()
                .filter_map(|leaf| leaf.label.as_deref())
                .collect();
            labels.sort_unstable();
            let label = (labels.into_iter().rev())
                .max_by_key(|label| votes(label))
                .map(str::to_owned);
            let caption = if let [only] = inside[..] {
                only.caption.clone()
            } else {
                None
            };
            Leaf {
                members: inside.iter().map(|leaf| leaf.members).sum(),
                label,
                caption,
            }
        })
        .collect()
}

/// The looks of the leaves of a picture.
#[derive(Debug)]
pub(super) struct Looks<'a> {
    looks: Vec<(&'a str, Look)>,
    /// Whether leaves without a label are drawn.
    unlabelled: bool,
}

impl<'a> Looks<'a> {
    pub(super) fn of(leaves: &'a [Leaf], key: &Key) -> Self {
        Self {
            looks: key.looks(leaves.iter().filter_map(|leaf| leaf.label.as_deref())),
            unlabelled: leaves.iter().any(|leaf| leaf.label.is_none()),
        }
    }

    /// The same of a picture that leaves the leaves without label out.
    pub(super) fn only_labelled(self) -> Self {
        Self {
            unlabelled: false,
            ..self
        }
    }

    /// Whether no leaf has a label.
    pub(super) fn is_empty(&self) -> bool {
        self.looks.is_empty()
    }

    /// Whether not all leaves are discs, so that their form must be legible.
    pub(super) fn have_symbols(&self) -> bool {
        (self.looks.iter()).any(|(_, look)| look.symbol != Symbol::Disc || look.open)
    }

    /// The look of a leaf.
    pub(super) fn look(&self, leaf: &Leaf) -> Look {
        let Some(label) = leaf.label.as_deref() else {
            return Look::disc(if leaf.members == 0 { WHITE } else { UNLABELLED });
        };
        let known = self.looks.iter().find(|(known, _)| *known == label);
        known.map_or(Look::disc(UNLABELLED), |(_, look)| *look)
    }

    /// Adds the look of each label to `legend`, if any label occurs.
    pub(super) fn explain(&self, radius: f64, legend: &mut Legend) {
        if self.is_empty() {
            return;
        }
        legend.heading("label");
        for (label, look) in &self.looks {
            legend.symbol(radius, *look, label);
        }
        if self.unlabelled {
            legend.disc(radius, UNLABELLED, "none");
        }
        let looks = || self.looks.iter().map(|(_, look)| look);
        if (looks().enumerate()).any(|(k, look)| looks().take(k).any(|other| other == look)) {
            legend.note("some labels look alike");
        }
    }
}

/// Writes a title across the top of a sheet, if there is one, and returns the top of the remaining room.
pub(super) fn draw_title(canvas: &mut Canvas, title: &str) -> f64 {
    if title.is_empty() {
        return MARGIN;
    }
    let face = TextFace::new(TITLE, INK).bold().anchored(Anchor::Middle);
    let middle = 0.5 * canvas.width();
    let face = face.fitted(title, 2.0 * (middle - MARGIN));
    canvas.text([middle, MARGIN + 0.6 * TITLE], title, face);
    MARGIN + 1.6 * TITLE
}

/// Largest number of members of a leaf, at least 1.
pub(super) fn most_members(leaves: &[Leaf]) -> f64 {
    let members = leaves.iter().map(|leaf| leaf.members);
    members.max().unwrap_or(0).max(1) as f64
}

/// Adds circles for typical numbers of members to `legend`.
pub(super) fn explain_sizes(
    leaves: &[Leaf],
    scale: DiscScale,
    heading: &str,
    fill: Colour,
    legend: &mut Legend,
) {
    legend.heading(heading);
    if leaves.iter().any(|leaf| leaf.members == 0) {
        legend.disc(scale.radius(0), WHITE, "0");
    }
    for members in typical_members(leaves) {
        legend.disc(scale.radius(members), fill, &members.to_string());
    }
}

/// Radius of marks: their area is proportional to the number of members, or all are equal.
#[derive(Debug, Clone, Copy)]
pub(super) struct DiscScale {
    /// Radius of a mark of one member.
    one: f64,
    /// Least radius.
    least: f64,
    equal: bool,
}

impl DiscScale {
    pub(super) fn by_members(one: f64) -> Self {
        Self {
            one,
            least: 0.0,
            equal: false,
        }
    }

    pub(super) fn equal(radius: f64) -> Self {
        Self {
            one: radius,
            least: 0.0,
            equal: true,
        }
    }

    /// The same scale with a least radius, which small marks need if their form is to be seen.
    pub(super) fn at_least(self, least: f64) -> Self {
        Self { least, ..self }
    }

    pub(super) fn radius(self, members: usize) -> f64 {
        let radius = if self.equal {
            self.one
        } else if members == 0 {
            0.6 * self.one
        } else {
            self.one * (members as f64).sqrt()
        };
        radius.max(self.least)
    }
}

/// Numbers of members for a legend: the smallest, the largest and a round one between.
fn typical_members(leaves: &[Leaf]) -> Vec<usize> {
    let present = || {
        leaves
            .iter()
            .map(|leaf| leaf.members)
            .filter(|&members| members > 0)
    };
    let (Some(least), Some(most)) = (present().min(), present().max()) else {
        return Vec::new();
    };
    let middle = ((least as f64).sqrt() + (most as f64).sqrt()).powi(2) / 4.0;
    let round = (0..7)
        .flat_map(|power| [1, 2, 5].map(|digit| digit * 10usize.pow(power)))
        .filter(|&value| value > least && value < most)
        .min_by(|a, b| {
            (*a as f64 - middle)
                .abs()
                .total_cmp(&(*b as f64 - middle).abs())
        });
    let mut typical = vec![least];
    typical.extend(round);
    typical.push(most);
    typical.dedup();
    typical
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf(members: usize, label: &str) -> Leaf {
        Leaf {
            members,
            label: (!label.is_empty()).then(|| label.to_owned()),
            caption: Some(members.to_string()),
        }
    }

    #[test]
    fn families_vote_by_members() {
        let leaves = [
            leaf(3, "power"),
            leaf(2, "precision"),
            leaf(2, "precision"),
            leaf(9, ""),
            leaf(1, "hook"),
        ];
        let families = leaves_of_families(&leaves, &[0, 0, 0, 0, 1]);
        assert_eq!(
            families[0],
            Leaf {
                members: 16,
                label: Some("precision".into()),
                caption: None
            }
        );
        assert_eq!(families[1], leaves[4]);
        let tie = leaves_of_families(&[leaf(1, "b"), leaf(1, "a")], &[0, 0]);
        assert_eq!(tie[0].label.as_deref(), Some("a"));
    }

    #[test]
    fn legend_sizes_are_round_and_distinct() {
        let of = |members: &[usize]| {
            typical_members(
                &members
                    .iter()
                    .map(|&members| leaf(members, ""))
                    .collect::<Vec<_>>(),
            )
        };
        assert_eq!(of(&[1, 7, 63, 0]), [1, 20, 63]);
        assert_eq!(of(&[1, 1]), [1]);
        assert_eq!(of(&[1, 2]), [1, 2]);
        assert!(of(&[0]).is_empty());
    }
}
