//! Import of grasps of other programs as a `grasps.parquet`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use serde_json::{Value, json};

use super::arguments::Import;
use crate::cli::args::{Common, within};
use crate::cli::input;
use crate::cli::output::check_file;
use crate::cli::printing::{complain, tell_written};
use crate::cli::run::Watch;
use crate::grasp::Judgement;
use crate::limits::OBJECT_SCALE;
use crate::store::exchange::{Mapping, check_kind, files_of};
use crate::store::{Source, content_hash};
use crate::study::{
    GraspImportError, GraspImportSettings, ImportedGrasps, ScaleCounts, import_grasps, median,
    name_of,
};

/// Names of mesh files in data sets that do not tell the object.
const VAGUE_NAMES: [&str; 8] = [
    "decomposed",
    "mesh",
    "model",
    "nontextured",
    "object",
    "scaled",
    "simplified",
    "textured",
];

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    if command.path.is_file() {
        check_kind(&command.path)?;
    }
    let hand = command.hand.as_deref();
    let hand = hand.context("--hand: the hand of the grasps must be named (a URDF or MJCF file, or one that comes with the program)")?;
    let object = command.object.as_deref();
    let object = object.context("--object: the object of the grasps must be named (a mesh, or one that comes with the program)")?;
    if let Some(scale) = command.scale {
        within("--scale", OBJECT_SCALE, scale)?;
    }
    let output = output(command, common)?;
    let mapping = mapping(command.mapping.as_deref())?;
    let hand = input::hand(hand, command.hand_folder.as_deref(), command.mirror)?;
    if !common.quiet {
        input::warn(&hand.warnings().collect::<Vec<_>>());
    }
    let (mut object, notes) = input::object(object, command.scale, command.thickness)?;
    input::rename(&mut object, command.name.as_deref())?;
    let settings = GraspImportSettings {
        hand,
        object,
        notes,
        scale: command.scale,
        mapping,
    };

    let imported = Watch::over(common.quiet, |run| {
        import_grasps(&command.path, &settings, run)
    });
    let mut imported = imported.map_err(|error| with_flag(error, command))?;
    let metadata = &mut imported.file.metadata;
    metadata.command.clone_from(&common.provenance.command);
    metadata.inputs = sources(command, common)?;
    imported.file.write(&output)?;
    if !common.quiet {
        for notes in &imported.object_notes {
            input::warn(notes);
        }
        // Apart from the others, of which only some are shown.
        if let Some(doubt) = &imported.doubt {
            input::warn(&[doubt.to_string()]);
        }
        input::warn(&imported.notes);
    }
    let report = value(&imported, &output);
    tell_written(common, &report, &output.display().to_string())?;
    if common.quiet {
        return Ok(());
    }
    let object = &imported.file.metadata.objects[0].name;
    if command.name.is_none() && VAGUE_NAMES.contains(&object.as_str()) {
        complain(&format!(
            "the object is called \"{object}\" after its file; give it another name with --name"
        ));
    }
    let ScaleCounts(scales) = &imported.scales;
    if scales.len() > 1 && command.scale.is_none() {
        complain(&format!(
            "imported grasps at all {} scales: `landscape build` makes a landscape of each; `--scale {}` imports one of them",
            scales.len(),
            scales[scales.len() / 2].0
        ));
    }
    Ok(())
}

fn output(command: &Import, common: &Common) -> anyhow::Result<PathBuf> {
    let output = if let Some(output) = &command.output {
        output.clone()
    } else {
        let name = PathBuf::from(name_of(&command.path));
        let stem = name
            .file_stem()
            .context("--output: the file to write must be named")?;
        PathBuf::from(format!("{}.parquet", stem.to_string_lossy()))
    };
    let named = [&command.hand, &command.object];
    let mut inputs: Vec<&Path> = named.into_iter().flatten().map(Path::new).collect();
    inputs.push(&command.path);
    inputs.extend(command.mapping.as_deref());
    check_file(&output, &inputs, common.force)?;
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
        let files = files_of(&command.path)?;
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

/// Adds the flag that mends or caused the error.
fn with_flag(error: GraspImportError, command: &Import) -> anyhow::Error {
    match (&error, command.scale) {
        (GraspImportError::OtherObjects { .. }, _) => {
            anyhow::anyhow!("{error}: say with --name which one --object is")
        }
        (GraspImportError::OtherScales { .. }, Some(scale)) => {
            anyhow::Error::new(error).context(format!("--scale {scale}"))
        }
        _ => error.into(),
    }
}

/// The report.
fn value(imported: &ImportedGrasps, output: &Path) -> Value {
    let ImportedGrasps {
        file,
        judgements,
        format,
        found,
        left_out,
        doubt,
        notes,
        ..
    } = imported;
    let hand = &file.metadata.hands[0];
    let ScaleCounts(scales) = ScaleCounts::of(file.grasps.iter().map(|grasp| grasp.scale));
    let count = |test: fn(&Judgement) -> bool| judgements.iter().filter(|j| test(j)).count();
    let middle = |value: fn(&Judgement) -> f64| median(judgements.iter().map(value).collect());
    json!({
        "format": format,
        "hand": hand.name,
        "object": file.metadata.objects[0].name,
        "found": found,
        "read": file.grasps.len(),
        "left_out": left_out,
        "scales": scales.iter().map(|(scale, grasps)| json!({ "scale": scale, "grasps": grasps })).collect::<Vec<_>>(),
        "median_gap_m": middle(|judgement| judgement.gap_m),
        "median_depth_m": middle(|judgement| judgement.deepest_m),
        "published": count(Judgement::passes_published),
        "strict": count(Judgement::passes_strict),
        "doubt": doubt.as_ref().map(ToString::to_string),
        "notes": hand.warnings().chain(notes.iter().cloned()).collect::<Vec<_>>(),
        "wrote": [output],
    })
}
