//! Measures how diverse a population of grasps is.
//!
//! The crate has two halves. [`grasp`] turns a hand and an object into an energy and samples it. [`topography`] maps *any*
//! energy: its minima, the lowest passes between them, and the tree of merges. The halves share only the traits of
//! [`space`], [`energy`] and [`sample`].
//!
//! | to … | look at |
//! |---|---|
//! | define tangents and distances | [`space::Space`] |
//! | use an energy of your own | [`energy::Energy`]; reference surfaces in [`energy::model`] |
//! | descend to a minimum | [`optimize::quench`] |
//! | draw samples | [`sample::Kernel`], [`sample::Mala`] |
//! | build the energy of a hand on an object | [`grasp::GraspEnergy`], [`hand::Hand`], [`object::Object`] |
//! | measure distances to a mesh | [`mesh::Mesh`], [`mesh::ExactMesh`] |
//! | synthesize and judge grasps | [`grasp::synthesis::synthesize`], [`grasp::judge`], [`grasp::closure`] |
//! | go from a function of your own to its disconnectivity graph | [`own_function`] |
//! | map a landscape | [`topography::quench_all`], [`topography::distinct`], [`topography::build_landscape`] |
//! | compare a tree, distances or a graph with labels | [`agreement::Dendrogram`], [`agreement::test_labels`] |
//! | draw a landscape | [`figure::DisconnectivityPicture`], [`figure::BarrierPicture`], [`figure::Scene`] |
//! | plot numbers | [`figure::chart::Chart`] |
//! | read and write files | [`store`] |
//! | go from a file of grasps to a landscape with tables and pictures | [`study::map_population`] |
//!
//! # Example
//! The Müller–Brown surface from four starting points: three minima, and the pass at −40.66 between the two lowest.
//!
//! ```
//! # #[cfg(feature = "topography")] {
//! use landscape::energy::model::MullerBrown;
//! use landscape::sample::Mala;
//! use landscape::topography::{
//!     MapSettings, MinimumId, Run, Scales, build_landscape, distinct, quench_all,
//! };
//!
//! let energy = MullerBrown::new();
//! let starts = [[-0.7, 1.2], [0.5, 0.1], [-0.1, 0.5], [0.8, 0.0]].map(|x| x.to_vec());
//! let scales = Scales::measured(&energy, &starts);
//! let quenches = quench_all(&energy, &starts, &scales.quench(), &Run::default())?;
//! let (minima, _) = distinct(&energy, &quenches, &scales.sameness(), scales.gradient_tolerance());
//! assert_eq!(minima.len(), 3);
//!
//! let settings = MapSettings::for_minima(&energy, &minima);
//! let kernel = Mala::new(&energy);
//! let landscape = build_landscape(&energy, &kernel, minima, &settings, &Run::default())?;
//! let height = landscape.tree.minimax(MinimumId(0), MinimumId(1)).unwrap();
//! assert!((height + 40.664844).abs() < 1e-5);
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![warn(clippy::print_stdout, clippy::print_stderr)]

#[cfg(any(feature = "figure", feature = "grasp"))]
mod atomic_file;
#[cfg(feature = "simulation")]
mod caught;

pub mod agreement;
pub mod doubt;
pub mod energy;
pub mod limits;
pub mod optimize;
pub mod printable;
pub mod sample;
pub mod space;

#[cfg(feature = "grasp")]
pub mod cache;
#[cfg(feature = "grasp")]
pub mod evaluation;
#[cfg(feature = "figure")]
pub mod figure;
#[cfg(feature = "grasp")]
pub mod formats;
#[cfg(feature = "grasp")]
pub mod grasp;
#[cfg(feature = "grasp")]
pub mod hand;
#[cfg(feature = "grasp")]
pub mod mesh;
#[cfg(feature = "grasp")]
pub mod object;
#[cfg(feature = "chemistry")]
pub mod thermal;
#[cfg(feature = "topography")]
pub mod topography;

#[cfg(feature = "topography")]
#[doc = include_str!("../docs/own_function.md")]
pub mod own_function {}

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod store;
#[cfg(feature = "cli")]
pub mod study;
