//! MJCF, the format of `MuJoCo`: bodies, joints and geoms, after its documentation ("XML reference", version 3) and checked
//! against its kinematics.
//!
//! Read: nested default classes, includes, bodies and frames, hinge and slide joints, primitives and meshes, linear
//! couplings (`equality/joint`, `equality/tendon`), pairs of bodies that never collide. What moves nothing (actuators,
//! sensors, inertias, options) is skipped; what would change the hand and is not read is an error that names the element
//! and its line.

mod body;
mod coupling;
mod defaults;
mod element;
mod geom;
mod mesh;
mod orientation;

use std::collections::BTreeMap;

use super::HandError;
use super::files::Files;
use super::model::Model;
use defaults::Defaults;
use element::Element;
use mesh::MeshAsset;

/// What `<compiler>` says.
#[derive(Debug, Clone)]
struct Compiler {
    radians: bool,
    /// Axes of Euler angles: lower case turns with the body, upper case stays.
    euler_sequence: [char; 3],
    /// Whether a range alone makes a joint limited.
    auto_limits: bool,
    mesh_folder: String,
    strip_path: bool,
}

impl Default for Compiler {
    fn default() -> Self {
        Self {
            radians: false,
            euler_sequence: ['x', 'y', 'z'],
            auto_limits: true,
            mesh_folder: String::new(),
            strip_path: false,
        }
    }
}

impl Compiler {
    /// Takes over what all `<compiler>` elements say, the later ones last.
    fn of(root: &Element) -> Result<Self, HandError> {
        let mut compiler = Self::default();
        let (mut assets, mut meshes) = (None, None);
        for element in root.children_named("compiler") {
            if let Some(angle) = element.attribute("angle") {
                compiler.radians = match angle {
                    "radian" => true,
                    "degree" => false,
                    other => {
                        return Err(
                            element.error(format!("angle=\"{other}\": degree or radian is needed"))
                        );
                    }
                };
            }
            if let Some(sequence) = element.attribute("eulerseq") {
                let axes: Vec<char> = sequence.chars().collect();
                compiler.euler_sequence = <[char; 3]>::try_from(axes)
                    .ok()
                    .filter(|axes| axes.iter().all(|axis| "xyzXYZ".contains(*axis)))
                    .ok_or_else(|| {
                        element.error(format!(
                            "eulerseq=\"{sequence}\": three of x, y, z are needed"
                        ))
                    })?;
            }
            compiler.auto_limits = element.flag("autolimits", compiler.auto_limits)?;
            compiler.strip_path = element.flag("strippath", compiler.strip_path)?;
            if element.attribute("coordinate") == Some("global") {
                return Err(element.error(
                    "global coordinates, which MuJoCo gave up in version 2.3.4, are not read",
                ));
            }
            assets = element.attribute("assetdir").or(assets);
            meshes = element.attribute("meshdir").or(meshes);
        }
        meshes
            .or(assets)
            .unwrap_or_default()
            .clone_into(&mut compiler.mesh_folder);
        Ok(compiler)
    }
}

/// Everything the readers of the single elements share.
struct Reader<'a> {
    compiler: Compiler,
    defaults: Defaults<'a>,
    meshes: BTreeMap<String, MeshAsset<'a>>,
    files: &'a dyn Files,
    model: Model,
}

impl Reader<'_> {
    /// Notes each thing once.
    fn note(&mut self, note: String) {
        if !self.model.notes.contains(&note) {
            self.model.notes.push(note);
        }
    }
}

pub(super) fn read(name: &str, text: &str, files: &dyn Files) -> Result<Model, HandError> {
    let root = element::read(name, text, files)?;
    let compiler = Compiler::of(&root)?;
    let defaults = Defaults::of(&root)?;
    let meshes = mesh::list(&root, &defaults)?;
    let mut reader = Reader {
        compiler,
        defaults,
        meshes,
        files,
        model: Model {
            name: root.attribute("model").unwrap_or("MuJoCo Model").to_owned(),
            ..Model::default()
        },
    };
    body::read_world(&mut reader, &root)?;
    coupling::read(&mut reader, &root)?;
    Ok(reader.model)
}
