//! `landscape export`: grasps for other programs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::args::{Common, HandAndObject};
use super::input;
use super::output::{check_file, check_folder, is_scene};
use crate::cli::printing::{complain, print_json};
use crate::figure::Scene;
use crate::store::exchange::{dexgraspnet_npy, qpos, qpos_csv, qpos_npy, table_csv, table_json};
use crate::store::{FileSet, GraspFile, GraspRow, HandMetadata, write_atomic};

/// Write grasps for other programs.
#[derive(Debug, Args)]
pub(super) struct Export {
    /// The grasps: a file of `landscape synth` or `import`.
    #[arg(value_name = "FILE")]
    grasps: PathBuf,
    /// The output format.
    #[arg(value_enum, value_name = "FORMAT")]
    format: ExportFormat,
    /// Export only the grasp with this id; may be given several times.
    #[arg(long, value_name = "ID")]
    grasp: Vec<u64>,
    /// The file to write (a folder of scenes for glb); by default in the current folder, named after the grasps.
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
    /// MuJoCo's qpos (.csv or .npy).
    Qpos,
    /// A binary glTF scene for each grasp.
    Glb,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape export grasps.parquet csv                      grasps.csv: a row for each grasp, a column for each joint
  landscape export grasps.parquet qpos -o grasps.npy       rows of MuJoCo's qpos: position, quaternion w x y z, joints
  landscape export grasps.parquet dexgraspnet              grasps.npy, as DexGraspNet's own files
  landscape export grasps.parquet glb                      grasps.scenes/: the judged hand, the object and the contacts
  landscape export grasps.parquet glb --grasp 17 -o 17.glb

Poses are those of the hand's root in the object's frame: p_object = R p_hand + t, in metres; angles are in radians. In
qpos the hand's outermost body has a free joint; the columns of the CSV form name its joints. `landscape import` reads
csv and json without any change of the numbers.";

pub(super) fn run(command: &Export, common: &Common) -> anyhow::Result<()> {
    let output = output(command)?;
    let inputs = [command.grasps.as_path()];
    if command.format == ExportFormat::Glb && !is_scene(&output) {
        let scene = |name: &str| {
            let number = name.strip_suffix(".glb");
            number.is_some_and(|number| number.parse::<u64>().is_ok())
        };
        check_folder(&output, &inputs, scene, common)?;
    } else {
        check_file(&output, &inputs, common)?;
    }
    let file = input::grasps(&command.grasps, &command.of, common)?;
    for id in &command.grasp {
        ensure!(
            file.grasps.iter().any(|grasp| grasp.id == *id),
            "--grasp {id}: {} has no grasp of this number",
            command.grasps.display()
        );
    }
    let chosen = |grasp: &&GraspRow| command.grasp.is_empty() || command.grasp.contains(&grasp.id);
    let grasps: Vec<&GraspRow> = file.grasps.iter().filter(chosen).collect();
    let written = if command.format == ExportFormat::Glb {
        scenes(&file, &grasps, &output)?
    } else {
        write_atomic(&output, &bytes(command.format, &file, &grasps, &output)?)?;
        output.display().to_string()
    };
    if !common.quiet {
        complain(&format!("wrote {written}"));
    }
    if common.json {
        print_json(&json!({ "wrote": [output], "grasps": grasps.len() }))?;
    }
    Ok(())
}

fn output(command: &Export) -> anyhow::Result<PathBuf> {
    let endings: &[&str] = match command.format {
        ExportFormat::Csv => &["csv"],
        ExportFormat::Json => &["json"],
        ExportFormat::Dexgraspnet => &["npy"],
        ExportFormat::Qpos => &["csv", "npy"],
        ExportFormat::Glb => &["scenes", "glb"],
    };
    let Some(output) = &command.output else {
        let stem = command
            .grasps
            .file_stem()
            .context("--output: the file to write must be named")?;
        let middle = if matches!(command.format, ExportFormat::Qpos) {
            ".qpos"
        } else {
            ""
        };
        return Ok(PathBuf::from(format!(
            "{}{middle}.{}",
            stem.to_string_lossy(),
            endings[0]
        )));
    };
    let ending = output
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    if !matches!(command.format, ExportFormat::Glb) {
        ensure!(
            ending.is_some_and(|ending| endings.contains(&ending.as_str())),
            "--output {}: the name must end in .{}",
            output.display(),
            endings.join(" or .")
        );
    }
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
        ExportFormat::Qpos | ExportFormat::Glb => {
            let hand = metadata.build_matching()?;
            let (joints, rows) = qpos(&hand, grasps);
            if output
                .extension()
                .is_some_and(|ending| ending.eq_ignore_ascii_case("npy"))
            {
                qpos_npy(&rows)
            } else {
                qpos_csv(&rows, &joints)
            }
        }
    })
}

/// Writes a scene for each grasp into a folder, or one into a file. Returns what was written.
fn scenes(file: &GraspFile, grasps: &[&GraspRow], output: &Path) -> anyhow::Result<String> {
    let single = is_scene(output);
    ensure!(
        !single || grasps.len() == 1,
        "--output {}: a .glb file holds one grasp: choose it with --grasp, or name a folder",
        output.display()
    );
    if !single {
        std::fs::create_dir_all(output)
            .with_context(|| format!("cannot create the folder {}", output.display()))?;
    }
    let mut files = FileSet::default();
    for population in file.landscapes() {
        let of_this: Vec<&&GraspRow> = population
            .grasps
            .iter()
            .filter(|grasp| grasps.iter().any(|chosen| chosen.id == grasp.id))
            .collect();
        if of_this.is_empty() {
            continue;
        }
        let hand = population.hand()?;
        let (mesh, _) = population.mesh()?;
        // The hand that was judged, since the drawn skin is thicker at creases.
        let skin = hand.solid_skin();
        for grasp in of_this {
            let scene = Scene::of_grasp_on(&hand, &skin, &mesh, &grasp.grasp);
            let path = if single {
                output.to_path_buf()
            } else {
                output.join(format!("{}.glb", grasp.id))
            };
            files.add(&path, &scene.to_glb())?;
        }
    }
    files.finish()?;
    Ok(if single {
        output.display().to_string()
    } else {
        format!("{} scenes into {}", grasps.len(), output.display())
    })
}
