//! Templates of the types on the Shadow hand: poses and contacts, without an object.

use std::path::Path;

use landscape::evaluation::taxonomy::{
    Anatomy, Patch, Rule, Taxonomy, TouchingPatch, label_contacts,
};
use landscape::hand::{Hand, HandFiles, PosedHand};
use nalgebra::Vector3;
use serde::Deserialize;

use crate::Failure;
use crate::case::Case;
use crate::contact::{Contact, NEAR_MM, PALM, agrees};

/// Area that an annotated contact counts as, mm²: enough to be certain.
const ANNOTATED_MM2: f64 = 60.0;

#[derive(Deserialize)]
struct Examples {
    joint_order: Vec<String>,
    templates: Vec<Template>,
}

#[derive(Deserialize)]
struct Template {
    feix_number: u8,
    qpos: Vec<f64>,
    contacts: Vec<Annotated>,
}

#[derive(Deserialize)]
struct Annotated {
    body: String,
    normal_body: [f64; 3],
    point_body: [f64; 3],
}

/// Labels of all templates of a file, on the hand of another file.
pub(crate) fn cases(path: &Path, hand: &Path, rule: &Rule) -> Result<Vec<Case>, Failure> {
    let examples: Examples = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let hand = Hand::from_files(&HandFiles::load(hand)?)?;
    let anatomy = Anatomy::of(&hand)?;
    let mut cases = Vec::new();
    for template in &examples.templates {
        let mut x = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        for joint in &hand.joints {
            let place = examples
                .joint_order
                .iter()
                .position(|name| *name == joint.name);
            x.push(template.qpos[place.ok_or(format!("no angle of {}", joint.name))?]);
        }
        let mut posed = PosedHand::default();
        hand.pose(&x, &mut posed);
        let touch = |contact: &Annotated| {
            let link = hand.link(&contact.body)?;
            let frame = &posed.object_from_link[link.0];
            let normal = Vector3::from(contact.normal_body);
            Some(TouchingPatch {
                patch: anatomy.patch_on(&hand, link, &normal)?,
                link,
                point: frame.point(&Vector3::from(contact.point_body)),
                normal: frame.direction(&normal),
                object_normal: -frame.direction(&normal),
                weight_mm2: ANNOTATED_MM2,
            })
        };
        let touches: Option<Vec<TouchingPatch>> = template.contacts.iter().map(touch).collect();
        let touches = touches.ok_or("a contact is on no link of this hand")?;
        let truth = Taxonomy::feix().numbered(template.feix_number);
        let truth = truth.ok_or("a template has no type")?;
        let mut contact = Contact {
            parts_mm: [f64::INFINITY; 6],
            bones_mm: Vec::new(),
        };
        for touch in &touches {
            let part = match touch.patch {
                Patch::Palm(_) => PALM,
                Patch::Digit(digit, ..) => digit,
            };
            contact.parts_mm[part] = 0.0;
        }
        cases.push(Case {
            id: format!("template {}", template.feix_number),
            object: template.feix_number.to_string(),
            truth,
            agrees: agrees(truth, &contact.touching(NEAR_MM)),
            contact,
            label: label_contacts(rule, &anatomy, &posed, &touches, None),
            x,
        });
    }
    Ok(cases)
}
