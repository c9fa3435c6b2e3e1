//! Clusters of atoms, modulo position, orientation, handedness and numbering of equal atoms.

use nalgebra::{Matrix3, Matrix4, Quaternion, UnitQuaternion, Vector3};

use super::Space;
use super::assignment::Assignment;
use super::rotation::any_normal;

/// Configurations of n atoms in ℝ³, modulo translations, rotations, mirror images and permutations of atoms of one kind.
///
/// A point is `[x₁, y₁, z₁, x₂, …]` (3n numbers), a tangent a displacement of every atom, and
///
/// ```text
/// d(a, b) = min over R ∈ O(3), permutations P of ‖(a − ā) − R P (b − b̄)‖
/// ```
///
/// The rotation is optimal for given partners (Horn, J. Opt. Soc. Am. A 4, 629 (1987)), and the partners are optimal for a
/// given rotation (linear assignment). Both alternate from several starts until nothing changes. The starts put one pair of
/// atoms of either cluster on every ordered pair of the other's, in both mirror images; a start is skipped if its pair
/// alone proves that no nearer copy can follow. This finds the minimum, up to 10⁻⁸ of the cluster's size, whenever the
/// clusters are near each other compared with the distance between neighbouring atoms, so copies of one structure are
/// always recognised. For clusters farther apart it is a heuristic and `d` an upper bound (between all Lennard-Jones minima
/// and saddles of 7 atoms, 1 of 120 distances is not the least, by 1.6 %).
///
/// An alignment takes microseconds between neighbours on a path, 0.2 ms between unrelated clusters of 7 atoms, and 0.2 s at
/// 38 atoms.
///
/// Straight lines between aligned configurations are the geodesics of this space, and all their points are aligned.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    atoms: usize,
    /// The kind of each atom; empty if all are equal.
    kinds: Vec<usize>,
}

/// Largest number of starts per alignment: all starts up to 22 atoms, the most promising ones of bigger clusters.
const STARTS: usize = 1000;
/// The same for a quick alignment.
const FEW_STARTS: usize = 50;

impl Cluster {
    /// Clusters of `atoms` equal atoms.
    pub const fn new(atoms: usize) -> Self {
        Self {
            atoms,
            kinds: Vec::new(),
        }
    }

    /// Clusters of atoms of these kinds, such as their elements. Only atoms of one kind may change places.
    pub fn of_kinds(kinds: &[usize]) -> Self {
        Self {
            atoms: kinds.len(),
            kinds: kinds.to_vec(),
        }
    }

    fn log_with(&self, starts: usize, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let n = 3 * self.atoms;
        assert_eq!((a.len(), b.len(), tangent.len()), (n, n, n));
        if self.atoms == 0 {
            return 0.0;
        }
        let (a, b) = (centred(a), centred(b));
        let copy = nearest_copy(&a, &b, &self.kinds, 0.0, starts);
        for ((step, from), to) in tangent.chunks_exact_mut(3).zip(&a).zip(&copy) {
            step.copy_from_slice((to - from).as_slice());
        }
        squared_distance(&a, &copy).sqrt()
    }
}

impl Space for Cluster {
    fn coordinates(&self) -> usize {
        3 * self.atoms
    }

    fn tangents(&self) -> usize {
        3 * self.atoms
    }

    fn exp(&self, x: &mut [f64], tangent: &[f64]) {
        assert_eq!((x.len(), tangent.len()), (3 * self.atoms, 3 * self.atoms));
        for (coordinate, step) in x.iter_mut().zip(tangent) {
            *coordinate += step;
        }
    }

    fn log(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        self.log_with(STARTS, a, b, tangent)
    }

    fn log_quickly(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        self.log_with(FEW_STARTS, a, b, tangent)
    }

    /// Compares the sorted distances from the centroid first. The search for a near copy then leaves out every start that
    /// cannot lead so near, and ends at the first copy that is near enough.
    fn within(&self, a: &[f64], b: &[f64], reach: f64) -> bool {
        let landmarks = [a, b].map(|x| self.landmarks(x));
        let apart = landmarks[0].iter().zip(&landmarks[1]);
        if self.atoms == 0 || apart.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() > reach {
            return self.atoms == 0;
        }
        let (a, b) = (centred(a), centred(b));
        squared_distance(&a, &nearest_copy(&a, &b, &self.kinds, reach, STARTS)).sqrt() <= reach
    }

    /// The distances of the atoms from their centroid, sorted within each kind.
    fn landmarks(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), 3 * self.atoms);
        let radii = centred(x).into_iter().map(|atom| atom.norm());
        let mut radii: Vec<(usize, f64)> = (radii.enumerate())
            .map(|(atom, radius)| (kind(&self.kinds, atom), radius))
            .collect();
        radii.sort_by(|(one, a), (other, b)| one.cmp(other).then(a.total_cmp(b)));
        radii.into_iter().map(|(_, radius)| radius).collect()
    }

    /// The logarithm modulo translations and rotations only; the numbering of the atoms is kept.
    fn log_near(&self, a: &[f64], b: &[f64], tangent: &mut [f64]) -> f64 {
        let n = 3 * self.atoms;
        assert_eq!((a.len(), b.len(), tangent.len()), (n, n, n));
        if self.atoms == 0 {
            return 0.0;
        }
        let (a, mut b) = (centred(a), centred(b));
        let rotation = best_rotation(&a, &b).to_rotation_matrix();
        for ((step, from), to) in tangent.chunks_exact_mut(3).zip(&a).zip(&mut b) {
            *to = rotation * *to;
            step.copy_from_slice((*to - from).as_slice());
        }
        squared_distance(&a, &b).sqrt()
    }

    /// Three translations and three rotations; fewer rotations if all atoms lie on a line or in a point.
    fn zero_modes(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), 3 * self.atoms);
        if self.atoms == 0 {
            return Vec::new();
        }
        let arms = centred(x);
        let size = arms.iter().map(Vector3::norm_squared).sum::<f64>().sqrt();
        let mut modes: Vec<Vec<f64>> = Vec::with_capacity(6);
        for axis in 0..3 {
            let mut mode = vec![0.0; x.len()];
            mode.iter_mut()
                .skip(axis)
                .step_by(3)
                .for_each(|k| *k = (self.atoms as f64).sqrt().recip());
            modes.push(mode);
        }
        // Principal axes make the rotations orthogonal to each other; translations are orthogonal to them anyway.
        let inertia = arms.iter().fold(Matrix3::zeros(), |sum, arm| {
            sum + Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()
        });
        for axis in inertia.symmetric_eigen().eigenvectors.column_iter() {
            let turned: Vec<f64> = arms
                .iter()
                .flat_map(|arm| axis.cross(arm).data.0[0])
                .collect();
            let length = turned.iter().map(|k| k * k).sum::<f64>().sqrt();
            if length > 1e-8 * size {
                modes.push(turned.into_iter().map(|k| k / length).collect());
            }
        }
        modes.concat()
    }
}

/// The kind of an atom; no list of kinds means that all are equal.
fn kind(kinds: &[usize], atom: usize) -> usize {
    kinds.get(atom).copied().unwrap_or(0)
}

fn centred(x: &[f64]) -> Vec<Vector3<f64>> {
    let atoms: Vec<_> = x.chunks_exact(3).map(Vector3::from_column_slice).collect();
    let centroid = atoms.iter().sum::<Vector3<f64>>() / atoms.len() as f64;
    atoms.into_iter().map(|atom| atom - centroid).collect()
}

fn squared_distance(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(from, to)| (to - from).norm_squared())
        .sum()
}

/// The copy of `b` nearest to `a` (both centred), with its atoms in the order of their partners in `a`. A copy within `enough`
/// need not be the nearest, and if there is none, any copy may be returned; 0 asks for the nearest in any case.
fn nearest_copy(
    a: &[Vector3<f64>],
    b: &[Vector3<f64>],
    kinds: &[usize],
    enough: f64,
    most_starts: usize,
) -> Vec<Vector3<f64>> {
    let size = a.iter().chain(b).map(Vector3::norm_squared).sum::<f64>();
    if !size.is_finite() {
        return b.to_vec();
    }
    let near = enough * enough;
    let done = |best: f64| best <= near.max(1e-16 * size);
    let most = if enough > 0.0 { near } else { f64::INFINITY };
    let mut search = Search::new(a, b, kinds);
    // First the present numbering, then the present orientation: along a path one of them is right.
    search.visit(false, &(0..b.len()).collect::<Vec<_>>());
    search.descend(false, &UnitQuaternion::identity());
    if done(search.best) {
        return search.copy;
    }

    let mut starts = Vec::with_capacity(2 * b.len() * b.len());
    let mut offer = |pair: [usize; 2], partners: [usize; 2]| {
        if pair.map(|i| kind(kinds, i)) != partners.map(|j| kind(kinds, j)) {
            return;
        }
        let bound = pair_bound(pair.map(|i| &a[i]), partners.map(|j| &b[j]));
        // The bound is a difference of numbers as large as `size`.
        if bound < search.best.min(most) + 1e-14 * size {
            starts.push((bound, pair, partners));
        }
    };
    let (of_a, of_b) = (anchors(a), anchors(b));
    for i in 0..b.len() {
        for j in (0..b.len()).filter(|j| *j != i) {
            offer(of_a, [i, j]);
            offer([i, j], of_b);
        }
    }
    let key = |start: &(f64, [usize; 2], [usize; 2])| (start.1, start.2);
    starts.sort_unstable_by(|one, other| {
        one.0
            .total_cmp(&other.0)
            .then_with(|| key(one).cmp(&key(other)))
    });
    for (bound, [p, q], [i, j]) in starts.into_iter().take(most_starts) {
        if done(search.best) || bound > search.best.min(most) + 1e-14 * size {
            break;
        }
        let target = frame(&a[p], &a[q]);
        search.descend(false, &(target * frame(&b[i], &b[j]).inverse()));
        search.descend(true, &(target * frame(&-b[i], &-b[j]).inverse()));
    }
    search.copy
}

/// The pair of atoms that fixes the orientation best: the atom farthest from the centroid and the atom farthest from its
/// line.
fn anchors(a: &[Vector3<f64>]) -> [usize; 2] {
    let largest = |measure: &dyn Fn(&Vector3<f64>) -> f64| {
        (0..a.len())
            .max_by(|i, j| measure(&a[*i]).total_cmp(&measure(&a[*j])))
            .unwrap_or(0)
    };
    let p = largest(&Vector3::norm_squared);
    [p, largest(&|atom| atom.cross(&a[p]).norm_squared())]
}

/// min over R ∈ O(3) of `Σ ‖a_k − R b_k‖²` for two atoms: a lower bound for every copy of the cluster with this pairing.
///
/// ```text
/// Σ (‖a_k‖² + ‖b_k‖²) − 2 (σ₁ + σ₂),   (σ₁ + σ₂)² = ‖H‖² + 2 σ₁σ₂,   σ₁σ₂ = ‖a₁×a₂‖ ‖b₁×b₂‖,   H = Σ a_k b_kᵀ
/// ```
fn pair_bound(a: [&Vector3<f64>; 2], b: [&Vector3<f64>; 2]) -> f64 {
    let (a1, a2) = (a[0].norm_squared(), a[1].norm_squared());
    let (b1, b2) = (b[0].norm_squared(), b[1].norm_squared());
    let norm = a1 * b1 + a2 * b2 + 2.0 * a[0].dot(a[1]) * b[0].dot(b[1]);
    let product = (a[0].cross(a[1]).norm_squared() * b[0].cross(b[1]).norm_squared()).sqrt();
    a1 + a2 + b1 + b2 - 2.0 * (norm + 2.0 * product).max(0.0).sqrt()
}

/// The orientation whose first axis points along `first`, with `second` on a fixed side of it.
fn frame(first: &Vector3<f64>, second: &Vector3<f64>) -> UnitQuaternion<f64> {
    // An atom at the centroid or a pair on a line leaves the orientation partly free; any choice is valid.
    let ahead = first.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let normal = ahead.cross(second);
    let normal = if normal.norm() > 1e-12 * second.norm() {
        normal
    } else {
        any_normal(&ahead)
    };
    UnitQuaternion::face_towards(&ahead, &normal)
}

/// The best copy so far, the pairings already tried, and the buffers of the descent.
struct Search<'a> {
    a: &'a [Vector3<f64>],
    /// The atoms of b and of its mirror image −b.
    b: [Vec<Vector3<f64>>; 2],
    best: f64,
    copy: Vec<Vector3<f64>>,
    trial: Vec<Vector3<f64>>,
    /// Lists of partners already tried with each image, concatenated.
    visited: [Vec<usize>; 2],
    kinds: &'a [usize],
    /// More than all distances of partners together.
    forbidden: f64,
    cost: Vec<f64>,
    assignment: Assignment,
}

impl<'a> Search<'a> {
    fn new(a: &'a [Vector3<f64>], b: &[Vector3<f64>], kinds: &'a [usize]) -> Self {
        // ‖a_i − R b_j‖² ≤ 2 ‖a_i‖² + 2 ‖b_j‖².
        let all = a.iter().chain(b).map(Vector3::norm_squared).sum::<f64>();
        Self {
            a,
            b: [b.to_vec(), b.iter().map(|atom| -atom).collect()],
            best: f64::INFINITY,
            copy: b.to_vec(),
            trial: b.to_vec(),
            visited: [Vec::new(), Vec::new()],
            kinds,
            forbidden: 4.0 * all,
            cost: vec![0.0; a.len() * a.len()],
            assignment: Assignment::new(a.len()),
        }
    }

    /// Alternates best partners and best rotation, starting with `rotation`, until the partners have been tried before.
    fn descend(&mut self, mirrored: bool, rotation: &UnitQuaternion<f64>) {
        let mut rotation = *rotation;
        let n = self.a.len();
        // The loop ends because each round tries new partners.
        loop {
            let matrix = rotation.to_rotation_matrix();
            for (j, atom) in self.b[usize::from(mirrored)].iter().enumerate() {
                let turned = matrix * atom;
                for (i, target) in self.a.iter().enumerate() {
                    self.cost[i * n + j] = if kind(self.kinds, i) == kind(self.kinds, j) {
                        (target - turned).norm_squared()
                    } else {
                        self.forbidden
                    };
                }
            }
            self.assignment.solve(&self.cost);
            let partners = std::mem::take(&mut self.assignment.column);
            let next = self.visit(mirrored, &partners);
            self.assignment.column = partners;
            match next {
                Some(better) => rotation = better,
                None => return,
            }
        }
    }

    /// Computes the best rotation for new partners and keeps the copy if it is the nearest so far; `None` for partners
    /// tried before.
    fn visit(&mut self, mirrored: bool, partners: &[usize]) -> Option<UnitQuaternion<f64>> {
        let visited = &mut self.visited[usize::from(mirrored)];
        if visited
            .chunks_exact(partners.len())
            .any(|tried| tried == partners)
        {
            return None;
        }
        visited.extend_from_slice(partners);
        for (place, partner) in self.trial.iter_mut().zip(partners) {
            *place = self.b[usize::from(mirrored)][*partner];
        }
        let rotation = best_rotation(self.a, &self.trial);
        let matrix = rotation.to_rotation_matrix();
        for atom in &mut self.trial {
            *atom = matrix * *atom;
        }
        let distance = squared_distance(self.a, &self.trial);
        if distance < self.best {
            self.best = distance;
            self.copy.copy_from_slice(&self.trial);
        }
        Some(rotation)
    }
}

/// Rotation R that minimises `Σ ‖a_i − R b_i‖²`: the eigenvector of the largest eigenvalue of Horn's 4 × 4 matrix.
fn best_rotation(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> UnitQuaternion<f64> {
    let s = b.iter().zip(a).fold(Matrix3::zeros(), |sum, (from, to)| {
        sum + from * to.transpose()
    });
    #[rustfmt::skip]
    let horn = Matrix4::new(
        s.m11 + s.m22 + s.m33, s.m23 - s.m32, s.m31 - s.m13, s.m12 - s.m21,
        s.m23 - s.m32, s.m11 - s.m22 - s.m33, s.m12 + s.m21, s.m31 + s.m13,
        s.m31 - s.m13, s.m12 + s.m21, s.m22 - s.m11 - s.m33, s.m23 + s.m32,
        s.m12 - s.m21, s.m31 + s.m13, s.m23 + s.m32, s.m33 - s.m11 - s.m22,
    );
    let eigen = horn.symmetric_eigen();
    let q = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]))
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::sample::{Rng, Task, stream};
    use crate::space::rotation::exp;

    fn random_cluster(n: usize, rng: &mut Rng) -> Vec<f64> {
        (0..3 * n).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    /// A rigidly moved, renumbered and perhaps mirrored copy. Only atoms of one kind are renumbered.
    fn disguised(x: &[f64], kinds: &[usize], mirror: bool, rng: &mut Rng) -> Vec<f64> {
        let mut atoms: Vec<Vector3<f64>> =
            x.chunks_exact(3).map(Vector3::from_column_slice).collect();
        for i in (1..atoms.len()).rev() {
            let j = rng.random_range(0..=i);
            if kind(kinds, i) == kind(kinds, j) {
                atoms.swap(i, j);
            }
        }
        let rotation = exp(&Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0)));
        let shift = Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0));
        let sign = if mirror { -1.0 } else { 1.0 };
        atoms
            .iter()
            .flat_map(|atom| (rotation * (atom * sign) + shift).data.0[0])
            .collect()
    }

    fn best_by_enumeration(
        a: &[Vector3<f64>],
        b: &[Vector3<f64>],
        kinds: &[usize],
        order: &mut Vec<usize>,
    ) -> f64 {
        if order.len() == a.len() {
            let mut best = f64::INFINITY;
            for sign in [1.0, -1.0] {
                let copy: Vec<_> = order.iter().map(|i| b[*i] * sign).collect();
                let rotation = best_rotation(a, &copy);
                let turned: Vec<_> = copy.iter().map(|atom| rotation * atom).collect();
                best = best.min(squared_distance(a, &turned));
            }
            return best;
        }
        let mut best = f64::INFINITY;
        for i in 0..b.len() {
            if !order.contains(&i) && kind(kinds, i) == kind(kinds, order.len()) {
                order.push(i);
                best = best.min(best_by_enumeration(a, b, kinds, order));
                order.pop();
            }
        }
        best
    }

    #[test]
    fn copies_are_recognised() {
        let mut rng = stream(1, Task::Start, 0);
        for n in [1, 2, 3, 4, 7, 13, 38] {
            let space = Cluster::new(n);
            let mut a = random_cluster(n, &mut rng);
            if n == 7 {
                // One atom exactly at the centroid gives no direction to align.
                let centroid = centred(&a[..18]);
                a = centroid
                    .iter()
                    .flat_map(|atom| atom.data.0[0])
                    .chain([0.0; 3])
                    .collect();
            }
            for mirror in [false, true] {
                let distance = space.distance(&a, &disguised(&a, &[], mirror, &mut rng));
                // Exact copies up to the rounding of coordinates of size 3.
                assert!(distance < 1e-13, "{n} atoms: {distance}");
            }
        }
    }

    #[test]
    fn being_within_a_reach_agrees_with_the_distance() {
        let mut rng = stream(5, Task::Start, 0);
        for n in [1, 2, 5, 7, 13] {
            let space = Cluster::new(n);
            let a = random_cluster(n, &mut rng);
            let mut tangent = vec![0.0; 3 * n];
            for size in [0.0, 1e-6, 1e-3, 0.05, 1.0] {
                let mut b = disguised(&a, &[], true, &mut rng);
                for coordinate in &mut b {
                    *coordinate += size * rng.random_range(-1.0..1.0);
                }
                let distance = space.distance(&a, &b);
                for reach in [1.001 * distance + 1e-12, 0.999 * distance - 1e-12] {
                    assert_eq!(
                        space.within(&a, &b, reach),
                        distance <= reach,
                        "{n}: {size}"
                    );
                }
                // A quick alignment leads to a copy, too, and never to a nearer one.
                let quick = space.log_quickly(&a, &b, &mut tangent);
                assert!(quick >= distance - 1e-9);
                let mut there = a.clone();
                space.exp(&mut there, &tangent);
                assert!(space.distance(&there, &b) < 1e-6);
            }
            let other = random_cluster(n, &mut rng);
            assert_eq!(
                space.within(&a, &other, 0.1),
                space.distance(&a, &other) <= 0.1
            );
        }
    }

    #[test]
    fn near_clusters_get_the_exact_distance() {
        let mut rng = stream(2, Task::Start, 0);
        // The octahedron: 48 symmetries, so many near copies compete.
        let s = 0.8;
        let octahedron = [
            s, 0., 0., -s, 0., 0., 0., s, 0., 0., -s, 0., 0., 0., s, 0., 0., -s,
        ];
        let mut noisy = || octahedron.map(|k| k + rng.random_range(-0.15..0.15));
        let pairs: Vec<_> = (0..20).map(|_| (noisy(), noisy())).collect();
        for (a, b) in pairs {
            let exact = best_by_enumeration(&centred(&a), &centred(&b), &[], &mut Vec::new());
            let exact = exact.sqrt();
            let b = disguised(&b, &[], true, &mut rng);
            approx::assert_abs_diff_eq!(Cluster::new(6).distance(&a, &b), exact, epsilon = 1e-7);
        }
    }

    #[test]
    fn only_atoms_of_one_kind_change_places() {
        let mut rng = stream(6, Task::Start, 0);
        let kinds = [18, 36, 18, 36, 36, 54];
        let space = Cluster::of_kinds(&kinds);
        for _ in 0..20 {
            let a = random_cluster(6, &mut rng);
            let copy = disguised(&a, &kinds, true, &mut rng);
            assert!(space.distance(&a, &copy) < 1e-13 && space.within(&a, &copy, 1e-9));
            let near: Vec<f64> = a
                .iter()
                .map(|k| k + rng.random_range(-0.05..0.05))
                .collect();
            let exact = best_by_enumeration(&centred(&a), &centred(&near), &kinds, &mut Vec::new());
            let distance = space.distance(&a, &disguised(&near, &kinds, true, &mut rng));
            approx::assert_abs_diff_eq!(distance, exact.sqrt(), epsilon = 1e-7);
            // Two atoms of different kinds that change places make another cluster.
            let mut other = a.clone();
            for axis in 0..3 {
                other.swap(axis, 3 + axis);
            }
            let apart = space.distance(&a, &other);
            assert!(Cluster::new(6).distance(&a, &other) < 1e-13 && apart > 0.01);
            assert!(!space.within(&a, &other, 0.5 * apart));
            let marks = [&a, &other].map(|x| space.landmarks(x));
            let bound = marks[0].iter().zip(&marks[1]).map(|(a, b)| (a - b).powi(2));
            assert!(bound.sum::<f64>().sqrt() <= apart + 1e-12);
        }
    }

    #[test]
    fn zero_modes_are_orthonormal_and_free() {
        let mut rng = stream(3, Task::Start, 0);
        let x = random_cluster(5, &mut rng);
        let modes = Cluster::new(5).zero_modes(&x);
        assert_eq!(modes.len(), 6 * 15);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (i, one) in modes.chunks_exact(15).enumerate() {
            for (j, other) in modes.chunks_exact(15).enumerate() {
                approx::assert_abs_diff_eq!(
                    dot(one, other),
                    f64::from(u8::from(i == j)),
                    epsilon = 1e-14
                );
            }
            // To first order, no interatomic distance changes.
            for (p, q) in [(0, 1), (0, 4), (2, 3)] {
                let change: f64 = (0..3)
                    .map(|k| (x[3 * p + k] - x[3 * q + k]) * (one[3 * p + k] - one[3 * q + k]))
                    .sum();
                approx::assert_abs_diff_eq!(change, 0.0, epsilon = 1e-14);
            }
        }
        let line = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
        assert_eq!(Cluster::new(3).zero_modes(&line).len(), 5 * 9);
    }
}
