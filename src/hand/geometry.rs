//! Geometry of a hand for contact, collision and drawing, from the parts of a description.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::capsule_decomposition::capsules_in;
use super::hull::{Hull, directions};
use super::model::{Body, Form, Model, Part, check_count, within};
use super::side_file::{CapsuleEntry, SideFile};
use super::{Capsule, Frame, HandError, Link, LinkId};
use crate::limits::{HAND_LENGTH, HAND_POSITION};
use crate::mesh::Mesh;

/// A mesh with more triangles than this is drawn as its convex hull.
const DRAWN: usize = 20_000;
/// Largest numbers of parts and of capsules of all links together; pairs of them are compared.
const MOST_PARTS: usize = 500;
const MOST_CAPSULES: usize = 4000;
/// A mesh of closed pieces becomes a hull of each if these fill less than this share of its own hull, if there are not more,
/// and without pieces smaller than this share of all, such as screws.
const FULL: f64 = 0.9;
const MOST_PIECES: usize = 8;
const SMALL_PIECE: f64 = 0.01;
/// Corners of the polygon that approximates a circle.
const CORNERS: u32 = 32;

/// The geometry of all links, sorted by link.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) capsules: Vec<Capsule>,
    /// For each capsule, whether it is geometry of the description rather than the filling of a hull.
    pub(super) exact: Vec<bool>,
    pub(super) hulls: Vec<Hull>,
    pub(super) meshes: Vec<LinkMesh>,
}

/// Triangles fixed to a link, for drawing; link frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinkMesh {
    pub(super) link: LinkId,
    pub(super) vertices: Vec<Vector3<f64>>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Geometry {
    /// Spheres and capsules are kept; every other form becomes its convex hull, filled with capsules. A mesh of several
    /// pieces may become a hull of each.
    ///
    /// The collision geometry counts. Visual geometry counts as [`counted`] says.
    pub(super) fn of(
        model: &Model,
        side: &SideFile,
        links: &[Link],
        notes: &mut Vec<String>,
    ) -> Result<Self, HandError> {
        for (place, entries) in [("capsules", &side.capsules), ("filling", &side.filling)] {
            let known = |name: &String| links.iter().any(|link| &link.name == name);
            if let Some(name) = entries.keys().find(|&name| !known(name)) {
                return Err(HandError::Unknown {
                    place: format!("\"{place}\" of the side file"),
                    kind: "link",
                    name: name.clone(),
                });
            }
        }
        let (parts, told) = counted(model, side);
        notes.extend(told);
        let advice = "give the links fewer pieces, or capsules in the side file (\"capsules\")";
        let count = parts.iter().map(Vec::len).sum();
        check_count("pieces of geometry", count, MOST_PARTS, advice)?;
        let mut geometry = Self::default();
        for (l, (link, parts)) in links.iter().zip(&parts).enumerate() {
            let id = LinkId(l);
            if let Some(entries) = side.capsules.get(&link.name) {
                geometry.add_capsules(id, entries, true, &link.name)?;
                continue;
            }
            let filling = side.filling.get(&link.name);
            for part in parts {
                let added = geometry.add(id, part, filling.is_none(), &link.name)?;
                if !added {
                    notes.push(format!(
                        "a mesh of link \"{}\" is left out: it has no volume",
                        link.name
                    ));
                }
            }
            if let Some(entries) = filling {
                geometry.add_capsules(id, entries, false, &link.name)?;
            }
            geometry.filling_last(id);
        }
        if geometry.capsules.is_empty() {
            return Err(HandError::NoGeometry);
        }
        check_count("capsules", geometry.capsules.len(), MOST_CAPSULES, advice)?;
        Ok(geometry)
    }

    fn add_capsules(
        &mut self,
        link: LinkId,
        entries: &[CapsuleEntry],
        exact: bool,
        name: &str,
    ) -> Result<(), HandError> {
        for &CapsuleEntry { a, b, radius_m } in entries {
            check_size(radius_m, name)?;
            for &coordinate in a.iter().chain(&b) {
                let place = || format!("an end of a capsule of link \"{name}\" in the side file");
                within(HAND_POSITION, coordinate, place)?;
            }
            self.push(
                Capsule {
                    link,
                    a: a.into(),
                    b: b.into(),
                    radius_m,
                },
                exact,
            );
        }
        Ok(())
    }

    /// Moves the capsules that fill the hulls of the last link behind the link's exact capsules.
    fn filling_last(&mut self, link: LinkId) {
        let first = self.capsules.partition_point(|capsule| capsule.link < link);
        let of_link = self.capsules.drain(first..).zip(self.exact.drain(first..));
        let (exact, filling): (Vec<_>, Vec<_>) = of_link.partition(|(_, exact)| *exact);
        for (capsule, exact) in exact.into_iter().chain(filling) {
            self.push(capsule, exact);
        }
    }

    /// Refuses meshes that are needed but could not be read.
    pub(super) fn check_meshes(model: &Model, side: &SideFile) -> Result<(), HandError> {
        for (body, parts) in model.bodies.iter().zip(counted(model, side).0) {
            for part in parts {
                if let Form::Unread(_) = part.form {
                    points(&part.form, &body.name)?;
                }
            }
        }
        Ok(())
    }

    fn push(&mut self, capsule: Capsule, exact: bool) {
        self.capsules.push(capsule);
        self.exact.push(exact);
    }

    /// Adds a part; returns whether it has a volume.
    fn add(
        &mut self,
        link: LinkId,
        part: &Part,
        filled: bool,
        name: &str,
    ) -> Result<bool, HandError> {
        let frame = &part.in_body;
        let placed = |capsule: &Capsule| Capsule {
            a: frame.point(&capsule.a),
            b: frame.point(&capsule.b),
            ..*capsule
        };
        if let Form::Sphere { .. } | Form::Capsule { .. } = part.form {
            for capsule in primitive(&part.form, link, name)? {
                self.push(placed(&capsule), true);
            }
            return Ok(true);
        }
        let points: Vec<Vector3<f64>> = points(&part.form, name)?
            .iter()
            .map(|point| frame.point(point))
            .collect();
        let Some(hull) = Hull::of(link, &points) else {
            return Ok(false);
        };
        self.meshes.push(drawn(&part.form, frame, &hull));
        let hulls = match &part.form {
            Form::Mesh(mesh) => hulls_of_pieces(&points, &mesh.triangles, &hull),
            _ => None,
        };
        let hulls = hulls.unwrap_or_else(|| vec![hull]);
        if filled {
            match &part.form {
                Form::Mesh(_) | Form::Ellipsoid { .. } => {
                    for capsule in hulls.iter().flat_map(capsules_in) {
                        self.push(capsule, false);
                    }
                }
                form => {
                    for capsule in primitive(form, link, name)? {
                        self.push(placed(&capsule), false);
                    }
                }
            }
        }
        self.hulls.extend(hulls);
        Ok(true)
    }
}

/// For each body the parts that count, and notes on the visual parts.
///
/// Collision parts count. Visual parts count only of bodies without collision parts: all of them if no body of the hand has
/// any; otherwise meshes, if the body is fixed to none that has. Other visual parts are marks for drawing, such as axes.
/// Bodies with capsules in the side file have no parts.
fn counted<'a>(model: &'a Model, side: &SideFile) -> (Vec<Vec<&'a Part>>, Vec<String>) {
    let solid = |body: &Body| body.parts.iter().any(|part| part.solid);
    let own = |body: &Body| !side.capsules.contains_key(&body.name);
    let any = model.bodies.iter().any(solid);
    // For each body the first of those that are fixed to each other.
    let mut rigid: Vec<usize> = Vec::new();
    for (b, body) in model.bodies.iter().enumerate() {
        let above = body.parent.filter(|_| body.joint.is_none());
        rigid.push(above.map_or(b, |parent| rigid[parent]));
    }
    let mut has_solid = vec![false; rigid.len()];
    for (body, &first) in model.bodies.iter().zip(&rigid) {
        has_solid[first] |= solid(body) || !own(body);
    }
    let (mut left_out, mut taken) = (Vec::new(), Vec::new());
    let parts = model.bodies.iter().zip(&rigid).map(|(body, &first)| {
        if !own(body) {
            return Vec::new();
        }
        let visual = !solid(body);
        let counts = |part: &&Part| match part.form {
            _ if !visual => part.solid,
            _ if !any => true,
            Form::Mesh(_) | Form::Unread(_) => !has_solid[first],
            _ => false,
        };
        let parts: Vec<&Part> = body.parts.iter().filter(counts).collect();
        if visual && !body.parts.is_empty() {
            let names = if parts.is_empty() {
                &mut left_out
            } else {
                &mut taken
            };
            names.push(body.name.as_str());
        }
        parts
    });
    let parts = parts.collect();
    let mut notes = Vec::new();
    if !any && !taken.is_empty() {
        notes.push("no link has collision geometry, so the visual geometry is the hand".to_owned());
    } else if !taken.is_empty() {
        notes.push(format!(
            "{} no collision geometry, and no link fixed to it has any, so visual meshes are taken in its place; add collision \
             geometry for another shape",
            having(&taken)
        ));
    }
    if !left_out.is_empty() {
        notes.push(format!(
            "{} no collision geometry, so visual geometry is left out there; add collision geometry, or capsules in the side \
             file, if objects can touch it",
            having(&left_out)
        ));
    }
    (parts, notes)
}

/// `links "a" and "b" have`, with at most five names.
fn having(names: &[&str]) -> String {
    const MOST: usize = 5;
    let quoted: Vec<String> = names
        .iter()
        .take(MOST)
        .map(|name| format!("\"{name}\""))
        .collect();
    match (quoted.as_slice(), names.len()) {
        ([name], 1) => format!("link {name} has"),
        ([others @ .., last], count) if count <= MOST => {
            format!("links {} and {last} have", others.join(", "))
        }
        (quoted, count) => {
            let more = count - quoted.len();
            format!("links {} and {more} more have", quoted.join(", "))
        }
    }
}

/// The mesh itself if it has few enough triangles, otherwise the hull.
fn drawn(form: &Form, frame: &Frame, hull: &Hull) -> LinkMesh {
    match form {
        Form::Mesh(mesh) if (1..=DRAWN).contains(&mesh.triangles.len()) => LinkMesh {
            link: hull.link,
            vertices: mesh.vertices.iter().map(|v| frame.point(v)).collect(),
            triangles: mesh.triangles.clone(),
        },
        _ => LinkMesh {
            link: hull.link,
            vertices: hull.vertices.clone(),
            triangles: hull.triangles.clone(),
        },
    }
}

/// The hulls of the closed pieces of a mesh, if they tell much more than the hull of them all.
fn hulls_of_pieces(
    points: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    whole: &Hull,
) -> Option<Vec<Hull>> {
    if triangles.len() > DRAWN {
        return None;
    }
    let mesh = Mesh::closed("part", points.to_vec(), triangles.to_vec()).ok()?;
    let hull = |piece: Vec<[u32; 3]>| {
        let corners: BTreeSet<u32> = piece.into_iter().flatten().collect();
        let corners = corners.into_iter().map(|v| mesh.vertices()[v as usize]);
        let hull = Hull::of(whole.link, &corners.collect::<Vec<_>>())?;
        Some((hull.volume_m3(), hull))
    };
    let mut pieces: Vec<(f64, Hull)> = mesh.pieces().into_iter().filter_map(hull).collect();
    pieces.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let all_m3: f64 = pieces.iter().map(|(volume, _)| volume).sum();
    let mut hulls: Vec<Hull> = Vec::new();
    let mut filled_m3 = 0.0;
    for (volume, hull) in pieces {
        // The wall of a cavity lies in that around it.
        if volume >= SMALL_PIECE * all_m3 && !hulls.iter().any(|other| other.holds(&hull)) {
            filled_m3 += volume;
            hulls.push(hull);
        }
    }
    let better = filled_m3 < FULL * whole.volume_m3();
    (better && (1..=MOST_PIECES).contains(&hulls.len())).then_some(hulls)
}

/// Points in the form's own frame whose convex hull is the form.
fn points(form: &Form, name: &str) -> Result<Vec<Vector3<f64>>, HandError> {
    Ok(match form {
        Form::Cylinder { radius, length } => {
            check_size(*radius, name)?;
            check_size(*length, name)?;
            let circle =
                (0..CORNERS).map(|k| libm::sincos(TAU * f64::from(k) / f64::from(CORNERS)));
            let ends = |(sin, cos): (f64, f64)| {
                [-0.5, 0.5].map(|end| Vector3::new(radius * cos, radius * sin, end * length))
            };
            circle.flat_map(ends).collect()
        }
        Form::Cuboid { size } => {
            for &side in size {
                check_size(side, name)?;
            }
            let half = Vector3::from(*size) / 2.0;
            let sign = |bits: usize, axis: usize| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
            let corner = |bits: usize| Vector3::from_fn(|axis, _| sign(bits, axis) * half[axis]);
            (0..8).map(corner).collect()
        }
        Form::Ellipsoid { radii } => {
            for &radius in radii {
                check_size(radius, name)?;
            }
            let radii = Vector3::from(*radii);
            directions(256).map(|d| d.component_mul(&radii)).collect()
        }
        Form::Mesh(mesh) => mesh.vertices.clone(),
        Form::Unread(problem) => {
            return Err(HandError::Mesh {
                link: name.to_owned(),
                problem: problem.clone(),
            });
        }
        Form::Sphere { .. } | Form::Capsule { .. } => Vec::new(),
    })
}

fn check_size(size: f64, link: &str) -> Result<(), HandError> {
    within(HAND_LENGTH, size, || format!("a size in link \"{link}\""))
}

/// A primitive as capsules in its own frame.
///
/// A cylinder becomes the capsule that reaches from cap to cap; a flat cylinder is replaced by the box around it. A
/// box becomes a row of parallel capsules as thick as its shortest side, which rounds its edges off.
fn primitive(form: &Form, link: LinkId, name: &str) -> Result<Vec<Capsule>, HandError> {
    let along_z = |radius_m: f64, half: f64| {
        vec![Capsule {
            link,
            a: Vector3::z() * -half,
            b: Vector3::z() * half,
            radius_m,
        }]
    };
    match form {
        Form::Sphere { radius } => {
            check_size(*radius, name)?;
            Ok(along_z(*radius, 0.0))
        }
        Form::Capsule { radius, length } => {
            check_size(*radius, name)?;
            check_size(*length, name)?;
            Ok(along_z(*radius, length / 2.0))
        }
        Form::Cylinder { radius, length } => {
            check_size(*radius, name)?;
            check_size(*length, name)?;
            if 2.0 * radius > *length {
                return Ok(rounded_box([2.0 * radius, 2.0 * radius, *length], link));
            }
            Ok(along_z(*radius, length / 2.0 - radius))
        }
        Form::Cuboid { size } => {
            for &side in size {
                check_size(side, name)?;
            }
            Ok(rounded_box(*size, link))
        }
        Form::Ellipsoid { .. } | Form::Mesh(_) | Form::Unread(_) => Ok(Vec::new()),
    }
}

/// Parallel capsules along the longest side, with axes at most a radius apart.
fn rounded_box(size: [f64; 3], link: LinkId) -> Vec<Capsule> {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| size[j].total_cmp(&size[i]));
    let [long, wide, thin] = order;
    let radius_m = size[thin] / 2.0;
    let half = |axis: usize| Vector3::ith(axis, size[axis] / 2.0 - radius_m);
    let gaps = (0..64)
        .find(|&gaps| 2.0 * half(wide)[wide] <= f64::from(gaps) * radius_m)
        .unwrap_or(64);
    (0..=gaps)
        .map(|row| {
            let centre = half(wide) * (f64::from(2 * row - gaps) / f64::from(gaps.max(1)));
            Capsule {
                link,
                a: centre - half(long),
                b: centre + half(long),
                radius_m,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners and triangles of boxes with these lowest and highest corners.
    fn boxes(of: &[[[f64; 3]; 2]]) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
        const FACES: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for ends in of {
            let first = u32::try_from(points.len()).unwrap();
            points.extend((0..8usize).map(|k| Vector3::from_fn(|i, _| ends[k >> i & 1][i])));
            triangles.extend((FACES.iter()).flat_map(|&[a, b, c, d]| {
                [[a, b, c], [a, c, d]].map(|face| face.map(|corner| first + corner))
            }));
        }
        (points, triangles)
    }

    /// Pieces with air between them are hulls of their own. Halves of one solid, cavities and screws are not.
    #[test]
    fn pieces_of_a_mesh_have_hulls_of_their_own() {
        let found = |of: &[[[f64; 3]; 2]]| -> Option<Vec<f64>> {
            let (points, triangles) = boxes(of);
            let whole = Hull::of(LinkId(0), &points).unwrap();
            let hulls = hulls_of_pieces(&points, &triangles, &whole)?;
            // Cubic centimetres.
            Some(
                hulls
                    .iter()
                    .map(|hull| (1e6 * hull.volume_m3()).round())
                    .collect(),
            )
        };
        let palm = [[0.0; 3], [0.02, 0.02, 0.02]];
        let rod = [[0.02, 0.0, 0.0], [0.06, 0.01, 0.01]];
        let hollow = [[0.005; 3], [0.015; 3]];
        let screw = [[0.0, 0.03, 0.0], [0.002, 0.032, 0.002]];
        assert_eq!(found(&[rod, palm]), Some(vec![8.0, 4.0]));
        assert_eq!(found(&[palm, hollow, screw, rod]), Some(vec![8.0, 4.0]));
        assert_eq!(found(&[palm]), None);
        let half = [[0.02, 0.0, 0.0], [0.04, 0.02, 0.02]];
        assert_eq!(found(&[palm, half]), None);
        let beads = |count: u8| -> Vec<[[f64; 3]; 2]> {
            let bead = |k| {
                [
                    [f64::from(k) * 0.02, 0.0, 0.0],
                    [f64::from(k) * 0.02 + 0.01, 0.01, 0.01],
                ]
            };
            (0..count).map(bead).collect()
        };
        assert_eq!(found(&beads(8)), Some(vec![1.0; 8]));
        assert_eq!(found(&beads(9)), None);
        // What is open bounds nothing.
        let (points, mut triangles) = boxes(&[rod, palm]);
        triangles.pop();
        let whole = Hull::of(LinkId(0), &points).unwrap();
        assert!(hulls_of_pieces(&points, &triangles, &whole).is_none());
    }

    /// Boxes and flat cylinders reach exactly as far as they should along each axis, whichever side is longest.
    #[test]
    fn primitives_keep_their_extents() {
        let extents = |form: &Form| {
            let capsules = primitive(form, LinkId(0), "a").unwrap();
            let reach = |axis: usize| {
                let reach = |c: &Capsule| c.a[axis].abs().max(c.b[axis].abs()) + c.radius_m;
                2.0 * capsules.iter().map(reach).fold(0.0, f64::max)
            };
            [reach(0), reach(1), reach(2)]
        };
        let cuboid = |size| Form::Cuboid { size };
        let cylinder = |radius, length| Form::Cylinder { radius, length };
        let capsule = Form::Capsule {
            radius: 0.01,
            length: 0.05,
        };
        for (form, expected) in [
            (cuboid([0.1, 0.02, 0.06]), [0.1, 0.02, 0.06]),
            (cuboid([0.03, 0.03, 0.03]), [0.03; 3]),
            (cylinder(0.01, 0.05), [0.02, 0.02, 0.05]),
            (cylinder(0.04, 0.02), [0.08, 0.08, 0.02]),
            (capsule, [0.02, 0.02, 0.07]),
        ] {
            let found = extents(&form);
            for axis in 0..3 {
                assert!(
                    (found[axis] - expected[axis]).abs() < 1e-12,
                    "{form:?}: {found:?}"
                );
            }
        }
    }
}
