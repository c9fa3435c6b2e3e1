//! Chains and the means of their batches.

use landscape::sample::{Kernel, State, TargetDensity, Task, stream};
use rand::RngExt;
use rayon::prelude::*;

/// How a proposal is decided on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// By the ratio that the kernel returns.
    Exact,
    /// By the energies alone, as if the proposal were as likely backward as forward.
    Plain,
    /// Every proposal is accepted.
    Always,
}

/// How long chains run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    pub(crate) rule: Rule,
    pub(crate) temperature: f64,
    pub(crate) step: f64,
    /// Independent chains.
    pub(crate) chains: u64,
    /// Batches of each chain, after one that is thrown away.
    pub(crate) batches: u32,
    /// Steps of a batch: many more than the chain needs to forget.
    pub(crate) length: u32,
}

/// What chains have seen.
#[derive(Debug)]
pub(crate) struct Seen {
    /// Means of the observables, batch by batch.
    pub(crate) batches: Vec<Vec<f64>>,
    /// Share of the proposals that were accepted.
    pub(crate) acceptance: f64,
}

/// Runs chains of `kernel` from `start`; `observe` adds what it sees of a state to as many sums as `observables`.
pub(crate) fn run(
    kernel: &dyn Kernel,
    start: &[f64],
    run: Run,
    observables: usize,
    observe: impl Fn(&State, &mut [f64]) + Sync,
) -> Seen {
    let law = TargetDensity {
        temperature: run.temperature,
        attraction: None,
    };
    let chains: Vec<(Vec<Vec<f64>>, f64)> = (0..run.chains)
        .into_par_iter()
        .map(|chain| {
            let mut rng = stream(11, Task::Synthesis, chain);
            let mut state = kernel.start(start);
            let mut proposal = State::default();
            let mut accepted = 0.0;
            let mut means = Vec::new();
            for _ in 0..=run.batches {
                let mut sums = vec![0.0; observables];
                for _ in 0..run.length {
                    let exact = kernel.propose(&state, &law, run.step, &mut rng, &mut proposal);
                    let log_ratio = match run.rule {
                        Rule::Exact => exact,
                        Rule::Plain => (state.energy - proposal.energy) / run.temperature,
                        Rule::Always => 0.0,
                    };
                    if rng.random::<f64>().ln() < log_ratio {
                        std::mem::swap(&mut state, &mut proposal);
                        accepted += 1.0;
                    }
                    observe(&state, &mut sums);
                }
                means.push(sums.iter().map(|sum| sum / f64::from(run.length)).collect());
            }
            means.remove(0);
            (means, accepted / f64::from((run.batches + 1) * run.length))
        })
        .collect();
    Seen {
        acceptance: chains.iter().map(|(_, share)| share).sum::<f64>() / chains.len() as f64,
        batches: chains.into_iter().flat_map(|(means, _)| means).collect(),
    }
}
