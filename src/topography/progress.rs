//! Progress reports of a long run.

use std::sync::atomic::{AtomicUsize, Ordering};

/// The stages of a run, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Phase {
    /// Descending from the start points.
    Quench,
    /// Basin hopping.
    Hop,
    /// Searching for saddles. The total assumes that nothing new is found.
    Search,
    /// Joining near minima that only the roughness of the energy divides.
    Ripple,
    /// Connecting near pairs.
    Connect,
    /// Joining components that are still separate.
    Join,
    /// Trying again the connections that decide the tree.
    Retry,
    /// Choosing temperature and force of the chains.
    Choose,
    /// Assigning minima to families one by one.
    Assign,
    /// Searching for lower ways across the merges of the tree.
    Cross,
    /// Synthesizing grasps.
    Synthesize,
    /// Cutting an object into convex pieces, whose number is not known before.
    Cut,
    /// Simulating grasps.
    Simulate,
    /// Labelling grasps.
    Label,
    /// Judging grasps.
    Judge,
    /// Eliminating minima from a network of rates.
    Eliminate,
}

impl Phase {
    /// What is being done, or what is counted, as users are told.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quench => "descending",
            Self::Ripple => "joining near minima",
            Self::Connect => "connecting pairs",
            Self::Join => "joining components",
            Self::Retry => "improving merges",
            Self::Choose => "choosing temperature and force",
            Self::Assign => "assigning minima",
            Self::Cross => "searching lower ways",
            Self::Search => "searching saddles",
            Self::Synthesize => "chains",
            Self::Cut => "cutting the object into convex pieces, the first time only",
            Self::Simulate | Self::Label | Self::Judge => "grasps",
            Self::Hop => "searching",
            Self::Eliminate => "eliminating minima",
        }
    }
}

/// How many tasks of a phase are finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The current phase.
    pub phase: Phase,
    /// Tasks finished, in whatever order.
    pub done: usize,
    /// Tasks of this phase known so far, or of this round of it; 0 for work that is not counted.
    pub total: usize,
    /// For a phase in rounds: which round this is, from 1, and how many there are at most. What a round finds decides whether
    /// there is another one.
    pub round: Option<(usize, usize)>,
}

/// Receives progress reports, from any thread.
pub type Observer<'a> = dyn Fn(Progress) + Sync + 'a;

pub(crate) struct Tally<'a> {
    phase: Phase,
    done: AtomicUsize,
    total: usize,
    round: Option<(usize, usize)>,
    observer: &'a Observer<'a>,
}

impl<'a> Tally<'a> {
    pub(super) fn after(
        phase: Phase,
        done: usize,
        total: usize,
        observer: &'a Observer<'a>,
    ) -> Self {
        Self::of_round(phase, None, (done, total), observer)
    }

    /// The tally of a round, given with the most there are, of whose tasks the first number is finished.
    pub(super) fn of_round(
        phase: Phase,
        round: Option<(usize, usize)>,
        (done, total): (usize, usize),
        observer: &'a Observer<'a>,
    ) -> Self {
        let tally = Self {
            phase,
            done: AtomicUsize::new(done),
            total,
            round,
            observer,
        };
        tally.tell(done);
        tally
    }

    fn tell(&self, done: usize) {
        (self.observer)(Progress {
            phase: self.phase,
            done,
            total: self.total,
            round: self.round,
        });
    }

    pub(crate) fn tick(&self) {
        self.tell(1 + self.done.fetch_add(1, Ordering::Relaxed));
    }
}
