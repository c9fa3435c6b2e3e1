//! Compliance of the hand's elastic layer.

use nalgebra::Vector3;

use super::{Forces, Scene, Stage, Term};
use crate::grasp::layer::{
    ComplianceSettings, LayerSettings, LoadCompliance, Node, load_compliance, mean_compliance, step,
};

/// Range of the cosine between the palmar side and the direction of the contact over which a sphere begins to carry.
const PALMAR: [f64; 2] = [-0.5, 0.3];
/// Range over which the length of a normal decides how much its sphere or node carries. Only lengths below the upper end
/// matter. They are found where skin feels two sides of a wall, a slot or a sharp edge at once.
const DIRECTED: [f64; 2] = [0.25, 0.5];
/// Nodes with less weight carry nothing: the squares of smaller lengths underflow.
const LEAST_WEIGHT: f64 = 1e-140;
/// Force of the test loads. It only defines the unit of length: what it presses 5 mm of a finger.
const LOAD: f64 = 1.0;
/// Rounding of the friction cones in that unit: it keeps the second derivatives finite at their edges.
const FRICTION_ROUNDING: f64 = 0.02;
/// How far a test load moves an object that nothing holds, in that unit: far more than one that is held.
const FREE_MOTION: f64 = 100.0;
/// Rounding of the square root of the compliance, as a fraction of the compliance without contacts.
const ROUNDING: f64 = 0.01;

/// How much the elastic layer of the hand gives under test loads on the object: w for a hand that has let go, about 0 for
/// one that holds in all directions.
///
/// ```text
/// E = w mean_compliance(nodes),   W = Σ_s h_s w_s,   a = Σ h_s w_s a_s / W,   n = Σ h_s w_s n_s / |Σ h_s w_s n_s|
/// w_s = share_s · S(−n·volar) · S(gap) · S(|∇d|),   stiffness of a node = W · S(|Σ h w n| / W)
/// ```
///
/// Spheres s carry with their area, their gap and their side; nodes average them with hat functions h. This average is our
/// own; [`layer`](crate::grasp::layer) and [`mean_compliance`] name what they rest on.
///
/// Derivatives of normals have |∇d|, the slope of the object's field d, and |Σ h w n| as divisors. Both can vanish where skin
/// feels two sides of a wall, a slot or a sharp edge at once, whose normals cancel. The last two steps S let such skin carry
/// less, and nothing before there is no normal: they are 1 from 0.5 on and 0 up to 0.25. So the gradient is Lipschitz
/// continuous wherever the second derivatives of d are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerCompliance {
    /// Settings of the layer.
    pub settings: LayerSettings,
}

/// A sphere that carries.
struct Carrier<'a> {
    near: &'a crate::grasp::layer::NearSphere,
    weight: f64,
    /// Derivatives of the weight by the gap, by the cosine and by the length of the gradient.
    by_gap: f64,
    by_cosine: f64,
    by_length: f64,
    inward: Vector3<f64>,
    arm: Vector3<f64>,
    volar: Vector3<f64>,
}

/// The sums over the spheres of a node, or the derivatives of the compliance by these.
#[derive(Clone, Default)]
struct Sums {
    weight: f64,
    /// Weighted arm and weighted inward normal.
    arm: Vector3<f64>,
    normal: Vector3<f64>,
}

/// A node that carries, its sums, and how much of it the length of its normal lets carry.
struct Place {
    node: usize,
    weight: f64,
    length: f64,
    directed: f64,
    directed_slope: f64,
}

impl LayerCompliance {
    /// How much the layer gives under single loads.
    pub(crate) fn under_loads(&self, scene: &Scene<'_>) -> LoadCompliance {
        let (_, nodes) = nodes(scene, &self.carriers(scene));
        let axes = scene.posed.object_from_link[0].rotation;
        load_compliance(&nodes, &axes, &self.loads())
    }

    fn loads(&self) -> ComplianceSettings {
        ComplianceSettings {
            friction: self.settings.friction,
            friction_rounding: FRICTION_ROUNDING,
            load: LOAD,
            torque_share: self.settings.torque_share,
            free_motion: FREE_MOTION,
            rounding: ROUNDING,
        }
    }

    fn carriers<'a>(&self, scene: &Scene<'a>) -> Vec<Carrier<'a>> {
        let layer = scene.layer;
        let mut carriers = Vec::new();
        for near in scene.near_spheres {
            let sphere = &layer.spheres[near.sphere as usize];
            let length = near.gradient.norm();
            let (directed, directed_slope) = step(length, DIRECTED);
            if !sphere.may_touch || directed == 0.0 {
                continue;
            }
            let (carries, carries_slope) = self.settings.carries(near.gap_m);
            if carries == 0.0 {
                continue;
            }
            let inward = -near.gradient / length;
            let volar = scene.posed.object_from_link[sphere.link.0].direction(&sphere.volar);
            let (side, side_slope) = if sphere.volar == Vector3::zeros() {
                (1.0, 0.0)
            } else {
                step(inward.dot(&volar), PALMAR)
            };
            if side == 0.0 {
                continue;
            }
            let contact = near.centre + inward * sphere.radius_m;
            carriers.push(Carrier {
                near,
                weight: sphere.share * side * carries * directed,
                by_gap: sphere.share * side * carries_slope * directed,
                by_cosine: sphere.share * side_slope * carries * directed,
                by_length: sphere.share * side * carries * directed_slope,
                inward,
                arm: (contact - scene.object.centroid) / scene.unit_m,
                volar,
            });
        }
        carriers
    }
}

/// The nodes that carry.
fn nodes(scene: &Scene<'_>, carriers: &[Carrier<'_>]) -> (Vec<Place>, Vec<Node>) {
    let layer = scene.layer;
    let mut sums = vec![Sums::default(); layer.nodes];
    for carrier in carriers {
        for &(node, hat) in &layer.spheres[carrier.near.sphere as usize].nodes {
            let sum = &mut sums[node as usize];
            let weight = hat * carrier.weight;
            sum.weight += weight;
            sum.arm += carrier.arm * weight;
            sum.normal += carrier.inward * weight;
        }
    }
    let mut places = Vec::new();
    let mut nodes = Vec::new();
    for (k, sum) in sums.iter().enumerate() {
        if sum.weight <= LEAST_WEIGHT {
            continue;
        }
        let length = sum.normal.norm();
        let (directed, directed_slope) = step(length / sum.weight, DIRECTED);
        if directed > 0.0 {
            places.push(Place {
                node: k,
                weight: sum.weight,
                length,
                directed,
                directed_slope,
            });
            nodes.push(Node {
                stiffness: sum.weight * directed,
                arm: sum.arm / sum.weight,
                inward_normal: sum.normal / length,
            });
        }
    }
    (places, nodes)
}

impl Term for LayerCompliance {
    fn name(&self) -> &'static str {
        "compliance"
    }

    fn weight(&self) -> f64 {
        self.settings.compliance_weight
    }

    fn stage(&self) -> Stage {
        Stage::Depths
    }

    fn add(&self, scene: &Scene<'_>, forces: &mut Forces) -> f64 {
        let layer = scene.layer;
        let carriers = self.carriers(scene);
        let (places, nodes) = nodes(scene, &carriers);
        let settings = self.loads();
        let axes = scene.posed.object_from_link[0].rotation;
        let found = mean_compliance(&nodes, &axes, &settings);
        let scale = self.weight();
        // Derivatives of the compliance by the sums of each node.
        let mut by_sums = vec![Sums::default(); layer.nodes];
        for (k, place) in places.iter().enumerate() {
            let at = &nodes[k];
            let n = &at.inward_normal;
            let arm = found.by_arm[k] / place.weight;
            let across = found.by_normal[k] - n * n.dot(&found.by_normal[k]);
            // The stiffness W S(l/W) changes by (S − S' l/W) dW + S' dl.
            let by_length = found.by_stiffness[k] * place.directed_slope;
            let by_weight = found.by_stiffness[k] * place.directed;
            by_sums[place.node] = Sums {
                weight: by_weight - by_length * place.length / place.weight - arm.dot(&at.arm),
                arm,
                normal: across / place.length + n * by_length,
            };
        }
        for carrier in &carriers {
            let sphere = &layer.spheres[carrier.near.sphere as usize];
            let mut by_weight = 0.0;
            let mut by_arm = Vector3::zeros();
            let mut by_inward = Vector3::zeros();
            for &(node, hat) in &sphere.nodes {
                let by_sum = &by_sums[node as usize];
                by_weight += hat * by_sum.weight;
                by_arm += by_sum.arm * hat;
                by_inward += by_sum.normal * hat;
            }
            by_weight += by_arm.dot(&carrier.arm) + by_inward.dot(&carrier.inward);
            by_arm *= carrier.weight;
            by_inward *= carrier.weight;
            let near = carrier.near;
            let length = near.gradient.norm();
            let by_cosine = by_weight * carrier.by_cosine;
            by_inward += by_arm * (sphere.radius_m / scene.unit_m) + carrier.volar * by_cosine;
            // The inward normal is −g/|g|, so its derivative is −(I − nnᵀ) H/|g|.
            let across = by_inward - carrier.inward * carrier.inward.dot(&by_inward);
            let along = carrier.inward * (by_weight * carrier.by_length);
            let force = near.gradient * (by_weight * carrier.by_gap) + by_arm / scene.unit_m
                - near.hessian * (across / length + along);
            forces.push(sphere.link, &near.centre, &(force * scale));
            let turn = carrier.volar.cross(&carrier.inward) * (by_cosine * scale);
            forces.wrenches[sphere.link.0].moment += turn;
        }
        forces.wrenches[0].moment += found.by_rotation * scale;
        scale * found.value
    }
}
