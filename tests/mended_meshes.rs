//! Meshes whose faces are there twice, in both directions, on separate corners or with walls inside: their solid has the
//! volume of the shape that they were made from, or they are refused.

use std::f64::consts::TAU;

use landscape::mesh::{Mesh, Repair, Repaired};
use landscape::object::Object;
use landscape::sample::{Rng, Task, stream};
use nalgebra::{Rotation3, Unit, Vector3};
use rand::RngExt;

/// Polygons over vertices, and the volume that they enclose.
struct Shape {
    name: &'static str,
    vertices: Vec<Vector3<f64>>,
    polygons: Vec<Vec<u32>>,
    volume: f64,
    /// The volume if the inner pieces count as solid.
    filled: f64,
}

impl Shape {
    fn new(name: &'static str) -> Self {
        Self {
            name,
            vertices: Vec::new(),
            polygons: Vec::new(),
            volume: 0.0,
            filled: 0.0,
        }
    }

    /// Adds a box from one corner to another, inside out if `hollow`.
    fn with_box(mut self, low: [f64; 3], high: [f64; 3], hollow: bool) -> Self {
        let first = u32::try_from(self.vertices.len()).unwrap();
        for corner in 0..8 {
            let side = |axis: usize| {
                if corner >> axis & 1 == 1 {
                    high[axis]
                } else {
                    low[axis]
                }
            };
            self.vertices.push(Vector3::new(side(0), side(1), side(2)));
        }
        let faces = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        for mut face in faces.map(|face| face.map(|corner| corner + first).to_vec()) {
            if hollow {
                face.reverse();
            }
            self.polygons.push(face);
        }
        let volume: f64 = (0..3).map(|axis| high[axis] - low[axis]).product();
        self.volume += if hollow { -volume } else { volume };
        self.filled = self.filled.max(self.volume);
        self
    }

    fn of_mesh(name: &'static str) -> Self {
        let (mesh, _) = Object::parts_of_named(name).unwrap();
        Self {
            vertices: mesh.vertices().to_vec(),
            polygons: mesh.triangles().iter().map(|t| t.to_vec()).collect(),
            volume: mesh.volume(),
            filled: mesh.volume(),
            ..Self::new(name)
        }
    }
}

fn shapes() -> Vec<Shape> {
    let legs = |shape: Shape, top: f64, width: f64| {
        [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]
            .into_iter()
            .fold(shape, |shape, [x, y]| {
                let (x, y, half) = (0.022 * x, 0.022 * y, width / 2.0);
                shape.with_box(
                    [x - half, y - half, -0.07],
                    [x + half, y + half, top],
                    false,
                )
            })
    };
    let board = |name| Shape::new(name).with_box([-0.03, -0.03, -0.03], [0.03, 0.03, 0.03], false);
    // The tops of these legs lie 2 mm deep in the box.
    let mut sunk = legs(board("box on sunk legs"), -0.028, 0.006);
    sunk.volume -= 4.0 * 0.006 * 0.006 * 0.002;
    let table = legs(
        Shape::new("table").with_box([-0.05, -0.05, -0.02], [0.05, 0.05, 0.0], false),
        -0.02,
        0.008,
    );
    let mut halved = board("box with a wall");
    // A wall through the middle, with its corners on edges of the box.
    let first = u32::try_from(halved.vertices.len()).unwrap();
    for [x, y] in [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03]] {
        halved.vertices.push(Vector3::new(x, y, 0.01));
    }
    halved.polygons.push((first..first + 4).collect());
    // Polygons of nine corners, which can be divided in many ways.
    let mut prism = Shape::new("prism");
    let corner = |place: u32, z: f64| {
        let (sin, cos) = libm::sincos(TAU * f64::from(place) / 9.0);
        Vector3::new(0.03 * cos, 0.03 * sin, z)
    };
    for z in [0.0, 0.08] {
        prism.vertices.extend((0..9).map(|place| corner(place, z)));
    }
    prism
        .polygons
        .extend([(0..9).rev().collect(), (9..18).collect()]);
    for from in 0..9 {
        let to = (from + 1) % 9;
        prism.polygons.push(vec![from, to, to + 9, from + 9]);
    }
    prism.volume = 0.08 * 4.5 * 0.03 * 0.03 * libm::sin(TAU / 9.0);
    prism.filled = prism.volume;
    let mut shapes = vec![
        board("box"),
        prism,
        sunk,
        table,
        halved,
        board("hollow box").with_box([-0.02; 3], [0.02; 3], true),
        Shape::of_mesh("mug"),
        Shape::of_mesh("ball"),
        Shape::of_mesh("hammer"),
    ];
    // Off the axes, so that no coordinates are equal by chance.
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(1.0, 2.0, 0.5)), 0.7);
    for shape in &mut shapes {
        if !["table", "prism"].contains(&shape.name) {
            continue;
        }
        for vertex in &mut shape.vertices {
            *vertex = turn * *vertex;
        }
    }
    shapes
}

/// How faces are doubled.
#[derive(Debug, Clone, Copy)]
struct Damage {
    /// Share of the faces that are there twice.
    share: f64,
    /// Whether copies have the opposite direction, the same, or either.
    reversed: Option<bool>,
    /// Whether polygons of copies begin at another corner, so that they are divided along other diagonals.
    other_diagonals: bool,
    /// Whether each face has corners of its own.
    split: bool,
    /// Largest displacement of a corner, metres.
    jitter_m: f64,
    /// Share of the faces that are turned.
    flipped: f64,
}

fn damaged(shape: &Shape, damage: Damage, rng: &mut Rng) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut polygons: Vec<Vec<u32>> = Vec::new();
    let one = rng.random_range(0..shape.polygons.len());
    for (number, polygon) in shape.polygons.iter().enumerate() {
        let mut polygon = polygon.clone();
        if rng.random::<f64>() < damage.flipped {
            polygon.reverse();
        }
        let doubled = if damage.share == 0.0 {
            number == one
        } else {
            rng.random::<f64>() < damage.share
        };
        if doubled {
            let mut copy = polygon.clone();
            if damage.reversed.unwrap_or_else(|| rng.random()) {
                copy.reverse();
            }
            if damage.other_diagonals {
                copy.rotate_left(rng.random_range(0..polygon.len()));
            }
            let place = rng.random_range(0..=polygons.len());
            polygons.insert(place, copy);
        }
        polygons.push(polygon);
    }
    let mut vertices = shape.vertices.clone();
    if damage.split {
        let corners = polygons
            .iter()
            .flatten()
            .map(|&v| shape.vertices[v as usize]);
        vertices = corners.collect();
        let mut next = 0..;
        for corner in polygons.iter_mut().flatten() {
            *corner = next.next().unwrap();
        }
    }
    for coordinate in vertices.iter_mut().flat_map(|v| v.iter_mut()) {
        *coordinate += damage.jitter_m * rng.random_range(-1.0..1.0);
    }
    let fan = |polygon: &Vec<u32>| {
        let first = polygon[0];
        let rest = polygon[1..]
            .windows(2)
            .map(move |pair| [first, pair[0], pair[1]]);
        rest.collect::<Vec<_>>()
    };
    (vertices, polygons.iter().flat_map(fan).collect())
}

fn damages() -> Vec<Damage> {
    let mut damages = Vec::new();
    for share in [0.0, 0.5, 1.0] {
        for reversed in [Some(true), Some(false), None] {
            for (split, jitter_m) in [(false, 0.0), (true, 0.0), (true, 1e-9)] {
                for (other_diagonals, flipped) in [(false, 0.0), (true, 0.0), (true, 0.3)] {
                    damages.push(Damage {
                        share,
                        reversed,
                        other_diagonals,
                        split,
                        jitter_m,
                        flipped,
                    });
                }
            }
        }
    }
    damages
}

#[test]
fn doubled_faces_never_change_the_solid_in_silence() {
    let mut refused: Vec<String> = Vec::new();
    for (number, shape) in (0..).zip(shapes()) {
        for (at, damage) in (0..).zip(damages()) {
            // The larger meshes with every fifth damage only.
            if shape.polygons.len() > 100 && at % 5 != number % 5 {
                continue;
            }
            // Six faces of which some are turned would tell no cavity.
            let flipped = if shape.name == "hollow box" {
                0.0
            } else {
                damage.flipped
            };
            let damage = Damage { flipped, ..damage };
            let mut rng = stream(at, Task::Start, number);
            let (vertices, triangles) = damaged(&shape, damage, &mut rng);
            let told = format!("{} {damage:?}", shape.name);
            match Mesh::repaired(shape.name, vertices, triangles) {
                Err(error) => refused.push(format!("{told}: {error}")),
                Ok(Repaired { mesh, repairs }) => {
                    let nested = repairs.iter().any(|r| matches!(r, Repair::Nested { .. }));
                    let wanted = if nested { shape.filled } else { shape.volume };
                    let share = mesh.volume() / wanted;
                    assert!(
                        (share - 1.0).abs() < 0.01,
                        "{told}: {share} of the volume; {repairs:?}"
                    );
                    assert!(!repairs.is_empty(), "{told}: nothing is told");
                }
            }
        }
    }
    assert!(refused.is_empty(), "{refused:#?}");
}

/// A square of 100 mm, bent by a right angle in the middle. One of its triangles faces the other way.
fn angle() -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let row = |x: f64, z: f64| [0.0, 0.1].map(|y| Vector3::new(x, y, z));
    let vertices = [row(0.0, 0.0), row(0.05, 0.0), row(0.05, 0.05)].concat();
    (vertices, vec![[0, 2, 1], [2, 1, 3], [2, 4, 3], [3, 4, 5]])
}

#[test]
fn a_bent_sheet_becomes_a_wall_of_even_thickness() {
    let (vertices, triangles) = angle();
    let refused = Mesh::repaired("angle", vertices.clone(), triangles.clone());
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("angle is not closed") && refused.contains("--thickness 2"),
        "{refused}"
    );
    let once = triangles.iter().copied();
    let reversed = triangles.iter().map(|&[a, b, c]| [a, c, b]);
    let otherwise = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]].into_iter();
    let doubles: [Vec<[u32; 3]>; 3] = [
        once.clone().collect(),
        once.clone().chain(reversed).collect(),
        once.chain(otherwise).collect(),
    ];
    for triangles in doubles {
        let made = Mesh::thickened("angle", vertices.clone(), triangles, 0.004).unwrap();
        assert_eq!(made.repairs.last(), Some(&Repair::Thickened { sheets: 1 }));
        // Both halves are 50 mm wide in their middle.
        assert!((made.mesh.volume() / (0.004 * 0.1 * 0.1) - 1.0).abs() < 1e-3);
        let [low, high] = made.mesh.bounds();
        assert!(
            (low - Vector3::new(0.0, 0.0, -0.002)).norm() < 1e-5,
            "{low}"
        );
        assert!(
            (high - Vector3::new(0.052, 0.1, 0.05)).norm() < 1e-5,
            "{high}"
        );
    }
}

#[test]
fn faces_between_two_enclosed_rooms_are_left_out() {
    let corner = |x: f64, y: f64, z: f64| Vector3::new(x, y, z) * 0.03;
    let mut vertices = Vec::new();
    for z in [0.0, 1.0] {
        for y in [0.0, 1.0, 2.0] {
            for x in [0.0, 1.0, 2.0] {
                vertices.push(corner(x, y, z));
            }
        }
    }
    let cube = |x: u32, y: u32| -> Vec<[u32; 3]> {
        let at = |bits: u32| x + (bits & 1) + 3 * (y + (bits >> 1 & 1)) + 9 * (bits >> 2);
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]].map(|half| half.map(at));
        quads.into_iter().flat_map(halves).collect()
    };
    let beside = [cube(0, 0), cube(1, 0)].concat();
    let made = Mesh::repaired("rooms", vertices.clone(), beside).unwrap();
    assert!((made.mesh.volume() / (2.0 * 0.03_f64.powi(3)) - 1.0).abs() < 1e-9);
    assert!((made.mesh.area_m2() / (10.0 * 0.03_f64.powi(2)) - 1.0).abs() < 1e-9);
    assert!(
        made.repairs
            .iter()
            .any(|repair| matches!(repair, Repair::Walls { .. }))
    );
    // Of two boxes that meet at an edge only, one is inside out.
    let mut corners = cube(1, 1);
    for triangle in &mut corners {
        triangle.swap(1, 2);
    }
    let touching = [cube(0, 0), corners].concat();
    let made = Mesh::repaired("edge", vertices.clone(), touching).unwrap();
    assert!((made.mesh.volume() / (2.0 * 0.03_f64.powi(3)) - 1.0).abs() < 1e-9);
    assert_eq!(made.repairs, [Repair::InsideOut { pieces: 1 }]);
    // As they are meant to be, they stay as they are.
    let sound = [cube(0, 0), cube(1, 1)].concat();
    let made = Mesh::repaired("edge", vertices.clone(), sound.clone()).unwrap();
    assert_eq!(made.repairs, []);
    assert_eq!(made.mesh.triangles().len(), sound.len());
    assert!((made.mesh.volume() / (2.0 * 0.03_f64.powi(3)) - 1.0).abs() < 1e-9);
}

/// A surface whose faces are divided differently on both sides of its edges.
#[test]
fn corners_on_edges_of_other_faces_do_not_open_a_surface() {
    // A cube whose upper face is a fan about its middle with corners in the middles of its edges.
    let mut cube = Shape::new("cube").with_box([0.0; 3], [0.06; 3], false);
    let first = u32::try_from(cube.vertices.len()).unwrap();
    for [x, y] in [
        [0.03, 0.0],
        [0.06, 0.03],
        [0.03, 0.06],
        [0.0, 0.03],
        [0.03, 0.03],
    ] {
        cube.vertices.push(Vector3::new(x, y, 0.06));
    }
    cube.polygons
        .retain(|polygon| polygon.iter().any(|&corner| corner < 4));
    let ring = [4, first, 5, first + 1, 7, first + 2, 6, first + 3];
    for (place, &from) in ring.iter().enumerate() {
        cube.polygons
            .push(vec![from, ring[(place + 1) % 8], first + 4]);
    }
    for share in [0.0, 1.0] {
        let damage = Damage {
            share,
            reversed: Some(true),
            other_diagonals: true,
            split: true,
            jitter_m: 0.0,
            flipped: 0.2,
        };
        let (vertices, triangles) = damaged(&cube, damage, &mut stream(5, Task::Start, 1));
        let made = Mesh::repaired("cube", vertices, triangles).unwrap();
        assert!(
            (made.mesh.volume() / 0.06_f64.powi(3) - 1.0).abs() < 1e-6,
            "{:?}",
            made.repairs
        );
    }
}
