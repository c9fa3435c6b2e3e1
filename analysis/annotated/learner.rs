//! A plain learner on the facts that the rule sees: how much of people's labels they tell, habits of the annotators included.
//!
//! Multinomial logistic regression with a ridge. Each grasp is named by a model that has seen no grasp of the same object.

use std::collections::{BTreeMap, BTreeSet};

use landscape::evaluation::taxonomy::{Form, GraspType, Taxonomy};
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
fn features(cases: &[&Case]) -> DMatrix<f64> {
    let names: BTreeSet<&str> = cases
        .iter()
        .flat_map(|case| case.label.facts.iter().map(|(name, _)| *name))
        .filter(|name| !matches!(*name, "form" | "size"))
        .collect();
    let rows = cases.iter().map(|case| {
        let known: BTreeMap<&str, f64> = case.label.facts.iter().copied().collect();
        // What cannot be measured is in the middle.
        let facts = names
            .iter()
            .map(|name| known.get(name).copied().unwrap_or(0.5) - 0.5);
        let held = case.label.held.as_ref();
        let forms = Form::ALL.map(|form| held.map_or(0.0, |held| held.degree(form)));
        let width = held.map_or(0.0, |held| libm::log((held.width_m / 0.04).max(0.05)));
        facts.chain(forms).chain([width, 1.0]).collect::<Vec<f64>>()
    });
    let rows: Vec<Vec<f64>> = rows.collect();
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column])
}

/// Coefficients that make the types of `chosen` rows likely, by gradient descent with momentum.
fn fit(all: &DMatrix<f64>, types: &[usize], chosen: &[usize]) -> DMatrix<f64> {
    let rows = all.select_rows(chosen);
    let count = chosen.len() as f64;
    let classes = Taxonomy::feix().types.len();
    let mut coefficients = DMatrix::zeros(all.ncols(), classes);
    let mut speed = coefficients.clone();
    for _ in 0..STEPS {
        let mut slope = probabilities(&rows, &coefficients);
        for (row, &case) in chosen.iter().enumerate() {
            slope[(row, types[case])] -= 1.0;
        }
        let gradient = rows.tr_mul(&slope) / count + &coefficients * RIDGE;
        speed = speed * 0.9 - gradient * (0.1 * STEP);
        coefficients += &speed;
    }
    coefficients
}

fn probabilities(rows: &DMatrix<f64>, coefficients: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scores = rows * coefficients;
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
    let all = features(cases);
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
            let coefficients = fit(&all, &types, &others);
            let told = probabilities(&all.select_rows(&own), &coefficients);
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
