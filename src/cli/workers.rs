//! The flag `--worker`, with which several processes share a run.

use std::str::FromStr;

use clap::Args;

use crate::store::Worker;

/// Sharing a run among processes.
#[derive(Debug, Args)]
pub(super) struct Share {
    #[expect(
        clippy::doc_markdown,
        reason = "the text is a help, where names are not code"
    )]
    /// Do the share of worker I of N, from 1/N to N/N, and write a journal only, in the folder OUTPUT.workers. Any number
    /// of workers may run at a time, on any machines that see the folder; each takes over what others leave. The same
    /// command without this flag joins the journals, does what is missing and writes the output. `auto` takes number and
    /// count from a Slurm array, `auto/N` the number from Slurm, HyperQueue or an indexed Kubernetes job.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["fresh", "resume"])]
    worker: Option<WorkerName>,
}

impl Share {
    /// Which worker this process is, if it is one.
    pub(super) fn worker(&self) -> anyhow::Result<Option<Worker>> {
        let environment = |name: &str| std::env::var(name).ok();
        (self.worker.as_ref())
            .map(|worker| worker.resolve(&environment))
            .transpose()
    }
}

/// A worker as users name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct WorkerName {
    /// `None` for `auto`.
    number: Option<usize>,
    count: Option<usize>,
}

impl FromStr for WorkerName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = || {
            format!(
                "`{text}` is no worker: give its number and the number of workers, such as 3/64, or auto or auto/64 in a job \
                 of a scheduler"
            )
        };
        let (number, count) = match text.split_once('/') {
            None => (text, None),
            Some((number, count)) => (number, Some(count.parse().map_err(|_not_a_number| help())?)),
        };
        let number = match (number, count) {
            ("auto", _) => None,
            (_, None) => return Err(help()),
            (number, Some(count)) => {
                let number: usize = number.parse().map_err(|_not_a_number| help())?;
                if !(1..=count).contains(&number) {
                    return Err(format!(
                        "there is no worker {number} of {count}: workers are counted from 1/{count} to {count}/{count}"
                    ));
                }
                Some(number)
            }
        };
        if count == Some(0) {
            return Err(help());
        }
        Ok(Self { number, count })
    }
}

/// Variables with the number of a task in an array of a scheduler, wherever its counting begins.
const NUMBERS: [&str; 3] = ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "JOB_COMPLETION_INDEX"];
/// The variable with the number of tasks in an array of Slurm.
const COUNT: &str = "SLURM_ARRAY_TASK_COUNT";

impl WorkerName {
    fn resolve(self, environment: &dyn Fn(&str) -> Option<String>) -> anyhow::Result<Worker> {
        let read = |name: &str| {
            let value = environment(name)?;
            let told = || anyhow::anyhow!("{name}: `{value}` is not the number of a task");
            Some(
                value
                    .trim()
                    .parse::<usize>()
                    .map_err(|_not_a_number| told()),
            )
        };
        if let (Some(number), Some(count)) = (self.number, self.count) {
            return Ok(Worker { number, count });
        }
        let task = NUMBERS.iter().find_map(|name| read(name));
        let task = task.ok_or_else(|| {
            anyhow::anyhow!(
                "--worker auto: none of {} is set: give the number of the worker, such as 3/64",
                NUMBERS.join(", ")
            )
        })??;
        let count = self.count.map(Ok).or_else(|| read(COUNT));
        let count = count.ok_or_else(|| {
            anyhow::anyhow!(
                "--worker auto: {COUNT} is not set, so the number of workers is not known: give it, such as auto/64"
            )
        })??;
        anyhow::ensure!(count > 0, "{COUNT} is 0");
        // Arrays are counted from 0, 1 or any other number; consecutive numbers are different workers.
        Ok(Worker {
            number: task % count + 1,
            count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(text: &str, variables: &[(&str, &str)]) -> Result<Worker, String> {
        let environment = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        let name: WorkerName = text.parse()?;
        name.resolve(&environment)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn workers_are_named_or_found() {
        let worker = |number, count| Ok(Worker { number, count });
        assert_eq!(resolved("3/64", &[]), worker(3, 64));
        assert_eq!(
            resolved("3/64", &[("SLURM_ARRAY_TASK_ID", "9")]),
            worker(3, 64)
        );
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "8"),
            ("SLURM_ARRAY_TASK_COUNT", "8"),
        ];
        assert_eq!(resolved("auto", &slurm), worker(1, 8));
        assert_eq!(resolved("auto/4", &[("HQ_TASK_ID", "2")]), worker(3, 4));
        assert_eq!(
            resolved("auto/4", &[("JOB_COMPLETION_INDEX", "0")]),
            worker(1, 4)
        );
    }

    #[test]
    fn unclear_workers_are_refused() {
        for text in [
            "", "3", "3/", "/4", "x/4", "0/4", "5/4", "1/0", "auto/0", "auto/x",
        ] {
            assert!(text.parse::<WorkerName>().is_err(), "{text}");
        }
        let told = |text, variables: &[_]| resolved(text, variables).unwrap_err();
        assert!(told("auto", &[]).contains("such as 3/64"));
        assert!(told("auto", &[("HQ_TASK_ID", "2")]).contains("auto/64"));
        assert!(told("auto/4", &[("HQ_TASK_ID", "two")]).contains("`two`"));
    }
}
