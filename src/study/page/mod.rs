//! A page (one HTML file) on which a landscape or a file of grasps is explored.
//!
//! Rust computes: the coordinates of tree and graph, the ways with their energies, the touched places, the statements about
//! trust. The page paints, poses the hand and filters. It needs no other file and no network: its two scripts are inlined,
//! named by their hashes in a content security policy that forbids all requests.
//!
//! | file of `web` | holds |
//! | --- | --- |
//! | `page.html`, `page.css` | the frame of the page and its look |
//! | `data.js` | unpacking of what `pack.rs` wrote |
//! | `kinematics.js` | forward kinematics and skinning, as in [`hand`](crate::hand) |
//! | `filter.js` | the language of the search field |
//! | `basins.js`, `route.js` | superbasins of a tree; ways between minima |
//! | `text.js` | words and numbers as texts |
//! | `state.js` | the selection, filter and level that all panels share, and their form in the address |
//! | `looks.js` | colours, and the look of each item |
//! | `dom.js` | small helpers: elements, buttons, what the browser remembers |
//! | `pen.js` | painting on a canvas or into an SVG file |
//! | `tree.js`, `graph.js`, `way.js`, `table.js`, `matrix.js`, `trust.js`, `flat.js`, `tangle.js`, `likeness.js` | the panels |
//! | `legend.js` | what the colours mean, and the filters that stay in sight |
//! | `words.js` | what the words of the page mean |
//! | `scene.js`, `pins.js`, `three.js` | the panels in three dimensions |
//! | `label.js`, `asked.js` | labelling by keyboard; the order in which a person is asked for labels |
//! | `export.js` | files to save: SVG, PNG, CSV, GLB |
//! | `main.js` | the start |
//!
//! The scripts are ES modules. `vendor/make.sh` bundles them, and the parts of three.js that they use, into `vendor/`, which
//! the program includes. `npm run check` in this folder checks their types (`tsc`), lints them and runs the unit tests of
//! those that need no browser (`tests`).

mod grasps;
mod hand;
mod html;
mod known;
mod labels;
mod landscape;
mod likeness;
mod pack;
mod surface;
mod touch;
mod tree;
mod trust;
mod ways;

use serde_json::{Value, json};

pub use grasps::PageGrasps;
pub use landscape::PageLandscape;
use pack::Pack;

use crate::hand::Hand;
use crate::printable::printable;
use crate::store::Manifest;
use crate::study::error::StudyError;
use crate::study::level::FamilyLevel;
use crate::study::looks;
use crate::topography::{Evidence, TreeDifference};

/// Hands, objects, and pairs of the two, each stored once.
#[derive(Debug, Default)]
struct Scenes {
    hands: Vec<(Hand, Value)>,
    objects: Vec<(String, Value)>,
    pairs: Vec<[usize; 2]>,
}

impl Scenes {
    fn page(self, command: &str, sides: &[Value], difference: &Value, pack: &Pack) -> String {
        let values = |list: Vec<Value>| Value::from(list);
        let evidence = tree::EVIDENCE.map(Evidence::name);
        let header = json!({
            "made_by": concat!("landscape ", env!("CARGO_PKG_VERSION")),
            "command": command,
            "hands": values(self.hands.into_iter().map(|(_, hand)| hand).collect()),
            "objects": values(self.objects.into_iter().map(|(_, object)| object).collect()),
            "scenes": self.pairs,
            "sides": sides,
            "difference": difference,
            "evidence": evidence,
            "taxonomy": grasps::taxonomy(),
            "looks": looks::packed(),
        });
        html::page(&pack.deflated(&header))
    }
}

/// The page of a landscape, or of two of one space with the differences between them and the distance within which minima
/// correspond. `command` recreates the page.
///
/// # Errors
/// If the tables are inconsistent, or hand, object or energy cannot be built.
///
/// # Examples
/// ```
/// use std::collections::BTreeMap;
///
/// use landscape::store::{LandscapeFiles, MinimumRow};
/// use landscape::study::{PageLandscape, landscape_page};
/// use landscape::topography::Attempts;
///
/// let minimum = |id: u64| MinimumRow { id, energy: id as f64, ..MinimumRow::default() };
/// let files = LandscapeFiles { minima: vec![minimum(0), minimum(1)], ..LandscapeFiles::default() };
/// let held = BTreeMap::new();
/// let (name, attempts) = ("two.landscape", &Attempts::default());
/// let shown = PageLandscape { name, files: &files, attempts, held: &held, energy: None };
/// let page = landscape_page(shown, None, "landscape report two.landscape")?;
/// assert!(page.contains("Content-Security-Policy"));
/// # Ok::<(), landscape::study::StudyError>(())
/// ```
pub fn landscape_page(
    landscape: PageLandscape<'_>,
    other: Option<(PageLandscape<'_>, &TreeDifference, f64)>,
    command: &str,
) -> Result<String, StudyError> {
    let (mut scenes, mut pack) = (Scenes::default(), Pack::default());
    let (side, minima) = landscape.side(&mut scenes, &mut pack, None)?;
    let mut sides = vec![side];
    let mut difference = Value::Null;
    if let Some((other, found, within)) = other {
        let guide = Some((&minima[..], &found.matches[..]));
        sides.push(other.side(&mut scenes, &mut pack, guide)?.0);
        difference = json!({
            "notes": comparison_notes([&landscape, &other].map(|side| (side.name, &side.files.manifest))),
            "within": within,
            "matches": found.matches,
            "possible": found.possible,
            "only_before": found.only_before,
            "only_after": found.only_after,
            "merges": found.merges,
        });
    }
    Ok(scenes.page(command, &sides, &difference, &pack))
}

/// What to know before two named landscapes are compared: that their objects or the levels of their families differ. Each note
/// is a sentence without a full stop.
pub fn comparison_notes([one, other]: [(&str, &Manifest); 2]) -> Vec<String> {
    let objects =
        [one, other].map(|(_, manifest)| Some((manifest.object.as_ref()?, manifest.scale)));
    let objects = match objects {
        [Some((first, scale)), Some((second, other_scale))]
            if first.content_hash != second.content_hash
                || scale.total_cmp(&other_scale).is_ne() =>
        {
            let named = |name: &str, scale| printable(&sized(name, scale), &[]).into_owned();
            Some(format!(
                "the objects differ ({}, {}): minima correspond where the hand stands alike in the frames of the two",
                named(&first.name, scale),
                named(&second.name, other_scale)
            ))
        }
        _ => None,
    };
    let levels =
        [one, other].map(|(name, manifest)| Some((name, FamilyLevel::of(manifest, None)?)));
    let levels = match &levels {
        [Some((name, level)), Some((other, other_level))] => {
            FamilyLevel::difference((name, level), (other, other_level))
        }
        _ => None,
    };
    objects.into_iter().chain(levels).collect()
}

/// Hand and object in a few words: `human on mug`.
fn subject(hand: &str, object: &str, scale: f64) -> String {
    format!("{hand} on {}", sized(object, scale))
}

/// An object with its scale, unless this is 1.
fn sized(object: &str, scale: f64) -> String {
    if scale.total_cmp(&1.0).is_eq() {
        object.to_owned()
    } else {
        format!("{object} × {scale}")
    }
}

/// The page of the grasps of a file. `command` recreates the page.
///
/// # Errors
/// If a hand, an object or the energy cannot be built.
pub fn grasp_page(grasps: PageGrasps<'_>, command: &str) -> Result<String, StudyError> {
    let (mut scenes, mut pack) = (Scenes::default(), Pack::default());
    let side = grasps.side(&mut scenes, &mut pack)?;
    Ok(scenes.page(command, &[side], &Value::Null, &pack))
}
