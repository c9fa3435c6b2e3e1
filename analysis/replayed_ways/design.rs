//! The numbers of docs/decisions/replay.md, and the ways that are drawn by them.

use landscape::sample::{Rng, Task, stream};
use landscape::store::{EdgeRow, LandscapeFiles};
use landscape::topography::MinimumId;
use rand::RngExt;
use rand::seq::SliceRandom;

pub(crate) const HANDS: [&str; 2] = ["human", "gripper_three_finger"];
pub(crate) const OBJECTS: [&str; 4] = ["bottle_round", "box", "ball", "mug"];
/// Chains of each landscape.
pub(crate) const CHAINS: &str = "24";
/// Neighbours to which each minimum is connected, and the settings of the map.
pub(crate) const NEIGHBOURS: &str = "3";
pub(crate) const MAP: &str = "[map]\nsearches = 0\n";
/// Seeds of the counted run, and of trial runs.
pub(crate) const SEED: u64 = 6201;
pub(crate) const TRIAL_SEED: u64 = 99;
/// Edges and random pairs drawn in each landscape, if it has so many.
const EDGES: usize = 40;
const PAIRS: usize = 10;
/// Classes of barrier, and of length within each.
const CLASSES: [usize; 2] = [4, 3];
/// Number of conditions of `Replay::conditions`, of which the first is the main one.
pub(crate) const CONDITIONS: usize = 4;

/// Landscapes that are driven under the main condition alone: the engine takes ten seconds for a drive of this hand.
const MAIN_ALONE: [&str; 3] = [
    "gripper_three_finger.box",
    "gripper_three_finger.ball",
    "gripper_three_finger.mug",
];

/// What is driven: a posture, the path of an edge, its straight line, and that between two minima that no edge joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Rest,
    Relaxed,
    Straight,
    Random,
}

/// One way, from a minimum to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Drive {
    pub(crate) kind: Kind,
    pub(crate) ends: [MinimumId; 2],
}

impl Drive {
    /// How many of the conditions it is driven under in a landscape: the controls and `MAIN_ALONE` under the main one alone.
    pub(crate) fn conditions(self, set: &str) -> usize {
        match self.kind {
            Kind::Rest | Kind::Relaxed if !MAIN_ALONE.contains(&set) => CONDITIONS,
            _ => 1,
        }
    }

    pub(crate) fn key(self) -> String {
        let [from, to] = self.ends.map(|end| end.0);
        format!("{:?} {from} {to}", self.kind).to_lowercase()
    }
}

/// The drives of a landscape: edges as paths and straight lines, random pairs, and all their ends at rest.
pub(crate) fn drawn(files: &LandscapeFiles, seed: u64) -> Vec<Drive> {
    let mut rng = stream(seed, Task::Resampling, 0);
    let mut drives = Vec::new();
    for edge in stratified(files, &mut rng) {
        let [a, b] = ends(edge);
        let ends = if rng.random::<bool>() { [a, b] } else { [b, a] };
        drives.extend([Kind::Relaxed, Kind::Straight].map(|kind| Drive { kind, ends }));
    }
    let joined: Vec<[MinimumId; 2]> = files.edges.iter().map(ends).collect();
    let all = || (0..files.minima.len()).map(MinimumId);
    let pairs = all().flat_map(|a| all().map(move |b| [a, b]));
    let apart = |[a, b]: &[MinimumId; 2]| {
        a != b
            && ![[*a, *b], [*b, *a]]
                .iter()
                .any(|pair| joined.contains(pair))
    };
    let mut pairs: Vec<[MinimumId; 2]> = pairs.filter(apart).collect();
    pairs.shuffle(&mut rng);
    let kind = Kind::Random;
    drives.extend(
        pairs
            .into_iter()
            .take(PAIRS)
            .map(|ends| Drive { kind, ends }),
    );
    let mut resting: Vec<MinimumId> = drives.iter().flat_map(|one| one.ends).collect();
    resting.sort_unstable();
    resting.dedup();
    let kind = Kind::Rest;
    drives.extend(resting.into_iter().map(|end| Drive {
        kind,
        ends: [end; 2],
    }));
    drives
}

/// The minima of an edge.
pub(crate) fn ends(edge: &EdgeRow) -> [MinimumId; 2] {
    [edge.a, edge.b].map(|end| MinimumId(usize::try_from(end).unwrap_or(usize::MAX)))
}

/// Edges with a path, in turn from classes of barrier and of length within these.
fn stratified<'a>(files: &'a LandscapeFiles, rng: &mut Rng) -> Vec<&'a EdgeRow> {
    let has_path = |edge: &EdgeRow| {
        files
            .paths
            .iter()
            .any(|row| (row.a, row.b) == (edge.a, edge.b))
    };
    let known = |edge: &&EdgeRow| {
        edge.relative_barrier.is_some() && edge.length.is_some() && has_path(edge)
    };
    let mut edges: Vec<&EdgeRow> = files.edges.iter().filter(known).collect();
    let mut classes: Vec<Vec<&EdgeRow>> = Vec::new();
    let by = |value: fn(&EdgeRow) -> Option<f64>| {
        move |a: &&EdgeRow, b: &&EdgeRow| {
            value(a).unwrap_or(0.0).total_cmp(&value(b).unwrap_or(0.0))
        }
    };
    edges.sort_by(by(|edge| edge.relative_barrier));
    let size = edges.len().div_ceil(CLASSES[0]).max(1);
    for of_barrier in edges.chunks_mut(size) {
        of_barrier.sort_by(by(|edge| edge.length));
        let size = of_barrier.len().div_ceil(CLASSES[1]).max(1);
        classes.extend(of_barrier.chunks(size).map(<[_]>::to_vec));
    }
    for class in &mut classes {
        class.shuffle(rng);
    }
    let longest = classes.iter().map(Vec::len).max().unwrap_or(0);
    let turns =
        (0..longest).flat_map(|turn| classes.iter().filter_map(move |class| class.get(turn)));
    turns.take(EDGES).copied().collect()
}
