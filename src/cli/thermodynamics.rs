//! `landscape thermodynamics`: heat capacity, occupation and free energies of a landscape.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;

use super::args::{Common, FamilyBarrier};
use super::output::{check_folder, given_or_beside, make_folder};
use crate::cli::printing::tell_text;
use crate::store::FileSet;
use crate::study::{NetworkOfStates, Thermodynamics as Found, ThermodynamicsSettings};

/// Thermodynamics of a landscape.
#[derive(Debug, Args)]
pub(super) struct Thermodynamics {
    /// A landscape with curvatures (of `landscape surface`, `build` or `import`), or a folder with min.data and ts.data.
    #[arg(value_name = "FOLDER")]
    landscape: PathBuf,
    /// The folder to write; by default the name of the landscape with the ending `.thermodynamics`.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Temperatures kT in units of the energy: N of them from LOW to HIGH. By default, the range in which the occupation
    /// of the minima changes.
    #[arg(long, value_name = "LOW:HIGHxN")]
    temperatures: Option<String>,
    /// Temperature kT of the free energies in the disconnectivity graph; by default the highest peak of the heat capacity.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    free_energy_at: Option<f64>,
    /// Tell the occupation of the superbasins at this energy: sets of minima that are connected below it. By default just below
    /// the deepest merge of the tree, where the main funnels are apart. A branch of a single minimum, or of fewer than 1 % of
    /// them, is no funnel unless there is nothing else.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    level: Option<f64>,
    /// Leave out minima whose curvatures are unknown, such as those on a face of a box, where they are not harmonic wells, and
    /// the saddles that lead to them. A note gives their number and their energies.
    #[arg(long)]
    without_faces: bool,
    #[command(flatten)]
    families: FamilyBarrier,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape surface lj 13                                  lj-13.landscape/: minima and saddles with their curvatures
  landscape thermodynamics lj-13.landscape                 lj-13.thermodynamics/: curves, tables, free energies
  landscape thermodynamics lj-13.landscape --temperatures 0.05:0.4x100 --free-energy-at 0.28

Each minimum is a harmonic well with the frequencies of its Hessian and the copies that its point group leaves; the sum
over wells gives the heat capacity, the mean energy, the occupation of each funnel, the entropy of the occupation and the
frustration index. The asymmetry of the two deepest funnels is printed as well. Temperatures are kT in units of the
energy. The approximation is good at low temperatures and covers only the minima that were found.

Writes thermodynamics.csv, .json, .svg and .png, superbasins.csv (number of superbasins against energy), summary.md, and
the pictures of `landscape draw` with free energies in place of energies.";

/// Greatest number of temperatures.
const MOST: usize = 10_000;

pub(super) fn run(command: &Thermodynamics, common: &Common) -> anyhow::Result<()> {
    command.families.checked()?;
    let temperatures = match &command.temperatures {
        Some(flag) => range(flag)?,
        None => Vec::new(),
    };
    if let Some(temperature) = command.free_energy_at {
        check_temperature("--free-energy-at", temperature)?;
    }
    if let Some(level) = command.level {
        ensure!(level.is_finite(), "--level {level}: an energy is needed");
    }
    let ending = "thermodynamics";
    let output = given_or_beside(command.output.as_ref(), &command.landscape, ending)?;
    check_folder(&output, &[&command.landscape], Found::writes, common)?;
    let mut states = NetworkOfStates::open(&command.landscape, &command.families.settings())?;
    if command.without_faces {
        states = states.without_faces();
    }
    let settings = ThermodynamicsSettings {
        temperatures,
        free_energy_at: command.free_energy_at,
        level: command.level,
    };
    let found = Found::new(&states, &settings)?;
    let _made = make_folder(&output)?;
    let mut files = FileSet::default();
    let text = found.write(&mut |name, bytes| files.add(&output.join(name), bytes))?;
    files.finish()?;
    let written = output.display().to_string();
    tell_text(common, (&text, &found.to_json()), Some(&written))
}

/// Rejects a temperature that is not positive and finite.
pub(super) fn check_temperature(flag: &str, temperature: f64) -> anyhow::Result<()> {
    ensure!(
        temperature > 0.0 && temperature.is_finite(),
        "{flag} {temperature}: a temperature kT in units of the energy is needed, above 0"
    );
    Ok(())
}

/// Parses `0.05:0.4x100`.
fn range(flag: &str) -> anyhow::Result<Vec<f64>> {
    let parsed = flag.split_once(':').and_then(|(low, rest)| {
        let (high, count) = rest.split_once('x')?;
        let ends: [f64; 2] = [low.trim().parse().ok()?, high.trim().parse().ok()?];
        Some((ends, count.trim().parse::<usize>().ok()?))
    });
    let Some(([low, high], count)) = parsed else {
        anyhow::bail!("--temperatures {flag}: write LOW:HIGHxN, for example 0.05:0.4x100");
    };
    for temperature in [low, high] {
        check_temperature("--temperatures", temperature)?;
    }
    ensure!(
        low < high && (3..=MOST).contains(&count),
        "--temperatures {flag}: LOW must be below HIGH, and N must be from 3 to {MOST}"
    );
    let step = (high - low) / (count - 1) as f64;
    Ok((0..count).map(|k| low + step * k as f64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read() {
        assert_eq!(range("1:2x3").unwrap(), [1.0, 1.5, 2.0]);
        for wrong in ["", "1:2", "1x3", "a:2x3", "1:2x0"] {
            assert!(range(wrong).unwrap_err().to_string().contains(wrong));
        }
        for (wrong, said) in [
            ("2:1x5", "below"),
            ("0:1x5", "above 0"),
            ("1:infx5", "above 0"),
        ] {
            assert!(range(wrong).unwrap_err().to_string().contains(said));
        }
    }
}
