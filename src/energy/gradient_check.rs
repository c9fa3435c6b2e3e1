//! Checks whether a gradient is the derivative of its energy.

use super::Energy;

/// Factors of the given step that are tried. The first step that gives a clear result ends the trial of a component.
const STEPS: [f64; 4] = [1.0, 10.0, 0.1, 100.0];
/// Tolerated error, as shares of the component and of the whole gradient.
const FORGIVEN: [f64; 2] = [1e-3, 1e-4];
/// A difference whose estimated error is below this share of the gradient needs no other step.
const SHARP: f64 = 1e-3;
/// Differences with errors up to this multiple of the least error are used.
const BELIEVED: f64 = 10.0;
/// Relative rounding error of an energy in double precision.
const ROUNDING: f64 = 1e-15;
/// Tolerated noise, in standard deviations.
const DEVIATIONS: f64 = 5.0;
/// A change of the energy below this share of its range over the points checked is negligible.
const NOTHING: f64 = 1e-3;
/// A component is wrong if it fails at this many points; a single failure may be due to a kink.
const POINTS: usize = 2;
/// Energy changes above this multiple of the least change are not used to find its last digit.
const MULTIPLES: f64 = 1e4;
/// Signs and weights of the sixth difference of seven values, and its standard deviation for values of deviation 1.
const SIXTH: ([f64; 7], f64) = (
    [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0],
    30.397_368_307_141_33,
);

/// A component of a gradient that is not the derivative of the energy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the gradient is not the derivative of the energy: at {x:?} component {component} is given as {told}, but differences \
     of the energy give {measured} (it is wrong at {wrong} of {checked} points)"
)]
pub struct GradientFault {
    /// Point with the greatest error.
    pub x: Vec<f64>,
    /// Number of the tangent, from 0.
    pub component: usize,
    /// Value in the gradient, energy per length.
    pub told: f64,
    /// Value from differences of the energy.
    pub measured: f64,
    /// Number of points where this component is wrong.
    pub wrong: usize,
    /// Number of points where it could be checked.
    pub checked: usize,
}

/// Compares every component of the gradient with central differences of the energy, at each of `points`.
///
/// ```text
/// D(h) = (E(x ⊕ h eₖ) − E(x ⊕ −h eₖ))/2h,   measured = (4 D(h) − D(2h))/3
/// |told − measured| ≤ 10⁻³ max(|told|, |measured|) + 10⁻⁴ ‖g‖ + |D(2h) − D(h)| + 5 σ/h
/// ```
///
/// eₖ: the k-th tangent; ⊕: [`Space::exp`](crate::space::Space::exp); g: the given gradient, with component `told`; σ: the
/// noise of the energy, measured by its sixth differences along the same lines (J. J. Moré and S. M. Wild, SIAM J. Sci.
/// Comput. 33, 1292 (2011)). h is first `step` (a length), then ten times, a tenth and a hundred times as much, until the
/// errors on the right side are small and the component agrees. Of the steps with errors up to ten times the least, one
/// must agree, otherwise the component is wrong. A good `step` is a hundred-thousandth of the region of interest.
///
/// A fault is a component that is wrong at two points or more, or at the only one where it can be checked, since a
/// difference means nothing next to a kink or to the edge of the domain. So give several points, some of them where the
/// energy is low: where it is steep its smaller terms cannot be seen. The check usually takes six evaluations per component
/// and point.
///
/// # Errors
/// The wrong component; of several, the one with the greatest error.
///
/// # Panics
/// If a point has the wrong length.
///
/// ```
/// use landscape::energy::{InBox, check_gradient};
///
/// // x² + y² + xy/10, whose second component lacks the last term.
/// let energy = InBox::new(&[-1.0; 2], &[1.0; 2], |p, gradient| {
///     gradient.copy_from_slice(&[2.0 * p[0] + 0.1 * p[1], 2.0 * p[1]]);
///     p[0] * p[0] + p[1] * p[1] + 0.1 * p[0] * p[1]
/// });
/// let fault = check_gradient(&energy, &[vec![0.3, 0.5], vec![-0.7, 0.2]], 1e-5).unwrap_err();
/// assert_eq!(fault.component, 1);
/// ```
pub fn check_gradient(
    energy: &dyn Energy,
    points: &[Vec<f64>],
    step: f64,
) -> Result<(), GradientFault> {
    let tangents = energy.space().tangents();
    let mut probes: Vec<Probe<'_>> = Vec::new();
    for x in points {
        let mut gradient = vec![0.0; tangents];
        let height = energy.evaluate(x, &mut gradient);
        if height.is_finite() {
            probes.push(Probe {
                energy,
                x,
                height,
                size: gradient.iter().map(|g| g * g).sum::<f64>().sqrt(),
                gradient,
            });
        }
    }
    let heights = || probes.iter().map(|probe| probe.height);
    let range =
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
    let mut faults: Vec<Option<(f64, GradientFault)>> = vec![None; tangents];
    let mut checked = vec![0; tangents];
    for probe in &probes {
        for (component, finding) in probe.components(step, range).into_iter().enumerate() {
            let Some(Finding {
                measured, excess, ..
            }) = finding
            else {
                continue;
            };
            checked[component] += 1;
            // An excess that is NaN counts as wrong.
            if excess <= 0.0 {
                continue;
            }
            let wrong = faults[component]
                .as_ref()
                .map_or(0, |(_, fault)| fault.wrong)
                + 1;
            let worst = faults[component]
                .as_ref()
                .map_or(f64::NEG_INFINITY, |(worst, _)| *worst);
            if excess.is_nan() || excess > worst {
                let fault = GradientFault {
                    x: probe.x.to_vec(),
                    component,
                    told: probe.gradient[component],
                    measured,
                    wrong,
                    checked: 0,
                };
                faults[component] = Some((excess, fault));
            } else if let Some((_, fault)) = &mut faults[component] {
                fault.wrong = wrong;
            }
        }
    }
    let faults = faults.into_iter().flatten().filter_map(|(excess, fault)| {
        let checked = checked[fault.component];
        (fault.wrong >= POINTS.min(checked)).then_some((excess, GradientFault { checked, ..fault }))
    });
    let worst = faults.max_by(|(a, _), (b, _)| a.total_cmp(b));
    worst.map_or(Ok(()), |(_, fault)| Err(fault))
}

/// A point where a gradient is checked.
struct Probe<'a> {
    energy: &'a dyn Energy,
    x: &'a [f64],
    height: f64,
    gradient: Vec<f64>,
    /// Norm of the gradient.
    size: f64,
}

/// Result of the differences for one component.
struct Finding {
    measured: f64,
    /// Error beyond the tolerance, as a share of the gradient; not positive if the component is right.
    excess: f64,
    /// Error of the measured value, as a share of the gradient.
    error: f64,
}

/// The best agreement among those findings of one component that are about as accurate as the most accurate one.
fn believed(findings: Vec<Finding>) -> Option<Finding> {
    let errors = findings.iter().map(|finding| finding.error);
    let least = errors.fold(f64::INFINITY, f64::min);
    let accurate = (findings.into_iter()).filter(|finding| finding.error <= BELIEVED * least);
    accurate.min_by(|a, b| a.excess.total_cmp(&b.excess))
}

/// The largest number of which all changes of the energy are multiples, which is the resolution of an energy with few
/// digits. For an energy with all digits it is about `rounding`; smaller changes are ignored.
fn last_digit(rises: &[f64], rounding: f64) -> f64 {
    let counts = |rise: &f64| *rise > rounding;
    let least = rises.iter().copied().filter(counts).reduce(f64::min);
    // Far larger multiples are not used, because their own rounding is not small compared with the digit.
    let near = |rise: &f64| counts(rise) && least.is_some_and(|least| *rise <= MULTIPLES * least);
    let near = rises.iter().copied().filter(near);
    near.reduce(|mut a, mut b| {
        // Euclid's algorithm.
        while b > rounding {
            (a, b) = (b, a % b);
            // A remainder within rounding of a whole multiple counts as zero.
            if a - b <= rounding {
                b = 0.0;
            }
        }
        a
    })
    .unwrap_or(0.0)
}

/// The energies at seven places along a tangent; the middle one is the point itself.
struct Line {
    component: usize,
    step: f64,
    energies: [f64; 7],
}

impl Probe<'_> {
    /// The finding for each component; `None` if it cannot be checked.
    fn components(&self, step: f64, range: f64) -> Vec<Option<Finding>> {
        let count = self.gradient.len();
        let mut findings: Vec<Vec<Finding>> = (0..count).map(|_| Vec::new()).collect();
        let mut level: Vec<Option<f64>> = vec![None; count];
        let mut open: Vec<usize> = (0..count).collect();
        let mut noises: Vec<(f64, f64)> = Vec::new();
        let mut rises: Vec<f64> = Vec::new();
        for factor in STEPS {
            let lines = open.iter().map(|k| self.line(*k, factor * step));
            let lines: Vec<Line> = lines.filter(Line::is_finite).collect();
            for line in lines.iter().filter(|line| line.is_level()) {
                level[line.component] = Some(line.step);
            }
            // Noise does not depend on the step, but a longer step may show little of it by chance.
            noises.push((factor, lines.iter().map(Line::noise).fold(0.0, f64::max)));
            let shorter = noises.iter().filter(|(other, _)| *other <= factor);
            let noise = shorter.map(|(_, noise)| *noise).fold(0.0, f64::max);
            rises.extend(lines.iter().flat_map(Line::rises));
            let noise = noise.max(last_digit(&rises, ROUNDING * self.height.abs()));
            for line in lines.iter().filter(|line| !line.is_level()) {
                let finding = self.compare(line, noise);
                if finding.error <= SHARP && finding.excess <= 0.0 {
                    open.retain(|component| *component != line.component);
                }
                findings[line.component].push(finding);
            }
        }
        let findings = findings.into_iter().zip(level).enumerate();
        findings
            .map(|(component, (findings, level))| {
                believed(findings)
                    .or_else(|| level.map(|step| self.compare_level(component, 6.0 * step, range)))
            })
            .collect()
    }

    fn line(&self, component: usize, step: f64) -> Line {
        let space = self.energy.space();
        let mut tangent = vec![0.0; self.gradient.len()];
        let mut unused = tangent.clone();
        let energies = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|steps| {
            if steps == 0.0 {
                return self.height;
            }
            let mut there = self.x.to_vec();
            tangent[component] = steps * step;
            space.exp(&mut there, &tangent);
            self.energy.evaluate(&there, &mut unused)
        });
        Line {
            component,
            step,
            energies,
        }
    }

    /// Compares the gradient with the differences along a line.
    fn compare(&self, line: &Line, noise: f64) -> Finding {
        let e = &line.energies;
        let near = (e[4] - e[2]) / (2.0 * line.step);
        let far = (e[5] - e[1]) / (4.0 * line.step);
        let measured = near + (near - far) / 3.0;
        let told = self.gradient[line.component];
        let error = (far - near).abs() + DEVIATIONS * noise / line.step;
        let forgiven =
            FORGIVEN[0] * told.abs().max(measured.abs()) + FORGIVEN[1] * self.size + error;
        let size = self.size.max(measured.abs()).max(f64::MIN_POSITIVE);
        Finding {
            measured,
            excess: ((told - measured).abs() - forgiven) / size,
            error: error / size,
        }
    }

    /// The finding for an energy that does not change over `length` at all: the component is right if the change that the
    /// gradient predicts could be lost to rounding.
    fn compare_level(&self, component: usize, length: f64, range: f64) -> Finding {
        let promised = self.gradient[component].abs() * length;
        let forgiven = NOTHING * range + ROUNDING * self.height.abs();
        Finding {
            measured: 0.0,
            excess: (promised - forgiven) / promised.max(f64::MIN_POSITIVE),
            error: 0.0,
        }
    }
}

impl Line {
    fn is_finite(&self) -> bool {
        self.energies.iter().all(|energy| energy.is_finite())
    }

    #[expect(
        clippy::float_cmp,
        reason = "rounded to the same number is what is asked"
    )]
    fn is_level(&self) -> bool {
        self.energies
            .iter()
            .all(|energy| *energy == self.energies[3])
    }

    /// Absolute changes of the energy between neighbouring places.
    fn rises(&self) -> impl Iterator<Item = f64> {
        let pairs = self.energies.windows(2);
        pairs.map(|pair| (pair[1] - pair[0]).abs())
    }

    /// Standard deviation of the noise of its energies.
    fn noise(&self) -> f64 {
        let parts = self.energies.iter().zip(SIXTH.0);
        let sixth: f64 = parts.map(|(energy, weight)| energy * weight).sum();
        let size = self
            .energies
            .iter()
            .fold(0.0, |most: f64, e| most.max(e.abs()));
        (sixth.abs() / SIXTH.1).max(ROUNDING * size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::InBox;
    use crate::energy::model::{LennardJones, MullerBrown};
    use crate::sample::{Task, stream};
    use crate::space::{Euclidean, Space};
    use rand::RngExt;

    fn points(seed: u64, count: u64, half: f64, dimensions: usize) -> Vec<Vec<f64>> {
        let point = |id| {
            let mut rng = stream(seed, Task::Start, id);
            (0..dimensions)
                .map(|_| rng.random_range(-half..half))
                .collect()
        };
        (0..count).map(point).collect()
    }

    /// A sum of many parts with a coupling of the first two coordinates; `spoil` is what the gradient gets wrong.
    fn coupled(round: f64, spoil: impl Fn(&[f64], &mut [f64]) + Sync) -> impl Energy {
        InBox::new(
            &[-3.0; 3],
            &[3.0; 3],
            move |p: &[f64], gradient: &mut [f64]| {
                let [x, y, z] = [p[0], p[1], p[2]];
                gradient[0] = 4.0 * x * (x * x - 1.0) + 0.3 * libm::cos(y) * libm::cos(x);
                gradient[1] = 2.0 * y - 0.3 * libm::sin(y) * libm::sin(x);
                gradient[2] = libm::sin(z);
                let energy = (x * x - 1.0).powi(2) + y * y + 0.3 * libm::cos(y) * libm::sin(x)
                    - libm::cos(z);
                spoil(p, gradient);
                if round > 0.0 {
                    (energy / round).round() * round
                } else {
                    energy
                }
            },
        )
    }

    #[test]
    fn what_is_right_passes() {
        let step = 1e-5;
        let shifted = InBox::new(&[-2.0], &[2.0], |p, gradient| {
            gradient[0] = 2.0 * p[0];
            p[0] * p[0] - 1e8
        });
        let single = InBox::new(&[-2.0], &[2.0], |p, gradient| {
            gradient[0] = 2.0 * p[0];
            #[expect(
                clippy::cast_possible_truncation,
                reason = "single precision is the point"
            )]
            f64::from((p[0] * p[0] + 3.0) as f32)
        });
        let plane = InBox::new(&[-2.0; 2], &[2.0; 2], |p, gradient| {
            gradient.copy_from_slice(&[2.0, -0.3]);
            2.0 * p[0] - 0.3 * p[1] + 7.0
        });
        for seed in 0..20 {
            let passes = |energy: &dyn Energy, points: Vec<Vec<f64>>, step: f64, what: &str| {
                let found = check_gradient(energy, &points, step);
                assert_eq!(found, Ok(()), "{what}, seed {seed}");
            };
            let surface = MullerBrown::new();
            passes(&surface, points(seed, 8, 1.0, 2), step, "Müller–Brown");
            let cluster = LennardJones::new(5);
            passes(&cluster, points(seed, 8, 1.2, 15), step, "LJ₅");
            // Energies with few digits, far from zero, of single precision, and one that all steps agree on.
            for round in [0.0, 1e-9, 1e-6, 1e-2] {
                let energy = coupled(round, |_, _| ());
                let what = format!("digits of {round}");
                passes(&energy, points(seed, 8, 1.0, 3), 6.0 * step, &what);
            }
            passes(
                &shifted,
                points(seed, 6, 2.0, 1),
                4.0 * step,
                "far from zero",
            );
            passes(
                &single,
                points(seed, 6, 2.0, 1),
                4.0 * step,
                "single precision",
            );
            passes(&plane, points(seed, 6, 2.0, 2), 4.0 * step, "plane");
        }
    }

    #[test]
    fn one_wrong_component_is_found() {
        type Spoil = fn(&[f64], &mut [f64]);
        let wrongs: [(usize, Spoil); 5] = [
            // A forgotten coupling, a sign, a factor, a component never written, and a coupling half off.
            (0, |p, g| g[0] -= 0.3 * libm::cos(p[1]) * libm::cos(p[0])),
            (1, |_, g| g[1] = -g[1]),
            (2, |_, g| g[2] *= 1.05),
            (2, |_, g| g[2] = 0.0),
            (1, |p, g| g[1] += 0.15 * libm::sin(p[1]) * libm::sin(p[0])),
        ];
        for (component, spoil) in wrongs {
            for (round, seed) in [(0.0, 3), (1e-6, 3), (0.0, 4), (1e-6, 5)] {
                let points = points(seed, 8, 2.0, 3);
                let fault = check_gradient(&coupled(round, spoil), &points, 6e-5).unwrap_err();
                assert_eq!(fault.component, component, "{fault}");
                assert!(fault.wrong >= 2 && fault.checked == 8, "{fault}");
            }
        }
    }

    #[test]
    fn a_constant_has_no_slope() {
        let energy = InBox::new(&[-1.0; 2], &[1.0; 2], |_, gradient| {
            gradient.copy_from_slice(&[0.0, 5.0]);
            1.0
        });
        let fault = check_gradient(&energy, &points(3, 3, 0.9, 2), 1e-5).unwrap_err();
        assert_eq!((fault.component, fault.measured), (1, 0.0));
    }

    /// |x|: right everywhere but at its kink, where one of the points lies.
    struct Kinked(Euclidean);

    impl Energy for Kinked {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            gradient[0] = x[0].signum();
            x[0].abs()
        }
    }

    #[test]
    fn a_point_at_a_kink_says_nothing() {
        let points = [vec![1e-6], vec![0.5], vec![-0.3]];
        assert_eq!(
            check_gradient(&Kinked(Euclidean::new(1)), &points, 1e-5),
            Ok(())
        );
    }
}
