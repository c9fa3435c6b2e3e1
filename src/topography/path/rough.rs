//! Relaxation on an energy that is a minimum over discrete choices.
//!
//! Kinks lie every few millimetres there, so the pieces that tie at a top rarely stay the lowest ones on the way to a
//! stationary point of theirs. A path is relaxed as a whole instead, until its forces and its height have settled.

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
/// Relaxed means: the force across the path is below the tolerance at every image *and* doubling the images moved the
/// height by less than the height tolerance. `None` if no point of the path is finite.
pub(super) fn settle<'e>(
    energy: &'e dyn Energy,
    band: Band<'e>,
    floor: f64,
    settings: &PathSettings,
) -> Option<Settled<'e>> {
    let (coarse, coarse_peak, _) = lowest(energy, band, floor, settings)?;
    let (fine, peak, rests) = lowest(energy, coarse.doubled(), floor, settings)?;
    let slack = settings.slack(peak.energy - floor);
    if std::env::var("DBG").is_ok() { eprintln!("settle coarse {:.4} fine {:.4} slack {:.4} rests {rests}", coarse_peak.energy - floor, peak.energy - floor, slack); }
    Some(Settled {
        relaxed: rests && (peak.energy - coarse_peak.energy).abs() <= slack,
        band: fine,
        peak,
    })
}

/// Rounds of relaxation until the forces have died down; the string at the end if they have, else the lowest one met,
/// since momentum may carry a string over a kink.
fn lowest<'e>(
    energy: &'e dyn Energy,
    mut band: Band<'e>,
    floor: f64,
    settings: &PathSettings,
) -> Option<(Band<'e>, Peak, bool)> {
    let mut best: Option<(Band<'e>, Peak, bool)> = None;
    for _ in 0..settings.rounds {
        let force = band.relax(settings.iterations, settings.force_tolerance);
        let peak = Peak::of(energy, &band)?;
        let rests = force <= settings.force_tolerance;
    if std::env::var("DBG").is_ok() { eprintln!("   round {:.4} force {force:.1} images {}", peak.energy - floor, band.path.images.len()); }
        let slack = settings.slack(peak.energy - floor);
        let lower = best
            .as_ref()
            .is_none_or(|(_, known, _)| peak.energy < known.energy);
        let ties = best
            .as_ref()
            .is_some_and(|(_, known, _)| peak.energy <= known.energy + slack);
        if lower || (rests && ties) {
            best = Some((band.clone(), peak, rests));
        }
        if rests {
            break;
        }
    }
    best
}
