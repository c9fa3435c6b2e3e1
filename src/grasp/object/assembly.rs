//! Objects made of shapes given by formulae.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::space::Symmetry;

use super::{Description, Mesh, ObjectError, Primitive, Shape};

/// A shape, or the union of several.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Assembly {
    /// Name; that of the file where left out.
    pub name: Option<String>,
    /// Mass; from the volume at 500 kg/m³ where left out.
    pub mass_kg: Option<f64>,
    /// Motions that map the object onto itself; that of the shape where there is only one and this is left out.
    pub symmetry: Option<Symmetry>,
    /// The shapes; they may overlap.
    pub parts: Vec<Primitive>,
}

impl Assembly {
    /// Mesh and description: of one shape the formula itself, of several the mesh of their union. `name` is what errors call
    /// it.
    ///
    /// # Errors
    /// Where there is no part, or one has an impossible size.
    pub fn object(&self, name: &str) -> Result<(Mesh, Description), ObjectError> {
        if self.parts.is_empty() {
            return Err(ObjectError::Value {
                name: name.to_owned(),
                field: "parts",
                problem: "there is no [[parts]]: at least one shape is needed",
            });
        }
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for part in &self.parts {
            let mesh = part.mesh(name)?;
            let first = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            vertices.extend_from_slice(mesh.vertices());
            triangles.extend(
                mesh.triangles()
                    .iter()
                    .map(|t| t.map(|corner| corner + first)),
            );
        }
        let single = match self.parts[..] {
            [part] => Some(part),
            _ => None,
        };
        let symmetry = self.symmetry.clone().unwrap_or_else(|| match single {
            Some(Primitive::Sphere(ball)) => Symmetry::Sphere {
                centre: ball.centre,
            },
            Some(Primitive::Cylinder(cylinder)) => Symmetry::Axis {
                point: cylinder.centre,
                direction: cylinder.axis.into_inner(),
            },
            Some(Primitive::Capsule(capsule)) if capsule.a != capsule.b => Symmetry::Axis {
                point: capsule.a,
                direction: capsule.b - capsule.a,
            },
            _ => Symmetry::None,
        });
        let description = Description {
            name: self.name.clone(),
            mass_kg: self.mass_kg,
            symmetry,
            primitive: single,
        };
        let shapes: Vec<Arc<dyn Shape>> = self.parts.iter().map(|part| part.shape()).collect();
        let mesh = Mesh::of_pieces(name, vertices, triangles, Some(&shapes))?;
        Ok((mesh, description))
    }
}
