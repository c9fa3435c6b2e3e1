//! A neural shape in metres.

use nalgebra::{Matrix3, Vector3};

use super::NeuralError;
use super::network::{Answer, Network, Real};
use crate::limits::OBJECT_SCALE;
use crate::object::Shape;

/// The signed distance of a [`Network`] in metres, defined everywhere.
///
/// ```text
/// d(p) = s f(p/s)                        for ‖p‖ ≤ s
/// d(p) = s f(p/‖p‖) + ‖p‖ − s            beyond
/// ```
///
/// The scale s is the number of metres per unit of the network. The networks were not trained beyond the ball of radius 1,
/// so the distance is continued outward. The continuation is continuous, but its slope has a kink on the sphere. Inside the
/// ball there are kinks everywhere, as in all networks of rectifiers.
///
/// Evaluating many points at once ([`NeuralField::distances`], [`NeuralField::answers`]) is much cheaper than one by one;
/// the results differ by rounding. `f32` is as accurate as the trained network; `f64` gives derivatives without rounding
/// noise.
#[derive(Debug, Clone, PartialEq)]
pub struct NeuralField<T: Real> {
    network: Network<T>,
    scale_m: f64,
    lipschitz: f64,
}

/// Number of points along each axis at which the steepest slope is sought.
const SLOPE_NODES: u32 = 20;
/// Safety factor, because the slope between those points may be steeper. There is no useful bound for a network.
const HEADROOM: f64 = 1.5;

impl<T: Real> NeuralField<T> {
    /// The shape of `network`, with `scale_m` metres per unit.
    ///
    /// # Errors
    /// If the scale is beyond its limit.
    pub fn new(network: Network<T>, scale_m: f64) -> Result<Self, NeuralError> {
        OBJECT_SCALE.check(scale_m).map_err(NeuralError::Scale)?;
        let mut field = Self {
            network,
            scale_m,
            lipschitz: 1.0,
        };
        field.lipschitz = HEADROOM * field.steepest().max(1.0);
        Ok(field)
    }

    /// The network.
    pub fn network(&self) -> &Network<T> {
        &self.network
    }

    /// Metres per unit of the network.
    pub fn scale_m(&self) -> f64 {
        self.scale_m
    }

    /// [`Shape::distance`] at each of `points`.
    pub fn distances(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        let asked: Vec<Asked> = points.iter().map(|point| self.ask(point)).collect();
        let places: Vec<_> = asked.iter().map(|asked| asked.place).collect();
        let values = self.network.values(&places);
        asked
            .iter()
            .zip(values)
            .map(|(asked, value)| self.scale_m * (value + asked.beyond))
            .collect()
    }

    /// [`Shape::hessian`] at each of `points`.
    pub fn answers(&self, points: &[Vector3<f64>]) -> Vec<Answer> {
        let asked: Vec<Asked> = points.iter().map(|point| self.ask(point)).collect();
        let places: Vec<_> = asked.iter().map(|asked| asked.place).collect();
        let answers = self.network.answers(&places);
        let in_metres = |(asked, answer): (&Asked, Answer)| {
            let (value, gradient, hessian) = asked.continued(answer);
            (self.scale_m * value, gradient, hessian / self.scale_m)
        };
        asked.iter().zip(answers).map(in_metres).collect()
    }

    fn ask(&self, point: &Vector3<f64>) -> Asked {
        let place = point / self.scale_m;
        let radius = place.norm();
        if radius <= 1.0 {
            Asked { place, beyond: 0.0 }
        } else {
            Asked {
                place: place / radius,
                beyond: radius - 1.0,
            }
        }
    }

    /// Largest slope found outside the solid.
    fn steepest(&self) -> f64 {
        let coordinate = |index: u32| 2.0 * (f64::from(index) + 0.5) / f64::from(SLOPE_NODES) - 1.0;
        let nodes = SLOPE_NODES.pow(3);
        let places: Vec<Vector3<f64>> = (0..nodes)
            .map(|node| {
                let [x, y, z] = [
                    node % SLOPE_NODES,
                    node / SLOPE_NODES % SLOPE_NODES,
                    node / SLOPE_NODES.pow(2),
                ];
                Vector3::new(coordinate(x), coordinate(y), coordinate(z))
            })
            .filter(|place| place.norm() <= 1.0)
            .collect();
        let slopes = self.network.answers(&places).into_iter();
        let outside = slopes.filter(|(value, ..)| *value >= 0.0);
        outside
            .map(|(_, gradient, _)| gradient.norm())
            .fold(0.0, f64::max)
    }
}

/// A query point in units of the network.
struct Asked {
    /// The point, moved radially onto the ball if it lies beyond.
    place: Vector3<f64>,
    /// Distance of the point beyond the ball.
    beyond: f64,
}

impl Asked {
    /// Derivatives of f(u) + r by p, from those of f at u = p/r, where r = ‖p‖.
    fn continued(&self, (value, gradient, hessian): Answer) -> Answer {
        if self.beyond == 0.0 {
            return (value, gradient, hessian);
        }
        let (radius, unit) = (1.0 + self.beyond, self.place);
        let outward = unit * unit.transpose();
        let across = Matrix3::identity() - outward;
        let radial = gradient.dot(&unit);
        // ∂²(g·p/r)/∂p² for constant g.
        let mixed = gradient * unit.transpose();
        let turning = (outward * 3.0 - Matrix3::identity()) * radial - mixed - mixed.transpose();
        (
            value + self.beyond,
            across * gradient / radius + unit,
            (across * hessian * across + turning) / (radius * radius) + across / radius,
        )
    }
}

impl<T: Real> Shape for NeuralField<T> {
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        self.distances(std::slice::from_ref(point))[0]
    }

    fn gradient(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let (distance_m, gradient, _) = self.hessian(point);
        (distance_m, gradient)
    }

    fn hessian(&self, point: &Vector3<f64>) -> Answer {
        self.answers(std::slice::from_ref(point))[0]
    }

    /// One and a half times the largest slope found at some thousand points. No rigorous bound is known.
    fn lipschitz(&self) -> f64 {
        self.lipschitz
    }
}
