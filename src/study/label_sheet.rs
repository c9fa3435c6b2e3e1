//! A contact sheet for labelling grasps by hand: one self-contained HTML file.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use crate::evaluation::taxonomy::{Label, Taxonomy};
use crate::figure::Scene;
use crate::store::{GraspFile, GraspRow};

/// The page, in which the data replace [`DATA`].
const PAGE: &str = include_str!("label_sheet.html");
const DATA: &str = "\"DATA\"";
/// Side of a picture, pixels.
const SIDE: u32 = 220;

/// One grasp on the sheet.
#[derive(Serialize)]
struct Card {
    /// Stored as text, because numbers in scripts are exact only up to 2⁵³.
    id: String,
    object: String,
    /// Two pictures, PNG in base64.
    pictures: [String; 2],
    /// The human label so far.
    human: Option<String>,
    rule: String,
    best: String,
}

#[derive(Serialize)]
struct Page<'a> {
    file: &'a str,
    types: Vec<Choice<'a>>,
    grasps: Vec<Card>,
}

/// A type that can be selected.
#[derive(Serialize)]
struct Choice<'a> {
    number: u8,
    name: &'a str,
    aliases: &'a [String],
    cell: &'a str,
    cue: &'a str,
}

/// The cards of all grasps, one population after the other.
fn cards(file: &GraspFile, labels: &BTreeMap<u64, Label>) -> Result<Vec<Card>, StudyError> {
    let mut cards = Vec::new();
    for population in file.landscapes() {
        let (hand, object) = (population.hand()?, population.object()?);
        let skin = hand.skin();
        let card = |row: &&GraspRow| {
            let scene = Scene::of_grasp(&hand, &skin, &object, &row.grasp);
            let [first, second] = scene.two_cameras(Vector3::z());
            let picture = |camera| -> Result<String, StudyError> {
                Ok(STANDARD.encode(scene.render(camera, SIDE, SIDE).to_png()?))
            };
            let label = labels.get(&row.id);
            Ok(Card {
                id: row.id.to_string(),
                object: row.object.clone(),
                pictures: [picture(&first)?, picture(&second)?],
                human: row.label.clone().filter(|label| !label.is_empty()),
                rule: label.map_or_else(String::new, |label| label.text().to_owned()),
                best: label.map_or_else(String::new, Label::best_text),
            })
        };
        let of_population = population.grasps.par_iter().map(card);
        cards.extend(of_population.collect::<Result<Vec<_>, StudyError>>()?);
    }
    Ok(cards)
}

/// A page (HTML) on which a human labels the grasps of a file, whose name it shows. `labels` are those of the rule, by id.
///
/// # Errors
/// If a hand or an object cannot be built, or a picture cannot be encoded.
pub fn label_sheet(
    name: &str,
    file: &GraspFile,
    labels: &BTreeMap<u64, Label>,
) -> Result<String, StudyError> {
    let types = Taxonomy::feix().types.iter().map(|entry| Choice {
        number: entry.number,
        name: &entry.name,
        aliases: &entry.aliases,
        cell: &entry.cell,
        cue: &entry.cue,
    });
    let page = Page {
        file: name,
        types: types.collect(),
        grasps: cards(file, labels)?,
    };
    Ok(PAGE.replacen(DATA, &page.script(), 1))
}

impl Page<'_> {
    fn script(&self) -> String {
        let data = serde_json::to_string(self).expect("plain data with text keys is always JSON");
        // Inside a script element `</script` would end it early, and `<!--` would hide its end.
        data.replace('<', "\\u003c")
    }
}
