//! Relaxation of a path as a whole.
//!
//! On the envelope of grasps kinks lie every few millimetres, so the pieces that tie at a top rarely stay the lowest ones on the way to a
//! stationary point of theirs. A path is relaxed as a whole instead, until its top is at rest and its height has settled.

use super::PathSettings;
use super::pass::Peak;
use super::string::Band;
use crate::energy::Energy;

/// A relaxed string, its highest point, and whether both tests of a relaxed path hold.
pub(super) struct Settled<'e> {
    pub(super) band: Band<'e>,
    pub(super) peak: Peak,
    pub(super) relaxed: bool,
}

/// Relaxes `band`, then doubles its images and goes on.
///
/// Relaxed means: the force across the path at its top is below the tolerance *and* doubling the images moved the height
/// by less than the height tolerance. `None` if no point of the path is finite.
pub(super) fn settle<'e>(
    energy: &'e dyn Energy,
    band: Band<'e>,
    floor: f64,
    settings: &PathSettings,
) -> Option<Settled<'e>> {
    let (coarse, coarse_peak) = lowest(energy, band, floor, settings)?;
    let (fine, peak) = lowest(energy, coarse.doubled(), floor, settings)?;
    let slack = settings.slack(peak.energy - floor);
    Some(Settled {
        relaxed: fine.across(peak.image, settings.max_step) <= settings.force_tolerance
            && (peak.energy - coarse_peak.energy).abs() <= slack,
        band: fine,
        peak,
    })
}

/// Rounds of relaxation until the height no longer falls and the top is at rest; the lowest string met, since momentum
/// may carry a string over a kink.
fn lowest<'e>(
    energy: &'e dyn Energy,
    mut band: Band<'e>,
    floor: f64,
    settings: &PathSettings,
) -> Option<(Band<'e>, Peak)> {
    let mut best: Option<(Band<'e>, Peak)> = None;
    for _ in 0..settings.rounds {
        band.relax(settings.iterations, settings.force_tolerance);
        let peak = Peak::of(energy, &band)?;
        let slack = settings.slack(peak.energy - floor);
        let (lower, falling) = match &best {
            None => (true, true),
            Some((_, known)) => (
                peak.energy < known.energy,
                peak.energy < known.energy - 0.5 * slack,
            ),
        };
        if lower {
            best = Some((band.clone(), peak));
        }
        let rests = best.as_ref().is_some_and(|(band, peak)| {
            band.across(peak.image, settings.max_step) <= settings.force_tolerance
        });
        if !falling && rests {
            break;
        }
    }
    best
}
