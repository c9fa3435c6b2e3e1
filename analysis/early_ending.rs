//! Does ending a simulation as soon as the object rests change its outcome? → `target/early_ending.md`
//!
//! `early_ending [--six-directions] GRASPS.parquet …` simulates every grasp twice, to the last step and with an early end,
//! and compares outcomes and times. The two alternate, so that other load on the machine slows both.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::Instant;

use landscape::evaluation::stability::{
    Build, Drop, Outcome, Protocol, Reason, Rest, SixDirections, Solid, simulate,
};
use landscape::store::{GraspFile, Overrides};

/// A rest criterion that is never met.
const NEVER: Rest = Rest {
    way_m: 1e-9,
    time_s: 1e3,
};

/// Both outcomes of one grasp, that of the last step first, and their times, seconds.
struct Pair {
    name: String,
    outcomes: [Outcome; 2],
    seconds: [f64; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, files): (Vec<String>, Vec<String>) = std::env::args()
        .skip(1)
        .partition(|argument| argument.starts_with("--"));
    let six = flags.iter().any(|flag| flag == "--six-directions");
    let protocols = [NEVER, Rest::default()].map(|rest| {
        if six {
            Protocol::SixDirections(SixDirections {
                rest,
                ..SixDirections::default()
            })
        } else {
            Protocol::Drop(Drop {
                rest,
                ..Drop::default()
            })
        }
    });
    let mut pairs = Vec::new();
    for file in &files {
        pairs.extend(measure(Path::new(file), &protocols)?);
    }
    let name = if six {
        "early_ending_six"
    } else {
        "early_ending"
    };
    let table = table(&pairs);
    print!("{table}");
    fs::write(format!("target/{name}.md"), table)?;
    Ok(())
}

fn measure(path: &Path, protocols: &[Protocol; 2]) -> Result<Vec<Pair>, Box<dyn Error>> {
    let (file, _) = GraspFile::read(path, Overrides::default())?;
    let mut pairs = Vec::new();
    for population in file.landscapes() {
        let hand = population.hand()?;
        let (mesh, mass_kg) = population.mesh()?;
        let solid = Solid::new(&mesh, Build::Pieces);
        for grasp in &population.grasps {
            let trials = protocols.map(|protocol| {
                let started = Instant::now();
                let outcome = simulate(&hand, &grasp.grasp, &solid, mass_kg, &protocol);
                (outcome, started.elapsed().as_secs_f64())
            });
            pairs.push(Pair {
                name: format!("{} {}", path.display(), grasp.id),
                outcomes: trials.map(|(outcome, _)| outcome),
                seconds: trials.map(|(_, seconds)| seconds),
            });
        }
    }
    Ok(pairs)
}

fn table(pairs: &[Pair]) -> String {
    let mut text = String::new();
    let stable = |outcome: &Outcome| outcome.is_stable();
    let same = pairs
        .iter()
        .filter(|pair| stable(&pair.outcomes[0]) == stable(&pair.outcomes[1]));
    let _ = writeln!(text, "same outcome: {} of {}", same.count(), pairs.len());
    let _ = writeln!(
        text,
        "\n| to the last step | grasps | s a grasp | ended early: held | s a grasp | farthest apart at the end, mm |\n|---|---|---|---|---|---|"
    );
    let mut reasons: Vec<Reason> = pairs.iter().map(|pair| pair.outcomes[0].reason).collect();
    reasons.sort_unstable();
    reasons.dedup();
    for reason in reasons {
        let of: Vec<&Pair> = pairs
            .iter()
            .filter(|pair| pair.outcomes[0].reason == reason)
            .collect();
        let mean =
            |which: usize| of.iter().map(|pair| pair.seconds[which]).sum::<f64>() / of.len() as f64;
        let apart = of.iter().map(|pair| {
            let [full, early] = &pair.outcomes;
            (full.displacement_m - early.displacement_m).abs()
        });
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} | {} | {:.3} | {:.3} |",
            reason.name(),
            of.len(),
            mean(0),
            of.iter().filter(|pair| stable(&pair.outcomes[1])).count(),
            mean(1),
            1e3 * apart.fold(0.0, f64::max)
        );
    }
    let total = |which: usize| pairs.iter().map(|pair| pair.seconds[which]).sum::<f64>();
    let _ = writeln!(
        text,
        "\nall: {:.1} grasps a second to the last step, {:.1} ended early ({:.1} times as many)",
        pairs.len() as f64 / total(0),
        pairs.len() as f64 / total(1),
        total(0) / total(1)
    );
    for pair in pairs {
        let [full, early] = &pair.outcomes;
        if stable(full) != stable(early) {
            let _ = writeln!(
                text,
                "\n{}: {} after {:.2} mm, ended early {} after {:.2} mm",
                pair.name,
                full.reason.name(),
                1e3 * full.displacement_m,
                early.reason.name(),
                1e3 * early.displacement_m
            );
        }
    }
    text
}
