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
#[path = "../roc.rs"]
mod roc;

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use landscape::figure::chart::{Axis, Chart, Corner, Panel, Series as Line};
use landscape::figure::theme;
use landscape::grasp::paper::PaperSettings;
use landscape::grasp::{Grasp, Judgement};
use landscape::hand::Hand;
use landscape::object::Object;
use method::Method;
use rayon::prelude::*;
use roc::Roc;

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
    Chart::new("", vec![curves(&all)])
        .draw()?
        .with_pixels_per_unit(1)
        .save(&folder.join("refinement_roc.png"))?;
    fs::write(folder.join("refinement.md"), text(&all))?;
    Ok(())
}

fn run(name: &'static str, about: String, method: Method, chains: u64) -> Series {
    let sample = |chain| {
        let end = method.run(SEED, chain, &mut |_, _| ());
        Sample {
            chain,
            before: State::new(&method, end.raw),
            after: State::new(&method, end.refined),
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

    /// Whether there is force closure at μ = 0.5, and whether every contact is within 2 mm of the mesh as well.
    fn holds(&self) -> [bool; 2] {
        let Judgement {
            force_closure,
            gap_m,
            ..
        } = self.judgement;
        [force_closure, force_closure && gap_m <= 0.002]
    }
}

impl Series {
    /// ‖Gc‖ of the refined samples with or without force closure.
    fn norms(&self, closed: bool) -> Vec<f64> {
        let states = self.samples.iter().map(|sample| &sample.after);
        let own = states.filter(|state| state.holds()[0] == closed);
        own.map(|state| state.judgement.net_wrench).collect()
    }

    /// How well a high ‖Gc‖ tells the samples without force closure, and the number of these.
    fn roc(&self) -> (Option<Roc>, usize) {
        let trapped = self.norms(false);
        (Roc::new(&trapped, &self.norms(true)), trapped.len())
    }

    fn median(&self, of: impl Fn(&Sample) -> f64) -> f64 {
        let mut values: Vec<f64> = self.samples.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        let half = values.len() / 2;
        0.5 * (values[half] + values[(values.len() - 1) / 2])
    }
}

/// The curves: share of trapped samples above a threshold against share of other samples above it.
fn curves(all: &[Series]) -> Panel {
    let chance = Line::line(vec![[0.0, 0.0], [1.0, 1.0]]).coloured(theme::PALE_LINE);
    let mut lines = vec![chance.dashed()];
    for (place, series) in all.iter().enumerate() {
        if let (Some(roc), trapped) = series.roc() {
            let (name, count) = (series.name, series.samples.len());
            let name = format!("{name}, {trapped} of {count}: {}", roc.text());
            let line = Line::line(roc.points).coloured(theme::series(place));
            lines.push(line.named(&name));
        }
    }
    Panel {
        legend: Some(Corner::LowerRight),
        ..Panel::new(
            "does a high ‖Gc‖ tell samples without force closure?",
            Axis::linear("share of the others taken for such").with_range(0.0, 1.0),
            Axis::linear("share of them found").with_range(0.0, 1.0),
            lines,
        )
    }
}

fn text(all: &[Series]) -> String {
    let mut text = format!(
        "# Before and after refinement, and who is trapped\n\n\
         Chains on `{OBJECT}`, seed {SEED}. Contacts are measured on the exact mesh; *closure*: exact force closure at μ = 0.5; \
         *grasp*: closure, and every contact within 2 mm of the mesh. ‖Gc‖ is that of the exact mesh, its arms divided by the method's \
         own unit (object radius; 120 mm as released). Medians over all samples. *Closed*: \
         the default energy, which has no contact set, so that the best set of each pose is judged, and which refines an end on the energy that does not name the digits of a grip. Written by `cargo run --release --example refinement`.\n\n\
         | method | chains | ‖Gc‖ before | after | mean contact distance before, mm | after, mm | closure before | after | grasp \
         before | after |\n|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for series in all {
        let _ = write!(
            text,
            "| {} | {} | {:.3} | {:.3} | {:.2} | {:.2}",
            series.name,
            series.samples.len(),
            series.median(|sample| sample.before.judgement.net_wrench),
            series.median(|sample| sample.after.judgement.net_wrench),
            series.median(|sample| 1e3 * sample.before.mean_distance_m),
            series.median(|sample| 1e3 * sample.after.mean_distance_m),
        );
        for which in [0, 1] {
            for state in [|s: &Sample| s.before.holds(), |s: &Sample| s.after.holds()] {
                let held = series.samples.iter().filter(|s| state(s)[which]).count();
                let share = 100.0 * held as f64 / series.samples.len() as f64;
                let _ = write!(text, " | {share:.1} %");
            }
        }
        text.push_str(" |\n");
    }
    text.push_str(
        "\n## Does a high ‖Gc‖ tell the trapped samples?\n\nArea below the ROC curve after refinement (½: knows nothing), with \
         DeLong's 95 % interval (none where the classes do not overlap, or one has a single case).\n\n\
         | method | trapped means | trapped | ‖Gc‖ |\n|---|---|---|---|\n",
    );
    for series in all {
        let (roc, trapped) = series.roc();
        let area = roc.map_or("–".to_owned(), |roc| roc.text());
        let (name, count) = (series.name, series.samples.len());
        let _ = writeln!(
            text,
            "| {name} | without closure | {trapped} of {count} | {area} |"
        );
    }
    text
}
