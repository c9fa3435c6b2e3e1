//! `landscape cache`: what is kept between runs, and its removal.

use std::fmt::Write;

use anyhow::Context;
use clap::{Args, Subcommand};
use serde_json::json;

use super::args::Common;
use crate::cache::{Cache, Kept, Kind};
use crate::cli::printing::{print, print_json};
use crate::printable::counted;

/// Show or empty the cache.
#[derive(Debug, Args)]
pub(super) struct CacheOf {
    #[command(subcommand)]
    command: Option<CacheCommand>,
}

#[derive(Debug, Subcommand)]
enum CacheCommand {
    /// Remove all that is kept
    Clear,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape cache                                          where it lies, and how large it is
  landscape cache clear                                    empty it

Smooth fields of objects and objects cut into convex pieces are kept, because they take seconds to a minute and depend
only on the mesh. Results are the same with and without the cache. Beyond its limit, what was used longest ago is
removed. It may be emptied at any time, also while other commands run.
The cache lies in the system's folder for caches: $XDG_CACHE_HOME or ~/.cache on Linux, ~/Library/Caches on macOS,
%LOCALAPPDATA% on Windows.";

pub(super) fn run(command: &CacheOf, common: &Common) -> anyhow::Result<()> {
    let cache = Cache::of_user();
    match command.command {
        None => show(&cache, common),
        Some(CacheCommand::Clear) => clear(&cache, common),
    }
}

fn show(cache: &Cache, common: &Common) -> anyhow::Result<()> {
    let files = cache.files();
    if common.json {
        return print_json(&json!({
            "folder": cache.folder,
            "fields": number(&files, Kind::Field),
            "cut_objects": number(&files, Kind::Pieces),
            "bytes": size(&files),
            "most_bytes": cache.most_bytes,
        }));
    }
    let Some(folder) = &cache.folder else {
        print(
            "No folder for caches was found, so nothing is kept between runs: set XDG_CACHE_HOME or HOME to an absolute \
             path.\n",
        );
        return Ok(());
    };
    let mut text = format!("folder    {}\n", folder.display());
    let _ = writeln!(
        text,
        "contains  {}, {}",
        told(&files),
        told_size(size(&files))
    );
    let _ = writeln!(
        text,
        "at most   {}; beyond that, what was used longest ago is removed",
        told_size(cache.most_bytes)
    );
    print(&text);
    Ok(())
}

fn clear(cache: &Cache, common: &Common) -> anyhow::Result<()> {
    let folder = cache.folder.as_ref();
    let named = folder.map_or(String::new(), |folder| folder.display().to_string());
    let removed = cache
        .clear()
        .with_context(|| format!("the cache in {named} cannot be emptied"))?;
    if common.json {
        return print_json(&json!({
            "folder": cache.folder,
            "removed_files": removed.len(),
            "removed_bytes": size(&removed),
        }));
    }
    print(&if removed.is_empty() {
        "The cache is empty.\n".to_owned()
    } else {
        format!(
            "Removed {}, {}, from {named}\n",
            told(&removed),
            told_size(size(&removed))
        )
    });
    Ok(())
}

fn told(files: &[Kept]) -> String {
    format!(
        "{} and {}",
        counted(number(files, Kind::Field), "field"),
        counted(number(files, Kind::Pieces), "cut object")
    )
}

fn number(files: &[Kept], kind: Kind) -> usize {
    files.iter().filter(|file| file.kind == kind).count()
}

fn size(files: &[Kept]) -> u64 {
    files.iter().map(|file| file.bytes).sum()
}

fn told_size(bytes: u64) -> String {
    if bytes < 1_000_000_000 {
        format!("{:.1} MB", bytes as f64 / 1e6)
    } else {
        format!("{:.1} GB", bytes as f64 / 1e9)
    }
}
