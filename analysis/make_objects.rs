//! The bottles, the jar and the ball that come with this crate → `data/objects/*.obj` and `*.json`.
//!
//! A bottle is a profile (radius over height, corners rounded) swept about the z axis; its cross-section passes from a
//! circle at the neck to an oval or a rounded square at the body. Every object stands on z = 0, in metres.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;
use std::path::Path;

use landscape::grasp::object::{Description, Mesh, Primitive, Sphere};
use landscape::space::Symmetry;
use nalgebra::{Isometry3, Vector2, Vector3};

/// Corner of a profile in millimetres: distance from the axis, height, radius of the rounding.
type Corner = [f64; 3];

struct Bottle {
    name: &'static str,
    mass_kg: f64,
    profile: &'static [Corner],
    section: Section,
}

/// Cross-section |x/a|ⁿ + |y/b|ⁿ = rⁿ below the shoulder, a circle above it.
struct Section {
    depth: f64,
    exponent: f64,
    shoulder_mm: [f64; 2],
}

const ROUND: Section = Section {
    depth: 1.0,
    exponent: 2.0,
    shoulder_mm: [0.0, 1.0],
};

const BOTTLES: [Bottle; 7] = [
    Bottle {
        name: "bottle_round",
        mass_kg: 0.62,
        profile: &[
            [31.0, 0.0, 5.0],
            [31.0, 138.0, 45.0],
            [13.5, 180.0, 40.0],
            [13.5, 212.0, 4.0],
            [15.5, 216.0, 4.0],
            [15.5, 230.0, 4.0],
        ],
        section: ROUND,
    },
    Bottle {
        name: "bottle_water",
        mass_kg: 1.35,
        profile: &[
            [42.0, 0.0, 9.0],
            [42.0, 95.0, 45.0],
            [33.0, 130.0, 35.0],
            [42.0, 165.0, 45.0],
            [42.0, 225.0, 45.0],
            [15.0, 272.0, 15.0],
            [15.0, 296.0, 4.0],
        ],
        section: ROUND,
    },
    Bottle {
        name: "bottle_medicine",
        mass_kg: 0.06,
        profile: &[
            [19.0, 0.0, 3.5],
            [19.0, 50.0, 5.0],
            [14.5, 57.0, 4.0],
            [14.5, 75.0, 3.5],
        ],
        section: ROUND,
    },
    Bottle {
        name: "jar",
        mass_kg: 0.55,
        profile: &[
            [42.0, 0.0, 8.0],
            [44.0, 72.0, 9.0],
            [37.0, 80.0, 5.0],
            [37.0, 98.0, 4.0],
        ],
        section: ROUND,
    },
    Bottle {
        name: "bottle_square",
        mass_kg: 0.78,
        profile: &[
            [34.0, 0.0, 6.0],
            [34.0, 145.0, 25.0],
            [15.0, 172.0, 14.0],
            [15.0, 205.0, 4.0],
        ],
        section: Section {
            depth: 1.0,
            exponent: 5.0,
            shoulder_mm: [130.0, 172.0],
        },
    },
    Bottle {
        name: "bottle_flask",
        mass_kg: 0.33,
        profile: &[
            [44.0, 0.0, 9.0],
            [46.0, 95.0, 30.0],
            [12.5, 128.0, 12.0],
            [12.5, 152.0, 4.0],
        ],
        section: Section {
            depth: 0.5,
            exponent: 2.4,
            shoulder_mm: [85.0, 130.0],
        },
    },
    Bottle {
        name: "bottle_squeeze",
        mass_kg: 0.5,
        profile: &[
            [44.0, 0.0, 9.0],
            [47.0, 55.0, 120.0],
            [42.0, 122.0, 26.0],
            [18.0, 142.0, 8.0],
            [16.0, 166.0, 6.0],
            [7.0, 178.0, 6.0],
            [5.0, 195.0, 3.2],
        ],
        section: Section {
            depth: 0.62,
            exponent: 2.5,
            shoulder_mm: [95.0, 142.0],
        },
    },
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/objects");
    fs::create_dir_all(&folder)?;
    let mut made: Vec<(&str, Mesh, Description)> = Vec::new();
    for bottle in &BOTTLES {
        made.push((bottle.name, bottle.mesh()?, bottle.description()));
    }
    made.push(ball()?);
    for (name, mesh, description) in made {
        fs::write(folder.join(format!("{name}.obj")), mesh.to_obj())?;
        fs::write(
            folder.join(format!("{name}.json")),
            serde_json::to_string_pretty(&description)? + "\n",
        )?;
        let size_mm = (mesh.bounds()[1] - mesh.bounds()[0]) * 1e3;
        println!(
            "{name}: {} triangles, {:.0} × {:.0} × {:.0} mm, {:.0} ml, {} kg",
            mesh.triangles().len(),
            size_mm.x,
            size_mm.y,
            size_mm.z,
            mesh.volume() * 1e6,
            description.mass_kg.unwrap_or_default()
        );
    }
    Ok(())
}

impl Bottle {
    fn mesh(&self) -> Result<Mesh, Box<dyn std::error::Error>> {
        let profile = rounded(self.profile);
        let (mut vertices, mut triangles) = (vec![Vector3::zeros()], Vec::new());
        let mut below: Vec<u32> = Vec::new();
        for (index, point) in profile.iter().enumerate() {
            // Neighbouring rings differ by one halving at most.
            let wanted = segments(point.x);
            let count = match below.len() {
                0 => segments(profile[0].x),
                previous => wanted.clamp(previous / 2, previous * 2),
            };
            let first = u32::try_from(vertices.len())?;
            vertices.extend(
                (0..count).map(|step| self.section.point(point, TAU * step as f64 / count as f64)),
            );
            let ring: Vec<u32> = (first..).take(count).collect();
            if index == 0 {
                triangles.extend((0..count).map(|i| [0, ring[(i + 1) % count], ring[i]]));
            } else {
                stitch(&below, &ring, &mut triangles);
            }
            below = ring;
        }
        let top = u32::try_from(vertices.len())?;
        vertices.push(Vector3::z() * profile.last().expect("a profile has points").y);
        let count = below.len();
        triangles.extend((0..count).map(|i| [top, below[i], below[(i + 1) % count]]));
        let metres = vertices.into_iter().map(|v| v * 1e-3).collect();
        Ok(Mesh::new(self.name, metres, triangles)?)
    }

    fn description(&self) -> Description {
        let turn = |angle: f64| Isometry3::rotation(Vector3::z() * angle);
        let symmetry = if self.section.depth < 1.0 {
            Symmetry::Finite(vec![turn(PI)])
        } else if self.section.exponent > 2.0 {
            Symmetry::Finite(vec![turn(FRAC_PI_2), turn(PI), turn(-FRAC_PI_2)])
        } else {
            Symmetry::Axis {
                point: Vector3::zeros(),
                direction: Vector3::z(),
            }
        };
        Description {
            name: Some(self.name.into()),
            mass_kg: Some(self.mass_kg),
            symmetry,
            primitive: None,
        }
    }
}

impl Section {
    fn point(&self, profile: &Vector2<f64>, angle: f64) -> Vector3<f64> {
        let [from, to] = self.shoulder_mm;
        let t = ((profile.y - from) / (to - from)).clamp(0.0, 1.0);
        let circle = t * t * (3.0 - 2.0 * t);
        let depth = self.depth + (1.0 - self.depth) * circle;
        let exponent = self.exponent + (2.0 - self.exponent) * circle;
        let (sin, cos) = angle.sin_cos();
        let reach =
            profile.x * (cos.abs().powf(exponent) + sin.abs().powf(exponent)).powf(-1.0 / exponent);
        Vector3::new(reach * cos, depth * reach * sin, profile.y)
    }
}

/// Fewest segments of a ring that stay within 0.05 mm of the circle; steps of two so that rings can be stitched.
fn segments(radius_mm: f64) -> usize {
    let sagitta = |count: usize| radius_mm * (1.0 - (PI / count as f64).cos());
    [9, 18, 36]
        .into_iter()
        .find(|&count| sagitta(count) <= 0.05)
        .unwrap_or(72)
}

/// The profile from the axis at the bottom to the axis at the top, corners replaced by arcs, evenly divided.
fn rounded(corners: &[Corner]) -> Vec<Vector2<f64>> {
    const STEP_MM: f64 = 8.0;
    const ARC_STEP: f64 = PI / 10.0;
    let point = |corner: &Corner| Vector2::new(corner[0], corner[1]);
    let (bottom, top) = (corners[0][1], corners[corners.len() - 1][1]);
    let mut ends = vec![Vector2::new(0.0, bottom)];
    ends.extend(corners.iter().map(point));
    ends.push(Vector2::new(0.0, top));

    let mut curve = vec![ends[0]];
    for (index, corner) in corners.iter().enumerate() {
        let [before, here, after] = [ends[index], ends[index + 1], ends[index + 2]];
        let (inward, onward) = ((here - before).normalize(), (after - here).normalize());
        let turn = inward.perp(&onward).atan2(inward.dot(&onward));
        let half = (turn / 2.0).tan().abs();
        // An arc may use up half of an edge.
        let room = 0.49 * (here - before).norm().min((after - here).norm());
        let radius = corner[2].min(room / half);
        let start = here - inward * (radius * half);
        line_to(&mut curve, start, STEP_MM);
        let side = Vector2::new(-inward.y, inward.x) * turn.signum();
        let centre = start + side * radius;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small positive count"
        )]
        let steps = (turn.abs() / ARC_STEP)
            .max(turn.abs() * radius / STEP_MM)
            .ceil() as u32;
        for step in 1..=steps {
            let (sin, cos) = (turn * f64::from(step) / f64::from(steps)).sin_cos();
            let spoke = -side * radius;
            curve.push(
                centre + Vector2::new(cos * spoke.x - sin * spoke.y, sin * spoke.x + cos * spoke.y),
            );
        }
    }
    line_to(&mut curve, Vector2::new(0.0, top), STEP_MM);
    // The points on the axis are the poles.
    curve.pop();
    curve.remove(0);
    curve
}

fn line_to(curve: &mut Vec<Vector2<f64>>, end: Vector2<f64>, step: f64) {
    let start = curve[curve.len() - 1];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive count"
    )]
    let count = ((end - start).norm() / step).ceil().max(1.0) as u32;
    curve.extend((1..=count).map(|i| start.lerp(&end, f64::from(i) / f64::from(count))));
}

/// Triangles between two rings, the upper of which has as many, half or twice as many vertices.
fn stitch(below: &[u32], above: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let (few, many) = (below.len().min(above.len()), below.len().max(above.len()));
    if few == many {
        for i in 0..few {
            let j = (i + 1) % few;
            triangles.extend([
                [below[i], below[j], above[j]],
                [below[i], above[j], above[i]],
            ]);
        }
        return;
    }
    let (coarse, fine) = if below.len() == few {
        (below, above)
    } else {
        (above, below)
    };
    for i in 0..few {
        let j = (i + 1) % few;
        let [a, b, c] = [fine[2 * i], fine[2 * i + 1], fine[(2 * i + 2) % many]];
        for [p, q, r] in [
            [a, b, coarse[i]],
            [b, coarse[j], coarse[i]],
            [b, c, coarse[j]],
        ] {
            triangles.push(if coarse == below {
                [q, p, r]
            } else {
                [p, q, r]
            });
        }
    }
}

/// A ball from an icosahedron divided four times.
fn ball() -> Result<(&'static str, Mesh, Description), Box<dyn std::error::Error>> {
    const RADIUS_M: f64 = 0.035;
    let centre = Vector3::z() * RADIUS_M;
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut vertices: Vec<Vector3<f64>> = Vec::new();
    for [a, b] in [
        [-1.0, -golden],
        [1.0, -golden],
        [-1.0, golden],
        [1.0, golden],
    ] {
        vertices.extend([
            Vector3::new(a, b, 0.0),
            Vector3::new(0.0, a, b),
            Vector3::new(b, 0.0, a),
        ]);
    }
    // Faces are the triples of mutual neighbours, which lie two apart.
    let near = |i: usize, j: usize| (vertices[i] - vertices[j]).norm() < 2.1;
    let mut faces: Vec<[Vector3<f64>; 3]> = Vec::new();
    for (i, j, k) in
        (0..12).flat_map(|i| (i + 1..12).flat_map(move |j| (j + 1..12).map(move |k| (i, j, k))))
    {
        if near(i, j) && near(j, k) && near(k, i) {
            let [a, b, c] = [i, j, k].map(|index| vertices[index].normalize());
            faces.push(if a.dot(&b.cross(&c)) > 0.0 {
                [a, b, c]
            } else {
                [a, c, b]
            });
        }
    }
    for _ in 0..4 {
        let divide = |[a, b, c]: [Vector3<f64>; 3]| {
            let [ab, bc, ca] = [
                (a + b).normalize(),
                (b + c).normalize(),
                (c + a).normalize(),
            ];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(divide).collect();
    }
    // Corners of neighbouring faces coincide to the last bit and are merged by `Mesh::new`.
    let corners: Vec<Vector3<f64>> = faces
        .into_iter()
        .flatten()
        .map(|unit| centre + unit * RADIUS_M)
        .collect();
    let triangles = (0..u32::try_from(corners.len())?)
        .step_by(3)
        .map(|i| [i, i + 1, i + 2])
        .collect();
    let description = Description {
        name: Some("ball".into()),
        mass_kg: Some(0.06),
        symmetry: Symmetry::Sphere { centre },
        primitive: Some(Primitive::Sphere(Sphere {
            centre,
            radius_m: RADIUS_M,
        })),
    };
    Ok(("ball", Mesh::new("ball", corners, triangles)?, description))
}
