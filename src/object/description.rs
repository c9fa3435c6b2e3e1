//! Objects to be grasped: mesh, smooth shape and description file.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Rotation3, Unit, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::Symmetry;

use super::{
    Assembly, Capsule, Cuboid, Cylinder, Field, FieldSettings, ObjectError, Revolved, Shape,
    Sphere, within,
};
use crate::limits::{DIRECTION, GRASP_POSITION, MOST_MOTIONS, OBJECT_MASS};
use crate::mesh::{ExactMesh, Mesh, MeshError, SignedDistance, SurfaceSample};

/// Density of an object whose mass is not given, kg/m³: half that of water, as for wood or a half-full bottle.
const DEFAULT_DENSITY_KG_M3: f64 = 500.0;

/// Quaternions of symmetries that are farther than this from unit length are refused. Smaller deviations come from rounding
/// in print.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Number of points on the object's surface.
const SURFACE_SAMPLES: usize = 2_000;

/// Number of samples that tell how thin an object is: about one per square centimetre on a bottle.
const THICKNESS_SAMPLES: usize = 384;

/// The object is thin where it is thinner than this, about a finger, metres.
const THIN_M: f64 = 0.015;

/// Shortest step of the search for the opposite side of the object, metres.
const THICKNESS_STEP_M: f64 = 2.5e-4;

/// Properties of an object that are not in its mesh. They come from the file beside the mesh with the ending `.json`. All
/// fields are optional.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Description {
    /// Name. Default: the name of the mesh file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Mass. Default: that of the volume at 500 kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Motions that map the object onto itself. They are checked against the mesh.
    pub symmetry: Symmetry,
    /// A formula for the shape, used instead of a baked field. It is checked against the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub primitive: Option<Primitive>,
    /// Formulae of the parts, if the mesh is a union of meshes of primitives. Inside tests are faster with them than with
    /// the mesh. They are checked against the mesh.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Primitive>,
}

/// A shape given by a formula.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Primitive {
    /// A ball.
    Sphere(Sphere),
    /// A box.
    Cuboid(Cuboid),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A capsule.
    Capsule(Capsule),
}

impl Primitive {
    pub(super) fn shape(self) -> Arc<dyn Shape> {
        match self {
            Self::Sphere(shape) => Arc::new(shape),
            Self::Cuboid(shape) => Arc::new(shape),
            Self::Cylinder(shape) => Arc::new(shape),
            Self::Capsule(shape) => Arc::new(shape),
        }
    }
}

/// A rigid object to be grasped. Its frame is that of its mesh.
///
/// # Examples
/// An object that comes with the program, and the distance of a point from its surface.
///
/// ```
/// use landscape::object::Object;
/// use nalgebra::Vector3;
///
/// let ball = Object::named("ball")?;
/// let distance_m = ball.shape.distance(&(ball.centroid + Vector3::new(0.1, 0.0, 0.0)));
/// assert!((distance_m - 0.065).abs() < 1e-6);
/// # Ok::<(), landscape::object::ObjectError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Object {
    /// Name.
    pub name: String,
    /// Surface.
    pub mesh: Mesh,
    /// Exact distances to the surface, used for decisions.
    pub exact: ExactMesh,
    /// Smooth distances, used in energies.
    pub shape: Arc<dyn Shape>,
    /// Accuracy of the baked field; `None` if the shape is a formula.
    pub field_report: Option<super::FieldReport>,
    /// Centroid of the volume, metres.
    pub centroid: Vector3<f64>,
    /// Largest distance of a vertex from the centroid, metres.
    pub radius_m: f64,
    /// Motions that map the object onto itself.
    pub symmetry: Symmetry,
    /// Mass.
    pub mass_kg: f64,
    /// The description that it was made with.
    pub description: Description,
    /// Points spread evenly over the surface. Each prefix of the list is evenly spread too.
    pub surface_samples: Vec<SurfaceSample>,
    /// Share of the surface where the object is thinner than a finger (15 mm): 1 for a bowl, 0 for a solid bottle.
    pub thin_share: f64,
    /// Notes for the user, such as repairs of the mesh or a doubtful size; one sentence each.
    pub notes: Vec<String>,
}

/// The parts that an object is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectParts {
    /// Name.
    pub name: String,
    /// Surface.
    pub mesh: Mesh,
    /// Changes to the mesh, one sentence each.
    pub notes: Vec<String>,
    /// Properties that are not in the mesh.
    pub description: Description,
}

impl Object {
    /// Reads a mesh (OBJ, STL, PLY or glTF, metres) and the description beside it, if there is one.
    ///
    /// # Errors
    /// If a file cannot be read or is invalid, or if the description does not fit the mesh.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ObjectError> {
        let parts = Self::parts_of_file(path.as_ref(), None)?;
        let mut object = Self::from_mesh(&parts.name, parts.mesh, &parts.description)?;
        object.notes.splice(0..0, parts.notes);
        Ok(object)
    }

    /// Reads a TOML file of shapes ([`Assembly`]), or a mesh (OBJ, STL, PLY or glTF, in any unit) with the description
    /// beside it, if there is one. Nothing is baked. With a `thickness`, in the unit of the mesh, its open surfaces become
    /// walls ([`Mesh::thickened`]).
    ///
    /// # Errors
    /// If a file cannot be read or is invalid, or if nothing can be thickened.
    pub fn parts_of_file(path: &Path, thickness: Option<f64>) -> Result<ObjectParts, ObjectError> {
        if (path.extension()).is_some_and(|kind| kind.eq_ignore_ascii_case("toml")) {
            if thickness.is_some() {
                return Err(MeshError::Closed(path.display().to_string()).into());
            }
            return Assembly::read(path);
        }
        let repaired = match thickness {
            Some(thickness) => Mesh::read_thickened(path, thickness)?,
            None => Mesh::read(path, 1.0)?,
        };
        let beside = path.with_extension("json");
        let description = match fs::read_to_string(&beside) {
            Ok(text) => Description::from_json(&beside.display().to_string(), &text)?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Description::default(),
            Err(source) => {
                return Err(ObjectError::Read {
                    path: beside,
                    source,
                });
            }
        };
        let stem = path
            .file_stem()
            .unwrap_or(path.as_os_str())
            .to_string_lossy();
        let name = description
            .name
            .clone()
            .unwrap_or_else(|| stem.into_owned());
        // Notes are stored with grasps, and files record names of files only.
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let note = |repair: &crate::mesh::Repair| format!("{file}: {repair}");
        Ok(ObjectParts {
            name,
            notes: repaired.repairs.iter().map(note).collect(),
            mesh: repaired.mesh,
            description,
        })
    }

    /// Makes an object from a mesh. Its field is baked or comes from the user's cache folder.
    ///
    /// # Errors
    /// If the description has an impossible value or does not fit the mesh, or if the size cannot be metres.
    pub fn from_mesh(
        name: &str,
        mesh: Mesh,
        description: &Description,
    ) -> Result<Self, ObjectError> {
        description.validate(name)?;
        mesh.check_size(name)?;
        let exact = ExactMesh::new(&mesh);
        let radius_m = mesh.radius_m();
        let fit = Fit {
            name,
            mesh: &mesh,
            exact: &exact,
            tolerance_m: tolerance_m(radius_m),
        };
        fit.symmetry(&description.symmetry)?;
        fit.parts(&description.parts)?;
        let surface_samples = mesh.sample_surface(SURFACE_SAMPLES, 0);
        let (shape, field_report) = if let Some(primitive) = description.primitive {
            let shape = primitive.shape();
            fit.primitive(&*shape, &surface_samples)?;
            (shape, None)
        } else if let Symmetry::Axis { point, direction } = &description.symmetry {
            let field = Revolved::bake(&mesh, &exact, point, direction);
            let report = *field.report();
            (Arc::new(field) as Arc<dyn Shape>, Some(report))
        } else {
            let field = Field::cached(&mesh, &exact, &FieldSettings::default());
            let report = *field.report();
            (Arc::new(field) as Arc<dyn Shape>, Some(report))
        };
        Ok(Self {
            name: name.to_owned(),
            field_report,
            centroid: mesh.centroid(),
            radius_m,
            symmetry: description.symmetry.clone(),
            mass_kg: description.mass_of(&mesh),
            notes: size_note(name, &mesh).into_iter().collect(),
            description: description.clone(),
            thin_share: thin_share(&surface_samples[..THICKNESS_SAMPLES], &*shape),
            surface_samples,
            shape,
            exact,
            mesh,
        })
    }

    /// Largest accepted deviation of the surface from a declared symmetry or formula, metres. It is 1 % of the radius, but
    /// at least half a millimetre.
    pub fn tolerance_m(&self) -> f64 {
        tolerance_m(self.radius_m)
    }
}

fn tolerance_m(radius_m: f64) -> f64 {
    (0.01 * radius_m).max(0.5e-3)
}

/// A note if the unit of a mesh is doubtful.
fn size_note(name: &str, mesh: &Mesh) -> Option<String> {
    /// Hands hold nothing larger, and fingertips nothing smaller.
    const USUAL_M: [f64; 2] = [0.01, 0.5];
    let size_m = mesh.size_m();
    if size_m > USUAL_M[1] {
        Some(format!(
            "{name} is {size_m:.2} m across, too large for a hand; if the mesh is not in metres, pass --scale (such as --scale \
             0.1 for meshes of unit size, as DexGraspNet's)"
        ))
    } else if size_m < USUAL_M[0] {
        Some(format!(
            "{name} is only {:.1} mm across, less than a fingertip; if the mesh is not in metres, pass --scale",
            1e3 * size_m
        ))
    } else {
        None
    }
}

impl Description {
    /// Reads a description. `name` is its name in errors.
    ///
    /// # Errors
    /// If the text is not a description.
    pub fn from_json(name: &str, text: &str) -> Result<Self, ObjectError> {
        serde_json::from_str(text).map_err(|source| ObjectError::Description {
            name: name.to_owned(),
            source,
        })
    }

    /// The mesh of an object of this description.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub(super) fn mesh(
        &self,
        name: &str,
        vertices: Vec<Vector3<f64>>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Mesh, ObjectError> {
        let shapes: Vec<Arc<dyn Shape>> = self.parts.iter().map(|part| part.shape()).collect();
        let distance = |shape| -> SignedDistance<'_> {
            let shape: &Arc<dyn Shape> = shape;
            Box::new(|point| shape.distance(point))
        };
        let solids: Vec<SignedDistance<'_>> = shapes.iter().map(distance).collect();
        let solids = (!solids.is_empty()).then_some(solids.as_slice());
        Ok(Mesh::of_pieces(name, vertices, triangles, solids)?)
    }

    /// Reads the mesh of an object of this description from the text of an OBJ file. All objects and groups of the file
    /// form one mesh.
    ///
    /// # Errors
    /// As [`Mesh::from_obj`].
    pub fn mesh_of_obj(&self, name: &str, obj: &str) -> Result<Mesh, ObjectError> {
        let read = crate::mesh::of_obj(name, &mut obj.as_bytes())?;
        self.mesh(name, read.vertices, read.triangles)
    }

    /// Mass of an object of this description, kilograms: the given one, or that of the volume at 500 kg/m³.
    pub fn mass_of(&self, mesh: &Mesh) -> f64 {
        self.mass_kg
            .unwrap_or_else(|| mesh.volume() * DEFAULT_DENSITY_KG_M3)
    }

    /// The description of an object scaled by `factor` at the same density.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        scaled.mass_kg = self.mass_kg.map(|mass| mass * factor.powi(3));
        match &mut scaled.symmetry {
            Symmetry::None => {}
            Symmetry::Axis { point, .. } => *point *= factor,
            Symmetry::Sphere { centre } => *centre *= factor,
            Symmetry::Finite(motions) => {
                for motion in motions {
                    motion.translation.vector *= factor;
                }
            }
        }
        // The formulae would have to be scaled as well; the mesh suffices without them.
        scaled.primitive = None;
        scaled.parts.clear();
        scaled
    }

    fn validate(&self, name: &str) -> Result<(), ObjectError> {
        let invalid = |field, problem| {
            Err(ObjectError::Value {
                name: name.to_owned(),
                field,
                problem,
            })
        };
        within(OBJECT_MASS, &self.mass_kg, (name, "mass_kg"))?;
        let place = |place: &Vector3<f64>| within(GRASP_POSITION, place, (name, "symmetry"));
        match &self.symmetry {
            Symmetry::None => {}
            Symmetry::Axis { point, direction } => {
                place(point)?;
                within(DIRECTION, [&direction.norm()], (name, "symmetry.direction"))?;
            }
            Symmetry::Sphere { centre } => place(centre)?,
            Symmetry::Finite(motions) => {
                if motions.len() > MOST_MOTIONS {
                    return invalid("symmetry", "there are more than 1000 motions");
                }
                for motion in motions {
                    place(&motion.translation.vector)?;
                    let length = motion.rotation.as_ref().norm();
                    if length.is_nan() || (length - 1.0).abs() > UNIT_TOLERANCE {
                        return invalid("symmetry", "a quaternion is not of unit length");
                    }
                }
            }
        }
        let mut shapes = self.primitive.iter().chain(&self.parts);
        shapes.try_for_each(|shape| shape.check(name))
    }
}

/// Share of the samples at which the object is thin.
fn thin_share(samples: &[SurfaceSample], shape: &dyn Shape) -> f64 {
    let thin = samples.iter().filter(|sample| is_thin(sample, shape));
    thin.count() as f64 / samples.len() as f64
}

/// Whether the straight line inward from a surface point leaves the object before [`THIN_M`].
fn is_thin(sample: &SurfaceSample, shape: &dyn Shape) -> bool {
    let mut along = THICKNESS_STEP_M;
    while along < THIN_M {
        let distance = shape.distance(&(sample.point - sample.normal * along));
        if distance > THICKNESS_STEP_M {
            return true;
        }
        along += distance.abs().max(THICKNESS_STEP_M);
    }
    false
}

/// Comparison of a description with the mesh.
struct Fit<'a> {
    name: &'a str,
    mesh: &'a Mesh,
    exact: &'a ExactMesh,
    tolerance_m: f64,
}

impl Fit<'_> {
    fn symmetry(&self, symmetry: &Symmetry) -> Result<(), ObjectError> {
        match symmetry {
            Symmetry::None => Ok(()),
            Symmetry::Axis { point, direction } => {
                let turns = Self::turns(point, direction);
                self.moved("symmetric about an axis", &turns)
            }
            Symmetry::Sphere { centre } => {
                let turns: Vec<_> = [Vector3::x(), Vector3::y(), Vector3::z()]
                    .iter()
                    .flat_map(|axis| Self::turns(centre, axis))
                    .collect();
                self.moved("symmetric about a point", &turns)
            }
            Symmetry::Finite(motions) => self.moved("symmetric under listed motions", motions),
        }
    }

    fn primitive(&self, shape: &dyn Shape, samples: &[SurfaceSample]) -> Result<(), ObjectError> {
        let points = self
            .mesh
            .boundary()
            .0
            .iter()
            .chain(samples.iter().map(|sample| &sample.point));
        let deviation_m = points
            .map(|point| shape.distance(point).abs())
            .fold(0.0, f64::max);
        self.judge("a primitive shape", deviation_m)
    }

    fn parts(&self, parts: &[Primitive]) -> Result<(), ObjectError> {
        if parts.is_empty() {
            return Ok(());
        }
        let shapes: Vec<Arc<dyn Shape>> = parts.iter().map(|part| part.shape()).collect();
        let off = |point: &Vector3<f64>| {
            let distances = shapes.iter().map(|shape| shape.distance(point));
            distances.fold(f64::INFINITY, f64::min).abs()
        };
        let vertices = self.mesh.boundary().0.iter();
        self.judge("a union of shapes", vertices.map(off).fold(0.0, f64::max))
    }

    /// Rotations whose angles are not multiples of the angles between a mesh's facets.
    fn turns(point: &Vector3<f64>, direction: &Vector3<f64>) -> Vec<Isometry3<f64>> {
        let axis = Unit::new_normalize(*direction);
        let turn = |angle_rad: f64| {
            let rotation = Rotation3::from_axis_angle(&axis, angle_rad);
            Isometry3::from_parts((point - rotation * point).into(), rotation.into())
        };
        [0.1, 1.0, 2.0, 3.0, 4.5].map(turn).to_vec()
    }

    fn moved(&self, what: &'static str, motions: &[Isometry3<f64>]) -> Result<(), ObjectError> {
        let off = |motion: &Isometry3<f64>| {
            let moved =
                |v: &Vector3<f64>| self.exact.gap(&motion.transform_point(&(*v).into()).coords);
            let points = self.mesh.boundary().0.par_iter();
            points.map(moved).reduce(|| 0.0, f64::max)
        };
        self.judge(what, motions.iter().map(off).fold(0.0, f64::max))
    }

    fn judge(&self, what: &'static str, deviation_m: f64) -> Result<(), ObjectError> {
        if deviation_m <= self.tolerance_m {
            return Ok(());
        }
        Err(ObjectError::Deviation {
            name: self.name.to_owned(),
            what,
            deviation_m,
            tolerance_m: self.tolerance_m,
        })
    }
}
