//! Whether imported grasps lie on their object, and which other reading of their file would put them there.
//!
//! Data sets differ in units, orders of quaternions, directions of poses and frames, and most of them say nothing about it.
//! A wrong reading gives grasps beside the object. [`doubt`] measures how far the grasps are off, and if that is implausible,
//! it tries other readings. Nothing is changed: the reading that fits is named together with what selects it.
//!
//! A grasp is *off* by the gap between the object and the second nearest digit (the palm counts as one), or by the depth of
//! the deepest point of the hand in the object if that is more. Two digits, because some part of a hand often lies near an
//! object by chance. The median over grasps counts.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

use crate::doubt::Doubt;
use crate::grasp::depth::deepest_m;
use crate::hand::{Frame, Hand, JointKind, PosedHand};
use crate::mesh::ExactMesh;
use crate::printable::counted;
use crate::space::Pose;
use crate::store::ObjectMetadata;
use crate::store::exchange::{AngleUnit, Frame as Direction, LengthUnit, Mapping, RotationForm};

/// Gap that no reading needs to explain: no data set starts a grasp so far off.
const FAR_M: f64 = 0.05;
/// Depth that no reading needs to explain. The deepest published grasps that were measured have a median of 7 mm.
const DEEP_M: f64 = 0.015;
/// Grasps that are off by less than this are not doubted.
const PLAUSIBLE_M: f64 = 0.01;
/// Greatest depth, by the solids of hand and object, at which a reading fits. A hand that stands in the middle of a small object
/// is deeper in it.
const FITTING_DEPTH_M: f64 = 0.008;
/// Gap of grasps that are refused unless their unit is stated: more than the length of a hand.
const IMPOSSIBLE_M: f64 = 0.5;
/// A reading fits if its grasps are off by at most this share of the given reading's. Few grasps fit more easily by chance.
const SHARE: [(usize, f64); 2] = [(4, 0.25), (0, 0.125)];

/// Coordinates beyond this are not measured: their squares are inexact or infinite.
const FARTHEST_M: f64 = 1e6;

/// Largest number of grasps, and of points of the hand, that are measured.
const GRASPS: usize = 64;
const POINTS: usize = 512;
/// Largest number of grasps whose depth is measured by the solids.
const THOROUGH: usize = 16;

/// An imported grasp.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placed {
    pub(super) pose: Pose,
    /// Scale of the object.
    pub(super) scale: f64,
}

/// What was imported.
pub(super) struct Imported<'a> {
    /// The file or folder.
    pub(super) subject: String,
    /// The hand.
    pub(super) hand: &'a Hand,
    /// The object at scale 1.
    pub(super) object: &'a ObjectMetadata,
    /// How the file was read.
    pub(super) mapping: &'a Mapping,
    /// Whether the format states what the numbers of a rotation are, so that there is no order of a quaternion.
    pub(super) named_rotation: bool,
    /// Whether poses were those of the hand's outermost body.
    pub(super) of_outermost_body: bool,
    /// Whether the file has no scale of the object.
    pub(super) without_scale: bool,
    /// The grasps.
    pub(super) grasps: Vec<Placed>,
}

/// A doubt, and whether the grasps cannot be meant so.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Doubted {
    pub(super) doubt: Doubt,
    pub(super) refused: bool,
}

/// Doubts grasps that lie off their object; `None` if they are plausible. `reread` gives the grasps of the same file under
/// another mapping, if it can be read so.
pub(super) fn doubt(
    imported: &Imported<'_>,
    reread: &dyn Fn(&Mapping) -> Option<Vec<Placed>>,
) -> Option<Doubted> {
    let range = Range::new(imported)?;
    let given = sample(&imported.grasps);
    let fit = range.fit(&given);
    if fit.off_m < PLAUSIBLE_M {
        return None;
    }
    let strong = fit.gap_m > FAR_M || fit.depth_m > DEEP_M;
    let tried = Trial {
        imported,
        range: &range,
        given: &given,
        fit,
        strong,
    };
    let found = tried.other_mapping(reread).or_else(|| tried.other_frame());
    if found.is_none() && !strong {
        return None;
    }
    let refused = fit.gap_m > IMPOSSIBLE_M && imported.mapping.translation_unit.is_none();
    let found = found.unwrap_or_else(|| Found {
        cause: "probably hand, object, scale or frame is another one, since no other unit, direction, order of quaternions or \
                origin fits"
            .to_owned(),
        remedy: "check --hand, --object and --scale".to_owned(),
    });
    let mut remedy = found.remedy;
    if refused {
        remedy += "; `translation_unit = \"m\"` in a --mapping imports them as they are";
    }
    Some(Doubted {
        doubt: Doubt {
            subject: imported.subject.clone(),
            finding: fit.told(imported.grasps.len(), &imported.object.name),
            cause: found.cause,
            remedy,
        },
        refused,
    })
}

/// Doubts joints that lie beyond their limits and would not in degrees, or in millimetres if all of them are slides.
/// `None` if the hand has joints of both kinds, or if such joints do not fit either.
pub(super) fn doubt_joints(
    subject: &str,
    hand: &Hand,
    mapping: &Mapping,
    grasps: &[&Pose],
) -> Option<Doubt> {
    let all = |kind: JointKind| hand.joints.iter().all(|joint| joint.kind == kind);
    let (factor, unit, remedy) = if all(JointKind::Hinge) && mapping.joint_unit == AngleUnit::Rad {
        (
            1.0_f64.to_radians(),
            "degrees",
            lines(&["joint_unit = \"deg\""]),
        )
    } else if all(JointKind::Slide) {
        (1e-3, "millimetres", "give them in metres".to_owned())
    } else {
        return None;
    };
    // Published joints lie up to 0.6 rad beyond their limits.
    let slack = if unit == "degrees" { 0.6 } else { 0.01 };
    let mut farthest: Option<(f64, f64, &str)> = None;
    for pose in grasps {
        for (joint, &value) in hand.joints.iter().zip(pose.joints()) {
            let [lower, upper] = joint.limits;
            let beyond = |q: f64| (lower - q).max(q - upper);
            if !joint.wraps && beyond(value * factor) > slack {
                return None;
            }
            if farthest.is_none_or(|(most, ..)| beyond(value) > most) {
                farthest = Some((beyond(value), value, &joint.name));
            }
        }
    }
    let (_, value, name) = farthest.filter(|(beyond, ..)| *beyond > slack)?;
    Some(Doubt {
        subject: subject.to_owned(),
        finding: format!("joint `{name}` is at {value}, far beyond its limits"),
        cause: format!(
            "probably its joints are in {unit}, which would fit the limits of all grasps"
        ),
        remedy,
    })
}

/// A remedy: lines of a mapping.
fn lines(lines: &[&str]) -> String {
    let lines: Vec<String> = lines.iter().map(|line| format!("`{line}`")).collect();
    format!("give --mapping with {}", lines.join(" and "))
}

/// At most [`GRASPS`] grasps, evenly spread over the file.
fn sample(grasps: &[Placed]) -> Vec<Placed> {
    let count = grasps.len().min(GRASPS);
    let chosen = (0..count).map(|k| grasps[k * grasps.len() / count].clone());
    chosen.collect()
}

/// How far grasps are off: medians, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_field_names, reason = "`_m` names their unit")]
struct Fit {
    off_m: f64,
    gap_m: f64,
    depth_m: f64,
    /// Upper quartile of the depths.
    deep_quarter_m: f64,
}

impl Fit {
    /// Of the gaps and depths of grasps, metres.
    fn of(measured: &[[f64; 2]]) -> Self {
        let quantile = |value: fn(&[f64; 2]) -> f64, share: f64| {
            let mut values: Vec<f64> = measured.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "an index below the number of grasps"
            )]
            let at = (share * (values.len().max(1) - 1) as f64) as usize;
            values.get(at).copied().unwrap_or(0.0)
        };
        Self {
            off_m: quantile(|[gap, depth]| gap.max(*depth), 0.5),
            gap_m: quantile(|[gap, _]| *gap, 0.5),
            depth_m: quantile(|[_, depth]| *depth, 0.5),
            deep_quarter_m: quantile(|[_, depth]| *depth, 0.75),
        }
    }

    /// The lower, the better: a hand in the object is worse than one that has not arrived.
    fn cost_m(&self) -> f64 {
        self.gap_m.max(4.0 * self.depth_m)
    }

    fn told(&self, grasps: usize, object: &str) -> String {
        let which = if self.gap_m >= self.depth_m {
            format!("{} from", length(self.gap_m))
        } else {
            format!("{} inside", length(self.depth_m))
        };
        format!(
            "the median of {} is {which} {object}",
            counted(grasps, "grasp")
        )
    }
}

fn length(metres: f64) -> String {
    if metres < 1.0 {
        format!("{:.1} mm", 1e3 * metres)
    } else {
        format!("{metres:.1} m")
    }
}

/// The hand and the object, for measuring distances.
struct Range<'a> {
    whole: &'a Hand,
    /// The hand with few surface points.
    hand: Hand,
    exact: ExactMesh,
    /// The scale of `exact`.
    scale: f64,
    object: &'a ObjectMetadata,
    /// Centroid of the mesh and centre of its box, at that scale.
    centres: [Vector3<f64>; 2],
}

/// A place where the hand is near the object.
struct Place {
    point: Vector3<f64>,
    distance_m: f64,
}

impl<'a> Range<'a> {
    /// `None` if there are no grasps, or the object cannot be built, which is told when its grasps are judged.
    fn new(imported: &Imported<'a>) -> Option<Self> {
        let scale = imported.grasps.first()?.scale;
        let (mesh, _) = imported.object.mesh(scale).ok()?;
        let [low, high] = mesh.bounds();
        Some(Self {
            whole: imported.hand,
            hand: imported
                .hand
                .thinned(imported.hand.surface.len().div_ceil(POINTS).max(1)),
            exact: ExactMesh::new(&mesh),
            scale,
            object: imported.object,
            centres: [mesh.centroid(), 0.5 * (low + high)],
        })
    }

    /// The nearest places of the nearest and the second nearest digit, if the hand stands so.
    fn nearest(&self, placed: &Placed) -> [Place; 2] {
        let nowhere = |distance_m| Place {
            point: Vector3::zeros(),
            distance_m,
        };
        let pose = &placed.pose;
        if !(pose.iter()).all(|x| x.abs() < FARTHEST_M) {
            return [nowhere(FARTHEST_M), nowhere(FARTHEST_M)];
        }
        let factor = placed.scale / self.scale;
        let mut posed = PosedHand::default();
        self.hand.pose(pose, &mut posed);
        let mut digits: Vec<Option<Place>> = Vec::new();
        digits.resize_with(self.hand.digits.len().max(1), || None);
        for (point, surface) in posed.points.iter().zip(&self.hand.surface) {
            let distance_m = factor * self.exact.distance(&(point / factor));
            let digit = &mut digits[self.hand.links[surface.link.0].digit];
            if digit
                .as_ref()
                .is_none_or(|place| distance_m < place.distance_m)
            {
                let point = *point;
                *digit = Some(Place { point, distance_m });
            }
        }
        let mut places: Vec<Place> = digits.into_iter().flatten().collect();
        places.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        let mut places = places.into_iter();
        let first = places.next().unwrap_or_else(|| nowhere(0.0));
        let second = places.next().unwrap_or(Place { ..first });
        [first, second]
    }

    fn fit(&self, grasps: &[Placed]) -> Fit {
        let measured: Vec<[f64; 2]> = grasps
            .par_iter()
            .map(|placed| {
                let [first, second] = self.nearest(placed);
                [second.distance_m.max(0.0), (-first.distance_m).max(0.0)]
            })
            .collect();
        Fit::of(&measured)
    }

    /// The fit of a few grasps with the depths of the solids: points of the hand show no hand in which a thin object ends.
    fn thorough_fit(&self, grasps: &[Placed]) -> Option<Fit> {
        let scale = grasps.first()?.scale;
        let other;
        let exact = if (scale - self.scale).abs() < f64::EPSILON {
            &self.exact
        } else {
            other = ExactMesh::new(&self.object.mesh(scale).ok()?.0);
            &other
        };
        let same = grasps
            .iter()
            .filter(|placed| (placed.scale - scale).abs() < f64::EPSILON);
        let chosen: Vec<&Placed> = same.take(THOROUGH).collect();
        let measured: Vec<[f64; 2]> = chosen
            .into_par_iter()
            .map(|placed| {
                let mut posed = PosedHand::default();
                self.whole.pose(&placed.pose, &mut posed);
                let [_, second] = self.nearest(placed);
                let depth_m = deepest_m(exact, self.whole, &posed);
                [second.distance_m.max(0.0), depth_m]
            })
            .collect();
        Some(Fit::of(&measured))
    }

    /// The move of all hands, at the scale of the mesh, that brings their two nearest digits onto the object: Gauss–Newton
    /// steps on their signed distances.
    fn shift(&self, grasps: &[Placed]) -> Vector3<f64> {
        const STEPS: usize = 12;
        const LONGEST_M: f64 = 0.1;
        let mut shift = Vector3::zeros();
        for _ in 0..STEPS {
            let moved = shifted(grasps, shift / self.scale);
            let rows: Vec<[(Vector3<f64>, f64); 2]> = moved
                .par_iter()
                .map(|placed| {
                    let factor = placed.scale / self.scale;
                    self.nearest(placed).map(|place| {
                        let normal = self.exact.nearest(&(place.point / factor)).normal;
                        (factor * normal, place.distance_m)
                    })
                })
                .collect();
            // A direction along which no distance changes, as the axis of a bottle, stays as it is.
            let damping = 0.02 * grasps.len() as f64;
            let (mut matrix, mut right) = (Matrix3::identity() * damping, Vector3::zeros());
            for (row, distance) in rows.into_iter().flatten() {
                matrix += row * row.transpose();
                right -= distance * row;
            }
            let step = matrix
                .try_inverse()
                .map_or(right, |inverse| inverse * right);
            shift += step * (LONGEST_M / step.norm().max(LONGEST_M));
        }
        shift
    }
}

/// Moves the hands by `shift`, which belongs to scale 1.
fn shifted(grasps: &[Placed], shift: Vector3<f64>) -> Vec<Placed> {
    let moved = |placed: &Placed| {
        let mut isometry = isometry_of(&placed.pose);
        isometry.translation.vector += placed.scale * shift;
        Placed {
            pose: at(&isometry, placed.pose.joints()),
            ..*placed
        }
    };
    grasps.iter().map(moved).collect()
}

/// The frame of a pose's hand.
fn isometry_of(pose: &Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.rotation_wxyz();
    Isometry3::from_parts(
        Translation3::from(Vector3::from_column_slice(pose.translation_m())),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    )
}

fn at(frame: &Isometry3<f64>, joints: &[f64]) -> Pose {
    let q = frame.rotation;
    Pose::new(
        frame.translation.vector.into(),
        [q.w, q.i, q.j, q.k],
        joints,
    )
}

fn isometry_of_frame(frame: &Frame) -> Isometry3<f64> {
    Isometry3::from_parts(
        frame.translation.into(),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.rotation)),
    )
}

/// The pose of the hand's root if `pose` is that of a frame of the hand.
pub(super) fn of_frame(pose: &Pose, root_from_frame: &Frame) -> Pose {
    let root = isometry_of(pose) * isometry_of_frame(root_from_frame).inverse();
    at(&root, pose.joints())
}

/// A reading that fits.
struct Found {
    cause: String,
    remedy: String,
}

/// One changed entry of a mapping.
struct Change {
    mapping: Mapping,
    cause: &'static str,
    line: &'static str,
}

/// The search for a reading that fits.
struct Trial<'a> {
    imported: &'a Imported<'a>,
    range: &'a Range<'a>,
    given: &'a [Placed],
    fit: Fit,
    strong: bool,
}

impl Trial<'_> {
    /// The fit of these grasps, thoroughly measured, if they fit.
    fn fitting(&self, grasps: &[Placed]) -> Option<Fit> {
        let fits = self.fits(&self.range.fit(grasps));
        let thorough = fits.then(|| self.range.thorough_fit(grasps)).flatten()?;
        (self.fits(&thorough) && thorough.depth_m <= FITTING_DEPTH_M).then_some(thorough)
    }

    fn fits(&self, fit: &Fit) -> bool {
        let count = self.given.len();
        let share = SHARE.iter().find(|(least, _)| count >= *least);
        let share = share.map_or(0.0, |(_, share)| *share);
        // Grasps metres away may be hands that have not closed yet, in another unit.
        let most_m = if self.fit.gap_m > IMPOSSIBLE_M {
            FAR_M
        } else {
            PLAUSIBLE_M
        };
        fit.off_m <= most_m.min(share * self.fit.off_m)
    }

    fn told(fit: &Fit) -> String {
        format!(": the median is then {} off", length(fit.off_m))
    }

    /// The entries of a mapping, one or two of them, whose change fits best.
    fn other_mapping(&self, reread: &dyn Fn(&Mapping) -> Option<Vec<Placed>>) -> Option<Found> {
        let fit = |mapping: &Mapping| {
            let grasps = reread(mapping)?;
            let same = grasps.len() == self.imported.grasps.len();
            same.then(|| self.fitting(&sample(&grasps))).flatten()
        };
        let best = |fitting: Vec<(Fit, Vec<Change>)>| {
            let fitting = fitting.into_iter();
            fitting.min_by(|(a, _), (b, _)| a.cost_m().total_cmp(&b.cost_m()))
        };
        let singles = self.changes(self.imported.mapping);
        let tried = singles.into_iter().filter_map(|change| {
            let fit = fit(&change.mapping)?;
            Some((fit, vec![change]))
        });
        let mut found = best(tried.collect());
        // In another unit the hands may come near the object and still be turned wrongly.
        if self.strong
            && found
                .as_ref()
                .is_none_or(|(fit, _)| fit.off_m > PLAUSIBLE_M)
        {
            let mut tried = Vec::new();
            for first in self.changes(self.imported.mapping) {
                for second in self.changes(&first.mapping) {
                    // Each pair once, and no entry twice.
                    if key(second.line) >= key(first.line) {
                        continue;
                    }
                    if let Some(fit) = fit(&second.mapping) {
                        let first = Change {
                            mapping: Mapping::default(),
                            ..first
                        };
                        tried.push((fit, vec![first, second]));
                    }
                }
            }
            let pair = best(tried);
            found = match (found, pair) {
                (Some(one), Some(two)) if two.0.off_m > SHARE[0].1 * one.0.off_m => Some(one),
                (one, two) => two.or(one),
            };
        }
        let (fit, changes) = found?;
        let causes: Vec<&str> = changes.iter().map(|change| change.cause).collect();
        let entries: Vec<&str> = changes.iter().map(|change| change.line).collect();
        Some(Found {
            cause: format!("probably {}{}", causes.join(" and "), Self::told(&fit)),
            remedy: lines(&entries),
        })
    }

    /// All mappings that differ in one entry.
    fn changes(&self, mapping: &Mapping) -> Vec<Change> {
        let mut changes = Vec::new();
        let mut add = |cause, line, change: &dyn Fn(&mut Mapping)| {
            let mut mapping = mapping.clone();
            change(&mut mapping);
            changes.push(Change {
                mapping,
                cause,
                line,
            });
        };
        let unit = mapping.translation_unit.unwrap_or_default();
        let scaled = self
            .given
            .iter()
            .any(|placed| (placed.scale - 1.0).abs() > 0.1);
        for (other, cause, line) in [
            (
                LengthUnit::M,
                "its positions are in metres",
                "translation_unit = \"m\"",
            ),
            (
                LengthUnit::Cm,
                "its positions are in centimetres",
                "translation_unit = \"cm\"",
            ),
            (
                LengthUnit::Mm,
                "its positions are in millimetres",
                "translation_unit = \"mm\"",
            ),
            (
                LengthUnit::Mesh,
                "its positions are in the unit of the mesh",
                "translation_unit = \"mesh\"",
            ),
        ] {
            if other != unit && (other != LengthUnit::Mesh || scaled) {
                add(cause, line, &|mapping| {
                    mapping.translation_unit = Some(other);
                });
            }
        }
        match mapping.rotation_form {
            RotationForm::Wxyz if !self.imported.named_rotation => add(
                "its quaternions are in the order x y z w",
                "rotation_form = \"xyzw\"",
                &|mapping| mapping.rotation_form = RotationForm::Xyzw,
            ),
            RotationForm::Xyzw => add(
                "its quaternions are in the order w x y z",
                "rotation_form = \"wxyz\"",
                &|mapping| mapping.rotation_form = RotationForm::Wxyz,
            ),
            RotationForm::FixedXyz | RotationForm::RotationVector
                if mapping.rotation_unit == AngleUnit::Rad =>
            {
                add(
                    "the angles of its rotations are in degrees",
                    "rotation_unit = \"deg\"",
                    &|mapping| mapping.rotation_unit = AngleUnit::Deg,
                );
            }
            _ => {}
        }
        if mapping.frame == Direction::ObjectFromHand {
            add(
                "its poses are those of the object in the hand's frame",
                "frame = \"hand_from_object\"",
                &|mapping| mapping.frame = Direction::HandFromObject,
            );
        } else {
            add(
                "its poses are those of the hand in the object's frame",
                "frame = \"object_from_hand\"",
                &|mapping| mapping.frame = Direction::ObjectFromHand,
            );
        }
        if mapping.joint_unit == AngleUnit::Deg {
            add(
                "its joints are in radians",
                "joint_unit = \"rad\"",
                &|mapping| {
                    mapping.joint_unit = AngleUnit::Rad;
                },
            );
        }
        changes
    }

    /// Another frame of the hand or the object, or another size of the object.
    fn other_frame(&self) -> Option<Found> {
        let mut best: Option<(Fit, Found)> = None;
        let mut consider = |grasps: &[Placed], cause: String, remedy: String| {
            let fit = self.range.fit(grasps);
            let better = best
                .as_ref()
                .is_none_or(|(known, _)| fit.off_m < known.off_m);
            if self.fits(&fit) && better {
                let cause = format!("probably {cause}{}", Self::told(&fit));
                best = Some((fit, Found { cause, remedy }));
            }
        };
        let body = self
            .imported
            .hand
            .links
            .get(1)
            .map_or("", |link| &link.name);
        let stated = self.imported.mapping.link.is_some();
        if let Some(offset) = self.imported.hand.root_offset().filter(|_| !stated) {
            let inverse = isometry_of_frame(&offset);
            let moved = |placed: &Placed| Placed {
                pose: if self.imported.of_outermost_body {
                    at(&(isometry_of(&placed.pose) * inverse), placed.pose.joints())
                } else {
                    of_frame(&placed.pose, &offset)
                },
                ..*placed
            };
            let grasps: Vec<Placed> = self.given.iter().map(moved).collect();
            let (cause, remedy) = if self.imported.of_outermost_body {
                (
                    format!(
                        "its poses are those of the world of the hand's file and not of body `{body}`"
                    ),
                    "give --mapping with `link = \"world\"`".to_owned(),
                )
            } else {
                (
                    format!(
                        "its poses are those of body `{body}` and not of the world of the hand's file"
                    ),
                    format!("give --mapping with `link = \"{body}\"`"),
                )
            };
            consider(&grasps, cause, remedy);
        }
        // A moved mesh is left on one side and entered on the other. Hands that have not closed yet are only far off.
        if self.strong || self.fit.deep_quarter_m > PLAUSIBLE_M {
            let mut shifts: Vec<Vector3<f64>> = self.range.centres.to_vec();
            if self.given.len() >= SHARE[0].0 {
                shifts.push(self.range.shift(self.given));
            }
            for shift in shifts {
                let at_scale_one = shift / self.range.scale;
                // Without the sign of a rounded zero.
                let [x, y, z] = <[f64; 3]>::from(-1e3 * shift).map(|x| x.round() + 0.0);
                consider(
                    &shifted(self.given, at_scale_one),
                    format!("the origin of {} is another one", self.imported.object.name),
                    format!(
                        "move the vertices of the mesh by about ({x}, {y}, {z}) mm, measured at scale {}",
                        self.range.scale
                    ),
                );
            }
        }
        if self.strong && self.imported.without_scale && self.given.len() >= SHARE[0].0 {
            for tenths in (-30..=10).filter(|tenths| *tenths != 0) {
                let factor = libm::pow(10.0, f64::from(tenths) / 10.0);
                let resized: Vec<Placed> = (self.given.iter().take(GRASPS / 4))
                    .map(|placed| Placed {
                        pose: placed.pose.clone(),
                        scale: placed.scale * factor,
                    })
                    .collect();
                let scale = self.range.scale * factor;
                consider(
                    &resized,
                    format!("{} has another size", self.imported.object.name),
                    format!("give --scale {scale:.2}"),
                );
            }
        }
        best.map(|(_, found)| found)
    }
}

/// The entry that a line of a mapping sets.
fn key(line: &str) -> &str {
    line.split(' ').next().unwrap_or(line)
}
