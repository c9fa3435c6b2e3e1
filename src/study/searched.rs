//! How a surface is searched, and the result.

use super::surface::Subject;
use crate::energy::{Counted, Energy};
use crate::space::Space;
use crate::topography::exchange::curvatures;
use crate::topography::{
    Exploration, Landscape, LowestReport, LowestSettings, PairSearch, SearchSettings,
    TransitionState, mark_branches,
};

/// How a surface is searched.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceSearch<'a> {
    /// Settings of every search.
    pub settings: &'a SearchSettings,
    /// Only the lowest minima and the ways between them are sought, with these settings; `None` seeks everything.
    pub lowest: Option<&'a LowestSettings>,
    /// Points from which the search begins, besides random ones.
    pub known: &'a [Vec<f64>],
    /// Two minima of the result between which further searches follow; see [`explore_from`](crate::topography::explore_from).
    /// A search for the lowest minima alone ignores it.
    pub pair: Option<PairSearch>,
}

/// The result of [`search_surface`](super::search_surface).
#[derive(Debug, Clone)]
pub struct Searched {
    /// The minima and saddles; at least one minimum.
    pub found: Exploration,
    /// Their landscape.
    pub landscape: Landscape,
    /// How the search for the lowest minima went, if only these were sought.
    pub lowest: Option<LowestReport>,
}

impl Searched {
    /// Turns the result of a search in an unrolled box ([`InBox`](crate::energy::InBox)) into that of the surface `shown`, whose
    /// coordinates `point` returns. `settings` are those of the search.
    ///
    /// Curvatures are measured anew in the coordinates of `shown`, since those of the unrolled box are f″ sin² of its angles.
    /// A point nearer to a face than the step of finite differences has none: the slope across the face does not vanish there.
    /// Saddles on a face whose two descents are mirror images of each other are left out.
    pub fn shown_as(
        &mut self,
        point: &dyn Fn(&[f64]) -> Vec<f64>,
        shown: &Subject<'_>,
        settings: &SearchSettings,
    ) {
        self.move_points(point);
        let step = settings.audit().difference;
        let on_face = |x: &[f64]| {
            let mut sides = x.iter().zip(&shown.low).zip(&shown.high);
            sides.any(|((x, low), high)| x - low <= step || high - x <= step)
        };
        let slopes = Slopes(shown.energy);
        let counted = Counted::new(&slopes);
        let measured = |x: &[f64]| {
            let inside = (!on_face(x)).then(|| curvatures(&counted, x, step));
            inside.flatten().unwrap_or_default()
        };
        let artefact =
            |saddle: &TransitionState| on_face(&saddle.coordinates) && is_mirrored(saddle);
        self.found.saddles.retain(|saddle| !artefact(saddle));
        mark_branches(&mut self.found.saddles);
        let saddles = self.found.distinct_saddles();
        let hits: Vec<usize> = saddles.map(|saddle| saddle.hits).collect();
        let minima = self.found.minima.iter();
        let draws: Vec<usize> = minima.map(|minimum| minimum.members.len()).collect();
        self.found.coverage = self.found.coverage.of(&hits, &draws);
        for (minimum, audit) in self.found.minima.iter().zip(&mut self.found.audits) {
            audit.curvatures = measured(&minimum.coordinates);
        }
        for saddle in &mut self.found.saddles {
            saddle.audit.curvatures = measured(&saddle.coordinates);
        }
        self.found.evaluations += usize::try_from(counted.evaluations()).unwrap_or(0);
    }

    fn move_points(&mut self, point: &dyn Fn(&[f64]) -> Vec<f64>) {
        let change = |x: &mut Vec<f64>| *x = point(x);
        for minimum in &mut self.found.minima {
            change(&mut minimum.coordinates);
        }
        for saddle in &mut self.found.saddles {
            change(&mut saddle.coordinates);
            saddle.path.images.iter_mut().for_each(change);
        }
        for bound in &mut self.found.bounds {
            bound.path.images.iter_mut().for_each(change);
        }
        for minimum in self.landscape.network.node_weights_mut() {
            change(&mut minimum.coordinates);
        }
        for connection in &mut self.landscape.connections {
            connection.path.images.iter_mut().for_each(change);
            for crossing in &mut connection.crossings {
                crossing.path.images.iter_mut().for_each(change);
            }
        }
    }
}

/// An energy without its own second derivatives: in a box, searches ask for gradients only, and nobody checked the others.
struct Slopes<'a>(&'a dyn Energy);

impl Energy for Slopes<'_> {
    fn space(&self) -> &dyn Space {
        self.0.space()
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        self.0.evaluate(x, gradient)
    }
}

/// Whether the two descents from a saddle, in the coordinates of a box, begin toward the same side and end in one minimum.
fn is_mirrored(saddle: &TransitionState) -> bool {
    let images = &saddle.path.images;
    let before = saddle.top.checked_sub(1).and_then(|k| images.get(k));
    let (Some(before), Some(after)) = (before, images.get(saddle.top + 1)) else {
        return false;
    };
    let sides = before.iter().zip(after).zip(&saddle.coordinates);
    let cosine: f64 = sides.map(|((a, b), x)| (a - x) * (b - x)).sum();
    saddle.ends[0] == saddle.ends[1] && cosine > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::InBox;
    use crate::space::Euclidean;
    use crate::store::Source;
    use crate::study::{StudyRun, search_surface};
    use crate::thermal::Superposition;
    use crate::topography::exchange::Database;
    use crate::topography::{FamilySettings, in_box};

    /// (x² − 1)² + y²/2.
    struct Wells(Euclidean);

    impl Energy for Wells {
        fn space(&self) -> &dyn Space {
            &self.0
        }

        fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
            let [x, y] = [x[0], x[1]];
            let rest = x * x - 1.0;
            gradient[0] = 4.0 * x * rest;
            gradient[1] = y;
            rest * rest + 0.5 * y * y
        }
    }

    fn searched(low: [f64; 2], high: [f64; 2]) -> Searched {
        let wells = Wells(Euclidean::new(2));
        let boxed = InBox::new(&low, &high, |x, gradient| {
            assert!((0..2).all(|k| (low[k]..=high[k]).contains(&x[k])), "{x:?}");
            wells.evaluate(x, gradient)
        });
        let shown = Subject {
            name: "wells",
            energy: &wells,
            coordinates: "box".to_owned(),
            low: low.to_vec(),
            high: high.to_vec(),
            source: Source::default(),
        };
        let mut subject = shown.clone();
        subject.energy = &boxed;
        (subject.low, subject.high) = boxed.region();
        let draw = in_box(&subject.low, &subject.high);
        let settings = SearchSettings::measured(&boxed, &draw, 0);
        let search = SurfaceSearch {
            settings: &settings,
            lowest: None,
            known: &[],
            pair: None,
        };
        let run = StudyRun::default();
        let mut found =
            search_surface(&subject, &search, &FamilySettings::default(), &run).unwrap();
        found.shown_as(&|u| boxed.point(u), &shown, &settings);
        found
    }

    /// An unrolled box bends the coordinates: its curvatures are f″ sin².
    #[test]
    fn curvatures_in_a_box_are_those_of_the_surface() {
        let found = searched([-1.1, -1.0], [3.0, 1.0]).found;
        assert_eq!(found.minima.len(), 2);
        for audit in &found.audits {
            approx::assert_abs_diff_eq!(
                audit.curvatures.as_slice(),
                [1.0, 8.0].as_slice(),
                epsilon = 1e-4
            );
        }
        let [saddle] = &found.saddles[..] else {
            panic!("mirror images are no saddles: {:?}", found.saddles)
        };
        approx::assert_abs_diff_eq!(
            saddle.audit.curvatures.as_slice(),
            [-4.0, 1.0].as_slice(),
            epsilon = 1e-4
        );
        let database = Database::from_exploration(&found, None);
        let occupation = Superposition::new(&database).unwrap().occupation(0.3);
        assert!((occupation[0] - 0.5).abs() < 1e-4, "{occupation:?}");
    }

    #[test]
    fn points_on_a_face_have_no_curvatures() {
        // The left well is cut off at its flank, and is a minimum of the face x = −0.9.
        let found = searched([-0.9, -1.0], [3.0, 1.0]).found;
        assert_eq!(found.minima.len(), 2);
        let on_face = |x: &[f64]| (x[0] + 0.9).abs() < 1e-9;
        for (minimum, audit) in found.minima.iter().zip(&found.audits) {
            assert_eq!(on_face(&minimum.coordinates), audit.curvatures.is_empty());
        }
        let database = Database::from_exploration(&found, None);
        assert_eq!(database.vibrational_modes, Some(2));
        let told = Superposition::new(&database).unwrap_err().to_string();
        assert!(
            told.contains("m1 ") && told.contains("face of a box"),
            "{told}"
        );
    }
}
