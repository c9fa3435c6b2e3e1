//! Which grasp types a hand can do on some objects, and whether they hold.

use std::fmt::Write;

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

use super::markdown::table;
use super::synthesis::{objection, usual_chains};
use super::wish::Wishes;
use super::{Asked, Origin, PopulationSettings, Run, StudyError, WishError, json, simulate_all};
use crate::evaluation::stability::{Drop, Protocol};
use crate::evaluation::taxonomy::Taxonomy;
use crate::figure::chart::{Axis, Chart, Mark, Panel, Series};
use crate::figure::{text_width, theme};
use crate::store::{GraspFile, GraspRow, RebuildError};
use crate::topography::Phase;

/// What came of one type on one object.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Ability {
    /// Name of the object.
    pub object: String,
    /// Number of the grasp type.
    pub number: u8,
    /// Name of the grasp type.
    #[serde(rename = "type")]
    pub name: String,
    /// Number of chains that were asked for it.
    pub chains: usize,
    /// How many ended in a grasp of this type that passes the strict filter.
    pub found: usize,
    /// How many of these hold when dropped in simulation.
    pub held: usize,
}

/// Which grasp types a hand can do on some objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Abilities {
    /// Name of the hand.
    pub hand: String,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Types that need a digit which the hand lacks.
    pub impossible: Vec<String>,
    /// An entry for each other type and object, by object.
    pub abilities: Vec<Ability>,
}

/// The grasp types that the hand of an origin has the digits for, and the names of the others.
///
/// # Errors
/// If the hand is not built like a human one, so that types are not defined for it, or hand or object cannot be built.
pub fn possible_types(origin: &Origin) -> Result<(Vec<Asked>, Vec<String>), StudyError> {
    let (hand, object) = (origin.hand.build()?, origin.object.build(origin.scale)?);
    let wishes = Wishes::none(&hand, &object);
    let (mut asked, mut impossible) = (Vec::new(), Vec::new());
    for entry in &Taxonomy::feix().types {
        let wish = Asked::Type(entry.number);
        match wishes.planned(&wish) {
            Ok(_) => asked.push(wish),
            Err(WishError::Digit { .. }) => impossible.push(entry.name.clone()),
            Err(error) => return Err(error.into()),
        }
    }
    Ok((asked, impossible))
}

/// Asks chains for every type that the hand of the origins has the digits for, on the object of each origin: `chains` for
/// each type and object. Finished chains are kept in the journal of the run.
///
/// # Errors
/// If the hand is not built like a human one, a hand or an object cannot be built, or the journal takes no record.
pub fn hand_abilities(
    origins: &[Origin],
    chains: u64,
    seed: u64,
    run: &Run<'_>,
) -> Result<Abilities, StudyError> {
    let mut abilities = Abilities {
        hand: String::new(),
        objects: Vec::new(),
        impossible: Vec::new(),
        abilities: Vec::new(),
    };
    for (place, origin) in origins.iter().enumerate() {
        let mut settings = PopulationSettings {
            seed,
            ..PopulationSettings::default()
        };
        (settings.asked, abilities.impossible) = possible_types(origin)?;
        settings.chains = chains * settings.asked.len() as u64;
        let found = on_object(place, origins.len(), origin, &settings, run)?;
        abilities.abilities.extend(found);
        abilities.hand.clone_from(&origin.hand.name);
        abilities.objects.push(origin.object.name.clone());
    }
    Ok(abilities)
}

fn on_object(
    place: usize,
    objects: usize,
    origin: &Origin,
    settings: &PopulationSettings,
    run: &Run<'_>,
) -> Result<Vec<Ability>, StudyError> {
    let energy = origin.energy(settings)?;
    let wishes = settings.wishes(&energy)?;
    let numbers: Vec<u64> = (0..settings.chains).collect();
    let tally = run.tally_of_round(Phase::Synthesize, (place, objects), numbers.len());
    let before = format!("object {place} ");
    let tasks = (numbers.as_slice(), &tally, before.as_str());
    let ends = usual_chains(&energy, origin, settings, &wishes, tasks, run)?;
    let granted: Vec<bool> = (ends.par_iter())
        .map(|(end, judgement)| {
            objection(wishes.of_chain(end.chain), end, judgement, settings).is_none()
        })
        .collect();
    let rows: Vec<GraspRow> = (ends.iter().zip(&granted))
        .filter(|(_, granted)| **granted)
        .map(|((end, judgement), _)| origin.row(&energy, settings.seed, end, judgement))
        .collect();
    let file = GraspFile {
        metadata: origin
            .metadata(&energy, settings)
            .map_err(RebuildError::Energy)?,
        grasps: rows,
    };
    let held: Vec<u64> = run
        .in_turn(
            &[place],
            |place| format!("object {place} held"),
            |_| {
                let quiet = Run {
                    observer: run.observer,
                    ..Run::default()
                };
                let found = simulate_all(&file, &Protocol::Drop(Drop::default()), &quiet)?;
                let held = found
                    .outcomes
                    .iter()
                    .filter(|(_, outcome)| outcome.is_stable());
                Ok::<_, StudyError>(held.map(|(id, _)| *id).collect::<Vec<u64>>())
            },
        )?
        .remove(0);
    let of_wish = |(number, asked): (usize, &Asked)| {
        let own = |chain: u64| wishes.place(chain) == number;
        let Asked::Type(kind) = asked else {
            return None;
        };
        Some(Ability {
            object: origin.object.name.clone(),
            number: *kind,
            name: asked.name(),
            chains: numbers.iter().filter(|chain| own(**chain)).count(),
            found: file.grasps.iter().filter(|row| own(row.id)).count(),
            held: held.iter().filter(|id| own(**id)).count(),
        })
    };
    Ok(settings
        .asked
        .iter()
        .enumerate()
        .filter_map(of_wish)
        .collect())
}

/// Width of a column and height of a row of the picture, and room beside them, canvas units.
const STEP: f64 = 34.0;
const BESIDE: f64 = 40.0;
/// Radii of a dot that stands for all chains, and of the least.
const WHOLE: f64 = 0.46 * STEP;
const LEAST: f64 = 3.5;

impl Abilities {
    /// A table: types against objects, with the share of chains that found each, and the share of these that hold.
    pub fn markdown(&self) -> String {
        let mut head = vec!["type"];
        head.extend(self.objects.iter().map(String::as_str));
        let mut text = String::new();
        let reached = self.reached();
        let _ = writeln!(
            text,
            "The {} hand does {} of the 33 grasp types on {}: {}.\n",
            self.hand,
            reached.len(),
            crate::printable::counted(self.objects.len(), "object"),
            if reached.is_empty() {
                "none".to_owned()
            } else {
                reached.join(", ")
            }
        );
        let rows = self.types().into_iter().map(|(number, name)| {
            let cells = self.objects.iter().map(|object| {
                let own = self.of(number, object);
                own.map_or_else(
                    || "–".to_owned(),
                    |own| match own.found {
                        0 => format!("0 of {}", own.chains),
                        found => format!("{found} of {}, {} hold", own.chains, own.held),
                    },
                )
            });
            std::iter::once(format!("{number} {name}"))
                .chain(cells)
                .collect()
        });
        text += &table(&head, rows);
        if !self.impossible.is_empty() {
            let _ = writeln!(
                text,
                "\nThe hand lacks a digit for: {}.",
                self.impossible.join(", ")
            );
        }
        text
    }

    /// A row for each type and object, with a heading.
    pub fn csv(&self) -> String {
        let mut text = "id,object,number,type,chains,found,held\n".to_owned();
        for (id, own) in self.abilities.iter().enumerate() {
            let _ = writeln!(
                text,
                "{id},\"{}\",{},{},{},{},{}",
                own.object.replace('"', "\"\""),
                own.number,
                own.name,
                own.chains,
                own.found,
                own.held
            );
        }
        text
    }

    /// All numbers.
    pub fn to_json(&self) -> Value {
        json(self)
    }

    /// Types against objects: the area of a dot is the share of chains that found the type, its colour the share of these
    /// that hold.
    pub fn chart(&self) -> Chart {
        let types = self.types();
        let height = |row: usize| -(row as f64);
        let mut series = Vec::new();
        for (column, object) in self.objects.iter().enumerate() {
            for (row, (number, _)) in types.iter().enumerate() {
                let Some(own) = self.of(*number, object).filter(|own| own.found > 0) else {
                    continue;
                };
                let share = own.found as f64 / own.chains as f64;
                let dot = Series::new(Mark::Points {
                    points: vec![[column as f64, height(row)]],
                    radius: (WHOLE * share.sqrt()).max(LEAST),
                });
                series.push(dot.coloured(theme::sequential(own.held as f64 / own.found as f64)));
            }
        }
        let columns: Vec<(f64, String)> = (0..).map(f64::from).zip(self.objects.clone()).collect();
        let rows: Vec<(f64, String)> = (types.iter().enumerate())
            .map(|(row, (number, name))| (height(row), format!("{name} {number}")))
            .collect();
        let longest = |texts: &[(f64, String)]| {
            let widths = texts
                .iter()
                .map(|(_, text)| text_width(text, theme::TEXT, false));
            widths.fold(0.0, f64::max)
        };
        let side = |count: usize, text: f64| count.max(6) as f64 * STEP + text + BESIDE;
        let sides = [
            side(columns.len(), longest(&rows)),
            side(rows.len(), longest(&columns)),
        ];
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some thousand units"
        )]
        let panel_size = sides.map(|side| side.ceil() as u32);
        let title = format!(
            "{}: area, share of chains; colour, share that holds",
            self.hand
        );
        let mut panel = Panel::new(
            &title,
            Axis::linear("").with_ticks(columns),
            Axis::linear("").with_ticks(rows),
            series,
        );
        panel.x.range = Some([-0.6, self.objects.len().max(6) as f64 - 0.4]);
        panel.y.range = Some([0.4 - types.len().max(6) as f64, 0.6]);
        Chart {
            panel_size,
            ..Chart::new("", vec![panel])
        }
    }

    /// Numbers and names of the types that were asked for.
    fn types(&self) -> Vec<(u8, &str)> {
        let mut types: Vec<(u8, &str)> = (self.abilities.iter())
            .map(|own| (own.number, own.name.as_str()))
            .collect();
        types.sort_unstable();
        types.dedup();
        types
    }

    /// Names of the types that some chain found.
    fn reached(&self) -> Vec<&str> {
        let found =
            |number: u8| (self.abilities.iter()).any(|own| own.number == number && own.found > 0);
        let types = self.types().into_iter();
        types
            .filter(|(number, _)| found(*number))
            .map(|(_, name)| name)
            .collect()
    }

    fn of(&self, number: u8, object: &str) -> Option<&Ability> {
        let abilities = self.abilities.iter();
        abilities
            .into_iter()
            .find(|own| own.number == number && own.object == object)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn abilities() -> Abilities {
        let ability = |object: &str, number, found, held| Ability {
            object: object.to_owned(),
            number,
            name: Taxonomy::feix().numbered(number).unwrap().name.clone(),
            chains: 12,
            found,
            held,
        };
        Abilities {
            hand: "human".to_owned(),
            objects: vec!["ball".to_owned(), "pen".to_owned()],
            impossible: vec!["Ventral".to_owned()],
            abilities: vec![
                ability("ball", 9, 6, 5),
                ability("ball", 19, 0, 0),
                ability("pen", 9, 12, 12),
                ability("pen", 19, 0, 0),
            ],
        }
    }

    #[test]
    fn tables_say_how_many_chains_found_a_type_and_how_many_hold() {
        let text = abilities().markdown();
        assert!(
            text.contains("does 1 of the 33 grasp types on 2 objects: Palmar Pinch."),
            "{text}"
        );
        assert!(
            text.contains("| 9 Palmar Pinch | 6 of 12, 5 hold | 12 of 12, 12 hold |"),
            "{text}"
        );
        assert!(text.contains("| 19 Distal | 0 of 12 | 0 of 12 |"), "{text}");
        assert!(text.contains("lacks a digit for: Ventral"), "{text}");
        assert_eq!(
            abilities().csv().lines().nth(3),
            Some("2,\"pen\",9,Palmar Pinch,12,12,12")
        );
    }

    #[test]
    fn a_type_that_no_chain_found_has_no_dot() {
        assert_eq!(abilities().chart().panels[0].series.len(), 2);
    }
}
