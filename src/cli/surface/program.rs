//! Energies that another program computes: their region, their space, and a check of their gradient.

use std::path::Path;

use anyhow::{bail, ensure};
use rand::RngExt;

use crate::cli::args::Coordinates;
use crate::energy::{Energy, External};
use crate::sample::{Task, stream};
use crate::space::{Cluster, Euclidean, Rotation, Space, Torus};
use crate::store::content_hash;
use crate::topography::in_box;

/// Random points at which the gradient of a program is checked.
const CHECKED: u64 = 8;

/// The least and the greatest value of each coordinate.
pub(super) type Region = (Vec<f64>, Vec<f64>);

/// `-1.5:1,-0.3:1.8`, or `-1:1x21` for 21 alike.
pub(super) fn region(flag: &str) -> anyhow::Result<Region> {
    let (mut low, mut high) = (Vec::new(), Vec::new());
    for part in flag.split(',') {
        let (side, count) = part.split_once('x').unwrap_or((part, "1"));
        let ends = side.split_once(':').and_then(|(low, high)| {
            let ends: (f64, f64) = (low.trim().parse().ok()?, high.trim().parse().ok()?);
            (ends.0 < ends.1 && (ends.1 - ends.0).is_finite()).then_some(ends)
        });
        let count = count
            .trim()
            .parse()
            .ok()
            .filter(|count| (1..=10_000).contains(count));
        let Some(((least, most), count)) = ends.zip(count) else {
            bail!("--region {flag}: `{part}` is not low:high with low < high (or low:highxN)");
        };
        low.extend(vec![least; count]);
        high.extend(vec![most; count]);
    }
    Ok((low, high))
}

/// The space of coordinates of this kind.
pub(in crate::cli) fn space(
    coordinates: Coordinates,
    count: usize,
) -> anyhow::Result<Box<dyn Space + Send>> {
    Ok(match coordinates {
        Coordinates::Flat => Box::new(Euclidean::new(count)),
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

/// Hash of a command and of the files it names: a changed program is another one.
pub(super) fn command_hash(program: &str) -> String {
    let files = program
        .split_whitespace()
        .filter(|word| Path::new(word).is_file());
    let mut parts: Vec<Vec<u8>> = files.filter_map(|file| std::fs::read(file).ok()).collect();
    parts.push(program.as_bytes().to_vec());
    content_hash(&parts.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

/// Compares the gradient with differences of the energy at random points of the region.
pub(super) fn check_gradient(
    energy: &External,
    (low, high): (&[f64], &[f64]),
    seed: u64,
    step: f64,
) -> anyhow::Result<()> {
    let draw = in_box(low, high);
    let space = energy.space();
    let (mut good, mut wrong) = (0, None);
    for id in 0..CHECKED {
        let mut rng = stream(seed, Task::Start, u64::MAX / 2 + id);
        let x = draw(&mut rng);
        let direction = rng.random_range(0..space.tangents());
        let mut gradient = vec![0.0; space.tangents()];
        let here = energy.evaluate(&x, &mut gradient);
        let side = |length: f64| {
            let (mut there, mut tangent) = (x.clone(), vec![0.0; space.tangents()]);
            tangent[direction] = length;
            space.shift(&mut there, &tangent);
            energy.evaluate(&there, &mut vec![0.0; space.tangents()])
        };
        let (ahead, behind) = (side(step), side(-step));
        energy.check()?;
        let (told, measured) = (gradient[direction], (ahead - behind) / (2.0 * step));
        if !(here.is_finite() && measured.is_finite()) {
            continue;
        }
        // Differences of an energy are good to its rounding over the step.
        let noise = 1e-13 * (ahead.abs() + behind.abs()) / step;
        if (told - measured).abs() <= 0.02 * (told.abs() + measured.abs()) + 100.0 * noise {
            good += 1;
        } else {
            wrong.get_or_insert((x, direction, told, measured));
        }
    }
    match wrong {
        // A point next to a kink or a wall says nothing.
        Some((x, direction, told, measured)) if good == 0 => bail!(
            "the gradient is not the derivative of the energy: at {x:?} component {direction} is told as {told}, but \
             differences of the energy give {measured}"
        ),
        _ => Ok(()),
    }
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
        for wrong in [
            "", "1", "1:0", "0:0", "a:b", "0:1x0", "0:1,", "0:inf", "nan:1",
        ] {
            let error = region(wrong).unwrap_err().to_string();
            assert!(error.contains("low:high"), "{error}");
        }
    }
}
