//! The limits of steps and evaluations of a search, which rise where they end many searches.

use serde::{Deserialize, Serialize};

use super::census::Census;
use super::outcome::SearchEnd;
use super::settings::SearchSettings;
use super::start::Start;

/// Searches since the last rise from which a further one may follow.
const SEEN: usize = 64;
/// Greatest number of times that the limits are doubled. In a bent valley whose walls are 10⁴ times as stiff as its bottom a
/// climb takes up to about 1000 steps.
const RISES: usize = 4;
/// One in so many searches must end by a limit before it rises: few do so where fragments of a cluster move apart.
const CUT: usize = 4;
/// One in so many searches must end at a saddle if numbers of hits are to tell what is missing. On reference surfaces two in
/// five or more do, and on bent valleys whose saddles were missed one in ten or fewer.
const FEW: usize = 5;

/// The limits at the end of a search, and what they did since they last rose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Limits {
    /// Greatest number of steps of a climb.
    pub steps: usize,
    /// Number of times that this number was doubled.
    pub rises: usize,
    /// Number of searches since the last time.
    pub searches: usize,
    /// Those that a limit ended.
    pub cut: usize,
    /// Those that ended at a saddle, wherever they began.
    pub arrived: usize,
    /// Of all searches, the number that ended at a saddle, and the number of all.
    pub whole: [usize; 2],
}

impl Limits {
    /// Whether the limits ended many searches, and more than arrived at a saddle.
    pub fn are_low(&self) -> bool {
        CUT * self.cut >= self.searches && self.cut > self.arrived
    }

    /// The number of searches that ended at a saddle, and of how many, if these are so few that numbers of hits say nothing of
    /// other saddles: since the limits last rose, or of all.
    pub fn few(&self) -> Option<[usize; 2]> {
        let counts = [[self.arrived, self.searches], self.whole];
        counts
            .into_iter()
            .find(|[arrived, all]| FEW * arrived < *all)
    }
}

/// The limits in the course of a search. They follow from counts at the ends of batches alone.
pub(super) struct Limit {
    settings: SearchSettings,
    pub(super) counts: Limits,
    /// Number of searches made before the last rise.
    risen: usize,
    /// Planned starts of searches that a limit ended.
    again: Vec<Start>,
}

impl Limit {
    pub(super) fn new(settings: &SearchSettings) -> Self {
        Self {
            settings: settings.clone(),
            counts: Limits {
                steps: settings.steps,
                ..Limits::default()
            },
            risen: 0,
            again: Vec::new(),
        }
    }

    /// The settings with the limits of now.
    pub(super) fn settings(&self) -> &SearchSettings {
        &self.settings
    }

    /// Number of the search since which nothing was new and no limit rose.
    pub(super) fn since(&self, census: &Census) -> usize {
        census.last_new.max(self.risen)
    }

    pub(super) fn note(&mut self, start: Start, end: SearchEnd) {
        self.counts.searches += 1;
        self.counts.whole[1] += 1;
        match end {
            SearchEnd::Arrived => {
                self.counts.arrived += 1;
                self.counts.whole[0] += 1;
            }
            SearchEnd::Steps | SearchEnd::Evaporated => {
                self.counts.cut += 1;
                if start != Start::Random {
                    self.again.push(start);
                }
            }
            _ => {}
        }
    }

    pub(super) fn rises(&self) -> bool {
        let counts = &self.counts;
        counts.searches >= SEEN && counts.rises < RISES && counts.are_low()
    }

    /// Doubles the limits and returns the planned starts of searches that they had ended.
    pub(super) fn rise(&mut self, census: &Census) -> Vec<Start> {
        self.settings.steps *= 2;
        self.settings.quench.max_evaluations *= 2;
        self.risen = census.searches;
        self.counts = Limits {
            steps: self.settings.steps,
            rises: self.counts.rises + 1,
            whole: self.counts.whole,
            ..Limits::default()
        };
        std::mem::take(&mut self.again)
    }
}
