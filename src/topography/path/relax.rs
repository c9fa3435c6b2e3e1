//! Relaxes rough paths between two minima to the lowest path, and determines its evidence.
//!
//! **When is a path relaxed?** Only the top of a path decides its height; elsewhere it only has to be lower. A path counts
//! as relaxed ([`Evidence::Path`]) if its top is stationary *and* doubling its images changes the height by less than a
//! hundredth of the barrier. Stationary means that the gradient is below the force tolerance. Tops are refined to passes and
//! pinned, the rest of the string relaxes further, and any new top is refined in turn. If descents from the highest pass
//! reach both minima, the evidence is better: [`Evidence::Saddle`].
//!
//! If tops are lowered ([`PathSettings::lowering`]), a path counts as relaxed when no move lowers its top *and* halving the
//! distance of its points hardly changes its height (see `lower`).

use super::images::Images;
use super::lower::{Lowered, lower, over};
use super::pass::{Pass, Peak, Refined};
use super::settings::{DEPARTURE, HEIGHT_TOLERANCE, LoweringSettings, PathSettings};
use super::{Path, near, spread};
use crate::energy::Energy;
use crate::optimize::QuenchSettings;
use crate::topography::minima::MatchTolerance;
use crate::topography::network::{Claim, Evidence, Minimum};

/// Number of parts in which a string over ripples relaxes roughly. It ends early once it rises by less than a ripple.
const COARSE_PARTS: usize = 3;

pub(in crate::topography) struct Outcome {
    pub(in crate::topography) path: Path,
    pub(in crate::topography) height: f64,
    pub(in crate::topography) top: Vec<f64>,
    pub(in crate::topography) evidence: Evidence,
    pub(in crate::topography) invalid_reason: Option<String>,
    pub(in crate::topography) passes: Vec<Pass>,
    /// Index of the start that gave the path.
    pub(in crate::topography) start: usize,
}

impl Outcome {
    fn claim(&self) -> Claim {
        Claim {
            invalid: self.invalid_reason.is_some(),
            height: self.height,
            evidence: self.evidence,
        }
    }
}

/// Relaxes the polygons `starts` from `ends.0` to `ends.1`: all of them roughly, then the lowest, and the others if that
/// one does not relax or they come close. `None` if every start is outside the domain.
///
/// On a surface with ripples, a rough path that would have to sink far to get below the `known` height is not refined.
pub(in crate::topography) fn relax(
    energy: &dyn Energy,
    ends: (&Minimum, &Minimum),
    starts: &[Vec<Vec<f64>>],
    settings: &PathSettings,
    descent: &QuenchSettings,
    sameness: &MatchTolerance,
    known: f64,
) -> Option<Outcome> {
    let rippled = settings.roughness > 0.0;
    let floor = ends.0.energy.max(ends.1.energy);
    let mut rough: Vec<(usize, bool, Images<'_>)> = starts
        .iter()
        .enumerate()
        .filter_map(|(start, points)| {
            let mut images = Images::new(energy, points, settings.segments, settings.max_step);
            if images.path.energies[1..settings.segments]
                .iter()
                .all(|e| !e.is_finite())
            {
                return None;
            }
            let parts = if rippled { COARSE_PARTS } else { 1 };
            for _ in 0..parts {
                if !(rippled && images.path.height() <= floor + settings.roughness) {
                    let iterations = settings.coarse_iterations / parts;
                    images.relax(iterations, settings.force_tolerance);
                }
            }
            if !images.path.height().is_finite() {
                return None;
            }
            let top = &images.path.images[images.path.top()];
            let invalid = energy.invalid_reason(top).is_some();
            Some((start, invalid, images))
        })
        .collect();
    rough.sort_by(|a, b| (a.1.cmp(&b.1)).then(a.2.path.height().total_cmp(&b.2.path.height())));
    let mut best: Option<Outcome> = None;
    let mut passes = Vec::new();
    for (start, invalid, images) in rough {
        let margin = settings.rivalry * (images.path.height() - floor);
        let beyond = |known: &Outcome| {
            known.evidence < Evidence::Chain
                && (rippled || invalid || images.path.height() - margin > known.height)
        };
        if best.as_ref().is_some_and(beyond) {
            continue;
        }
        let relaxation = Relaxation {
            energy,
            ends,
            settings,
            descent,
            sameness,
        };
        let mut outcome = if rippled && images.path.height() - margin > known {
            let (height, top) = (images.path.height(), images.path.top());
            let top = images.path.images[top].clone();
            relaxation.verdict(images.path, height, top, Evidence::Chain, Vec::new())
        } else {
            relaxation.finish(images)
        };
        outcome.start = start;
        passes.append(&mut outcome.passes);
        let slack = HEIGHT_TOLERANCE * (outcome.height - floor) + sameness.energy;
        let beaten = |known: &Outcome| outcome.claim().beats(known.claim(), sameness.energy, slack);
        if best.as_ref().is_none_or(beaten) {
            best = Some(outcome);
        }
    }
    let mut best = best?;
    best.passes = passes;
    Some(best)
}

pub(super) struct Relaxation<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) ends: (&'a Minimum, &'a Minimum),
    pub(super) settings: &'a PathSettings,
    pub(super) descent: &'a QuenchSettings,
    pub(super) sameness: &'a MatchTolerance,
}

impl<'a> Relaxation<'a> {
    /// Lowers the top of a path, then refines it if possible.
    fn finish_lowered(&self, rough: Path, floor: f64, lowering: &LoweringSettings) -> Outcome {
        let found = lower(self.energy, &rough.images, floor, self.settings, lowering);
        let Some(Lowered {
            path,
            peak,
            relaxed,
        }) = found
        else {
            let (height, top) = (rough.height(), rough.images[rough.top()].clone());
            return self.verdict(rough, height, top, Evidence::Chain, Vec::new());
        };
        if relaxed {
            let pass = peak.refine(
                self.energy,
                floor,
                self.settings,
                self.descent,
                self.sameness,
            );
            if let Some(Refined { pass, .. }) = pass {
                if let Some(path) = self.direct(&pass, path.images.len()) {
                    let (height, top) = (pass.energy.max(path.height()), pass.x.clone());
                    return self.verdict(path, height, top, Evidence::Saddle, vec![pass]);
                }
                if let Some(path) = over(self.energy, &path, &pass, floor, self.settings, lowering)
                {
                    let (height, top) = (path.height(), pass.x.clone());
                    return self.verdict(path, height, top, Evidence::Saddle, vec![pass]);
                }
            }
        }
        let height = path.height();
        let evidence = if relaxed {
            Evidence::Path
        } else {
            Evidence::Chain
        };
        self.verdict(path, height, peak.x, evidence, Vec::new())
    }

    fn finish(&self, mut images: Images<'a>) -> Outcome {
        let space = self.energy.space();
        let floor = self.ends.0.energy.max(self.ends.1.energy);
        if self.settings.roughness > 0.0 {
            return self.finish_rippled(images, floor);
        }
        self.insert(&mut images, floor);
        let reach = 2.0 * images.path.length(space) / (images.path.images.len() - 1) as f64;
        let (mut passes, mut doubled) = (Vec::new(), false);
        // The highest pinned energy and its point, and the last peak that could not be refined.
        let mut pinned = (floor, self.higher_end().to_vec());
        let mut loose: Option<Peak> = None;
        let mut round = 0;
        let relaxed = loop {
            let Some(peak) = Peak::of(self.energy, &images) else {
                loose = None;
                break true;
            };
            let slack = HEIGHT_TOLERANCE * (pinned.0 - floor) + self.sameness.energy;
            if peak.energy <= pinned.0 + slack {
                // It is not worth a refinement, but the path goes over it.
                loose = (peak.energy > pinned.0).then_some(peak);
                if doubled {
                    break true;
                }
                images = images.doubled();
                doubled = true;
                images.relax(self.settings.iterations / 2, self.settings.force_tolerance);
                continue;
            }
            if round == self.settings.rounds {
                let stationary = peak.residual(self.energy) <= self.settings.force_tolerance;
                let height = peak.energy;
                let before = loose.replace(peak).map(|peak| peak.energy);
                if !stationary {
                    break false;
                }
                let before = if doubled {
                    before
                } else {
                    images = images.doubled();
                    images.relax(self.settings.iterations, self.settings.force_tolerance);
                    loose = Peak::of(self.energy, &images);
                    Some(height)
                };
                break self.settled(loose.as_ref(), before, floor);
            }
            round += 1;
            let found = peak.refine(
                self.energy,
                floor,
                self.settings,
                self.descent,
                self.sameness,
            );
            let direct = (found.as_ref())
                .and_then(|found| self.direct(&found.pass, images.path.images.len()));
            // A pass that joins other minima belongs to this path only if it is near, or if the path lay on a higher ridge.
            let found = found.filter(|found| {
                direct.is_some() || found.beside || near(space, &found.pass.x, &peak.x) <= reach
            });
            if let Some(Refined { pass, .. }) = found {
                if let Some(path) = direct {
                    let (top, evidence) = (pass.x.clone(), Evidence::Saddle);
                    let height = pass.energy;
                    passes.push(pass);
                    return self.verdict(path, height, top, evidence, passes);
                }
                images.pin(peak.image, &pass.x, pass.energy);
                if pass.energy > pinned.0 {
                    pinned = (pass.energy, pass.x.clone());
                }
                passes.push(pass);
                loose = None;
            } else {
                loose = Some(peak);
            }
            images.relax(self.settings.iterations, self.settings.force_tolerance);
        };
        let (mut height, mut top) = pinned;
        if let Some(peak) = loose
            && peak.energy > height
        {
            (height, top) = (peak.energy, peak.x);
        }
        // The reported height is never below the highest energy found.
        if images.path.height() > height {
            height = images.path.height();
            top.clone_from(&images.path.images[images.path.top()]);
        }
        let evidence = if relaxed {
            Evidence::Path
        } else {
            Evidence::Chain
        };
        self.verdict(images.path, height, top, evidence, passes)
    }

    /// Leads a path over passes, and lowers its top if that fails and lowering is set.
    fn finish_rippled(&self, images: Images<'a>, floor: f64) -> Outcome {
        let rough = self.finish_rough(images, floor);
        let Some(lowering) = &self.settings.lowering else {
            return rough;
        };
        if rough.evidence <= Evidence::Path {
            return rough;
        }
        let mut lowered = self.finish_lowered(rough.path, floor, lowering);
        lowered.passes.extend(rough.passes);
        if lowered.evidence <= Evidence::Saddle {
            return lowered;
        }
        // The lowered top lies nearer to a pass than the rough one did.
        let images = Images::new(
            self.energy,
            &lowered.path.images,
            self.settings.segments,
            self.settings.max_step,
        );
        let mut led = self.finish_rough(images, floor);
        let slack = self.settings.slack(lowered.height - floor);
        if led.evidence == Evidence::Saddle && led.height <= lowered.height + slack {
            led.passes.append(&mut lowered.passes);
            return led;
        }
        lowered.passes.append(&mut led.passes);
        lowered
    }

    /// Splits segments on which the surface differs too much from the cubic through the ends.
    fn insert(&self, images: &mut Images<'_>, floor: f64) {
        for _ in 0..self.settings.insertions {
            let barrier = (images.path.height() - floor).max(0.0);
            let tolerance = DEPARTURE * barrier + self.settings.energy_tolerance;
            let Some(finer) = images.inserted(tolerance) else {
                break;
            };
            *images = finer;
            images.relax(self.settings.iterations / 2, self.settings.force_tolerance);
        }
    }

    /// Whether a peak that could not be refined to a pass is nevertheless stationary, with unchanged height.
    fn settled(&self, peak: Option<&Peak>, before: Option<f64>, floor: f64) -> bool {
        peak.zip(before).is_some_and(|(peak, before)| {
            let slack = HEIGHT_TOLERANCE * (peak.energy - floor);
            (peak.energy - before).abs() <= slack + self.sameness.energy
                && peak.residual(self.energy) <= self.settings.force_tolerance
        })
    }

    fn higher_end(&self) -> &[f64] {
        if self.ends.0.energy > self.ends.1.energy {
            &self.ends.0.coordinates
        } else {
            &self.ends.1.coordinates
        }
    }

    /// The path down both sides of a pass, if it joins the two minima directly.
    fn direct(&self, pass: &Pass, images: usize) -> Option<Path> {
        let space = self.energy.space();
        let lands = |side: usize, minimum: &Minimum| {
            let end = pass.descents[side].images.len() - 1;
            let x = &pass.descents[side].images[end];
            self.sameness
                .holds(space, x, pass.descents[side].energies[end], minimum)
        };
        let (up, down) = if lands(0, self.ends.0) && lands(1, self.ends.1) {
            (0, 1)
        } else if lands(1, self.ends.0) && lands(0, self.ends.1) {
            (1, 0)
        } else {
            return None;
        };
        let half = images.div_ceil(2).max(2);
        let mut ahead = spread(space, &pass.descents[down].images, half);
        let mut path = spread(space, &pass.descents[up].images, half);
        path.reverse();
        path.pop();
        path.append(&mut ahead);
        let last = path.len() - 1;
        path[0].clone_from(&self.ends.0.coordinates);
        path[last].clone_from(&self.ends.1.coordinates);
        Some(Path::through(self.energy, path))
    }

    pub(super) fn verdict(
        &self,
        mut path: Path,
        height: f64,
        top: Vec<f64>,
        evidence: Evidence,
        passes: Vec<Pass>,
    ) -> Outcome {
        path.unfold(self.energy.space());
        let invalid_reason = self.energy.invalid_reason(&top);
        Outcome {
            path,
            height,
            top,
            evidence: if invalid_reason.is_some() {
                evidence.max(Evidence::Chain)
            } else {
                evidence
            },
            invalid_reason,
            passes,
            start: 0,
        }
    }
}
