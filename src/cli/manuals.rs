//! `landscape completions` and `landscape man`: what shells and `man` know of the command line, made from its definition.

use std::path::PathBuf;

use clap::{Args, Command, ValueHint};
use clap_complete::Shell;
use serde_json::json;

use super::args::Common;
use super::output::{check_folder, make_folder};
use crate::cli::printing::{print, print_json, tell_written};
use crate::store::FileSet;

/// Print a script for a shell.
#[derive(Debug, Args)]
pub(super) struct Completions {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Write manual pages.
#[derive(Debug, Args)]
pub(super) struct Man {
    /// The folder to write.
    #[arg(value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    output: PathBuf,
}

pub(super) const COMPLETIONS: &str = "\
Examples:
  landscape completions bash > ~/.local/share/bash-completion/completions/landscape
  landscape completions zsh > ~/.zfunc/_landscape          a folder of $fpath
  landscape completions fish > ~/.config/fish/completions/landscape.fish";

pub(super) const MAN: &str = "\
Examples:
  landscape man ~/.local/share/man/man1                    then `man landscape` and `man landscape-synth`";

pub(super) fn completions(
    command: &Completions,
    mut definition: Command,
    common: &Common,
) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(command.shell, &mut definition, "landscape", &mut script);
    let script = String::from_utf8(script)?;
    if common.json {
        return print_json(&json!({ "shell": command.shell.to_string(), "script": script }));
    }
    print(&script);
    Ok(())
}

pub(super) fn man(command: &Man, definition: &Command, common: &Common) -> anyhow::Result<()> {
    let output = &command.output;
    let pages = pages(definition, "landscape")?;
    let is_page = |name: &str| pages.iter().any(|(page, _)| page == name);
    check_folder(output, &[], is_page, common)?;
    let _made = make_folder(output)?;
    let mut files = FileSet::default();
    for (name, page) in &pages {
        files.add(&output.join(name), page)?;
    }
    files.finish()?;
    let wrote: Vec<PathBuf> = pages.iter().map(|(name, _)| output.join(name)).collect();
    let written = format!("{} pages to {}", pages.len(), output.display());
    tell_written(common, &json!({ "wrote": wrote }), &written)
}

/// Name and text of the page of a command, and of those under it.
fn pages(definition: &Command, name: &str) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut page = Vec::new();
    // Pages are named as `man` names them, with hyphens.
    let mut named = definition
        .clone()
        .name(name.to_owned())
        .bin_name(name.replace('-', " "));
    // The synopsis is the line of usage of the help, which marks what is required and names the values.
    let usage = named.render_usage().to_string();
    let usage = usage.trim_start_matches("Usage: ").to_owned();
    clap_mangen::Man::new(named.override_usage(usage)).render(&mut page)?;
    let mut found = vec![(format!("{name}.1"), page)];
    for under in definition.get_subcommands() {
        if under.get_name() != "help" {
            found.extend(pages(under, &format!("{name}-{}", under.get_name()))?);
        }
    }
    Ok(found)
}
