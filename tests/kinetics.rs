//! Rates between sets of minima against published values.

use landscape::energy::model::LennardJones;
use landscape::optimize::{QuenchSettings, quench};
use landscape::space::point_group_order;
use landscape::thermal::{Dynamics, RateNetwork};
use landscape::topography::exchange::{Database, MinimumEntry, TransitionStateEntry, Vibrations};
use landscape::topography::{AuditSettings, audit};
use serde::Deserialize;

const REFERENCE: &str = include_str!("reference/kinetics_32_states.json");

#[derive(Deserialize)]
struct Reference {
    minima: Vec<f64>,
    transition_states: Vec<(f64, usize, usize)>,
    a: Vec<usize>,
    b: Vec<usize>,
    rates: Vec<Rates>,
}

#[derive(Deserialize)]
struct Rates {
    temperature: f64,
    mean_time_to_a: f64,
    mean_time_to_b: f64,
    steady_state_to_a: Option<f64>,
    steady_state_to_b: Option<f64>,
    first_passage_to_a: Option<f64>,
    first_passage_to_b: Option<f64>,
}

/// The 32 states of D. Kannan, D. J. Sharpe, T. D. Swinburne and D. J. Wales, J. Chem. Phys. 153, 244108 (2020), with the
/// rates that `PyGT` 0.3.0 computes for them. Its tutorial prints the mean times at T = 1: 664.58268 and 585.79341.
#[test]
fn a_published_network_has_its_published_rates() {
    let reference: Reference = serde_json::from_str(REFERENCE).unwrap();
    let vibrations = Some(Vibrations {
        log_product: 1.0,
        ..Vibrations::default()
    });
    let minima = reference.minima.iter().map(|energy| MinimumEntry {
        energy: *energy,
        vibrations,
    });
    let states = reference.transition_states.iter();
    let states = states.map(|(energy, a, b)| TransitionStateEntry {
        energy: *energy,
        ends: [*a, *b],
        vibrations,
    });
    let database = Database {
        minima: minima.collect(),
        transition_states: states.collect(),
        vibrational_modes: None,
    };
    let (a, b) = (&reference.a, &reference.b);
    for expected in &reference.rates {
        let network =
            RateNetwork::new(&database, expected.temperature, Dynamics::TransitionState).unwrap();
        let between = network.between(b, a);
        let (to_a, to_b) = (between.forward.unwrap(), between.backward.unwrap());
        // By default any difference below 2·10⁻¹⁶ passes, and the rates at low temperatures are smaller than 10⁻¹².
        let agree = |ours: f64, theirs: f64, tolerance: f64| {
            approx::assert_relative_eq!(ours, theirs, epsilon = 0.0, max_relative = tolerance);
        };
        // PyGT works with the numbers themselves, which costs digits of Σ p/T at low temperatures.
        let (most, sum) = (1e-9, 1e-5);
        agree(libm::exp(-to_a.mean_time), expected.mean_time_to_a, most);
        agree(libm::exp(-to_b.mean_time), expected.mean_time_to_b, most);
        for (ours, theirs, tolerance) in [
            (to_a.steady_state, expected.steady_state_to_a, most),
            (to_b.steady_state, expected.steady_state_to_b, most),
            (to_a.first_passage, expected.first_passage_to_a, sum),
            (to_b.first_passage, expected.first_passage_to_b, sum),
        ] {
            if let Some(theirs) = theirs {
                agree(libm::exp(ours), theirs, tolerance);
            }
        }
    }
}

/// The icosahedron of 13 Lennard-Jones atoms, as in the file `min.data` that `PyGT` shows for this cluster: energy,
/// ln-product and order of the point group.
#[test]
fn the_icosahedron_has_its_published_frequencies() {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut x = vec![0.0; 3];
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            x.extend([0.0, a, b, a, b, 0.0, b, 0.0, a]);
        }
    }
    for coordinate in &mut x {
        *coordinate *= 0.57;
    }
    let energy = LennardJones::new(13);
    let found = quench(&energy, &x, &QuenchSettings::default());
    assert!(
        (found.energy + 44.326_801_419_5).abs() < 1e-9,
        "{}",
        found.energy
    );
    let audits = audit(
        &energy,
        std::slice::from_ref(&found.x),
        0,
        &AuditSettings::default(),
    );
    let logs = audits[0]
        .curvatures
        .iter()
        .map(|curvature| libm::log(*curvature));
    let log_product: f64 = logs.sum();
    assert!(
        (log_product - 158.246_448_738_3).abs() < 1e-6,
        "{log_product}"
    );
    assert_eq!(point_group_order(&found.x, &[], 1e-3), 120);
}
