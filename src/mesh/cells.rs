//! The cells into which triangles cut space.
//!
//! Which side of a triangle is outside is found without its orientation: about each edge the triangles are sorted by their
//! angle, and the sides of two neighbours that face each other border one cell (Zhou et al. 2016, *Mesh Arrangements for
//! Solid Geometry*). A cell that cannot be reached from far away is enclosed. So a solid is recognised whose triangles are
//! there in both directions, several times, or with walls inside.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::Vector3;

/// Triangles whose angles about an edge differ by less lie on each other, radians. Single-precision coordinates turn triangles
/// of one plane by up to about a hundred-thousandth.
const FLUSH_RAD: f64 = 1e-4;
/// Cells with less negative volume than this share of the largest are flat, and their sign is a rounding error.
const FLAT: f64 = 1e-9;

/// What a triangle separates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The outside from an enclosed cell; `turned` if its normal points into the cell.
    Boundary { turned: bool },
    /// Two enclosed cells.
    Wall,
    /// Nothing: the outside lies on both sides.
    Sheet,
}

/// The roles of triangles.
#[derive(Debug)]
pub(super) struct Cells {
    /// For each triangle, what it separates.
    pub(super) roles: Vec<Role>,
    /// For each triangle, the part of the surface that is connected by edges.
    pub(super) parts: Vec<usize>,
    /// For each triangle at the boundary, the solid that it bounds: enclosed cells without the walls between them.
    pub(super) solids: Vec<usize>,
    /// Whether triangles lie on each other at some edge.
    flush: bool,
    /// Number of triangles that were given. Those after them close holes.
    given: usize,
}

/// A triangle at an edge.
#[derive(Debug, Clone, Copy)]
struct Blade {
    triangle: usize,
    /// Whether it runs along the edge from the lower index to the higher.
    up: bool,
}

impl Blade {
    /// Number of its side that faces growing angles. Sides 2 t and 2 t + 1 are front and back of triangle t.
    fn ahead(self) -> usize {
        2 * self.triangle + usize::from(!self.up)
    }

    /// Number of its side that faces falling angles.
    fn behind(self) -> usize {
        2 * self.triangle + usize::from(self.up)
    }
}

/// Calls `see` for each edge of the triangles in `seen`, with its triangles in the order of their angles. Triangles that lie on
/// each other form one group, but for those from `given` on, which close holes: beside a hole that bends in its plane they lie
/// on its neighbours, and yet the surface goes on there.
fn for_each_edge(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    given: usize,
    seen: impl Iterator<Item = usize>,
    mut see: impl FnMut(&[Vec<Blade>]),
) {
    let mut uses: Vec<([u32; 2], u32, Blade)> = Vec::new();
    for triangle in seen {
        let [a, b, c] = triangles[triangle];
        for [from, to, other] in [[a, b, c], [b, c, a], [c, a, b]] {
            let blade = Blade {
                triangle,
                up: from < to,
            };
            uses.push(([from.min(to), from.max(to)], other, blade));
        }
    }
    uses.sort_by_key(|(edge, _, blade)| (*edge, blade.triangle));
    for at in uses.chunk_by(|one, next| one.0 == next.0) {
        see(&groups(vertices, given, at));
    }
}

/// The triangles at one edge, grouped and sorted by angle.
fn groups(
    vertices: &[Vector3<f64>],
    given: usize,
    at: &[([u32; 2], u32, Blade)],
) -> Vec<Vec<Blade>> {
    let closes_hole = |blade: &Blade| blade.triangle >= given;
    let [low, high] = at[0].0.map(|vertex| vertices[vertex as usize]);
    let along = (high - low).try_normalize(0.0).unwrap_or_default();
    let outward = |other: u32| {
        let offset = vertices[other as usize] - low;
        offset - along * along.dot(&offset)
    };
    let first = outward(at[0].1);
    let second = along.cross(&first);
    let angle = |other: u32| {
        let offset = outward(other);
        let angle = libm::atan2(
            offset.dot(&second) * first.norm(),
            offset.dot(&first) * second.norm(),
        );
        if angle < 0.0 { angle + TAU } else { angle }
    };
    let mut blades: Vec<(f64, Blade)> = at.iter().map(|(_, o, b)| (angle(*o), *b)).collect();
    blades.sort_by(|(a, one), (b, other)| a.total_cmp(b).then(one.triangle.cmp(&other.triangle)));
    let mut groups: Vec<Vec<Blade>> = Vec::with_capacity(blades.len());
    let mut before = f64::NEG_INFINITY;
    for (angle, blade) in &blades {
        match groups.last_mut() {
            Some(group)
                if angle - before < FLUSH_RAD && !closes_hole(blade) && !closes_hole(&group[0]) =>
            {
                group.push(*blade);
            }
            _ => groups.push(vec![*blade]),
        }
        before = *angle;
    }
    // Rounding may have put a triangle of the first group at the end of the turn.
    let at_ends = [&groups[0], &groups[groups.len() - 1]];
    let of_given = at_ends.iter().all(|group| !closes_hole(&group[0]));
    if groups.len() > 1 && of_given && blades[0].0 + TAU - before < FLUSH_RAD {
        let last = groups.pop().unwrap_or_default();
        groups[0].extend(last);
    }
    groups
}

impl Cells {
    /// The cells of triangles, of which those from the index `given` on close holes.
    pub(super) fn new(vertices: &[Vector3<f64>], triangles: &[[u32; 3]], given: usize) -> Self {
        let count = triangles.len();
        let (mut sides, mut parts) = (Sets::new(2 * count), Sets::new(count));
        let mut flush = false;
        for_each_edge(vertices, triangles, given, 0..count, |groups| {
            let mut last = groups[groups.len() - 1][0];
            for group in groups {
                let here = group[0];
                sides.join(last.ahead(), here.behind());
                parts.join(last.triangle, here.triangle);
                for blade in &group[1..] {
                    flush = true;
                    sides.join(here.ahead(), blade.ahead());
                    sides.join(here.behind(), blade.behind());
                    parts.join(here.triangle, blade.triangle);
                }
                last = here;
            }
        });
        let parts: Vec<usize> = (0..count).map(|t| parts.of(t)).collect();
        let outside = outside(vertices, triangles, &parts, &mut sides);
        let mut solids = Sets::new(2 * count);
        let mut roles = Vec::with_capacity(count);
        for triangle in 0..count {
            let [front, back] = [0, 1].map(|side| sides.of(2 * triangle + side));
            let role = match [outside[front], outside[back]] {
                [true, false] => Role::Boundary { turned: false },
                [false, true] => Role::Boundary { turned: true },
                [true, true] => Role::Sheet,
                [false, false] => {
                    solids.join(front, back);
                    Role::Wall
                }
            };
            roles.push(role);
        }
        let solid_of = |triangle: usize| {
            let side = usize::from(roles[triangle] == Role::Boundary { turned: false });
            let cell = sides.of(2 * triangle + side);
            solids.of(cell)
        };
        let solids = (0..count).map(solid_of).collect();
        Self {
            roles,
            parts,
            solids,
            flush,
            given,
        }
    }

    pub(super) fn is_boundary(&self, triangle: usize) -> bool {
        matches!(self.roles[triangle], Role::Boundary { .. })
    }

    /// Of triangles of one role that lie on each other in different divisions of the same polygon, those of one division.
    pub(super) fn one_layer(
        &self,
        vertices: &[Vector3<f64>],
        triangles: &[[u32; 3]],
        of_role: impl Fn(Role) -> bool,
    ) -> Vec<bool> {
        let of_this_role =
            || (0..triangles.len()).filter(|&triangle| of_role(self.roles[triangle]));
        let mut kept = vec![false; triangles.len()];
        if !self.flush {
            for triangle in of_this_role() {
                kept[triangle] = true;
            }
            return kept;
        }
        let mut layers = Layers::new(triangles.len());
        for_each_edge(vertices, triangles, self.given, of_this_role(), |groups| {
            layers.add(groups, &self.roles);
        });
        for triangle in of_this_role() {
            layers.settle(triangle, true);
        }
        for triangle in of_this_role() {
            kept[triangle] = layers.kept[triangle] == Some(true);
        }
        kept
    }
}

/// For each set of sides, whether it borders the outside: for each part, the cell that surrounds it. Volumes are signed so
/// that those of enclosed cells are positive.
fn outside(
    vertices: &[Vector3<f64>],
    triangles: &[[u32; 3]],
    parts: &[usize],
    sides: &mut Sets,
) -> Vec<bool> {
    let mut volumes = vec![0.0; 2 * triangles.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        let origin = vertices[triangles[parts[triangle]][0] as usize];
        let [a, b, c] = corners.map(|vertex| vertices[vertex as usize] - origin);
        let volume = a.dot(&b.cross(&c));
        volumes[sides.of(2 * triangle)] -= volume;
        volumes[sides.of(2 * triangle + 1)] += volume;
    }
    // The most negative volume of each part, and the cell that has it.
    let mut least: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for (triangle, &part) in parts.iter().enumerate() {
        for side in [0, 1] {
            let cell = sides.of(2 * triangle + side);
            let entry = least.entry(part).or_insert((volumes[cell], cell));
            if volumes[cell] < entry.0 {
                *entry = (volumes[cell], cell);
            }
        }
    }
    let mut outside = vec![false; 2 * triangles.len()];
    for (triangle, part) in parts.iter().enumerate() {
        for side in [0, 1] {
            let cell = sides.of(2 * triangle + side);
            let (most, surrounding) = least[part];
            outside[cell] = cell == surrounding || volumes[cell] < FLAT * most;
        }
    }
    outside
}

/// The choice between triangles that lie on each other.
struct Layers {
    /// Whether a triangle is kept; `None` if it is open.
    kept: Vec<Option<bool>>,
    /// The groups that a triangle belongs to.
    groups_of: Vec<Vec<usize>>,
    groups: Vec<Vec<usize>>,
    /// The group where the surface goes on.
    next: Vec<Option<usize>>,
}

impl Layers {
    fn new(count: usize) -> Self {
        Self {
            kept: vec![None; count],
            groups_of: vec![Vec::new(); count],
            groups: Vec::new(),
            next: Vec::new(),
        }
    }

    /// Adds the triangles of an edge.
    fn add(&mut self, groups: &[Vec<Blade>], roles: &[Role]) {
        let (first, count) = (self.groups.len(), groups.len());
        for (place, group) in groups.iter().enumerate() {
            let Blade { triangle, up } = group[0];
            let following = match roles[triangle] {
                // The solid is behind a triangle that faces outward.
                Role::Boundary { turned } if up == turned => Some((place + 1) % count),
                Role::Boundary { .. } => Some((place + count - 1) % count),
                _ if count == 2 => Some(1 - place),
                _ => None,
            };
            let following = following.filter(|&following| following != place);
            self.next.push(following.map(|following| first + following));
            for blade in group {
                self.groups_of[blade.triangle].push(first + place);
            }
            self.groups
                .push(group.iter().map(|blade| blade.triangle).collect());
        }
    }

    /// Keeps or drops a triangle if it is open, and all others that follow from this: of a group one triangle is kept if one
    /// of the group where the surface goes on is kept.
    fn settle(&mut self, triangle: usize, keep: bool) {
        let mut waiting = vec![(triangle, keep)];
        while let Some((triangle, keep)) = waiting.pop() {
            if self.kept[triangle].is_some() {
                continue;
            }
            self.kept[triangle] = Some(keep);
            let Self {
                kept,
                groups_of,
                groups,
                next,
            } = &*self;
            let of = |group: usize, state: Option<bool>| {
                let members = groups[group].iter().copied();
                members.filter(move |&member| kept[member] == state)
            };
            for &group in &groups_of[triangle] {
                if keep {
                    waiting.extend(of(group, None).map(|member| (member, false)));
                }
                let Some(next) = next[group] else {
                    continue;
                };
                let mut open = of(next, None);
                if keep {
                    if let (Some(only), None) = (open.next(), open.next())
                        && of(next, Some(true)).next().is_none()
                    {
                        waiting.push((only, true));
                    }
                } else if of(group, Some(false)).count() == groups[group].len() {
                    waiting.extend(open.map(|member| (member, false)));
                }
            }
        }
    }
}

/// Disjoint sets of numbers.
#[derive(Debug)]
pub(super) struct Sets(Vec<usize>);

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The number that stands for the set of `number`.
    pub(super) fn of(&mut self, mut number: usize) -> usize {
        while self.0[number] != number {
            self.0[number] = self.0[self.0[number]];
            number = self.0[number];
        }
        number
    }

    pub(super) fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.of(one), self.of(other));
        // The lowest number stands for a set, so that sets do not depend on the order of joins.
        self.0[one.max(other)] = one.min(other);
    }
}
