//! The grasp energy E(H, x, O) of a pose and a contact set, and its envelope E(H, O) = min over x.

mod evaluation;
mod heat_bath;
mod local;
mod near;
mod queries;
mod search;
mod settings;
mod start_score;

use std::sync::{Arc, Mutex};

use evaluation::Memory;
pub use evaluation::Ramp;
pub use queries::THROUGH_M;
pub use settings::{AUTHORS_UNIT_M, Candidates, EnergySettings, EnergySettingsError, Unit};

use super::grip::Grip;
use super::layer::{Layer, LayerSettings};
use super::term::{Alignment, Distance, Term};
use crate::energy::{Energy, Explain, Piecewise};
use crate::hand::{Ball, Hand};
use crate::object::Object;
use crate::space::{PoseMetric, PoseSpace, Space};

/// E(H, O): the energy of a hand pose on an object, minimised exactly over all sets of n contacts.
///
/// ```text
/// E(H, O) = min over x ⊂ S(H), |x| = n  of  E_fc(H, x, O) + E_dist(H, x, O) + E_pen + E_prior + …
/// ```
///
/// It is continuous and piecewise C¹, with kinks at seams; for a fixed set it is C¹ ([`Piecewise::evaluate_piece`]).
#[derive(Debug)]
pub struct GraspEnergy {
    hand: Arc<Hand>,
    object: Arc<Object>,
    space: PoseSpace,
    metric: PoseMetric,
    settings: EnergySettings,
    unit_m: f64,
    /// The terms used in the search for the best contact set.
    distance: Distance,
    alignment: Alignment,
    /// Distance that every surface point must keep from the object, metres.
    clearance_m: f64,
    /// The elastic layer; without spheres if contacts are a set of points.
    layer: Layer,
    /// A layer of fewer spheres, on which a chain closes a hand.
    coarse_layer: Arc<Layer>,
    /// The terms with nonzero weight, by stage.
    terms: Vec<Box<dyn Term>>,
    /// Whether each surface point may be a contact, and the list of those that may.
    may_touch: Vec<bool>,
    contact_candidates: Vec<u32>,
    memories: Mutex<Vec<Memory>>,
}

/// Initial distance of candidates. The search widens it where necessary.
const FIRST_BAND_M: f64 = 0.006;

/// Contact energy above which all contact sets are bad, and the best one is found only on request.
const HOPELESS: f64 = 1.0;

impl GraspEnergy {
    /// The energy of `hand` on `object`.
    ///
    /// # Errors
    /// If the settings are invalid.
    pub fn new(
        hand: Arc<Hand>,
        object: Arc<Object>,
        settings: EnergySettings,
    ) -> Result<Self, EnergySettingsError> {
        let layers = settings.layer.map(
            |LayerSettings {
                 patch_spacing_m, ..
             }| {
                let fine = Layer::new(&hand, patch_spacing_m);
                (fine, Layer::coarse(&hand, patch_spacing_m))
            },
        );
        let (layer, coarse) = layers.unwrap_or_default();
        Self::with_layer(hand, object, settings, layer, Arc::new(coarse))
    }

    fn with_layer(
        hand: Arc<Hand>,
        object: Arc<Object>,
        settings: EnergySettings,
        layer: Layer,
        coarse_layer: Arc<Layer>,
    ) -> Result<Self, EnergySettingsError> {
        settings.validate()?;
        let unit_m = match settings.unit {
            Unit::ObjectRadius => object.radius_m,
            Unit::Metres(unit) => unit,
        };
        let metric = hand.pose_metric();
        let space = PoseSpace::new(metric.clone(), object.symmetry.clone());
        let may_touch = settings.candidates.of(&hand);
        let contact_candidates: Vec<u32> = (0u32..)
            .zip(&may_touch)
            .filter_map(|(index, may)| may.then_some(index))
            .collect();
        if contact_candidates.len() < settings.contacts {
            return Err(EnergySettingsError::Candidates {
                found: contact_candidates.len(),
                contacts: settings.contacts,
            });
        }
        Ok(Self {
            space,
            metric,
            unit_m,
            distance: settings.distance(),
            alignment: settings.alignment(),
            clearance_m: 0.0,
            layer,
            coarse_layer,
            terms: settings.terms(0.0),
            settings,
            may_touch,
            contact_candidates,
            hand,
            object,
            memories: Mutex::new(Vec::new()),
        })
    }

    /// The same energy with a stiff penalty that keeps the hand `clearance_m` off the object; it gives the hovering cost.
    #[must_use]
    pub fn with_clearance(mut self, clearance_m: f64, weight: f64) -> Self {
        self.clearance_m = clearance_m;
        self.settings.penetration_weight = weight;
        if let Some(layer) = &mut self.settings.layer {
            layer.pressing_weight_per_m = weight / self.unit_m;
            layer.pressing_free_m = -clearance_m;
        }
        self.terms = self.settings.terms(clearance_m);
        self
    }

    /// The energy that closes a hand in a grip: digits that take part are drawn to the object from farther away and without
    /// a hump; the other parts carry nothing and keep off the object. Meshes of the hand are filled coarsely. Its minima are starts for descents on this energy.
    /// `None` for an energy without a layer.
    pub(crate) fn for_grip(&self, grip: Grip) -> Option<Self> {
        let layer = self.settings.layer?;
        let closing = EnergySettings {
            layer: Some(LayerSettings {
                reach_m: layer.closing_reach_m,
                reach_hump: 0.0,
                ..layer
            }),
            ..self.settings
        };
        let clearance_m = layer.rest_clearance_m();
        let coarse = &self.coarse_layer;
        let layer = Layer::clone(coarse).for_grip(&self.hand, grip, clearance_m);
        let (hand, object) = (self.hand.clone(), self.object.clone());
        Self::with_layer(hand, object, closing, layer, coarse.clone()).ok()
    }

    /// The hand.
    pub fn hand(&self) -> &Arc<Hand> {
        &self.hand
    }

    /// The object.
    pub fn object(&self) -> &Arc<Object> {
        &self.object
    }

    /// Indices of the surface points that may be contacts.
    pub fn contact_candidates(&self) -> &[u32] {
        &self.contact_candidates
    }

    /// The elastic layer; without spheres for an energy of contact sets.
    pub fn layer(&self) -> &Layer {
        &self.layer
    }

    /// The balls that fill the meshes of the hand; none for an energy without a layer, which does not need them.
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

    /// Length unit of arms, distances and depths, metres.
    pub fn unit_m(&self) -> f64 {
        self.unit_m
    }
}

impl Energy for GraspEnergy {
    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.evaluate_below(x, gradient, f64::INFINITY)
    }

    /// The energy of an elastic layer is smooth and has no pieces.
    fn piecewise(&self) -> Option<&dyn Piecewise> {
        self.settings
            .layer
            .is_none()
            .then_some(self as &dyn Piecewise)
    }

    fn explain(&self) -> Option<&dyn Explain> {
        Some(self)
    }
}

impl Piecewise for GraspEnergy {
    fn active_piece(&self, x: &[f64]) -> Vec<u32> {
        self.contacts(x)
    }

    fn evaluate_piece(&self, x: &[f64], piece: &[u32], gradient: &mut [f64]) -> f64 {
        self.evaluate_ramped(x, piece, Ramp::default(), gradient)
    }

    fn evaluate_below(&self, x: &[f64], gradient: &mut [f64], cutoff: f64) -> f64 {
        self.at(x, |evaluation| evaluation.envelope(gradient, cutoff))
    }

    fn evaluate_roughly_above(
        &self,
        x: &[f64],
        gradient: &mut [f64],
        ceiling: f64,
    ) -> (f64, Vec<u32>) {
        self.at(x, |evaluation| evaluation.roughly(gradient, ceiling))
    }

    fn with_cache(&self) -> Option<Box<dyn Energy + '_>> {
        Some(Box::new(self.with_own_memory()))
    }
}

impl Explain for GraspEnergy {
    /// The terms at the best contact set, or at a good one if all sets are very bad.
    fn terms(&self, x: &[f64]) -> Vec<(String, f64)> {
        self.at(x, |evaluation| {
            evaluation.measure_candidates();
            evaluation.choose_contacts_roughly_above(HOPELESS);
            let choice = evaluation.memory.search.best().to_vec();
            evaluation.terms(&choice)
        })
    }

    fn invalid_reason(&self, x: &[f64]) -> Option<String> {
        let deepest_m = self.deepest_m(x);
        (deepest_m > THROUGH_M)
            .then(|| format!("hand and object overlap by {:.1} mm", deepest_m * 1e3))
    }
}

impl GraspEnergy {
    /// E(H, x, O) with the weights of contact distances and depths multiplied by `ramp`, as in synthesis.
    ///
    /// # Panics
    /// If a slice has the wrong length.
    pub fn evaluate_ramped(
        &self,
        x: &[f64],
        choice: &[u32],
        ramp: Ramp,
        gradient: &mut [f64],
    ) -> f64 {
        self.at(x, |evaluation| evaluation.held(choice, ramp, gradient))
    }

    /// The named, weighted terms of E(H, x, O), in a fixed order.
    pub fn terms_of(&self, x: &[f64], choice: &[u32]) -> Vec<(String, f64)> {
        self.at(x, |evaluation| evaluation.terms(choice))
    }

    /// Names of the terms, in the order of [`Explain::terms`].
    pub fn term_names(&self) -> Vec<String> {
        let names = self.terms.iter().map(|term| term.name().to_owned());
        names.collect()
    }
}
