//! Thermodynamics of a landscape: tables, curves, and its disconnectivity graph by free energy.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::digits::{Digits, significant};
use super::drawing::{Drawing, MOST_NAMED, Put, Titles};
use super::error::StudyError;
use super::markdown::table;
use super::network_of_states::NetworkOfStates;
use crate::figure::chart::{Axis, Chart, Mark, Panel, Series};
use crate::figure::{MAKER, leaves_of};
use crate::printable::{counted, printable};
use crate::thermal::{
    Funnels, SAME, Superposition, count_superbasins, frustration, range_of_energies, superbasins,
};
use crate::topography::exchange::Database;
use crate::topography::{Evidence, Families, Tree};

/// Greatest number of superbasins whose occupation is drawn.
const DRAWN: usize = 8;
/// A superbasin is drawn if its occupation reaches this anywhere.
const NOTABLE: f64 = 0.03;
/// Default range of temperatures: the lowest minimum holds this share at its lower end …
const COLD: f64 = 0.9999;
/// … and the landscape entropy reaches this share of its greatest value at its upper end.
const HOT: f64 = 0.9;
/// Number of temperatures by default.
const COUNT: usize = 200;
/// Number of intervals between the energies at which superbasins are counted.
const LEVELS: usize = 200;

/// Settings of [`Thermodynamics::new`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ThermodynamicsSettings {
    /// Temperatures, ascending; empty for a range chosen from the minima.
    pub temperatures: Vec<f64>,
    /// Temperature of the free energies; by default that of the highest peak of the heat capacity.
    pub free_energy_at: Option<f64>,
    /// Energy of the superbasins whose occupation is told; by default just below the deepest merge.
    pub level: Option<f64>,
}

/// The thermodynamics at one temperature.
#[derive(Debug, Clone, PartialEq)]
pub struct AtTemperature {
    /// kT.
    pub temperature: f64,
    /// Mean energy.
    pub energy: f64,
    /// Heat capacity in units of Boltzmann's constant.
    pub heat_capacity: f64,
    /// Entropy of the occupation of minima.
    pub landscape_entropy: f64,
    /// Frustration (see [`frustration`]); `None` if no minimum is connected to the lowest one.
    pub frustration: Option<f64>,
    /// Occupation of each superbasin. Minima above the level of the superbasins are missing.
    pub occupation: Vec<f64>,
    /// Occupation of the lowest minimum of each superbasin alone.
    pub bottoms: Vec<f64>,
}

/// Thermodynamics of a landscape in the harmonic superposition approximation.
#[derive(Debug)]
pub struct Thermodynamics<'a> {
    states: &'a NetworkOfStates,
    wells: Superposition,
    /// The two deepest funnels; `None` if nothing merges.
    pub funnels: Option<Funnels>,
    /// Energy of the superbasins; `None` if nothing merges and none was given, so that each minimum is a superbasin.
    pub level: Option<f64>,
    /// The minima of each superbasin, its lowest first.
    pub superbasins: Vec<Vec<usize>>,
    /// The curves, by ascending temperature.
    pub curves: Vec<AtTemperature>,
    /// Peaks of the heat capacity: temperature and height, by ascending temperature.
    pub peaks: Vec<[f64; 2]>,
    /// Temperature of the free energies.
    pub free_energy_at: f64,
    /// Minima and transition states with free energies.
    pub free: Database,
}

impl<'a> Thermodynamics<'a> {
    /// Computes the curves.
    ///
    /// # Errors
    /// If the curvatures of a stationary point are not known, or a temperature is too far from the energies.
    ///
    /// # Panics
    /// If a temperature is not positive and finite.
    pub fn new(
        states: &'a NetworkOfStates,
        settings: &ThermodynamicsSettings,
    ) -> Result<Self, StudyError> {
        let wells = states.wells()?;
        let temperatures = if settings.temperatures.is_empty() {
            range_of(states, &wells)
        } else {
            settings.temperatures.clone()
        };
        states.check(&temperatures)?;
        states.check(settings.free_energy_at.as_slice())?;
        let funnels = Funnels::deepest(&states.tree);
        let level = settings.level.or(funnels.map(|funnels| funnels.level()));
        let superbasin_of = superbasins(&states.tree, level.unwrap_or(f64::MAX));
        let count = superbasin_of
            .iter()
            .flatten()
            .max()
            .map_or(0, |most| most + 1);
        let mut members = vec![Vec::new(); count];
        for (minimum, superbasin) in superbasin_of.iter().enumerate() {
            if let Some(superbasin) = superbasin {
                members[*superbasin].push(minimum);
            }
        }
        let at = |temperature: f64| {
            let mut occupation = vec![0.0; count];
            let shares = wells.occupation(temperature);
            for (share, superbasin) in shares.iter().zip(&superbasin_of) {
                if let Some(superbasin) = superbasin {
                    occupation[*superbasin] += share;
                }
            }
            AtTemperature {
                temperature,
                energy: wells.mean_energy(temperature),
                heat_capacity: wells.heat_capacity(temperature),
                landscape_entropy: wells.landscape_entropy(temperature),
                frustration: frustration(&wells, &states.tree, temperature),
                occupation,
                bottoms: members.iter().map(|members| shares[members[0]]).collect(),
            }
        };
        let curves: Vec<AtTemperature> = temperatures.into_iter().map(at).collect();
        let peaks = peaks(&curves);
        let highest = peaks.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
        let middle = curves.get(curves.len() / 2).map(|at| at.temperature);
        let free_energy_at = settings
            .free_energy_at
            .or(highest.map(|peak| peak[0]))
            .or(middle)
            .unwrap_or(1.0);
        let free = wells.free_energy_landscape(&states.database, free_energy_at)?;
        Ok(Self {
            states,
            wells,
            funnels,
            level,
            superbasins: members,
            curves,
            peaks,
            free_energy_at,
            free,
        })
    }

    /// Whether [`Thermodynamics::write`] writes a file with this name.
    pub fn writes(name: &str) -> bool {
        [
            "superbasins.csv",
            "thermodynamics.csv",
            "thermodynamics.svg",
            "thermodynamics.png",
            "thermodynamics.json",
            "summary.md",
        ]
        .contains(&name)
            || Drawing::writes(name)
    }

    /// Gives `put` the table, the curves, the summary, and the disconnectivity graph by free energy. Returns the summary.
    ///
    /// # Errors
    /// The first error of `put`, or of a picture.
    pub fn write(&self, put: Put<'_>) -> Result<String, StudyError> {
        put("thermodynamics.csv", self.csv().as_bytes())?;
        put(
            "thermodynamics.json",
            format!("{:#}\n", self.to_json()).as_bytes(),
        )?;
        let counts = self.superbasin_counts().into_iter();
        let rows = counts.map(|(energy, count)| format!("{energy},{count}\n"));
        let table = format!("energy,superbasins\n{}", rows.collect::<String>());
        put("superbasins.csv", table.as_bytes())?;
        let sheet = self.chart().draw()?;
        for name in ["thermodynamics.svg", "thermodynamics.png"] {
            put(name, &sheet.encode(name.as_ref())?)?;
        }
        let network = self.states.network_of(&self.free);
        let families = Families::below(&network, self.states.families.barrier, Evidence::Path);
        let titles = Titles::of_free_energies(&self.states.name, self.free_energy_at);
        let mut leaves = leaves_of(&network);
        if leaves.len() <= MOST_NAMED {
            // The one member of a minimum is its row, since rows are sorted by energy and not by free energy.
            for (leaf, minimum) in leaves.iter_mut().zip(network.node_weights()) {
                let number = minimum.members.first().map(|row| self.states.numbers[*row]);
                leaf.caption = number.map(|number| format!("m{number}"));
            }
        }
        let tree = Tree::from_network(&network, Evidence::Chain);
        let drawing = Drawing {
            family_of: families.family_of(),
            ..Drawing::new(&network, &tree, leaves, &titles)
        };
        drawing.write(put)?;
        let text = printable(&self.summary(), &['\n', '\t']).into_owned();
        put("summary.md", text.as_bytes())?;
        Ok(text)
    }

    /// All numbers.
    pub fn to_json(&self) -> Value {
        let curves = self.curves.iter().map(|at| {
            json!({
                "temperature": at.temperature,
                "energy": at.energy,
                "heat_capacity": at.heat_capacity,
                "landscape_entropy": at.landscape_entropy,
                "frustration": at.frustration,
                "occupation": at.occupation,
                "occupation_of_bottoms": at.bottoms,
            })
        });
        let free: Vec<f64> = self.free.minima.iter().map(|entry| entry.energy).collect();
        json!({
            "landscape": self.states.name,
            "notes": self.states.notes,
            "left_out_minima": self.states.left_out_minima(),
            "vibrational_modes": self.states.database.vibrational_modes,
            "funnels": self.funnels.map(|funnels| json!({
                "pass": funnels.pass,
                "bottoms": funnels.bottoms,
                "minima": funnels.minima,
                "evidence": funnels.evidence,
                "asymmetry": funnels.asymmetry(),
            })),
            "level_of_superbasins": self.level,
            "superbasins": self.superbasins.iter().map(|members| self.states.numbered(members)).collect::<Vec<_>>(),
            "peaks_of_heat_capacity": self.peaks,
            "free_energy_at": self.free_energy_at,
            "free_energies": self.states.of_landscape(&free),
            "curves": curves.collect::<Vec<_>>(),
        })
    }

    fn csv(&self) -> String {
        let names = self.superbasins.iter();
        let names =
            names.map(|members| format!(",funnel_of_m{0},m{0}", self.states.numbers[members[0]]));
        let mut text = format!(
            "temperature,energy,heat_capacity,landscape_entropy,frustration{}\n",
            names.collect::<String>()
        );
        for at in &self.curves {
            let frustration = at.frustration.map_or(String::new(), |f| f.to_string());
            let _ = write!(
                text,
                "{},{},{},{},{frustration}",
                at.temperature, at.energy, at.heat_capacity, at.landscape_entropy
            );
            for (funnel, bottom) in at.occupation.iter().zip(&at.bottoms) {
                let _ = write!(text, ",{funnel},{bottom}");
            }
            text.push('\n');
        }
        text
    }

    /// Number of superbasins at energies from the lowest minimum to the highest merge.
    fn superbasin_counts(&self) -> Vec<(f64, usize)> {
        let tree = &self.states.tree;
        let energies = || tree.nodes.iter().map(|node| node.energy);
        let low = energies().fold(f64::INFINITY, f64::min);
        let high = energies().fold(f64::NEG_INFINITY, f64::max);
        let levels = (0..=LEVELS).map(|k| low + (high - low) * k as f64 / LEVELS as f64);
        levels
            .map(|energy| (energy, count_superbasins(tree, energy)))
            .collect()
    }

    /// Superbasins whose occupation is notable somewhere, the most occupied first, at most [`DRAWN`].
    fn notable(&self) -> Vec<usize> {
        let most = |superbasin: usize| {
            let shares = self.curves.iter().map(|at| at.occupation[superbasin]);
            shares.fold(0.0, f64::max)
        };
        let mut ranked: Vec<(usize, f64)> = (0..self.superbasins.len())
            .map(|superbasin| (superbasin, most(superbasin)))
            .filter(|(_, most)| *most >= NOTABLE)
            .collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        ranked.truncate(DRAWN);
        ranked
            .into_iter()
            .map(|(superbasin, _)| superbasin)
            .collect()
    }

    fn chart(&self) -> Chart {
        let line = |value: &dyn Fn(&AtTemperature) -> f64| {
            let points = self.curves.iter().map(|at| [at.temperature, value(at)]);
            points.collect::<Vec<_>>()
        };
        let axis = || Axis::linear("temperature kT (energy)");
        let mut capacity = vec![Series::line(line(&|at| at.heat_capacity))];
        capacity
            .extend((self.peaks.iter()).map(|peak| Series::new(Mark::Vertical(peak[0])).dashed()));
        let mut occupation: Vec<Series> = (self.notable().into_iter())
            .map(|superbasin| {
                let name = format!("funnel of m{}", self.bottom(superbasin));
                Series::line(line(&|at| at.occupation[superbasin])).named(&name)
            })
            .collect();
        let shown = self.notable();
        let others = line(&|at| {
            1.0 - shown
                .iter()
                .map(|superbasin| at.occupation[*superbasin])
                .sum::<f64>()
        });
        if others.iter().any(|point| point[1] >= NOTABLE) {
            occupation.push(Series::line(others).named("all others").dashed());
        }
        let superbasins = self.superbasin_counts().into_iter();
        let superbasins = superbasins
            .map(|(energy, count)| [energy, count as f64])
            .collect();
        let label = match self.wells.modes() {
            0 => "heat capacity − κ (k)",
            _ => "heat capacity (k)",
        };
        let mut chart = Chart::new(
            &format!("{}: harmonic superposition", self.states.name),
            vec![
                Panel::new("heat capacity", axis(), Axis::linear(label), capacity),
                Panel::new(
                    "occupation of superbasins",
                    axis(),
                    Axis::linear("probability").with_range(0.0, 1.0),
                    occupation,
                ),
                Panel::new(
                    "superbasins",
                    Axis::linear("energy"),
                    Axis::linear("sets of minima connected below it"),
                    vec![Series::steps(superbasins)],
                ),
            ],
        );
        chart.panel_size = [780, 640];
        chart.legend_below = true;
        chart
    }

    /// Number of the lowest minimum of a superbasin in the landscape.
    fn bottom(&self, superbasin: usize) -> usize {
        self.states.numbers[self.superbasins[superbasin][0]]
    }

    fn told_level(&self) -> String {
        match self.level {
            Some(level) => format!(
                "Superbasins: sets of minima that are connected below the energy {}; a funnel is named after its lowest minimum",
                Digits::of([level]).show(level)
            ),
            None => "No two minima are connected, so each is a superbasin of its own".to_owned(),
        }
    }

    fn summary(&self) -> String {
        let states = self.states;
        let level = self.told_level();
        let mut text = format!(
            "# {}: thermodynamics\n\nHarmonic superposition of {}. {level}. ",
            states.name,
            counted(states.database.minima.len(), "minimum"),
        );
        match states.database.vibrational_modes {
            Some(modes) => {
                let _ = writeln!(text, "A minimum has {modes} vibrational modes.");
            }
            None => text.push_str(
                "The number κ of vibrational modes is not recorded, so energies lack κ T and heat capacities lack κ.\n",
            ),
        }
        if states.left_out > 0 {
            let _ = writeln!(
                text,
                "\nConnections without curvatures are left out of the free energies, {} in number: they are bounds or lie on \
                 the faces of a box, or their rows of ts.data contain placeholders.",
                states.left_out
            );
        }
        text.push_str(&states.told_notes());
        text.push_str("\nMinima that were not found are missing here, too: at temperatures where many minima are occupied, the curves are those of the sample.\n");
        if let Some(funnels) = &self.funnels {
            let [deeper, shallower] = funnels.bottoms.map(|bottom| funnels.pass - bottom);
            let digits = Digits::of([deeper, shallower]);
            let bound = if funnels.evidence > Evidence::Path {
                "at most "
            } else {
                ""
            };
            let _ = writeln!(
                text,
                "\n- The two deepest funnels have {} and {} minima. The pass between them lies {bound}{} above the bottom of the \
                 deeper one and {bound}{} above that of the other. Their asymmetry (difference of these, divided by the sum) is \
                 {:.2}.",
                funnels.minima[0],
                funnels.minima[1],
                digits.show(deeper),
                digits.show(shallower),
                funnels.asymmetry()
            );
        }
        for [temperature, height] in &self.peaks {
            let _ = writeln!(
                text,
                "\n- The heat capacity has a peak of {height:.1} k at kT = {}.",
                significant(*temperature)
            );
        }
        if self.peaks.is_empty() {
            text.push_str("\n- The heat capacity has no peak in this range.\n");
        }
        let notable = self.notable();
        let funnels = notable.iter().flat_map(|superbasin| {
            let bottom = self.bottom(*superbasin);
            [format!("funnel of m{bottom}"), format!("m{bottom} alone")]
        });
        let funnels: Vec<String> = funnels.collect();
        let mut head = vec!["kT", "energy", "heat capacity", "landscape entropy"];
        head.extend(["effective minima", "frustration"]);
        head.extend(funnels.iter().map(String::as_str));
        let step = self.curves.len().div_ceil(12).max(1);
        let digits = Digits::of(self.curves.iter().map(|at| at.energy));
        let rows = self.curves.iter().step_by(step).map(|at| {
            let mut row = vec![
                significant(at.temperature),
                digits.show(at.energy),
                format!("{:.3}", at.heat_capacity),
                format!("{:.3}", at.landscape_entropy),
                format!("{:.2}", libm::exp(at.landscape_entropy)),
                at.frustration
                    .map_or_else(String::new, |f| format!("{f:.3}")),
            ];
            let shares = notable
                .iter()
                .flat_map(|superbasin| [at.occupation[*superbasin], at.bottoms[*superbasin]]);
            row.extend(shares.map(|share| format!("{share:.3}")));
            row
        });
        text.push('\n');
        text += &table(&head, rows);
        let _ = writeln!(
            text,
            "\nThe disconnectivity graph and the barrier graph in this folder show free energies at kT = {}, counted \
             from the lowest. Their texts number the minima by free energy, and \
             the pictures name them as in the landscape.\n\nMade by {MAKER}.",
            significant(self.free_energy_at)
        );
        text
    }
}

/// Steps of the grid of temperatures in a factor of ten.
const STEPS: i32 = 20;

/// Temperatures from where the lowest energy holds nearly everything to where the occupation has nearly spread. Minima of one
/// energy, up to rounding, count as one, and the search begins and ends ten powers of ten from the range of energies.
fn range_of(states: &NetworkOfStates, wells: &Superposition) -> Vec<f64> {
    let spread = range_of_energies(&states.tree);
    let mut level = 0;
    // Minima are sorted by energy.
    let rises = states.database.minima.windows(2).map(|pair| {
        level += usize::from(pair[1].energy - pair[0].energy > SAME * spread);
        level
    });
    let level_of: Vec<usize> = std::iter::once(0).chain(rises).collect();
    let shares = |temperature: f64| {
        let mut shares = vec![0.0; states.database.minima.len()];
        for (share, level) in wells.occupation(temperature).iter().zip(&level_of) {
            shares[*level] += share;
        }
        shares
    };
    let entropy = |temperature: f64| {
        let shares = shares(temperature).into_iter().filter(|share| *share > 0.0);
        shares.map(|p| -p * libm::log(p)).sum::<f64>().max(0.0)
    };
    let decade = decade_of(spread);
    let grid: Vec<f64> = (-10 * STEPS..=10 * STEPS)
        .map(|k| f64::from(k + STEPS * decade) / f64::from(STEPS))
        .map(|power| libm::pow(10.0_f64, power))
        .collect();
    let entropies: Vec<f64> = grid.iter().map(|t| entropy(*t)).collect();
    let most = entropies.iter().copied().fold(0.0, f64::max);
    let ground = |t: f64| shares(t).into_iter().fold(0.0, f64::max);
    // The entropy of a single energy is that of rounding.
    let hot = |entropy: &f64| *entropy >= (HOT * most).max(SAME);
    let spread = entropies.iter().position(hot).unwrap_or(0);
    let cold = (0..spread).rev().find(|k| ground(grid[*k]) >= COLD);
    let (low, high) = match (cold, spread) {
        (Some(cold), _) => (grid[cold], grid[spread]),
        // No temperature separates a single energy from others.
        (None, 0) => (
            0.01 * libm::pow(10.0_f64, f64::from(decade)),
            libm::pow(10.0_f64, f64::from(decade)),
        ),
        (None, spread) => (grid[0], grid[spread]),
    };
    (0..COUNT)
        .map(|k| low + (high - low) * k as f64 / (COUNT - 1) as f64)
        .collect()
}

/// The power of ten at or below a range of energies; 0 for none.
fn decade_of(range: f64) -> i32 {
    let exponents = -280..=280;
    let is_below = |k: &i32| libm::pow(10.0_f64, f64::from(*k)) <= range;
    if range > 0.0 {
        exponents.rev().find(is_below).unwrap_or(-280)
    } else {
        0
    }
}

/// Local maxima of the heat capacity, placed by a parabola through three temperatures.
fn peaks(curves: &[AtTemperature]) -> Vec<[f64; 2]> {
    let triples = curves.windows(3);
    triples
        .filter(|three| {
            let [a, b, c] = [0, 1, 2].map(|k| three[k].heat_capacity);
            b > a && b >= c
        })
        .map(|three| {
            let [x0, x1, x2] = [0, 1, 2].map(|k| three[k].temperature);
            let [y0, y1, y2] = [0, 1, 2].map(|k| three[k].heat_capacity);
            let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
            let bend = (right - left) / (x2 - x0);
            // Where the slope of Newton's interpolation vanishes.
            let x = (0.5 * (x0 + x1) - 0.5 * left / bend).clamp(x0, x2);
            let y = y0 + left * (x - x0) + bend * (x - x0) * (x - x1);
            [x, y]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn states(minima: &str, transition_states: &str) -> NetworkOfStates {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("min.data"), minima).unwrap();
        std::fs::write(folder.path().join("ts.data"), transition_states).unwrap();
        NetworkOfStates::open(folder.path(), &crate::topography::FamilySettings::default()).unwrap()
    }

    /// Energies in another unit give the same curves.
    #[test]
    fn default_temperatures_follow_the_unit_of_the_energies() {
        let settings = ThermodynamicsSettings::default();
        let made = |unit: f64| {
            let minima = format!("{} 1 1 0 0 0\n{} 0.5 1 0 0 0\n", -2.0 * unit, -unit);
            let states = states(&minima, &format!("{} 0.2 1 1 2 0 0 0\n", 0.5 * unit));
            let found = Thermodynamics::new(&states, &settings).unwrap();
            let ends = [0, COUNT - 1].map(|k| found.curves[k].temperature / unit);
            (ends, found.curves[0].occupation[0], found.summary())
        };
        let ([low, high], cold, _) = made(1.0);
        assert!(
            (0.05..0.2).contains(&low) && high > 0.5 && cold > 0.999,
            "{low} {high}"
        );
        let (joules, _, summary) = made(1e-21);
        approx::assert_relative_eq!(joules[0], low, max_relative = 1e-9);
        approx::assert_relative_eq!(joules[1], high, max_relative = 1e-9);
        assert!(
            !summary.contains("0.0000 |") && summary.contains("e-22 |"),
            "{summary}"
        );
    }

    /// The minima of a symmetric surface differ by the rounding of their descents.
    #[test]
    fn rounding_makes_no_temperatures() {
        let minima = "0 1 1 0 0 0\n1e-16 1 1 0 0 0\n";
        let states = states(minima, "2 0.2 1 1 2 0 0 0\n");
        let found = Thermodynamics::new(&states, &ThermodynamicsSettings::default()).unwrap();
        assert!(found.curves[0].temperature > 1e-3, "{:?}", found.curves[0]);
        for at in &found.curves {
            assert!(
                at.frustration.is_none() && (at.occupation[0] - 0.5).abs() < 1e-9,
                "{at:?}"
            );
        }
    }

    #[test]
    fn a_single_minimum_has_no_level() {
        let states = states("-3 1 1 0 0 0\n", "");
        let found = Thermodynamics::new(&states, &ThermodynamicsSettings::default()).unwrap();
        assert_eq!(found.level, None);
        let summary = found.summary();
        assert!(
            summary.contains("of 1 minimum. No two minima are connected"),
            "{summary}"
        );
        assert!(!summary.contains("e308"), "{summary}");
        assert!(found.to_json()["level_of_superbasins"].is_null());
        let far = ThermodynamicsSettings {
            free_energy_at: Some(1e-300),
            ..ThermodynamicsSettings::default()
        };
        let told = Thermodynamics::new(&states, &far).unwrap_err().to_string();
        assert!(told.contains("kT of 1e-300"), "{told}");
    }

    #[test]
    fn peaks_of_a_parabola_are_exact() {
        let at = |temperature: f64| AtTemperature {
            temperature,
            energy: 0.0,
            heat_capacity: 5.0 - (temperature - 0.37).powi(2),
            landscape_entropy: 0.0,
            frustration: None,
            occupation: Vec::new(),
            bottoms: Vec::new(),
        };
        let curves: Vec<AtTemperature> = [0.1, 0.25, 0.4, 0.5, 0.9].map(at).into();
        let [[x, y]] = peaks(&curves)[..] else {
            panic!("one peak")
        };
        assert!(
            (x - 0.37).abs() < 1e-12 && (y - 5.0).abs() < 1e-12,
            "{x} {y}"
        );
    }
}
