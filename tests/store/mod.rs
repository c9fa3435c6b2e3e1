//! Files: round trips, equal bytes, the message of every refusal, and kills at any moment.
#![expect(
    clippy::float_cmp,
    reason = "what is stored must come back bit for bit"
)]

mod grasps;
mod journals;
mod landscapes;
mod refusals;
mod sums;
mod writing;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::folder::names;
use crate::parts::Parts;
use landscape::grasp::Grasp;
use landscape::space::Pose;
use landscape::store::{
    Counts, EdgeRow, GraspFile, GraspRow, HandMetadata, LandscapeFiles, Manifest, Metadata,
    MinimumRow, ObjectMetadata, Overrides, PathPoint, SCHEMA_VERSION, Source, Step, StoreError,
    TextFile, Warning,
};
use serde_json::json;
use tempfile::TempDir;

fn hand() -> HandMetadata {
    HandMetadata {
        name: "two fingers".into(),
        joint_names: vec!["left".into(), "right".into()],
        limits: vec![[-0.3, 1.0 / 3.0], [f64::NEG_INFINITY, f64::INFINITY]],
        surface_points: 40,
        surface_hash: "4567".into(),
        description: vec![TextFile {
            name: "hand.urdf".into(),
            text: "<robot name=\"ü\"/>\n".into(),
        }],
        content_hash: "0123".into(),
        notes: vec!["joint \"left\" turns without limits".into()],
    }
}

fn object(name: &str) -> ObjectMetadata {
    ObjectMetadata {
        name: name.into(),
        description: json!({ "axis": [0.1 + 0.2, 0.0, 1.0] }),
        mass_kg: 0.1 + 0.7,
        mesh_obj: Some("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()),
        content_hash: "4567".into(),
    }
}

fn grasp(id: u64) -> GraspRow {
    let half = 0.1 * id as f64;
    GraspRow {
        id,
        object: "cup".into(),
        scale: 1.0,
        hand: "two fingers".into(),
        grasp: Grasp::new(
            Pose::new(
                [0.1 * half, -1.0 / 3.0, f64::MIN_POSITIVE],
                [libm::cos(half), libm::sin(half), 0.0, 0.0],
                &[0.2, -7.0],
            ),
            vec![39, 0, 7],
        ),
        squeeze_joints: Some(vec![0.25, -7.5]),
        energy: 0.7,
        terms: vec![0.3, 0.4],
        net_wrench: 1e-300,
        distance_squared: 0.25,
        penetration: 0.0,
        friction: Some(0.5),
        epsilon: Some(0.05),
        stable: Some(true),
        stable_reason: Some("held".into()),
        stable_displacement_m: Some(0.001),
        stable_turn_rad: Some(0.02),
        label: Some("medium wrap".into()),
        label_auto: Some("precision disk".into()),
        label_score: Some(0.9),
        label_best: Some("Precision Disk (likely), Precision Sphere".into()),
        label_category: Some("power".into()),
        label_source: Some("human".into()),
        source: "synthesis".into(),
        chain_seed: u64::MAX,
        chain_step: 9999,
    }
}

/// The pose with other joints.
fn with_joints(pose: &Pose, joints: &[f64]) -> Pose {
    let translation_m = std::array::from_fn(|k| pose[k]);
    Pose::new(translation_m, pose.rotation_wxyz(), joints)
}

fn source(name: &str) -> Source {
    Source {
        name: name.into(),
        content_hash: "6c62272e07bb014262b821756295c58d".into(),
    }
}

fn file(count: u64) -> GraspFile {
    let metadata = Metadata {
        schema_version: SCHEMA_VERSION,
        program_version: "0.1.0".into(),
        command: "landscape synth --hand two".into(),
        inputs: vec![source("two.urdf")],
        earlier: vec![Step {
            program_version: "0.0.9".into(),
            command: "landscape import old.csv".into(),
            inputs: vec![source("old.csv")],
        }],
        seed: u64::MAX,
        hands: vec![hand()],
        objects: vec![object("cup"), object("bowl")],
        energy: json!({ "weights": [0.1, 1e-7, 3.3333333333333335] }),
        settings: json!({ "steps": 10000 }),
        stability: json!({ "protocol": "drop" }),
        labels: json!({ "rule": "0" }),
        terms: vec!["force_closure".into(), "distance".into()],
    };
    GraspFile {
        metadata,
        grasps: (0..count).map(grasp).collect(),
    }
}

/// A folder for one test and a path in it.
fn place(name: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn read(path: &Path) -> Result<(GraspFile, Vec<Warning>), StoreError> {
    GraspFile::read(path, Overrides::default())
}

/// The warnings about a file that another program wrote, without the one that says so.
fn besides_the_seal(mut warnings: Vec<Warning>, path: &Path) -> Vec<Warning> {
    assert_eq!(warnings.pop(), Some(Warning::Unsealed(path.to_path_buf())));
    warnings
}

fn overrides() -> Overrides {
    Overrides {
        hand: Some(hand()),
        object: Some(object("cup")),
    }
}

/// The columns of a valid file, as a basis for invalid ones.
fn of(file: &GraspFile) -> Parts {
    let (_folder, path) = place("grasps.parquet");
    file.write(&path).unwrap();
    Parts::of(&path)
}

impl Parts {
    fn read(self, overrides: Overrides) -> Result<(GraspFile, Vec<Warning>), StoreError> {
        let (_folder, path) = place("grasps.parquet");
        self.write(&path);
        let (file, warnings) = GraspFile::read(&path, overrides)?;
        Ok((file, besides_the_seal(warnings, &path)))
    }

    /// The message with which the file is refused, without its folder.
    fn refusal(self) -> String {
        let (folder, path) = place("grasps.parquet");
        self.write(&path);
        sentence(&read(&path).unwrap_err(), folder.path())
    }
}

fn sentence(error: &StoreError, folder: &Path) -> String {
    error
        .to_string()
        .replace(&format!("{}/", folder.display()), "")
}

fn flipped(bytes: &[u8], position: usize, mask: u8) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[position] ^= mask;
    bytes
}

fn landscape() -> LandscapeFiles {
    let minimum = |id: u64| MinimumRow {
        id,
        energy: 0.1 * id as f64,
        coordinates: vec![0.1, 1.0 / 3.0, id as f64],
        members: vec![id, id + 10, u64::MAX],
        family: 0,
        labels: BTreeMap::from([("medium wrap".into(), 2), ("lateral".into(), 1)]),
    };
    let edge = EdgeRow {
        a: 0,
        b: 1,
        height: Some(0.5),
        relative_barrier: Some(0.4),
        length: Some(0.07),
        evidence: "path".into(),
        term: Some("distance".into()),
        chain_forward: Some(0.9),
        chain_backward: None,
        chains_forward: vec![0.95, 0.9],
        chains_backward: Vec::new(),
        chain_runs: 4,
        evaluations: 12345,
        way: Some("regrasping".into()),
    };
    let untried = EdgeRow {
        a: 1,
        b: 2,
        evidence: "none".into(),
        evaluations: 99,
        ..EdgeRow::default()
    };
    let image = |image: u64| PathPoint {
        a: 0,
        b: 1,
        image,
        coordinates: vec![0.0, 0.5, image as f64],
        energy: 0.2,
        terms: (image == 1).then(|| vec![0.125, 0.075]),
    };
    let manifest = Manifest {
        program_version: "0.1.0".into(),
        command: "landscape build grasps.parquet".into(),
        seed: 7,
        source: Source {
            name: "grasps.parquet".into(),
            content_hash: "89ab".into(),
        },
        onto: Some(Source {
            name: "old.landscape".to_owned(),
            content_hash: "5678".to_owned(),
        }),
        hand: Some(hand()),
        object: Some(object("cup")),
        scale: 0.06,
        energy: json!({ "w": 0.1 }),
        settings: json!({ "images": 20 }),
        terms: vec!["force_closure".into(), "distance".into()],
        family_barrier: Some(0.1 + 0.2),
        letting_go: Some(1.0),
        counts: Counts {
            grasps: 9,
            minima: 3,
            families: 1,
            pairs: 2,
            components: 2,
            evaluations: 12444,
        },
        evidence: BTreeMap::from([("path".into(), 1), ("none".into(), 1)]),
        findings: BTreeMap::from([("median_merge_depth".into(), json!(0.1))]),
        warnings: vec!["1 minimum is left out".into()],
    };
    LandscapeFiles {
        manifest,
        minima: (0..3).map(minimum).collect(),
        edges: vec![edge, untried],
        paths: (0..3).map(image).collect(),
    }
}
