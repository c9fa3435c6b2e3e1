//! Depth of hand and object in each other, compared with dense samples of the exported hand.
#![cfg(feature = "grasp")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::collections::BTreeMap;
use std::sync::Arc;

use landscape::grasp::start::start_pose;
use landscape::grasp::synthesis::{SynthesisSettings, synthesize};
use landscape::grasp::{EnergySettings, Grasp, GraspEnergy, judge};
use landscape::hand::{Hand, PosedHand, Skin};
use landscape::mesh::{ExactMesh, Mesh};
use landscape::object::Object;
use landscape::optimize::QuenchSettings;
use landscape::sample::{Rng, Task, stream};
use nalgebra::Vector3;
use rand::RngExt;

/// Largest amount by which the filter's depth may fall below that of a sample, metres.
const PROMISED_M: f64 = 1e-4;
/// Points spread evenly over the area of the triangles, whether or not these lie inside others.
fn spread(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    count: usize,
    rng: &mut Rng,
) -> Vec<Vector3<f64>> {
    let corners = |t: &[u32; 3]| t.map(|v| vertices[v as usize]);
    let mut total = 0.0;
    let sums: Vec<f64> = triangles
        .iter()
        .map(corners)
        .map(|[a, b, c]| {
            total += (b - a).cross(&(c - a)).norm();
            total
        })
        .collect();
    (0..count)
        .map(|_| {
            let at = rng.random_range(0.0..total);
            let [a, b, c] = corners(&triangles[sums.partition_point(|&sum| sum < at)]);
            let [mut u, mut v] = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)];
            if u + v > 1.0 {
                [u, v] = [1.0 - u, 1.0 - v];
            }
            a + (b - a) * u + (c - a) * v
        })
        .collect()
}

/// The first vertex of the piece that vertex `at` belongs to.
fn root(piece: &[usize], mut at: usize) -> usize {
    while piece[at] != at {
        at = piece[at];
    }
    at
}

/// The closed pieces of a posed skin.
fn pieces(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<Mesh> {
    let mut piece: Vec<usize> = (0..vertices.len()).collect();
    // Coincident corners are one.
    let mut places: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    for (index, vertex) in vertices.iter().enumerate() {
        let key = [vertex.x, vertex.y, vertex.z].map(f64::to_bits);
        piece[index] = *places.entry(key).or_insert(index);
    }
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| root(&piece, v as usize));
        let first = a.min(b).min(c);
        for other in [a, b, c] {
            piece[other] = first;
        }
    }
    let mut of: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
    for triangle in triangles {
        of.entry(root(&piece, triangle[0] as usize))
            .or_default()
            .push(*triangle);
    }
    of.into_values()
        .filter_map(|triangles| Mesh::new("piece", vertices.to_vec(), triangles).ok())
        .collect()
}

/// The deepest sample of the hand in the object, and of the object in a closed piece of the hand.
fn sampled(
    object: &Object,
    of_object: &[Vector3<f64>],
    skin: &Skin,
    posed: &PosedHand,
    rng: &mut Rng,
) -> f64 {
    let vertices = skin.pose(posed);
    let mut deepest = spread(&vertices, &skin.triangles, of_object.len(), rng)
        .iter()
        // Where the smooth shape says that it is far outside, it is outside.
        .filter(|point| object.shape.distance(point) < 0.003 * object.shape.lipschitz())
        .fold(0.0, |deepest: f64, point| {
            deepest.max(-object.exact.distance(point))
        });
    for piece in pieces(&vertices, &skin.triangles) {
        let [low, high] = piece.bounds();
        let exact = ExactMesh::new(&piece);
        for point in of_object {
            if low.inf(point) == low && high.sup(point) == high {
                deepest = deepest.max(-exact.distance(point));
            }
        }
    }
    deepest
}

/// Grasps, and random poses with various overlaps of hand and object.
fn poses(energy: &GraspEnergy, rng: &mut Rng) -> Vec<Vec<f64>> {
    let (hand, object) = (energy.hand(), energy.object());
    let mut poses: Vec<Vec<f64>> = (0..3)
        .map(|_| {
            let mut x = start_pose(hand, object, rng);
            let inward = rng.random_range(0.0..0.5);
            for (place, &centre) in x.iter_mut().zip(object.centroid.iter()) {
                *place += inward * (centre - *place);
            }
            x
        })
        .collect();
    let settings = SynthesisSettings {
        steps: 1,
        ..SynthesisSettings::default()
    };
    let refine = QuenchSettings::default().with_gradient_tolerance(1e-2);
    for chain in 0..2 {
        poses.push(
            synthesize(energy, &settings, &refine, 3, chain)
                .refined
                .pose
                .into(),
        );
    }
    poses
}

/// Compares the depth in the filters with `count` samples of the hand and as many of the object.
fn compare(hands: Vec<(String, Hand)>, objects: &[&str], count: usize) {
    let objects: Vec<Arc<Object>> = objects
        .iter()
        .map(|name| Arc::new(Object::named(name).unwrap()))
        .collect();
    let samples: Vec<Vec<Vector3<f64>>> = objects
        .iter()
        .map(|object| object.mesh.sample_surface(count, 1))
        .map(|samples| samples.iter().map(|sample| sample.point).collect())
        .collect();
    let mut rng = stream(5, Task::Start, 0);
    let mut short = Vec::new();
    for (name, hand) in hands {
        let (skin, hand) = (hand.solid_skin(), Arc::new(hand));
        let (mut overlaps, mut over) = (0, Vec::new());
        for (object, of_object) in objects.iter().zip(&samples) {
            let settings = EnergySettings::default();
            let energy = GraspEnergy::new(hand.clone(), object.clone(), settings).unwrap();
            for x in poses(&energy, &mut rng) {
                let mut posed = PosedHand::default();
                hand.pose(&x, &mut posed);
                let told = judge(&energy, &Grasp::new(x, vec![0, 1, 2, 3])).deepest_m;
                let found = sampled(object, of_object, &skin, &posed, &mut rng);
                overlaps += usize::from(found > 1e-3);
                over.push(1e3 * (told - found));
                if told < found - PROMISED_M {
                    short.push(format!("{name} on {}: {told} m of {found} m", object.name));
                }
            }
        }
        over.sort_by(f64::total_cmp);
        assert!(overlaps > 0, "{name}: {over:?}");
        // Samples lie millimetres apart, so they miss a little, and seldom much.
        assert!(over[over.len() / 2] < 2.0, "{name}: {over:?}");
    }
    assert!(short.is_empty(), "{}", short.join("\n"));
}

/// Tests the built-in hands, which consist of capsules or of boxes.
#[test]
fn no_sample_of_the_hand_is_deeper_than_is_told() {
    let hands = ["human", "gripper_three_finger", "gripper_parallel"];
    let hands = hands.map(|name| (name.to_owned(), Hand::named(name).unwrap()));
    compare(hands.into(), &["bottle_round"], 10_000);
}
