//! A gallery of awkward energies: what the search says of each is known beforehand.

use landscape::energy::{Energy, FunctionOn};
use landscape::space::Euclidean;
use landscape::topography::{
    self, Doubt, Exploration, FamilySettings, SearchSettings, explore, in_box,
};

/// Searches from random points of the square of side 2 `half`, with several seeds.
fn explored(energy: &dyn Energy, half: f64) -> Vec<Exploration> {
    let (low, high) = ([-half; 2], [half; 2]);
    let draw = in_box(&low, &high);
    let search = |seed| {
        let settings = SearchSettings::measured(energy, &draw, seed);
        explore(energy, &draw, &settings, &topography::Run::default()).unwrap()
    };
    (0..4).map(search).collect()
}

fn numbers(found: &Exploration) -> (usize, usize) {
    (found.minima.len(), found.saddles.len())
}

fn bowl(x: f64, y: f64) -> (f64, [f64; 2]) {
    (0.5 * (x * x + y * y), [x, y])
}

/// Requires that nothing is claimed for this reason (or because of kinks), and that descents did not finish.
fn check_doubt(found: &Exploration, also: Option<Doubt>) {
    let coverage = &found.coverage;
    assert!(
        coverage.unfinished > 0 && coverage.sure.abs() < 1e-15,
        "{coverage:?}"
    );
    assert!(
        coverage.doubt == Some(Doubt::Unfinished) || (also.is_some() && coverage.doubt == also),
        "{coverage:?}"
    );
}

/// A function of the plane and its derivatives.
fn plane(function: impl Fn(f64, f64) -> (f64, [f64; 2]) + Sync) -> impl Energy {
    FunctionOn::new(Euclidean::new(2), move |p: &[f64], gradient: &mut [f64]| {
        let (energy, slopes) = function(p[0], p[1]);
        gradient.copy_from_slice(&slopes);
        energy
    })
}

/// −depth exp(−((x − cx)² + (y − cy)²) / 2 width²).
fn well(x: f64, y: f64, centre: [f64; 2], width: f64, depth: f64) -> (f64, [f64; 2]) {
    let (dx, dy) = (x - centre[0], y - centre[1]);
    let square = width * width;
    let value = -depth * libm::exp(-0.5 * (dx * dx + dy * dy) / square);
    (value, [-value * dx / square, -value * dy / square])
}

fn sum(parts: &[(f64, [f64; 2])]) -> (f64, [f64; 2]) {
    parts
        .iter()
        .fold((0.0, [0.0; 2]), |(e, g), (energy, slopes)| {
            (e + energy, [g[0] + slopes[0], g[1] + slopes[1]])
        })
}

#[test]
fn holes_without_a_bottom_are_told() {
    // Beside the hole is a well. The scales of the surface are measured below random points, which may lie in the hole.
    let logarithm = plane(|x, y| {
        let square: f64 = (x - 1.0).powi(2) + y * y;
        let hole = (
            0.25 * libm::log(square),
            [0.5 * (x - 1.0) / square, 0.5 * y / square],
        );
        sum(&[hole, bowl(x, y), well(x, y, [-1.0, 0.0], 0.4, 1.0)])
    });
    let charge = plane(|x, y| {
        let radius = libm::hypot(x - 1.0, y);
        let slope = 0.1 / radius.powi(3);
        let hole = (-0.1 / radius, [slope * (x - 1.0), slope * y]);
        sum(&[hole, bowl(x, y), well(x, y, [-1.0, 0.0], 0.4, 1.0)])
    });
    for energy in [&logarithm as &dyn Energy, &charge] {
        for found in explored(energy, 2.0) {
            // If the scales were measured in the hole, nothing is found.
            assert!(numbers(&found) <= (1, 0), "{:?}", numbers(&found));
            if numbers(&found) == (1, 0) {
                check_doubt(&found, Some(Doubt::Kinks));
            }
        }
    }
}

#[test]
fn pointed_minima_are_told() {
    let cone = plane(|x, y| {
        let radius = libm::hypot(x, y).max(1e-300);
        (radius, [x / radius, y / radius])
    });
    let root = plane(|x, y| {
        let radius = libm::hypot(x, y).max(1e-200);
        let slope = 0.5 / libm::pow(radius, 1.5);
        (radius.sqrt(), [slope * x, slope * y])
    });
    for found in explored(&cone, 2.0) {
        check_doubt(&found, Some(Doubt::Kinks));
        assert!(numbers(&found) <= (1, 0));
    }
    for found in explored(&root, 2.0) {
        check_doubt(&found, Some(Doubt::Kinks));
        // A descent may hit the very point.
        assert!(numbers(&found) <= (1, 0));
    }
    // The slope of |x|^(3/2) is continuous and its curvature infinite.
    let bent = plane(|x, y| {
        let valley = y * y - 1.0;
        (
            valley * valley + libm::pow(x.abs(), 1.5),
            [1.5 * x.abs().sqrt() * x.signum(), 4.0 * y * valley],
        )
    });
    for found in explored(&bent, 2.0) {
        assert_eq!(numbers(&found), (2, 1));
        assert!((found.saddles[0].energy - 1.0).abs() < 1e-9);
    }
}

#[test]
fn jumps_are_told() {
    // The lowest points are at the foot of the cliff, where the gradient does not vanish.
    let cliff = plane(|x, y| {
        let (energy, gradient) = bowl(x, y);
        (energy - f64::from(u8::from(x > 0.5)), gradient)
    });
    for found in explored(&cliff, 2.0) {
        check_doubt(&found, None);
        assert_eq!(numbers(&found), (1, 0));
    }
    // A step up has nothing at its foot.
    let step = plane(|x, y| {
        let (energy, gradient) = bowl(x, y);
        (energy + f64::from(u8::from(x > 0.5)), gradient)
    });
    for found in explored(&step, 2.0) {
        assert_eq!(numbers(&found), (1, 0));
    }
}

#[test]
fn gaps_in_the_domain_part_the_minima() {
    let gap = plane(|x, y| {
        let parts = [
            bowl(x, y),
            well(x, y, [-1.0, 0.0], 0.4, 1.0),
            well(x, y, [1.0, 0.3], 0.4, 1.2),
        ];
        let (energy, gradient) = sum(&parts);
        (
            if libm::hypot(x, y) < 0.3 {
                f64::NAN
            } else {
                energy
            },
            gradient,
        )
    });
    for found in explored(&gap, 2.0) {
        assert_eq!(numbers(&found), (2, 0));
        let doubt = found.coverage.doubt;
        assert!(
            matches!(doubt, Some(Doubt::Apart | Doubt::Unfinished)),
            "{doubt:?}"
        );
    }
}

#[test]
fn wells_of_different_width_are_found_or_not_excluded() {
    let funnels = plane(|x, y| {
        let (height, slopes) = bowl(x, y);
        sum(&[
            well(x, y, [-1.0, 0.0], 0.8, 1.0),
            well(x, y, [1.5, 0.5], 0.02, 1.0),
            (0.1 * height, slopes.map(|slope| 0.1 * slope)),
        ])
    });
    for found in explored(&funnels, 3.0) {
        // One of 3,000 random points lies in the narrow well.
        let complete = numbers(&found) == (2, 1);
        assert!(
            complete || found.coverage.sure < 0.99,
            "{:?}",
            found.coverage
        );
    }
}

/// Where only one minimum was met, nothing but the size of other basins is bounded: the deepest well may be too narrow.
#[test]
fn one_minimum_alone_is_no_ground_for_a_claim() {
    let needle = plane(|x, y| {
        let (height, slopes) = bowl(x, y);
        sum(&[
            well(x, y, [2.0, 1.5], 0.1, 1.0),
            (0.05 * height, slopes.map(|slope| 0.05 * slope)),
        ])
    });
    let mut alone = 0;
    for found in explored(&needle, 4.0) {
        if numbers(&found) == (1, 0) {
            let coverage = found.coverage;
            assert_eq!(coverage.doubt, Some(Doubt::Alone));
            assert!(coverage.sure.abs() < 1e-15 && coverage.unseen_below.is_none());
            assert!((0.01..0.2).contains(&coverage.undrawn_share_below));
            alone += 1;
        } else {
            assert_eq!(numbers(&found), (2, 1));
        }
    }
    assert!(alone > 0);
}

#[test]
fn plains_stiff_valleys_and_close_pairs_are_mapped() {
    let plain = plane(|x, y| {
        sum(&[
            well(x, y, [-1.0, 0.0], 0.3, 1.0),
            well(x, y, [1.0, 0.0], 0.3, 0.8),
        ])
    });
    let stiff = plane(|x, y| {
        let (valley, off) = (x * x - 1.0, y - 0.1 * x);
        (
            valley * valley + 1e6 * off * off,
            [4.0 * x * valley - 2e5 * off, 2e6 * off],
        )
    });
    let close = plane(|x, y| {
        let valley = x * x - 1e-4;
        (valley * valley + y * y, [4.0 * x * valley, 2.0 * y])
    });
    for (name, energy, half) in [
        ("plain", &plain as &dyn Energy, 3.0),
        ("stiff", &stiff, 2.0),
        ("close", &close, 2.0),
    ] {
        for found in explored(energy, half) {
            assert_eq!(numbers(&found), (2, 1), "{name}");
            assert!(
                found.coverage.sure > 0.8 && found.coverage.sure < 0.99,
                "{name}"
            );
        }
    }
}

#[test]
fn plateaus_and_troughs_of_one_energy_are_apart() {
    let discs = plane(|x, y| {
        // Squared depth beyond the edge of a disc, and its derivatives.
        let outside = |centre: f64| {
            let radius = libm::hypot(x - centre, y);
            let beyond = (radius - 0.4).max(0.0);
            let slope = 2.0 * beyond / radius.max(1e-300);
            (beyond * beyond, [slope * (x - centre), slope * y])
        };
        let (one, other) = (outside(1.2), outside(-1.2));
        let slopes = [0, 1].map(|k| other.0 * one.1[k] + one.0 * other.1[k]);
        (one.0 * other.0, slopes)
    });
    let troughs = plane(|x, _| {
        let valley = x * x - 1.0;
        (valley * valley, [4.0 * x * valley, 0.0])
    });
    for (name, energy, height) in [
        ("discs", &discs as &dyn Energy, 0.4096),
        ("troughs", &troughs, 1.0),
    ] {
        for found in explored(energy, 2.0) {
            assert_eq!(numbers(&found), (2, 1), "{name}");
            let saddle = &found.saddles[0];
            assert_ne!(saddle.ends[0], saddle.ends[1], "{name}");
            assert!((saddle.energy - height).abs() < 1e-6, "{name}");
            assert_eq!(found.coverage.doubt, Some(Doubt::Degenerate), "{name}");
        }
    }
}

/// Where n valleys meet in one point, all curvatures vanish. It is one saddle, which joins all n minima.
#[test]
fn saddles_where_several_valleys_meet_are_one_each() {
    // The real part of z^n, n = 3 and 4, with walls around.
    let monkey = plane(|x, y| {
        let square = x * x + y * y;
        (
            x * (x * x - 3.0 * y * y) + 0.5 * square * square,
            [
                3.0 * (x * x - y * y) + 2.0 * square * x,
                -6.0 * x * y + 2.0 * square * y,
            ],
        )
    });
    let cross = plane(|x, y| {
        let (a, b) = (x * x, y * y);
        let square = a + b;
        (
            a * a - 6.0 * a * b + b * b + square.powi(3),
            [
                4.0 * x * (a - 3.0 * b) + 6.0 * square * square * x,
                4.0 * y * (b - 3.0 * a) + 6.0 * square * square * y,
            ],
        )
    });
    for (energy, valleys) in [(&monkey as &dyn Energy, 3), (&cross, 4)] {
        for found in explored(energy, 2.0) {
            assert_eq!(numbers(&found), (valleys, valleys - 1));
            assert_eq!(found.distinct_saddles().count(), 1);
            for (k, saddle) in found.saddles.iter().enumerate() {
                assert_eq!(saddle.audit.duplicate_of, (k > 0).then_some(0));
                assert!(saddle.energy.abs() < 1e-9);
            }
            let landscape = found.landscape(energy, &FamilySettings::default());
            assert_eq!(landscape.tree.roots.len(), 1);
            // The estimate of what is missing knows it as one saddle, not as several that are met equally often.
            let coverage = &found.coverage;
            assert_eq!(coverage.arrived, found.saddles[0].hits);
            // Searches end so far from the centre of the cross that it may seem to be no isolated point.
            assert!(coverage.doubt.is_none() || valleys > 3);
        }
    }
}

/// A kinked ridge between two wells has no saddle that can be verified, so nothing bounds the number of those missing.
#[test]
fn a_kinked_ridge_leaves_no_bound() {
    let ridge = plane(|x, y| {
        let one = ((x - 1.0).powi(2) + y * y, [2.0 * (x - 1.0), 2.0 * y]);
        let other = ((x + 1.0).powi(2) + y * y + 0.3, [2.0 * (x + 1.0), 2.0 * y]);
        if one.0 < other.0 { one } else { other }
    });
    for found in explored(&ridge, 2.0) {
        assert_eq!(numbers(&found), (2, 0));
        assert_eq!(found.coverage.doubt, Some(Doubt::Apart));
        let bounds = (found.coverage.unseen, found.coverage.unseen_below);
        assert_eq!(bounds, (None, None));
    }
}
