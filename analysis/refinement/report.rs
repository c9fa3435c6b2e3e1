//! The tables.

use std::fmt::Write;

use super::{OBJECT, SEED, Sample, Score, Series, State, Truth, area};

/// Threshold of ‖Gc‖ in Eq. 11.
const THRESHOLD: f64 = 0.5;

pub(crate) fn text(all: &[Series]) -> String {
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
        let medians = |of: fn(&State) -> f64| {
            [
                median(series, |s| of(&s.before)),
                median(series, |s| of(&s.after)),
            ]
        };
        let [norm_before, norm_after] = medians(|state| state.judgement.net_wrench);
        let [far, near] = medians(|state| 1e3 * state.mean_distance_m);
        let _ = write!(
            text,
            "| {} | {} | {norm_before:.3} | {norm_after:.3} | {far:.2} | {near:.2}",
            series.name,
            series.samples.len(),
        );
        for truth in Truth::ALL {
            let share = |of: fn(&Sample) -> &State| {
                let free = series.samples.iter().filter(|s| !truth.of(of(s))).count();
                100.0 * free as f64 / series.samples.len() as f64
            };
            let (before, after) = (share(|s| &s.before), share(|s| &s.after));
            let _ = write!(text, " | {before:.1} % | {after:.1} %");
        }
        text.push_str(" |\n");
    }
    areas(&mut text, all);
    threshold(&mut text, all);
    pictured(&mut text, all);
    text
}

fn median(series: &Series, of: impl Fn(&Sample) -> f64) -> f64 {
    let mut values: Vec<f64> = series.samples.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    0.5 * (values[half] + values[(values.len() - 1) / 2])
}

fn areas(text: &mut String, all: &[Series]) {
    text.push_str(
        "\n## Which score tells the trapped samples?\n\nArea below the ROC curve after refinement (½: knows nothing), with \
         DeLong's 95 % interval (none where the classes do not overlap, or one has a single case). Distance: mean contact \
         distance; energy: E(H, x, O) of the method itself.\n\n| method | trapped means | trapped |",
    );
    for score in Score::ALL {
        let _ = write!(text, " {} |", score.name());
    }
    text.push_str("\n|---|---|---|---|---|---|\n");
    for series in all {
        for truth in Truth::ALL {
            let name = truth.name();
            let _ = write!(
                text,
                "| {} | {name} | {} of {} |",
                series.name,
                series.trapped(truth),
                series.samples.len()
            );
            for score in Score::ALL {
                let cell = series
                    .roc(score, truth)
                    .map_or_else(|_| "–".to_owned(), |roc| area(&roc));
                let _ = write!(text, " {cell} |");
            }
            text.push('\n');
        }
    }
}

fn threshold(text: &mut String, all: &[Series]) {
    let _ = write!(
        text,
        "\n## The threshold of Eq. 11\n\nWhat ‖Gc‖ ≥ {THRESHOLD} says after refinement.\n\n| method | trapped means | trapped and \
         found | trapped and missed | free and accused | free and left alone |\n|---|---|---|---|---|---|\n"
    );
    for series in all {
        for truth in Truth::ALL {
            let name = truth.name();
            let _ = write!(text, "| {} | {name} |", series.name);
            for (trapped, accused) in [(true, true), (true, false), (false, true), (false, false)] {
                let cases = series.samples.iter().filter(|sample| {
                    let high = Score::NetWrench.of(sample) >= THRESHOLD;
                    truth.of(&sample.after) == trapped && high == accused
                });
                let _ = write!(text, " {} |", cases.count());
            }
            text.push('\n');
        }
    }
}

fn pictured(text: &mut String, all: &[Series]) {
    text.push_str(
        "\n## The samples in the picture\n\nThose at the quantiles 0, 25, 50, 75 and 100 % of ‖Gc‖ after refinement.\n\n| method | \
         chain | ‖Gc‖ before | after | mean contact distance before, mm | after, mm | least friction after | closure |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for series in all {
        for sample in series.quantiles(5) {
            let (before, after) = (&sample.before, &sample.after);
            let friction = after.judgement.least_friction;
            let _ = writeln!(
                text,
                "| {} | {} | {:.3} | {:.3} | {:.2} | {:.2} | {} | {} |",
                series.name,
                sample.chain,
                before.judgement.net_wrench,
                after.judgement.net_wrench,
                1e3 * before.mean_distance_m,
                1e3 * after.mean_distance_m,
                friction.map_or("∞".to_owned(), |f| format!("{f:.2}")),
                if after.judgement.force_closure {
                    "yes"
                } else {
                    "no"
                },
            );
        }
    }
}
