//! Published hands and the built-in ones: do they load, how far are they from `MuJoCo`'s kinematics, how many of their
//! chains end in a grasp, and how many of these hold? → `figures/published_hands.md`, `.png`, `.csv`
//!
//! Published hands are sought in the folder `hands` of `LANDSCAPE_TEST_DATA`. Each hand has 24 chains on the round bottle, whose grasps are dropped. Runs in the .csv are not repeated, unless the
//! derived properties of the hand have changed; delete it to start again. Times are printed to the terminal.

#[expect(dead_code, reason = "each program uses a part")]
#[path = "../chains.rs"]
mod chains;
mod closed;
#[path = "../../tests/published/mod.rs"]
mod published;
#[path = "../table.rs"]
mod table;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use landscape::agreement::wilson;
use landscape::figure::contact_sheet;
use landscape::hand::{HAND_NAMES, Hand, HandError, HandFiles};
use landscape::store::content_hash;
use published::{DEX_URDF, Difference, REFERENCES};
use table::Table;

const HEADER: &str = "name,object,chains,kept,held,shown";

/// The same files in their published form. `MuJoCo` refuses some, and some refer to missing meshes.
const ORIGINALS: [&str; 7] = [
    "shadow_dexgraspnet/original/shadow_hand_wrist_free.xml",
    "shadow_dexgraspnet/original/shadow_hand_vis.xml",
    "shadow_dexonomy/original/right.xml",
    "mano/original/right.xml",
    "allegro/original/right.xml",
    "urdf/shadow_hand_right.urdf",
    "urdf/allegro_hand_right.urdf",
];

/// A hand that loads.
struct Loaded {
    name: String,
    hand: Arc<Hand>,
    /// Identifies the derived properties of the hand.
    derived: String,
    difference: Option<Difference>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut loaded, mut refused) = (Vec::new(), Vec::new());
    let mut take =
        |name: &str, files: Result<HandFiles, HandError>, reference: Option<PathBuf>| match files
            .and_then(|files| load(name, &files, reference.as_deref()))
        {
            Ok(hand) => loaded.push(hand),
            Err(error) => refused.push((name.to_owned(), error.to_string())),
        };
    for name in HAND_NAMES {
        take(name, HandFiles::named(name), None);
    }
    let folder = published::folder().ok_or("set LANDSCAPE_TEST_DATA")?;
    for [description, reference] in REFERENCES {
        let path = folder.join(description);
        take(
            description,
            HandFiles::load(&path),
            Some(folder.join(reference)),
        );
    }
    for [description, reference] in DEX_URDF {
        let files = HandFiles::load_within(&folder.join(description), &folder);
        take(description, files, Some(published::of_dex_urdf(reference)));
    }
    for description in ORIGINALS {
        take(
            description,
            HandFiles::load(&folder.join(description)),
            None,
        );
    }
    let csv = Path::new("figures/published_hands.csv");
    let mut closed = Table::read(csv, HEADER)?;
    let mut keys = Vec::new();
    let (mut images, mut captions) = (Vec::new(), Vec::new());
    for (number, entry) in loaded.iter().enumerate() {
        let key = entry.key();
        if closed.of(&key).is_empty() {
            let started = Instant::now();
            let row = closed::measure(&entry.hand)?;
            let seconds = started.elapsed().as_secs_f64();
            eprintln!("{}: kept, held, shown {row:?}, {seconds:.0} s", entry.name);
            closed.set(&key, [&row[..]]);
        }
        keys.push(key);
        closed.write(csv, &keys)?;
        let shown = closed.of(&keys[number])[0][2];
        images.push(closed::picture(&entry.hand, shown)?);
        captions.push(format!("{}   {}", number + 1, entry.hand.name));
    }
    let picture = Path::new("figures/published_hands.png");
    contact_sheet(&images, &captions, 5, picture)?;
    let text = text(&loaded, &refused, &closed)?;
    fs::write("figures/published_hands.md", text)?;
    Ok(())
}

impl Loaded {
    /// Its key in the table.
    fn key(&self) -> String {
        let (object, chains) = (closed::OBJECT, closed::CHAINS);
        format!("{} {},{object},{chains}", self.name, self.derived)
    }
}

fn load(name: &str, files: &HandFiles, reference: Option<&Path>) -> Result<Loaded, HandError> {
    let started = Instant::now();
    let hand = Hand::from_files(files)?;
    let seconds = started.elapsed().as_secs_f64();
    eprintln!("{name}: derived in {seconds:.2} s");
    let derived = files.derived_side_file()?;
    Ok(Loaded {
        name: name.to_owned(),
        derived: content_hash(&[derived.as_bytes()])[..8].to_owned(),
        difference: reference.map(|path| Difference::of(&hand, &published::reference(path))),
        hand: Arc::new(hand),
    })
}

fn text(
    loaded: &[Loaded],
    refused: &[(String, String)],
    closed: &Table,
) -> Result<String, Box<dyn Error>> {
    let mut text = format!(
        "# Published hands\n\nNothing is annotated but what their side files say, and only those of our own have one. \
         The error of the kinematics is the largest over all links and some configurations, against MuJoCo 4.0.0. \
         *Kept* are grasps on {} that pass the strict filter, of {} chains with the default energy; *hold* are those of them \
         that keep the bottle when it drops (with the 95 % interval). The seed is {}. The picture shows a grasp of each hand that holds.\n\n\
         ![A grasp of each hand](published_hands.png)\n\n\
         | | hand | links | joints | digits | kinematics off by | kept | hold |\n\
         |---|---|---|---|---|---|---|---|\n",
        closed::OBJECT,
        closed::CHAINS,
        closed::SEED,
    );
    for (number, entry) in loaded.iter().enumerate() {
        let hand = &entry.hand;
        let off = entry.difference.as_ref().map_or("–".to_owned(), |off| {
            format!("{:.0e} m, {:.0e} rad", off.metres, off.radians)
        });
        let rows = closed.of(&entry.key());
        let [kept, held, _] = rows[0][..] else {
            return Err("a row of the table is broken".into());
        };
        let hold = if kept > 0.0 {
            let [low, high] = wilson(held, kept).map(|share| 100.0 * share);
            format!("{:.0} % ({low:.0}–{high:.0} %)", 100.0 * held / kept)
        } else {
            "–".to_owned()
        };
        let thumb = if hand.has_thumb() { ", a thumb" } else { "" };
        let _ = write!(
            text,
            "| {} | {} | {} | {} | {}{thumb} | {off} | {kept} of {} | {hold}",
            number + 1,
            entry.name,
            hand.links.len(),
            hand.joints.len(),
            hand.digits.len() - 1,
            closed::CHAINS,
        );
        text.push_str(" |\n");
    }
    if !refused.is_empty() {
        text.push_str("\nRefused, and what is said then:\n");
        let folder = published::folder().unwrap_or_default();
        for (name, error) in refused {
            // Tags in the sentence are no tags of the page.
            let error = (error.replace(&*folder.to_string_lossy(), "…")).replace('<', "\\<");
            let _ = writeln!(text, "- {name}: {error}");
        }
    }
    Ok(text)
}
