//! Settings of the grasp energy, and presets.

use serde::{Deserialize, Serialize};

use crate::grasp::layer::LayerSettings;
use crate::grasp::term::{
    Alignment, Distance, ForceClosure, HandInObject, JointLimits, LayerCompliance, NormForm,
    ObjectInHand, Pressing, Prior, PriorForm, Rank, RankForm, Reach, SelfPenetration, Term,
};
use crate::hand::Hand;
use crate::limits::{
    Beyond, DISTANCE_WEIGHT, ENERGY_SETTING, NEAREST_POINTS_ROUNDING, OBJECT_SIZE,
};

/// Length unit of the authors of Liu et al. (2021), used in Eq. 11.
pub const AUTHORS_UNIT_M: f64 = 0.12;

/// Length unit of arms, distances and depths, which makes the energy dimensionless.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Greatest distance of a vertex of the object from its centroid of volume.
    ObjectRadius,
    /// A fixed length in metres (0.12 in Liu et al. 2021).
    Metres(f64),
}

/// Which surface points of the hand may be contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Candidates {
    /// All points.
    All,
    /// Points on the tips and pads of the last links of the digits.
    Fingertips,
}

impl Candidates {
    /// Whether each surface point of `hand` is a candidate.
    pub fn of(self, hand: &Hand) -> Vec<bool> {
        let is_candidate = |point| match self {
            Self::All => hand.may_touch(point),
            Self::Fingertips => hand.may_touch(point) && hand.is_fingertip(point),
        };
        hand.surface.iter().map(is_candidate).collect()
    }
}

/// Terms of the grasp energy with weights and roundings. They are read from a TOML file; see `data/experiments/`.
///
/// The default is [`EnergySettings::closed`]. Values that are missing where settings are read are those of
/// [`EnergySettings::four_points`], so that what was stored before there were layers keeps its meaning; experiment files
/// build on a preset instead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default = "EnergySettings::four_points")]
pub struct EnergySettings {
    /// The elastic layer of the hand. Without one, contacts are a set of n surface points, as in Liu et al. (2021).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<LayerSettings>,
    /// Number of contacts n. Three equal unit forces balance only at 120°, so pinches need four contacts.
    pub contacts: usize,
    /// Which surface points may be contacts.
    pub candidates: Candidates,
    /// Length unit of the energy.
    pub unit: Unit,
    /// Weight of the net wrench.
    pub force_closure_weight: f64,
    /// Norm or square of the net wrench.
    pub force_closure_form: NormForm,
    /// Rounding of the norm of the net wrench, dimensionless.
    pub force_closure_rounding: f64,
    /// Weight of the rank condition.
    pub rank_weight: f64,
    /// Least eigenvalue or all.
    pub rank_form: RankForm,
    /// Threshold ε of the rank condition.
    pub rank_epsilon: f64,
    /// Weight of contact distances per unit length (or its square).
    pub distance_weight: f64,
    /// Norm or square of the distances.
    pub distance_form: NormForm,
    /// Rounding of the distances, metres.
    pub distance_rounding_m: f64,
    /// Weight of the alignment of the normals of hand and object at the contacts.
    pub alignment_weight: f64,
    /// Weight of hand points inside the object per unit length.
    pub penetration_weight: f64,
    /// Weight of object points inside the hand per unit length.
    pub intrusion_weight: f64,
    /// Depth of an object point inside the hand that costs nothing, metres, like compressed skin.
    pub intrusion_free_m: f64,
    /// Weight of the hand's overlap with itself per unit length.
    pub self_penetration_weight: f64,
    /// Rounding of the nearest points of two parts of the hand, which jump where the parts are parallel: a share of the
    /// squared lengths of the parts, 0 for none. See [`SelfPenetration`].
    pub nearest_points_rounding: f64,
    /// Rounding of the three kinds of depth, metres.
    pub depth_rounding_m: f64,
    /// Weight of joint excess per radian.
    pub joint_limits_weight: f64,
    /// Rounding of the joint excess, radians.
    pub joint_limits_rounding_rad: f64,
    /// Weight of the pose prior.
    pub prior_weight: f64,
    /// Form of the pose prior.
    pub prior_form: PriorForm,
}

impl Default for EnergySettings {
    fn default() -> Self {
        Self::closed()
    }
}

impl EnergySettings {
    /// The energy of the best set of four surface points: smooth pieces, free of scale, with feasible hands. Hovering costs
    /// more than losing force closure, so that barriers measure force closure.
    pub fn four_points() -> Self {
        Self {
            layer: None,
            contacts: 4,
            candidates: Candidates::All,
            unit: Unit::ObjectRadius,
            force_closure_weight: 1.0,
            force_closure_form: NormForm::Norm,
            force_closure_rounding: 0.05,
            rank_weight: 0.0,
            rank_form: RankForm::Least,
            rank_epsilon: 1e-4,
            distance_weight: 10.0,
            distance_form: NormForm::Norm,
            distance_rounding_m: 0.002,
            alignment_weight: 0.0,
            penetration_weight: 10.0,
            intrusion_weight: 10.0,
            intrusion_free_m: 0.0015,
            self_penetration_weight: 10.0,
            nearest_points_rounding: 0.0,
            depth_rounding_m: 0.0005,
            joint_limits_weight: 20.0,
            joint_limits_rounding_rad: 0.02,
            prior_weight: 0.02,
            prior_form: PriorForm::Quadratic,
        }
    }

    /// The energy of an elastic layer on the palmar side of the hand. Its gradient is Lipschitz continuous where the second
    /// derivatives of the object's field are ([`LayerCompliance`], [`SelfPenetration`]). Its minima are closed hands that
    /// hold. One unit of energy is the compliance of a hand that has let go.
    ///
    /// The contact set of a grasp is no part of it; it is chosen afterwards, for filters and files, with a weight of
    /// distances that prefers points which touch.
    pub fn closed() -> Self {
        Self {
            layer: Some(LayerSettings::default()),
            distance_weight: 40.0,
            self_penetration_weight: 3.0,
            nearest_points_rounding: 0.01,
            depth_rounding_m: 0.002,
            joint_limits_weight: 6.0,
            prior_weight: 0.006,
            ..Self::four_points()
        }
    }

    /// The formulae printed in Liu et al. (2021), Eqs. 7–10, with their w = 1.
    pub fn paper() -> Self {
        Self {
            layer: None,
            contacts: 3,
            candidates: Candidates::All,
            unit: Unit::ObjectRadius,
            force_closure_weight: 1.0,
            force_closure_form: NormForm::Norm,
            force_closure_rounding: 0.0,
            rank_weight: 1.0,
            rank_form: RankForm::Least,
            rank_epsilon: 1e-4,
            distance_weight: 1.0,
            distance_form: NormForm::Norm,
            distance_rounding_m: 0.0,
            alignment_weight: 0.0,
            penetration_weight: 1.0,
            intrusion_weight: 0.0,
            intrusion_free_m: 0.0,
            self_penetration_weight: 0.0,
            nearest_points_rounding: 0.0,
            depth_rounding_m: 0.0,
            joint_limits_weight: 0.0,
            joint_limits_rounding_rad: 0.02,
            prior_weight: 1.0,
            prior_form: PriorForm::Norm,
        }
    }

    /// The energy of the authors' code: squared norms, ten times the penetration, the rank term over all eigenvalues, and
    /// an alignment term that is not in the paper. Lengths are in units of 120 mm.
    pub fn released() -> Self {
        Self {
            contacts: 5,
            unit: Unit::Metres(AUTHORS_UNIT_M),
            force_closure_form: NormForm::Square,
            rank_form: RankForm::Sum,
            rank_epsilon: 0.01,
            distance_form: NormForm::Square,
            alignment_weight: 1.0,
            penetration_weight: 10.0,
            prior_form: PriorForm::StandardScores,
            ..Self::paper()
        }
    }

    pub(super) fn force_closure(&self) -> ForceClosure {
        ForceClosure {
            weight: self.force_closure_weight,
            form: self.force_closure_form,
            rounding: self.force_closure_rounding,
        }
    }

    pub(super) fn distance(&self) -> Distance {
        Distance {
            weight: self.distance_weight,
            form: self.distance_form,
            rounding_m: self.distance_rounding_m,
        }
    }

    pub(super) fn alignment(&self) -> Alignment {
        Alignment {
            weight: self.alignment_weight,
        }
    }

    /// Names of the terms with nonzero weight, in the order of [`GraspEnergy::term_names`](crate::grasp::GraspEnergy::term_names).
    pub fn term_names(&self) -> Vec<String> {
        let terms = self.terms(0.0);
        terms.iter().map(|term| term.name().to_owned()).collect()
    }

    /// The terms with nonzero weight, in the order of their [`Stage`](crate::grasp::term::Stage). All surface points of the
    /// hand are kept `clearance_m` off the object.
    pub(super) fn terms(&self, clearance_m: f64) -> Vec<Box<dyn Term>> {
        let mut terms = match self.layer {
            None => self.point_terms(clearance_m),
            Some(settings) => vec![
                Box::new(LayerCompliance { settings }) as Box<dyn Term>,
                Box::new(Reach { settings }),
                Box::new(Pressing { settings }),
            ],
        };
        terms.push(Box::new(SelfPenetration {
            weight: self.self_penetration_weight,
            rounding_m: self.depth_rounding_m,
            nearest_points_rounding: self.nearest_points_rounding,
        }));
        terms.push(Box::new(JointLimits {
            weight: self.joint_limits_weight,
            rounding_rad: self.joint_limits_rounding_rad,
        }));
        terms.push(Box::new(Prior {
            weight: self.prior_weight,
            form: self.prior_form,
        }));
        terms.retain(|term| term.weight() > 0.0);
        terms
    }

    /// The terms of contacts and depths of an energy of contact sets.
    fn point_terms(&self, clearance_m: f64) -> Vec<Box<dyn Term>> {
        vec![
            Box::new(self.force_closure()),
            Box::new(Rank {
                weight: self.rank_weight,
                form: self.rank_form,
                epsilon: self.rank_epsilon,
            }),
            Box::new(self.distance()),
            Box::new(self.alignment()),
            Box::new(HandInObject {
                weight: self.penetration_weight,
                rounding_m: self.depth_rounding_m,
                clearance_m,
            }),
            Box::new(ObjectInHand {
                weight: self.intrusion_weight,
                free_m: self.intrusion_free_m,
                rounding_m: self.depth_rounding_m,
            }),
        ]
    }

    /// Rejects settings for which nothing brings contacts to the surface (single terms may be evaluated with them).
    ///
    /// # Errors
    /// If the weight of distances is 0 or almost 0.
    pub fn ask_for_contacts(&self) -> Result<(), EnergySettingsError> {
        let told = |beyond| EnergySettingsError::Value {
            name: "distance_weight",
            beyond,
        };
        DISTANCE_WEIGHT.check(self.distance_weight).map_err(told)
    }

    /// Describes the first invalid value in one sentence.
    ///
    /// # Errors
    /// If a weight or rounding is negative, not finite or above a million, or the number of contacts is outside 2..=8.
    pub fn validate(&self) -> Result<(), EnergySettingsError> {
        if !(2..=8).contains(&self.contacts) {
            return Err(EnergySettingsError::Contacts(self.contacts));
        }
        if let Unit::Metres(unit) = self.unit {
            let told = |beyond| EnergySettingsError::Value {
                name: "unit",
                beyond,
            };
            OBJECT_SIZE.check(unit).map_err(told)?;
        }
        let values = [
            ("force_closure_weight", self.force_closure_weight),
            ("force_closure_rounding", self.force_closure_rounding),
            ("rank_weight", self.rank_weight),
            ("rank_epsilon", self.rank_epsilon),
            ("distance_weight", self.distance_weight),
            ("distance_rounding_m", self.distance_rounding_m),
            ("alignment_weight", self.alignment_weight),
            ("penetration_weight", self.penetration_weight),
            ("intrusion_weight", self.intrusion_weight),
            ("intrusion_free_m", self.intrusion_free_m),
            ("self_penetration_weight", self.self_penetration_weight),
            ("depth_rounding_m", self.depth_rounding_m),
            ("joint_limits_weight", self.joint_limits_weight),
            ("joint_limits_rounding_rad", self.joint_limits_rounding_rad),
            ("prior_weight", self.prior_weight),
        ];
        let values = values.map(|(name, value)| (name, ENERGY_SETTING, value));
        let rounding = (
            "nearest_points_rounding",
            NEAREST_POINTS_ROUNDING,
            self.nearest_points_rounding,
        );
        let of_layer = self.layer.iter().flat_map(LayerSettings::values);
        for (name, limit, value) in values.into_iter().chain([rounding]).chain(of_layer) {
            let told = |beyond| EnergySettingsError::Value { name, beyond };
            limit.check(value).map_err(told)?;
        }
        Ok(())
    }
}

/// An invalid setting of the energy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EnergySettingsError {
    /// The number of contacts is outside 2..=8.
    #[error("contacts = {0}: a grasp has 2 to 8 contacts")]
    Contacts(usize),
    /// There are fewer candidates than contacts.
    #[error("only {found} surface points of the hand may be contacts, but {contacts} are needed")]
    Candidates {
        /// Number of candidates.
        found: usize,
        /// Required number of contacts.
        contacts: usize,
    },
    /// A value is negative, NaN or far too large.
    #[error("{name} = {beyond}")]
    Value {
        /// The setting.
        name: &'static str,
        /// Its value and its limit.
        beyond: Beyond,
    },
}
