//! Metadata of a grasp file: hand, objects, energy, settings. They suffice to make the file again.

use std::io::{Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::StoreError;

/// Version of the columns and metadata of this program.
pub const SCHEMA_VERSION: u64 = 1;

/// How a grasp file was made, and its hands and objects. It is stored as JSON under the Parquet metadata key `landscape`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Metadata {
    /// [`SCHEMA_VERSION`] of the program that wrote the file.
    pub schema_version: u64,
    /// Version of that program.
    pub program_version: String,
    /// The command line that makes the file again, in a folder that has its input files; empty if unknown.
    pub command: String,
    /// The input files of the command.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Source>,
    /// The commands that made the earlier versions of this file, before labels or outcomes of simulations were added; the
    /// oldest comes first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier: Vec<Step>,
    /// Seed of all random draws.
    pub seed: u64,
    /// The hands of the rows; nearly always one.
    pub hands: Vec<HandMetadata>,
    /// The objects of the rows; often one.
    pub objects: Vec<ObjectMetadata>,
    /// Terms, weights and constants of the energy.
    pub energy: serde_json::Value,
    /// All other settings.
    pub settings: serde_json::Value,
    /// The protocol of the column `stable` with all its numbers, and the models of the objects in it; null if nothing was
    /// simulated.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub stability: serde_json::Value,
    /// The version and the thresholds of the rule for the column `label_auto`; null if nothing was labelled.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub labels: serde_json::Value,
    /// Names of the energy terms, in the order of [`GraspRow::terms`](super::GraspRow::terms).
    pub terms: Vec<String>,
}

/// A command that made an earlier version of a file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Step {
    /// Version of the program.
    pub program_version: String,
    /// The command line.
    pub command: String,
    /// Its input files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Source>,
}

/// A hand, with the text from which it can be built again.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HandMetadata {
    /// Name in the column `hand`, for instance `human`.
    pub name: String,
    /// Names of the joints, in the order of the joint angles.
    pub joint_names: Vec<String>,
    /// Lower and upper limit of each joint, radians; metres for sliding joints; infinite (null in JSON) if there is none.
    #[serde(with = "limits")]
    pub limits: Vec<[f64; 2]>,
    /// Number of surface points. Contacts are indices of these points.
    pub surface_points: usize,
    /// [`content_hash`] of the surface points, rounded to micrometres.
    pub surface_hash: String,
    /// Description file and the files that belong to it.
    pub description: Vec<TextFile>,
    /// [`content_hash`] of everything the hand was built from.
    pub content_hash: String,
    /// What was left out of the description, changed or doubted when it was read, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl HandMetadata {
    /// The notes as warnings that name the hand.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let told = |note| format!("hand {}: {note}", self.name);
        self.notes.iter().map(told)
    }

    /// Whether both describe the same hand with the same surface points.
    pub fn is_same_hand(&self, other: &Self) -> bool {
        self.content_hash == other.content_hash && self.surface_hash == other.surface_hash
    }
}

/// A complete text file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TextFile {
    /// File name, without folder.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// An object at scale 1.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectMetadata {
    /// Name in the column `object`, for instance `bottle`.
    pub name: String,
    /// Properties that are not in the mesh (symmetry, mass, formula), as the `object` module writes them.
    pub description: serde_json::Value,
    /// Mass, kilograms.
    pub mass_kg: f64,
    /// Its mesh as Wavefront OBJ text, metres (deflated, base64 in JSON); `None` if only `content_hash` is known.
    #[serde(with = "packed")]
    pub mesh_obj: Option<String>,
    /// [`content_hash`] of everything the object was built from.
    pub content_hash: String,
}

impl Metadata {
    /// Records that this version of the program makes the file with `command` from `inputs`. The previous command becomes
    /// the last of [`Metadata::earlier`].
    pub fn remade_by(&mut self, command: &str, inputs: Vec<Source>) {
        let before = Step {
            program_version: std::mem::replace(
                &mut self.program_version,
                env!("CARGO_PKG_VERSION").to_owned(),
            ),
            command: std::mem::replace(&mut self.command, command.to_owned()),
            inputs: std::mem::replace(&mut self.inputs, inputs),
        };
        if !before.command.is_empty() {
            self.earlier.push(before);
        }
    }

    /// The metadata as JSON for the file.
    pub(super) fn to_json(&self, path: &Path) -> Result<String, StoreError> {
        self.check(path)?;
        serde_json::to_string(self).map_err(|error| bad(path, error.to_string()))
    }

    /// Reads the output of [`Metadata::to_json`]. `path` is named in errors.
    pub(super) fn from_json(path: &Path, text: &str) -> Result<Self, StoreError> {
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|error| bad(path, error.to_string()))?;
        check_version(path, &value)?;
        let metadata: Self =
            serde_json::from_value(value).map_err(|error| bad(path, error.to_string()))?;
        metadata.check(path)?;
        Ok(metadata)
    }

    /// Checks conditions that the types do not guarantee.
    pub(super) fn check(&self, path: &Path) -> Result<(), StoreError> {
        for hand in &self.hands {
            if hand.joint_names.len() != hand.limits.len() {
                let [names, limits] = [hand.joint_names.len(), hand.limits.len()];
                return Err(bad(
                    path,
                    format!(
                        "hand `{}` has {names} joints but {limits} limits",
                        hand.name
                    ),
                ));
            }
        }
        let repeated = first_repeated(self.terms.iter().map(String::as_str))
            .or_else(|| first_repeated(self.hands.iter().map(|hand| hand.name.as_str())))
            .or_else(|| first_repeated(self.objects.iter().map(|object| object.name.as_str())));
        match repeated {
            Some(name) => Err(bad(path, format!("`{name}` is named twice"))),
            None => Ok(()),
        }
    }
}

/// Accepts the known schema version only.
pub(super) fn check_version(path: &Path, value: &serde_json::Value) -> Result<(), StoreError> {
    match value["schema_version"].as_u64() {
        None => Err(bad(path, "`schema_version` is missing".to_owned())),
        Some(SCHEMA_VERSION) => Ok(()),
        Some(found) => Err(StoreError::SchemaVersion {
            path: path.to_path_buf(),
            found,
            known: SCHEMA_VERSION,
        }),
    }
}

pub(super) fn bad(path: &Path, reason: String) -> StoreError {
    StoreError::Metadata {
        path: path.to_path_buf(),
        reason,
    }
}

fn first_repeated<'a>(names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = std::collections::BTreeSet::new();
    names.into_iter().find(|name| !seen.insert(*name))
}

/// Identifies content: 128-bit FNV-1a over the parts and their lengths, as 32 hexadecimal digits. It detects accidents but
/// not forgery.
///
/// ```
/// use landscape::store::content_hash;
///
/// assert_ne!(content_hash(&[b"ab", b"c"]), content_hash(&[b"a", b"bc"]));
/// assert_eq!(content_hash(&[]), "6c62272e07bb014262b821756295c58d");
/// ```
pub fn content_hash(parts: &[&[u8]]) -> String {
    let hash = parts.iter().fold(FNV_BASIS, |hash, part| {
        fnv1a(fnv1a(hash, &(part.len() as u64).to_le_bytes()), part)
    });
    format!("{hash:032x}")
}

/// Offset basis and prime of 128-bit FNV-1a: <http://www.isthe.com/chongo/tech/comp/fnv/>.
const FNV_BASIS: u128 = 0x6c62272e07bb014262b821756295c58d;
const FNV_PRIME: u128 = 0x0000000001000000000000000000013b;

fn fnv1a(hash: u128, bytes: &[u8]) -> u128 {
    bytes.iter().fold(hash, |hash, byte| {
        (hash ^ u128::from(*byte)).wrapping_mul(FNV_PRIME)
    })
}

/// JSON has no infinity, so a missing limit is null.
mod limits {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(
        limits: &[[f64; 2]],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let finite = |limit: f64| limit.is_finite().then_some(limit);
        limits
            .iter()
            .map(|pair| pair.map(finite))
            .collect::<Vec<_>>()
            .serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<[f64; 2]>, D::Error> {
        let pairs = Vec::<[Option<f64>; 2]>::deserialize(deserializer)?;
        let open = |[lower, upper]: [Option<f64>; 2]| {
            [
                lower.unwrap_or(f64::NEG_INFINITY),
                upper.unwrap_or(f64::INFINITY),
            ]
        };
        Ok(pairs.into_iter().map(open).collect())
    }
}

/// Long text, deflated and base64-encoded.
mod packed {
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use flate2::Compression;
    use flate2::read::ZlibDecoder;
    use flate2::write::ZlibEncoder;
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Read, Write};

    /// Largest size of an unpacked text, bytes, because a few packed bytes can claim to be many.
    const LARGEST: u64 = 256 << 20;

    #[expect(
        clippy::ref_option,
        reason = "serde hands over a reference to the field"
    )]
    pub(super) fn serialize<S: Serializer>(
        text: &Option<String>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let pack = |text: &String| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
            encoder
                .write_all(text.as_bytes())
                .and_then(|()| encoder.finish())
                .map(|bytes| STANDARD.encode(bytes))
        };
        text.as_ref()
            .map(pack)
            .transpose()
            .map_err(S::Error::custom)?
            .serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<String>, D::Error> {
        let Some(packed) = Option::<String>::deserialize(deserializer)? else {
            return Ok(None);
        };
        let bytes = STANDARD.decode(packed).map_err(D::Error::custom)?;
        let mut text = String::new();
        ZlibDecoder::new(bytes.as_slice())
            .take(LARGEST + 1)
            .read_to_string(&mut text)
            .map_err(D::Error::custom)?;
        if text.len() as u64 > LARGEST {
            return Err(D::Error::custom("a mesh is larger than 256 MB"));
        }
        Ok(Some(text))
    }
}

/// The input of a landscape.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Source {
    /// File name, without folder.
    pub name: String,
    /// [`content_hash`](super::content_hash) of its bytes.
    pub content_hash: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_matches_published_vectors() {
        assert_eq!(
            format!("{:032x}", fnv1a(FNV_BASIS, b"a")),
            "d228cb696f1a8caf78912b704e4a8964"
        );
        assert_eq!(
            format!("{:032x}", fnv1a(FNV_BASIS, b"foobar")),
            "343e1662793c64bf6f0d3597ba446f18"
        );
    }

    #[test]
    fn json_keeps_every_bit_and_open_limits() {
        let hand = HandMetadata {
            joint_names: vec!["a".into(), "b".into()],
            limits: vec![[-0.1 - 0.2, 1.0 / 3.0], [f64::NEG_INFINITY, f64::INFINITY]],
            ..HandMetadata::default()
        };
        let text = serde_json::to_string(&hand).unwrap();
        assert!(text.contains("[null,null]"));
        assert_eq!(serde_json::from_str::<HandMetadata>(&text).unwrap(), hand);
        // Without its feature `float_roundtrip`, serde_json misreads a tenth of all doubles, 0.3 − 0.1 among them.
        for value in [
            5.0e-324,
            1.7976931348623157e308,
            2.2250738585072014e-308,
            0.3 - 0.1,
            8.41e21,
        ] {
            let object = ObjectMetadata {
                mass_kg: value,
                ..ObjectMetadata::default()
            };
            let text = serde_json::to_string(&object).unwrap();
            assert_eq!(
                serde_json::from_str::<ObjectMetadata>(&text)
                    .unwrap()
                    .mass_kg
                    .to_bits(),
                value.to_bits()
            );
        }
    }

    #[test]
    fn mesh_is_packed() {
        let mesh_obj = Some("v 0 0 0\n".repeat(1000));
        let object = ObjectMetadata {
            mesh_obj,
            ..ObjectMetadata::default()
        };
        let text = serde_json::to_string(&object).unwrap();
        assert!(text.len() < 400, "{text}");
        assert_eq!(
            serde_json::from_str::<ObjectMetadata>(&text).unwrap(),
            object
        );
    }
}
