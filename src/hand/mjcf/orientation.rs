//! The five forms of a rotation in MJCF, and frames.

use nalgebra::{Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};

use super::super::{Frame, HandError};
use super::Compiler;
use super::defaults::Attributes;
use super::element::Element;

const WAYS: [&str; 5] = ["quat", "euler", "axisangle", "xyaxes", "zaxis"];

impl Compiler {
    /// An angle in the unit of the file, converted to radians.
    pub(super) fn angle(&self, value: f64) -> f64 {
        if self.radians {
            value
        } else {
            value.to_radians()
        }
    }

    /// Position and orientation of an element.
    pub(super) fn frame(&self, attributes: &Attributes<'_>) -> Result<Frame, HandError> {
        let translation = attributes.exactly::<3>("pos")?.unwrap_or_default();
        let rotation = match attributes.nearest(&WAYS) {
            Some(element) => self.rotation(element, attributes.element())?,
            None => Matrix3::identity(),
        };
        Ok(Frame {
            rotation,
            translation: translation.into(),
        })
    }

    fn rotation(&self, given: &Element, blamed: &Element) -> Result<Matrix3<f64>, HandError> {
        let mut ways = WAYS
            .iter()
            .filter_map(|way| Some((*way, given.attribute(way)?)));
        let Some((way, text)) = ways.next() else {
            return Ok(Matrix3::identity());
        };
        // As in MuJoCo, another form takes precedence over the quaternion.
        let (way, text) = if way == "quat" {
            ways.next().unwrap_or((way, text))
        } else {
            (way, text)
        };
        if let Some((other, _)) = ways.next() {
            return Err(blamed.error(format!(
                "both {way} and {other} are given: only one orientation is allowed"
            )));
        }
        let zero = || blamed.error(format!("{way}=\"{text}\" has no direction"));
        match way {
            "quat" => quaternion(blamed.exactly("quat", text)?).ok_or_else(zero),
            "euler" => Ok(self.euler(blamed.exactly("euler", text)?)),
            "axisangle" => {
                let [x, y, z, angle] = blamed.exactly("axisangle", text)?;
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-14).ok_or_else(zero)?;
                Ok(*Rotation3::from_axis_angle(&axis, self.angle(angle)).matrix())
            }
            "xyaxes" => {
                let [a, b, c, d, e, f] = blamed.exactly("xyaxes", text)?;
                let x = Vector3::new(a, b, c)
                    .try_normalize(1e-14)
                    .ok_or_else(zero)?;
                let y = Vector3::new(d, e, f);
                let y = (y - x * x.dot(&y)).try_normalize(1e-14).ok_or_else(zero)?;
                Ok(Matrix3::from_columns(&[x, y, x.cross(&y)]))
            }
            _ => {
                let z = Vector3::from(blamed.exactly::<3>("zaxis", text)?);
                z.try_normalize(1e-14)
                    .map(|z| turning_z_to(&z))
                    .ok_or_else(zero)
            }
        }
    }

    /// Three rotations in the order of `eulerseq`: about body axes if lower case, about fixed axes if upper case.
    fn euler(&self, angles: [f64; 3]) -> Matrix3<f64> {
        let mut rotation = Matrix3::identity();
        for (axis, angle) in self.euler_sequence.iter().zip(angles) {
            let unit = match axis.to_ascii_lowercase() {
                'x' => Vector3::x_axis(),
                'y' => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            let turn = *Rotation3::from_axis_angle(&unit, self.angle(angle)).matrix();
            rotation = if axis.is_lowercase() {
                rotation * turn
            } else {
                turn * rotation
            };
        }
        rotation
    }
}

/// The rotation of a quaternion (w x y z) of any nonzero length.
pub(super) fn quaternion([w, x, y, z]: [f64; 4]) -> Option<Matrix3<f64>> {
    let quaternion = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-14)?;
    Some(*quaternion.to_rotation_matrix().matrix())
}

/// The shortest rotation that takes the z axis to the unit vector `z`; half a turn about the x axis if they are opposite,
/// as in `MuJoCo`.
pub(super) fn turning_z_to(z: &Vector3<f64>) -> Matrix3<f64> {
    let axis = Vector3::z().cross(z);
    let (sine, cosine) = (axis.norm(), z.z);
    let axis = Unit::try_new(axis, 1e-10).unwrap_or(Vector3::x_axis());
    *Rotation3::from_axis_angle(&axis, libm::atan2(sine, cosine)).matrix()
}
