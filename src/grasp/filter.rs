//! Filters that decide whether a pose is a grasp: the published one and a strict one, measured on the exact mesh.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::Grasp;
use super::closure::{
    EpsilonSettings, PointContact, epsilon, is_force_closure, least_friction, net_wrench,
};
use super::depth::{deepest_m, is_deeper};
use super::energy::{AUTHORS_UNIT_M, GraspEnergy};
use super::failure::in_one_concavity;
use super::layer::Layer;
use super::term::{Proximity, Scene, for_each_overlap};
use crate::hand::{Hand, LinkId, PosedHand};
use crate::object::Object;

/// Friction coefficient of the force-closure test in the strict filter.
pub const STRICT_FRICTION: f64 = 0.5;

/// Depth that the strict filter refuses, metres. Closed hands press on purpose, by less than a millimetre where the skin has
/// room to yield.
const MOST_PRESSING_M: f64 = 0.001;
/// Greatest distance of a contact from the mesh, either way, metres.
pub const MOST_GAP_M: f64 = 0.002;

/// Quantities that the filters test. Contact distances, normals and depths are those of the exact mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// ‖Gc‖ with arms divided by the unit of the energy.
    pub net_wrench: f64,
    /// Σ d² of the contacts, in the authors' unit of 120 mm.
    pub distance_squared: f64,
    /// Sum of the depths of the hand's surface points inside the object, in the authors' unit.
    pub penetration: f64,
    /// Largest distance of a contact from the surface, metres.
    pub gap_m: f64,
    /// Greatest depth of a point of the exported hand in the object, or of the object in the hand, metres ([`deepest_m`]).
    pub deepest_m: f64,
    /// Greatest overlap of the hand's capsules, metres. They do not fill all corners of meshes and boxes.
    pub self_penetration_m: f64,
    /// Largest excess of a joint over its limits, radians; metres for sliding joints.
    pub joint_excess: f64,
    /// Number of digits (palm, thumb and fingers) with contacts.
    pub digits: usize,
    /// Whether all contacts lie in one concavity ([`in_one_concavity`]) and push apart instead of together.
    pub one_concavity: bool,
    /// Least friction at which the contact forces balance; `None` if none suffices.
    pub least_friction: Option<f64>,
    /// Exact force closure at [`STRICT_FRICTION`].
    pub force_closure: bool,
    /// Ferrari–Canny ε at [`STRICT_FRICTION`]; not positive if some wrench cannot be resisted.
    pub epsilon: f64,
    /// Mean compliance of the elastic layer, from 0 to 1; `None` if there is none.
    #[serde(default)]
    pub compliance: Option<f64>,
    /// Whether the layer gives little enough under single loads
    /// ([`LayerSettings::holds`](super::layer::LayerSettings::holds)); `None` if there is none.
    #[serde(default)]
    pub withstands_loads: Option<bool>,
}

impl Judgement {
    /// Eq. 11 of Liu et al. (2021) as printed: ‖Gc‖ < 0.5, Σ d² < 0.02, E_pen < 0.02.
    pub fn passes_published(&self) -> bool {
        self.net_wrench < 0.5 && self.distance_squared < 0.02 && self.penetration < 0.02
    }

    /// Eq. 11 as the authors' code computes it: the *square* of ‖Gc‖ and ten times the penetration.
    pub fn passes_released(&self) -> bool {
        self.net_wrench.powi(2) < 0.5
            && self.distance_squared < 0.02
            && 10.0 * self.penetration < 0.02
    }

    /// The first condition of the strict filter that fails; `None` if the grasp passes.
    pub fn strict_objection(&self) -> Option<&'static str> {
        let checks = [
            (self.gap_m <= MOST_GAP_M, "a contact too far off"),
            (self.deepest_m < MOST_PRESSING_M, "too deep in the object"),
            (self.self_penetration_m < 0.003, "too deep in itself"),
            (self.joint_excess <= 1e-3, "beyond joint limits"),
            (self.digits >= 2, "one digit only"),
            (!self.one_concavity, "contacts in one concavity"),
            (self.force_closure, "no force closure"),
            (
                self.withstands_loads != Some(false),
                "gives way under loads",
            ),
        ];
        checks
            .into_iter()
            .find_map(|(passes, reason)| (!passes).then_some(reason))
    }

    /// The strict filter: contacts within 2 mm, nothing deeper than 1 mm, self-penetration below 3 mm, joint limits, at least
    /// two digits (of palm, thumb and fingers), contacts not in one concavity, force closure at μ = 0.5, and an elastic layer
    /// that gives little under single loads.
    pub fn passes_strict(&self) -> bool {
        self.strict_objection().is_none()
    }
}

/// A contact measured on the exact mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredContact {
    /// Index of the hand's surface point.
    pub surface_point: u32,
    /// The link of the point.
    pub link: LinkId,
    /// Signed distance from the mesh, metres; negative inside.
    pub distance_m: f64,
    /// Arm from the object's centroid, divided by the energy's unit, and inward normal of the mesh.
    pub contact: PointContact,
}

/// The contacts of a grasp on the exact mesh.
///
/// # Panics
/// If the grasp belongs to another hand.
pub fn measure_contacts(energy: &GraspEnergy, grasp: &Grasp) -> Vec<MeasuredContact> {
    Scale::of(energy).measure(grasp)
}

/// A hand, an object, and the length unit of arms and depths.
#[derive(Clone, Copy)]
pub(super) struct Scale<'a> {
    pub(super) hand: &'a Hand,
    pub(super) object: &'a Object,
    pub(super) unit_m: f64,
}

impl<'a> Scale<'a> {
    fn of(energy: &'a GraspEnergy) -> Self {
        Self {
            hand: energy.hand(),
            object: energy.object(),
            unit_m: energy.unit_m(),
        }
    }

    fn posed(self, grasp: &Grasp) -> PosedHand {
        let mut posed = PosedHand::default();
        self.hand.pose(&grasp.pose, &mut posed);
        posed
    }

    pub(super) fn measure(self, grasp: &Grasp) -> Vec<MeasuredContact> {
        self.measure_posed(&self.posed(grasp), &grasp.contacts)
    }

    fn measure_posed(self, posed: &PosedHand, contacts: &[u32]) -> Vec<MeasuredContact> {
        let measure = |&index: &u32| {
            let point = posed.points[index as usize];
            let nearest = self.object.exact.nearest(&point);
            MeasuredContact {
                surface_point: index,
                link: self.hand.surface[index as usize].link,
                distance_m: nearest.distance_m,
                contact: PointContact {
                    arm: (point - self.object.centroid) / self.unit_m,
                    inward_normal: -nearest.normal,
                },
            }
        };
        contacts.iter().map(measure).collect()
    }

    /// A judgement without the elastic layer.
    pub(super) fn judge(self, grasp: &Grasp) -> Judgement {
        let posed = self.posed(grasp);
        Judgement {
            deepest_m: deepest_m(&self.object.exact, self.hand, &posed),
            ..self.judge_but_depth(grasp, &posed)
        }
    }

    /// A judgement with a depth of zero, without the elastic layer.
    fn judge_but_depth(self, grasp: &Grasp, posed: &PosedHand) -> Judgement {
        let Self { hand, object, .. } = self;
        let mut proximity = Proximity::default();
        proximity.update_pairs(hand, posed);
        let scene = Scene {
            hand,
            posed,
            joints: grasp.pose.joints(),
            object,
            proximity: &proximity,
            layer: &Layer::default(),
            near_spheres: &[],
            unit_m: self.unit_m,
        };

        let measured = self.measure_posed(posed, &grasp.contacts);
        let point_contacts: Vec<PointContact> = measured.iter().map(|m| m.contact).collect();
        let distances_m = || measured.iter().map(|m| m.distance_m);
        let mut digits: Vec<usize> = measured
            .iter()
            .map(|m| hand.links[m.link.0].digit)
            .collect();
        digits.sort_unstable();
        digits.dedup();

        let on_mesh: Vec<Vector3<f64>> = measured
            .iter()
            .map(|m| {
                object
                    .exact
                    .nearest(&posed.points[m.surface_point as usize])
                    .point
            })
            .collect();

        let mut penetration = 0.0;
        let lipschitz = object.shape.lipschitz();
        for point in &posed.points {
            // The smooth shape shows where the slow exact distance is needed.
            if object.shape.distance(point) > 0.003 * lipschitz {
                continue;
            }
            let depth = -object.exact.distance(point);
            if depth > 0.0 {
                penetration += depth / AUTHORS_UNIT_M;
            }
        }
        let mut self_penetration_m = 0.0f64;
        for_each_overlap(&scene, |depth| {
            self_penetration_m = self_penetration_m.max(depth);
        });
        let joint_excess =
            hand.joints
                .iter()
                .zip(grasp.pose.joints())
                .fold(0.0f64, |worst, (joint, &q)| {
                    let [lower, upper] = joint.limits;
                    worst.max(q - upper).max(lower - q)
                });
        let least = least_friction(&point_contacts);
        let epsilon_settings = EpsilonSettings {
            friction: STRICT_FRICTION,
            ..EpsilonSettings::default()
        };
        Judgement {
            net_wrench: net_wrench(&point_contacts),
            distance_squared: distances_m().map(|d| (d / AUTHORS_UNIT_M).powi(2)).sum(),
            penetration,
            gap_m: distances_m().map(f64::abs).fold(0.0, f64::max),
            deepest_m: 0.0,
            self_penetration_m,
            joint_excess,
            digits: digits.len(),
            one_concavity: in_one_concavity(&object.exact, &on_mesh),
            least_friction: least.is_finite().then_some(least),
            force_closure: is_force_closure(&point_contacts, STRICT_FRICTION),
            epsilon: epsilon(&point_contacts, &epsilon_settings).value,
            compliance: None,
            withstands_loads: None,
        }
    }
}

/// Judges a grasp on the exact mesh.
///
/// # Panics
/// If the grasp belongs to another hand.
pub fn judge(energy: &GraspEnergy, grasp: &Grasp) -> Judgement {
    with_layer(energy, grasp, Scale::of(energy).judge(grasp))
}

/// Whether a grasp passes the strict filter: [`Judgement::passes_strict`] of [`judge`]. Depths are the dearest part of a
/// judgement, so they come last, and only depths that matter are sought.
///
/// # Panics
/// If the grasp belongs to another hand.
pub(crate) fn passes_strict(energy: &GraspEnergy, grasp: &Grasp) -> bool {
    let scale = Scale::of(energy);
    let posed = scale.posed(grasp);
    let judgement = with_layer(energy, grasp, scale.judge_but_depth(grasp, &posed));
    judgement.passes_strict()
        && !is_deeper(&scale.object.exact, scale.hand, &posed, MOST_PRESSING_M)
}

/// The judgement with what the elastic layer says.
fn with_layer(energy: &GraspEnergy, grasp: &Grasp, mut judgement: Judgement) -> Judgement {
    judgement.compliance = Some(energy.compliance(&grasp.pose));
    judgement.withstands_loads = Some(energy.withstands_loads(&grasp.pose));
    judgement
}
