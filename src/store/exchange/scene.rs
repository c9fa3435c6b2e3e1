//! Where the object of a dictionary of `DexGraspBench`, `BODex` or Dexonomy stands, and how large it is.
//!
//! | told by | pose and scale of the object |
//! | --- | --- |
//! | `obj_pose`, `obj_scale` | flat files |
//! | `scene_cfg` | Dexonomy: the scene is nested in the file; `task.obj_name` or `interest_obj_name` names its object |
//! | `world_cfg`, `manip_name` | `BODex`: one world for each scene |
//! | `scene_path` | the scene is a file of its own |
//!
//! What comes first in this table is used. `scene_scale` holds a factor for each grasp on the scale of a scene.

use std::path::{Path, PathBuf};

use nalgebra::Isometry3;

use super::dexgraspbench::isometry;
use super::{bytes, finite};
use crate::formats::npy;
use crate::formats::pickle::{Heap, Id, Node};

/// Largest relative difference between the scales of three axes.
const SAME_SCALE: f64 = 1e-6;

/// How the object of some grasps stands in their world.
#[derive(Debug, Default)]
pub(super) struct Stand {
    /// The pose of the object; `None` if the file tells none, which is the origin.
    pub(super) pose_of_object: Option<Isometry3<f64>>,
    /// One scale for all grasps, or one for each; not empty.
    pub(super) scales: Option<Vec<f64>>,
    /// Name or path of the object.
    pub(super) object: Option<String>,
    /// What is assumed.
    pub(super) notes: Vec<String>,
}

/// An object of a scene.
#[derive(Debug, Default)]
struct InScene {
    name: Option<String>,
    pose: Option<Isometry3<f64>>,
    scale: Option<f64>,
}

/// Reads how the object of the dictionary `item` stands, which holds `count` grasps and comes from the file `path`.
pub(super) fn stand(heap: &Heap, item: Id, count: usize, path: &Path) -> Result<Stand, String> {
    let mut notes = Vec::new();
    let flat = InScene {
        name: text(heap, item, "obj_path"),
        pose: pose(heap, item, "obj_pose")?,
        scale: scale(heap, item, "obj_scale")?,
    };
    let in_scene = if flat.pose.is_some() && flat.scale.is_some() {
        InScene::default()
    } else {
        in_scene(heap, item, path, &mut notes)?
    };
    let scales = match (flat.scale, in_scene.scale) {
        (Some(scale), _) => Some(vec![scale]),
        (None, Some(scale)) => Some(match factors(heap, item, count)? {
            Some(factors) => factors.iter().map(|factor| factor * scale).collect(),
            None => vec![scale],
        }),
        (None, None) => None,
    };
    Ok(Stand {
        pose_of_object: flat.pose.or(in_scene.pose),
        scales,
        object: flat.name.or(in_scene.name),
        notes,
    })
}

/// The object in the scene that the dictionary holds or names.
fn in_scene(
    heap: &Heap,
    item: Id,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<InScene, String> {
    if let Some(scene) = heap.entry(item, "scene_cfg") {
        return of_scene(heap, scene, "`scene_cfg`");
    }
    if let Some(world) = heap.entry(item, "world_cfg") {
        return of_world(heap, item, world);
    }
    let Some(named) = text(heap, item, "scene_path") else {
        return Ok(InScene::default());
    };
    let Some(file) = beside(path, &named) else {
        notes.push(format!(
            "the scene {named}, with the place and scale of the object, is missing: the object is taken to stand at the \
             origin, with the scale of --scale (default 1). Put the scene under this path next to the grasps or into a folder \
             above them"
        ));
        return Ok(InScene::default());
    };
    let what = format!("the scene {}", file.display());
    let content = bytes(&file).map_err(|error| error.to_string())?;
    let content = npy::read(&content).map_err(|problem| format!("{what}: {problem}"))?;
    let npy::Content::Objects(heap, whole) = content else {
        return Err(format!(
            "{what} contains numbers where a dictionary is needed"
        ));
    };
    let scene = match heap.node(whole) {
        Node::Objects(items) => items.first().copied().unwrap_or(whole),
        _ => whole,
    };
    of_scene(&heap, scene, &what)
}

/// The file that a dictionary in `path` names: absolute, or relative to the folder of `path` or one above it.
fn beside(path: &Path, named: &str) -> Option<PathBuf> {
    // The folders above a relative path are those above the current folder.
    let path = std::path::absolute(path).ok()?;
    let folder = path.parent()?;
    let folders = folder.ancestors().map(|folder| folder.join(named));
    folders.into_iter().find(|file| file.is_file())
}

/// The object that a scene is about: the one that it names, or its only rigid object.
fn of_scene(heap: &Heap, scene: Id, what: &str) -> Result<InScene, String> {
    let objects = heap
        .entry(scene, "scene")
        .ok_or_else(|| format!("{what} has no `scene` with objects"))?;
    let named = heap
        .entry(scene, "task")
        .and_then(|task| text(heap, task, "obj_name"))
        .or_else(|| text(heap, scene, "interest_obj_name"));
    let (name, object) = match named {
        Some(name) => {
            let object = heap.entry(objects, &name);
            let missing = || format!("{what} has no object `{name}`, although it names it");
            let object = object.ok_or_else(missing)?;
            (name, object)
        }
        None => only(heap, objects, |object| {
            text(heap, object, "type").as_deref() == Some("rigid_object")
        })
        .ok_or_else(|| {
            format!(
                "{what} names no object (`task.obj_name`), and has not exactly one rigid object"
            )
        })?,
    };
    object_of(heap, object, name)
}

/// The mesh of a world of `BODex` that its grasps are about.
fn of_world(heap: &Heap, item: Id, world: Id) -> Result<InScene, String> {
    let first = |id: Id| match heap.node(id) {
        Node::List(items) | Node::Objects(items) => items.first().copied(),
        _ => Some(id),
    };
    let meshes = first(world)
        .and_then(|world| heap.entry(world, "mesh"))
        .ok_or("its `world_cfg` has no `mesh`")?;
    let named = heap
        .entry(item, "manip_name")
        .and_then(first)
        .and_then(|name| match heap.node(name) {
            Node::Text(name) => Some(name.clone()),
            _ => None,
        });
    let named = named.and_then(|name| Some((name.clone(), heap.entry(meshes, &name)?)));
    let (name, object) = named.or_else(|| only(heap, meshes, |_| true)).ok_or(
        "its `world_cfg` has several meshes, and `manip_name` does not name the one that is grasped",
    )?;
    object_of(heap, object, name)
}

/// The only entry of a dictionary whose value passes.
fn only(heap: &Heap, dictionary: Id, passes: impl Fn(Id) -> bool) -> Option<(String, Id)> {
    let Node::Dictionary(entries) = heap.node(dictionary) else {
        return None;
    };
    let mut passing = entries.iter().filter(|(_, value)| passes(*value));
    let (key, value) = passing.next()?;
    match (heap.node(*key), passing.next()) {
        (Node::Text(name), None) => Some((name.clone(), *value)),
        _ => None,
    }
}

fn object_of(heap: &Heap, object: Id, name: String) -> Result<InScene, String> {
    let of = |problem: String| format!("object `{name}` of its scene: {problem}");
    Ok(InScene {
        pose: pose(heap, object, "pose").map_err(of)?,
        scale: scale(heap, object, "scale").map_err(of)?,
        name: Some(name),
    })
}

fn text(heap: &Heap, item: Id, key: &str) -> Option<String> {
    let mut value = heap.entry(item, key)?;
    // BODex stores a list of one path for each scene.
    if let Node::List(items) | Node::Objects(items) = heap.node(value)
        && let [only] = items[..]
    {
        value = only;
    }
    match heap.node(value) {
        Node::Text(text) => Some(text.clone()),
        _ => None,
    }
}

fn pose(heap: &Heap, item: Id, key: &str) -> Result<Option<Isometry3<f64>>, String> {
    let Some(pose) = heap.entry(item, key) else {
        return Ok(None);
    };
    let pose = heap
        .few(pose, 7)
        .ok_or_else(|| format!("its `{key}` is not an array of 7 numbers"))?;
    isometry(&pose, &format!("`{key}`")).map(Some)
}

/// One number, or three equal ones.
fn scale(heap: &Heap, item: Id, key: &str) -> Result<Option<f64>, String> {
    let Some(scale) = heap.entry(item, key) else {
        return Ok(None);
    };
    let scales = heap
        .few(scale, 3)
        .ok_or_else(|| format!("its `{key}` is neither one number nor three"))?;
    finite(&scales, &format!("`{key}`"))?;
    let first = *scales
        .first()
        .ok_or_else(|| format!("its `{key}` is empty"))?;
    if (scales.iter()).any(|other| (other - first).abs() > SAME_SCALE * first.abs()) {
        return Err(format!(
            "its `{key}` differs between axes, which is not supported"
        ));
    }
    Ok(Some(first))
}

/// The factors of `scene_scale`: one for all grasps, or one for each.
fn factors(heap: &Heap, item: Id, count: usize) -> Result<Option<Vec<f64>>, String> {
    let Some(factors) = heap.entry(item, "scene_scale") else {
        return Ok(None);
    };
    let factors = heap
        .numbers(factors)
        .ok_or("its `scene_scale` is not an array of numbers")?
        .values;
    finite(&factors, "`scene_scale`")?;
    if factors.is_empty() || (factors.len() != 1 && factors.len() != count) {
        return Err(format!(
            "its `scene_scale` has {} numbers for {count} grasps",
            factors.len()
        ));
    }
    Ok(Some(factors))
}
