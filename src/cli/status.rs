//! `landscape status`: how far an unfinished run is.

use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::args::Common;
use super::printing::{print, print_json};
use super::progress::spelled;
use crate::printable::counted;
use crate::store::{RunStatus, WorkerState};

/// Show how far an unfinished run is.
#[derive(Debug, Args)]
pub(super) struct Status {
    /// What the run writes: the file of `synth` or `stability`, or the folder of `build` or `surface`. It need not exist
    /// yet.
    #[arg(value_name = "OUTPUT")]
    output: PathBuf,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  landscape status grasps.parquet                          of `landscape synth`, while it runs or after it was killed
  landscape status grasps.landscape --json                 of `landscape build`, for a script

Reads the journals of the run (OUTPUT.partial, and OUTPUT.workers of --worker) and changes nothing. A worker is `at work`,
has `ended` because nothing was left for it, or is `gone`: it was killed, and others take over its tasks.";

pub(super) fn run(command: &Status, common: &Common) -> anyhow::Result<()> {
    // A user may name the journal's folder instead.
    let text = command.output.to_string_lossy();
    let text = text.trim_end_matches('/');
    let output = [".workers", ".partial"]
        .iter()
        .find_map(|suffix| text.strip_suffix(suffix))
        .unwrap_or(text);
    let output = PathBuf::from(output);
    let Some(status) = RunStatus::read(&output)? else {
        anyhow::ensure!(
            output.exists(),
            "there is no {} and no journal of a run that writes it",
            output.display()
        );
        if common.json {
            return print_json(&serde_json::json!({ "output": output, "finished": true }));
        }
        print(&format!(
            "{} is finished: no run that writes it has left a journal\n",
            output.display()
        ));
        return Ok(());
    };
    if common.json {
        let mut value = serde_json::to_value(&status)?;
        value["finished"] = false.into();
        return print_json(&value);
    }
    print(&told(&status));
    Ok(())
}

fn told(status: &RunStatus) -> String {
    let at_work = (status.workers.iter())
        .filter(|worker| worker.state == WorkerState::AtWork)
        .count();
    let mut text = format!("{}\n", status.output.display());
    let _ = writeln!(
        text,
        "finished   {}",
        counted(status.finished_tasks, "task")
    );
    if let Some(stage) = &status.stage {
        let left = status
            .seconds_left_in_stage
            .map_or(String::new(), |left| format!(", about {} left", time(left)));
        let _ = writeln!(
            text,
            "now        {}: {} of {} of round {}{left}",
            stage.name,
            stage.finished,
            counted(stage.tasks, "task"),
            stage.round
        );
        let _ = writeln!(
            text,
            "rate       {:.2} tasks a second, {} being worked at",
            status.tasks_per_second, status.tasks_at_work
        );
    }
    let _ = match (status.plain_run_at_work, status.workers.len()) {
        (true, _) => writeln!(text, "at work    a run without --worker"),
        (false, 0) => writeln!(
            text,
            "at work    nobody: the same command continues the run"
        ),
        (false, workers) => writeln!(
            text,
            "at work    {at_work} of {}",
            counted(workers, "worker")
        ),
    };
    if !status.workers.is_empty() {
        let _ = writeln!(
            text,
            "{:>12}  {:<8}{:>8}{:>10}{:>12}  host",
            "worker", "state", "tasks", "at work", "time"
        );
    }
    for worker in &status.workers {
        let state = match worker.state {
            WorkerState::AtWork => "at work",
            WorkerState::Ended => "ended",
            WorkerState::Gone => "gone",
        };
        let _ = writeln!(
            text,
            "{:>12}  {state:<8}{:>8}{:>10}{:>12}  {} (process {})",
            worker.worker.to_string(),
            worker.finished_tasks,
            worker.tasks_at_work,
            time(worker.seconds),
            worker.host,
            worker.process
        );
    }
    text
}

fn time(seconds: f64) -> String {
    spelled(Duration::try_from_secs_f64(seconds).unwrap_or_default())
}
