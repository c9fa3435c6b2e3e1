//! Figure 6 of Liu et al. (2021): the same samples before and after refinement, and whether a high ‖Gc‖ detects trapped
//! samples → `figures/refinement.png`, `figures/refinement_roc.png`, `figures/refinement.md`
//!
//! Each method has four hundred chains on the round bottle. A sample is trapped if its contacts have no force closure at μ
//! = 0.5 by the exact test with the normals of the exact mesh. The pictures show the samples at five quantiles of ‖Gc‖
//! after refinement. `cargo run --release --example refinement`; `-- --quick`: 12 short chains, into `target/`.

#[path = "../method.rs"]
#[expect(dead_code, reason = "each program uses a part")]
mod method;
mod picture;
mod report;
#[path = "../roc.rs"]
mod roc;

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::grasp::paper::PaperSettings;
use landscape::grasp::{Grasp, Judgement};
use landscape::hand::Hand;
use landscape::object::Object;
use method::Method;
use rayon::prelude::*;
use roc::{Roc, RocError};

const OBJECT: &str = "bottle_round";
const SEED: u64 = 6;
const CHAINS: u64 = 400;

/// A sample before or after refinement.
struct State {
    grasp: Grasp,
    judgement: Judgement,
    /// Mean distance of the contacts from the exact mesh, metres.
    mean_distance_m: f64,
}

struct Sample {
    chain: u64,
    before: State,
    after: State,
    /// E(H, x, O) after refinement.
    energy: f64,
}

/// All samples of a method, in ascending order of ‖Gc‖ after refinement.
struct Series {
    name: &'static str,
    /// What the energy is made of, and the name of the refinement.
    about: String,
    method: Method,
    samples: Vec<Sample>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let folder = PathBuf::from(if quick { "target" } else { "figures" });
    let object = Arc::new(Object::named(OBJECT)?);
    let hand = Arc::new(Hand::human());
    let chains = if quick { 12 } else { CHAINS };
    let mut all = Vec::new();
    for (mut settings, refinement) in [
        (PaperSettings::printed(), "descent, contacts held"),
        (PaperSettings::released(), "1000 cold noisy steps"),
    ] {
        if quick {
            settings.steps = 500;
        }
        let method = Method::paper(&hand, &object, settings);
        let about = format!("{} contacts, refined by {refinement}", settings.contacts);
        all.push(run(method.name(), about, method, chains));
    }
    // Chains that end without a grasp count; otherwise there would be no trapped samples.
    let closed = Method::closed(&hand, &object)?;
    let about = "an elastic layer, refined by descent".to_owned();
    all.push(run("closed, first attempt", about, closed, chains));
    picture::sheet(&all).save(&folder.join("refinement.png"))?;
    picture::curves(&all)
        .draw()?
        .with_pixels_per_unit(1)
        .save(&folder.join("refinement_roc.png"))?;
    fs::write(folder.join("refinement.md"), report::text(&all))?;
    Ok(())
}

fn run(name: &'static str, about: String, method: Method, chains: u64) -> Series {
    let sample = |chain| {
        let end = method.run(SEED, chain, &mut |_, _| ());
        Sample {
            chain,
            before: State::new(&method, end.raw),
            after: State::new(&method, end.refined),
            energy: end.energy,
        }
    };
    let mut samples: Vec<Sample> = (0..chains).into_par_iter().map(sample).collect();
    samples.sort_by(|a, b| {
        let norm = |sample: &Sample| sample.after.judgement.net_wrench;
        norm(a).total_cmp(&norm(b)).then(a.chain.cmp(&b.chain))
    });
    Series {
        name,
        about,
        method,
        samples,
    }
}

impl State {
    fn new(method: &Method, grasp: Grasp) -> Self {
        let measured = method.contacts(&grasp);
        let sum: f64 = measured.iter().map(|m| m.distance_m.abs()).sum();
        Self {
            judgement: method.judge(&grasp),
            mean_distance_m: sum / measured.len() as f64,
            grasp,
        }
    }

    fn caption(&self) -> String {
        format!(
            "‖Gc‖ {:.2}   {:.1} mm",
            self.judgement.net_wrench,
            1e3 * self.mean_distance_m
        )
    }
}

/// Properties of a refined sample that a score should detect.
#[derive(Clone, Copy, PartialEq)]
enum Truth {
    /// There is no force closure at μ = 0.5.
    NoForceClosure,
    /// There is no force closure, or a contact is more than 2 mm off the mesh.
    NoGrasp,
}

impl Truth {
    const ALL: [Self; 2] = [Self::NoForceClosure, Self::NoGrasp];

    fn name(self) -> &'static str {
        match self {
            Self::NoForceClosure => "without closure",
            Self::NoGrasp => "no grasp",
        }
    }

    fn of(self, state: &State) -> bool {
        let judgement = &state.judgement;
        !judgement.force_closure || (self == Self::NoGrasp && judgement.gap_m > 0.002)
    }
}

/// Score that should detect it.
#[derive(Clone, Copy)]
enum Score {
    NetWrench,
    MeanDistance,
    Energy,
}

impl Score {
    const ALL: [Self; 3] = [Self::NetWrench, Self::MeanDistance, Self::Energy];

    fn name(self) -> &'static str {
        match self {
            Self::NetWrench => "‖Gc‖",
            Self::MeanDistance => "distance",
            Self::Energy => "energy",
        }
    }

    fn of(self, sample: &Sample) -> f64 {
        match self {
            Self::NetWrench => sample.after.judgement.net_wrench,
            Self::MeanDistance => sample.after.mean_distance_m,
            Self::Energy => sample.energy,
        }
    }
}

impl Series {
    fn roc(&self, score: Score, truth: Truth) -> Result<Roc, RocError> {
        let scores: Vec<f64> = self.samples.iter().map(|s| score.of(s)).collect();
        let trapped: Vec<bool> = self.samples.iter().map(|s| truth.of(&s.after)).collect();
        Roc::new(&scores, &trapped)
    }

    /// Number of trapped refined samples.
    fn trapped(&self, truth: Truth) -> usize {
        let states = self.samples.iter().map(|sample| &sample.after);
        states.filter(|state| truth.of(state)).count()
    }

    /// The samples at this many quantiles of ‖Gc‖ after refinement, evenly spaced from the least to the largest.
    fn quantiles(&self, count: usize) -> impl Iterator<Item = &Sample> {
        let last = self.samples.len() - 1;
        (0..count).map(move |k| &self.samples[(k * last + (count - 1) / 2) / (count - 1)])
    }
}

/// An area with its 95 % interval, if there is one.
fn area(roc: &Roc) -> String {
    let [low, high] = roc.interval(1.96);
    if low.is_nan() || high.is_nan() {
        return format!("{:.2}", roc.area);
    }
    format!("{:.2} ({low:.2}–{high:.2})", roc.area)
}
