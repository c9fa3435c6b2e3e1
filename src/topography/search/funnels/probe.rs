//! Whether a landscape is small enough to enumerate.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::energy::{Counted, Energy};
use crate::optimize::quench;
use crate::sample::{Task, stream};
use crate::topography::rarefaction::unseen;
use crate::topography::search::{Draw, SearchSettings};

/// Number of descents, and of the first ones, after which a landscape that repeats itself needs no more.
const DESCENTS: [u64; 2] = [200, 1000];
/// Least number of searches for each minimum with which an enumeration is worth its while.
const EACH: usize = 30;
/// Share of the time that the descents may take.
const SHARE: f64 = 0.1;
/// First number of the random streams of these descents.
const FIRST: u64 = 1 << 62;

/// Descents from random points, and how many minima they suggest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SizeProbe {
    /// Descents that ended in a minimum.
    pub descents: usize,
    /// Different energies of these minima.
    pub distinct: usize,
    /// Energies met once.
    pub once: usize,
    /// Chao's lower bound of the number of minima that differ in energy.
    pub minima: f64,
    /// Whether the time ended the descents.
    #[serde(default)]
    pub cut: bool,
    /// Evaluations spent.
    pub evaluations: usize,
}

impl SizeProbe {
    /// Whether an enumeration cannot end: each minimum alone needs dozens of searches, and together that is more than the
    /// greatest number of searches. Descents that time ended while most of them found something new are taken for a sign of
    /// the same. Little patience or more searches than the default allow larger landscapes; to stop early
    /// does not make a landscape large.
    pub fn is_too_large(&self, settings: &SearchSettings) -> bool {
        let usual = SearchSettings::default();
        let patience = settings.patience.min(EACH);
        let searches = settings.max_searches.max(usual.max_searches);
        let unknown = self.cut && 2 * self.distinct > self.descents;
        unknown || self.minima * patience as f64 > searches as f64
    }
}

/// Descends from up to a thousand random points and compares the energies. The result depends on the seed alone, unless
/// `enough` (that of [`Run`](crate::topography::Run)), which is asked before each descent, tells that a tenth of the time is
/// over.
pub fn probe_size(
    energy: &dyn Energy,
    draw: &Draw<'_>,
    settings: &SearchSettings,
    enough: &(dyn Fn(f64) -> bool + Sync),
) -> SizeProbe {
    let enough = || enough(SHARE);
    let counted = Counted::new(energy);
    let mut energies: Vec<f64> = Vec::new();
    let mut probe = SizeProbe {
        descents: 0,
        distinct: 0,
        once: 0,
        minima: 0.0,
        cut: false,
        evaluations: 0,
    };
    let mut done = 0;
    for count in DESCENTS {
        let descent = |id: u64| {
            if enough() {
                return None;
            }
            let start = draw(&mut stream(settings.seed, Task::Start, FIRST + id));
            let end = quench(&counted, &start, &settings.quench);
            settings.is_finished(&end).then_some(end.energy)
        };
        let found: Vec<Option<f64>> = (done..count).into_par_iter().map(descent).collect();
        energies.extend(found.into_iter().flatten());
        done = count;
        energies.sort_by(f64::total_cmp);
        let near = |a: &f64, b: &f64| b - a <= settings.sameness.energy;
        let hits: Vec<usize> = energies.chunk_by(near).map(<[f64]>::len).collect();
        let met = |times: usize| hits.iter().filter(|hits| **hits == times).count();
        probe = SizeProbe {
            descents: energies.len(),
            distinct: hits.len(),
            once: met(1),
            minima: hits.len() as f64 + unseen(energies.len(), met(1), met(2)),
            cut: enough(),
            evaluations: usize::try_from(counted.evaluations()).unwrap_or(usize::MAX),
        };
        if 2 * probe.distinct <= probe.descents || probe.cut {
            break;
        }
    }
    probe
}
