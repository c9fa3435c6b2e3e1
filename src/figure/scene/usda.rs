//! A scene as USD text.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::{Scene, Surface};
use crate::figure::MAKER;

impl Scene {
    /// The scene as a `.usda` file in metres with z up: the prims `/grasp/hand`, `/grasp/object` and `/grasp/contact_0`, ….
    /// Friction cones are omitted.
    pub fn to_usda(&self) -> String {
        let mut text = format!(
            "#usda 1.0\n(\n    customLayerData = {{\n        string generator = \"Made by {MAKER}\"\n    }}\n    \
             defaultPrim = \"grasp\"\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n\ndef Xform \"grasp\"\n{{\n"
        );
        let names = ["hand", "object"];
        for (place, surface) in self.surfaces.iter().enumerate() {
            let name = names
                .get(place)
                .map_or_else(|| format!("surface_{place}"), ToString::to_string);
            mesh(&mut text, &name, surface);
        }
        for (place, marker) in self.markers.iter().enumerate() {
            let _ = write!(
                text,
                "    def Sphere \"contact_{place}\"\n    {{\n        double radius = {}\n        double3 xformOp:translate = {}\n        \
                 uniform token[] xformOpOrder = [\"xformOp:translate\"]\n        {}    }}\n",
                marker.radius_m,
                point(&marker.centre),
                colour(marker.colour)
            );
        }
        text.push_str("}\n");
        text
    }
}

fn mesh(text: &mut String, name: &str, surface: &Surface) {
    let three = vec!["3"; surface.triangles.len()].join(", ");
    let corners = surface.triangles.iter().flatten();
    let corners: Vec<String> = corners.map(ToString::to_string).collect();
    let points: Vec<String> = surface.vertices.iter().map(point).collect();
    let _ = write!(
        text,
        "    def Mesh \"{name}\"\n    {{\n        int[] faceVertexCounts = [{three}]\n        int[] faceVertexIndices = [{}]\n        \
         point3f[] points = [{}]\n        uniform token subdivisionScheme = \"none\"\n        {}    }}\n",
        corners.join(", "),
        points.join(", "),
        colour(surface.colour)
    );
}

fn point(point: &Vector3<f64>) -> String {
    let [x, y, z] = [point.x, point.y, point.z].map(|x| x + 0.0);
    format!("({x}, {y}, {z})")
}

/// USD has linear colours.
fn colour(colour: [u8; 3]) -> String {
    let linear = |byte: u8| {
        let value = f64::from(byte) / 255.0;
        if value <= 0.04045 {
            value / 12.92
        } else {
            libm::pow((value + 0.055) / 1.055, 2.4)
        }
    };
    let [red, green, blue] = colour.map(linear);
    format!("color3f[] primvars:displayColor = [({red:.4}, {green:.4}, {blue:.4})]\n")
}
