//! Which points of a flat bottom are one minimum.
//!
//! A descent ends anywhere on a plateau, a trough or a ring, and anywhere near the bottom of a well that rises more slowly than
//! x⁴, because the gradient is below the tolerance there. The distance of two such ends tells nothing.

use crate::energy::Energy;
use crate::optimize::quench;
use crate::space::vector::{add, dot, norm, scale};
use crate::topography::audit::{Audit, AuditSettings, Verdict};
use crate::topography::eigen::Scaled;
use crate::topography::trough::joins;

/// Ends of descents where the softest curvature is below this fraction of the stiffest may lie farther from the minimum than
/// the distance tolerance: along xⁿ the gradient is below 10⁻⁸ where the curvature is below 10⁻⁵, for n ≥ 5.
const SOFT: f64 = 1e-4;
/// A curvature vanishes if at the tolerance of distance its gradient is at most so many tolerances.
const LOOSE: f64 = 10.0;
/// Number of parts into which a line is divided, and their length in distance tolerances if the greatest number allows it.
const PARTS: [usize; 2] = [8, 64];
const PART: f64 = 25.0;
/// Maximum number of rounds in which descents shorten the gap between two points of one energy, each to about 0.6.
const SHORTENINGS: usize = 8;
/// Places between two points where descents begin, the next ones only if the first one does not shorten the gap: along the
/// line, and aside in units of its length. The middle of a symmetric pair lies on a ridge, and so does nearly all of a line
/// between opposite points of a ring, off which a descent from beside the ridge leads.
const BEGINNINGS: [[f64; 2]; 3] = [[0.382, 0.0], [0.49, 0.2], [0.51, -0.2]];
/// If the descents leave more than this fraction of a gap, a ridge divides it.
const STUCK: f64 = 0.9;
/// Number of nearest sets of one energy that a new point may belong to.
const NEAREST: usize = 4;

/// A stationary point that passed its audit.
#[derive(Clone, Copy)]
pub(super) struct Bottom<'a> {
    pub(super) x: &'a [f64],
    pub(super) energy: f64,
    pub(super) audit: &'a Audit,
}

impl Bottom<'_> {
    pub(super) fn is_degenerate(&self) -> bool {
        self.audit.verdict == Verdict::Degenerate
    }

    /// Whether a gradient within its tolerance hardly tells where the point is.
    fn is_loose(&self, settings: &AuditSettings) -> bool {
        let slope = |curvature: &f64| curvature.abs() * settings.sameness.distance;
        let mut curvatures = self.audit.curvatures.iter();
        curvatures.any(|curvature| slope(curvature) <= LOOSE * settings.gradient_tolerance)
    }

    fn is_flat(&self) -> bool {
        let sizes = self.audit.curvatures.iter().map(|size| size.abs());
        let (softest, stiffest) = sizes.fold((f64::INFINITY, 0.0_f64), |(low, high), size| {
            (low.min(size), high.max(size))
        });
        self.is_degenerate() || softest <= SOFT * stiffest
    }
}

/// The known minimum, if any, of which `new` is another point; `known` are the minima of nearly its energy with their
/// numbers.
///
/// Two points of flat bottoms are one minimum if the energy on the line between them does not rise above the higher one: a
/// true minimum is the lowest point of its neighbourhood on every line. Points of rings, troughs and plateaus are also one if
/// a walk along the level directions leads from one to the other, and otherwise unless descents from between them end on both
/// sides of a ridge. Where such descents end elsewhere, they tell nothing.
pub(super) fn same_bottom<'a>(
    energy: &dyn Energy,
    new: &Bottom<'_>,
    known: impl Iterator<Item = (usize, Bottom<'a>)>,
    settings: &AuditSettings,
) -> Option<usize> {
    if !new.is_flat() {
        return None;
    }
    let ground = Ground { energy, settings };
    let known: Vec<(usize, Bottom<'_>)> = known.filter(|(_, bottom)| bottom.is_flat()).collect();
    let here = (new.x, new.energy);
    let level = known
        .iter()
        .find(|(_, bottom)| ground.is_level(here, (bottom.x, bottom.energy)));
    if let Some((number, _)) = level {
        return Some(*number);
    }
    if !new.is_degenerate() {
        return None;
    }
    let mut sets: Vec<(f64, usize, &[f64])> = (known.iter())
        .filter(|(_, bottom)| bottom.is_degenerate())
        .map(|(number, bottom)| (energy.space().distance(new.x, bottom.x), *number, bottom.x))
        .collect();
    sets.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    sets.truncate(NEAREST);
    let joined = sets.iter().find(|(_, _, x)| ground.are_joined(here, x));
    let unparted = || sets.iter().find(|(_, _, x)| !ground.are_parted(here, x));
    let (_, number, _) = joined.or_else(unparted)?;
    Some(*number)
}

/// Whether a point belongs to the bottom of a minimum of nearly its energy: it lies within the tolerance of distance, or the energy
/// on the line between them does not rise above the higher one.
pub(super) fn is_of_bottom(
    energy: &dyn Energy,
    point: (&[f64], f64),
    minimum: (&[f64], f64),
    settings: &AuditSettings,
) -> bool {
    let ground = Ground { energy, settings };
    (energy.space()).within(point.0, minimum.0, settings.sameness.distance)
        || ground.is_level(point, minimum)
}

/// The known saddle, if any, of which the saddle `new` is another point; `known` are those of nearly its energy with their
/// numbers. Where curvatures vanish, searches end anywhere near the saddle. The energy on the line between two such ends
/// neither rises nor falls.
pub(super) fn same_saddle<'a>(
    energy: &dyn Energy,
    new: &Bottom<'_>,
    known: impl Iterator<Item = (usize, Bottom<'a>)>,
    settings: &AuditSettings,
) -> Option<usize> {
    let ground = Ground { energy, settings };
    let mut loose = known.filter(|(_, saddle)| saddle.is_loose(settings));
    let here = (new.x, new.energy);
    let is_same = |saddle: &Bottom<'_>| ground.is_even(here, (saddle.x, saddle.energy));
    let same = new
        .is_loose(settings)
        .then(|| loose.find(|(_, saddle)| is_same(saddle)));
    same.flatten().map(|(number, _)| number)
}

/// The energy and what counts as level.
struct Ground<'a> {
    energy: &'a dyn Energy,
    settings: &'a AuditSettings,
}

impl Ground<'_> {
    /// Whether the energy on the line between two points never rises above the higher one.
    fn is_level(&self, a: (&[f64], f64), b: (&[f64], f64)) -> bool {
        let higher = a.1.max(b.1);
        let most = higher + self.settings.noise(higher);
        self.all_between(a.0, b.0, |height| height <= most)
    }

    /// Whether the energy on the line between two points neither rises nor falls.
    fn is_even(&self, a: (&[f64], f64), b: (&[f64], f64)) -> bool {
        let most = (a.1 - b.1).abs() + self.settings.noise(a.1);
        self.all_between(a.0, b.0, |height| (height - a.1).abs() <= most)
    }

    /// Whether this holds for the energies on the line between two points.
    fn all_between(&self, a: &[f64], b: &[f64], holds: impl Fn(f64) -> bool) -> bool {
        let space = self.energy.space();
        let mut tangent = vec![0.0; space.tangents()];
        let distance = space.log(a, b, &mut tangent);
        let [mut parts, greatest] = PARTS;
        while parts < greatest && distance > PART * self.settings.sameness.distance * parts as f64 {
            parts *= 2;
        }
        let mut gradient = vec![0.0; tangent.len()];
        let mut height = |part: usize| {
            let (mut x, mut step) = (a.to_vec(), tangent.clone());
            scale(&mut step, part as f64 / parts as f64);
            space.exp(&mut x, &step);
            self.energy.evaluate(&x, &mut gradient)
        };
        // A ridge is most likely in the middle.
        let mut between = (0..parts)
            .map(|part| (part + parts / 2) % parts)
            .filter(|part| *part > 0);
        between.all(|part| holds(height(part)))
    }

    /// Whether a walk along the set of one of the points leads to the other.
    fn are_joined(&self, (a, level): (&[f64], f64), b: &[f64]) -> bool {
        let surface = Scaled::new(self.energy);
        joins(&surface, a, b, self.settings, &|x| {
            self.is_level((x, level), (b, level))
        })
    }

    /// Whether a ridge divides two points of one energy: descents from between them shorten the gap only up to a rest.
    fn are_parted(&self, (a, level): (&[f64], f64), b: &[f64]) -> bool {
        let mut ends = [a.to_vec(), b.to_vec()];
        for _ in 0..SHORTENINGS {
            match self.shortened(ends, level) {
                Gap::Shorter(shorter) => ends = shorter,
                Gap::Ridge => return true,
                Gap::Closed | Gap::Unknown => return false,
            }
        }
        false
    }

    /// What descents from between two points of one energy make of the gap.
    fn shortened(&self, [a, b]: [Vec<f64>; 2], level: f64) -> Gap {
        let space = self.energy.space();
        let mut along = vec![0.0; space.tangents()];
        let gap = space.log(&a, &b, &mut along);
        let aside = perpendicular(&along);
        let open = |one: &[f64], other: &[f64]| {
            let is_open = !self.is_level((one, level), (other, level));
            is_open.then(|| space.distance(one, other))
        };
        for [part, off] in BEGINNINGS {
            let mut start = a.clone();
            let step = along.iter().zip(&aside);
            let step: Vec<f64> = step
                .map(|(along, aside)| part * along + off * aside)
                .collect();
            space.exp(&mut start, &step);
            let end = quench(self.energy, &start, &self.settings.quench);
            let resting = end.gradient_norm <= self.settings.gradient_tolerance;
            if !(resting && (end.energy - level).abs() <= self.settings.sameness.energy) {
                return Gap::Unknown;
            }
            match [open(&a, &end.x), open(&end.x, &b)].map(|rest| rest.unwrap_or(0.0)) {
                [first, second] if first.max(second) > STUCK * gap => {}
                [first, second] if first > second => return Gap::Shorter([a, end.x]),
                [_, second] if second > 0.0 => return Gap::Shorter([end.x, b]),
                _ => return Gap::Closed,
            }
        }
        Gap::Ridge
    }
}

/// A tangent of the same length that is perpendicular to this one and has no other symmetry; 0 if there is none.
fn perpendicular(tangent: &[f64]) -> Vec<f64> {
    let components = (1..=tangent.len()).map(|k| libm::sin((k * k) as f64));
    let mut aside: Vec<f64> = components.collect();
    let part = dot(&aside, tangent) / dot(tangent, tangent).max(f64::MIN_POSITIVE);
    add(&mut aside, -part, tangent);
    let length = norm(&aside);
    if length > 1e-9 {
        scale(&mut aside, norm(tangent) / length);
    }
    aside
}

/// What is known of the gap between two points of one energy.
enum Gap {
    /// Level lines join them.
    Closed,
    /// The longer part that is left.
    Shorter([Vec<f64>; 2]),
    /// A ridge divides them.
    Ridge,
    /// A descent ended at another energy.
    Unknown,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::FunctionOn;
    use crate::space::Euclidean;
    use crate::topography::audit::audit;

    /// The numbers that `same_bottom` gives to points of a plane, one after the other.
    fn numbers(
        function: impl Fn(f64, f64) -> (f64, [f64; 2]) + Sync,
        points: &[[f64; 2]],
    ) -> Vec<usize> {
        let energy = FunctionOn::new(Euclidean::new(2), move |p: &[f64], gradient: &mut [f64]| {
            let (energy, slopes) = function(p[0], p[1]);
            gradient.copy_from_slice(&slopes);
            energy
        });
        let settings = AuditSettings::default();
        let points: Vec<Vec<f64>> = points.iter().map(|point| point.to_vec()).collect();
        let audits = audit(&energy, &points, 0, &settings);
        let bottom = |k: usize| {
            assert!(audits[k].verdict.is_stationary(), "{k}: {:?}", audits[k]);
            Bottom {
                x: &points[k],
                energy: energy.evaluate(&points[k], &mut [0.0; 2]),
                audit: &audits[k],
            }
        };
        let mut kept: Vec<usize> = Vec::new();
        (0..points.len())
            .map(|k| {
                let known = kept.iter().map(|place| bottom(*place)).enumerate();
                let known: Vec<_> = known.collect();
                same_bottom(&energy, &bottom(k), known.into_iter(), &settings).unwrap_or_else(
                    || {
                        kept.push(k);
                        kept.len() - 1
                    },
                )
            })
            .collect()
    }

    #[test]
    fn wells_that_rise_slowly_have_one_bottom() {
        let sextic = |x: f64, y: f64| (x.powi(6) + y * y, [6.0 * x.powi(5), 2.0 * y]);
        let points = [[0.004, 0.0], [-0.004, 0.0], [0.002, 0.0]];
        assert_eq!(numbers(sextic, &points), [0, 0, 0]);
        // A soft double well is not level between its minima.
        let double = |x: f64, y: f64| {
            let valley = x * x - 0.01;
            (valley * valley + 1e4 * y * y, [4.0 * x * valley, 2e4 * y])
        };
        assert_eq!(numbers(double, &[[0.1, 0.0], [-0.1, 0.0]]), [0, 1]);
    }

    #[test]
    fn troughs_are_followed_and_ridges_divide() {
        let ring = |x: f64, y: f64| {
            let s = x * x + y * y - 1.0;
            (s * s, [4.0 * s * x, 4.0 * s * y])
        };
        let at = |turn: f64| [libm::cos(turn), libm::sin(turn)];
        assert_eq!(
            numbers(ring, &[0.0, 0.1, 2.0, 3.1, 3.13, -1.5].map(at)),
            [0; 6]
        );
        let troughs = |x: f64, _: f64| {
            let valley = x * x - 1.0;
            (valley * valley, [4.0 * x * valley, 0.0])
        };
        let points = [[1.0, 0.3], [-1.0, 0.3], [1.0, -2.0], [-1.0, 1.7]];
        assert_eq!(numbers(troughs, &points), [0, 1, 0, 1]);
    }

    #[test]
    fn rings_around_other_basins_are_one_each() {
        let at = |radius: f64, turn: f64| [radius * libm::cos(turn), radius * libm::sin(turn)];
        // q (q − 2.25)² has a minimum of energy 0 in its middle, too.
        let around = |x: f64, y: f64| {
            let q = x * x + y * y;
            let off = q - 2.25;
            let slope = 2.0 * (off * off + 2.0 * q * off);
            (q * off * off, [slope * x, slope * y])
        };
        let ring = [0.0, 3.1, 1.4, -2.0].map(|turn| at(1.5, turn));
        assert_eq!(numbers(around, &ring), [0; 4]);
        // (q − 1)² (q − 4)² has two rings of energy 0.
        let concentric = |x: f64, y: f64| {
            let q = x * x + y * y;
            let (inner, outer) = (q - 1.0, q - 4.0);
            let slope = 4.0 * inner * outer * (inner + outer);
            (inner * inner * outer * outer, [slope * x, slope * y])
        };
        let rings = [(1.0, 0.0), (2.0, 0.5), (1.0, 3.0), (2.0, -2.9), (2.0, 1.7)];
        let rings = rings.map(|(radius, turn)| at(radius, turn));
        assert_eq!(numbers(concentric, &rings), [0, 1, 0, 1, 1]);
    }

    #[test]
    fn a_ring_of_saddles_is_not_isolated() {
        let energy = FunctionOn::new(Euclidean::new(2), |p: &[f64], gradient: &mut [f64]| {
            let q = p[0] * p[0] + p[1] * p[1];
            let off = q - 2.25;
            let slope = 2.0 * (off * off + 2.0 * (q + 0.2) * off);
            (gradient[0], gradient[1]) = (slope * p[0], slope * p[1]);
            (q + 0.2) * off * off
        });
        let radius = (1.85_f64 / 3.0).sqrt();
        let points: Vec<Vec<f64>> = [0.0, 0.4, 2.2, -1.0]
            .map(|turn| vec![radius * libm::cos(turn), radius * libm::sin(turn)])
            .into();
        let found = audit(&energy, &points, 1, &AuditSettings::default());
        let verdicts: Vec<Verdict> = found.iter().map(|audit| audit.verdict).collect();
        assert_eq!(verdicts, [Verdict::Degenerate; 4]);
    }
}
