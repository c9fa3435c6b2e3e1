//! Rates between two sets of minima of a landscape, against temperature.

use std::fmt::Write as _;
use std::iter;

use serde_json::{Value, json};

use super::digits::as_given;
use super::error::StudyError;
use super::markdown::table;
use super::network_of_states::NetworkOfStates;
use crate::figure::MAKER;
use crate::figure::chart::{Axis, Chart, Corner, Panel, Series};
use crate::thermal::{Dynamics, Pathway, RateNetwork, SetRates, Unreachable};
use crate::topography::Observer;

/// Settings of [`Kinetics::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct KineticsSettings {
    /// Temperatures kT.
    pub temperatures: Vec<f64>,
    /// How transition states are crossed.
    pub dynamics: Dynamics,
    /// Number of pathways to rank.
    pub pathways: usize,
}

/// The kinetics at one temperature. Rates are logarithms.
#[derive(Debug, Clone, PartialEq)]
pub struct KineticsAt {
    /// kT.
    pub temperature: f64,
    /// Equilibrium probabilities of sources and targets.
    pub occupation: [f64; 2],
    /// Rates from the sources to the targets, and back.
    pub rates: [SetRates; 2],
    /// The fastest pathways from the sources to the targets.
    pub pathways: Vec<Pathway>,
    /// Committor of each minimum: ln of the probability to reach the targets before the sources, so that it is 0 for the
    /// targets.
    pub log_committors: Vec<f64>,
}

/// Rates between two sets of minima.
#[derive(Debug)]
pub struct Kinetics<'a> {
    states: &'a NetworkOfStates,
    sources: &'a [usize],
    targets: &'a [usize],
    settings: &'a KineticsSettings,
    /// One entry for each temperature.
    pub at: Vec<KineticsAt>,
}

impl<'a> Kinetics<'a> {
    /// Computes rates, committors and pathways. `observer` hears of the elimination at each temperature.
    ///
    /// # Errors
    /// If curvatures are not known, if no sequence of transition states joins the two sets, or if a temperature is too
    /// far from the energies.
    ///
    /// # Panics
    /// If a set is empty or names a minimum that does not exist, if a minimum is in both, or if a temperature is not
    /// positive and finite.
    pub fn new(
        states: &'a NetworkOfStates,
        (sources, targets): (&'a [usize], &'a [usize]),
        settings: &'a KineticsSettings,
        observer: &Observer<'_>,
    ) -> Result<Self, StudyError> {
        states.check(&settings.temperatures)?;
        if states.database.transition_states.is_empty() && states.left_out > 0 {
            return Err(StudyError::NoStateVibrations {
                name: states.name.clone(),
                count: states.left_out,
            });
        }
        let wells = states.wells()?;
        let at = settings.temperatures.iter().map(|temperature| {
            let network = RateNetwork::new(&states.database, *temperature, settings.dynamics)?;
            let shares = wells.occupation(*temperature);
            let share = |set: &[usize]| set.iter().map(|state| shares[*state]).sum();
            let between = network.between_watched(sources, targets, observer);
            let known = |rates: Result<SetRates, Unreachable>| {
                let in_tree = |Unreachable(minimum)| Unreachable(states.numbers[minimum]);
                rates.map_err(|error| StudyError::from(in_tree(error)))
            };
            Ok(KineticsAt {
                temperature: *temperature,
                occupation: [share(sources), share(targets)],
                rates: [known(between.forward)?, known(between.backward)?],
                pathways: network.fastest_pathways(sources, targets, settings.pathways),
                log_committors: between.log_committors,
            })
        });
        let at = at.collect::<Result<Vec<KineticsAt>, StudyError>>()?;
        Ok(Self {
            states,
            sources,
            targets,
            settings,
            at,
        })
    }

    /// All numbers. Rates, times and committors are natural logarithms, because they may be beyond the range of numbers.
    pub fn to_json(&self) -> Value {
        let rates = |rates: &SetRates| {
            json!({
                "log_first_passage_rate": rates.first_passage,
                "log_inverse_mean_time": rates.mean_time,
                "log_steady_state_rate": rates.steady_state,
            })
        };
        let at = self.at.iter().map(|at| {
            let pathways = at.pathways.iter();
            let pathways = pathways.map(|pathway| {
                json!({ "minima": self.states.numbered(&pathway.states), "log_rate": pathway.log_rate })
            });
            let committors = self.states.of_landscape(&at.log_committors).into_iter();
            json!({
                "temperature": at.temperature,
                "occupation_of_sources": at.occupation[0],
                "occupation_of_targets": at.occupation[1],
                "forward": rates(&at.rates[0]),
                "backward": rates(&at.rates[1]),
                "pathways": pathways.collect::<Vec<_>>(),
                // JSON has no infinity: a committor of 0 is null.
                "log_committors": committors.map(|q| q.filter(|q| q.is_finite())).collect::<Vec<_>>(),
            })
        });
        json!({
            "made_by": MAKER,
            "landscape": self.states.name,
            "notes": self.states.notes,
            "left_out_minima": self.states.left_out_minima(),
            "sources": self.states.numbered(self.sources),
            "targets": self.states.numbered(self.targets),
            "numbers_in_min_data": self.states.rows.iter().map(|row| row + 1).collect::<Vec<_>>(),
            "friction": self.friction(),
            "at": at.collect::<Vec<_>>(),
        })
    }

    /// The numbers of the two sets in `min.data`, if they are others than those of the tree.
    fn numbers(&self) -> String {
        let rows = &self.states.rows;
        if rows.is_sorted() {
            return String::new();
        }
        let told = |set: &[usize]| {
            let names = set.iter().take(NUMBERED);
            let mut names: Vec<String> = names
                .map(|state| self.states.numbers[*state])
                .map(|number| format!("m{number} is {}", rows[number] + 1))
                .collect();
            if set.len() > NUMBERED {
                names.push(format!("{} more", set.len() - NUMBERED));
            }
            names.join(", ")
        };
        format!(
            "\nThe tree numbers minima by energy, and min.data by its lines, counted from 1. From: {}. To: {}.\n",
            told(self.sources),
            told(self.targets)
        )
    }

    /// A few minima by name, many by number.
    fn named(&self, set: &[usize]) -> String {
        if set.len() <= 4 {
            self.states.names(set).join(", ")
        } else {
            let first = self.states.numbers[set[0]];
            format!("m{first} and {} more", set.len() - 1)
        }
    }

    fn friction(&self) -> Option<f64> {
        match self.settings.dynamics {
            Dynamics::TransitionState => None,
            Dynamics::Kramers { friction } => Some(friction),
        }
    }

    /// Rates against inverse temperature (an Arrhenius plot).
    pub fn chart(&self) -> Chart {
        let decades = std::f64::consts::LN_10;
        let line = |way: usize| {
            let rate = |at: &KineticsAt| at.rates[way].first_passage / decades;
            let points = self.at.iter().map(|at| [1.0 / at.temperature, rate(at)]);
            let mut points: Vec<[f64; 2]> = points.collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            points
        };
        let names = [
            format!(
                "{} → {}",
                self.named(self.sources),
                self.named(self.targets)
            ),
            format!(
                "{} → {}",
                self.named(self.targets),
                self.named(self.sources)
            ),
        ];
        let mut series = Vec::new();
        for (way, name) in names.iter().enumerate() {
            series.push(Series::line(line(way)).named(name));
            series.push(Series::points(line(way)).named(name));
        }
        let panel = Panel {
            legend: Some(Corner::UpperRight),
            ..Panel::new(
                &format!("{}: rates between two sets of minima", self.states.name),
                Axis::linear("1/(kT) (1/energy)"),
                Axis::linear("log₁₀ of the first-passage rate (1/time)"),
                series,
            )
        };
        Chart::new("", vec![panel])
    }

    /// The tables as text.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# {}: rates from {} to {}\n\n",
            self.states.name,
            self.named(self.sources),
            self.named(self.targets)
        );
        let _ = match self.friction() {
            None => writeln!(
                text,
                "Transition-state theory with harmonic frequencies. Times are in units of √(mass · length² / energy)."
            ),
            Some(friction) => writeln!(
                text,
                "Kramers rates with a friction of {} and harmonic frequencies. Times are in units of √(mass · \
                 length² / energy).",
                as_given(friction)
            ),
        };
        text.push_str(&self.numbers());
        let rows = self.at.iter().map(|at| {
            let [there, back] = at.rates;
            let numbers = [
                libm::log(at.occupation[0]),
                libm::log(at.occupation[1]),
                there.first_passage,
                -there.mean_time,
                there.steady_state,
                back.first_passage,
                -back.mean_time,
            ];
            let temperature = iter::once(as_given(at.temperature));
            temperature.chain(numbers.map(power)).collect()
        });
        let head = [
            "kT",
            "p(from)",
            "p(to)",
            "rate there",
            "mean time there",
            "steady-state rate",
            "rate back",
            "mean time back",
        ];
        text.push('\n');
        text += &table(&head, rows);
        text.push_str(
            "\nThe rate is Σ p/T over the minima of the first set: p is the equilibrium share within the set, T the mean \
             first-passage time. The steady-state rate counts every departure that arrives before it returns.\n",
        );
        if self.states.left_out > 0 {
            let _ = writeln!(
                text,
                "\nConnections without curvatures are left out, {} in number: they are bounds or lie on the faces of a box, or \
                 their rows of ts.data contain placeholders.",
                self.states.left_out
            );
        }
        text.push_str(&self.states.told_notes());
        for at in &self.at {
            let _ = writeln!(
                text,
                "\n## Fastest pathways at kT = {}\n",
                as_given(at.temperature)
            );
            let rows = at.pathways.iter().enumerate().map(|(rank, pathway)| {
                let share = pathway.log_rate - at.rates[0].steady_state;
                vec![
                    (rank + 1).to_string(),
                    power(pathway.log_rate),
                    format!("{:.2} %", 100.0 * libm::exp(share)),
                    self.states.names(&pathway.states).join(" → "),
                ]
            });
            text += &table(
                &["rank", "rate", "share of the steady-state rate", "minima"],
                rows,
            );
        }
        text.push_str(
            "\nA pathway counts direct passages only. Where the pathways hold a small share, most passages step back and \
             forth on their way.\n",
        );
        text
    }
}

/// Greatest number of minima of a set whose numbers in `min.data` the text tells; JSON holds all.
const NUMBERED: usize = 12;

/// Beyond this, the double-precision logarithm of a number does not hold its first digits.
const MOST_DECADES: f64 = 1e12;

/// A number given by its natural logarithm, in powers of ten.
fn power(log: f64) -> String {
    if log == f64::NEG_INFINITY {
        return "0".to_owned();
    }
    let decades = log / std::f64::consts::LN_10;
    if decades.abs() > MOST_DECADES {
        return format!("10^({decades:.3e})");
    }
    let exponent = decades.floor();
    let mantissa = libm::pow(10.0_f64, decades - exponent);
    // Rounding may give 10.00.
    let (mantissa, exponent) = if mantissa >= 9.995 {
        (1.0, exponent + 1.0)
    } else {
        (mantissa, exponent)
    };
    if (-3.0..4.0).contains(&exponent) {
        format!("{:.4}", mantissa * libm::pow(10.0_f64, exponent))
    } else {
        format!("{mantissa:.2}e{exponent}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_all_range_are_shown() {
        assert_eq!(power(0.0), "1.0000");
        assert_eq!(power(f64::NEG_INFINITY), "0");
        assert_eq!(
            power(-1000.0 * std::f64::consts::LN_10 + libm::log(2.0_f64)),
            "2.00e-1000"
        );
        assert_eq!(power(libm::log(9.999e6_f64)), "1.00e7");
        assert_eq!(power(-1e300), "10^(-4.343e299)");
    }
}
