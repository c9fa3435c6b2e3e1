//! Makes the built-in objects → `data/objects/*.obj` and `*.json`, and a picture of them → `figures/objects.png`.
//!
//! Most objects are turned: a profile is swept about the z axis. Every object stands on z = 0. Lengths are in metres.

use std::fs;
use std::path::Path;

use ball::ball;
use carton::carton;
use hammer::hammer;
use landscape::figure::{Scene, Surface, contact_sheet};
use landscape::mesh::Mesh;
use landscape::object::Description;
use lathe::{ROUND, Section, Turned};
use mug::mug;
use nalgebra::Vector3;

mod ball;
mod carton;
mod hammer;
mod lathe;
mod mug;
mod parts;
mod tube;

const TURNED: [Turned; 11] = [
    Turned {
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
    Turned {
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
    Turned {
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
    Turned {
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
    Turned {
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
    Turned {
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
    Turned {
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
    Turned {
        name: "bowl",
        mass_kg: 0.31,
        profile: &[
            [30.0, 0.0, 3.0],
            [58.0, 22.0, 40.0],
            [72.0, 62.0, 2.4],
            [66.7, 62.0, 2.4],
            [53.8, 25.0, 34.0],
            [29.5, 6.0, 20.0],
        ],
        section: ROUND,
    },
    Turned {
        name: "can",
        mass_kg: 0.36,
        profile: &[
            [26.0, 0.0, 3.0],
            [33.0, 9.0, 6.0],
            [33.0, 101.0, 8.0],
            [27.5, 112.0, 2.0],
            [27.5, 116.0, 1.5],
        ],
        section: ROUND,
    },
    Turned {
        name: "disk",
        mass_kg: 0.04,
        profile: &[[50.0, 0.0, 2.5], [50.0, 8.0, 2.5]],
        section: ROUND,
    },
    Turned {
        name: "pen",
        mass_kg: 0.011,
        profile: &[
            [1.0, 0.0, 0.6],
            [4.5, 24.0, 14.0],
            [5.2, 75.0, 90.0],
            [5.0, 142.0, 2.5],
        ],
        section: ROUND,
    },
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("data/objects");
    fs::create_dir_all(&folder)?;
    let mut made: Vec<(&str, Mesh, Description)> = Vec::new();
    for turned in &TURNED {
        made.push((turned.name, turned.mesh()?, turned.description()));
    }
    made.extend([ball()?, carton()?, hammer()?, mug()?]);
    made.sort_by_key(|(name, ..)| *name);
    let (mut images, mut captions) = (Vec::new(), Vec::new());
    for (name, mesh, description) in made {
        fs::write(folder.join(format!("{name}.obj")), mesh.to_obj())?;
        fs::write(
            folder.join(format!("{name}.json")),
            serde_json::to_string_pretty(&description)? + "\n",
        )?;
        let size_mm = (mesh.bounds()[1] - mesh.bounds()[0]) * 1e3;
        let size = format!("{:.0} × {:.0} × {:.0} mm", size_mm.x, size_mm.y, size_mm.z);
        let mass_kg = description.mass_kg.unwrap_or_default();
        println!(
            "{name}: {} triangles, {size}, {:.0} ml, {mass_kg} kg",
            mesh.triangles().len(),
            mesh.volume() * 1e6,
        );
        let scene = Scene {
            surfaces: vec![Surface::of_mesh(&mesh)],
            ..Scene::default()
        };
        let camera = scene.framed(Vector3::new(0.55, -1.0, 0.6), Vector3::z());
        images.push(scene.render(&camera, 300, 300));
        captions.push(name.to_owned());
    }
    contact_sheet(&images, &captions, 5, &root.join("figures/objects.png"))?;
    Ok(())
}
