//! MJCF, the format of `MuJoCo`: bodies, joints and geoms. The reader follows `MuJoCo`'s documentation ("XML reference",
//! version 3) and was checked against its kinematics.
//!
//! It reads nested default classes, includes, bodies and frames, hinge and slide joints, primitives and meshes, linear
//! couplings (`equality/joint`, `equality/tendon`), closed loops (`equality/connect`, `equality/weld`) and pairs of bodies that
//! never collide. Elements that move nothing (actuators, sensors, inertias, options) are skipped. An unsupported element that
//! would change the hand is an error that names the element and its line.

mod body;
mod coupling;
mod defaults;
mod element;
mod geom;
mod mesh;
mod orientation;

use std::collections::BTreeMap;
use std::path::Path;

use super::model::Model;
use super::sources::Files;
use super::{Frame, HandError};
use defaults::Defaults;
use element::Element;
use mesh::MeshAsset;

/// The settings of `<compiler>`.
#[derive(Debug, Clone)]
struct Compiler {
    radians: bool,
    /// Axes of Euler angles: a lower-case axis turns with the body, an upper-case axis is fixed.
    euler_sequence: [char; 3],
    /// Whether a joint with a range is limited.
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
    /// Reads all `<compiler>` elements; later ones override earlier ones.
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

/// State that the readers of all elements share.
struct Reader<'a> {
    compiler: Compiler,
    defaults: Defaults<'a>,
    meshes: BTreeMap<String, MeshAsset<'a>>,
    files: &'a dyn Files,
    /// For each named site, its body and its frame there.
    sites: BTreeMap<String, (String, Frame)>,
    model: Model,
}

impl Reader<'_> {
    /// Adds a note unless it is there already.
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
        sites: BTreeMap::new(),
        model: Model {
            name: model_name(&root, name),
            ..Model::default()
        },
    };
    body::read_world(&mut reader, &root)?;
    coupling::read(&mut reader, &root)?;
    Ok(reader.model)
}

/// The name of the model; that of its file if it has none. `MuJoCo` writes its own default.
fn model_name(root: &Element, file: &str) -> String {
    let given = root.attribute("model");
    let name = given.filter(|name| !["", "MuJoCo Model"].contains(name));
    name.map_or_else(
        || {
            let stem = Path::new(file).file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        },
        str::to_owned,
    )
}

/// Whether a text is MJCF: its first element is `<mujoco>` or `<mujocoinclude>`.
pub(super) fn is_mjcf(text: &str) -> bool {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    loop {
        let after = if rest.starts_with("<!--") {
            "-->"
        } else if rest.starts_with("<?") {
            "?>"
        } else {
            return rest.starts_with("<mujoco");
        };
        let Some(end) = rest.find(after) else {
            return false;
        };
        rest = rest[end + after.len()..].trim_start();
    }
}
