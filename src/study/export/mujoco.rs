//! A scene of `MuJoCo`: the hand, one object, and a keyframe for each grasp.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::text::{comment, name, numbers, obj};
use super::tree::{Attached, Moving, attached, names};
use super::{ExportError, ExportedFile, check_rigid, closing_test};
use crate::evaluation::stability::{Closing, LoadTest, Protocol, Solid, joint_targets};
use crate::figure::MAKER;
use crate::hand::{Capsule, Frame, Hand, JointKind, LinkId};
use crate::mesh::Mesh;
use crate::space::Pose;
use crate::store::GraspRow;
use crate::study::simulation::solid_in_pieces;
use crate::topography::Observer;

/// Time step, seconds: that of `MuJoCo` itself.
const TIME_STEP_S: f64 = 0.002;
/// Memory of the simulation. By default `MuJoCo` took 15 MB, and stopped where a squeeze made 443 contacts.
const MEMORY: &str = "256M";
/// Mass and inertia that every link that moves has at least.
const LEAST: [f64; 2] = [1e-3, 1e-7];
/// Stiffness of couplings, `solref` and `solimp`. With the defaults of `MuJoCo` light jaws that follow each other part by
/// millimetres under the force of the squeeze, and the object moves with them.
const COUPLING: &str = "solref=\"0.004 1\" solimp=\"0.99 0.999 0.001\"";
/// The free body of the object, and the body of `MuJoCo` itself. No link has these names.
const TAKEN: [&str; 2] = ["object", "world"];

/// The content of a scene.
#[derive(Debug, Clone)]
pub struct MujocoScene<'a> {
    /// The hand.
    pub hand: &'a Hand,
    /// Name of the object.
    pub object: &'a str,
    /// The object in its frame.
    pub mesh: &'a Mesh,
    /// Its mass, kilograms; the scene names it but has that of the test.
    pub mass_kg: f64,
    /// The test whose mass, friction and springs the scene has.
    pub protocol: Protocol,
    /// The grasps.
    pub grasps: Vec<&'a GraspRow>,
}

impl MujocoScene<'_> {
    /// `scene.xml` and the meshes that it refers to.
    ///
    /// The shapes that collide are those of the simulations of stability: capsules, balls that fill the meshes of the hand,
    /// and the convex pieces of the object. The hand stands on a mocap body, which a keyframe puts where the grasp has
    /// it; the object is free and starts in its own frame. The actuators are springs, whose targets in a keyframe press as
    /// the test does. Gravity acts on the object and not on the links, as if the hand bore its own weight. The first `user`
    /// number of a body is its digit ([`Link::digit`](crate::hand::Link::digit)), and the site `palm` has the axes of
    /// [`Axes::Palm`](crate::evaluation::stability::Axes::Palm); the text `protocol` is the test (JSON). `observer` is told if the object must be cut.
    ///
    /// # Errors
    /// If the hand has a skin that bends.
    ///
    /// # Panics
    /// If a grasp is one of another hand.
    pub fn files(&self, observer: &Observer<'_>) -> Result<Vec<ExportedFile>, ExportError> {
        check_rigid(self.hand)?;
        let test = closing_test(&self.protocol);
        let solid = solid_in_pieces(self.mesh, observer);
        let mut writer = Writer {
            scene: self,
            names: names(self.hand, &TAKEN),
            links: attached(self.hand),
            tested_kg: test.mass_kg(&solid, self.mass_kg),
            test,
            files: Vec::new(),
            assets: String::new(),
        };
        let mut bodies = String::new();
        writer.body(&mut bodies, 0, 2);
        writer.object(&mut bodies, &solid);
        let mut text = writer.head();
        let _ = write!(text, "  <asset>\n{}  </asset>\n", writer.assets);
        let _ = write!(
            text,
            "  <worldbody>\n    <light pos=\"0.3 -0.3 0.8\" dir=\"-0.3 0.3 -0.8\"/>\n{bodies}  </worldbody>\n"
        );
        writer.couplings(&mut text);
        writer.actuators(&mut text);
        writer.keyframes(&mut text, &solid);
        text.push_str("</mujoco>\n");
        let scene = ExportedFile {
            name: "scene.xml".to_owned(),
            bytes: text.into_bytes(),
        };
        writer.files.insert(0, scene);
        Ok(writer.files)
    }
}

struct Writer<'a> {
    scene: &'a MujocoScene<'a>,
    names: Vec<String>,
    links: Vec<Attached<'a>>,
    test: LoadTest,
    /// Mass of the object in the test, kilograms.
    tested_kg: f64,
    files: Vec<ExportedFile>,
    assets: String,
}

impl Writer<'_> {
    fn head(&self) -> String {
        let MujocoScene {
            hand,
            object,
            mass_kg,
            protocol,
            ..
        } = self.scene;
        let test = &self.test;
        let told = serde_json::to_string(protocol).expect("a protocol is numbers and names");
        format!(
            "<mujoco model=\"{}\">\n  \
             <!-- Made by {MAKER}: hand {} on {}, which weighs {mass_kg} kg; here {} kg, as in the test `{}`. -->\n  \
             <custom><text name=\"protocol\" data=\"{}\"/></custom>\n  \
             <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
             <size memory=\"{MEMORY}\"/>\n  \
             <option timestep=\"{TIME_STEP_S}\" integrator=\"implicitfast\" cone=\"elliptic\" impratio=\"10\"/>\n  \
             <default>\n    \
             <joint armature=\"{}\"/>\n    \
             <default class=\"seen\"><geom type=\"mesh\" group=\"2\" contype=\"0\" conaffinity=\"0\"/></default>\n    \
             <default class=\"hand\"><geom group=\"3\" contype=\"0\" conaffinity=\"1\" friction=\"{friction}\" rgba=\"0.91 0.75 0.64 1\"/></default>\n    \
             <default class=\"object\"><geom type=\"mesh\" group=\"3\" contype=\"1\" conaffinity=\"0\" friction=\"{friction}\" rgba=\"0.5 0.64 0.75 1\"/></default>\n  \
             </default>\n",
            name(&format!("{} on {object}", hand.name)),
            comment(&hand.name),
            comment(object),
            self.tested_kg,
            test.protocol,
            name(&told),
            Closing::ARMATURE_KG_M2,
            friction = test.friction,
        )
    }

    /// Adds a mesh and returns its name.
    fn mesh(
        &mut self,
        called: String,
        vertices: &[Vector3<f64>],
        triangles: &[[u32; 3]],
    ) -> String {
        let file = format!("{called}.obj");
        // The inertia is given, and that of a surface needs no volume.
        let _ = writeln!(
            self.assets,
            "    <mesh name=\"{called}\" file=\"{file}\" inertia=\"shell\"/>"
        );
        self.files.push(obj(file, vertices, triangles));
        called
    }

    /// A link and all links below it.
    fn body(&mut self, text: &mut String, place: usize, depth: usize) {
        let part = self.links[place].clone();
        let hand = self.scene.hand;
        let indent = "  ".repeat(depth);
        let root = part.link.parent.is_none();
        let _ = writeln!(
            text,
            "{indent}<body name=\"{}\" user=\"{}\"{}{}>",
            name(&self.names[place]),
            part.link.digit,
            if root {
                " mocap=\"true\"".to_owned()
            } else {
                placed(&part.origin)
            },
            if root { "" } else { " gravcomp=\"1\"" },
        );
        if let Some(moving) = &part.joint {
            let kind = match moving.kind {
                JointKind::Hinge => "hinge",
                JointKind::Slide => "slide",
            };
            let range = moving
                .limits
                .map(|limits| format!(" range=\"{}\"", numbers(&limits)));
            let _ = writeln!(
                text,
                "{indent}  <joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{}/>",
                name(&part.link.joint_name),
                numbers(&moving.axis),
                range.unwrap_or_default()
            );
        }
        if !root {
            let least = if part.joint.is_some() {
                LEAST
            } else {
                [0.0; 2]
            };
            let density = Closing::DENSITY_KG_M3;
            let mass = hand.link_mass(part.id, density, least);
            if mass.mass_kg > 0.0 {
                inertial(text, &indent, mass.mass_kg, &mass.centre, &mass.inertia);
            }
        }
        let (palm, frame) = hand.palm_on_link();
        if palm == part.id {
            let _ = writeln!(
                text,
                "{indent}  <site name=\"palm\" group=\"5\"{}/>",
                placed(&frame)
            );
        }
        self.shapes(text, &part, &indent);
        for child in place + 1..self.links.len() {
            if self.links[child].link.parent == Some(part.id) {
                self.body(text, child, depth + 1);
            }
        }
        let _ = writeln!(text, "{indent}</body>");
    }

    /// What is seen of a link, and what collides.
    fn shapes(&mut self, text: &mut String, part: &Attached<'_>, indent: &str) {
        let hand = self.scene.hand;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (_, corners, faces) in hand.link_meshes().filter(|(link, ..)| *link == part.id) {
            let first = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            vertices.extend_from_slice(corners);
            triangles.extend(
                faces
                    .iter()
                    .map(|face| face.map(|c| c.saturating_add(first))),
            );
        }
        if !triangles.is_empty() {
            let mesh = self.mesh(format!("link_{:02}", part.id.0), &vertices, &triangles);
            let _ = writeln!(
                text,
                "{indent}  <geom class=\"seen\" mesh=\"{mesh}\" rgba=\"0.91 0.75 0.64 1\"/>"
            );
        }
        let exact: Vec<&Capsule> = of_link(hand.exact_capsules(), part.id).collect();
        for (number, capsule) in hand.capsules.iter().enumerate() {
            if capsule.link != part.id || hand.is_filling(number) {
                continue;
            }
            // What is not covered by a mesh is seen itself.
            let seen = if exact.contains(&capsule) {
                " group=\"2\""
            } else {
                ""
            };
            let _ = writeln!(text, "{indent}  {}", capsule_geom(capsule, seen));
        }
        for ball in hand.balls().iter().filter(|ball| ball.link == part.id) {
            let _ = writeln!(
                text,
                "{indent}  <geom class=\"hand\" type=\"sphere\" pos=\"{}\" size=\"{}\"/>",
                numbers(&ball.centre),
                ball.radius_m
            );
        }
    }

    fn object(&mut self, text: &mut String, solid: &Solid) {
        let mesh = self.scene.mesh;
        let mass_kg = self.tested_kg;
        text.push_str("    <body name=\"object\">\n      <freejoint name=\"object\"/>\n");
        inertial(
            text,
            "    ",
            mass_kg,
            &solid.centre(),
            &(solid.unit_inertia() * mass_kg),
        );
        let seen = self.mesh("object".to_owned(), mesh.vertices(), mesh.triangles());
        let _ = writeln!(
            text,
            "      <geom class=\"seen\" mesh=\"{seen}\" rgba=\"0.5 0.64 0.75 1\"/>"
        );
        for (number, piece) in solid.pieces().iter().enumerate() {
            let called = format!("object_{number:02}");
            let piece = self.mesh(called, &piece.vertices, &piece.triangles);
            let _ = writeln!(text, "      <geom class=\"object\" mesh=\"{piece}\"/>");
        }
        text.push_str("    </body>\n");
    }

    /// Joints that follow others.
    fn couplings(&self, text: &mut String) {
        let mut lines = String::new();
        for part in &self.links {
            if let Some(Moving {
                follows: Some([ratio, offset]),
                leader,
                ..
            }) = &part.joint
            {
                let _ = writeln!(
                    lines,
                    "    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{offset} {ratio} 0 0 0\" {COUPLING}/>",
                    name(&part.link.joint_name),
                    name(&self.scene.hand.joints[*leader].name)
                );
            }
        }
        if !lines.is_empty() {
            let _ = write!(text, "  <equality>\n{lines}  </equality>\n");
        }
    }

    /// A spring for each joint of the hand, in their order.
    fn actuators(&self, text: &mut String) {
        let springs = &self.test.closing;
        text.push_str("  <actuator>\n");
        for joint in &self.scene.hand.joints {
            let lever = joint.kind.radians_per_unit();
            // Beyond these targets a spring at a limit pulls no harder.
            let beyond = springs.torque_limit_n_m / springs.stiffness_n_m / lever;
            let [lower, upper] = joint.limits;
            let range = if joint.wraps {
                String::new()
            } else {
                format!(" ctrlrange=\"{} {}\"", lower - beyond, upper + beyond)
            };
            let most = springs.torque_limit_n_m * lever;
            let _ = writeln!(
                text,
                "    <position name=\"{name}\" joint=\"{name}\" kp=\"{}\" kv=\"{}\" forcerange=\"-{most} {most}\"{range}/>",
                springs.stiffness_n_m * lever.powi(2),
                springs.damping_n_m_s * lever.powi(2),
                name = name(&joint.name),
            );
        }
        text.push_str("  </actuator>\n");
    }

    fn keyframes(&self, text: &mut String, solid: &Solid) {
        text.push_str("  <keyframe>\n");
        for row in &self.scene.grasps {
            let squeezed = row.squeeze_joints.as_deref();
            let hand = self.scene.hand;
            let targets = joint_targets(hand, &row.grasp, squeezed, solid, &self.test);
            let pose = &row.grasp.pose;
            let _ = writeln!(
                text,
                "    <key name=\"{}\" qpos=\"{} 0 0 0 1 0 0 0\" ctrl=\"{}\" mpos=\"{}\" mquat=\"{}\"/>",
                row.id,
                numbers(&self.coordinates(pose)),
                numbers(&targets),
                numbers(pose.translation_m()),
                numbers(&pose.rotation_wxyz())
            );
        }
        text.push_str("  </keyframe>\n");
    }

    /// Coordinates of the joints in the order of the bodies.
    fn coordinates(&self, pose: &Pose) -> Vec<f64> {
        let moving = self.links.iter().filter_map(|part| part.joint.as_ref());
        moving
            .map(|moving| {
                let q = pose.joints()[moving.leader];
                moving
                    .follows
                    .map_or(q, |[ratio, offset]| ratio * q + offset)
            })
            .collect()
    }
}

fn of_link<'a>(
    capsules: impl Iterator<Item = &'a Capsule>,
    link: LinkId,
) -> impl Iterator<Item = &'a Capsule> {
    capsules.filter(move |capsule| capsule.link == link)
}

fn capsule_geom(capsule: &Capsule, seen: &str) -> String {
    let Capsule { a, b, radius_m, .. } = capsule;
    if (b - a).norm() < 1e-9 {
        let at = numbers(a);
        return format!(
            "<geom class=\"hand\" type=\"sphere\" pos=\"{at}\" size=\"{radius_m}\"{seen}/>"
        );
    }
    let ends = numbers(a.iter().chain(b));
    format!("<geom class=\"hand\" type=\"capsule\" fromto=\"{ends}\" size=\"{radius_m}\"{seen}/>")
}

fn inertial(
    text: &mut String,
    indent: &str,
    mass_kg: f64,
    centre: &Vector3<f64>,
    inertia: &Matrix3<f64>,
) {
    let i = |row: usize, column: usize| inertia[(row, column)];
    let six = [i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)];
    let _ = writeln!(
        text,
        "{indent}  <inertial pos=\"{}\" mass=\"{mass_kg}\" fullinertia=\"{}\"/>",
        numbers(centre),
        numbers(&six)
    );
}

fn placed(frame: &Frame) -> String {
    let rotation = Rotation3::from_matrix_unchecked(frame.rotation);
    let q = UnitQuaternion::from_rotation_matrix(&rotation);
    format!(
        " pos=\"{}\" quat=\"{}\"",
        numbers(&frame.translation),
        numbers(&[q.w, q.i, q.j, q.k])
    )
}
