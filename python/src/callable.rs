//! Python functions as energies.
//!
//! A search asks from a thread of its own, which attaches to the interpreter for each call. After the first error every point
//! counts as outside the domain, so that the search leaves soon, and the error is kept for the caller.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use landscape::energy::{Energy, hessian_from_gradients};
use landscape::space::Space;
use landscape::topography::JournalError;
use numpy::{PyArray1, PyArray2, PyArrayDyn, PyArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;

use crate::error::Failure;
use crate::work::ending;

/// Points for which a function that takes many is asked at once.
const BATCH: usize = 1024;
/// Largest difference between mirrored elements of a Hessian, as a share of its largest element.
const ASYMMETRY: f64 = 1e-6;
/// Largest difference between a Hessian and differences of the gradient, as a share of its largest element.
const HESSIAN_ERROR: f64 = 1e-2;
/// Rounding error of a second derivative, as a share of the greatest energy that was seen, on a side of length 1.
const ROUNDING: f64 = 1e-9;

/// A function of the caller, and what became of it.
pub(crate) struct Asked {
    function: Py<PyAny>,
    hessian: Option<Py<PyAny>>,
    /// Whether it takes many points at once.
    batch: bool,
    coordinates: usize,
    tangents: usize,
    stopped: AtomicBool,
    failure: Mutex<Option<Failure>>,
}

impl fmt::Debug for Asked {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = formatter.debug_struct("Asked");
        shown.field("batch", &self.batch).finish_non_exhaustive()
    }
}

impl Asked {
    pub(crate) fn new(
        function: Py<PyAny>,
        hessian: Option<Py<PyAny>>,
        batch: bool,
        space: &dyn Space,
    ) -> Self {
        Self {
            function,
            hessian,
            batch,
            coordinates: space.coordinates(),
            tangents: space.tangents(),
            stopped: AtomicBool::new(false),
            failure: Mutex::new(None),
        }
    }

    /// Lets the search end soon.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn fail(&self, failure: Failure) {
        let mut first = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(failure);
        self.stop();
    }

    /// The first error, once; an interruption if there is none and the search was stopped.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let mut first = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        match first.take() {
            Some(failure) => Err(failure),
            None if self.stopped.load(Ordering::Relaxed) => Err(Failure::Interrupted),
            None => Ok(()),
        }
    }

    /// An error for a journal, which ends the search, once there is an error.
    pub(crate) fn check_journal(&self) -> Result<(), JournalError> {
        if self.stopped.load(Ordering::Relaxed) {
            let told: Box<dyn std::error::Error + Send + Sync> = "the energy has failed".into();
            return Err(told.into());
        }
        Ok(())
    }

    /// What `ask` returns with the interpreter, or `otherwise` after an error.
    fn asked<T>(&self, otherwise: T, ask: impl FnOnce(Python<'_>) -> Result<T, Failure>) -> T {
        if self.stopped.load(Ordering::Relaxed) || ending() {
            self.stop();
            return otherwise;
        }
        match Python::try_attach(ask) {
            Some(Ok(answer)) => answer,
            Some(Err(failure)) => {
                self.fail(failure);
                otherwise
            }
            // The interpreter is ending.
            None => {
                self.stop();
                otherwise
            }
        }
    }

    /// Energy and gradient at x.
    pub(crate) fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.asked(f64::INFINITY, |py| {
            if self.batch {
                let mut energies = [0.0];
                self.ask_batch(py, &[x.to_vec()], &mut energies, gradient)?;
                Ok(energies[0])
            } else {
                self.ask(py, x, gradient)
            }
        })
    }

    /// Energies and gradients at many points, together if the function takes many.
    pub(crate) fn evaluate_all(
        &self,
        points: &[Vec<f64>],
        energies: &mut [f64],
        gradients: &mut [f64],
    ) {
        let size = if self.batch { BATCH } else { 1 };
        let parts = (energies.par_chunks_mut(size))
            .zip(gradients.par_chunks_mut(size * self.tangents.max(1)));
        parts
            .zip(points.par_chunks(size))
            .for_each(|((energies, gradients), points)| {
                if self.batch {
                    let done = self.asked(false, |py| {
                        self.ask_batch(py, points, energies, gradients)
                            .map(|()| true)
                    });
                    if !done {
                        energies.fill(f64::INFINITY);
                    }
                } else {
                    energies[0] = self.evaluate(&points[0], gradients);
                }
            });
    }

    /// The two values that the function returns for `given`. A failure names the point `x`.
    fn two<'py>(
        &self,
        given: &Bound<'py, PyAny>,
        x: &[f64],
        expected: &str,
    ) -> Result<Bound<'py, PyTuple>, Failure> {
        let answer = (self.function.bind(given.py()).call1((given,))).map_err(Failure::Raised)?;
        match answer.cast::<PyTuple>() {
            Ok(pair) if pair.len() == 2 => Ok(pair.clone()),
            _ => Err(wrong(
                x,
                format!(
                    "the function must return two {expected}, but returned {}",
                    kind(&answer)
                ),
            )),
        }
    }

    fn ask(&self, py: Python<'_>, x: &[f64], gradient: &mut [f64]) -> Result<f64, Failure> {
        let given = PyArray1::from_slice(py, x);
        let pair = self.two(given.as_any(), x, "values, energy and gradient")?;
        let told = pair.get_borrowed_item(0).map_err(Failure::Raised)?;
        let Ok(energy) = told.extract::<f64>() else {
            return Err(wrong(
                x,
                format!("the energy must be a number, but is {}", kind(&told)),
            ));
        };
        let told = pair.get_borrowed_item(1).map_err(Failure::Raised)?;
        Self::copy(py, x, &told, gradient)?;
        checked(x, energy, gradient)
    }

    /// Copies a gradient that a function returned.
    fn copy(
        py: Python<'_>,
        x: &[f64],
        told: &Bound<'_, PyAny>,
        gradient: &mut [f64],
    ) -> Result<(), Failure> {
        if let Ok(array) = told.cast::<PyArray1<f64>>()
            && copied(array.to_owned(), gradient)
        {
            return Ok(());
        }
        let Ok(array) = numbers(py, told) else {
            return Err(wrong(
                x,
                format!(
                    "the gradient must be an array of numbers, but is {}",
                    kind(told)
                ),
            ));
        };
        let count = array.len().unwrap_or(0);
        if count != gradient.len() {
            return Err(wrong(
                x,
                format!(
                    "the gradient must have {} numbers, but has {count}",
                    gradient.len()
                ),
            ));
        }
        let array = array.cast::<PyArray1<f64>>();
        match array {
            Ok(array) if copied(array.clone(), gradient) => Ok(()),
            _ => Err(wrong(x, "the gradient cannot be read".to_owned())),
        }
    }

    /// Energies and gradients at many points at once.
    fn ask_batch(
        &self,
        py: Python<'_>,
        points: &[Vec<f64>],
        energies: &mut [f64],
        gradients: &mut [f64],
    ) -> Result<(), Failure> {
        let first = &points[0];
        let given =
            PyArray2::from_vec2(py, points).map_err(|error| wrong(first, error.to_string()))?;
        let pair = self.two(given.as_any(), first, "arrays, energies and gradients")?;
        for (place, name, target) in [
            (0, "energies", &mut *energies),
            (1, "gradients", &mut *gradients),
        ] {
            let told = pair.get_item(place).map_err(Failure::Raised)?;
            let shape = if place == 0 {
                vec![points.len()]
            } else {
                vec![points.len(), self.tangents]
            };
            if !table_copied(py, &told, &shape, target) {
                return Err(wrong(
                    first,
                    format!(
                        "the {name} of {} points must be an array of the shape {}, but are {}",
                        points.len(),
                        shown(&shape),
                        kind(&told)
                    ),
                ));
            }
        }
        for ((x, energy), gradient) in points
            .iter()
            .zip(energies.iter_mut())
            .zip(gradients.chunks(self.tangents))
        {
            *energy = checked(x, *energy, gradient)?;
        }
        Ok(())
    }

    /// The second derivatives that the caller's function returns.
    fn ask_hessian(
        &self,
        py: Python<'_>,
        function: &Py<PyAny>,
        x: &[f64],
        hessian: &mut [f64],
    ) -> Result<bool, Failure> {
        let given = PyArray1::from_slice(py, x);
        let answer = function.bind(py).call1((given,)).map_err(Failure::Raised)?;
        let n = self.tangents;
        if !table_copied(py, &answer, &[n, n], hessian) {
            return Err(wrong(
                x,
                format!(
                    "the Hessian must be an array of the shape ({n}, {n}), but is {}",
                    kind(&answer)
                ),
            ));
        }
        let largest = hessian.iter().fold(0.0, |most: f64, h| most.max(h.abs()));
        for (row, column) in (0..n).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            let pair = [hessian[row * n + column], hessian[column * n + row]];
            if pair.iter().any(|h| !h.is_finite())
                || (pair[0] - pair[1]).abs() > ASYMMETRY * largest
            {
                return Err(wrong(
                    x,
                    format!(
                        "the Hessian must be finite and symmetric, but its elements ({row}, {column}) and ({column}, {row}) are \
                         {} and {}",
                        pair[0], pair[1]
                    ),
                ));
            }
        }
        Ok(true)
    }

    /// Compares the caller's second derivatives at `points` with differences of the gradients of `energy`, in a region whose
    /// shortest side is `side`.
    pub(crate) fn check_hessian(
        &self,
        energy: &dyn Energy,
        points: &[Vec<f64>],
        (step, side): (f64, f64),
    ) -> Result<(), Failure> {
        let Some(function) = &self.hessian else {
            return Ok(());
        };
        let n = self.tangents;
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        // What is smaller than this is rounding of the energy, as on a plateau.
        let mut slopes = vec![0.0; n];
        let height = points.iter().fold(0.0, |most: f64, x| {
            most.max(energy.evaluate(x, &mut slopes).abs())
        });
        let rounding = ROUNDING * height / (side * side);
        for x in points {
            let mut given = vec![0.0; n * n];
            if !self.asked(false, |py| self.ask_hessian(py, function, x, &mut given)) {
                return self.check();
            }
            let slopes = |points: &[Vec<f64>]| {
                let mut slopes = vec![0.0; points.len() * n];
                (points.iter().zip(slopes.chunks_mut(n)))
                    .all(|(x, slope)| energy.evaluate(x, slope).is_finite())
                    .then_some(slopes)
            };
            let mut measured = vec![0.0; n * n];
            if !hessian_from_gradients(energy.space(), x, step, slopes, &mut measured) {
                continue;
            }
            // Where rotations do not commute, slopes along one after the other differ by half a slope.
            for (row, column) in (0..n).flat_map(|row| (0..row).map(move |column| (row, column))) {
                let mean = f64::midpoint(measured[row * n + column], measured[column * n + row]);
                measured[row * n + column] = mean;
                measured[column * n + row] = mean;
            }
            let largest = largest(&measured).max(largest(&given));
            let allowed = (HESSIAN_ERROR * largest).max(rounding);
            let differs = |(a, b): (&f64, &f64)| (a - b).abs() > allowed;
            if let Some(place) = given.iter().zip(&measured).position(differs) {
                return Err(wrong(
                    x,
                    format!(
                        "element ({}, {}) of the Hessian is {}, but differences of the gradient give {}",
                        place / n,
                        place % n,
                        given[place],
                        measured[place]
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// Copies an array of the given shape that a function returned.
fn table_copied(
    py: Python<'_>,
    told: &Bound<'_, PyAny>,
    shape: &[usize],
    target: &mut [f64],
) -> bool {
    let same = told
        .getattr("shape")
        .and_then(|told| told.extract::<Vec<usize>>());
    // Lists and the like have no shape; their numbers are counted below.
    if same.is_ok_and(|told| told != shape) {
        return false;
    }
    let array = numbers(py, told).ok();
    (array.as_ref())
        .and_then(|array| array.cast::<PyArray1<f64>>().ok())
        .is_some_and(|array| copied(array.clone(), target))
}

/// A shape as Python writes it.
fn shown(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        sides => format!("{sides:?}").replace('[', "(").replace(']', ")"),
    }
}

/// All numbers of what a function returned, as one flat array.
fn numbers<'py>(py: Python<'py>, told: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import(intern!(py, "numpy"))?;
    let float = numpy.getattr(intern!(py, "float64"))?;
    let array = numpy.call_method1(intern!(py, "ascontiguousarray"), (told, float))?;
    let array = array.cast_into::<PyArrayDyn<f64>>()?;
    array.call_method1(intern!(py, "reshape"), (-1,))
}

/// Copies an array of the right length.
fn copied(array: Bound<'_, PyArray1<f64>>, target: &mut [f64]) -> bool {
    let Ok(array) = array.try_readonly() else {
        return false;
    };
    if let Ok(values) = array.as_slice() {
        if values.len() == target.len() {
            target.copy_from_slice(values);
            return true;
        }
        return false;
    }
    let values = array.as_array();
    if values.len() != target.len() {
        return false;
    }
    for (value, told) in target.iter_mut().zip(values.iter()) {
        *value = *told;
    }
    true
}

/// The energy, if both are what they should be.
fn checked(x: &[f64], energy: f64, gradient: &[f64]) -> Result<f64, Failure> {
    if energy == f64::INFINITY {
        return Ok(energy);
    }
    if !energy.is_finite() {
        return Err(wrong(
            x,
            format!("the energy is {energy}, but must be a number, or +inf outside the domain"),
        ));
    }
    match gradient.iter().position(|slope| !slope.is_finite()) {
        Some(component) => Err(wrong(
            x,
            format!(
                "component {component} of the gradient is {}, although the energy is {energy}",
                gradient[component]
            ),
        )),
        None => Ok(energy),
    }
}

/// The largest number of coordinates that a sentence quotes.
const QUOTED: usize = 12;

fn wrong(x: &[f64], problem: String) -> Failure {
    let quoted = if x.len() <= QUOTED {
        format!("{x:?}")
    } else {
        let first = format!("{:?}", &x[..QUOTED]);
        format!("{}, … ({} numbers)]", first.trim_end_matches(']'), x.len())
    };
    Failure::Energy {
        told: format!("{problem} (at x = {quoted})"),
        x: x.to_vec(),
    }
}

/// What a value is, in words.
fn kind(value: &Bound<'_, PyAny>) -> String {
    let name = (value.get_type().name()).map_or_else(|_| "?".to_owned(), |name| name.to_string());
    match value.getattr("shape").and_then(|shape| shape.repr()) {
        Ok(shape) => format!("{name} of the shape {shape}"),
        Err(_) => name,
    }
}

/// A function of the caller on a space.
pub(crate) struct Function<'a> {
    pub(crate) asked: &'a Asked,
    pub(crate) space: &'a (dyn Space + Send),
    /// Step of the differences of a Hessian from a batch of gradients.
    pub(crate) difference: f64,
}

impl Energy for Function<'_> {
    fn space(&self) -> &dyn Space {
        self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        assert_eq!(
            (x.len(), gradient.len()),
            (self.asked.coordinates, self.asked.tangents)
        );
        self.asked.evaluate(x, gradient)
    }

    /// That of the caller, or central differences of the gradients in one call of a function that takes many points.
    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        if let Some(function) = &self.asked.hessian {
            return self
                .asked
                .asked(false, |py| self.asked.ask_hessian(py, function, x, hessian));
        }
        if !self.asked.batch {
            return false;
        }
        let gradients = |points: &[Vec<f64>]| {
            let mut energies = vec![0.0; points.len()];
            let mut gradients = vec![0.0; points.len() * self.asked.tangents];
            let known = self.asked.asked(false, |py| {
                self.asked
                    .ask_batch(py, points, &mut energies, &mut gradients)?;
                Ok(energies.iter().all(|energy| energy.is_finite()))
            });
            known.then_some(gradients)
        };
        hessian_from_gradients(self.space, x, self.difference, gradients, hessian)
    }
}

impl Function<'_> {
    /// This function as the library sees it.
    pub(crate) fn energy(&self) -> &dyn Energy {
        self
    }
}
