//! Runs that several processes share, of which some are killed.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use landscape::sample::{Task, stream};
use rand::RngExt;
use serde_json::Value;

use super::desk::{Desk, assert_says};
use super::records::records;
use super::{BUILD, Run, SYNTH, on_a_full_disk};

impl Run {
    fn worker(&self, desk: &Desk, number: usize, count: usize) -> Child {
        let line = format!("{} -q --threads 1 --worker {number}/{count}", self.line);
        let mut command = desk.command(&line);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    }

    /// The journal of a worker, whose name ends with that of the machine.
    fn journal_of(&self, desk: &Desk, worker: &str) -> PathBuf {
        let started = Instant::now();
        loop {
            let entries = fs::read_dir(desk.path(&self.workers_folder()));
            let paths = entries
                .into_iter()
                .flatten()
                .map(|entry| entry.unwrap().path());
            let mut named = paths.filter(|path| super::name(path).starts_with(worker));
            if let Some(path) = named.next() {
                return path;
            }
            assert!(
                started.elapsed() < Duration::from_mins(1),
                "it has a journal"
            );
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn workers_folder(&self) -> String {
        format!("{}.workers", self.output)
    }

    /// How often each task was done, by the journals of all workers.
    fn times_done(&self, desk: &Desk) -> BTreeMap<String, usize> {
        let mut times = BTreeMap::new();
        for entry in fs::read_dir(desk.path(&self.workers_folder())).unwrap() {
            for (key, _) in records(&entry.unwrap().path()) {
                if !key.starts_with('~') {
                    *times.entry(key).or_insert(0) += 1;
                }
            }
        }
        times
    }

    /// Runs `count` workers at a time, kills the first `kills` of them after random times and starts them again, and joins.
    fn shared(&self, count: usize, kills: usize) {
        let desk = self.desk();
        let mut workers: Vec<Child> = (1..=count)
            .map(|number| self.worker(&desk, number, count))
            .collect();
        for (worker, number) in workers.iter_mut().zip(1..=kills) {
            let mut rng = stream(6, Task::Start, number as u64);
            std::thread::sleep(Duration::from_millis(rng.random_range(20..300)));
            worker.kill().unwrap();
            worker.wait().unwrap();
            *worker = self.worker(&desk, number, count);
        }
        for mut worker in workers {
            assert!(worker.wait().unwrap().success());
        }
        let times = self.times_done(&desk);
        let twice = times.values().filter(|times| **times > 1).count();
        // What a killed worker had begun is done by another, and two may begin the same one at the very end. The tasks of this
        // build take milliseconds, which is shorter than the time in which workers see each other's marks.
        assert!(
            self.output == BUILD.output || twice <= kills + 1 + times.len() / 20,
            "{twice} of {} tasks were done twice",
            times.len()
        );
        self.finish(&desk, "-q --threads 2");
        assert!(!desk.path(&self.workers_folder()).exists());
    }
}

#[test]
fn shared_syntheses_give_the_same_bytes() {
    for (count, kills) in [(1, 1), (2, 1), (5, 3), (64, 5)] {
        SYNTH.shared(count, kills);
    }
}

#[test]
fn shared_builds_give_the_same_bytes() {
    for (count, kills) in [(1, 0), (2, 2), (5, 2)] {
        BUILD.shared(count, kills);
    }
}

#[test]
fn a_worker_takes_over_what_a_killed_one_leaves() {
    let desk = SYNTH.desk();
    let mut first = SYNTH.worker(&desk, 1, 2);
    let journal = SYNTH.journal_of(&desk, "1-of-2");
    let begun = |key: &str| records(&journal).iter().any(|(known, _)| known == key);
    while !begun("~begin chain 2") {
        assert!(first.try_wait().unwrap().is_none(), "it has five tasks");
        std::thread::sleep(Duration::from_millis(1));
    }
    // The plain run does not join a run that is at work.
    assert_says(
        &desk.mistake(&format!("{} -q", SYNTH.line)),
        &["1-of-2-", "still at work", "give this command again"],
    );
    let status = |desk: &Desk| -> Value {
        let output = desk.run("status g.parquet --json");
        assert!(output.status.success());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let alive = status(&desk);
    assert_eq!(alive["workers"][0]["state"], "at_work", "{alive}");
    assert_eq!(alive["stage"]["tasks"], 10, "{alive}");
    first.kill().unwrap();
    first.wait().unwrap();
    let killed = status(&desk);
    assert_eq!(killed["workers"][0]["state"], "gone", "{killed}");
    assert!(killed["finished_tasks"].as_u64().unwrap() >= 1, "{killed}");

    assert!(SYNTH.worker(&desk, 2, 2).wait().unwrap().success());
    assert_eq!(SYNTH.times_done(&desk).len(), 10, "all are done");
    let ended = status(&desk);
    assert_eq!(ended["workers"][1]["state"], "ended", "{ended}");
    assert_eq!(ended["stage"]["finished"], 10, "{ended}");
    // Nothing is left for the plain run.
    let before = SYNTH.times_done(&desk);
    let said = desk.run(&format!("{} --threads 2", SYNTH.line));
    let said = String::from_utf8(said.stderr).unwrap();
    assert_says(
        &said,
        &["10 finished tasks in", "the journals of 2 other processes"],
    );
    assert_eq!(before.len(), 10);
    assert!(SYNTH.files(&desk) == SYNTH.whole().files, "same bytes");
    assert_says(
        &String::from_utf8(desk.run("status g.parquet").stdout).unwrap(),
        &["g.parquet is finished"],
    );
}

#[test]
fn a_worker_waits_for_the_tasks_of_others() {
    let desk = SYNTH.desk();
    let first = SYNTH.worker(&desk, 1, 2);
    let mut second = SYNTH.worker(&desk, 2, 2);
    let started = Instant::now();
    // Stopped, the first holds its lock and one task, which nobody may take from it.
    let stop = |signal: &str| {
        let pid = first.id().to_string();
        let done = std::process::Command::new("kill")
            .args([signal, &pid])
            .status();
        assert!(done.unwrap().success());
    };
    let journal = SYNTH.journal_of(&desk, "1-of-2");
    let begun = || (records(&journal).iter()).any(|(key, _)| key.starts_with("~begin"));
    while !begun() {
        assert!(started.elapsed() < Duration::from_mins(1));
        std::thread::sleep(Duration::from_millis(1));
    }
    stop("-STOP");
    let all_but_one = || SYNTH.times_done(&desk).len() >= 9;
    while !all_but_one() {
        assert!(started.elapsed() < Duration::from_mins(2), "it takes over");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(500));
    assert!(second.try_wait().unwrap().is_none(), "it waits");
    stop("-CONT");
    assert!(second.wait().unwrap().success());
    let mut first = first;
    assert!(first.wait().unwrap().success());
    // It may have been stopped just before it marked a task that the second has taken then.
    let times = SYNTH.times_done(&desk);
    assert!(times.values().sum::<usize>() <= 11, "{times:?}");
    SYNTH.finish(&desk, "-q");
}

#[test]
fn workers_of_other_runs_are_refused() {
    let desk = SYNTH.desk();
    assert!(SYNTH.worker(&desk, 1, 1).wait().unwrap().success());
    let other = SYNTH.line.replace("--seed 1", "--seed 2");
    for flag in ["", "--worker 1/1", "--worker 1/2"] {
        assert_says(
            &desk.mistake(&format!("{other} {flag}")),
            &["g.parquet.workers", "other input or settings", "--fresh"],
        );
    }
    assert_says(
        &desk.mistake(&format!("{other} --worker 3/2")),
        &["no worker 3 of 2", "1/2 to 2/2"],
    );
    assert!(desk.run(&format!("{other} -q --fresh")).status.success());
    assert!(!desk.path("g.parquet.workers").exists());
}

/// The disk of one worker is full: it ends with one sentence, and another does the rest.
#[test]
fn a_worker_on_a_full_disk() {
    let desk = SYNTH.desk();
    for blocks in [0, 8] {
        on_a_full_disk(&desk, blocks, &format!("{} -q --worker 1/2", SYNTH.line));
    }
    assert!(SYNTH.worker(&desk, 2, 2).wait().unwrap().success());
    assert_eq!(SYNTH.times_done(&desk).len(), 10);
    SYNTH.finish(&desk, "-q");
}
