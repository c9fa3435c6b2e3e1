//! `landscape config`: prints the settings of a command as a file for its flag `--config`.

use anyhow::ensure;
use clap::{Args, ValueEnum};

use super::args::Common;
use super::stability::{protocol_names, published};
use crate::cli::printing::{print, print_json};
use crate::study::ConfigurationFile;

/// Print the settings of a command.
#[derive(Debug, Args)]
pub(super) struct Config {
    /// The command.
    #[arg(value_name = "COMMAND", value_enum)]
    of: Configurable,
    /// The protocol of `stability`.
    #[arg(long, value_name = "NAME", value_parser = protocol_names())]
    protocol: Option<String>,
}

/// Commands that read files of settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Configurable {
    /// For `synth --config`: energy and sampler.
    Synth,
    /// For `build --config`: map, chains, paths and families.
    Build,
    /// For `surface --config`: search, lowest part and families.
    Surface,
    /// For `stability --config`: the protocol.
    Stability,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape config build > mine.toml                       the settings of `build`, each with a comment
  landscape build grasps.parquet --config mine.toml        the same map, until mine.toml is edited
  landscape config synth > mine.toml                       those of energy and sampler
  landscape config stability --protocol dexgraspbench      those of another protocol

A file may leave out any of its keys; the defaults hold for them. Keys that begin with # are measured, depend on the
energy, or have no default. Unknown keys are refused. Flags override the file.";

pub(super) fn run(command: &Config, common: &Common) -> anyhow::Result<()> {
    ensure!(
        command.protocol.is_none() || command.of == Configurable::Stability,
        "--protocol: only `stability` has protocols"
    );
    let file = match command.of {
        Configurable::Synth => ConfigurationFile::Synth,
        Configurable::Build => ConfigurationFile::Build,
        Configurable::Surface => ConfigurationFile::Surface,
        Configurable::Stability => {
            let protocol = command.protocol.as_deref().unwrap_or("drop");
            ConfigurationFile::Stability(published(protocol)?)
        }
    };
    if common.json {
        return print_json(&file.values());
    }
    print(&file.text());
    Ok(())
}
