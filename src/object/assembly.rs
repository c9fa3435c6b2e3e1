//! Objects made of primitives.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::space::Symmetry;

use super::{Description, ObjectError, ObjectParts, Primitive};
use crate::mesh::Mesh;

/// Largest number of different shapes in an object; larger objects should be given as meshes.
const MOST_PARTS: usize = 500;

/// A union of one or more primitives.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Assembly {
    /// Name. Default: the name of the file.
    pub name: Option<String>,
    /// Mass. Default: that of the volume at 500 kg/m³.
    pub mass_kg: Option<f64>,
    /// Motions that map the object onto itself. Default: those of the shape if there is only one.
    pub symmetry: Option<Symmetry>,
    /// The shapes. They may overlap, and duplicates count once.
    pub parts: Vec<Primitive>,
}

impl Assembly {
    /// Reads a TOML file of shapes.
    pub(super) fn read(path: &Path) -> Result<ObjectParts, ObjectError> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| ObjectError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        let assembly: Self =
            crate::formats::toml_text::parse(&text).map_err(|source| ObjectError::Shapes {
                name: name.clone(),
                source,
            })?;
        let (mesh, description) = assembly.object(&name)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok(ObjectParts {
            name: assembly.name.unwrap_or_else(|| stem.into_owned()),
            mesh,
            notes: Vec::new(),
            description,
        })
    }

    /// Mesh and description. A single shape keeps its formula; several shapes give the mesh of their union. `name` is the
    /// name of the object in errors.
    ///
    /// # Errors
    /// If there is no part, there are more than 500 parts, or a part has an impossible size.
    pub fn object(&self, name: &str) -> Result<(Mesh, Description), ObjectError> {
        let refuse = |problem: &'static str| ObjectError::Value {
            name: name.to_owned(),
            field: "parts",
            problem,
        };
        let mut parts: Vec<Primitive> = Vec::new();
        for part in &self.parts {
            if !parts.contains(part) {
                parts.push(*part);
            }
            if parts.len() > MOST_PARTS {
                return Err(refuse(
                    "there are more than 500 shapes: give the object as a mesh",
                ));
            }
        }
        if parts.is_empty() {
            return Err(refuse(
                "there is no [[parts]]: at least one shape is needed",
            ));
        }
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for part in &parts {
            let mesh = part.mesh(name)?;
            let first = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
            vertices.extend_from_slice(mesh.vertices());
            triangles.extend(
                mesh.triangles()
                    .iter()
                    .map(|t| t.map(|corner| corner + first)),
            );
        }
        let single = match parts[..] {
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
            parts: match single {
                Some(_) => Vec::new(),
                None => parts,
            },
        };
        let mesh = description.mesh(name, vertices, triangles)?;
        Ok((mesh, description))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::object::{Object, Sphere};

    /// Found by fuzzing: each of six thousand copies was cut along all others.
    #[test]
    fn shapes_count_once_and_are_not_too_many() {
        let ball = |x_m: f64| {
            Primitive::Sphere(Sphere {
                centre: Vector3::new(x_m, 0.0, 0.0),
                radius_m: 0.03,
            })
        };
        let mut assembly = Assembly {
            parts: vec![ball(0.0); 10_000],
            ..Assembly::default()
        };
        let (_, description) = assembly.object("ball").unwrap();
        assert_eq!(description.primitive, Some(ball(0.0)));
        assembly.parts = (0..501).map(|i| ball(f64::from(i))).collect();
        let refused = assembly.object("balls").unwrap_err();
        assert!(refused.to_string().contains("500"), "{refused}");
    }

    #[test]
    fn formulae_go_with_the_mesh_of_a_union() {
        let ball = |x: f64| Sphere {
            centre: Vector3::new(x, 0.0, 0.0),
            radius_m: 0.03,
        };
        let assembly = Assembly {
            parts: vec![
                Primitive::Sphere(ball(-0.02)),
                Primitive::Sphere(ball(0.02)),
            ],
            ..Assembly::default()
        };
        let (mesh, description) = assembly.object("pair").unwrap();
        let text = serde_json::to_string(&description).unwrap();
        let mut read = Description::from_json("pair", &text).unwrap();
        assert_eq!(read, description);
        let again = read.mesh_of_obj("pair", &mesh.to_obj()).unwrap();
        // A cap 0.01 high is cut away from each of the balls.
        let area_m2 = 4.0 * std::f64::consts::PI * 0.03 * (2.0 * 0.03 - 0.01);
        for (mesh, scale) in [
            (&mesh, 1.0),
            (&again, 1.0),
            (&again.scaled("pair", 2.0).unwrap(), 2.0),
        ] {
            let share = mesh.area_m2() / (area_m2 * scale * scale);
            assert!((share - 1.0).abs() < 0.01, "{share}");
        }
        Object::from_mesh("pair", again.clone(), &read).unwrap();
        read.parts[1] = Primitive::Sphere(ball(0.03));
        let refused = Object::from_mesh("pair", again, &read).unwrap_err();
        assert!(
            refused.to_string().contains("a union of shapes"),
            "{refused}"
        );
    }
}
