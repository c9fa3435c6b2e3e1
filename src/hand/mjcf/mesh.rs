//! Mesh assets: file, scale and reference frame.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::super::HandError;
use super::super::mesh::triangles;
use super::super::model::Form;
use super::Reader;
use super::defaults::{Attributes, Defaults};
use super::element::Element;
use super::orientation::quaternion;
use crate::formats::Triangles;

/// A mesh asset, read when the first geom uses it.
pub(super) struct MeshAsset<'a> {
    element: &'a Element,
    form: OnceCell<Form>,
}

/// All meshes by name; a mesh without a name has that of its file.
pub(super) fn list<'a>(
    root: &'a Element,
    defaults: &Defaults<'_>,
) -> Result<BTreeMap<String, MeshAsset<'a>>, HandError> {
    let mut meshes = BTreeMap::new();
    for element in root
        .children_named("asset")
        .flat_map(|asset| asset.children_named("mesh"))
    {
        let attributes = defaults.resolve(element, None)?;
        let name = match (attributes.text("name"), attributes.text("file")) {
            (Some(name), _) => name.to_owned(),
            (None, Some(file)) => stem(file),
            (None, None) => return Err(element.error("a mesh needs a name or a file")),
        };
        let asset = MeshAsset {
            element,
            form: OnceCell::new(),
        };
        if meshes.insert(name.clone(), asset).is_some() {
            return Err(element.error(format!("there are two meshes named \"{name}\"")));
        }
    }
    Ok(meshes)
}

fn stem(file: &str) -> String {
    let stem = Path::new(file).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

impl Reader<'_> {
    /// The mesh that a geom names.
    pub(super) fn mesh(&self, geom: &Element, name: &str) -> Result<Form, HandError> {
        let Some(asset) = self.meshes.get(name) else {
            return Err(geom.error(format!("no mesh is called \"{name}\"")));
        };
        if let Some(form) = asset.form.get() {
            return Ok(form.clone());
        }
        let attributes = self.defaults.resolve(asset.element, None)?;
        let form = self.load(&attributes)?;
        Ok(asset.form.get_or_init(|| form).clone())
    }

    fn load(&self, attributes: &Attributes<'_>) -> Result<Form, HandError> {
        let element = attributes.element();
        let mut mesh = if let Some(text) = attributes.text("vertex") {
            points(element, text, attributes.text("face"))?
        } else {
            let Some(file) = attributes.text("file") else {
                return Err(element.error("a mesh needs a file or vertices"));
            };
            let reference = self.reference(file);
            match self
                .files
                .mesh(&reference)
                .and_then(|text| triangles(text.as_bytes()))
            {
                Ok(mesh) => mesh,
                Err(problem) => {
                    return Ok(Form::Unread(format!("{}: {problem}", element.place())));
                }
            }
        };
        let scale = attributes.exactly::<3>("scale")?.unwrap_or([1.0; 3]);
        if scale.contains(&0.0) {
            return Err(element.error("a scale of 0 leaves nothing"));
        }
        let from = Vector3::from(attributes.exactly::<3>("refpos")?.unwrap_or_default());
        let turn = match attributes.exactly::<4>("refquat")? {
            Some(given) => quaternion(given)
                .ok_or_else(|| element.error("refquat has no direction"))?
                .transpose(),
            None => Matrix3::identity(),
        };
        for vertex in &mut mesh.vertices {
            *vertex = (turn * (*vertex - from)).component_mul(&Vector3::from(scale));
        }
        if scale.iter().product::<f64>() < 0.0 {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(Form::Mesh(Arc::new(mesh)))
    }

    /// The path of a mesh file relative to the description.
    fn reference(&self, file: &str) -> String {
        let file = if self.compiler.strip_path {
            let name = Path::new(file).file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        } else {
            file.to_owned()
        };
        let folder = self.compiler.mesh_folder.trim_end_matches('/');
        if folder.is_empty() || Path::new(&file).is_absolute() {
            file
        } else {
            format!("{folder}/{file}")
        }
    }
}

/// A mesh written out in the description. A mesh without faces only gives its hull.
fn points(element: &Element, vertices: &str, faces: Option<&str>) -> Result<Triangles, HandError> {
    let numbers = element.numbers("vertex", vertices)?;
    let vertices: Vec<Vector3<f64>> = numbers
        .chunks_exact(3)
        .map(Vector3::from_column_slice)
        .collect();
    if vertices.len() < 4 || numbers.len() % 3 != 0 {
        return Err(element.error("vertex: at least four points of three numbers are needed"));
    }
    let indices: Option<Vec<u32>> = faces
        .unwrap_or_default()
        .split_whitespace()
        .map(|word| {
            let index = word.parse().ok();
            index.filter(|&index: &u32| (index as usize) < vertices.len())
        })
        .collect();
    let Some(indices) = indices.filter(|indices| indices.len() % 3 == 0) else {
        return Err(element.error("face: triples of vertex numbers are needed"));
    };
    let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
    Ok(Triangles {
        triangles: triangles.collect(),
        vertices,
    })
}
