//! Closes a hand by damped least squares over pose and joints.

use nalgebra::{DMatrix, DVector, Vector3};
use serde::{Deserialize, Serialize};

use super::touch::{CapsuleTouch, capsule_touches};
use crate::grasp::Grasp;
use crate::grasp::closure::{PointContact, contact_forces};
use crate::grasp::energy::GraspEnergy;
use crate::hand::{Hand, LinkId, PosedHand, Wrench, closest_points};
use crate::space::{Pose, PoseSpace, Space};

/// Settings of the closing of a hand.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClosingSettings {
    /// Depth to which the hardest-pressing capsule is pressed into the object, metres.
    pub depth_m: f64,
    /// Distance from the surface within which capsules are pressed, metres. Those of the contacts are always pressed.
    pub reach_m: f64,
    /// Digits that do not touch but are closer than this are closed until they touch, metres.
    pub free_reach_m: f64,
    /// Friction at which the contact forces that determine the depths balance.
    pub friction: f64,
    /// Number of times the depths are determined anew.
    pub rounds: usize,
    /// Least-squares steps in each round.
    pub steps: usize,
}

impl Default for ClosingSettings {
    fn default() -> Self {
        Self {
            depth_m: 0.0005,
            reach_m: 0.001,
            free_reach_m: 0.02,
            friction: 0.2,
            rounds: 4,
            steps: 15,
        }
    }
}

/// Error that counts as one, metres.
const TOLERANCE_M: f64 = 5e-5;
/// Tolerated depth of other capsules beyond the greatest goal depth, metres.
const SLACK_M: f64 = 1e-4;
/// Tolerated overlap of the hand with itself, metres.
const SELF_OVERLAP_M: f64 = 1e-3;
/// Longest step, metres.
const LONGEST_STEP_M: f64 = 5e-3;
/// Distance below which surfaces are considered, metres.
const VIEW_M: f64 = 6e-3;
/// Greatest depth of a digit that did not touch before, metres.
const LIGHT_M: f64 = 1e-4;

#[derive(Debug, Clone, Copy)]
struct Goal {
    capsule: usize,
    depth_m: f64,
}

/// The pose of a grasp after its hand was closed until it presses.
///
/// ```text
/// min Σ_goals (gap_c + p_c)² + Σ_others min(0, gap_c + p_max)² + Σ_pairs max(0, overlap − 1 mm)²,
/// p_c = p f_c / max f,    f: balanced contact forces, as far inside the friction cones as possible
/// ```
///
/// Gaps are signed distances of capsules from the mesh. Levenberg–Marquardt steps keep the movement small, and joints stay
/// within their limits. The result is deterministic and takes some tens of milliseconds.
///
/// # Panics
/// If the grasp belongs to another hand.
pub fn close_hand(energy: &GraspEnergy, grasp: &Grasp, settings: &ClosingSettings) -> Pose {
    let hand = energy.hand();
    let mut at = TouchingHand::new(energy, grasp.pose.clone(), settings);
    let chosen = capsules_of(hand, &at.posed, &grasp.contacts);
    for _ in 0..settings.rounds {
        let goals = goals(energy, &at, &chosen, settings);
        at = approach(energy, at, &goals, settings);
    }
    at.pose
}

/// The capsules on whose surface the points `contacts` lie.
fn capsules_of(hand: &Hand, posed: &PosedHand, contacts: &[u32]) -> Vec<usize> {
    let off_surface = |index: u32, capsule: usize| {
        let pair = closest_points(&[posed.points[index as usize]; 2], &posed.capsules[capsule]);
        (pair.offset.norm() - hand.capsules[capsule].radius_m).abs()
    };
    let mut found: Vec<usize> = contacts
        .iter()
        .filter_map(|&index| {
            let link = hand.surface[index as usize].link;
            (0..hand.capsules.len())
                .filter(|&capsule| hand.capsules[capsule].link == link)
                .min_by(|&a, &b| off_surface(index, a).total_cmp(&off_surface(index, b)))
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

struct TouchingHand {
    pose: Pose,
    posed: PosedHand,
    touches: Vec<CapsuleTouch>,
}

impl TouchingHand {
    fn new(energy: &GraspEnergy, pose: Pose, settings: &ClosingSettings) -> Self {
        let mut posed = PosedHand::default();
        energy.hand().pose(&pose, &mut posed);
        let reach_m = settings.free_reach_m.max(VIEW_M);
        let touches = capsule_touches(&energy.object().exact, energy.hand(), &posed, reach_m);
        Self {
            pose,
            posed,
            touches,
        }
    }
}

fn goals(
    energy: &GraspEnergy,
    at: &TouchingHand,
    chosen: &[usize],
    settings: &ClosingSettings,
) -> Vec<Goal> {
    let (hand, object) = (energy.hand(), energy.object());
    let digit = |touch: &CapsuleTouch| hand.links[touch.link.0].digit;
    let pressed: Vec<&CapsuleTouch> = at
        .touches
        .iter()
        .filter(|touch| chosen.contains(&touch.capsule) || touch.gap_m < settings.reach_m)
        .collect();
    let contacts: Vec<PointContact> = pressed
        .iter()
        .map(|touch| touch.contact(&object.centroid, energy.unit_m()))
        .collect();
    // If no forces balance yet, all capsules press equally.
    let forces = contact_forces(&contacts, settings.friction).map_or_else(
        || vec![1.0; contacts.len()],
        |balanced| {
            let along = balanced.forces.iter().zip(&contacts);
            along
                .map(|(force, contact)| force.dot(&contact.inward_normal).max(0.0))
                .collect()
        },
    );
    let largest = forces.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut goals: Vec<Goal> = pressed
        .iter()
        .zip(forces)
        .map(|(touch, force)| Goal {
            capsule: touch.capsule,
            depth_m: settings.depth_m * force / largest,
        })
        .collect();
    for free in 1..hand.digits.len() {
        if pressed.iter().any(|touch| digit(touch) == free) {
            continue;
        }
        let nearest = at
            .touches
            .iter()
            .filter(|touch| digit(touch) == free && touch.gap_m < settings.free_reach_m)
            .min_by(|a, b| a.gap_m.total_cmp(&b.gap_m));
        goals.extend(nearest.map(|touch| Goal {
            capsule: touch.capsule,
            depth_m: LIGHT_M.min(settings.depth_m),
        }));
    }
    goals
}

/// Residuals and their derivatives along the tangents.
struct Residuals {
    values: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Residuals {
    fn cost(&self) -> f64 {
        self.values.iter().map(|value| value * value).sum()
    }
}

/// Computes the derivative of a distance that grows as points of links move along given directions.
struct Puller<'a> {
    hand: &'a Hand,
    space: &'a PoseSpace,
    no_joint: Vec<f64>,
}

impl Puller<'_> {
    fn row(&self, posed: &PosedHand, moves: &[(LinkId, Vector3<f64>, Vector3<f64>)]) -> Vec<f64> {
        let mut wrenches = vec![Wrench::default(); self.hand.links.len()];
        for (link, point, direction) in moves {
            wrenches[link.0].add(point, direction);
        }
        let mut row = vec![0.0; self.space.tangents()];
        let metric = self.space.metric();
        self.hand
            .pull_back(posed, &wrenches, &self.no_joint, metric, &mut row);
        for slope in &mut row {
            *slope /= TOLERANCE_M;
        }
        row
    }
}

fn residuals(
    puller: &Puller<'_>,
    at: &TouchingHand,
    goals: &[Goal],
    settings: &ClosingSettings,
) -> Residuals {
    let hand = puller.hand;
    let (mut values, mut rows) = (Vec::new(), Vec::new());
    for touch in &at.touches {
        let goal = goals.iter().find(|goal| goal.capsule == touch.capsule);
        let off_m = goal.map_or_else(
            || (touch.gap_m + settings.depth_m + SLACK_M).min(0.0),
            |goal| touch.gap_m + goal.depth_m,
        );
        if off_m != 0.0 {
            values.push(off_m / TOLERANCE_M);
            rows.push(puller.row(
                &at.posed,
                &[(touch.link, touch.on_hand, -touch.inward_normal)],
            ));
        }
    }
    for &[first, second] in &hand.self_pairs {
        let (one, two) = (&hand.capsules[first], &hand.capsules[second]);
        let nearest = closest_points(&at.posed.capsules[first], &at.posed.capsules[second]);
        let distance = nearest.offset.norm();
        let over_m = one.radius_m + two.radius_m - SELF_OVERLAP_M - distance;
        if over_m > 0.0 && distance > 0.0 {
            let [a, b] = at.posed.capsules[first];
            let a = a + (b - a) * nearest.s;
            let apart = nearest.offset / distance;
            values.push(over_m / TOLERANCE_M);
            let moves = [(one.link, a, apart), (two.link, a + nearest.offset, -apart)];
            rows.push(puller.row(&at.posed, &moves));
        }
    }
    Residuals { values, rows }
}

/// Levenberg–Marquardt steps toward the goals.
fn approach(
    energy: &GraspEnergy,
    mut at: TouchingHand,
    goals: &[Goal],
    settings: &ClosingSettings,
) -> TouchingHand {
    let (hand, space) = (&**energy.hand(), energy.pose_space());
    let puller = Puller {
        hand,
        space,
        no_joint: vec![0.0; hand.joints.len()],
    };
    let mut now = residuals(&puller, &at, goals, settings);
    // Slopes are 1 / tolerance, so this damps moves that change no gap by more than a hundredth of their length.
    let mut damping = (0.01 / TOLERANCE_M).powi(2);
    for _ in 0..settings.steps {
        if now.cost() < 1e-3 {
            break;
        }
        let Some(tangent) = step(&now, damping, space.tangents()) else {
            break;
        };
        let mut pose = at.pose.clone();
        space.exp(&mut pose, &tangent);
        for (coordinate, joint) in pose.joints_mut().iter_mut().zip(&hand.joints) {
            if !joint.wraps {
                *coordinate = coordinate.clamp(joint.limits_rad[0], joint.limits_rad[1]);
            }
        }
        let moved = TouchingHand::new(energy, pose, settings);
        let then = residuals(&puller, &moved, goals, settings);
        if then.cost() < now.cost() {
            (at, now) = (moved, then);
            damping = (damping * 0.3).max((1e-3 / TOLERANCE_M).powi(2));
        } else {
            damping *= 8.0;
        }
    }
    at
}

/// −(`JᵀJ` + λI)⁻¹`Jᵀr`, limited to the longest step.
fn step(residuals: &Residuals, damping: f64, tangents: usize) -> Option<Vec<f64>> {
    let count = residuals.values.len();
    let jacobian = DMatrix::from_fn(count, tangents, |row, column| residuals.rows[row][column]);
    let values = DVector::from_column_slice(&residuals.values);
    let mut normal = jacobian.tr_mul(&jacobian);
    for i in 0..tangents {
        normal[(i, i)] += damping;
    }
    let step = normal.cholesky()?.solve(&jacobian.tr_mul(&values));
    let shrink = (LONGEST_STEP_M / step.norm()).min(1.0);
    Some(step.iter().map(|value| -value * shrink).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::grasp::EnergySettings;
    use crate::object::Object;

    /// Compares the slopes of all residuals with central differences, for a palm at the surface of a box.
    #[test]
    fn rows_are_the_derivatives_of_the_residuals() {
        let hand = Arc::new(Hand::human());
        let object = Arc::new(Object::named("box").unwrap());
        let energy = GraspEnergy::new(hand.clone(), object, EnergySettings::four_points()).unwrap();
        let settings = ClosingSettings {
            // With this reach nothing enters or leaves the considered set.
            free_reach_m: 0.05,
            ..ClosingSettings::default()
        };
        let mut x = Pose::from(hand.rest_coordinates());
        let top = energy
            .object()
            .exact
            .nearest(&Vector3::new(0.01, 0.02, 1.0));
        x[2] = top.point.z - hand.palm.centre.z + 0.03;
        let space = energy.pose_space();
        let at = TouchingHand::new(&energy, x.clone(), &settings);
        assert!(at.touches.len() > 3, "{} touches", at.touches.len());
        let goals: Vec<Goal> = at
            .touches
            .iter()
            .map(|touch| Goal {
                capsule: touch.capsule,
                depth_m: 3e-4,
            })
            .collect();
        let puller = Puller {
            hand: &hand,
            space,
            no_joint: vec![0.0; hand.joints.len()],
        };
        let at_shift = |tangent: &[f64]| {
            let mut moved = x.clone();
            space.exp(&mut moved, tangent);
            let place = TouchingHand::new(&energy, moved, &settings);
            residuals(&puller, &place, &goals, &settings)
        };
        let here = residuals(&puller, &at, &goals, &settings);
        let (mut smooth, mut kinks) = (0, 0);
        for i in 0..space.tangents() {
            let along = |step: f64| {
                let mut tangent = vec![0.0; space.tangents()];
                tangent[i] = step;
                at_shift(&tangent).values
            };
            let step = 1e-6;
            let (ahead, behind) = (along(step), along(-step));
            for (k, row) in here.rows.iter().enumerate() {
                let difference = (ahead[k] - behind[k]) / (2.0 * step);
                // There is no derivative at an edge of the mesh.
                let bend = (ahead[k] - 2.0 * here.values[k] + behind[k]).abs() / step;
                if bend > 1e-3 / TOLERANCE_M {
                    kinks += 1;
                    continue;
                }
                smooth += 1;
                let error = (row[i] - difference).abs() / (1.0 / TOLERANCE_M);
                assert!(error < 1e-3, "{k} {i}: {} against {difference}", row[i]);
            }
        }
        assert!(smooth > 10 * kinks, "{smooth} smooth, {kinks} kinks");
    }
}
