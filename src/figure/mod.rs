//! Pictures: layout is pure geometry, painting is plotters.

#[cfg(feature = "grasp")]
pub mod scene;
