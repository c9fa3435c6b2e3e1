//! Energies that another program computes: region, space, and gradient check.

use std::path::Path;
use std::time::Duration;

use anyhow::{bail, ensure};

use super::{Coordinates, Surface};
use crate::cli::args::within;
use crate::energy::{Energy, External, ExternalError, InBox, check_gradient};
use crate::limits::{ANSWER_TIME, MOST_COORDINATES, REGION, REGION_SIDE};
use crate::optimize::{QuenchSettings, quench};
use crate::sample::{Task, stream};
use crate::space::{Cluster, Euclidean, Periodic, Rotation, Space, Torus};
use crate::store::content_hash;
use crate::topography::in_box;

/// Step of the finite differences of energies, relative to the shortest side of the region.
const DIFFERENCE: f64 = 1e-5;
/// Number of random points at which the gradient is checked, and of points along descents from them.
const CHECKED: u64 = 3;
/// Evaluations of such a descent, which need not converge.
const DESCENT: usize = 20;

/// Lower and upper bounds of each coordinate.
pub(super) type Region = (Vec<f64>, Vec<f64>);

/// Parses `-1.5:1,-0.3:1.8`, or `-1:1x21` for 21 equal ranges.
pub(super) fn region(flag: &str) -> anyhow::Result<Region> {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for part in flag.split(',') {
        let (side, count) = part.split_once('x').unwrap_or((part, "1"));
        let ends = side.split_once(':').and_then(|(low, high)| {
            let ends: (f64, f64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
            (ends.0 < ends.1).then_some(ends)
        });
        let count = count
            .trim()
            .parse()
            .ok()
            .filter(|count| (1..=MOST_COORDINATES).contains(count));
        let Some(((least, most), count)) = ends.zip(count) else {
            bail!("--region {flag}: `{part}` is not low:high with low < high (or low:highxN)");
        };
        for (limit, value) in [(REGION, least), (REGION, most), (REGION_SIDE, most - least)] {
            within(&format!("--region {part}:"), limit, value)?;
        }
        low.extend(vec![least; count]);
        high.extend(vec![most; count]);
        ensure!(
            low.len() <= MOST_COORDINATES,
            "--region: there are more than {MOST_COORDINATES} coordinates"
        );
    }
    Ok((low, high))
}

/// The space of these coordinates. With periodic ones, the sides of the region are the periods.
pub(in crate::cli) fn space(
    coordinates: Coordinates,
    (low, high): (&[f64], &[f64]),
) -> anyhow::Result<Box<dyn Space + Send>> {
    let count = low.len();
    Ok(match coordinates {
        Coordinates::Periodic => {
            let periods: Vec<f64> = low.iter().zip(high).map(|(low, high)| high - low).collect();
            Box::new(Periodic::new(low, &periods))
        }
        Coordinates::Flat | Coordinates::Box => Box::new(Euclidean::new(count)),
        Coordinates::Angles => Box::new(Torus::new(count)),
        Coordinates::Atoms => {
            ensure!(
                count.is_multiple_of(3),
                "--coordinates atoms: --region has {count} coordinates, and an atom has three"
            );
            Box::new(Cluster::new(count / 3))
        }
        Coordinates::Rotation => {
            ensure!(
                count == 4,
                "--coordinates rotation: --region has {count} coordinates, and a quaternion has four"
            );
            Box::new(Rotation::new(1.0))
        }
    })
}

/// Hash of a command and the files it names, so that a changed program gives another hash.
pub(super) fn command_hash(program: &str) -> String {
    let files = program
        .split_whitespace()
        .filter(|word| Path::new(word).is_file());
    let mut parts: Vec<Vec<u8>> = files.filter_map(|file| std::fs::read(file).ok()).collect();
    parts.push(program.as_bytes().to_vec());
    content_hash(&parts.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// Starts the program and checks its gradient (unless it is by finite differences) at random points and below them.
pub(super) fn start(
    command: &Surface,
    program: &str,
    (low, high): (&[f64], &[f64]),
) -> anyhow::Result<External> {
    let seconds = command.answer_seconds;
    within("--answer-seconds", ANSWER_TIME, seconds)?;
    let limit = Duration::from_secs_f64(seconds);
    let sides = low.iter().zip(high).map(|(low, high)| high - low);
    let step = DIFFERENCE * sides.fold(f64::INFINITY, f64::min);
    let space = space(command.coordinates, (low, high))?;
    let external = External::start(program, space, step)?
        .with_answer_limit(limit)
        .with_protocol(command.protocol.into());
    let boxed = InBox::new(low, high, |x, gradient| external.evaluate(x, gradient));
    let is_box = command.coordinates == Coordinates::Box;
    let ((low, high), energy): (Region, &dyn Energy) = if is_box {
        (boxed.region(), &boxed)
    } else {
        ((low.to_vec(), high.to_vec()), &external)
    };
    let draw = in_box(&low, &high);
    let descent = QuenchSettings::default()
        .with_max_step(1e3 * step)
        .with_max_evaluations(DESCENT);
    let mut points = Vec::new();
    for id in 0..CHECKED {
        let x = draw(&mut stream(command.seed, Task::Start, u64::MAX / 2 + id));
        energy.evaluate(&x, &mut vec![0.0; energy.space().tangents()]);
        check(&external)?;
        if external.is_differenced() {
            return Ok(external);
        }
        points.push(quench(energy, &x, &descent).x);
        points.push(x);
    }
    let checked = check_gradient(energy, &points, step);
    check(&external)?;
    checked?;
    Ok(external)
}

/// The error of the program, if any.
pub(super) fn check(external: &External) -> anyhow::Result<()> {
    external.check().map_err(|error| match error {
        ExternalError::Late { .. } => {
            anyhow::anyhow!("{error} (--answer-seconds allows more)")
        }
        error => error.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_read() {
        assert_eq!(
            region("-1.5:1,0:2x2").unwrap(),
            (vec![-1.5, 0.0, 0.0], vec![1.0, 2.0, 2.0])
        );
        for wrong in ["", "1", "1:0", "0:0", "a:b", "0:1x0", "0:1,", "nan:1"] {
            let error = region(wrong).unwrap_err().to_string();
            assert!(error.contains("low:high"), "{error}");
        }
        for far in ["0:inf", "-1e155:0", "0:1e-300"] {
            let error = region(far).unwrap_err().to_string();
            assert!(
                error.contains(far) && error.contains("choose another unit"),
                "{error}"
            );
        }
        let error = region("0:1x9000,0:1x9000").unwrap_err().to_string();
        assert!(error.contains("10000 coordinates"), "{error}");
    }
}
