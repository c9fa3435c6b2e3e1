use super::*;
use crate::grasp::layer::LayerSettings;
use crate::sample::{Rng, Task, stream};
use nalgebra::Vector6;
use rand::RngExt;

const SETTINGS: ComplianceSettings = ComplianceSettings {
    friction: 0.3,
    load: 1.0,
    torque_share: 0.4,
    free_motion: 20.0,
    friction_rounding: 1e-9,
    rounding: 0.01,
};

fn vector(rng: &mut Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

fn nodes(count: usize, rng: &mut Rng) -> Vec<Node> {
    (0..count)
        .map(|_| {
            let outward = vector(rng).normalize();
            Node {
                stiffness: rng.random_range(0.0..2.0),
                arm: outward + vector(rng) * 0.2,
                inward_normal: (vector(rng) * 0.4 - outward).normalize(),
            }
        })
        .collect()
}

fn value(nodes: &[Node], axes: &Matrix3<f64>) -> f64 {
    mean_compliance(nodes, axes, &SETTINGS).value
}

#[test]
fn without_contacts_it_is_one() {
    assert!((value(&[], &Matrix3::identity()) - 1.0).abs() < 1e-14);
}

/// The derivatives by stiffness, arm, normal and rotation of the loads.
#[test]
fn derivatives() {
    let mut rng = stream(1, Task::Start, 0);
    let identity = Matrix3::identity();
    let step = 1e-6;
    for count in [1, 3, 5, 9] {
        let nodes = nodes(count, &mut rng);
        let found = mean_compliance(&nodes, &identity, &SETTINGS);
        let difference =
            |changed: &dyn Fn(f64) -> f64| (changed(step) - changed(-step)) / (2.0 * step);
        for i in 0..count {
            let with = |change: &dyn Fn(&mut Node)| {
                let mut changed = nodes.clone();
                change(&mut changed[i]);
                value(&changed, &identity)
            };
            let direction = vector(&mut rng);
            let n = nodes[i].inward_normal;
            let checks = [
                (
                    found.by_stiffness[i],
                    difference(&|h| with(&|node| node.stiffness += h)),
                ),
                (
                    found.by_arm[i].dot(&direction),
                    difference(&|h| with(&|node| node.arm += direction * h)),
                ),
                (
                    found.by_normal[i].dot(&(direction - n * n.dot(&direction))),
                    difference(&|h| {
                        with(&|node| node.inward_normal = (n + direction * h).normalize())
                    }),
                ),
            ];
            for (analytic, estimate) in checks {
                assert!((analytic - estimate).abs() < 1e-6, "{analytic} {estimate}");
            }
        }
        let axis = vector(&mut rng);
        let estimate = difference(&|h| value(&nodes, nalgebra::Rotation3::new(axis * h).matrix()));
        assert!((found.by_rotation.dot(&axis) - estimate).abs() < 1e-6);
    }
}

/// Pads of one side do not pull, and two pads do not resist a torque about the line between them.
#[test]
fn single_loads_show_where_a_hand_does_not_hold() {
    let pad = |x: f64, y: f64| Node {
        stiffness: 5.0,
        arm: Vector3::new(x, y, 0.0),
        inward_normal: Vector3::new(-x, -y, 0.0),
    };
    let found = |nodes: &[Node]| load_compliance(nodes, &Matrix3::identity(), &SETTINGS);
    let free = found(&[]);
    assert!((free.force - 1.0).abs() < 1e-9 && (free.torque - 1.0).abs() < 1e-9);
    let one_side = found(&[pad(1.0, 0.0)]);
    assert!(one_side.force > 0.99, "{one_side:?}");
    let two = found(&[pad(1.0, 0.0), pad(-1.0, 0.0)]);
    let half = 0.75_f64.sqrt();
    let three = found(&[pad(1.0, 0.0), pad(-0.5, half), pad(-0.5, -half)]);
    assert!(
        three.force < two.force && two.force < 0.3,
        "{two:?} {three:?}"
    );
    assert!(three.torque < 0.5 * two.torque, "{two:?} {three:?}");
}

#[test]
fn two_jaws_need_not_resist_the_torque_about_their_line() {
    let layer = LayerSettings::default();
    let [force, torque] = [0.1, 0.9];
    let pinch = LoadCompliance { force, torque };
    assert!(layer.holds(&pinch, 2) && !layer.holds(&pinch, 3));
    let slack = LoadCompliance { force: 0.9, torque };
    assert!(!layer.holds(&slack, 2));
}

/// Strong duality: the least energy of forces in their cones, found by projected gradient steps on the first form, is
/// the maximum of the second.
#[test]
fn both_forms_agree() {
    let mut rng = stream(2, Task::Start, 0);
    for _ in 0..5 {
        let nodes: Vec<Node> = nodes(6, &mut rng)
            .into_iter()
            .map(|node| Node {
                stiffness: node.stiffness + 0.1,
                ..node
            })
            .collect();
        let load: [f64; 6] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let (mu, kappa) = (SETTINGS.friction, SETTINGS.free_motion);
        let groups: Vec<Group> = nodes.chunks(LANES).map(Group::of).collect();
        let cone = Cone::new(mu, SETTINGS.friction_rounding);
        let (y, dual) = maximise(&groups, &load, [0.0; 6], 1.0 / kappa, &cone);
        let again = Dual::at(&groups, &load, &y, 1.0 / kappa, &cone).value;
        assert!((dual - again).abs() < 1e-9 * (1.0 + dual), "{dual} {again}");
        let load = Vector6::from(load);

        let mut forces = vec![Vector3::zeros(); nodes.len()];
        let steepest = kappa * 12.0 * nodes.len() as f64 + 10.0;
        let mut primal = f64::INFINITY;
        for _ in 0..200_000 {
            let net: Vector6<f64> = nodes
                .iter()
                .zip(&forces)
                .map(|(node, f)| wrench(f, &node.arm))
                .sum();
            let missing = net - load;
            let own: f64 = nodes
                .iter()
                .zip(&forces)
                .map(|(node, f): (_, &Vector3<f64>)| 0.5 * f.norm_squared() / node.stiffness)
                .sum();
            primal = 0.5 * kappa * missing.norm_squared() + own;
            let [force, torque] = [0, 3].map(|row| missing.fixed_rows::<3>(row).into_owned());
            let pulled = |arm: &Vector3<f64>| force + torque.cross(arm);
            for (node, force) in nodes.iter().zip(&mut forces) {
                let slope = pulled(&node.arm) * kappa + *force / node.stiffness;
                let u = *force - slope / steepest;
                let n = node.inward_normal;
                let tangent = u - n * n.dot(&u);
                let at = Potential::of(n.dot(&u), tangent.norm_squared(), &cone);
                *force = n * at.along + tangent / at.tangential * at.across;
            }
        }
        assert!(primal >= dual - 1e-9, "{primal} {dual}");
        assert!(primal - dual < 1e-4 * (1.0 + dual), "{primal} {dual}");
    }
}

fn wrench(force: &Vector3<f64>, arm: &Vector3<f64>) -> Vector6<f64> {
    let torque = arm.cross(force);
    Vector6::new(force.x, force.y, force.z, torque.x, torque.y, torque.z)
}
