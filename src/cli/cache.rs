//! `landscape cache`: what is kept between runs, and its removal.

use anyhow::Context;
use clap::{Args, Subcommand};
use serde_json::json;

use super::args::Common;
use crate::cache::{Cache, Kept, Kind};
use crate::cli::printing::{complain, tell};

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
    let number = |kind: Kind| files.iter().filter(|file| file.kind == kind).count();
    let report = json!({
        "folder": cache.folder,
        "fields": number(Kind::Field),
        "cut_objects": number(Kind::Pieces),
        "bytes": size(&files),
        "most_bytes": cache.most_bytes,
    });
    if cache.folder.is_none() && !common.quiet {
        complain("note: no folder for caches: set XDG_CACHE_HOME or HOME to an absolute path");
    }
    tell(common, &report)
}

fn clear(cache: &Cache, common: &Common) -> anyhow::Result<()> {
    let removed = cache.clear().context("the cache cannot be emptied")?;
    let report = json!({
        "folder": cache.folder,
        "removed_files": removed.len(),
        "removed_bytes": size(&removed),
    });
    tell(common, &report)
}

fn size(files: &[Kept]) -> u64 {
    files.iter().map(|file| file.bytes).sum()
}
