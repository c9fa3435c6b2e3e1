//! The module `landscape._native` of the Python package: hands, objects, grasps, energies, surfaces given by Python functions,
//! landscape folders, and the command line. The package's façade names arguments, fills in defaults and documents them.
//!
//! * [`work`]: native work while the interpreter is free, with signals and panics.
//! * [`callable`]: Python functions as energies.
//! * [`error`]: which exception tells which failure.

mod arrays;
mod callable;
mod command;
mod energy;
mod error;
mod grasps;
mod hand;
mod landscape;
mod object;
mod surface;
mod work;

use ::landscape::hand::HAND_NAMES;
use ::landscape::object::OBJECT_NAMES;
use pyo3::prelude::*;

/// The native part of the package `landscape`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("HAND_NAMES", HAND_NAMES.to_vec())?;
    module.add("OBJECT_NAMES", OBJECT_NAMES.to_vec())?;
    module.add_class::<hand::Hand>()?;
    module.add_class::<object::Object>()?;
    module.add_class::<grasps::Grasps>()?;
    module.add_class::<energy::Energy>()?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<landscape::Folder>()?;
    module.add_function(wrap_pyfunction!(command::main, module)?)?;
    module.add_function(wrap_pyfunction!(command::call, module)?)?;
    module.add_function(wrap_pyfunction!(command::check_output, module)?)?;
    module.add_function(wrap_pyfunction!(work::panic, module)?)?;
    let finish = wrap_pyfunction!(work::finish, module)?;
    let py = module.py();
    (py.import("atexit")?).call_method1("register", (finish,))?;
    Ok(())
}
