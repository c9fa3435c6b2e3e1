//! Exports the data with which another engine repeats the drop test: `crosscheck_export GRASPS.parquet FOLDER`
//!
//! The program writes the convex pieces of each object (`<object>_<piece>.obj`, and `<object>.obj` with all of them;
//! metres, object frame) and `grasps.json`: mass properties, and for each grasp the posed capsules of the hand and the
//! outcome of our simulation.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::evaluation::stability::{Build, Drop, Piece, Protocol, Solid, Solver, simulate};
use landscape::hand::PosedHand;
use landscape::store::{GraspFile, Overrides};
use rayon::prelude::*;
use serde_json::json;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [grasps, folder] = arguments.as_slice() else {
        return Err("usage: crosscheck_export GRASPS.parquet FOLDER".into());
    };
    let folder = Path::new(folder);
    fs::create_dir_all(folder)?;
    let (file, _) = GraspFile::read(Path::new(grasps), Overrides::default())?;
    let protocol = Drop::default();
    let mut populations = Vec::new();
    for population in file.landscapes() {
        let name = &population.object.name;
        let hand = population.hand()?;
        let (mesh, mass_kg) = population.mesh()?;
        let solid = Solid::new(&mesh, Build::Pieces);
        let mut pieces = Vec::new();
        let (mut all, mut vertices) = (String::new(), 0);
        for (number, piece) in solid.pieces().iter().enumerate() {
            let piece_name = format!("{name}_{number}.obj");
            fs::write(folder.join(&piece_name), obj_text(piece, 0))?;
            let _ = writeln!(all, "o {number}");
            all += &obj_text(piece, vertices);
            vertices += u32::try_from(piece.vertices.len())?;
            pieces.push(piece_name);
        }
        let all_pieces = format!("{name}.obj");
        fs::write(folder.join(&all_pieces), all)?;
        let of_grasp = |grasp: &&landscape::store::GraspRow| {
            let mut posed = PosedHand::default();
            hand.pose(&grasp.grasp.pose, &mut posed);
            let capsules: Vec<_> = hand
                .capsules
                .iter()
                .zip(&posed.capsules)
                .map(|(capsule, [a, b])| {
                    json!({ "link": hand.links[capsule.link.0].name, "a": a, "b": b, "radius_m": capsule.radius_m })
                })
                .collect();
            let drop = Protocol::Drop(protocol);
            let outcome = simulate(&hand, &grasp.grasp, None, &solid, mass_kg, &drop);
            json!({ "id": grasp.id, "capsules": capsules, "outcome": outcome })
        };
        let grasps: Vec<_> = population.grasps.par_iter().map(of_grasp).collect();
        populations.push(json!({
            "object": name,
            "pieces": pieces,
            "all_pieces": all_pieces,
            "mass_kg": mass_kg,
            "centre_m": solid.centre(),
            "inertia_kg_m2": solid.unit_inertia() * mass_kg,
            "grasps": grasps,
        }));
    }
    let contact =
        json!({ "frequency_hz": Solver::CONTACT_FREQUENCY_HZ, "damping": Solver::CONTACT_DAMPING });
    let all = json!({ "protocol": protocol, "contact": contact, "populations": populations });
    fs::write(folder.join("grasps.json"), serde_json::to_string(&all)?)?;
    Ok(())
}

/// `before`: number of vertices that are already in the file.
fn obj_text(piece: &Piece, before: u32) -> String {
    let mut text = String::new();
    for v in &piece.vertices {
        let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
    }
    for corners in &piece.triangles {
        let [a, b, c] = corners.map(|corner| before + corner + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
