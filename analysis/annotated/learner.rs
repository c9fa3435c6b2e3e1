//! A plain learner on the facts that the rule sees: how much of people's labels they tell, habits of the annotators included.
//!
//! Multinomial logistic regression with a ridge. Each grasp is named by a model that has seen no grasp of the same object.

use std::collections::{BTreeMap, BTreeSet};

use landscape::evaluation::taxonomy::{Form, GraspType, Label, Taxonomy};
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::case::{Case, Measure};

/// Weight of the squares of the coefficients for each grasp, fixed before the first run.
const RIDGE: f64 = 0.01;
const STEPS: usize = 400;
const STEP: f64 = 1.0;

/// The probabilities of the types for each case, by number.
pub(crate) struct Learned(Vec<Vec<f64>>);

/// A number of each fact, of each form, of the width, and a constant.
pub(crate) fn features(labels: &[&Label]) -> DMatrix<f64> {
    let names: BTreeSet<&str> = labels
        .iter()
        .flat_map(|label| label.facts.iter().map(|(name, _)| *name))
        .filter(|name| !matches!(*name, "form" | "size"))
        .collect();
    let rows = labels.iter().map(|label| {
        let known: BTreeMap<&str, f64> = label.facts.iter().copied().collect();
        // What cannot be measured is in the middle.
        let facts = names
            .iter()
            .map(|name| known.get(name).copied().unwrap_or(0.5) - 0.5);
        let held = label.held.as_ref();
        let forms = Form::ALL.map(|form| held.map_or(0.0, |held| held.degree(form)));
        let width = held.map_or(0.0, |held| libm::log((held.width_m / 0.04).max(0.05)));
        facts.chain(forms).chain([width, 1.0]).collect::<Vec<f64>>()
    });
    let rows: Vec<Vec<f64>> = rows.collect();
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column])
}

/// Coefficients that make the types of the rows likely, by gradient descent with momentum. `before`: logarithms of weights that
/// the types have already.
pub(crate) fn fit(
    rows: &DMatrix<f64>,
    before: &DMatrix<f64>,
    types: &[usize],
    ridge: f64,
) -> DMatrix<f64> {
    let count = types.len() as f64;
    let mut coefficients = DMatrix::zeros(rows.ncols(), before.ncols());
    let mut speed = coefficients.clone();
    for _ in 0..STEPS {
        let mut slope = probabilities(rows, before, &coefficients);
        for (row, &own) in types.iter().enumerate() {
            slope[(row, own)] -= 1.0;
        }
        let gradient = rows.tr_mul(&slope) / count + &coefficients * ridge;
        speed = speed * 0.9 - gradient * (0.1 * STEP);
        coefficients += &speed;
    }
    coefficients
}

/// The probabilities of the types for each row.
pub(crate) fn probabilities(
    rows: &DMatrix<f64>,
    before: &DMatrix<f64>,
    coefficients: &DMatrix<f64>,
) -> DMatrix<f64> {
    let mut scores = before + rows * coefficients;
    for mut row in scores.row_iter_mut() {
        let most = row.max();
        row.apply(|score| *score = libm::exp(*score - most));
        let sum = row.sum();
        row /= sum;
    }
    scores
}

/// Names every case by a model of the cases of all other objects.
pub(crate) fn leave_one_object_out(cases: &[&Case]) -> Learned {
    let labels: Vec<&Label> = cases.iter().map(|case| &case.label).collect();
    let all = features(&labels);
    let equal = |count| DMatrix::zeros(count, Taxonomy::feix().types.len());
    let types: Vec<usize> = cases
        .iter()
        .map(|case| usize::from(case.truth.number) - 1)
        .collect();
    let objects: BTreeSet<&str> = cases.iter().map(|case| case.object.as_str()).collect();
    let of_object: Vec<(Vec<usize>, DMatrix<f64>)> = objects
        .into_par_iter()
        .map(|object| {
            let (own, others): (Vec<usize>, Vec<usize>) =
                (0..cases.len()).partition(|&i| cases[i].object == object);
            let seen: Vec<usize> = others.iter().map(|&case| types[case]).collect();
            let rows = all.select_rows(&others);
            let coefficients = fit(&rows, &equal(others.len()), &seen, RIDGE);
            let rows = all.select_rows(&own);
            let told = probabilities(&rows, &equal(own.len()), &coefficients);
            (own, told)
        })
        .collect();
    let mut learned = vec![Vec::new(); cases.len()];
    for (own, told) in of_object {
        for (row, case) in own.into_iter().enumerate() {
            learned[case] = told.row(row).iter().copied().collect();
        }
    }
    Learned(learned)
}

impl Learned {
    /// Whether the case with this number is named right in this respect: the class of the largest sum of probabilities.
    pub(crate) fn right(&self, case: usize, truth: &GraspType, measure: Measure) -> Option<bool> {
        let told = &self.0[case];
        let types = || Taxonomy::feix().types.iter().zip(told);
        if measure == Measure::TopThree {
            let own = told[usize::from(truth.number) - 1];
            return Some(told.iter().filter(|p| **p > own).count() < 3);
        }
        let mut sums: BTreeMap<String, f64> = BTreeMap::new();
        for (entry, p) in types() {
            *sums.entry(measure.class(entry)?).or_insert(0.0) += p;
        }
        let best = sums.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        Some(measure.class(truth)? == best)
    }
}
