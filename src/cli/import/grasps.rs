//! Import of grasps of other programs as a `grasps.parquet`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use serde_json::{Value, json};

use super::arguments::Import;
use crate::cli::args::{Common, within};
use crate::cli::input;
use crate::cli::output::check_file;
use crate::cli::printing::{complain, print, print_json};
use crate::cli::provenance::name_of;
use crate::cli::run::Watch;
use crate::grasp::Judgement;
use crate::limits::OBJECT_SCALE;
use crate::store::exchange::{Mapping, check_kind, files_of};
use crate::store::{Source, content_hash};
use crate::study::{
    GraspImportError, GraspImportSettings, ImportedGrasps, Run, ScaleCounts, import_grasps,
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

    let watch = Watch::new(common.quiet);
    let run = Run {
        observer: &|news| watch.see(news),
        ..Run::default()
    };
    let imported = import_grasps(&command.path, &settings, &run);
    watch.clear();
    let mut imported = imported.map_err(|error| with_flag(error, command))?;
    let metadata = &mut imported.file.metadata;
    metadata.command.clone_from(&common.provenance.command);
    metadata.inputs = sources(command, common)?;
    imported.file.write(&output)?;
    if common.json {
        print_json(&value(&imported, &output))?;
    }
    if common.quiet {
        return Ok(());
    }
    for notes in &imported.object_notes {
        input::warn(notes);
    }
    // Apart from the others, of which only some are shown.
    input::warn(
        &imported
            .doubt
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>(),
    );
    input::warn(&imported.notes);
    print(&summary(&imported));
    complain(&format!("wrote {}", output.display()));
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

/// The JSON document.
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
    json!({
        "format": format,
        "hand": hand.name,
        "object": file.metadata.objects[0].name,
        "found": found,
        "read": file.grasps.len(),
        "left_out": left_out,
        "scales": scales.iter().map(|(scale, grasps)| json!({ "scale": scale, "grasps": grasps })).collect::<Vec<_>>(),
        "published": count(Judgement::passes_published),
        "strict": count(Judgement::passes_strict),
        "doubt": doubt.as_ref().map(ToString::to_string),
        "notes": hand.warnings().chain(notes.iter().cloned()).collect::<Vec<_>>(),
        "wrote": [output],
    })
}

fn summary(imported: &ImportedGrasps) -> String {
    let ImportedGrasps {
        file,
        judgements,
        format,
        found,
        left_out,
        ..
    } = imported;
    let rising = |value: fn(&Judgement) -> f64| {
        let mut values: Vec<f64> = judgements.iter().map(|j| 1e3 * value(j)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let gaps = rising(|judgement| judgement.gap_m);
    let depths = rising(|judgement| judgement.deepest_m);
    let at = |values: &[f64], tenths: usize| values[(values.len() - 1) * tenths / 10];
    let counts = |test: fn(&Judgement) -> bool| judgements.iter().filter(|j| test(j)).count();
    let left_out = match left_out {
        0 => String::new(),
        _ => format!(", {left_out} left out"),
    };
    format!(
        "read                 {} of {found} grasps ({format}) of {} on {}{left_out}\n\
         scales               {}\n\
         farthest contact     median {:.1} mm, nine in ten within {:.1} mm\n\
         deepest penetration  median {:.1} mm, nine in ten within {:.1} mm\n\
         Eq. 11 as printed    {} pass\nstrict filter        {} pass",
        file.grasps.len(),
        file.metadata.hands[0].name,
        file.metadata.objects[0].name,
        ScaleCounts::of(file.grasps.iter().map(|grasp| grasp.scale)),
        at(&gaps, 5),
        at(&gaps, 9),
        at(&depths, 5),
        at(&depths, 9),
        counts(Judgement::passes_published),
        counts(Judgement::passes_strict),
    )
}
