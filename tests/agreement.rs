//! Statistics of agreement, tested on planted partitions, results of other programs, and random labels.
//!
//! The reference numbers were computed with scipy 1.17.1, scikit-learn 1.9.1, scikit-bio 0.7.4, networkx 3.6.1 and
//! statsmodels 0.15.0 from the points and labels below.

use landscape::agreement::{
    Correlation, Dendrogram, Outcome, PairMatrix, Permutations, adjusted_mutual_information,
    adjusted_rand, agreement_of_cuts, anosim_of_ranks, assortativity, barrier_ratio, bootstrap,
    cliffs_delta, holm, indicator, mantel, morans_i, partial_mantel, pearson, permanova, permdisp,
    silhouette, spearman, test_labels, test_order, test_uncertain_labels,
};

/// Coordinates of twelve points in the plane: x, then y.
type Points = [[f64; 12]; 2];
const P: Points = [
    [1., 2., 3., 4., 9., 8., 11., 10., 5., 3., 7., 6.],
    [2., 4., 1., 5., 1., 4., 2., 6., 11., 9., 12., 8.],
];
const Q: Points = [
    [2., 1., 4., 3., 8., 10., 12., 7., 4., 5., 8., 2.],
    [1., 5., 2., 3., 2., 3., 5., 7., 9., 12., 10., 11.],
];
const Z: [f64; 12] = [3., 1., 4., 1., 5., 9., 2., 6., 5., 3., 5., 8.];
const LABELS: [usize; 12] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 1];
const OTHER: [usize; 12] = [0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 0, 0];
const ONE_BLOCK: [usize; 12] = [0; 12];

fn anosim(distances: &PairMatrix, labels: &[usize]) -> f64 {
    anosim_of_ranks(&distances.ranks(), labels)
}

fn distances(points: &Points) -> PairMatrix {
    PairMatrix::from_fn(12, |i, j| {
        // Whole numbers below the root, so that ties are exact.
        let square = |axis: &[f64; 12]| (axis[i] - axis[j]).powi(2);
        points.iter().map(square).sum::<f64>().sqrt()
    })
}

/// Distances without ties, so that a tree with two children per merge is unique.
fn untied(points: &Points, [a, b, m]: [usize; 3]) -> PairMatrix {
    let plain = distances(points);
    PairMatrix::from_fn(12, |i, j| {
        plain.get(i, j) + 1e-3 * ((a * i + b * j) % m) as f64
    })
}

fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
}

fn few(count: usize) -> Permutations {
    Permutations {
        count,
        seed: 3,
        least_per_class: 2,
    }
}

#[test]
fn numbers_of_other_programs() {
    let near = distances(&P);
    assert_close(anosim(&near, &LABELS), 0.7917133258678611);
    assert_close(permanova(&near, &LABELS), 12.190655447298496);
    assert_close(permdisp(&near, &LABELS), 1.0061801497105463);
    assert_close(adjusted_rand(&LABELS, &OTHER), -0.013651877133105802);
    assert_close(
        adjusted_mutual_information(&LABELS, &OTHER),
        0.041849191539734015,
    );
    let silhouettes = silhouette(&near, &LABELS);
    assert_close(silhouettes[11], -0.4283936747260438);
    assert_close(silhouettes.iter().sum::<f64>() / 12.0, 0.42259141656436777);
    let ratio = barrier_ratio(&near, &LABELS, [0, 1]);
    assert_close(ratio.ratio, 1.970788250361601);
    assert_close(ratio.delta, 0.784375);
    for (found, expected) in holm(&[0.01, 0.04, f64::NAN, 0.03, 0.005, 0.5]).iter().zip([
        0.04,
        0.09,
        f64::NAN,
        0.09,
        0.025,
        0.5,
    ]) {
        assert!((found - expected).abs() < 1e-15 || found.is_nan() && expected.is_nan());
    }
    let weights = PairMatrix::from_fn(12, |i, j| libm::exp(-near.get(i, j) / 3.0));
    for (class, expected) in [0.37180361354000924, 0.2709226768323262, 0.261649504021061]
        .iter()
        .enumerate()
    {
        assert_close(morans_i(&weights, &indicator(&LABELS, class)), *expected);
    }
    let graph = PairMatrix::from_fn(12, |i, j| f64::from(u8::from(near.get(i, j) < 5.0)));
    assert_close(assortativity(&graph, &LABELS).0, 0.547576301615799);
    let weighted = PairMatrix::from_fn(12, |i, j| ((3 * j + 5 * i) % 4) as f64);
    let (all, terms) = assortativity(&weighted, &LABELS);
    assert_close(all, 0.03458009880028229);
    assert_close(terms.iter().sum(), all);
}

#[test]
fn matrices_and_trees_of_other_programs() {
    let (near, other) = (distances(&P), distances(&Q));
    let gaps = PairMatrix::from_fn(12, |i, j| (Z[i] - Z[j]).abs());
    let test = |correlation| mantel(&near, &other, correlation, &ONE_BLOCK, &few(4999));
    let tested = test(Correlation::Pearson);
    assert_close(tested.statistic, 0.633047659667793);
    // 0.0001 in 99 999 permutations.
    assert!(tested.p < 0.002, "{tested:?}");
    assert_close(test(Correlation::Spearman).statistic, 0.6332847994612321);
    let partial = partial_mantel(
        &near,
        &other,
        &gaps,
        Correlation::Pearson,
        &ONE_BLOCK,
        &few(999),
    );
    assert_close(partial.statistic, 0.6467341840207905);
    let p = test_labels(&LABELS, &ONE_BLOCK, &few(4999), |labels| {
        anosim(&near, labels)
    });
    // 0.0003 in 99 999 permutations.
    assert!(p.known().unwrap().p < 2e-3);

    let (first, second) = (untied(&Q, [7, 3, 11]), untied(&P, [5, 2, 13]));
    let (tree, elm) = (Dendrogram::new(&first), Dendrogram::new(&second));
    assert_close(tree.purity(&LABELS, &[1.0; 12]), 0.7245614035087717);
    assert_close(
        pearson(tree.joined().values(), elm.joined().values()),
        0.6099788592253239,
    );
    assert_close(
        spearman(tree.joined().values(), elm.joined().values()),
        0.3923187491810181,
    );
    // With ties, which are one merge of many here and any order of two elsewhere: the heights are the same.
    let (tree, elm) = (Dendrogram::new(&near), Dendrogram::new(&other));
    assert_close(
        pearson(tree.joined().values(), elm.joined().values()),
        0.6097691204199049,
    );
    let cuts = [
        (2, 0.2535344015080113, 0.37723586217761784),
        (3, 0.5565509518477044, 0.6681259989009753),
        (4, 0.5105067985166872, 0.5195740296581384),
        (5, 0.49295774647887325, 0.4668460013935241),
    ];
    let tree = Dendrogram::new(&first);
    let rand = agreement_of_cuts(&tree, &LABELS, [2, 5], adjusted_rand);
    let information = agreement_of_cuts(&tree, &LABELS, [2, 5], adjusted_mutual_information);
    for (place, (clusters, by_pairs, by_bits)) in cuts.into_iter().enumerate() {
        assert_eq!(rand[place].0, clusters);
        assert_close(rand[place].1, by_pairs);
        assert!((information[place].1 - by_bits).abs() < 1e-10);
    }
}

/// Three classes of six: distances are 1 within a class and 3 between classes.
fn planted() -> (PairMatrix, Vec<usize>) {
    let labels: Vec<usize> = (0..18).map(|i| i / 6).collect();
    let matrix = PairMatrix::from_fn(18, |i, j| if i / 6 == j / 6 { 1.0 } else { 3.0 });
    (matrix, labels)
}

#[test]
fn small_classes_are_insufficient() {
    let settings = Permutations::default();
    let asked = |labels: &[usize]| {
        test_labels(labels, &vec![0; labels.len()], &settings, |_| {
            panic!("not to be asked")
        })
    };
    let labels = [0, 0, 0, 0, 0, 0, 2, 2, 2, 2];
    let expected = Outcome::Insufficient {
        class: 2,
        cases: 4,
        needed: 5,
    };
    assert_eq!(asked(&labels), expected);
    assert_eq!(asked(&[0; 9]).known(), None);
    assert_eq!(asked(&[]).known(), None);
}

#[test]
fn censored_pairs_raised_and_left_out() {
    let (near, labels) = planted();
    let holes = PairMatrix::from_fn(18, |i, j| {
        if i / 6 == j / 6 || (i + j) % 2 == 0 {
            near.get(i, j)
        } else {
            f64::NAN
        }
    });
    let raised = holes.raised(1.1);
    assert_eq!(raised.unknown(), 0);
    for matrix in [&holes, &raised] {
        assert_close(anosim(matrix, &labels), 1.0);
        assert_close(barrier_ratio(matrix, &labels, [0, 1]).delta, 1.0);
        assert_close(Dendrogram::new(matrix).purity(&labels, &[1.0; 18]), 1.0);
        let other = mantel(matrix, &near, Correlation::Spearman, &[0; 18], &few(99));
        assert!(other.statistic > 0.7 && other.p < 0.02, "{other:?}");
    }
    assert!(permanova(&holes, &labels).is_nan());
}

#[test]
fn the_same_seed_gives_the_same_and_names_do_not_matter() {
    let near = distances(&P);
    let test = |labels: &[usize]| {
        test_labels(labels, &ONE_BLOCK, &few(199), |labels| {
            permanova(&near, labels)
        })
        .known()
        .unwrap()
    };
    let renamed: Vec<usize> = LABELS.iter().map(|label| [4, 0, 2][*label]).collect();
    assert_eq!(test(&LABELS), test(&LABELS));
    assert_eq!(test(&LABELS).p.to_bits(), test(&renamed).p.to_bits());
    // A statistic of the order alone.
    let last = test_order(12, &ONE_BLOCK, &few(999), |order| order[11] as f64);
    assert!((last.p - 1.0 / 12.0).abs() < 0.03, "{last:?}");
    let doubled = PairMatrix::from_fn(12, |i, j| 2.0 * near.get(i, j));
    assert_close(anosim(&near, &LABELS), anosim(&doubled, &LABELS));
    assert_close(spearman(near.values(), doubled.values()), 1.0);
    assert_close(cliffs_delta(&[1.0, 2.0], &[2.0, 0.0]), 0.25);
}

#[test]
fn intervals_and_uncertain_labels() {
    let (near, labels) = planted();
    let mean = bootstrap(&[0; 18], 500, 1, |cases| {
        cases.iter().sum::<usize>() as f64 / 18.0
    });
    let [low, high] = mean.interval(0.95);
    // Standard error of the mean of 0 … 17: √((18² − 1)/12/18) = 1.22.
    assert!(
        (low - (8.5 - 1.96 * 1.22)).abs() < 0.4 && (high - (8.5 + 1.96 * 1.22)).abs() < 0.4,
        "{low} {high}"
    );
    let delta = bootstrap(&labels, 100, 1, |cases| {
        let own: Vec<usize> = cases.iter().map(|&i| labels[i]).collect();
        barrier_ratio(&near.chosen(cases, f64::NAN), &own, [0, 1]).delta
    });
    assert_eq!(delta.undefined, 0);
    assert_close(delta.quantile(0.0), 1.0);

    let belief = |sure: f64| -> Vec<Vec<f64>> {
        let of = |label: usize| {
            (0..3)
                .map(|k| if k == label { sure } else { 0.5 * (1.0 - sure) })
                .collect()
        };
        labels.iter().map(|&label| of(label)).collect()
    };
    let test = |sure: f64| {
        test_uncertain_labels(&belief(sure), &[0; 18], 20, &few(99), |labels| {
            anosim(&near, labels)
        })
    };
    let certain = test(1.0);
    assert_eq!(
        (certain.insufficient, certain.statistic.values.len()),
        (0, 20)
    );
    assert_close(certain.statistic.quantile(0.0), 1.0);
    assert_close(certain.p.quantile(1.0), 0.01);
    let doubtful = test(0.7);
    let middle = doubtful.statistic.quantile(0.5);
    assert!(middle > 0.1 && middle < 0.9, "{middle}");
    let ignorant = test(1.0 / 3.0);
    assert!(ignorant.statistic.quantile(0.5).abs() < 0.2 && ignorant.p.quantile(0.5) > 0.1);
}
