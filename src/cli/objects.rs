//! `landscape objects`: built-in objects, and new ones from neural networks.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::args::{Common, within};
use super::object_inspect;
use super::output::check_file;
use crate::cli::printing::{complain, tell};
use crate::figure::MAKER;
use crate::limits::OBJECT_SCALE;
use crate::object::neural::{Decoder, Network, NeuralField, Specs, SurfaceSettings, Tensors};
use crate::object::{Description, OBJECT_NAMES, Object};
use crate::printable::counted;
use crate::space::Symmetry;
use crate::store::write_atomic;

/// Objects.
#[derive(Debug, Args)]
pub(super) struct Objects {
    #[command(subcommand)]
    pub(super) command: ObjectsCommand,
}

#[derive(Debug, Subcommand)]
pub(super) enum ObjectsCommand {
    /// List the built-in objects
    List,
    /// Show the derived properties of an object (table, picture): size, pieces, volume, accuracy of its smooth field,
    /// symmetry
    #[command(after_help = object_inspect::EXAMPLES)]
    Inspect(object_inspect::ObjectsInspect),
    /// Make an object from a neural signed-distance function: a mesh, with its smooth field in the cache
    #[command(after_help = EXAMPLES)]
    Bake(Bake),
}

/// Make an object from a network.
#[derive(Debug, Args)]
pub(super) struct Bake {
    /// Weights of the decoder (.safetensors).
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Description of the network: the specs.json of its experiment; by default the one beside the model.
    #[arg(long, value_name = "FILE")]
    specs: Option<PathBuf>,
    /// The latent codes (.safetensors): by default the tensor `latent_codes` of the model.
    #[arg(long, value_name = "FILE")]
    codes: Option<PathBuf>,
    /// Index of the latent code, from 0.
    #[arg(long, value_name = "I", default_value_t = 0)]
    code: usize,
    /// Metres per unit of the network: about half the longest side of the object.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    scale: f64,
    /// Resolution of the surface: cells along the diameter of the network's ball.
    #[arg(long, value_name = "N", default_value_t = 128)]
    cells: u32,
    /// The mesh to write (.obj).
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  landscape objects bake model.safetensors --scale 0.1 -o bottle.obj
                                                           shape 0 of a trained decoder, 0.1 m per unit of the network
  landscape objects bake model.safetensors --specs s.json --codes codes.safetensors --code 7 --scale 0.1 -o jar.obj
  landscape synth --object bottle.obj -n 64                use it as any other object

The network is the decoder of DeepSDF: its distances are negative inside, and its shapes are scaled into a ball of
radius 1. The zero level set becomes a closed mesh, from which a smooth field is made; a network of rectifiers has no
curvature of its own. The field is kept between runs (see `landscape cache`). Checkpoints of torch (.pth) are converted by
the script in docs/neural_objects.md.";

pub(super) fn run(command: &ObjectsCommand, common: &Common) -> anyhow::Result<()> {
    match command {
        ObjectsCommand::List => list(common),
        ObjectsCommand::Bake(command) => bake(command, common),
        ObjectsCommand::Inspect(command) => object_inspect::run(command, common),
    }
}

fn list(common: &Common) -> anyhow::Result<()> {
    let entry = |name: &&str| {
        let (mesh, description) = Object::parts_of_named(name)?;
        let [low, high] = mesh.bounds();
        let symmetry = match &description.symmetry {
            Symmetry::None => "none".to_owned(),
            Symmetry::Axis { .. } => "axis".to_owned(),
            Symmetry::Sphere { .. } => "sphere".to_owned(),
            Symmetry::Finite(motions) => counted(motions.len(), "motion"),
        };
        Ok(json!({
            "name": name,
            "size_m": (high - low).as_slice(),
            "mass_kg": description.mass_kg,
            "symmetry": symmetry,
        }))
    };
    let objects = OBJECT_NAMES.iter().map(entry);
    let objects = objects.collect::<anyhow::Result<Vec<Value>>>()?;
    tell(common, &json!({ "objects": objects }))
}

/// Rejects invalid arguments before any work.
fn check(command: &Bake, common: &Common) -> anyhow::Result<()> {
    let output = &command.output;
    anyhow::ensure!(
        output
            .extension()
            .is_some_and(|kind| kind.eq_ignore_ascii_case("obj")),
        "--output {}: the name of an OBJ file (.obj) is needed",
        output.display()
    );
    let inputs = [
        Some(&command.model),
        command.specs.as_ref(),
        command.codes.as_ref(),
    ];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().map(PathBuf::as_path).collect();
    check_file(output, &inputs, common.force)?;
    anyhow::ensure!(
        (16..=512).contains(&command.cells),
        "--cells {}: a number from 16 to 512 is needed",
        command.cells
    );
    within("--scale", OBJECT_SCALE, command.scale)?;
    // The object's description, which would be read with the mesh.
    let beside = output.with_extension("json");
    if beside.exists() {
        let text = std::fs::read_to_string(&beside)
            .with_context(|| format!("cannot read {}", beside.display()))?;
        Description::from_json(&beside.display().to_string(), &text).context(
            "a file beside the output has the name of an object's description: choose another --output",
        )?;
    }
    Ok(())
}

fn bake(command: &Bake, common: &Common) -> anyhow::Result<()> {
    check(command, common)?;
    let say = |line: &str| {
        if !common.quiet {
            complain(line);
        }
    };
    let field = read(command)?;
    let name = command
        .output
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    say("looking for the surface …");
    let settings = SurfaceSettings {
        cells: command.cells,
    };
    let surface = field.surface(&name, &settings)?;
    let text = format!("# Made by {MAKER}.\n{}", surface.mesh.to_obj());
    write_atomic(&command.output, text.as_bytes())?;
    say(&format!(
        "wrote {}; baking its smooth field …",
        command.output.display()
    ));
    // Loads the object like `--object`, so that its field is in the cache afterwards.
    let object = Object::load(&command.output)?;
    if common.quiet && !common.json {
        return Ok(());
    }
    let report = object.field_report.as_ref();
    let [low, high] = surface.mesh.bounds();
    tell(
        common,
        &json!({
            "name": object.name,
            "size_m": (high - low).as_slice(),
            "mass_kg": object.mass_kg,
            "triangles": surface.mesh.triangles().len(),
            "network_at_vertices_m": surface.residual_m,
            "left_out": surface.crumbs,
            "field_cell_m": report.map(|report| report.cell_m),
            "field_error_m": report.map(|report| report.max_error_m),
            "wrote": [&command.output],
        }),
    )
}

fn read(command: &Bake) -> anyhow::Result<NeuralField<f32>> {
    let specs = command
        .specs
        .clone()
        .unwrap_or_else(|| command.model.with_file_name("specs.json"));
    let model = Tensors::load(&command.model)?;
    anyhow::ensure!(
        command.specs.is_some() || specs.exists(),
        "there is no {} beside the model: name the specs file with --specs",
        specs.display()
    );
    let decoder = Decoder::new(Specs::load(&specs)?, &model)?;
    let code = match &command.codes {
        Some(codes) => Tensors::load(codes)?.code(command.code),
        None => model.code(command.code),
    };
    let code = code.with_context(|| format!("--code {}", command.code))?;
    Ok(NeuralField::new(
        Network::new(&decoder, &code)?,
        command.scale,
    )?)
}
