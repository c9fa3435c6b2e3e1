//! The pictures of a survey: which kinds each object has, and how the numbers of kinds grow.

use std::collections::BTreeMap;

use super::report::contacts_label;
use super::{HandSurvey, KindCounts, Survey, SurveyedPopulation};
use crate::evaluation::taxonomy::Taxonomy;
use crate::figure::chart::{Axis, Chart, Mark, Panel, Series};
use crate::figure::{rarefaction_panel, text_width, theme};

/// Most objects in a picture; those with the most grasps are shown.
const OBJECTS: usize = 40;
/// Most sets of touching digits in a picture; those on most objects are shown.
const CONTACTS: usize = 16;
/// Width of a column and height of a row, and room beside them and their texts, canvas units.
const STEP: f64 = 34.0;
const BESIDE: f64 = 40.0;
/// Radius of a dot that stands for all grasps of an object.
const WHOLE: f64 = 0.46 * STEP;
/// Least radius of a dot.
const LEAST: f64 = 3.5;

impl Survey {
    /// Grasp types against objects: a panel for each hand to which the taxonomy applies. The area of a dot is the share of the
    /// object's grasps. `None` if it applies to no hand.
    pub fn type_chart(&self) -> Option<Chart> {
        let rows: Vec<(String, String)> = (Taxonomy::feix().types.iter())
            .map(|entry| {
                (
                    entry.name.clone(),
                    format!("{} {}", entry.name, entry.number),
                )
            })
            .collect();
        let panels = self.hands.iter().filter(|hand| hand.types.is_some());
        dots(
            panels
                .map(|hand| self.panel(hand, &rows, &|one| one.types.as_ref()))
                .collect(),
        )
    }

    /// Sets of touching digits against objects: a panel for each hand.
    pub fn contact_chart(&self) -> Option<Chart> {
        let panels = self.hands.iter().map(|hand| {
            let mut objects: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
            for (contacts, grasps) in self.of_hand(hand).flat_map(|one| &one.contacts) {
                let count = objects.entry(contacts).or_default();
                *count = (count.0 + 1, count.1 + grasps);
            }
            let mut sets: Vec<(&str, (usize, usize))> = objects.into_iter().collect();
            sets.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
            let rows: Vec<(String, String)> = (sets.iter().take(CONTACTS))
                .map(|(set, _)| ((*set).to_owned(), contacts_label(set).to_owned()))
                .collect();
            self.panel(hand, &rows, &|one| Some(&one.contacts))
        });
        dots(panels.collect())
    }

    /// How the numbers of types, sets of contact regions and families grow with the number of grasps, for each hand.
    pub fn rarefaction_chart(&self) -> Chart {
        let panel = |title: &str, counts: &dyn Fn(&HandSurvey) -> Option<Vec<usize>>| {
            let curves: Vec<_> = (self.hands.iter())
                .filter_map(|hand| Some((&hand.hand, HandSurvey::rarefaction(counts(hand)?))))
                .collect();
            // A hand has one colour in all panels.
            let number = |name: &str| self.hands.iter().position(|hand| hand.hand == name);
            let curves: Vec<_> = (curves.iter())
                .map(|(name, found)| {
                    let colour = theme::series(number(name).unwrap_or_default());
                    (name.as_str(), found, colour)
                })
                .collect();
            (!curves.is_empty()).then(|| rarefaction_panel(title, "grasps", &curves))
        };
        let values = |counts: &KindCounts| counts.values().copied().collect();
        let panels = [
            panel("types of the taxonomy", &|hand| {
                hand.types.as_ref().map(values)
            }),
            panel("sets of contact regions", &|hand| {
                Some(values(&hand.contacts))
            }),
            panel("families, each object by itself", &|hand| {
                Some(hand.family_sizes.clone()).filter(|sizes| !sizes.is_empty())
            }),
        ];
        Chart {
            legend_below: true,
            ..Chart::new("", panels.into_iter().flatten().collect())
        }
    }

    fn panel(
        &self,
        hand: &HandSurvey,
        rows: &[(String, String)],
        counts: &dyn Fn(&SurveyedPopulation) -> Option<&KindCounts>,
    ) -> Panel {
        let mut objects: Vec<&SurveyedPopulation> = self.of_hand(hand).collect();
        let all = objects.len();
        objects.sort_by_key(|one| std::cmp::Reverse(one.grasps));
        objects.truncate(OBJECTS);
        objects.sort_by_cached_key(|one| hand.label(one, &self.populations));
        // The first row is the highest.
        let height = |row: usize| -(row as f64);
        let mut series = Vec::new();
        for (column, one) in objects.iter().enumerate() {
            for (row, (kind, _)) in rows.iter().enumerate() {
                let Some(count) = counts(one).and_then(|counts| counts.get(kind)) else {
                    continue;
                };
                let share = *count as f64 / one.grasps.max(1) as f64;
                series.push(
                    Series::new(Mark::Points {
                        points: vec![[column as f64, height(row)]],
                        radius: (WHOLE * share.sqrt()).max(LEAST),
                    })
                    .coloured(theme::sequential(share.sqrt())),
                );
            }
        }
        let labels = objects.iter().map(|one| hand.label(one, &self.populations));
        let columns: Vec<(f64, String)> = (0..).map(f64::from).zip(labels).collect();
        let names = rows.iter().enumerate();
        let names = names.map(|(row, (_, text))| (height(row), text.clone()));
        let title = if all > OBJECTS {
            format!(
                "{} (the {OBJECTS} objects with most grasps of {all})",
                hand.hand
            )
        } else {
            hand.hand.clone()
        };
        Panel::new(
            &title,
            Axis::linear("").with_ticks(columns),
            Axis::linear("").with_ticks(names),
            series,
        )
    }
}

/// Panels of dots with rows and columns of one size, and room for their texts.
fn dots(mut panels: Vec<Panel>) -> Option<Chart> {
    let most = |axis: &dyn Fn(&Panel) -> &Axis| panels.iter().map(|p| axis(p).ticks.len()).max();
    let longest = |axis: &dyn Fn(&Panel) -> &Axis| {
        let texts = panels.iter().flat_map(|panel| &axis(panel).ticks);
        texts
            .map(|(_, text)| text_width(text, theme::TEXT, false))
            .fold(0.0, f64::max)
    };
    let (columns, rows) = (most(&|panel| &panel.x)?, most(&|panel| &panel.y)?);
    let side = |count: usize, text: f64| count.max(6) as f64 * STEP + text + BESIDE;
    let sides = [
        side(columns, longest(&|panel| &panel.y)),
        side(rows, longest(&|panel| &panel.x)),
    ];
    for panel in &mut panels {
        panel.x.range = Some([-0.6, columns.max(6) as f64 - 0.4]);
        panel.y.range = Some([0.4 - rows.max(6) as f64, 0.6]);
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some thousand units"
    )]
    let panel_size = sides.map(|side| side.ceil() as u32);
    Some(Chart {
        panel_size,
        ..Chart::new("", panels)
    })
}
