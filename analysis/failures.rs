//! Figure 11 of Liu et al. (2021): known failures → `figures/failures.png`, `.md`
//!
//! The failures are contacts that all lie in one concavity, and thin parts of the object that pass between the hand's
//! surface points. For each, the upper row shows the first chain of the paper's method, as printed, with ‖Gc‖ < 0.5 that
//! fails in this way. Below is the first grasp of the default energy on the same object. The table counts both failures
//! among the first chains of both.

mod between_points;
#[expect(dead_code, reason = "each program uses a part")]
mod method;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use between_points::passes_between_points;
use landscape::figure::{Image, Scene, contact_sheet};
use landscape::grasp::Judgement;
use landscape::grasp::depth::object_inside_hand_m;
use landscape::grasp::filter::STRICT_FRICTION;
use landscape::grasp::paper::PaperSettings;
use landscape::hand::{Hand, PosedHand, Skin};
use landscape::object::Object;
use method::Method;
use nalgebra::Vector3;
use rayon::prelude::*;

const SEED: u64 = 11;
/// Number of counted chains.
const CHAINS: u64 = 64;
/// Largest number of chains searched for an example. `AT_ONCE` chains run at a time.
const SEARCHED: u64 = 2_048;
const AT_ONCE: u64 = 64;
const SIDE: u32 = 330;
const CONE_M: f64 = 0.025;

/// Shown cases: an object and the failure of the hand on it.
const SHOWN: [(&str, Failure); 3] = [
    ("mug", Failure::OneConcavity),
    ("pen", Failure::ThinPart),
    ("bowl", Failure::ThinPart),
];
const COUNTED: [&str; 4] = ["mug", "bowl", "pen", "disk"];

#[derive(Clone, Copy, PartialEq)]
enum Failure {
    OneConcavity,
    ThinPart,
}

/// The end of a chain and its properties.
struct End {
    found: method::End,
    judgement: Judgement,
    thin_part: bool,
    /// Depth of the object inside the hand.
    swallowed_m: f64,
}

impl End {
    fn fails(&self, failure: Failure) -> bool {
        self.balances()
            && match failure {
                Failure::OneConcavity => self.judgement.one_concavity,
                Failure::ThinPart => self.thin_part,
            }
    }

    /// The relaxed test, which does not detect these failures alone.
    fn balances(&self) -> bool {
        self.judgement.net_wrench < 0.5
    }
}

/// The paper's method, as printed, or the default one on an object.
struct Chains(Method);

impl Chains {
    fn run(&self, chains: std::ops::Range<u64>) -> Vec<End> {
        let run = |chain| {
            let found = self.0.run(SEED, chain, &mut |_, _| ());
            let (hand, object) = (self.0.hand(), self.0.object());
            let mut posed = PosedHand::default();
            hand.pose(&found.refined.pose, &mut posed);
            End {
                judgement: self.0.judge(&found.refined),
                thin_part: passes_between_points(&object.exact, hand, &posed),
                swallowed_m: object_inside_hand_m(&object.exact, hand, &posed),
                found,
            }
        };
        chains.into_par_iter().map(run).collect()
    }

    /// The first chain whose end satisfies a condition.
    fn first(&self, wanted: impl Fn(&End) -> bool) -> Option<End> {
        (0..SEARCHED / AT_ONCE).find_map(|batch| {
            let ends = self.run(batch * AT_ONCE..(batch + 1) * AT_ONCE);
            ends.into_iter().find(&wanted)
        })
    }

    fn picture(&self, skin: &Skin, end: &End) -> Image {
        let (hand, object) = (self.0.hand(), self.0.object());
        let scene = Scene::of_grasp(hand, skin, object, &end.found.refined).with_friction_cones(
            &object.exact,
            STRICT_FRICTION,
            CONE_M,
        );
        scene.render(&scene.best_camera(Vector3::z()), SIDE, SIDE)
    }

    /// A row of the table.
    fn row(&self, text: &mut String) {
        let ends = self.run(0..CHAINS);
        let count = |test: &dyn Fn(&End) -> bool| ends.iter().filter(|end| test(end)).count();
        let strict = |end: &End| end.judgement.passes_strict();
        let _ = write!(text, "| {} | {} |", self.0.object().name, self.0.name());
        for among in [&End::balances as &dyn Fn(&End) -> bool, &strict] {
            let _ = write!(
                text,
                " {} | {} | {} | {} |",
                count(among),
                count(&|end| among(end) && end.judgement.digits == 1),
                count(&|end| among(end) && end.fails(Failure::OneConcavity)),
                count(&|end| among(end) && end.fails(Failure::ThinPart)),
            );
        }
        let deepest_m = ends
            .iter()
            .filter(|end| strict(end))
            .map(|end| end.swallowed_m)
            .fold(f64::NAN, f64::max);
        if deepest_m.is_nan() {
            text.push_str(" – |\n");
        } else {
            let _ = writeln!(text, " {:.1} |", 1e3 * deepest_m);
        }
        eprintln!("{} on {} counted", self.0.name(), self.0.object().name);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let hand = Arc::new(Hand::human());
    let skin = hand.skin();
    let methods = |name: &str| -> Result<[Chains; 2], Box<dyn Error>> {
        let object = Arc::new(Object::named(name)?);
        Ok([
            Chains(Method::paper(&hand, &object, PaperSettings::printed())),
            Chains(Method::closed(&hand, &object)?),
        ])
    };
    let mut rows: [Vec<(Image, String)>; 2] = Default::default();
    for (name, failure) in SHOWN {
        let [paper, closed] = methods(name)?;
        let failing = paper
            .first(|end| end.fails(failure))
            .ok_or_else(|| format!("no chain of {SEARCHED} fails so on the {name}"))?;
        let what = match failure {
            Failure::OneConcavity => "one concavity",
            Failure::ThinPart => "thin part",
        };
        let caption = format!("as printed, chain {}: {what}", failing.found.chain);
        rows[0].push((paper.picture(&skin, &failing), caption));
        let grasp = closed
            .first(|end| end.judgement.passes_strict())
            .ok_or_else(|| format!("no grasp of the {name}"))?;
        let caption = format!("closed, chain {}", grasp.found.chain);
        rows[1].push((closed.picture(&skin, &grasp), caption));
    }
    let (images, captions): (Vec<Image>, Vec<String>) = rows.into_iter().flatten().unzip();
    let sheet = Path::new("figures/failures.png");
    contact_sheet(&images, &captions, SHOWN.len(), sheet)?;

    let mut rows = String::new();
    for name in COUNTED {
        for chains in methods(name)? {
            chains.row(&mut rows);
        }
    }
    fs::write("figures/failures.md", text(&rows))?;
    Ok(())
}

fn text(rows: &str) -> String {
    format!(
        "Two known failures among the refined ends of {CHAINS} chains (seed {SEED}) of each method: of those that pass the \
         relaxed test ‖Gc‖ < 0.5, and of those that pass the strict filter, which is what `synth` keeps.\n\n\
         *As printed*: the formulae and Algorithm 1 of the paper; *closed*: the default energy. *One digit*: all contacts on \
         one finger, the thumb or the palm. *One concavity*: every two contacts see each other \
         past the object. *Thin part*: the object lies more than 4 mm inside the hand while no surface point of the hand is \
         2 mm inside the object; last column: the deepest that it lies inside the hand of a strict grasp. Both depths are \
         those of the whole mesh, triangle by triangle, so nothing lies between points.\n\n\
         | object | method | ‖Gc‖ < 0.5 | one digit | one concavity | thin part | strict | one digit | one concavity | thin part | deepest, mm |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n\
         {rows}\n\
         What removes them: contacts on at least two of palm, thumb and fingers and not all in one concavity, and nothing of \
         the object deeper than 1 mm inside the hand (all in the strict filter, for which a chain makes several attempts, so \
         no strict grasp can fail so).\n"
    )
}
