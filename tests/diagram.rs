//! The magnetisation diagram of Müller and Brown's surface, compared with independently measured thresholds: 20 fixed-step
//! MALA chains each, M = 500, δ = 0.05, forces in steps of a factor 10^0.1.

use landscape::energy::model::MullerBrown;
use landscape::optimize::QuenchSettings;
use landscape::sample::Mala;
use landscape::topography::{
    ChainSettings, Diagram, DiagramSettings, MatchTolerance, MemoryJournal, Minimum, Run, diagram,
    distinct, log_grid, quench_all,
};

/// Minima A, B, C in ascending order of energy.
fn minima() -> Vec<Minimum> {
    let starts = [vec![-0.56, 1.44], vec![0.62, 0.03], vec![-0.05, 0.47]];
    let energy = MullerBrown::new();
    let settings = QuenchSettings::default();
    let found = quench_all(&energy, &starts, &settings, &Run::default()).unwrap();
    distinct(&energy, &found, &MatchTolerance::default(), 1e-6).0
}

fn settings(replicas: usize) -> DiagramSettings {
    let scales = DiagramSettings::for_scales(50.0, 1.0);
    DiagramSettings {
        temperatures: vec![5.0, 20.0],
        forces: log_grid(10.0, 1000.0, 21),
        replicas,
        neighbours: 2,
        chain: ChainSettings {
            arrival: 0.05,
            step: 0.012,
            patience: 500,
            max_steps: 20_000,
            ..scales.chain.clone()
        },
        ..scales
    }
}

fn measure(settings: &DiagramSettings) -> Diagram {
    let energy = MullerBrown::new();
    let kernel = Mala::new(&energy);
    diagram(&energy, &kernel, &minima(), settings, &Run::default()).unwrap()
}

/// Start and end, the force of the first success, and the force from which all chains succeed.
type Threshold = ((usize, usize), f64, f64);

#[test]
fn thresholds_are_those_measured_before() {
    let known: [(f64, &[Threshold]); 2] = [
        (
            5.0,
            &[
                ((0, 1), 403.0, 508.0),
                ((1, 0), 127.0, 254.0),
                ((1, 2), 32.0, 202.0),
            ],
        ),
        (
            20.0,
            &[
                ((0, 1), 127.0, 508.0),
                ((1, 0), 25.0, 254.0),
                ((2, 0), 20.0, 254.0),
            ],
        ),
    ];
    let (mut table, mut off) = (Vec::new(), false);
    for (temperature, rows) in known {
        let mut settings = settings(20);
        settings.temperatures = vec![temperature];
        settings.chain.steered = false;
        settings.chain.step = 0.012 * (temperature / 5.0_f64).sqrt();
        let found = measure(&settings);
        assert_eq!(found.pairs.len(), 3);
        let thresholds = &found.isotherms[0].thresholds;
        for ((from, to), first, always) in rows {
            let row = thresholds
                .iter()
                .find(|row| (row.from, row.to) == (*from, *to));
            let row = row.expect("all pairs are measured");
            // Where one chain of twenty gets through chance decides; where all do it is sharp. The grid's step is 1.26.
            for (value, known, most) in [(row.first, *first, 2.1), (row.always, *always, 1.3)] {
                let value = value.expect("the strongest force is enough");
                table.push(format!("{from}→{to} T {temperature}: {value:.0} ({known})"));
                off |= (value / known).max(known / value) > most;
            }
        }
    }
    assert!(!off, "{}", table.join("\n"));
}

#[test]
fn the_recommendation_is_measured() {
    let found = measure(&settings(6));
    let best = found.recommended.as_ref().expect("strong forces join all");
    let row = (found.isotherms.iter())
        .find(|row| row.temperature.to_bits() == best.temperature.to_bits())
        .expect("a temperature of the grid");
    let level = (row.levels.iter())
        .find(|level| level.force.to_bits() == best.force.to_bits())
        .expect("a force of the grid");
    assert!(level.joined >= 0.9);
    for other in row.levels.iter().filter(|other| other.joined >= 0.9) {
        assert!(other.median_barrier >= level.median_barrier);
    }
    // A strong pull merges all in every replica, a weak one nothing.
    let last = row.levels[row.levels.len() - 1];
    assert!((last.groups - 1.0).abs() < 1e-12 && (last.stability - 1.0).abs() < 1e-12);
    assert!((last.arrived - 1.0).abs() < 1e-12);
    assert!(row.levels[0].groups > 1.0);
    assert!(best.reason.contains("adjusted Rand index"));
}

#[test]
fn what_is_remembered_is_not_measured_again() {
    let energy = MullerBrown::new();
    let counted = landscape::energy::Counted::new(&energy);
    let (kernel, journal, settings) = (Mala::new(&counted), MemoryJournal::default(), settings(2));
    let run = Run {
        journal: &journal,
        ..Run::default()
    };
    let first = diagram(&counted, &kernel, &minima(), &settings, &run).unwrap();
    let spent = counted.evaluations();
    let second = diagram(&counted, &kernel, &minima(), &settings, &run).unwrap();
    assert_eq!(counted.evaluations(), spent);
    assert_eq!(first, second);
    assert_eq!(first, measure(&settings));
}
