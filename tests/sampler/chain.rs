//! Chains and their batch means.

use landscape::sample::{Kernel, State, TargetDensity, Task, stream};
use rand::RngExt;
use rayon::prelude::*;

/// Rule for the decision about a proposal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// Uses the ratio that the kernel returns.
    Exact,
    /// Uses the energies only, as if proposals were symmetric.
    Plain,
    /// Accepts every proposal.
    Always,
}

/// Length of the chains.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run {
    pub(crate) rule: Rule,
    pub(crate) temperature: f64,
    pub(crate) step: f64,
    /// Number of independent chains.
    pub(crate) chains: u64,
    /// Number of batches of each chain, after a discarded first one.
    pub(crate) batches: u32,
    /// Number of steps in a batch, much greater than the correlation time of the chain.
    pub(crate) length: u32,
}

/// Observations of chains.
#[derive(Debug)]
pub(crate) struct Seen {
    /// Means of the observables, batch by batch.
    pub(crate) batches: Vec<Vec<f64>>,
    /// Share of accepted proposals.
    pub(crate) acceptance: f64,
}

/// Runs chains of `kernel` from `start`. `observe` adds the observables of a state to `observables` sums.
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
                    if libm::log(rng.random::<f64>()) < log_ratio {
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
