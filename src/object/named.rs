//! The built-in objects.

use super::{Description, Object, ObjectError};
use crate::mesh::Mesh;

/// Names for [`Object::named`].
pub const OBJECT_NAMES: [&str; EMBEDDED.len()] = {
    let mut names = [""; EMBEDDED.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = EMBEDDED[index].name;
        index += 1;
    }
    names
};

struct Embedded {
    name: &'static str,
    obj: &'static str,
    json: &'static str,
}

macro_rules! embedded {
    ($($name:literal),* $(,)?) => {
        [$(Embedded {
            name: $name,
            obj: include_str!(concat!("../../data/objects/", $name, ".obj")),
            json: include_str!(concat!("../../data/objects/", $name, ".json")),
        }),*]
    };
}

const EMBEDDED: [Embedded; 15] = embedded![
    "ball",
    "bottle_flask",
    "bottle_medicine",
    "bottle_round",
    "bottle_square",
    "bottle_squeeze",
    "bottle_water",
    "bowl",
    "box",
    "can",
    "disk",
    "hammer",
    "jar",
    "mug",
    "pen",
];

impl Object {
    /// A built-in object: one of [`OBJECT_NAMES`].
    ///
    /// # Errors
    /// If no object has this name.
    pub fn named(name: &str) -> Result<Self, ObjectError> {
        let (mesh, description) = Self::parts_of_named(name)?;
        Self::from_mesh(name, mesh, &description)
    }

    /// Mesh and description of a built-in object. Nothing is baked.
    ///
    /// # Errors
    /// If no object has this name.
    pub fn parts_of_named(name: &str) -> Result<(Mesh, Description), ObjectError> {
        let Some(embedded) = EMBEDDED.iter().find(|embedded| embedded.name == name) else {
            return Err(ObjectError::Unknown {
                name: name.to_owned(),
                known: OBJECT_NAMES.join(", "),
            });
        };
        let mesh = Mesh::from_obj(name, &mut embedded.obj.as_bytes())?;
        Ok((mesh, Description::from_json(name, embedded.json)?))
    }
}
