//! Sequential ADELM follows its published rules and depends on the order of arrival; the default map does not.

use landscape::energy::Energy;
use landscape::energy::model::MullerBrown;
use landscape::optimize::QuenchSettings;
use landscape::sample::Mala;
use landscape::space::{Euclidean, Space};
use landscape::topography::{
    ChainSettings, Evidence, MatchTolerance, Minimum, MinimumId, Run, Sequential,
    SequentialSettings, distinct, quench_all, sequential,
};

/// Three wells in the plane. Two of them are on either side of a wall that ends below the third. A straight pull leads from
/// each of the two to the third, but not from one to the other.
struct Wall(Euclidean);

/// Height at which the wall ends.
const END: f64 = 0.6;

const WELLS: [([f64; 2], f64); 3] = [([0.0, 1.5], 1.2), ([-0.5, 0.0], 1.1), ([0.5, 0.0], 1.0)];

impl Wall {
    fn new() -> Self {
        Self(Euclidean::new(2))
    }
}

impl Energy for Wall {
    fn space(&self) -> &dyn Space {
        &self.0
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let along = 1.0 / (1.0 + libm::exp((x[1] - END) / 0.1));
        let across = 20.0 * libm::exp(-50.0 * x[0] * x[0]);
        let mut energy = across * along;
        gradient[0] = -100.0 * x[0] * energy;
        gradient[1] = -energy * (1.0 - along) / 0.1;
        for (centre, depth) in WELLS {
            let (dx, dy) = (x[0] - centre[0], x[1] - centre[1]);
            let well = depth * libm::exp(-12.5 * (dx * dx + dy * dy));
            energy -= well;
            gradient[0] += 25.0 * dx * well;
            gradient[1] += 25.0 * dy * well;
        }
        energy
    }
}

/// The minima of the wells, in this order.
fn wells(order: &[usize]) -> Vec<Minimum> {
    let starts: Vec<Vec<f64>> = WELLS.iter().map(|(centre, _)| centre.to_vec()).collect();
    let energy = Wall::new();
    let settings = QuenchSettings::default();
    let found = quench_all(&energy, &starts, &settings, &Run::default()).unwrap();
    let (minima, rejected) = distinct(&energy, &found, &MatchTolerance::default(), 1e-6);
    assert!(rejected.is_empty() && minima.len() == 3);
    order.iter().map(|well| minima[*well].clone()).collect()
}

fn settings() -> SequentialSettings {
    let scales = SequentialSettings::for_scales(1.0, 1.0);
    SequentialSettings {
        chain: ChainSettings {
            temperature: 0.05,
            force: 6.0,
            attempts: 2,
            replicas: 2,
            ..scales.chain
        },
        ..scales
    }
}

fn run(order: &[usize]) -> Sequential {
    let energy = Wall::new();
    let kernel = Mala::new(&energy);
    let (minima, settings) = (wells(order), settings());
    sequential(&energy, &kernel, &minima, &settings, &Run::default()).unwrap()
}

#[test]
fn groups_depend_on_the_order_of_arrival() {
    // The lowest first: it stays the representative, and both others reach it.
    let one = run(&[0, 1, 2]);
    let ids = |ids: &[usize]| ids.iter().map(|id| MinimumId(*id)).collect::<Vec<_>>();
    assert_eq!(one.landscape.groups.members, [ids(&[0, 1, 2])]);
    assert_eq!(one.representatives, ids(&[0]));
    assert_eq!(one.arrivals, ids(&[0, 1, 2]));
    // The two on either side of the wall first: neither reaches the other, so each founds a group. The third joins one of
    // them, and being lower becomes its representative.
    let two = run(&[1, 2, 0]);
    assert_eq!(two.arrivals, ids(&[1, 2, 0]));
    assert_eq!(two.landscape.groups.members.len(), 2);
    assert_eq!(two.representatives[0], MinimumId(0));
    let joined = &two.landscape.groups.members[0];
    assert_eq!(joined.len(), 2);
    // It joined the group it reached over the lower barrier.
    let own = two.landscape.connection(joined[0], joined[1]).unwrap();
    assert_eq!(own.edge.evidence, Evidence::Chain);
    assert_eq!(own.forward.len() + own.backward.len(), 2);
    // Tree stage: one pair of representatives, two forces, two chains each way.
    let between = two
        .landscape
        .connection(two.representatives[0], two.representatives[1])
        .unwrap();
    assert_eq!((between.forward.len(), between.backward.len()), (4, 4));
    let lowest = (between.forward.iter().chain(&between.backward))
        .flatten()
        .fold(f64::INFINITY, |least, barrier| barrier.min(least));
    assert!((between.edge.height - lowest).abs() < 1e-15);
    assert!(between.path.height() <= between.edge.height + 1e-12);
    assert_eq!(two.landscape.tree.roots.len(), 1);
    // Chains go round the wall, which is twenty high, but not below the outer rim of the wells.
    for node in &two.landscape.tree.nodes[3..] {
        assert!((-1.0..3.0).contains(&node.energy), "{}", node.energy);
    }
}

#[test]
fn published_surface() {
    // A strong pull joins all of Müller and Brown's minima, a weak one only those 8.5 apart, less than twice T (thresholds
    // measured in tests/muller_brown.rs).
    let energy = MullerBrown::new();
    let kernel = Mala::new(&energy);
    let starts = [vec![0.62, 0.03], vec![-0.05, 0.47], vec![-0.56, 1.44]];
    let found = quench_all(
        &energy,
        &starts,
        &QuenchSettings::default(),
        &Run::default(),
    )
    .unwrap();
    let (minima, _) = distinct(&energy, &found, &MatchTolerance::default(), 1e-6);
    let groups = |force| {
        let scales = SequentialSettings::for_scales(50.0, 1.0);
        let settings = SequentialSettings {
            chain: ChainSettings {
                temperature: 5.0,
                force,
                max_steps: 20_000,
                patience: 500,
                ..scales.chain.clone()
            },
            ..scales
        };
        let found = sequential(&energy, &kernel, &minima, &settings, &Run::default()).unwrap();
        (found.landscape.groups.members.len(), found)
    };
    let (one, all) = groups(1000.0);
    assert_eq!(one, 1);
    let ids = |ids: &[usize]| ids.iter().map(|id| MinimumId(*id)).collect::<Vec<_>>();
    let (_, some) = groups(2.0);
    assert_eq!(some.landscape.groups.members, [ids(&[0]), ids(&[1, 2])]);
    // Upper bounds, up to the length of a step.
    let height = all
        .landscape
        .tree
        .minimax(MinimumId(0), MinimumId(1))
        .unwrap();
    assert!(height > -40.67 - 0.05 && height < 60.0, "{height}");
}
