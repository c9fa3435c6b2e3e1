//! The grasp energy E(H, O) of a hand pose on an object.

mod evaluation;
mod queries;
mod settings;

use std::sync::{Arc, Mutex};

use evaluation::Memory;
pub use queries::THROUGH_M;
pub use settings::{AUTHORS_UNIT_M, EnergySettings, EnergySettingsError};

use super::contact::CONTACTS;
use super::grip::Parts;
use super::layer::{Layer, LayerSettings};
use super::term::Term;
use crate::energy::{Energy, Explain};
use crate::hand::{Ball, Hand};
use crate::object::Object;
use crate::space::{PoseMetric, PoseSpace, Space};

/// Reach while a chain closes the digits of its grip, metres: more than twice that of the energy, so that
/// open digits are drawn.
const CLOSING_REACH_M: f64 = 0.03;

/// E(H, O): the energy of a hand pose on an object, a sum of smooth terms ([`EnergySettings`]).
#[derive(Debug)]
pub struct GraspEnergy {
    hand: Arc<Hand>,
    object: Arc<Object>,
    space: PoseSpace,
    metric: PoseMetric,
    settings: EnergySettings,
    layer: Layer,
    /// A layer of fewer spheres, on which a chain closes a hand.
    coarse_layer: Arc<Layer>,
    /// The terms with nonzero weight, by stage.
    terms: Vec<Box<dyn Term>>,
    memories: Mutex<Vec<Memory>>,
}

impl GraspEnergy {
    /// The energy of `hand` on `object`.
    ///
    /// # Errors
    /// If the settings are invalid, or if fewer surface points of the hand may touch than a contact set has members.
    pub fn new(
        hand: Arc<Hand>,
        object: Arc<Object>,
        settings: EnergySettings,
    ) -> Result<Self, EnergySettingsError> {
        settings.validate()?;
        let may_touch = hand.surface.iter().filter(|point| hand.may_touch(point));
        let found = may_touch.count();
        if found < CONTACTS {
            return Err(EnergySettingsError::Candidates {
                found,
                contacts: CONTACTS,
            });
        }
        let spacing_m = settings.layer.patch_spacing_m;
        let (fine, coarse) = (
            Layer::new(&hand, spacing_m),
            Layer::coarse(&hand, spacing_m),
        );
        Ok(Self::with_layer(
            hand,
            object,
            settings,
            fine,
            Arc::new(coarse),
        ))
    }

    fn with_layer(
        hand: Arc<Hand>,
        object: Arc<Object>,
        settings: EnergySettings,
        layer: Layer,
        coarse_layer: Arc<Layer>,
    ) -> Self {
        let metric = hand.pose_metric();
        Self {
            space: PoseSpace::new(metric.clone(), object.symmetry.clone()),
            metric,
            layer,
            coarse_layer,
            terms: settings.terms(),
            settings,
            hand,
            object,
            memories: Mutex::new(Vec::new()),
        }
    }

    /// The energy that closes some parts of a hand: those that take part are drawn to the object from farther away and without
    /// a hump; the other parts carry nothing and keep off the object. Meshes of the hand are filled coarsely. Its minima are
    /// starts for descents on this energy.
    pub(crate) fn for_grip(&self, parts: &Parts) -> Self {
        let layer = self.settings.layer;
        let closing = EnergySettings {
            layer: LayerSettings {
                reach_m: CLOSING_REACH_M,
                reach_hump: 0.0,
                ..layer
            },
            ..self.settings
        };
        let clearance_m = layer.rest_clearance_m();
        let coarse = &self.coarse_layer;
        let layer = Layer::clone(coarse).for_grip(&self.hand, parts, clearance_m);
        let (hand, object) = (self.hand.clone(), self.object.clone());
        Self::with_layer(hand, object, closing, layer, coarse.clone())
    }

    /// The hand.
    pub fn hand(&self) -> &Arc<Hand> {
        &self.hand
    }

    /// The object.
    pub fn object(&self) -> &Arc<Object> {
        &self.object
    }

    /// The elastic layer.
    pub fn layer(&self) -> &Layer {
        &self.layer
    }

    /// The balls that fill the meshes of the hand.
    pub fn layer_balls(&self) -> &[Ball] {
        if self.layer.spheres.is_empty() {
            &[]
        } else {
            self.hand.balls()
        }
    }

    /// The settings.
    pub fn settings(&self) -> &EnergySettings {
        &self.settings
    }

    /// The pose space as a concrete type.
    pub fn pose_space(&self) -> &PoseSpace {
        &self.space
    }

    /// Length unit of arms and depths, metres: the object's radius, which makes the energy dimensionless.
    pub fn unit_m(&self) -> f64 {
        self.object.radius_m
    }

    /// Names of the terms, in the order of [`Explain::terms`].
    pub fn term_names(&self) -> Vec<String> {
        let names = self.terms.iter().map(|term| term.name().to_owned());
        names.collect()
    }
}

impl Energy for GraspEnergy {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.at(x, |evaluation| evaluation.evaluate(gradient))
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Some(self)
    }
}

impl Explain for GraspEnergy {
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        #[expect(
            clippy::redundant_closure_for_method_calls,
            reason = "the method alone is not general in its lifetimes"
        )]
        self.at(x, |evaluation| evaluation.terms())
    }

    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        let deepest_m = self.deepest_m(x);
        (deepest_m > THROUGH_M)
            .then(|| format!("hand and object overlap by {:.1} mm", deepest_m * 1e3))
    }
}
