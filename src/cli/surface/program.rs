//! Energies that another program computes: region, space, and gradient check.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail, ensure};

use super::{Coordinates, Surface};
use crate::cli::args::within;
use crate::energy::{Energy, External, ExternalError, InBox, check_gradient};
use crate::limits::{ANSWER_TIME, MOST_COORDINATES, REGION, REGION_SIDE};
use crate::space::Space;
use crate::store::content_hash;
use crate::study::{self, broken_symmetry, difference_step, gradient_points};

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

/// The kind of the coordinates of a program's energy.
pub(super) fn kind(command: &Surface) -> anyhow::Result<study::Coordinates> {
    if let Some(path) = &command.symmetries {
        let angles = match command.coordinates {
            Coordinates::Flat => false,
            Coordinates::Angles => true,
            _ => bail!("--symmetries: give them for `--coordinates flat` or `angles` only"),
        };
        ensure!(
            command.elements.is_none(),
            "--symmetries and --elements do not go together: renumbered atoms are copies already"
        );
        let generators = symmetries(path)?;
        return Ok(study::Coordinates::Symmetric { angles, generators });
    }
    let Some(list) = &command.elements else {
        ensure!(
            command.coordinates != Coordinates::FixedFrame,
            "--coordinates fixed-frame needs --elements, such as `--elements Ar2`"
        );
        return Ok(command.coordinates.into());
    };
    let elements = elements(list)?;
    match command.coordinates {
        Coordinates::Atoms => Ok(study::Coordinates::Elements(elements)),
        Coordinates::FixedFrame => Ok(study::Coordinates::FixedFrame {
            elements,
            periodic: false,
        }),
        Coordinates::Periodic => Ok(study::Coordinates::FixedFrame {
            elements,
            periodic: true,
        }),
        _ => bail!(
            "--elements {list}: only atoms have elements, so give `--coordinates atoms` as well, or `fixed-frame` or \
             `periodic` for atoms among others that stay"
        ),
    }
}

/// Reads a file of `--symmetries`. Empty lines and what follows a `#` do not count.
fn symmetries(path: &Path) -> anyhow::Result<Vec<Vec<i64>>> {
    let named = || format!("--symmetries {}", path.display());
    let text = std::fs::read_to_string(path).with_context(named)?;
    let mut generators = Vec::new();
    for (row, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let numbers: Vec<i64> = (line.split_whitespace())
            .map(|word| {
                let wrong = || {
                    format!(
                        "{}: line {}: `{word}` is not the number of a coordinate, such as 2 or -2",
                        named(),
                        row + 1
                    )
                };
                word.parse().ok().with_context(wrong)
            })
            .collect::<anyhow::Result<_>>()?;
        if !numbers.is_empty() {
            generators.push(numbers);
        }
    }
    ensure!(
        !generators.is_empty(),
        "{}: it contains no symmetry",
        named()
    );
    Ok(generators)
}

/// Parses `Ar,Ar,Kr`, or `Ar2,Kr` for the same.
fn elements(list: &str) -> anyhow::Result<Vec<String>> {
    let mut elements = Vec::new();
    for part in list.split(',').map(str::trim) {
        let name = part.trim_end_matches(|end: char| end.is_ascii_digit());
        let count = match &part[name.len()..] {
            "" => Some(1),
            count => count.parse().ok(),
        };
        let count = count.filter(|count| (1..=MOST_COORDINATES / 3).contains(count));
        let named = !name.is_empty() && name.chars().all(|letter| letter.is_ascii_alphabetic());
        let (true, Some(count)) = (named, count) else {
            bail!(
                "--elements {list}: `{part}` is not an element: write Ar, or Ar12 for several atoms"
            );
        };
        elements.extend(vec![name.to_owned(); count]);
        ensure!(
            elements.len() <= MOST_COORDINATES / 3,
            "--elements: there are more than {} atoms",
            MOST_COORDINATES / 3
        );
    }
    Ok(elements)
}

/// The space of these coordinates. With periodic ones, the sides of the region are the periods.
fn space(
    kind: &study::Coordinates,
    region: (&[f64], &[f64]),
) -> anyhow::Result<Box<dyn Space + Send>> {
    let told = |error| match kind {
        study::Coordinates::Elements(_) | study::Coordinates::FixedFrame { .. } => {
            anyhow::anyhow!("--elements: --region has {error}")
        }
        study::Coordinates::Symmetric { .. } => anyhow::anyhow!("--symmetries: {error}"),
        kind => anyhow::anyhow!("--coordinates {}: --region has {error}", kind.name()),
    };
    kind.space(region).map_err(told)
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
    let step = difference_step((low, high));
    let kind = kind(command)?;
    let space = space(&kind, (low, high))?;
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
    let proceed = || check(&external).map(|()| !external.is_differenced());
    let points = gradient_points(
        energy,
        (&low, &high),
        step,
        command.seed.unwrap_or(0),
        proceed,
    )?;
    let checked = check_gradient(energy, &points, step);
    check(&external)?;
    checked?;
    if let study::Coordinates::Symmetric { generators, .. } = &kind
        && let Some(broken) = broken_symmetry(generators, &external, &points, || check(&external))?
    {
        bail!("--symmetries: {broken}");
    }
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
    fn elements_are_read() {
        assert_eq!(elements("Ar2, Kr").unwrap(), ["Ar", "Ar", "Kr"]);
        for wrong in [
            "",
            "Ar,",
            "2",
            "Ar0",
            "A r",
            "Ar-1",
            "Ar9999999999999999999999",
        ] {
            let error = elements(wrong).unwrap_err().to_string();
            assert!(error.contains("is not an element"), "{error}");
        }
        let error = elements("Ar3000,Kr3000").unwrap_err().to_string();
        assert!(error.contains("3333 atoms"), "{error}");
    }

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
