//! One search: a climb to a saddle and the descents on both sides.

use super::census::Census;
use super::outcome::{Outcome, SearchEnd};
use super::searcher::Searcher;
use super::start::{Place, Start};
use crate::energy::Counted;
use crate::optimize::StopReason;
use crate::space::vector::{add, scale};
use crate::topography::barrier::Crossing;
use crate::topography::eigen::Scaled;
use crate::topography::follow::{Following, Lost, Saddle};
use crate::topography::minima::QuenchRecord;
use crate::topography::path::{Pass, Path, descend, descend_one_way, leave_ridges};

/// Displacement off a saddle, relative to the length of the surface.
pub(super) const PUSH: f64 = 0.1;
/// Length at which the step along one mode saturates, in units of the length of the surface. It is far beyond the range in
/// which the Hessian can be trusted, so it limits only the steps along very soft modes.
const SATURATION: f64 = 10.0;
/// Step of the finite differences of gradients, relative to the longest step.
const DIFFERENCE: f64 = 1e-4;
/// Number of times the displacement is halved until both sides lead down.
const HALVINGS: i32 = 8;

/// Relative curvature below which a mode of a saddle is degenerate, so that more than two valleys may meet.
const DEGENERATE: f64 = 1e-3;
/// Greatest number of degenerate modes examined, and of directions in the plane of two of them.
const MODES: usize = 4;
const DIRECTIONS: u32 = 12;

impl Searcher<'_> {
    /// Runs search number `id`. The outcome depends only on the number, the start and the census.
    pub(super) fn run(&self, id: u64, start: Start, census: &Census) -> Outcome {
        let counted = Counted::new(self.energy);
        let counting = Searcher {
            energy: &counted,
            ..*self
        };
        let place = counting.place(id, start, census);
        let mut outcome = counting.climb(&place, census);
        // A search that returns to the saddle beside which it began says nothing about how hard that saddle is to meet.
        let returned = |known: &usize| {
            place
                .beside
                .is_some_and(|beside| census.are_one(beside, *known))
        };
        outcome.known = outcome.known.filter(|known| !returned(known));
        let drawn = place.drawn.as_ref();
        outcome.unfinished = drawn.is_some_and(|end| self.settings.is_unfinished(end));
        outcome.drawn = (place.drawn)
            .filter(|end| end.stop != StopReason::Budget && end.energy.is_finite())
            .map(QuenchRecord);
        outcome.evaluations = usize::try_from(counted.evaluations()).unwrap_or(usize::MAX);
        outcome
    }

    fn climb(&self, place: &Place, census: &Census) -> Outcome {
        let mut outcome = Outcome {
            fate: SearchEnd::Arrived,
            known: None,
            found: None,
            branches: Vec::new(),
            drawn: None,
            undecided: None,
            unfinished: false,
            evaluations: 0,
        };
        let following = Following {
            tolerance: self.settings.quench.gradient_tolerance,
            longest: place.longest,
            saturation: SATURATION * self.settings.length,
            level: PUSH * self.settings.length,
            // Bold steps may cross regions where the curvature changes, but finite differences must not.
            difference: DIFFERENCE * place.longest.min(self.settings.length),
            steps: self.settings.steps,
            kicks: 1,
            keeps_mode: true,
            ceiling: census.ceiling(self.settings.energy),
            known: &|x, energy| census.saddle(self.energy.space(), x, energy),
        };
        let saddle =
            match Scaled::new(self.energy).follow(&place.x, place.hint.as_deref(), &following) {
                Ok(saddle) => saddle,
                Err(lost) => {
                    match lost {
                        Lost::Known(saddle) => outcome.known = Some(saddle),
                        Lost::Outside => outcome.fate = SearchEnd::Outside,
                        Lost::High => outcome.fate = SearchEnd::High,
                        Lost::Steps => outcome.fate = SearchEnd::Steps,
                        Lost::Index => outcome.fate = SearchEnd::Index,
                        Lost::Undecided(x, height) => outcome.undecided = Some((x, height)),
                        Lost::Flat => outcome.fate = SearchEnd::Flat,
                    }
                    return outcome;
                }
            };
        // If a saddle is very close to its minimum, a displacement of the usual length can end above the saddle again.
        let descents = (0..HALVINGS).find_map(|halvings| {
            descend(
                self.energy,
                (&saddle.x, saddle.energy),
                &saddle.modes[0],
                PUSH * self.settings.length * 0.5_f64.powi(halvings),
                &self.settings.quench,
            )
        });
        let mut ways: Vec<Path> = descents.into_iter().flatten().collect();
        self.branch(&saddle, &mut ways);
        for way in &mut ways {
            self.leave_ridges(way, census);
        }
        if ways.len() < 2 {
            outcome.fate = SearchEnd::Evaporated;
            return outcome;
        }
        let mut crossings = ways[1..].iter().map(|way| {
            Crossing::from(Pass {
                x: saddle.x.clone(),
                energy: saddle.energy,
                residual: saddle.residual,
                descents: [ways[0].clone(), way.clone()],
            })
        });
        outcome.found = crossings.next();
        outcome.branches = crossings.collect();
        outcome
    }

    /// Continues a descent that did not end at a known minimum, if it rests at a saddle.
    fn leave_ridges(&self, way: &mut Path, census: &Census) {
        let (space, length) = (self.energy.space(), self.settings.length);
        let last = way.images.len() - 1;
        let end = (&way.images[last], way.energies[last]);
        if census.minimum_at(space, end.0, end.1).is_none() {
            let (push, difference) = (PUSH * length, DIFFERENCE * length);
            leave_ridges(self.energy, way, push, difference, &self.settings.quench);
        }
    }

    /// Adds to the descents from a degenerate saddle those to other minima (at a monkey saddle, for example, three valleys
    /// meet). It adds nothing if at most one mode is degenerate.
    fn branch(&self, saddle: &Saddle, ways: &mut Vec<Path>) {
        let settings = self.settings;
        let degenerate = DEGENERATE * settings.energy / (settings.length * settings.length);
        let small = |curvature: &&f64| curvature.abs() <= degenerate;
        let count = saddle
            .curvatures
            .iter()
            .take_while(small)
            .count()
            .min(MODES);
        let space = self.energy.space();
        for (i, first) in saddle.modes[..count].iter().enumerate() {
            for second in &saddle.modes[i + 1..count] {
                for k in 0..DIRECTIONS {
                    let angle = std::f64::consts::TAU * f64::from(k) / f64::from(DIRECTIONS);
                    let mut direction = first.clone();
                    scale(&mut direction, libm::cos(angle));
                    add(&mut direction, libm::sin(angle), second);
                    let Some(branch) = descend_one_way(
                        self.energy,
                        (&saddle.x, saddle.energy),
                        &direction,
                        PUSH * settings.length,
                        &settings.quench,
                    ) else {
                        continue;
                    };
                    let end = |way: &Path| way.images.len() - 1;
                    let (x, height) = (&branch.images[end(&branch)], branch.energies[end(&branch)]);
                    let known = ways.iter().any(|way| {
                        (height - way.energies[end(way)]).abs() <= settings.sameness.energy
                            && space.within(x, &way.images[end(way)], settings.sameness.distance)
                    });
                    if !known {
                        ways.push(branch);
                    }
                }
            }
        }
    }
}
