//! Contact sets of a hand that does not move. All sets can be enumerated, so their distribution is known.

use std::sync::Arc;

use landscape::energy::{Energy, Piecewise};
use landscape::grasp::energy::Ramp;
use landscape::grasp::start::start_pose;
use landscape::grasp::synthesis::ContactMoves;
use landscape::grasp::{EnergySettings, GraspEnergy, GraspKernel};
use landscape::hand::Hand;
use landscape::object::Object;
use landscape::sample::{Kernel, Rng, State, TargetDensity, Task, stream};
use landscape::space::Space;

use crate::chain::{Rule, Run, run};
use crate::statistics::deviation;
use crate::{CHANCE, WRONG};

/// Contact moves only.
struct Standing<'a> {
    kernel: GraspKernel<'a>,
    moves: ContactMoves,
}

impl Kernel for Standing<'_> {
    fn space(&self) -> &dyn Space {
        self.kernel.space()
    }

    fn start(&self, x: &[f64]) -> State {
        self.kernel.start(x)
    }

    fn propose(
        &self,
        state: &State,
        law: &TargetDensity<'_>,
        _step: f64,
        rng: &mut Rng,
        proposal: &mut State,
    ) -> f64 {
        propose_contact(&self.kernel, self.moves, state, law, rng, proposal)
    }
}

pub(crate) fn propose_contact(
    kernel: &GraspKernel<'_>,
    moves: ContactMoves,
    state: &State,
    law: &TargetDensity<'_>,
    rng: &mut Rng,
    proposal: &mut State,
) -> f64 {
    match moves {
        ContactMoves::HeatBath => kernel.move_contact(state, law.temperature, rng, proposal),
        ContactMoves::Uniform => {
            kernel.move_contact_uniformly(state, law.temperature, rng, proposal)
        }
    }
}

/// All sets of `size` numbers below `count`.
pub(crate) fn sets(count: u32, size: usize) -> Vec<Vec<u32>> {
    let mut sets = vec![vec![]];
    for _ in 0..size {
        sets = sets
            .into_iter()
            .flat_map(|set: Vec<u32>| {
                let from = set.last().map_or(0, |last| last + 1);
                (from..count).map(move |next| [&set[..], &[next]].concat())
            })
            .collect();
    }
    sets
}

fn energy(stride: usize, settings: EnergySettings) -> GraspEnergy {
    let hand = Arc::new(Hand::human().thinned(stride));
    let object = Arc::new(Object::named("ball").unwrap());
    GraspEnergy::new(hand, object, settings).unwrap()
}

/// Settings with an active rank condition, strong enough for its lack to be seen, and hands that should face the object.
fn with_more_terms() -> EnergySettings {
    EnergySettings {
        rank_weight: 2.0,
        rank_epsilon: 0.5,
        alignment_weight: 0.5,
        ..EnergySettings::four_points()
    }
}

fn cost(energy: &GraspEnergy, x: &[f64], set: &[u32], ramp: Ramp) -> f64 {
    let mut unused = vec![0.0; energy.space().tangents()];
    energy.evaluate_ramped(x, set, ramp, &mut unused)
}

const TEMPERATURE: f64 = 0.6;
const RAMP: Ramp = Ramp {
    distance: 0.4,
    depth: 1.0,
};
/// Number of groups of sets with about the same probability.
const GROUPS: usize = 12;

/// Deviation of the shares of groups of sets and of single points.
fn deviate(settings: EnergySettings, moves: ContactMoves, rule: Rule) -> f64 {
    let energy = energy(60, settings);
    let points = u32::try_from(energy.hand().surface.len()).unwrap();
    let x = start_pose(
        energy.hand(),
        energy.object(),
        &mut stream(4, Task::Start, 0),
    );
    let mut kernel = GraspKernel::new(&energy);
    kernel.ramp = RAMP;
    let kernel = Standing { kernel, moves };

    let sets = sets(points, settings.contacts);
    let costs: Vec<f64> = sets
        .iter()
        .map(|set| cost(&energy, &x, set, RAMP))
        .collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let weights: Vec<f64> = costs
        .iter()
        .map(|e| libm::exp((least - e) / TEMPERATURE))
        .collect();
    let total: f64 = weights.iter().sum();
    // Sets by rising energy fill the groups one by one.
    let mut order: Vec<usize> = (0..sets.len()).collect();
    order.sort_by(|a, b| costs[*a].total_cmp(&costs[*b]));
    let mut group = vec![0; sets.len()];
    let (mut expected, mut gathered) = (vec![0.0; GROUPS], 0.0);
    for &set in &order {
        let probability = weights[set] / total;
        group[set] = (0..GROUPS - 1)
            .find(|k| gathered + 0.5 * probability < (k + 1) as f64 / GROUPS as f64)
            .unwrap_or(GROUPS - 1);
        expected[group[set]] += probability;
        gathered += probability;
    }
    expected.pop();
    // The shares of all points add up to the number of contacts: one point is left out.
    for point in 1..points {
        let of_point = sets
            .iter()
            .zip(&weights)
            .filter(|(set, _)| set.contains(&point));
        expected.push(of_point.map(|(_, weight)| weight / total).sum());
    }
    // Groups without a set, and points that are next to never in one, have no normal law of batch means.
    let looked_at: Vec<usize> = (0..expected.len())
        .filter(|&k| expected[k] > 0.005)
        .collect();
    assert!(looked_at.len() > GROUPS, "{expected:?}");

    let settings = Run {
        rule,
        temperature: TEMPERATURE,
        step: 0.0,
        chains: 4,
        batches: 60,
        length: 3000,
    };
    let place = |contacts: &[u32]| {
        let mut set = contacts.to_vec();
        set.sort_unstable();
        sets.binary_search(&set).expect("every set is listed")
    };
    let seen = run(&kernel, &x, settings, expected.len(), |state, sums| {
        if let Some(sum) = sums[..GROUPS - 1].get_mut(group[place(&state.discrete)]) {
            *sum += 1.0;
        }
        for &contact in &state.discrete {
            if contact > 0 {
                sums[GROUPS - 2 + contact as usize] += 1.0;
            }
        }
    });
    let part = |values: &[f64]| -> Vec<f64> { looked_at.iter().map(|&k| values[k]).collect() };
    let batches: Vec<Vec<f64>> = seen.batches.iter().map(|batch| part(batch)).collect();
    deviation(&batches, &part(&expected))
}

#[test]
fn heat_bath_and_uniform_moves_have_one_law() {
    for settings in [EnergySettings::four_points(), with_more_terms()] {
        for moves in [ContactMoves::HeatBath, ContactMoves::Uniform] {
            let deviate = deviate(settings, moves, Rule::Exact);
            assert!(deviate < CHANCE, "{moves:?} {deviate}");
        }
    }
}

#[test]
fn wrong_ratios_are_found_out() {
    for (settings, moves, rule) in [
        (
            EnergySettings::four_points(),
            ContactMoves::HeatBath,
            Rule::Plain,
        ),
        (
            EnergySettings::four_points(),
            ContactMoves::Uniform,
            Rule::Always,
        ),
        // The rank condition is not in the proposal.
        (with_more_terms(), ContactMoves::HeatBath, Rule::Always),
    ] {
        let deviate = deviate(settings, moves, rule);
        assert!(deviate > WRONG, "{moves:?} {rule:?} {deviate}");
    }
}

/// The options of a heat-bath move are all points that cost little more than the cheapest one, also those farther from
/// the object that balance the others better, and their costs differ as the energies do.
#[test]
fn nothing_likely_is_missing_among_completions() {
    let aligned = EnergySettings {
        alignment_weight: 0.5,
        ..EnergySettings::four_points()
    };
    for settings in [EnergySettings::four_points(), aligned] {
        let energy = energy(4, settings);
        let points = u32::try_from(energy.hand().surface.len()).unwrap();
        let (mut listed, mut farther) = (0, 0);
        for chain in 0..12 {
            let mut rng = stream(4, Task::Start, chain);
            let x = start_pose(energy.hand(), energy.object(), &mut rng);
            let best = energy.active_piece(&x);
            let others = &best[1..];
            let whole = |index: u32| cost(&energy, &x, &[&[index], others].concat(), RAMP);
            for temperature in [0.002, 0.02, 0.2] {
                let allowance = 30.0 * temperature;
                let all: Vec<f64> = (0..points).map(whole).collect();
                let free = (0..points).filter(|index| !others.contains(index));
                let least = free
                    .clone()
                    .map(|i| all[i as usize])
                    .fold(f64::INFINITY, f64::min);
                let likely: Vec<u32> = free
                    .filter(|&i| all[i as usize] <= least + allowance)
                    .collect();
                let options = energy.heat_bath_costs(&x, others, RAMP.distance, allowance);
                let indices: Vec<u32> = options.iter().map(|(index, _)| *index).collect();
                assert_eq!(indices, likely, "chain {chain} at {temperature}");
                let cheapest = options
                    .iter()
                    .map(|(_, cost)| *cost)
                    .fold(f64::INFINITY, f64::min);
                for (index, cost) in options {
                    let difference = all[index as usize] - least - (cost - cheapest);
                    assert!(difference.abs() < 1e-12, "{difference}");
                }
                listed += likely.len();
                farther += likely
                    .iter()
                    .filter(|&&i| beyond(&energy, &x, others, i, allowance))
                    .count();
            }
        }
        assert!(listed > 500 && farther > 20, "{listed} {farther}");
    }
}

/// Whether the distance alone costs more than `allowance` above that of the nearest point.
fn beyond(energy: &GraspEnergy, x: &[f64], others: &[u32], index: u32, allowance: f64) -> bool {
    let settings = energy.settings();
    let distance_cost = |index: u32| {
        let mut posed = landscape::hand::PosedHand::default();
        energy.hand().pose(x, &mut posed);
        let distance_m = energy
            .object()
            .shape
            .distance(&posed.points[index as usize]);
        let rounding = settings.distance_rounding_m;
        RAMP.distance * settings.distance_weight * (libm::hypot(distance_m, rounding) - rounding)
            / energy.unit_m()
    };
    let points = u32::try_from(energy.hand().surface.len()).unwrap();
    let nearest = (0..points)
        .filter(|i| !others.contains(i))
        .map(distance_cost);
    distance_cost(index) > nearest.fold(f64::INFINITY, f64::min) + allowance
}
