//! Pictures of a minimax path: energy by term along it with rendered grasps below, and an animation.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::minimax_path::{MinimaxPath, Waypoint};
use crate::figure::chart::{Axis, Chart, Mark, Panel, Series};
use crate::figure::{
    Anchor, Canvas, FigureError, PICTURE_DENSITY, Picture, Scene, Surface, draw_row, row_height,
    side_in_row, theme,
};
use crate::grasp::{Grasp, GraspEnergy};
use crate::hand::PosedHand;

/// Width of the strip, canvas units.
const WIDTH: u32 = 1600;
/// Terms that never reach this fraction of the highest one are not drawn.
const LEAST_SHARE: f64 = 0.02;
/// Duration of the animation, seconds per centimetre, and its least duration.
const SECONDS_PER_CM: f64 = 0.25;
const LEAST_SECONDS: f64 = 3.0;

impl MinimaxPath {
    /// Picture of the energy by term along an [explained](MinimaxPath::explained) path, with a number of rendered points
    /// below it, including the highest point.
    ///
    /// # Errors
    /// If an energy is not finite.
    ///
    /// # Panics
    /// If the path has no points or is not explained, or fewer than two pictures are asked for.
    pub fn strip(&self, energy: &GraspEnergy, pictures: usize) -> Result<Canvas, FigureError> {
        let shown = self.shown(pictures);
        let most = self.most();
        let panel = Panel::new(
            "",
            Axis::linear("way of the hand's surface (mm)"),
            // Space for the numbers above the curves.
            Axis::linear("energy and its terms").with_range(0.0, 1.2 * most),
            self.series(energy, &shown),
        );
        let chart = Chart {
            // Inside the panel the legend would hide numbers.
            legend_below: true,
            panel_size: [WIDTH - 44, 620],
            ..Chart::new("", vec![panel])
        };
        let graph = chart.draw()?;
        let side = side_in_row(WIDTH, shown.len());
        let height = graph.height();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a length on a sheet"
        )]
        let below = row_height(side, 2).ceil() as u32;
        let mut canvas = graph.with_room_below(below);
        draw_row(
            &mut canvas,
            height - 60.0,
            &self.rendered(energy, &shown, side),
        );
        Ok(canvas)
    }

    /// The highest energy, at least 0.
    fn most(&self) -> f64 {
        let energies = self.points.iter().map(|step| step.point.energy);
        energies.fold(0.0, f64::max)
    }

    /// The curves of the energy and its terms, with marks at the points that are `shown`.
    fn series(&self, energy: &GraspEnergy, shown: &[usize]) -> Vec<Series> {
        let (steps, most) = (&self.points, self.most());
        let names = energy.term_names();
        let lines = |of: &dyn Fn(&Waypoint) -> f64| -> Vec<[f64; 2]> {
            steps
                .iter()
                .map(|step| [millimetres(step), of(step)])
                .collect()
        };
        let mut series: Vec<Series> = shown
            .iter()
            .map(|&place| {
                Series::new(Mark::Vertical(millimetres(&steps[place]))).coloured(theme::FAINT)
            })
            .collect();
        let mut colour = 0;
        for (term, name) in names.iter().enumerate() {
            let highest = steps
                .iter()
                .map(|step| step.terms()[term])
                .fold(0.0, f64::max);
            if highest >= LEAST_SHARE * most {
                let line = Series::line(lines(&|step| step.terms()[term]));
                series.push(line.named(name).coloured(theme::series(colour)));
                colour += 1;
            }
        }
        let total = Series::line(lines(&|step| step.point.energy));
        series.push(Series {
            width: 5.0,
            ..total.named("energy").coloured(theme::INK)
        });
        for (number, &place) in shown.iter().enumerate() {
            let step = &steps[place];
            let points = vec![[millimetres(step), step.point.energy]];
            series.push(Series::points(points).coloured(theme::INK));
            series.push(Series::new(Mark::Text {
                // The marks are above all curves.
                at: [millimetres(step), 1.07 * most],
                text: (number + 1).to_string(),
                anchor: Anchor::Middle,
            }));
        }
        series
    }

    /// Evenly spaced points along the path, including the highest one.
    fn shown(&self, count: usize) -> Vec<usize> {
        let steps = &self.points;
        let length = steps.last().map_or(0.0, |step| step.along_m);
        let nearest = |place: f64| {
            let apart = |i: &usize| (steps[*i].along_m - place).abs();
            (0..steps.len())
                .min_by(|a, b| apart(a).total_cmp(&apart(b)))
                .unwrap_or(0)
        };
        let mut shown: Vec<usize> = (0..count)
            .map(|k| nearest(length * k as f64 / (count - 1) as f64))
            .collect();
        let top = self.top();
        let inner = 1..count - 1;
        let closest = inner.min_by_key(|&k| shown[k].abs_diff(top));
        if let Some(closest) = closest {
            shown[closest] = top;
        }
        shown.sort_unstable();
        shown.dedup();
        shown
    }

    /// Scenes of the points from one side, in which only the hand moves.
    fn rendered(&self, energy: &GraspEnergy, shown: &[usize], side: u32) -> Vec<Picture> {
        let steps = &self.points;
        let (hand, object) = (energy.hand(), energy.object());
        let skin = hand.skin();
        let scene = |place: usize| {
            let step = &steps[place];
            let grasp = Grasp::new(step.point.coordinates.clone(), step.contacts.clone());
            Scene::of_grasp(hand, &skin, object, &grasp)
        };
        let middle = scene(shown[shown.len() / 2]);
        let toward_eye = middle.best_camera(Vector3::z()).toward_eye();
        let all = Scene {
            surfaces: shown
                .iter()
                .filter_map(|&place| scene(place).surfaces.into_iter().next())
                .collect(),
            ..Scene::default()
        };
        let camera = all.framed(toward_eye, Vector3::z());
        let highest = self.top();
        let picture = |(number, &place): (usize, &usize)| {
            let said = if place == highest { "top, " } else { "" };
            let step = &steps[place];
            Picture {
                image: scene(place).render(&camera, side * PICTURE_DENSITY, side * PICTURE_DENSITY),
                texts: vec![
                    format!("{}", number + 1),
                    format!("{said}E {:.2}", step.point.energy),
                ],
                look: None,
                of: None,
            }
        };
        shown.par_iter().enumerate().map(picture).collect()
    }

    /// An animation of the hand moving along the path over the fixed object, as a binary glTF scene.
    ///
    /// # Panics
    /// If the path has no points.
    pub fn animation(&self, energy: &GraspEnergy) -> Vec<u8> {
        let steps = &self.points;
        let hand = energy.hand();
        let skin = hand.skin();
        let mut posed = PosedHand::default();
        let frames: Vec<Vec<Vector3<f64>>> = steps
            .iter()
            .map(|step| {
                hand.pose(&step.point.coordinates, &mut posed);
                skin.pose(&posed)
            })
            .collect();
        hand.pose(&steps[0].point.coordinates, &mut posed);
        let scene = Scene {
            surfaces: vec![
                Surface::of_hand(&skin, &posed),
                Surface::of_mesh(&energy.object().mesh),
            ],
            ..Scene::default()
        };
        let length = steps.last().map_or(0.0, |step| step.along_m);
        let seconds = (1e2 * length * SECONDS_PER_CM).max(LEAST_SECONDS);
        let times: Vec<f64> = steps
            .iter()
            .map(|step| seconds * step.along_m / length.max(f64::MIN_POSITIVE))
            .collect();
        scene.to_animated_glb(&times, &frames)
    }
}

fn millimetres(step: &Waypoint) -> f64 {
    1e3 * step.along_m
}
