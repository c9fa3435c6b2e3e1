//! Builds a hand from its description.

use nalgebra::Vector3;

use super::files::HandFiles;
use super::geometry::Geometry;
use super::model::{Model, check_count, subtree_ends};
use super::side_file::{SideFile, untouching};
use super::solid::Parts;
use super::sources::Files;
use super::{
    Hand, HandError, PalmFrame, PosedHand, mano, plausibility, prior, region, roles, self_pairs,
    surface,
};

/// The hand of some files; `others` provides the files that they refer to.
pub(super) fn read(files: &HandFiles, others: &dyn Files) -> Result<Hand, HandError> {
    let side = files.side()?;
    let hand = match files.mano() {
        Some(reference) => mano::assemble(&reference.read()?, &side)?,
        None => assemble(&files.model(others)?, &side)?,
    };
    Ok(if side.mirror { hand.mirrored() } else { hand })
}

fn assemble(model: &Model, side: &SideFile) -> Result<Hand, HandError> {
    let (mut links, joints) = model.tree()?;
    let mut notes = model.notes.clone();
    let geometry = Geometry::of(model, side, &links, &mut notes)?;
    let digits = region::assign_digits(&mut links, &geometry.capsules, side)?;
    let palm_link = region::palm_link(&links);
    let (rest, cast) = prior::poses(&joints, side)?;
    let prior = prior::gaussian(rest, &joints, side)?;

    let mut hand = Hand {
        name: side.name.clone().unwrap_or_else(|| model.name.clone()),
        subtree_ends: subtree_ends(&links),
        link_points: vec![0..0; links.len()],
        untouching: untouching(&links, side)?,
        palm_link,
        links,
        joints,
        capsules: geometry.capsules,
        self_pairs: Vec::new(),
        surface: Vec::new(),
        digits,
        regions: Vec::new(),
        prior,
        palm: PalmFrame {
            centre: Vector3::zeros(),
            volar: Vector3::z(),
            distal: Vector3::y(),
            faced_m: 0.0,
        },
        notes,
        virtual_wrist: model.virtual_wrist.clone(),
        cast,
        meshes: geometry.meshes,
        parts: Parts::default(),
        inscribed: super::inscribed::Cache::default(),
        exact: geometry.exact,
        metric: side.metric.clone(),
        blend: None,
    };
    let mut rest = PosedHand::default();
    hand.pose(&hand.rest_coordinates(), &mut rest);
    if side.digits.is_none() {
        roles::name_digits(&mut hand);
    }
    plausibility::judge_shape(&mut hand, &rest)?;
    hand.self_pairs = self_pairs::derive(&hand, &rest, &self_pairs::apart(&hand, model, side)?);
    let points = side.surface_points.unwrap_or(surface::POINTS);
    if points == 0 {
        return Err(HandError::NotPositive {
            what: "surface_points of the side file".to_owned(),
            value: 0.0,
        });
    }
    let advice = "ask for fewer in the side file";
    check_count("surface points", points, surface::MOST_POINTS, advice)?;
    hand.surface = surface::sample(&hand, &rest, &geometry.hulls, points);
    hand.index_surface();
    hand.pose(&hand.rest_coordinates(), &mut rest);
    region::tag(&mut hand, &rest, side)?;
    hand.palm = match &side.palm {
        Some(palm) => region::palm_frame(palm)?,
        None => roles::palm_frame(&hand),
    };
    hand.check_metric()?;
    Ok(hand)
}
