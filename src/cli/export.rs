//! `landscape export`: grasps and landscapes for other programs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::args::{Common, HandAndObject};
use super::input;
use super::output::{check_file, check_folder, make_folder};
use super::run::Watch;
use super::stability::{protocol_names, published};
use crate::cli::printing::tell_text;
use crate::evaluation::stability::Protocol;
use crate::figure::Scene;
use crate::grasp::Grasp;
use crate::hand::Hand;
use crate::printable::counted;
use crate::store::exchange::{
    IsaacGrasp, dexgraspnet_npy, dexonomy_npy, graspgen_json, isaac_grasp, qpos, qpos_csv,
    qpos_npy, table_csv, table_json,
};
use crate::store::{FileSet, GraspFile, GraspRow, HandMetadata, Population, write_atomic};
use crate::study::{
    Approach, Drives, ExportedFile, MujocoScene, approaches, check_rigid, hand_urdf, roadmap,
    squeezing_test,
};

/// Write grasps for other programs.
#[derive(Debug, Args)]
pub(super) struct Export {
    /// The grasps: a file of `landscape synth` or `import`; for the format roadmap a landscape of `landscape build`.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The output format.
    #[arg(value_enum, value_name = "FORMAT")]
    format: ExportFormat,
    /// Export only the grasp with this id; may be given several times.
    #[arg(long, value_name = "ID")]
    grasp: Vec<u64>,
    /// The published test of a scene of MuJoCo (`stability --help` describes the tests); by default the one by which the grasps
    /// were simulated if the hand closes in it, and dexgraspbench otherwise.
    #[arg(long, value_name = "NAME", value_parser = protocol_names(), hide_possible_values = true)]
    protocol: Option<String>,
    /// Drive each way of a road map in simulation, both ways under four conditions, and write how often the object followed
    /// (seconds for each way).
    #[arg(long)]
    drive: bool,
    /// The file to write (a folder for dexonomy, mujoco, urdf, glb and usd); by default in the current folder, named after the
    /// grasps.
    #[arg(long, short, value_name = "PATH")]
    output: Option<PathBuf>,
    #[command(flatten)]
    of: HandAndObject,
}

/// Formats of exports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ExportFormat {
    /// A table with one row for each grasp.
    Csv,
    /// A list of objects with named entries.
    Json,
    /// DexGraspNet's array of dictionaries (.npy).
    Dexgraspnet,
    /// A dictionary of DexGraspBench and Dexonomy for each grasp (.npy).
    Dexonomy,
    /// MuJoCo's qpos (.csv or .npy).
    Qpos,
    /// A scene of MuJoCo with a keyframe for each grasp.
    Mujoco,
    /// Isaac Sim's file of grasps (.yaml).
    #[value(name = "isaac_grasp")]
    IsaacGrasp,
    /// GraspGen's file of poses without joints (.json).
    Graspgen,
    /// The hand as URDF with meshes.
    Urdf,
    /// A binary glTF scene for each grasp.
    Glb,
    /// A USD scene (.usda) for each grasp.
    Usd,
    /// A landscape as a road map: postures, and the ways between them with the targets of the joints (.json).
    Roadmap,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape export grasps.parquet csv                      grasps.csv: a row for each grasp, a column for each joint
  landscape export grasps.parquet qpos -o grasps.npy       rows of MuJoCo's qpos: position, quaternion w x y z, joints
  landscape export grasps.parquet mujoco                   grasps.mujoco/: scene.xml with a keyframe for each grasp
  landscape export grasps.parquet mujoco --protocol graspqp -o scene    the same for another test than dexgraspbench
  landscape export grasps.parquet urdf                     grasps.hand/: the hand as URDF, with its meshes
  landscape export grasps.parquet isaac_grasp              grasps.isaac_grasp.yaml, for Isaac Sim
  landscape export grasps.parquet graspgen                 grasps.graspgen.json: poses without joints, for parallel grippers
  landscape export grasps.parquet dexgraspnet              grasps.npy, as DexGraspNet's own files
  landscape export grasps.parquet dexonomy                 grasps.dexonomy/: a file for each grasp, as DexGraspBench reads
  landscape export grasps.parquet glb                      grasps.scenes/: the judged hand, the object and the contacts
  landscape export grasps.parquet glb --grasp 17 -o 17.glb
  landscape export grasps.landscape roadmap                grasps.roadmap.json: ways between grasps, to be driven

Poses are those of the hand's root in the object's frame: p_object = R p_hand + t, in metres; angles are in radians. The
root is the frame of the hand's file (the world of an MJCF), in qpos and dexonomy as well: attach the file to a body with
a free joint. A hand with a virtual wrist has the joints of that wrist in place of the free joint. The columns of the CSV form of qpos name the joints.
`landscape import` reads csv and json without any change of the numbers, and dexgraspnet and dexonomy as well.";

impl ExportFormat {
    /// Endings of the default output and of files that may be named; the ending of the files of a folder, if it is one.
    fn endings(self) -> (&'static str, &'static [&'static str], Option<&'static str>) {
        match self {
            Self::Csv => ("csv", &["csv"], None),
            Self::Json => ("json", &["json"], None),
            Self::Dexgraspnet => ("npy", &["npy"], None),
            Self::Qpos => ("qpos.csv", &["csv", "npy"], None),
            Self::Graspgen => ("graspgen.json", &["json"], None),
            Self::IsaacGrasp => ("isaac_grasp.yaml", &["yaml", "yml"], None),
            Self::Glb => ("scenes", &[], Some("glb")),
            Self::Usd => ("usd", &[], Some("usda")),
            Self::Dexonomy => ("dexonomy", &[], Some("npy")),
            Self::Mujoco => ("mujoco", &[], Some("xml")),
            Self::Urdf => ("hand", &[], Some("urdf")),
            Self::Roadmap => ("roadmap.json", &["json"], None),
        }
    }

    fn is_folder(self) -> bool {
        self.endings().2.is_some()
    }

    /// Whether an output is a single file of a grasp in place of a folder.
    fn is_single(self, output: &Path) -> bool {
        let one = matches!(self, Self::Glb | Self::Usd | Self::Dexonomy);
        one && ending(output).as_deref() == self.endings().2
    }

    /// Whether it writes a file of this name into its folder.
    fn writes(self, name: &str) -> bool {
        let Some((stem, ending)) = name.rsplit_once('.') else {
            return false;
        };
        let mesh = ending == "obj" && (stem.starts_with("link_") || stem.starts_with("object"));
        let own = self.endings().2 == Some(ending);
        match self {
            Self::Mujoco => mesh || name == "scene.xml",
            Self::Urdf => mesh || own,
            _ => own && stem.parse::<u64>().is_ok(),
        }
    }
}

fn ending(path: &Path) -> Option<String> {
    let ending = path.extension()?;
    Some(ending.to_string_lossy().to_lowercase())
}

pub(super) fn run(command: &Export, common: &Common) -> anyhow::Result<()> {
    let format = command.format;
    let output = output(command)?;
    let inputs = [command.grasps.as_path()];
    let single = !format.is_folder() || format.is_single(&output);
    if single {
        check_file(&output, &inputs, common.force)?;
    } else {
        check_folder(&output, &inputs, |name| format.writes(name), common)?;
    }
    ensure!(
        command.protocol.is_none() || matches!(format, ExportFormat::Mujoco),
        "--protocol: only the format mujoco is a scene of a test"
    );
    ensure!(
        !command.drive || format == ExportFormat::Roadmap,
        "--drive: only the format roadmap has ways to drive"
    );
    if format == ExportFormat::Roadmap {
        return write_roadmap(command, &output, common);
    }
    let file = input::grasps(&command.grasps, &command.of, common)?;
    input::all_known("--grasp", &command.grasp, &file, &command.grasps)?;
    let chosen = |grasp: &&GraspRow| command.grasp.is_empty() || command.grasp.contains(&grasp.id);
    let grasps: Vec<&GraspRow> = file.grasps.iter().filter(chosen).collect();
    let files = if format.is_folder() {
        let protocol = scene_test(command, &file)?;
        let files = files(format, &file, &grasps, protocol, common.quiet)?;
        write_files(files, &output, single)?
    } else {
        write_atomic(&output, &bytes(format, &file, &grasps, &output)?)?;
        1
    };
    // The hand alone has no grasps.
    let count = match format {
        ExportFormat::Urdf => 0,
        _ => grasps.len(),
    };
    let (place, grasps) = (output.display(), counted(count, "grasp"));
    let meshes = counted(files.saturating_sub(1), "mesh");
    let written = match format {
        ExportFormat::Mujoco => format!("{grasps} to {place}: scene.xml and {meshes}"),
        ExportFormat::Urdf => format!("{place}: the hand and {meshes}"),
        _ => format!("{grasps} to {place}"),
    };
    let report = json!({ "wrote": [output], "grasps": count });
    tell_text(common, ("", &report), Some(&written))
}

fn write_roadmap(command: &Export, output: &Path, common: &Common) -> anyhow::Result<()> {
    ensure!(
        command.grasp.is_empty() && command.of.hand.is_none() && command.of.object.is_none(),
        "the format roadmap writes a whole landscape: leave out --grasp, --hand and --object"
    );
    let files = input::open_landscape(&command.grasps)?;
    let name = command.grasps.display().to_string();
    let map = roadmap(&files, &Drives::of(&files, &name)?, command.drive)?;
    write_atomic(output, &serde_json::to_vec(&map)?)?;
    let edges = map["edges"].as_array().map_or(0, Vec::len);
    let (ways, nodes) = (
        counted(edges, "way"),
        counted(files.minima.len(), "posture"),
    );
    let written = format!("{nodes} and {ways} to {}", output.display());
    let report = json!({ "wrote": [output], "grasps": files.minima.len() });
    tell_text(common, ("", &report), Some(&written))
}

/// The test of a scene.
fn scene_test(command: &Export, file: &GraspFile) -> anyhow::Result<Protocol> {
    match &command.protocol {
        Some(name) => published(name),
        None => Ok(Protocol::Loads(squeezing_test(&file.metadata))),
    }
}

fn output(command: &Export) -> anyhow::Result<PathBuf> {
    let (default, endings, _) = command.format.endings();
    let Some(output) = &command.output else {
        let stem = command.grasps.file_stem();
        let stem = stem.context("--output: the file to write must be named")?;
        return Ok(format!("{}.{default}", stem.to_string_lossy()).into());
    };
    ensure!(
        endings.is_empty() || ending(output).is_some_and(|end| endings.contains(&end.as_str())),
        "--output {}: the name must end in .{}",
        output.display(),
        endings.join(" or .")
    );
    Ok(output.clone())
}

/// The hand of all grasps, which must be a single one.
fn one_hand<'a>(file: &'a GraspFile, grasps: &[&GraspRow]) -> anyhow::Result<&'a HandMetadata> {
    let names: BTreeSet<&str> = grasps.iter().map(|grasp| grasp.hand.as_str()).collect();
    ensure!(
        names.len() == 1,
        "the grasps are of several hands ({}), whose joints do not fit into one table",
        names.iter().copied().collect::<Vec<_>>().join(", ")
    );
    let hand = file
        .metadata
        .hands
        .iter()
        .find(|hand| names.contains(hand.name.as_str()));
    hand.context("the file does not describe its hand")
}

/// Some grasps of one hand on one object.
type Group<'a> = (Population<'a>, Vec<&'a GraspRow>);

/// The chosen grasps by hand, object and scale.
fn groups<'a>(file: &'a GraspFile, grasps: &[&GraspRow]) -> Vec<Group<'a>> {
    let chosen: BTreeSet<u64> = grasps.iter().map(|grasp| grasp.id).collect();
    let populations = file.landscapes().into_iter();
    populations
        .map(|population| {
            let of_this = population.grasps.iter();
            let of_this = of_this.filter(|grasp| chosen.contains(&grasp.id));
            let of_this: Vec<&GraspRow> = of_this.copied().collect();
            (population, of_this)
        })
        .filter(|(_, grasps)| !grasps.is_empty())
        .collect()
}

/// The chosen grasps, which must be those of one hand on one object.
fn one_group<'a>(file: &'a GraspFile, grasps: &[&GraspRow]) -> anyhow::Result<Group<'a>> {
    let mut groups = groups(file, grasps);
    let names = groups.iter().map(|(population, _)| {
        format!(
            "{} on {} of scale {}",
            population.hand.name, population.object.name, population.scale
        )
    });
    let names: Vec<String> = names.collect();
    ensure!(
        names.len() == 1,
        "the format supports one hand and one object, but the grasps are of {}: choose some of them (--grasp)",
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    );
    Ok(groups.remove(0))
}

fn bytes(
    format: ExportFormat,
    file: &GraspFile,
    grasps: &[&GraspRow],
    output: &Path,
) -> anyhow::Result<Vec<u8>> {
    let metadata = one_hand(file, grasps)?;
    let names = &metadata.joint_names;
    Ok(match format {
        ExportFormat::Csv => table_csv(grasps, names),
        ExportFormat::Json => table_json(grasps, names),
        ExportFormat::Dexgraspnet => dexgraspnet_npy(grasps, names),
        ExportFormat::IsaacGrasp => isaac(file, grasps)?,
        ExportFormat::Graspgen => {
            let (population, rows) = one_group(file, grasps)?;
            graspgen_json(&population.object.name, population.scale, &rows)
        }
        _ => {
            let hand = metadata.build_matching()?;
            let (columns, rows) = qpos(&hand, grasps);
            if ending(output).as_deref() == Some("npy") {
                qpos_npy(&rows)
            } else {
                qpos_csv(&rows, &columns)
            }
        }
    })
}

fn isaac(file: &GraspFile, grasps: &[&GraspRow]) -> anyhow::Result<Vec<u8>> {
    let (population, rows) = one_group(file, grasps)?;
    let hand = population.hand()?;
    check_rigid(&hand)?;
    let approaches = approaches_of(file, &population, &hand, &rows)?;
    let told = rows
        .iter()
        .zip(approaches)
        .map(|(row, approach)| IsaacGrasp {
            grasp: row,
            // A grasp that was not simulated counts as good: that is why it is in the file.
            confidence: if row.stable == Some(false) { 0.0 } else { 1.0 },
            before: approach.before,
        });
    Ok(isaac_grasp(
        &population.object.name,
        &hand.links[0].name,
        &population.hand.joint_names,
        &told.collect::<Vec<_>>(),
    ))
}

fn approaches_of(
    file: &GraspFile,
    population: &Population<'_>,
    hand: &Hand,
    rows: &[&GraspRow],
) -> anyhow::Result<Vec<Approach>> {
    let (mesh, _) = population.mesh()?;
    let grasps: Vec<&Grasp> = rows.iter().map(|row| &row.grasp).collect();
    Ok(approaches(
        hand,
        &mesh,
        &grasps,
        &squeezing_test(&file.metadata),
    ))
}

/// The files of a folder.
fn files(
    format: ExportFormat,
    file: &GraspFile,
    grasps: &[&GraspRow],
    protocol: Protocol,
    quiet: bool,
) -> anyhow::Result<Vec<ExportedFile>> {
    match format {
        ExportFormat::Mujoco => {
            let (population, rows) = one_group(file, grasps)?;
            let hand = population.hand()?;
            let (mesh, mass_kg) = population.mesh()?;
            let scene = MujocoScene {
                hand: &hand,
                object: &population.object.name,
                mesh: &mesh,
                mass_kg,
                protocol,
                grasps: rows,
            };
            Ok(Watch::over(quiet, |run| scene.files(run.observer))?)
        }
        ExportFormat::Urdf => {
            let hand = one_hand(file, grasps)?.build_matching()?;
            Ok(hand_urdf(&hand)?)
        }
        ExportFormat::Dexonomy => dexonomy(file, grasps),
        _ => scenes(format, file, grasps),
    }
}

/// A dictionary for each grasp. All names have the same length, so that their order is that of the ids.
fn dexonomy(file: &GraspFile, grasps: &[&GraspRow]) -> anyhow::Result<Vec<ExportedFile>> {
    let largest = grasps.iter().map(|grasp| grasp.id).max().unwrap_or(0);
    let digits = largest.to_string().len();
    let mut files = Vec::new();
    for (population, rows) in groups(file, grasps) {
        let hand = population.hand()?;
        check_rigid(&hand)?;
        let approaches = approaches_of(file, &population, &hand, &rows)?;
        files.extend(rows.iter().zip(approaches).map(|(row, approach)| {
            // Those that the makers of the grasp stored, if they did.
            let squeezed = row.squeeze_joints.as_ref().unwrap_or(&approach.squeezed);
            ExportedFile {
                name: format!("{:0digits$}.npy", row.id),
                bytes: dexonomy_npy(&hand, row, &approach.before, squeezed),
            }
        }));
    }
    Ok(files)
}

/// A scene for each grasp.
fn scenes(
    format: ExportFormat,
    file: &GraspFile,
    grasps: &[&GraspRow],
) -> anyhow::Result<Vec<ExportedFile>> {
    let mut files = Vec::new();
    for (population, rows) in groups(file, grasps) {
        let hand = population.hand()?;
        let (mesh, _) = population.mesh()?;
        // The hand that was judged, since the drawn skin is thicker at creases.
        let skin = hand.solid_skin();
        files.extend(rows.iter().map(|row| {
            let scene = Scene::of_grasp_on(&hand, &skin, &mesh, &row.grasp);
            let (ending, bytes) = match format {
                ExportFormat::Usd => ("usda", scene.to_usda().into_bytes()),
                _ => ("glb", scene.to_glb()),
            };
            ExportedFile {
                name: format!("{}.{ending}", row.id),
                bytes,
            }
        }));
    }
    Ok(files)
}

/// Writes the files into a folder, or the only one as `output`. Returns their number.
fn write_files(files: Vec<ExportedFile>, output: &Path, single: bool) -> anyhow::Result<usize> {
    let count = files.len();
    ensure!(
        !single || count == 1,
        "--output {}: such a file contains one grasp: choose it with --grasp, or name a folder",
        output.display()
    );
    let _made = (!single).then(|| make_folder(output)).transpose()?;
    let mut set = FileSet::default();
    for ExportedFile { name, bytes } in files {
        let path = if single {
            output.to_path_buf()
        } else {
            output.join(name)
        };
        set.add(&path, &bytes)?;
    }
    set.finish()?;
    Ok(count)
}
