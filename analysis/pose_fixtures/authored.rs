//! The authored part of a fixture: object, rough posture and placement, and contacts.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use landscape::hand::{Hand, PosedHand};
use landscape::object::{Capsule, Cuboid, Cylinder, Primitive, Sphere};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;

use crate::shape::points;

/// A type of grasp in some variants, or a pose outside the taxonomy.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Authored {
    #[serde(rename = "type", default)]
    pub(crate) kind: Option<u8>,
    #[serde(default)]
    pub(crate) name: Option<String>,
    pub(crate) depicts: String,
    #[serde(default)]
    pub(crate) pose: Rough,
    pub(crate) variants: Vec<Variant>,
}

/// One fixture of a type: the differences from the others.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Variant {
    /// Text added to the description of the type.
    pub(crate) with: String,
    #[serde(flatten)]
    pub(crate) pose: Rough,
}

/// A rough pose. Missing fields of a variant come from the type.
#[derive(Debug, Clone, Default, Deserialize)]
pub(crate) struct Rough {
    /// Joint angles of each digit in the order of the description, degrees.
    #[serde(default)]
    pub(crate) deg: BTreeMap<String, Vec<f64>>,
    /// Parts in a frame whose z axis is the long one.
    #[serde(default)]
    pub(crate) object: Option<Vec<Part>>,
    /// Origin of the object, hand frame, millimetres; added to `between`.
    #[serde(default)]
    pub(crate) at_mm: Option<[f64; 3]>,
    /// Regions around whose mean the object lies in the rough posture.
    #[serde(default)]
    pub(crate) between: Option<Vec<String>>,
    /// The object's z axis, hand frame.
    #[serde(default)]
    pub(crate) z: Option<[f64; 3]>,
    /// Direction near its x axis, hand frame.
    #[serde(default)]
    pub(crate) x: Option<[f64; 3]>,
    /// The x axis points from the first of these regions to the second.
    #[serde(default)]
    pub(crate) x_between: Option<[String; 2]>,
    /// Regions that touch.
    #[serde(default)]
    pub(crate) touch: Option<Vec<String>>,
    /// Regions that stay clear of the object.
    #[serde(default)]
    pub(crate) free: Option<Vec<String>>,
    /// Cost if the normal under the thumb and the mean of those under the fingers do not cancel.
    #[serde(default)]
    pub(crate) oppose: Option<f64>,
    /// Allowed motion of the object during closing, as a factor of 8 mm and 0.2 rad.
    #[serde(default)]
    pub(crate) loose: Option<f64>,
}

/// A solid with sizes in millimetres.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Part {
    /// Diameter and centre.
    Ball(f64, [f64; 3]),
    /// Diameter, length and centre, along z.
    Rod(f64, f64, [f64; 3]),
    /// Edges and centre.
    Box([f64; 3], [f64; 3]),
    /// Diameter and the ends of the axis.
    Pill(f64, [f64; 3], [f64; 3]),
    /// Diameter, thickness and centre, with the axis along x.
    Disc(f64, f64, [f64; 3]),
    /// Diameters of the middle line and of the tube, and centre; about x.
    Loop(f64, f64, [f64; 3]),
}

const MM: f64 = 1e-3;

impl Part {
    pub(crate) fn primitives(&self) -> Vec<Primitive> {
        let at = |p: &[f64; 3]| Vector3::from(*p) * MM;
        match self {
            Self::Ball(diameter, centre) => vec![Primitive::Sphere(Sphere {
                centre: at(centre),
                radius_m: 0.5 * diameter * MM,
            })],
            Self::Rod(diameter, length, centre) => vec![Primitive::Cylinder(Cylinder {
                centre: at(centre),
                axis: Vector3::z_axis(),
                radius_m: 0.5 * diameter * MM,
                half_height_m: 0.5 * length * MM,
                edge_radius_m: (0.2 * diameter.min(*length)).min(1.0) * MM,
            })],
            Self::Disc(diameter, thickness, centre) => vec![Primitive::Cylinder(Cylinder {
                centre: at(centre),
                axis: Vector3::x_axis(),
                radius_m: 0.5 * diameter * MM,
                half_height_m: 0.5 * thickness * MM,
                edge_radius_m: (0.2 * diameter.min(*thickness)).min(1.0) * MM,
            })],
            Self::Box(edges, centre) => vec![Primitive::Cuboid(Cuboid {
                centre: at(centre),
                half_extents: at(edges) * 0.5,
                edge_radius_m: (0.2 * edges.iter().copied().fold(f64::INFINITY, f64::min)).min(1.0)
                    * MM,
            })],
            Self::Pill(diameter, a, b) => vec![Primitive::Capsule(Capsule {
                a: at(a),
                b: at(b),
                radius_m: 0.5 * diameter * MM,
            })],
            Self::Loop(diameter, tube, centre) => {
                let corner = |k: u32| {
                    let angle = TAU * f64::from(k) / 12.0;
                    at(centre)
                        + Vector3::new(0.0, libm::cos(angle), libm::sin(angle))
                            * (0.5 * diameter * MM)
                };
                (0..12)
                    .map(|k| {
                        Primitive::Capsule(Capsule {
                            a: corner(k),
                            b: corner(k + 1),
                            radius_m: 0.5 * tube * MM,
                        })
                    })
                    .collect()
            }
        }
    }
}

impl Rough {
    /// This pose, with missing fields from `base`.
    pub(crate) fn over(&self, base: &Self) -> Self {
        let mut deg = base.deg.clone();
        deg.extend(self.deg.clone());
        let own = self.clone();
        Self {
            deg,
            object: own.object.or_else(|| base.object.clone()),
            at_mm: own.at_mm.or(base.at_mm),
            between: own.between.or_else(|| base.between.clone()),
            z: own.z.or(base.z),
            x: own.x.or(base.x),
            x_between: own.x_between.or_else(|| base.x_between.clone()),
            touch: own.touch.or_else(|| base.touch.clone()),
            free: own.free.or_else(|| base.free.clone()),
            oppose: own.oppose.or(base.oppose),
            loose: own.loose.or(base.loose),
        }
    }

    /// Joint angles, radians.
    pub(crate) fn joints(&self, hand: &Hand) -> Result<Vec<f64>, String> {
        let mut joints = hand.prior.rest.clone();
        for (digit, degrees) in &self.deg {
            let own: Vec<usize> = (0..hand.joints.len())
                .filter(|&j| hand.joints[j].name.starts_with(&format!("{digit}_")))
                .collect();
            if own.len() != degrees.len() {
                return Err(format!(
                    "{digit} has {} joints, not {}",
                    own.len(),
                    degrees.len()
                ));
            }
            for (j, angle) in own.into_iter().zip(degrees) {
                joints[j] = angle.to_radians();
            }
        }
        Ok(joints)
    }

    /// Pose of the object in the hand's frame before closing.
    pub(crate) fn hand_from_object(&self, hand: &Hand) -> Result<Isometry3<f64>, String> {
        let joints = self.joints(hand)?;
        let mut coordinates = vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        coordinates.extend(&joints);
        let mut posed = PosedHand::default();
        hand.pose(&coordinates, &mut posed);
        let middle = |region: &str| {
            let own: Vec<Vector3<f64>> = points(hand, region)
                .into_iter()
                .map(|i| posed.points[i])
                .collect();
            if own.is_empty() {
                return Err(format!("no region starts with {region}"));
            }
            Ok(own.iter().sum::<Vector3<f64>>() / own.len() as f64)
        };
        let mut origin = Vector3::from(self.at_mm.unwrap_or_default()) * MM;
        if let Some(regions) = &self.between {
            for region in regions {
                origin += middle(region)? / regions.len() as f64;
            }
        }
        let z = Vector3::from(self.z.unwrap_or([0.0, 0.0, 1.0])).normalize();
        let x = match (&self.x_between, self.x) {
            (Some([from, to]), _) => middle(to)? - middle(from)?,
            (None, Some(x)) => Vector3::from(x),
            (None, None) => Vector3::ith(z.iamin(), 1.0),
        };
        // If regions give the x axis, it is kept and z is rotated; otherwise the reverse.
        let (x, z) = if self.x_between.is_some() {
            let x = x.normalize();
            (x, (z - x * x.dot(&z)).normalize())
        } else {
            ((x - z * z.dot(&x)).normalize(), z)
        };
        let rotation = Matrix3::from_columns(&[x, z.cross(&x), z]);
        Ok(Isometry3::from_parts(
            Translation3::from(origin),
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)),
        ))
    }
}
