//! Builds a hand from MANO's arrays.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Vector3};

use super::super::blend::{Blend, BlendVertex};
use super::super::capsule_decomposition::capsules_in;
use super::super::hull::Hull;
use super::super::model::{subtree_ends, within};
use super::super::side_file::{SideFile, untouching};
use super::super::solid::Parts;
use super::super::{
    Capsule, Frame, Hand, HandError, Joint, JointKind, Link, LinkId, PalmFrame, PosePrior,
    PosedHand, SurfacePoint, region, self_pairs,
};
use super::{ANGLES, Arrays, LINKS, PARENTS};
use crate::limits::{HAND_POSITION, HAND_SHAPE, HINGE, MANO_NUMBER};
use crate::space::vector::product;

/// Names of the links in the order of the file, and the digit of each link (1 = thumb … 5 = little finger).
const NAMES: [(&str, usize); LINKS] = [
    ("palm", 0),
    ("index_proximal", 2),
    ("index_middle", 2),
    ("index_distal", 2),
    ("middle_proximal", 3),
    ("middle_middle", 3),
    ("middle_distal", 3),
    ("little_proximal", 5),
    ("little_middle", 5),
    ("little_distal", 5),
    ("ring_proximal", 4),
    ("ring_middle", 4),
    ("ring_distal", 4),
    ("thumb_metacarpal", 1),
    ("thumb_proximal", 1),
    ("thumb_distal", 1),
];
const DIGITS: [&str; 6] = ["palm", "thumb", "index", "middle", "ring", "little"];
/// Margin of the limits beyond the range of the file's own poses, as a share of that range.
const BEYOND: f64 = 0.1;
/// Least half range of a coordinate, radians.
const LEAST_HALF_RANGE: f64 = 0.05;
/// Least standard deviation of a component, radians.
const LEAST_DEVIATION: f64 = 1e-3;
/// Distance from the palm's centre to the point that faces the object at the start, as a share of the fingers' length.
const FACED: f64 = 0.4;

/// Builds the hand. Its coordinates are the 45 angles, or the weights of as many principal components as the side file
/// says.
///
/// MANO has no limits: each limit is an extreme of the file's own poses plus a tenth of their range. The prior is the
/// squared length of the weights of the principal components, each in units of its standard deviation over those poses.
pub(in super::super) fn assemble(arrays: &Arrays, side: &SideFile) -> Result<Hand, HandError> {
    let error = |problem: String| HandError::Mano {
        file: arrays.file.clone(),
        problem,
    };
    if let Some(entry) = foreign(side) {
        return Err(error(format!(
            "cannot have the entry \"{entry}\" in its side file"
        )));
    }
    let shaped = shaped(arrays, &side.mano.betas).map_err(error)?;
    let points = DMatrix::from_fn(shaped.len(), 3, |v, axis| shaped[v][axis]);
    let joints = &arrays.regressor * points;
    let origin = |l: usize| Vector3::new(joints[(l, 0)], joints[(l, 1)], joints[(l, 2)]);
    let mut origins: Vec<Vector3<f64>> = (0..LINKS).map(origin).collect();
    for place in shaped.iter().chain(&origins).flatten() {
        within(HAND_POSITION, *place, || {
            format!("a vertex or joint of {}", arrays.file)
        })?;
    }
    // The root's frame is that of the file: the hand may lie anywhere, so the place of the wrist joint does not matter.
    origins[0] = Vector3::zeros();
    let links = links(&origins);
    let (surface, vertices, triangles) = surface(arrays, &shaped, &origins);
    let capsules =
        capsules(&surface).ok_or_else(|| error("has no link with a volume".to_owned()))?;

    let whole = Coordinates::whole(arrays).map_err(error)?;
    let blend = |coordinates: &Coordinates| {
        Arc::new(Blend {
            offset_rad: coordinates.offset_rad.clone(),
            map: coordinates.map.clone(),
            vertices: vertices.clone(),
            triangles: triangles.clone(),
        })
    };
    let mut hand = Hand {
        name: side.name.clone().unwrap_or_else(|| "mano".to_owned()),
        subtree_ends: subtree_ends(&links),
        link_points: vec![0..0; links.len()],
        untouching: untouching(&links, side)?,
        palm_link: LinkId(0),
        joints: whole.joints(),
        cast: whole.prior.rest.clone(),
        prior: whole.prior.clone(),
        exact: vec![false; capsules.len()],
        capsules,
        self_pairs: Vec::new(),
        surface,
        digits: DIGITS.map(str::to_owned).to_vec(),
        regions: links.iter().map(|link| link.name.clone()).collect(),
        palm: PalmFrame {
            centre: Vector3::zeros(),
            volar: Vector3::z(),
            distal: Vector3::y(),
            faced_m: 0.0,
        },
        notes: Vec::new(),
        virtual_wrist: None,
        meshes: Vec::new(),
        parts: Parts::default(),
        inscribed: super::super::inscribed::Cache::default(),
        metric: side.metric.clone(),
        blend: Some(blend(&whole)),
        links,
    };
    hand.index_surface();
    hand.palm = match &side.palm {
        Some(palm) => region::palm_frame(palm)?,
        None => palm(&hand),
    };
    if let Some(count) = side.mano.components {
        let chosen = Coordinates::components(arrays, count).map_err(error)?;
        hand.blend = Some(blend(&chosen));
        hand.joints = chosen.joints();
        hand.cast.clone_from(&chosen.prior.rest);
        hand.prior = chosen.prior;
    }
    let mut rest = PosedHand::default();
    hand.pose(&hand.rest_coordinates(), &mut rest);
    let apart = self_pairs::apart(&hand, &super::super::model::Model::default(), side)?;
    hand.self_pairs = self_pairs::derive(&hand, &rest, &apart);
    hand.check_metric()?;
    Ok(hand)
}

/// An entry of the side file that has no meaning for a MANO hand.
fn foreign(side: &SideFile) -> Option<&'static str> {
    [
        ("without", !side.without.is_empty()),
        ("surface_points", side.surface_points.is_some()),
        ("digits", side.digits.is_some()),
        ("axes", side.axes.is_some()),
        ("palm_regions", !side.palm_regions.is_empty()),
        ("capsules", !side.capsules.is_empty()),
        ("filling", !side.filling.is_empty()),
        ("rest_deg", !side.rest_deg.is_empty()),
        ("rest_mm", !side.rest_mm.is_empty()),
        ("cast_deg", !side.cast_deg.is_empty()),
        ("deviation_deg", !side.deviation_deg.is_empty()),
        ("deviation_mm", !side.deviation_mm.is_empty()),
        ("synergies", !side.synergies.is_empty()),
        ("independent_share", side.independent_share.is_some()),
    ]
    .into_iter()
    .find_map(|(entry, given)| given.then_some(entry))
}

/// The template deformed by the shape weights.
fn shaped(arrays: &Arrays, betas: &[f64]) -> Result<Vec<Vector3<f64>>, String> {
    let known = arrays.shape_directions.first().map_or(0, DMatrix::ncols);
    if betas.len() > known {
        return Err(format!(
            "has {known} shapes, so \"betas\" of the side file must be at most {known} numbers"
        ));
    }
    let mut weights = betas.iter();
    weights
        .try_for_each(|beta| HAND_SHAPE.check(*beta))
        .map_err(|beyond| {
            format!("has a number out of range in \"betas\" of its side file: {beyond}")
        })?;
    let of_vertex = arrays.template.iter().zip(&arrays.shape_directions);
    Ok(of_vertex
        .map(|(vertex, directions)| {
            let shares = betas.iter().enumerate();
            vertex
                + shares
                    .map(|(b, beta)| directions.fixed_view::<3, 1>(0, b) * *beta)
                    .sum::<Vector3<f64>>()
        })
        .collect())
}

/// One link per joint; the frames are not rotated at rest.
fn links(origins: &[Vector3<f64>]) -> Vec<Link> {
    let link = |l: usize| {
        let parent = l.checked_sub(1).map(|ball| PARENTS[ball]);
        Link {
            name: NAMES[l].0.to_owned(),
            parent: parent.map(LinkId),
            parent_from_link: Frame {
                translation: parent.map_or(origins[l], |parent| origins[l] - origins[parent]),
                ..Frame::default()
            },
            motion: None,
            joint_name: String::new(),
            ball: l.checked_sub(1),
            digit: NAMES[l].1,
        }
    };
    (0..LINKS).map(link).collect()
}

/// All vertices, sorted by the link with the largest weight.
fn surface(
    arrays: &Arrays,
    shaped: &[Vector3<f64>],
    origins: &[Vector3<f64>],
) -> (Vec<SurfacePoint>, Vec<BlendVertex>, Vec<[u32; 3]>) {
    let mut doubled = vec![Vector3::zeros(); shaped.len()];
    let mut areas = vec![0.0; shaped.len()];
    for triangle in &arrays.triangles {
        let [a, b, c] = triangle.map(|v| shaped[v as usize]);
        let normal = (b - a).cross(&(c - a));
        for &v in triangle {
            doubled[v as usize] += normal;
            areas[v as usize] += normal.norm() / 6.0;
        }
    }
    let strongest = |v: usize| {
        arrays
            .weights
            .row(v)
            .iter()
            .copied()
            .enumerate()
            .fold(
                (0, 0.0),
                |best, (l, weight)| {
                    if weight > best.1 { (l, weight) } else { best }
                },
            )
            .0
    };
    let mut order: Vec<usize> = (0..shaped.len()).collect();
    order.sort_by_key(|&v| strongest(v));
    let mut place = vec![0u32; shaped.len()];
    for (&v, new) in order.iter().zip(0..) {
        place[v] = new;
    }
    let normal = |v: usize| doubled[v].try_normalize(1e-15).unwrap_or_else(Vector3::z);
    let points = order.iter().map(|&v| {
        let link = strongest(v);
        SurfacePoint {
            link: LinkId(link),
            point: shaped[v] - origins[link],
            normal: normal(v),
            area_m2: areas[v],
            region: link,
        }
    });
    let vertices = order.iter().map(|&v| BlendVertex {
        bindings: (arrays.weights.row(v).iter().enumerate())
            .filter(|(_, weight)| **weight > 0.0)
            .map(|(l, weight)| (LinkId(l), shaped[v] - origins[l], *weight))
            .collect(),
        normal: normal(v),
        corrections: arrays.pose_directions[v].transpose().as_slice().to_vec(),
    });
    let triangles = arrays
        .triangles
        .iter()
        .map(|t| t.map(|v| place[v as usize]));
    (points.collect(), vertices.collect(), triangles.collect())
}

/// Capsules inside the hull of the points of each link.
fn capsules(surface: &[SurfacePoint]) -> Option<Vec<Capsule>> {
    let of_link = |l: usize| {
        let own = surface.iter().filter(move |point| point.link.0 == l);
        let points: Vec<Vector3<f64>> = own.map(|point| point.point).collect();
        Hull::of(LinkId(l), &points)
            .map(|hull| capsules_in(&hull))
            .unwrap_or_default()
    };
    let capsules: Vec<Capsule> = (0..LINKS).flat_map(of_link).collect();
    (!capsules.is_empty()).then_some(capsules)
}

/// The choice of coordinates q with θ = offset + map q, their limits and their prior.
struct Coordinates {
    offset_rad: DVector<f64>,
    map: DMatrix<f64>,
    names: Vec<String>,
    limits: Vec<[f64; 2]>,
    prior: PosePrior,
}

impl Coordinates {
    /// The 45 angles as coordinates.
    fn whole(arrays: &Arrays) -> Result<Self, String> {
        // θ = mean + Cᵀ c, so c = C⁻ᵀ (θ − mean).
        let inverse = (arrays.components.transpose().try_inverse())
            .filter(|inverse| inverse.iter().all(|entry| MANO_NUMBER.holds(*entry)))
            .ok_or("has components (`hands_components`) that do not span all poses")?;
        let deviations = deviations(arrays);
        let precision = DMatrix::from_diagonal(&deviations.map(|deviation| deviation.powi(-2)));
        let precision = product(&product(&inverse.transpose(), &precision), &inverse);
        let precision = (&precision + precision.transpose()) / 2.0;
        let variances = DMatrix::from_diagonal(&deviations.map(|deviation| deviation * deviation));
        let covariance = product(
            &product(&arrays.components.transpose(), &variances),
            &arrays.components,
        );
        let poses = product(&arrays.coefficients, &arrays.components);
        let names =
            (1..LINKS).flat_map(|l| ["x", "y", "z"].map(|axis| format!("{}_{axis}", NAMES[l].0)));
        Ok(Self {
            offset_rad: DVector::zeros(ANGLES),
            map: DMatrix::identity(ANGLES, ANGLES),
            names: names.collect(),
            limits: limits(&poses, &arrays.mean_rad)?,
            prior: PosePrior {
                rest: arrays.mean_rad.as_slice().to_vec(),
                precision: precision.as_slice().to_vec(),
                deviations: covariance.diagonal().map(f64::sqrt).as_slice().to_vec(),
            },
        })
    }

    /// The weights of the first `count` principal components as coordinates.
    fn components(arrays: &Arrays, count: usize) -> Result<Self, String> {
        if !(1..=ANGLES).contains(&count) {
            return Err(format!(
                "can have 1 to {ANGLES} \"components\", not {count}"
            ));
        }
        let deviations = deviations(arrays).rows(0, count).into_owned();
        let precision = DMatrix::from_diagonal(&deviations.map(|deviation| deviation.powi(-2)));
        let coefficients = arrays.coefficients.columns(0, count).into_owned();
        Ok(Self {
            offset_rad: arrays.mean_rad.clone(),
            map: arrays.components.rows(0, count).transpose(),
            names: (1..=count).map(|n| format!("component_{n}")).collect(),
            limits: limits(&coefficients, &DVector::zeros(count))?,
            prior: PosePrior {
                rest: vec![0.0; count],
                precision: precision.as_slice().to_vec(),
                deviations: deviations.as_slice().to_vec(),
            },
        })
    }

    fn joints(&self) -> Vec<Joint> {
        let named = self.names.iter().zip(&self.limits).enumerate();
        named
            .map(|(j, (name, limits))| Joint {
                name: name.clone(),
                // A component moves all links; the first link represents them.
                link: LinkId(
                    if self.names.len() == ANGLES && self.offset_rad.amax() == 0.0 {
                        1 + j / 3
                    } else {
                        1
                    },
                ),
                kind: JointKind::Hinge,
                limits: *limits,
                wraps: false,
            })
            .collect()
    }
}

/// Standard deviations of the components over the file's poses, whose mean is zero.
fn deviations(arrays: &Arrays) -> DVector<f64> {
    let count = arrays.coefficients.nrows().max(1) as f64;
    DVector::from_fn(ANGLES, |c, _| {
        let square = arrays.coefficients.column(c).norm_squared() / count;
        square.sqrt().max(LEAST_DEVIATION)
    })
}

/// Limits about `middle`: the extremes over the poses (rows) plus a margin.
fn limits(poses: &DMatrix<f64>, middle: &DVector<f64>) -> Result<Vec<[f64; 2]>, String> {
    let of_coordinate = |c: usize| {
        let values = poses.column(c);
        let (lower, upper) = values
            .iter()
            .fold((0.0f64, 0.0f64), |(lower, upper), value| {
                (lower.min(*value), upper.max(*value))
            });
        let beyond = (BEYOND * (upper - lower)).max(LEAST_HALF_RANGE);
        let limits = [middle[c] + lower - beyond, middle[c] + upper + beyond];
        (limits.iter().try_for_each(|limit| HINGE.check(*limit))).map_err(|beyond| {
            format!("has poses (`hands_coeffs`) with an angle out of range: {beyond}")
        })?;
        Ok(limits)
    };
    (0..poses.ncols()).map(of_coordinate).collect()
}

/// The palm's frame. The palm faces the direction in which the fingers close from straight to the mean pose; if the mean
/// pose is straight, it faces −y, as in MANO's files.
fn palm(hand: &Hand) -> PalmFrame {
    let posed = |angles: &[f64]| {
        let mut posed = PosedHand::default();
        hand.pose(&crate::space::Pose::at_origin(angles), &mut posed);
        posed
    };
    let [straight, mean] = [posed(&[0.0; ANGLES]), posed(&hand.prior.rest)];
    let middle = |posed: &PosedHand, link: usize| {
        let points = &posed.points[hand.link_points[link].clone()];
        points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64
    };
    let fingers = (1..LINKS - 3).step_by(3);
    let (mut out, mut closing) = (Vector3::zeros(), Vector3::zeros());
    for first in fingers {
        let tip = middle(&straight, first + 2);
        out += (tip - straight.object_from_link[first].translation) / 4.0;
        closing += (middle(&mean, first + 2) - tip) / 4.0;
    }
    let distal = out.try_normalize(1e-6).unwrap_or_else(|| -Vector3::x());
    let across = |v: Vector3<f64>| (v - distal * distal.dot(&v)).try_normalize(1e-3);
    let volar = across(closing).or_else(|| across(-Vector3::y()));
    let volar =
        volar.unwrap_or_else(|| distal.cross(&Vector3::ith(distal.iamin(), 1.0)).normalize());
    let palm = middle(&straight, 0);
    let height = straight.points[hand.link_points[0].clone()].iter();
    let height = height
        .map(|point| volar.dot(&(point - palm)))
        .fold(0.0, f64::max);
    PalmFrame {
        centre: palm + volar * height,
        volar,
        distal,
        faced_m: FACED * out.norm(),
    }
}
