//! Labels of minima by the taxonomy for pictures, and rendered examples.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::drawing::Drawing;
use super::error::StudyError;
use super::looks;
use super::names::{GraspSetting, MinimumName};
use crate::evaluation::taxonomy::Rule;
use crate::figure::{Leaf, PICTURE_DENSITY, Picture, Scene, leaves_of_families, side_in_row};
use crate::grasp::Grasp;
use crate::store::{LandscapeFiles, MinimumRow};
use crate::topography::MinimumId;

/// Differences between grasp types that colours show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colouring {
    /// Power, intermediate, precision.
    Category,
    /// The type; of a grasp that several types fit about equally, the cell or the category.
    Type,
}

impl Colouring {
    /// Legend text for a grasp of this name.
    fn label(self, named: &MinimumName) -> &str {
        match (self, named.category) {
            (Self::Type, _) => named.text(),
            (Self::Category, Some(category)) => category.name(),
            (Self::Category, None) => "unlisted",
        }
    }
}

fn in_two(name: &str) -> Vec<String> {
    const SHORT: usize = 14;
    let ends = name.match_indices([' ', '/']).map(|(place, _)| place + 1);
    let middle = ends.min_by_key(|&end| name.len().abs_diff(2 * end));
    match middle.filter(|_| name.len() > SHORT) {
        Some(end) => vec![name[..end].trim_end().to_owned(), name[end..].to_owned()],
        None => vec![name.to_owned()],
    }
}

/// The names of a landscape's minima, for pictures.
#[derive(Debug)]
pub struct MinimumNames {
    setting: GraspSetting,
    names: Vec<MinimumName>,
}

impl MinimumNames {
    /// Names the minima by the standard rule; labels in the landscape override it. `name` is its name in errors.
    ///
    /// # Errors
    /// Those of [`GraspSetting::of`].
    pub fn of(files: &LandscapeFiles, name: &str) -> Result<Self, StudyError> {
        let setting = GraspSetting::of(files, name)?;
        let names = setting.names(files, Rule::standard());
        Ok(Self { setting, names })
    }

    /// Legend text of each minimum.
    pub fn labels(&self, colouring: Colouring) -> Vec<String> {
        let label = |named| colouring.label(named).to_owned();
        self.names.iter().map(label).collect()
    }

    /// At most `count` rendered minima: first one of each category, then of each type, then of the largest families, always
    /// from the families with most grasps. No two are of one family, and each has the label with which its family is drawn.
    ///
    /// # Panics
    /// If there is not one family and one leaf for each minimum.
    pub fn examples(
        &self,
        files: &LandscapeFiles,
        (family_of, leaves): (&[usize], &[Leaf]),
        count: usize,
    ) -> Vec<(MinimumId, Picture)> {
        let mut order = order(&files.minima, family_of);
        let drawn = leaves_of_families(leaves, family_of);
        order.retain(|&minimum| leaves[minimum].label == drawn[family_of[minimum]].label);
        let chosen = self.chosen(&order, family_of, count);
        let side = side_in_row(Drawing::WIDTH, chosen.len()) * PICTURE_DENSITY;
        let skin = self.setting.hand.skin();
        let key = looks::key();
        let picture = |&minimum: &usize| {
            let row = &files.minima[minimum];
            let grasp = Grasp::new(row.coordinates.clone(), Vec::new());
            let scene = Scene::of_grasp(&self.setting.hand, &skin, &self.setting.object, &grasp);
            let camera = scene.closer_camera(Vector3::z());
            let named = &self.names[minimum];
            let label = Colouring::Category.label(named);
            let picture = Picture {
                image: scene.render(&camera, side, side),
                texts: [in_two(named.text()), vec![format!("m{}", row.id)]].concat(),
                look: key.look(label),
                of: None,
            };
            (MinimumId(minimum), picture)
        };
        chosen.par_iter().map(picture).collect()
    }

    /// The first `count` of `order` by category, then by type, then any, with no two of one family.
    fn chosen(&self, order: &[usize], family_of: &[usize], count: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        let categories: [fn(&MinimumName, &MinimumName) -> bool; 3] = [
            |a, b| a.category == b.category,
            |a, b| a.text() == b.text(),
            |_, _| false,
        ];
        for same in categories {
            for &minimum in order {
                let known = |&other: &usize| {
                    family_of[other] == family_of[minimum]
                        || same(&self.names[other], &self.names[minimum])
                };
                if chosen.len() < count && !chosen.iter().any(known) {
                    chosen.push(minimum);
                }
            }
        }
        chosen
    }
}

/// The minima sorted by the number of grasps of their family and then their own, most first.
fn order(minima: &[MinimumRow], family_of: &[usize]) -> Vec<usize> {
    let families = family_of.iter().max().map_or(0, |most| most + 1);
    let mut grasps = vec![0; families];
    for (row, &family) in minima.iter().zip(family_of) {
        grasps[family] += row.members.len();
    }
    let mut order: Vec<usize> = (0..minima.len()).collect();
    order.sort_by_key(|&minimum| {
        let weight = (grasps[family_of[minimum]], minima[minimum].members.len());
        (std::cmp::Reverse(weight), minimum)
    });
    order
}
