//! Closed loops of a description, which are constraints between two links of the tree.
//!
//! A hand is a tree here, so a loop stays closed only if its joints move together. The joints of a loop that is not closed
//! by couplings follow one of them, as the joints of a linkage do, if linear couplings keep the loop closed.

use nalgebra::{DMatrix, DVector, Vector3};

use super::model::{Coupling, Model, check_count};
use super::sampling::joint_samples;
use super::{Frame, HandError, Joint, Link, LinkId};

/// Points of a loop may be this far apart, metres.
const OPEN_M: f64 = 0.5e-3;
/// Poses of all joints, and coordinates of the joint that drives a loop, at which loops are measured.
const POSES: usize = 256;
const STATIONS: u32 = 24;
/// A fitted joint may leave its range by this much, radians (metres are counted at the lever of a slide), and what a larger
/// excess costs as an opening, metres per radian.
const BEYOND: f64 = 0.02;
const EXCESS_M: f64 = 0.2;
/// Where a description assembles its loop, fitted joints are no farther off, radians (metres at the lever of a slide).
const ASSEMBLED: f64 = 0.1;
/// Most fitted joints for which all combinations of directions are tried as starts.
const MOST_DIRECTIONS: usize = 3;
const STEPS: usize = 100;
/// Largest numbers of loops and of joints in one that are coupled.
const MOST_LOOPS: usize = 30;
const MOST_MEMBERS: usize = 8;

/// A loop: points of two links that coincide.
#[derive(Debug, Clone)]
pub(super) struct Loop {
    /// Element, file and line.
    pub(super) place: String,
    /// Names of the two links.
    pub(super) links: [String; 2],
    /// The same points in the frames of both links, metres: one if the links turn about it, four if they are one body.
    pub(super) points: Vec<[Vector3<f64>; 2]>,
}

/// A loop in a tree of links.
struct Closure<'a> {
    of: &'a Loop,
    ends: [LinkId; 2],
}

impl Closure<'_> {
    /// Differences between the points of both links.
    fn gaps(&self, frames: &[Frame]) -> impl Iterator<Item = Vector3<f64>> {
        let [first, second] = self.ends.map(|end| frames[end.0]);
        let points = self.of.points.iter();
        points.map(move |[a, b]| first.point(a) - second.point(b))
    }

    /// Widest distance between them, metres.
    fn opening_m(&self, frames: &[Frame]) -> f64 {
        self.gaps(frames).map(|gap| gap.norm()).fold(0.0, f64::max)
    }

    /// Whether a link is moved relative to the other end by what moves one end.
    fn holds(&self, links: &[Link], link: usize) -> bool {
        let below = |end: LinkId| {
            let mut line = std::iter::successors(Some(end), |l| links[l.0].parent);
            line.any(|l| l.0 == link)
        };
        let [first, second] = self.ends.map(below);
        first != second
    }
}

/// Frames of all links in that of the root.
fn frames(links: &[Link], joints: &[f64]) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::with_capacity(links.len());
    for link in links {
        let parent = link
            .parent
            .map_or_else(Frame::default, |parent| frames[parent.0]);
        frames.push(link.frame_in(&parent, joints));
    }
    frames
}

/// Couples the joints of loops that are open. A loop with a link that the hand does not have is no loop.
///
/// # Errors
/// If linear couplings do not close a loop.
pub(super) fn close(model: &mut Model) -> Result<(), HandError> {
    if model.loops.is_empty() {
        return Ok(());
    }
    let loops = model.loops.clone();
    let advice = "cut those that do not matter for grasps";
    check_count("closed loops", loops.len(), MOST_LOOPS, advice)?;
    let mut coupled = vec![false; loops.len()];
    loop {
        let (links, joints) = model.tree()?;
        let closures: Vec<Option<Closure<'_>>> =
            loops.iter().map(|of| closure(of, &links)).collect();
        let open_m = widest_m(&closures, &links, &joints);
        let Some(open) = open_m.iter().position(|open_m| *open_m > OPEN_M) else {
            return Ok(());
        };
        let Some(closure) = &closures[open] else {
            return Ok(());
        };
        // A later coupling may change what an earlier loop rests on.
        if std::mem::replace(&mut coupled[open], true) {
            return Err(refusal(&loops[open], open_m[open], &[]));
        }
        couple(model, closure, (&links, &joints), open_m[open])?;
    }
}

fn closure<'a>(of: &'a Loop, links: &[Link]) -> Option<Closure<'a>> {
    let find = |name: &String| links.iter().position(|link| link.name == *name).map(LinkId);
    let [first, second] = of.links.each_ref().map(find);
    Some(Closure {
        of,
        ends: [first?, second?],
    })
}

/// For each loop, its widest opening over the ranges of all joints, metres; zero if it is no loop.
fn widest_m(closures: &[Option<Closure<'_>>], links: &[Link], joints: &[Joint]) -> Vec<f64> {
    let mut widest = vec![0.0f64; closures.len()];
    if closures.iter().all(Option::is_none) {
        return widest;
    }
    for sample in joint_samples(joints, POSES) {
        let frames = frames(links, &sample);
        for (widest, closure) in widest.iter_mut().zip(closures) {
            let open_m = closure
                .as_ref()
                .map_or(0.0, |closure| closure.opening_m(&frames));
            *widest = widest.max(open_m);
        }
    }
    widest
}

fn refusal(of: &Loop, open_m: f64, joints: &[&str]) -> HandError {
    let [first, second] = &of.links;
    let moving = if joints.is_empty() {
        "its joints".to_owned()
    } else {
        format!("its joints ({})", joints.join(", "))
    };
    HandError::Element {
        place: of.place.clone(),
        problem: format!(
            "it closes a loop between the links \"{first}\" and \"{second}\", but hands are trees here. No linear couplings of \
             {moving} keep the loop closed: it opens by {:.1} mm. Cut the loop: remove this element, and remove the other \
             joints of the loop or let them follow its driven joint (<equality><joint polycoef=\"offset ratio\">)",
            1e3 * open_m
        ),
    }
}

/// Lets the joints of a loop follow the best driven one.
fn couple(
    model: &mut Model,
    closure: &Closure<'_>,
    (links, joints): (&[Link], &[Joint]),
    open_m: f64,
) -> Result<(), HandError> {
    let moved = (0..links.len()).filter(|&l| closure.holds(links, l));
    let mut members: Vec<usize> = moved
        .filter_map(|l| links[l].motion.map(|motion| motion.joint))
        .collect();
    members.sort_unstable();
    members.dedup();
    let names: Vec<&str> = members.iter().map(|&j| joints[j].name.as_str()).collect();
    // A joint that others follow is driven rather than one of the linkage, and so is a joint near the root.
    let leads = |j: usize| {
        let of_joint = |link: &&Link| link.motion.is_some_and(|motion| motion.joint == j);
        links.iter().filter(of_joint).count() > 1
    };
    let depth =
        |j: usize| std::iter::successors(Some(joints[j].link), |l| links[l.0].parent).count();
    // Real linkages are short, and the search for many lines is long.
    let mut drivers = if members.len() <= MOST_MEMBERS {
        members.clone()
    } else {
        Vec::new()
    };
    drivers.sort_by_key(|&j| (!leads(j), depth(j), j));
    let zeros: Vec<f64> = joints
        .iter()
        .map(|joint| model.zero_of(&joint.name))
        .collect();
    for driver in drivers {
        let followers: Vec<usize> = members.iter().copied().filter(|&j| j != driver).collect();
        if joints[driver].wraps {
            continue;
        }
        let fit = Fit {
            closure,
            links,
            joints,
            zeros: &zeros,
            driver,
            followers,
        };
        if let Some(lines) = fit.best() {
            fit.apply(model, &lines);
            return Ok(());
        }
    }
    Err(refusal(closure.of, open_m, &names))
}

/// The search for couplings of `followers` to `driver`.
struct Fit<'a> {
    closure: &'a Closure<'a>,
    links: &'a [Link],
    joints: &'a [Joint],
    /// For each joint, its coordinate at displacement zero, at which the loop is closed.
    zeros: &'a [f64],
    driver: usize,
    followers: Vec<usize>,
}

impl Fit<'_> {
    /// Ratio and offset of each follower if these keep the loop closed.
    fn best(&self) -> Option<DVector<f64>> {
        let count = self.followers.len();
        let directions = if count <= MOST_DIRECTIONS {
            3usize.pow(u32::try_from(count).ok()?)
        } else {
            1
        };
        let mut best: Option<(f64, DVector<f64>)> = None;
        for direction in 0..directions {
            let found = self.descend(self.start(direction));
            let open_m = self.open_m(&found);
            if self.is_as_assembled(&found)
                && best.as_ref().is_none_or(|(least, _)| open_m < *least)
            {
                best = Some((open_m, found));
            }
        }
        best.filter(|(open_m, _)| *open_m <= OPEN_M)
            .map(|(_, lines)| lines)
    }

    /// Lines through the pose in which the loop is closed: ratios of 0, 1 or −1 by the digits of `direction`.
    fn start(&self, mut direction: usize) -> DVector<f64> {
        let mut lines = DVector::zeros(2 * self.followers.len());
        for (f, &follower) in self.followers.iter().enumerate() {
            let ratio = [0.0, 1.0, -1.0][direction % 3];
            direction /= 3;
            let ratio = ratio * self.unit(self.driver) / self.unit(follower);
            lines[2 * f] = ratio;
            lines[2 * f + 1] = self.zeros[follower] - ratio * self.zeros[self.driver];
        }
        lines
    }

    fn unit(&self, joint: usize) -> f64 {
        self.joints[joint].kind.radians_per_unit()
    }

    /// Coordinates of all joints with the driver at a share of its range.
    fn coordinates(&self, lines: &DVector<f64>, share: f64) -> Vec<f64> {
        let [low, high] = self.joints[self.driver].limits;
        let driven = low + share * (high - low);
        let mut q: Vec<f64> = (self.joints.iter())
            .map(|joint| f64::midpoint(joint.limits[0], joint.limits[1]))
            .collect();
        q[self.driver] = driven;
        for (f, &follower) in self.followers.iter().enumerate() {
            q[follower] = lines[2 * f] * driven + lines[2 * f + 1];
        }
        q
    }

    fn stations(&self, lines: &DVector<f64>) -> impl Iterator<Item = Vec<f64>> {
        let shares = (0..=STATIONS).map(|k| f64::from(k) / f64::from(STATIONS));
        shares.map(move |share| self.coordinates(lines, share))
    }

    fn open_m(&self, lines: &DVector<f64>) -> f64 {
        let openings = self.stations(lines);
        let openings = openings.map(|q| self.closure.opening_m(&frames(self.links, &q)));
        openings.fold(0.0, f64::max)
    }

    /// What a coordinate is outside its range, as an opening in metres.
    fn excess_m(&self, joint: usize, coordinate: f64) -> f64 {
        if self.joints[joint].wraps {
            return 0.0;
        }
        let [low, high] = self.joints[joint].limits;
        EXCESS_M * self.unit(joint) * ((coordinate - high).max(0.0) + (low - coordinate).max(0.0))
    }

    /// Whether a linkage is assembled as in the description: a loop often closes in several ways.
    fn is_as_assembled(&self, lines: &DVector<f64>) -> bool {
        let [low, high] = self.joints[self.driver].limits;
        let driven = self.zeros[self.driver];
        let described_m = self.closure.opening_m(&frames(self.links, self.zeros));
        if !(low..=high).contains(&driven) || described_m > OPEN_M {
            return true;
        }
        self.followers.iter().enumerate().all(|(f, &follower)| {
            let there = lines[2 * f] * driven + lines[2 * f + 1];
            (there - self.zeros[follower]).abs() * self.unit(follower) < ASSEMBLED
        })
    }

    fn residuals(&self, lines: &DVector<f64>) -> DVector<f64> {
        let mut all = Vec::new();
        for q in self.stations(lines) {
            let frames = frames(self.links, &q);
            for gap in self.closure.gaps(&frames) {
                all.extend(gap.iter());
            }
            all.extend(self.followers.iter().map(|&j| self.excess_m(j, q[j])));
        }
        DVector::from_vec(all)
    }

    /// Least squares by Levenberg and Marquardt with differences as derivatives.
    fn descend(&self, start: DVector<f64>) -> DVector<f64> {
        const DIFFERENCE: f64 = 1e-6;
        let (mut lines, mut damping) = (start, 1e-3);
        let mut residuals = self.residuals(&lines);
        'steps: for _ in 0..STEPS {
            let columns: Vec<DVector<f64>> = (0..lines.len())
                .map(|k| {
                    let mut moved = lines.clone();
                    moved[k] += DIFFERENCE;
                    (self.residuals(&moved) - &residuals) / DIFFERENCE
                })
                .collect();
            let jacobian = DMatrix::from_columns(&columns);
            let normal = jacobian.tr_mul(&jacobian);
            let slope = jacobian.tr_mul(&residuals);
            while damping < 1e9 {
                let mut damped = normal.clone();
                for k in 0..lines.len() {
                    damped[(k, k)] += damping * normal[(k, k)] + 1e-15;
                }
                let step = damped.cholesky().map(|factor| factor.solve(&slope));
                let tried = step.map_or_else(|| lines.clone(), |step| &lines - step);
                let there = self.residuals(&tried);
                let gain = 1.0 - there.norm_squared() / residuals.norm_squared();
                if gain > 0.0 {
                    (lines, residuals) = (tried, there);
                    damping = (damping / 4.0).max(1e-12);
                    if gain > 1e-6 {
                        continue 'steps;
                    }
                    return lines;
                }
                damping *= 4.0;
            }
            break;
        }
        lines
    }

    /// Couples the joints of the model.
    fn apply(&self, model: &mut Model, lines: &DVector<f64>) {
        let driver = &self.joints[self.driver].name;
        let mut told = Vec::new();
        for (f, &follower) in self.followers.iter().enumerate() {
            let name = &self.joints[follower].name;
            let (ratio, offset) = (lines[2 * f], lines[2 * f + 1]);
            let beyond = BEYOND / self.unit(follower);
            for joint in model.joints.iter_mut().filter(|joint| joint.name == *name) {
                // A linkage that only touches its end stop must not stop the driven joint.
                joint.limits = joint
                    .limits
                    .map(|[low, high]| [low - beyond, high + beyond]);
                joint.follows = Some(Coupling {
                    joint: driver.clone(),
                    ratio,
                    offset,
                });
            }
            // Rounded first, so that no −0 is printed.
            let [ratio, offset] = [ratio, offset].map(|x| (1e3 * x).round() / 1e3 + 0.0);
            told.push(if offset == 0.0 {
                format!("{name} = {ratio:.3} {driver}")
            } else {
                format!("{name} = {ratio:.3} {driver} {offset:+.3}")
            });
        }
        let [first, second] = &self.closure.of.links;
        model.notes.push(format!(
            "{} closes a loop between the links \"{first}\" and \"{second}\": its joints follow one of them here ({}), which \
             keeps the loop closed within {:.2} mm; other motions of the loop are left out",
            self.closure.of.place,
            told.join(", "),
            1e3 * self.open_m(lines)
        ));
    }
}
