//! Closes a hand from a rough pose onto an object, so that the chosen regions touch and nothing penetrates.

use landscape::energy::Energy;
use landscape::hand::{Hand, PosedHand, Wrench, axis_distance, closest_points};
use landscape::object::Shape;
use landscape::optimize::{QuenchSettings, quench};
use landscape::space::{PoseSpace, Space, joints_of};
use nalgebra::{Matrix3, Vector3};

use crate::shape::Union;

/// Unit of all squared terms, metres.
const UNIT_M: f64 = 1e-3;
/// Cost of a normal that does not oppose the object's: (1 + n·m) times this, in squares of the unit.
const ALIGNMENT: f64 = 6.0;
/// Deviations that cost as much as a millimetre: joints of digits that touch and of the others, radians,
const TOUCHING_RAD: f64 = 0.22;
const IDLE_RAD: f64 = 0.05;
/// and the placement, metres and radians.
const SHIFT_M: f64 = 8e-3;
const TURN_RAD: f64 = 0.2;
/// Point of the root about which the placement is measured, metres.
const CENTRE_M: Vector3<f64> = Vector3::new(0.0, 0.09, 0.02);
/// Distance that free regions keep, metres.
const CLEARANCE_M: f64 = 5e-3;
/// Depth that counts as contact and not as penetration, metres.
const PRESSED_M: f64 = 3e-4;

/// The sum of squares that is minimised.
pub(crate) struct Closing<'a> {
    pub(crate) hand: &'a Hand,
    pub(crate) shape: &'a Union,
    /// Points of the object's surface, object frame.
    pub(crate) samples: &'a [Vector3<f64>],
    /// Surface points of each region that touches.
    pub(crate) touching: Vec<Vec<usize>>,
    /// Surface points that stay clear.
    pub(crate) free: Vec<usize>,
    /// The rough pose, and the factor on the cost of leaving it.
    pub(crate) rough: Vec<f64>,
    pub(crate) looseness: f64,
    pub(crate) oppose: f64,
    pub(crate) idle: Vec<bool>,
    /// Factors of contacts and of penetration.
    pub(crate) pull: f64,
    pub(crate) push: f64,
    pub(crate) space: PoseSpace,
}

/// Accuracy of a pose with respect to the requirements.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Distance of each region that touches, metres.
    pub(crate) gaps_m: Vec<f64>,
    /// Depths of the hand's points in the object, of the object's points in the hand's capsules, and of capsules in each
    /// other.
    pub(crate) depth_m: f64,
    pub(crate) intrusion_m: f64,
    pub(crate) overlap_m: f64,
    /// Largest excess of a joint beyond its limits, radians.
    pub(crate) beyond_rad: f64,
}

/// Digit, link, point, the object's normal there and the derivative of the normal.
type Contact = (usize, usize, Vector3<f64>, Vector3<f64>, Matrix3<f64>);

struct Sum {
    energy: f64,
    wrenches: Vec<Wrench>,
}

impl Sum {
    /// Adds `factor · value²/unit²` for a length whose derivative with respect to a point of a link is `slope`.
    fn square(
        &mut self,
        factor: f64,
        value: f64,
        link: usize,
        p: &Vector3<f64>,
        slope: &Vector3<f64>,
    ) {
        self.energy += factor * (value / UNIT_M).powi(2);
        self.wrenches[link].add(p, &(slope * (2.0 * factor * value / UNIT_M.powi(2))));
    }
}

impl Closing<'_> {
    /// The pose after closing in stages of growing strictness: factors of contacts and of penetration, and evaluations of
    /// each descent.
    pub(crate) fn close(&mut self) -> Vec<f64> {
        let mut x = self.rough.clone();
        for (pull, push, evaluations) in [(0.3, 0.3, 300), (2.0, 3.0, 400), (20.0, 60.0, 900)] {
            (self.pull, self.push) = (pull, push);
            let settings = QuenchSettings::default()
                .with_max_step(0.01)
                .with_gradient_tolerance(1.0)
                .with_max_evaluations(evaluations);
            // The touching points are chosen anew a few times, because the choice has kinks that stop a descent.
            for _ in 0..3 {
                x = quench(self, &x, &settings).x;
            }
        }
        x
    }

    pub(crate) fn fit(&self, x: &[f64]) -> Fit {
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        let distances: Vec<f64> = posed
            .points
            .iter()
            .map(|p| self.shape.distance(p))
            .collect();
        let gaps_m = self.touching.iter().map(|own| {
            own.iter()
                .map(|&i| distances[i])
                .fold(f64::INFINITY, f64::min)
        });
        let intrusion = self.samples.iter().map(|p| {
            let capsules = self.hand.capsules.iter().zip(&posed.capsules);
            capsules
                .map(|(c, ends)| c.radius_m - axis_distance(p, ends))
                .fold(f64::NEG_INFINITY, f64::max)
        });
        let overlap = self.hand.self_pairs.iter().map(|&[a, b]| {
            let apart = closest_points(&posed.capsules[a], &posed.capsules[b])
                .offset
                .norm();
            self.hand.capsules[a].radius_m + self.hand.capsules[b].radius_m - apart
        });
        let beyond = self.hand.joints.iter().zip(joints_of(x)).map(|(joint, q)| {
            let [low, high] = joint.limits;
            (low - q).max(q - high)
        });
        Fit {
            gaps_m: gaps_m.collect(),
            depth_m: -distances.iter().copied().fold(0.0, f64::min),
            intrusion_m: intrusion.fold(0.0, f64::max),
            overlap_m: overlap.fold(0.0, f64::max),
            beyond_rad: beyond.fold(0.0, f64::max),
        }
    }

    fn touch(&self, posed: &PosedHand, sum: &mut Sum) {
        let mut contacts = Vec::new();
        for own in &self.touching {
            let cost = |&i: &usize| {
                let (distance, normal) = self.shape.gradient(&posed.points[i]);
                let facing = 1.0 + self.hand.point_normal(posed, i).dot(&normal);
                (distance / UNIT_M).powi(2) + ALIGNMENT * facing
            };
            let nearest = own.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
            let Some(&i) = nearest else { continue };
            let link = self.hand.surface[i].link.0;
            let (p, n) = (posed.points[i], self.hand.point_normal(posed, i));
            let (distance, normal, hessian) = self.shape.hessian(&p);
            sum.square(self.pull, distance, link, &p, &normal);
            let factor = self.pull * ALIGNMENT;
            sum.energy += factor * (1.0 + n.dot(&normal));
            sum.wrenches[link].add(&p, &(hessian * n * factor));
            sum.wrenches[link].moment += n.cross(&normal) * factor;
            contacts.push((self.hand.links[link].digit, link, p, normal, hessian));
        }
        self.face(&contacts, sum);
        for &i in &self.free {
            let p = posed.points[i];
            let (distance, normal) = self.shape.gradient(&p);
            if distance < CLEARANCE_M {
                let link = self.hand.surface[i].link.0;
                sum.square(0.3 * self.push, CLEARANCE_M - distance, link, &p, &-normal);
            }
        }
    }

    /// Cost of the thumb not opposing the fingers: |n(thumb) + mean n(fingers)|² of the object's normals.
    fn face(&self, contacts: &[Contact], sum: &mut Sum) {
        let count = |thumb: bool| {
            contacts
                .iter()
                .filter(|c| c.0 > 0 && (c.0 == 1) == thumb)
                .count()
        };
        let share = [
            1.0 / count(false).max(1) as f64,
            1.0 / count(true).max(1) as f64,
        ];
        let weight = |contact: &Contact| share[usize::from(contact.0 == 1)];
        if self.oppose > 0.0 && count(true) > 0 && count(false) > 0 {
            let of_digits = || contacts.iter().filter(|c| c.0 > 0);
            let rest: Vector3<f64> = of_digits().map(|c| c.3 * weight(c)).sum();
            sum.energy += self.oppose * rest.norm_squared();
            for contact in of_digits() {
                let slope = contact.4 * rest * (2.0 * self.oppose * weight(contact));
                sum.wrenches[contact.1].add(&contact.2, &slope);
            }
        }
    }

    fn keep_apart(&self, posed: &PosedHand, sum: &mut Sum) {
        for (p, at) in posed.points.iter().zip(&self.hand.surface) {
            let (distance, normal) = self.shape.gradient(p);
            if distance < -PRESSED_M {
                sum.square(self.push, -PRESSED_M - distance, at.link.0, p, &-normal);
            }
        }
        for p in self.samples {
            for (capsule, ends) in self.hand.capsules.iter().zip(&posed.capsules) {
                let axis = ends[1] - ends[0];
                let far = 0.5 * axis.norm() + capsule.radius_m;
                if (p - 0.5 * (ends[0] + ends[1])).norm_squared() > far * far {
                    continue;
                }
                let along =
                    ((p - ends[0]).dot(&axis) / axis.norm_squared().max(1e-12)).clamp(0.0, 1.0);
                let offset = p - (ends[0] + axis * along);
                let depth = capsule.radius_m - offset.norm() - PRESSED_M;
                if depth > 0.0 {
                    // The link moves, so the capsule's nearest point approaches when it moves along the offset.
                    let slope = offset / offset.norm().max(1e-9);
                    sum.square(self.push, depth, capsule.link.0, p, &slope);
                }
            }
        }
        for &[a, b] in &self.hand.self_pairs {
            let (one, two) = (&self.hand.capsules[a], &self.hand.capsules[b]);
            let nearest = closest_points(&posed.capsules[a], &posed.capsules[b]);
            let apart = nearest.offset.norm();
            let depth = one.radius_m + two.radius_m - apart;
            if depth > 0.0 {
                let p = posed.capsules[a][0]
                    + (posed.capsules[a][1] - posed.capsules[a][0]) * nearest.s;
                let slope = nearest.offset / apart.max(1e-9);
                sum.square(self.push, depth, one.link.0, &p, &slope);
                let factor = -2.0 * self.push * depth / UNIT_M.powi(2);
                sum.wrenches[two.link.0].add(&(p + nearest.offset), &(slope * factor));
            }
        }
    }

    /// Joint limits and closeness to the rough joint angles.
    fn joints(&self, x: &[f64], energy: &mut f64) -> Vec<f64> {
        let mut gradient = vec![0.0; self.hand.joints.len()];
        for (j, joint) in self.hand.joints.iter().enumerate() {
            let scale = if self.idle[j] { IDLE_RAD } else { TOUCHING_RAD };
            let off = (x[7 + j] - self.rough[7 + j]) / scale;
            *energy += off * off;
            gradient[j] += 2.0 * off / scale;
            let [low, high] = joint.limits;
            let beyond = (x[7 + j] - high).max(0.0) + (x[7 + j] - low).min(0.0);
            *energy += 1e5 * beyond * beyond;
            gradient[j] += 2e5 * beyond;
        }
        gradient
    }
}

impl Energy for Closing<'_> {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let mut posed = PosedHand::default();
        self.hand.pose(x, &mut posed);
        let mut sum = Sum {
            energy: 0.0,
            wrenches: vec![Wrench::default(); self.hand.links.len()],
        };
        self.touch(&posed, &mut sum);
        self.keep_apart(&posed, &mut sum);
        let mut energy = sum.energy;
        let joint_gradient = self.joints(x, &mut energy);
        self.hand.pull_back(
            &posed,
            &sum.wrenches,
            &joint_gradient,
            self.space.metric(),
            gradient,
        );
        // For the placement, three points of the palm are tied to their rough positions.
        let mut rough = PosedHand::default();
        self.hand.pose_links(&self.rough, &mut rough);
        let mut tied = vec![Wrench::default(); self.hand.links.len()];
        let (here, there) = (posed.object_from_link[0], rough.object_from_link[0]);
        let arm = SHIFT_M / TURN_RAD;
        for end in [Vector3::x(), Vector3::y(), Vector3::z()]
            .iter()
            .flat_map(|e| [*e, -e])
        {
            let local = CENTRE_M + end * arm;
            let p = here.point(&local);
            let off = (p - there.point(&local)) / (SHIFT_M * self.looseness);
            energy += off.norm_squared() / 6.0;
            tied[0].add(&p, &(off * (2.0 / 6.0 / (SHIFT_M * self.looseness))));
        }
        let mut more = vec![0.0; gradient.len()];
        let none = vec![0.0; self.hand.joints.len()];
        self.hand
            .pull_back(&posed, &tied, &none, self.space.metric(), &mut more);
        for (slope, more) in gradient.iter_mut().zip(more) {
            *slope += more;
        }
        energy
    }
}
