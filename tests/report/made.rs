//! A landscape made from the committed grasps without a search, and files of grasps of other hands.

use std::path::Path;

use landscape::energy::Energy;
use landscape::grasp::GraspEnergy;
use landscape::sample::{Task, stream};
use landscape::space::interpolate;
use landscape::store::{
    AtomicFolder, EdgeRow, GraspFile, LandscapeFiles, Manifest, MinimumRow, Overrides, PathPoint,
};
use landscape::study::Origin;
use rand::RngExt;
use serde_json::json;

/// Points of a path, as many as relaxed paths have.
const IMAGES: u32 = 24;

pub(super) fn committed() -> GraspFile {
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet");
    GraspFile::read(data.as_ref(), Overrides::default())
        .unwrap()
        .0
}

/// The poses of `count` minima: committed grasps, then copies of them moved a little.
fn minima(file: &GraspFile, count: usize) -> Vec<MinimumRow> {
    let mut rng = stream(3, Task::Start, 0);
    let rows = (0..count).map(|k| {
        let grasp = &file.grasps[k % file.grasps.len()];
        let mut row = MinimumRow {
            energy: grasp.energy,
            coordinates: grasp.grasp.pose.to_vec(),
            members: vec![k as u64],
            ..MinimumRow::default()
        };
        if k >= file.grasps.len() {
            row.coordinates[..3]
                .iter_mut()
                .for_each(|x| *x += rng.random_range(-1e-3..1e-3));
            row.energy += rng.random_range(0.0..0.05);
        }
        row
    });
    let mut rows: Vec<MinimumRow> = rows.collect();
    rows.sort_by(|a, b| a.energy.total_cmp(&b.energy));
    for (id, row) in rows.iter_mut().enumerate() {
        row.id = id as u64;
    }
    rows
}

/// A landscape of `count` minima in `groups` groups, with a random tree of connections. Up to 1,000 minima, all connections
/// have paths; else only those between groups.
pub(super) fn landscape(count: usize, groups: usize, folder: &Path) {
    let file = committed();
    let population = &file.landscapes()[0];
    let energy = population.energy().unwrap();
    let mut minima = minima(&file, count);
    let mut rng = stream(4, Task::Start, 0);
    let (mut edges, mut paths) = (Vec::new(), Vec::new());
    for k in 0..count {
        if k < groups {
            minima[k].group = k as u64;
        }
        if k == 0 {
            continue;
        }
        let other = rng.random_range(0..k.min(if k < groups { k } else { 4 * groups }));
        if k >= groups {
            minima[k].group = minima[other].group;
        }
        let height = minima[k].energy + rng.random_range(0.01..0.2);
        let (a, b) = (other as u64, k as u64);
        edges.push(EdgeRow {
            a,
            b,
            height: Some(height),
            relative_barrier: Some(height - minima[k].energy),
            length: Some(0.1),
            evidence: ["saddle", "path", "chain"][k % 3].to_owned(),
            way: Some(["sliding", "regrasping"][k % 2].to_owned()),
            ..EdgeRow::default()
        });
        if count <= 1000 || minima[k].group != minima[other].group {
            paths.extend(path(&energy, &minima[other], &minima[k]));
        }
    }
    let manifest = manifest(&file, &energy, [count, groups]);
    let files = LandscapeFiles {
        manifest,
        minima,
        edges,
        paths,
    };
    let folder = AtomicFolder::open(folder, true).unwrap();
    files.write(&folder).unwrap();
    folder.finish().unwrap();
}

/// Changes the tables of a landscape.
pub(super) fn changed(folder: &Path, change: impl FnOnce(&mut LandscapeFiles)) {
    let mut files = LandscapeFiles::read(folder).unwrap();
    change(&mut files);
    let folder = AtomicFolder::open(folder, true).unwrap();
    files.write(&folder).unwrap();
    folder.finish().unwrap();
}

fn path(energy: &GraspEnergy, from: &MinimumRow, to: &MinimumRow) -> Vec<PathPoint> {
    let point = |image: u32| PathPoint {
        a: from.id,
        b: to.id,
        image: u64::from(image),
        coordinates: interpolate(
            energy.space(),
            &from.coordinates,
            &to.coordinates,
            f64::from(image) / f64::from(IMAGES - 1),
        ),
        energy: from.energy.max(to.energy),
        ..PathPoint::default()
    };
    (0..IMAGES).map(point).collect()
}

fn manifest(file: &GraspFile, energy: &GraspEnergy, [count, groups]: [usize; 2]) -> Manifest {
    let mut manifest = Manifest {
        program_version: "0.0.0".to_owned(),
        command: "made by a test".to_owned(),
        hand: Some(file.metadata.hands[0].clone()),
        object: Some(file.metadata.objects[0].clone()),
        scale: 1.0,
        energy: file.metadata.energy.clone(),
        settings: json!({ "sameness": { "distance": 0.001 } }),
        terms: energy.term_names(),
        group_barrier: Some(0.05),
        ..Manifest::default()
    };
    manifest.counts.grasps = count as u64;
    manifest.counts.minima = count as u64;
    manifest.counts.groups = groups as u64;
    manifest
}

/// A file with one grasp of a hand on a ball.
pub(super) fn grasp_of(origin: &Origin, path: &Path) -> GraspFile {
    let settings = landscape::study::PopulationSettings::default();
    let energy = origin.energy(&settings).unwrap();
    let hand = energy.hand();
    let mut row = committed().grasps[0].clone();
    row.id = 0;
    row.hand.clone_from(&origin.hand.name);
    row.object.clone_from(&origin.object.name);
    row.grasp = landscape::grasp::Grasp::new(hand.rest_coordinates(), Vec::new());
    row.measure(&energy);
    let file = GraspFile {
        metadata: origin.metadata(&energy, &settings).unwrap(),
        grasps: vec![row],
    };
    file.write(path).unwrap();
    file
}
