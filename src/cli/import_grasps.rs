//! `landscape import` of grasps: converts files of other programs to `grasps.parquet`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use nalgebra::{Isometry3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use rayon::prelude::*;

use super::args::Common;
use super::import::Import;
use super::output::check_file;
use super::provenance::name_of;
use super::{input, progress};
use crate::cli::printing::{complain, print};
use crate::grasp::{EnergySettings, Grasp, GraspEnergy, Judgement};
use crate::hand::Hand;
use crate::limits::OBJECT_SCALE;
use crate::space::Pose;
use crate::store::exchange::{Mapping, Published, read};
use crate::store::{
    Fault, GraspFile, GraspRow, HandMetadata, Metadata, ObjectMetadata, SCHEMA_VERSION, Source,
    content_hash,
};

/// Relative difference within which scales are the same.
const SAME_SCALE: f64 = 1e-3;

/// Whether a path contains grasps rather than a landscape.
pub(super) fn holds_grasps(path: &Path) -> bool {
    let kinds = ["npy", "csv", "json", "parquet"];
    let kind = path.extension().unwrap_or_default();
    path.is_file() && kinds.iter().any(|known| kind.eq_ignore_ascii_case(known))
        || (path.is_dir()
            && !path.join("min.data").exists()
            && !files(path).unwrap_or_default().is_empty())
}

/// A grasp with the name of its source.
struct Row {
    /// Index among all grasps read.
    number: u64,
    published: Published,
    source: String,
    scale: f64,
}

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let hand = command.hand.as_deref();
    let hand = hand.context("--hand: the hand of the grasps must be named (a URDF or MJCF file, or one that comes with the program)")?;
    let object = command.object.as_deref();
    let object = object.context("--object: the object of the grasps must be named (a mesh, or one that comes with the program)")?;
    if let Some(scale) = command.scale {
        input::within("--scale", OBJECT_SCALE, scale)?;
    }
    let output = output(command, common)?;
    let mapping = mapping(command.mapping.as_deref())?;
    let hand_metadata = input::hand(hand, command.hand_folder.as_deref(), command.mirror)?;
    let hand = hand_metadata.build()?;
    let (mut object_metadata, object_notes) = input::object(object, command.scale)?;
    input::rename(&mut object_metadata, command.name.as_deref())?;

    let mut notes: BTreeSet<String> = object_notes.into_iter().collect();
    let (rows, format) = rows(command, &hand_metadata, &hand, &mapping, &mut notes)?;
    let rows = of_one_object(rows, &object_metadata.name)?;
    let total = rows.len();
    let all_scales = scales(&rows);
    let rows = at_scale(rows, command.scale, &all_scales)?;

    let mut file = GraspFile {
        metadata: Metadata {
            schema_version: SCHEMA_VERSION,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: common.provenance.command.clone(),
            inputs: sources(command, common)?,
            hands: vec![hand_metadata],
            objects: vec![object_metadata],
            energy: serde_json::to_value(EnergySettings::default())?,
            settings: serde_json::json!({ "format": format, "notes": notes }),
            ..Metadata::default()
        },
        grasps: Vec::new(),
    };
    let left_out = leave_out(&mut file, rows, &mut notes)?;
    let judgements = complete(&mut file, &hand, &left_out.rows, common)?;
    notes.extend(file.beyond_limits().map(|warning| warning.to_string()));
    file.write(&output)?;
    if !common.quiet {
        input::warn(&notes.into_iter().collect::<Vec<_>>());
        print(&summary(&file, &judgements, format, total, left_out.count));
        complain(&format!("wrote {}", output.display()));
        if all_scales.len() > 1 && command.scale.is_none() {
            complain(&format!(
                "it holds the grasps at all {} scales: `landscape build` makes a landscape of each; `--scale {}` imports one of them",
                all_scales.len(),
                all_scales[all_scales.len() / 2].0
            ));
        }
    }
    Ok(())
}

fn output(command: &Import, common: &Common) -> anyhow::Result<PathBuf> {
    let output = if let Some(output) = &command.output {
        output.clone()
    } else {
        let stem = command
            .path
            .file_stem()
            .context("--output: the file to write must be named")?;
        PathBuf::from(format!("{}.parquet", stem.to_string_lossy()))
    };
    let named = [&command.hand, &command.object];
    let mut inputs: Vec<&Path> = named.into_iter().flatten().map(Path::new).collect();
    inputs.push(&command.path);
    inputs.extend(command.mapping.as_deref());
    check_file(&output, &inputs, common)?;
    Ok(output)
}

fn mapping(path: Option<&Path>) -> anyhow::Result<Mapping> {
    let Some(path) = path else {
        return Ok(Mapping::default());
    };
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("--mapping {}: cannot be read", path.display()))?;
    crate::formats::toml_text::parse(&text).with_context(|| format!("--mapping {}", path.display()))
}

/// The files named in the command, and for a folder of files their common hash.
fn sources(command: &Import, common: &Common) -> anyhow::Result<Vec<Source>> {
    let mut sources = common.provenance.sources()?;
    if command.path.is_dir() {
        let files = files(&command.path)?;
        let bytes = files
            .iter()
            .map(|file| {
                std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))
            })
            .collect::<anyhow::Result<Vec<_>>>()?;
        let bytes: Vec<&[u8]> = bytes.iter().map(Vec::as_slice).collect();
        sources.push(Source {
            name: name_of(&command.path),
            content_hash: content_hash(&bytes),
        });
    }
    Ok(sources)
}

/// The file, or the sorted `.npy` files of a folder.
fn files(path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let entries =
        std::fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|kind| kind.eq_ignore_ascii_case("npy"))
        })
        .collect();
    files.sort();
    Ok(files)
}

fn rows(
    command: &Import,
    hand_metadata: &HandMetadata,
    hand: &Hand,
    mapping: &Mapping,
    notes: &mut BTreeSet<String>,
) -> anyhow::Result<(Vec<Row>, &'static str)> {
    let mut rows = Vec::new();
    let mut format = "";
    for path in files(&command.path)? {
        let found = read(&path, &hand_metadata.joint_names, mapping)?;
        format = found.format;
        notes.extend(found.notes);
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        for (place, mut published) in found.grasps.into_iter().enumerate() {
            if found.format != "DexGraspNet" && found.format != "table" {
                of_root_body(hand, &mut published);
            }
            let scale = published.scale.map(tidy);
            let scale = scale.or(command.scale).unwrap_or(1.0);
            let told = OBJECT_SCALE.check(scale);
            told.with_context(|| format!("{}, grasp {place}: its scale", path.display()))?;
            rows.push(Row {
                number: rows.len() as u64,
                published,
                source: format!("{name} {place}"),
                scale,
            });
        }
    }
    ensure!(
        !rows.is_empty(),
        "{} holds no grasps",
        command.path.display()
    );
    Ok((rows, format))
}

/// Corrects the pose of a qpos, which is that of the outermost body, if this is not at the hand's origin.
fn of_root_body(hand: &Hand, published: &mut Published) {
    let Some(offset) = hand.root_offset() else {
        return;
    };
    let pose = &published.pose;
    let [w, x, y, z] = pose.rotation_wxyz();
    let body = Isometry3::from_parts(
        Translation3::from(nalgebra::Vector3::from_column_slice(pose.translation_m())),
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
    );
    let offset = Isometry3::from_parts(
        offset.translation.into(),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(offset.rotation)),
    );
    let root = body * offset.inverse();
    let (t, q) = (root.translation.vector, root.rotation);
    published.pose = Pose::new(t.into(), [q.w, q.i, q.j, q.k], pose.joints());
}

/// The shortest decimal near a scale that was stored as a 32-bit number.
fn tidy(scale: f64) -> f64 {
    let rounded = (scale * 1e6).round() / 1e6;
    if (rounded / scale - 1.0).abs() < 1e-6 {
        rounded
    } else {
        scale
    }
}

/// The grasps of the named object, if the file has several.
fn of_one_object(rows: Vec<Row>, name: &str) -> anyhow::Result<Vec<Row>> {
    let named: BTreeSet<String> = rows
        .iter()
        .filter_map(|row| row.published.object.clone())
        .collect();
    if named.len() < 2 {
        return Ok(rows);
    }
    ensure!(
        named.contains(name),
        "the grasps are of {} objects ({}), none of which is called {name}: say with --name which one --object is",
        named.len(),
        named.iter().take(4).cloned().collect::<Vec<_>>().join(", ")
    );
    Ok(rows
        .into_iter()
        .filter(|row| row.published.object.as_deref() == Some(name))
        .collect())
}

/// Ascending scales with their numbers of grasps.
fn scales(rows: &[Row]) -> Vec<(f64, usize)> {
    // Positive numbers have the same order as their bits.
    let mut counts = BTreeMap::new();
    for row in rows {
        *counts.entry(row.scale.to_bits()).or_insert(0) += 1;
    }
    counts
        .into_iter()
        .map(|(bits, count)| (f64::from_bits(bits), count))
        .collect()
}

fn at_scale(rows: Vec<Row>, scale: Option<f64>, all: &[(f64, usize)]) -> anyhow::Result<Vec<Row>> {
    let Some(scale) = scale else {
        return Ok(rows);
    };
    let near = |other: f64| (other / scale - 1.0).abs() < SAME_SCALE;
    ensure!(
        all.iter().any(|(other, _)| near(*other)),
        "--scale {scale}: the grasps are at {}",
        told(all)
    );
    Ok(rows.into_iter().filter(|row| near(row.scale)).collect())
}

fn told(scales: &[(f64, usize)]) -> String {
    let told = scales
        .iter()
        .map(|(scale, count)| format!("{scale} ({count})"));
    told.collect::<Vec<_>>().join(", ")
}

/// Rows that can be stored, with their indices among all rows.
struct Kept {
    rows: Vec<Row>,
    count: usize,
}

/// Leaves out grasps that the file cannot hold, with joints far beyond their limits or contacts that the hand does not
/// have. The rows are stored with their poses only.
fn leave_out(
    file: &mut GraspFile,
    rows: Vec<Row>,
    notes: &mut BTreeSet<String>,
) -> anyhow::Result<Kept> {
    let ids: Option<Vec<u64>> = rows.iter().map(|row| row.published.id).collect();
    let ids = ids.filter(|ids| ids.iter().collect::<BTreeSet<_>>().len() == ids.len());
    let grasp = |(place, row): (usize, &Row)| GraspRow {
        id: ids.as_ref().map_or(row.number, |ids| ids[place]),
        object: file.metadata.objects[0].name.clone(),
        scale: row.scale,
        hand: file.metadata.hands[0].name.clone(),
        grasp: Grasp {
            pose: row.published.pose.clone(),
            contacts: row.published.contacts.clone().unwrap_or_default(),
        },
        label: row.published.label.clone(),
        source: row.source.clone(),
        ..GraspRow::default()
    };
    file.grasps = rows.iter().enumerate().map(grasp).collect();
    let faults: Vec<(usize, Fault)> = file.faults();
    let bad: BTreeSet<usize> = faults.iter().map(|(row, _)| *row).collect();
    if let Some((row, fault)) = faults.first() {
        ensure!(
            bad.len() < rows.len(),
            "none of the grasps can be used; {}: {fault}",
            rows[*row].source
        );
        notes.insert(format!(
            "{} of {} grasps are left out, the first ({}) because {fault}",
            bad.len(),
            rows.len(),
            rows[*row].source
        ));
    }
    let mut place = 0;
    file.grasps.retain(|_| {
        place += 1;
        !bad.contains(&(place - 1))
    });
    let rows = rows
        .into_iter()
        .enumerate()
        .filter(|(place, _)| !bad.contains(place));
    Ok(Kept {
        rows: rows.map(|(_, row)| row).collect(),
        count: bad.len(),
    })
}

/// Chooses missing contacts, and fills in energies and measures.
fn complete(
    file: &mut GraspFile,
    hand: &std::sync::Arc<Hand>,
    rows: &[Row],
    common: &Common,
) -> anyhow::Result<Vec<Judgement>> {
    let bar = progress::bar("grasps", rows.len() as u64, common.quiet);
    let mut judgements: Vec<Option<Judgement>> = vec![None; rows.len()];
    for (scale, _) in scales(rows) {
        let object = file.metadata.objects[0].build(scale)?;
        if !common.quiet {
            input::warn(&object.notes);
        }
        let energy = GraspEnergy::new(hand.clone(), object, EnergySettings::default())?;
        file.metadata.terms = energy.term_names();
        file.grasps
            .par_iter_mut()
            .zip(&mut judgements)
            .filter(|(grasp, _)| grasp.scale.to_bits() == scale.to_bits())
            .for_each(|(grasp, judgement)| {
                *judgement = Some(grasp.measure(&energy));
                bar.inc(1);
            });
    }
    bar.finish_and_clear();
    Ok(judgements.into_iter().flatten().collect())
}

fn summary(
    file: &GraspFile,
    judgements: &[Judgement],
    format: &str,
    total: usize,
    left_out: usize,
) -> String {
    let ObjectMetadata { name: object, .. } = &file.metadata.objects[0];
    let kept = file.grasps.len();
    let mut gaps: Vec<f64> = judgements.iter().map(|j| 1e3 * j.gap_m).collect();
    gaps.sort_by(f64::total_cmp);
    let mut depths: Vec<f64> = judgements.iter().map(|j| 1e3 * j.deepest_m).collect();
    depths.sort_by(f64::total_cmp);
    let at = |values: &[f64], tenths: usize| values[(values.len() - 1) * tenths / 10];
    let counts = |test: fn(&Judgement) -> bool| judgements.iter().filter(|j| test(j)).count();
    let scales: Vec<(f64, usize)> = {
        let mut counts = BTreeMap::new();
        for grasp in &file.grasps {
            *counts.entry(grasp.scale.to_bits()).or_insert(0) += 1;
        }
        counts
            .into_iter()
            .map(|(bits, count)| (f64::from_bits(bits), count))
            .collect()
    };
    format!(
        "read                 {kept} of {total} grasps ({format}) of {} on {object}{}\n\
         scales               {}\n\
         farthest contact     median {:.1} mm, nine in ten within {:.1} mm\n\
         deepest penetration  median {:.1} mm, nine in ten within {:.1} mm\n\
         Eq. 11 as printed    {} pass\nstrict filter        {} pass",
        file.metadata.hands[0].name,
        if left_out > 0 {
            format!(", {left_out} left out")
        } else {
            String::new()
        },
        told(&scales),
        at(&gaps, 5),
        at(&gaps, 9),
        at(&depths, 5),
        at(&depths, 9),
        counts(Judgement::passes_published),
        counts(Judgement::passes_strict),
    )
}
