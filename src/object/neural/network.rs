//! A decoder for one latent code, evaluated at many points at once.

use nalgebra::{DMatrix, DMatrixView, DVector, Dyn, Matrix3, RealField, Vector3, convert};
use rayon::prelude::*;

use super::decoder::Linear;
use super::{Decoder, NeuralError};

/// Number type of the weights and activations: `f32`, as in training, or `f64`.
pub trait Real: RealField + Copy {}
impl Real for f32 {}
impl Real for f64 {}

/// A [`Decoder`] for one latent code: a function of three coordinates.
///
/// The contribution of the code is part of the biases, so the columns of weights for the code cost nothing. Points are
/// evaluated in batches by matrix products. Up to 16 points, weights of inactive rectifiers are skipped instead; the two
/// ways differ by rounding. The results for a list of points do not depend on the number of threads. They depend on the
/// processor, because products use its widest vectors.
///
/// A network of rectifiers is piecewise linear: its gradient jumps between pieces, and the only curvature within a piece is
/// that of the final tanh, H = tanh″(z) ∇z ∇zᵀ.
#[derive(Debug, Clone, PartialEq)]
pub struct Network<T: Real> {
    layers: Vec<Layer<T>>,
    /// The output layer: one row of weights for hidden values and coordinates, and the bias.
    last: Layer<T>,
    squashing: Squashing,
}

/// One layer: W h + X x + b.
#[derive(Debug, Clone, PartialEq)]
struct Layer<T: Real> {
    /// W; no columns in the first layer.
    hidden: DMatrix<T>,
    /// X, if the coordinates join the input of the layer.
    coordinates: Option<DMatrix<T>>,
    /// b, including the contribution of the code.
    bias: DVector<T>,
}

/// Number of hyperbolic tangents on the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Squashing(u32);

/// Value, gradient and Hessian at a point.
pub type Answer = (f64, Vector3<f64>, Matrix3<f64>);

/// Number of points in a batch. It is large enough that packing the weights for a product costs little, and small enough
/// that the points of a hand occupy several threads.
const BATCH: usize = 256;
/// Up to this number of points, the weights are read once in place, without those of inactive rectifiers. Packing them for
/// a product would cost more than the product.
const FEW: usize = 16;

impl<T: Real> Network<T> {
    /// The function of the shape with latent code `code`.
    ///
    /// # Errors
    /// If the code has another length than in the specs.
    ///
    /// # Panics
    /// Never: specs without layers are refused.
    pub fn new(decoder: &Decoder, code: &[f64]) -> Result<Self, NeuralError> {
        let specs = &decoder.specs;
        if code.len() != specs.code_length {
            return Err(NeuralError::CodeLength {
                found: code.len(),
                expected: specs.code_length,
            });
        }
        let code = DVector::from_column_slice(code);
        let fold = |(index, linear): (usize, &Linear)| {
            if index == 0 || specs.network.latent_in.contains(&index) {
                Layer::joined(linear, Some(&code))
            } else if specs.network.xyz_in_all {
                Layer::joined(linear, None)
            } else {
                Layer::plain(linear)
            }
        };
        let mut layers: Vec<Layer<T>> = decoder.layers.iter().enumerate().map(fold).collect();
        let last = layers.pop().expect("specs without layers are refused");
        let network = &specs.network;
        Ok(Self {
            layers,
            last,
            squashing: Squashing(u32::from(network.use_tanh) + u32::from(network.final_tanh)),
        })
    }

    /// f at each of `points`.
    pub fn values(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        batches(points, |batch| {
            let hidden = self.forward(batch);
            (0..batch.len())
                .map(|point| self.squashing.of(self.output(&hidden, batch, point))[0])
                .collect()
        })
    }

    /// f, its gradient and its Hessian at each of `points`. They cost twice as much as the values.
    pub fn answers(&self, points: &[Vector3<f64>]) -> Vec<Answer> {
        batches(points, |batch| {
            let hidden = self.forward(batch);
            let slopes = self.backward(&hidden, batch.len());
            let answer = |(point, slope): (usize, &Vector3<f64>)| {
                let [value, first, second] = self.squashing.of(self.output(&hidden, batch, point));
                (value, slope * first, slope * slope.transpose() * second)
            };
            slopes.iter().enumerate().map(answer).collect()
        })
    }

    /// Number of floating-point operations in the matrix products for a value. A gradient needs as many again.
    pub fn operations(&self) -> usize {
        let all = self.layers.iter().chain([&self.last]);
        all.map(|layer| 2 * layer.hidden.len()).sum()
    }

    /// Hidden values of each layer, one column per point.
    fn forward(&self, points: &[Vector3<f64>]) -> Vec<DMatrix<T>> {
        let mut all: Vec<DMatrix<T>> = Vec::with_capacity(self.layers.len());
        for layer in &self.layers {
            let mut next = layer.offsets(points);
            if let Some(before) = all.last() {
                layer.add_hidden(before, &mut next);
            }
            let zero = T::zero();
            next.apply(|value| *value = if *value > zero { *value } else { zero });
            all.push(next);
        }
        all
    }

    /// z at a point: the argument of the final tanh.
    fn output(&self, hidden: &[DMatrix<T>], points: &[Vector3<f64>], point: usize) -> f64 {
        let mut z = self.last.bias[0];
        if let Some(coordinates) = &self.last.coordinates {
            let place: Vector3<T> = points[point].map(convert);
            z += coordinates.row(0).transpose().dot(&place);
        }
        if let Some(hidden) = hidden.last() {
            z += dot(self.last.hidden.as_slice(), hidden.column(point).as_slice());
        }
        wide(z)
    }

    /// ∇z at each point, from the hidden values there.
    fn backward(&self, hidden: &[DMatrix<T>], points: usize) -> Vec<Vector3<f64>> {
        let mut slopes = vec![Vector3::zeros(); points];
        self.last
            .add_coordinates(&DMatrix::repeat(1, points, T::one()), &mut slopes);
        let mut by_output: Option<DMatrix<T>> = None;
        for (index, (layer, values)) in self.layers.iter().zip(hidden).enumerate().rev() {
            let mut by_value = match by_output {
                None => DMatrix::from_fn(values.nrows(), values.ncols(), |row, _| {
                    self.last.hidden[(0, row)]
                }),
                Some(by_output) => self.layers[index + 1].pull_back(&by_output, values),
            };
            // The derivative of the rectifier; at its corner it is zero.
            by_value.zip_apply(values, |slope, value| {
                if value <= T::zero() {
                    *slope = T::zero();
                }
            });
            layer.add_coordinates(&by_value, &mut slopes);
            by_output = Some(by_value);
        }
        slopes
    }
}

impl<T: Real> Layer<T> {
    fn plain(linear: &Linear) -> Self {
        Self {
            hidden: linear.weight.map(convert),
            coordinates: None,
            bias: linear.bias.map(convert),
        }
    }

    /// Splits a layer. The last columns of its weights belong to the coordinates and those before them to the code.
    fn joined(linear: &Linear, code: Option<&DVector<f64>>) -> Self {
        let columns = linear.weight.ncols();
        let length = code.map_or(0, DVector::len);
        let hidden = columns - 3 - length;
        let mut bias = linear.bias.clone();
        if let Some(code) = code {
            bias += linear.weight.columns(hidden, length) * code;
        }
        Self {
            hidden: linear.weight.columns(0, hidden).map(convert),
            coordinates: Some(linear.weight.columns(columns - 3, 3).map(convert)),
            bias: bias.map(convert),
        }
    }

    /// X x + b, one column per point.
    fn offsets(&self, points: &[Vector3<f64>]) -> DMatrix<T> {
        let mut offsets = DMatrix::zeros(self.bias.len(), points.len());
        for (point, mut column) in points.iter().zip(offsets.column_iter_mut()) {
            column.copy_from(&self.bias);
            if let Some(coordinates) = &self.coordinates {
                for axis in 0..3 {
                    column.axpy(convert(point[axis]), &coordinates.column(axis), T::one());
                }
            }
        }
        offsets
    }

    /// Adds W h to each column.
    fn add_hidden(&self, before: &DMatrix<T>, sums: &mut DMatrix<T>) {
        if before.ncols() > FEW {
            sums.gemm(T::one(), &self.hidden, before, T::one());
            return;
        }
        for (unit, weights) in self.hidden.column_iter().enumerate() {
            for (&value, mut sum) in before.row(unit).iter().zip(sums.column_iter_mut()) {
                // About half of the rectifiers are inactive.
                if value > T::zero() {
                    sum.axpy(value, &weights, T::one());
                }
            }
        }
    }

    /// Wᵀ y for each column y. Rows whose `values` are inactive may be left out.
    fn pull_back(&self, by_output: &DMatrix<T>, values: &DMatrix<T>) -> DMatrix<T> {
        let mut by_value = DMatrix::zeros(values.nrows(), values.ncols());
        if values.ncols() > FEW {
            by_value.gemm(T::one(), &self.transposed(), by_output, T::zero());
            return by_value;
        }
        for (unit, weights) in self.hidden.column_iter().enumerate() {
            for (point, slopes) in by_output.column_iter().enumerate() {
                if values[(unit, point)] > T::zero() {
                    by_value[(unit, point)] = dot(weights.as_slice(), slopes.as_slice());
                }
            }
        }
        by_value
    }

    /// Wᵀ, as a view.
    fn transposed(&self) -> DMatrixView<'_, T, Dyn, Dyn> {
        let (rows, columns) = self.hidden.shape();
        DMatrixView::from_slice_with_strides(self.hidden.as_slice(), columns, rows, rows, 1)
    }

    /// Adds Xᵀ y to the slope of each point, where y is the column of the point.
    fn add_coordinates(&self, by_output: &DMatrix<T>, slopes: &mut [Vector3<f64>]) {
        let Some(coordinates) = &self.coordinates else {
            return;
        };
        for (slope, column) in slopes.iter_mut().zip(by_output.column_iter()) {
            for axis in 0..3 {
                slope[axis] += wide(dot(coordinates.column(axis).as_slice(), column.as_slice()));
            }
        }
    }
}

impl Squashing {
    /// Output at z, with its first and second derivatives.
    fn of(self, z: f64) -> [f64; 3] {
        (0..self.0).fold([z, 1.0, 0.0], |[value, first, second], _| {
            let t = libm::tanh(value);
            let slope = 1.0 - t * t;
            [
                t,
                slope * first,
                slope * second - 2.0 * t * slope * first * first,
            ]
        })
    }
}

/// Results of `work` for each of `points`, computed in batches on all threads.
fn batches<A: Send>(
    points: &[Vector3<f64>],
    work: impl Fn(&[Vector3<f64>]) -> Vec<A> + Sync + Send,
) -> Vec<A> {
    if points.len() <= BATCH {
        return work(points);
    }
    points.par_chunks(BATCH).flat_map_iter(work).collect()
}

/// Dot product with eight partial sums, as wide as a vector register.
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let ((a, rest_of_a), (b, rest_of_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [T::zero(); 8];
    for (a, b) in a.iter().zip(b) {
        for (sum, (&a, &b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest = rest_of_a.iter().zip(rest_of_b);
    let start = rest.fold(T::zero(), |sum, (&a, &b)| sum + a * b);
    sums.into_iter().fold(start, |sum, lane| sum + lane)
}

fn wide<T: Real>(value: T) -> f64 {
    nalgebra::try_convert(value).unwrap_or(f64::NAN)
}
