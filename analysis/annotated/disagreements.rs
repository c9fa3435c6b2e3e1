//! Grasps that the rule and a person name differently → `figures/annotated_disagreements.png` and `.md`

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use landscape::figure::{Image, Scene, Surface, contact_sheet};
use landscape::hand::PosedHand;
use landscape::object::Object;
use nalgebra::Vector3;

use crate::Failure;
use crate::case::{Case, Measure};
use crate::people::{hand_of, mesh_of};

/// Number of disagreements, and the most of one object.
const COUNT: usize = 10;
const OF_ONE_OBJECT: usize = 2;
/// Width and height of a picture.
const SIDE: u32 = 330;
const COLUMNS: usize = 4;

/// What was seen in the pictures: the grasp, who is right, and what a second annotator would decide.
const SEEN: [(&str, &str, &str); 10] = [
    (
        "12",
        "the person: palm and first phalanges are clear of the apple, only the ends of two fingers and the thumb hold it",
        "Tripod",
    ),
    (
        "225",
        "open: three digits as in a Tripod, but a ball of 96 mm lies along two whole fingers, as in Sphere 3 Finger",
        "either, half and half",
    ),
    (
        "110",
        "the rule: the handle lies on the thumb side of the middle finger, with the index on top",
        "Lateral Tripod or Prismatic 2 Finger",
    ),
    (
        "13",
        "the person: two nearly straight fingers over the apple, the tip of the thumb below, the palm clear",
        "Tripod",
    ),
    (
        "310",
        "the person in the category: a corner of the cube between three digits; the palm is just behind it and does not press",
        "Tripod or Prismatic 2 Finger",
    ),
    (
        "323",
        "neither: index and middle finger hold, so it is no Ring; a box of 93 mm is no sphere either",
        "Prismatic 2 Finger or Ring",
    ),
    (
        "97",
        "the person: a plate by its rim, straight fingers below and the thumb on top, is the textbook Extension Type",
        "Extension Type",
    ),
    (
        "96",
        "the person, as in the picture before",
        "Extension Type",
    ),
    (
        "176",
        "neither: the index finger is stretched but lies on nothing; the thumb presses the shank against the middle finger",
        "Lateral Tripod, or unlisted",
    ),
    (
        "33",
        "the person: the ring finger is near the plum but stands beside it",
        "Sphere 3 Finger",
    ),
];

/// The disagreements about which the rule is most certain, none of which is about the third that was not looked at.
fn chosen(cases: &[Case]) -> Vec<&Case> {
    let score = |case: &Case| case.label.best.first().map_or(0.0, |best| best.score);
    let mut wrong: Vec<&Case> = cases
        .iter()
        .filter(|case| !case.right(Measure::Type))
        .collect();
    wrong.sort_by(|a, b| score(b).total_cmp(&score(a)).then(a.id.cmp(&b.id)));
    let mut of_object: BTreeMap<&str, usize> = BTreeMap::new();
    wrong.retain(|case| {
        let count = of_object.entry(&case.object).or_insert(0);
        *count += 1;
        *count <= OF_ONE_OBJECT
    });
    wrong.truncate(COUNT);
    wrong
}

/// Draws the disagreements among these cases and writes the table beside the picture, `stem` without ending.
pub(crate) fn write(cases: &[Case], people: &Path, stem: &Path, rule: &str) -> Result<(), Failure> {
    let chosen = chosen(cases);
    let hand = hand_of(people)?;
    let skin = hand.skin();
    let mut images: Vec<Image> = Vec::new();
    let mut captions = Vec::new();
    let mut text = format!(
        "# Ten grasps that the rule and a person name differently\n\n\
         `LANDSCAPE_TEST_DATA=… cargo run --release --example annotated`, rule {rule}. Of the objects that were looked at, the \
         disagreements about which the rule is most certain, at most {OF_ONE_OBJECT} of an object, from two sides in \
         [annotated_disagreements.png](annotated_disagreements.png). *Touch*: digits within 5 mm by the rule, P the palm. The \
         last two columns are a judgement from the pictures and the definitions of the types, not a second annotation.\n\n\
         | | object | grasp | the person | the rule | probability | label | touch | the person's label agrees with contact | who is right | a second annotator |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for (place, case) in chosen.iter().enumerate() {
        let object = Object::load(mesh_of(people, &case.object)?)?;
        let mut posed = PosedHand::default();
        hand.pose(&case.x, &mut posed);
        let scene = Scene {
            surfaces: vec![
                Surface::of_hand(&skin, &posed),
                Surface::of_mesh(&object.mesh),
            ],
            ..Scene::default()
        };
        // From the palm's side and from the thumb's.
        let palm = hand.palm_at(&case.x[7..]);
        let root = &posed.object_from_link[0];
        let [volar, distal] = [palm.volar, palm.distal].map(|axis| root.direction(&axis));
        let radial = distal.cross(&volar);
        for toward_eye in [
            volar * 0.75 + radial * 0.5 + distal * 0.45,
            radial * 0.9 - volar * 0.2 + distal * 0.4,
        ] {
            let eye: Vector3<f64> = toward_eye.normalize();
            images.push(scene.render(&scene.framed(eye, distal), SIDE, SIDE));
        }
        let found = case.found_type().map_or("nothing", |found| &found.name);
        let score = case.label.best.first().map_or(0.0, |best| best.score);
        captions.push(format!("{}: person {}", place + 1, case.truth.name));
        captions.push(format!("rule {found} {score:.2}"));
        let seen = SEEN.iter().find(|(id, ..)| *id == case.id);
        let (right, second) = seen.map_or(("", ""), |(_, right, second)| (right, second));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {found} | {score:.2} | {} | {} | {} | {right} | {second} |",
            place + 1,
            case.object,
            case.id,
            case.truth.name,
            case.label.text(),
            case.label.virtual_fingers,
            if case.agrees { "yes" } else { "no" },
        );
    }
    contact_sheet(&images, &captions, COLUMNS, &stem.with_extension("png"))?;
    std::fs::write(stem.with_extension("md"), text)?;
    Ok(())
}
