//! What a watcher of a long run is told.

use std::sync::atomic::{AtomicUsize, Ordering};

/// The stages of a run, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Phase {
    /// Descending from the starts.
    Quench,
    /// Basin hopping.
    Hop,
    /// Searching saddles; the total is what the search would take if nothing new turned up.
    Search,
    /// Choosing pairs.
    Pairs,
    /// Connecting near pairs.
    Connect,
    /// Joining what is still apart.
    Join,
    /// Trying the connections that decide the tree again.
    Retry,
    /// Measuring the magnetisation diagram.
    Diagram,
    /// Assigning minima to groups one by one.
    Assign,
    /// Running more chains between the pairs that decide the tree.
    Replicate,
}

/// Tasks done of those of a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub phase: Phase,
    /// Tasks finished, in whatever order.
    pub done: usize,
    /// Tasks of this phase known so far.
    pub total: usize,
}

/// A watcher, called from any thread.
pub type Observer<'a> = dyn Fn(Progress) + Sync + 'a;

/// Counts the tasks of one phase.
pub(super) struct Tally<'a> {
    phase: Phase,
    done: AtomicUsize,
    total: usize,
    observer: &'a Observer<'a>,
}

impl<'a> Tally<'a> {
    /// With `done` tasks already finished.
    pub(super) fn after(
        phase: Phase,
        done: usize,
        total: usize,
        observer: &'a Observer<'a>,
    ) -> Self {
        observer(Progress { phase, done, total });
        Self {
            phase,
            done: AtomicUsize::new(done),
            total,
            observer,
        }
    }

    pub(super) fn tick(&self) {
        (self.observer)(Progress {
            phase: self.phase,
            done: 1 + self.done.fetch_add(1, Ordering::Relaxed),
            total: self.total,
        });
    }
}
