//! Failures of native work and the Python exceptions that tell them. The classes are defined in `landscape._errors`.

use std::any::Any;
use std::error::Error;
use std::io;

use landscape::cli::CallError;
use landscape::energy::GradientFault;
use landscape::printable::{printable, sentence};
use landscape::study::StudyError;
use landscape::topography::JournalError;
use pyo3::exceptions::{PyFileNotFoundError, PyKeyboardInterrupt, PyOSError, PyPermissionError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Why native work ended without a result. It needs no interpreter, so any thread can make it.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Something given by the caller is wrong.
    Input(String),
    /// An error of the operating system.
    System(io::ErrorKind, String),
    /// A search or a map found nothing.
    NothingFound(String),
    /// A function of the caller returned what is no energy.
    Energy { told: String, x: Vec<f64> },
    /// The gradient of a function of the caller is wrong.
    Gradient(Box<GradientFault>),
    /// A function of the caller raised.
    Raised(PyErr),
    /// The caller interrupted the work.
    Interrupted,
}

impl Failure {
    /// The failure that an error of the library is.
    pub(crate) fn of(error: &(dyn Error + 'static)) -> Self {
        let told = printable(&sentence(error), &[]).into_owned();
        let mut next = Some(error);
        while let Some(cause) = next {
            if let Some(system) = cause.downcast_ref::<io::Error>() {
                return Self::System(system.kind(), told);
            }
            next = cause.source();
        }
        Self::Input(told)
    }

    /// The Python exception.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Input(told) => exception(py, "InputError", &told),
            Self::System(kind, told) => match kind {
                io::ErrorKind::NotFound => PyFileNotFoundError::new_err(told),
                io::ErrorKind::PermissionDenied => PyPermissionError::new_err(told),
                _ => PyOSError::new_err(told),
            },
            Self::NothingFound(told) => exception(py, "NothingFoundError", &told),
            Self::Energy { told, x } => {
                with_fields(exception(py, "EnergyError", &told), py, |fields| {
                    fields.set_item("x", x)
                })
            }
            Self::Gradient(fault) => with_fields(
                exception(py, "GradientError", &fault.to_string()),
                py,
                |fields| {
                    fields.set_item("x", fault.x)?;
                    fields.set_item("component", fault.component)?;
                    fields.set_item("given", fault.told)?;
                    fields.set_item("measured", fault.measured)
                },
            ),
            Self::Raised(error) => error,
            Self::Interrupted => PyKeyboardInterrupt::new_err(()),
        }
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::NoMinimum { .. } | StudyError::OneMinimumOfSurface(_) => {
                Self::NothingFound(sentence(&error))
            }
            error => Self::of(&error),
        }
    }
}

impl From<JournalError> for Failure {
    fn from(error: JournalError) -> Self {
        Self::of(&error)
    }
}

impl From<CallError> for Failure {
    fn from(error: CallError) -> Self {
        match error.kind {
            Some(kind) => Self::System(kind, error.sentence),
            None => Self::Input(error.sentence),
        }
    }
}

/// An exception of a class of `landscape._errors`.
pub(crate) fn exception(py: Python<'_>, class: &str, told: &str) -> PyErr {
    let made = py
        .import("landscape._errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((told,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

fn with_fields(
    error: PyErr,
    py: Python<'_>,
    fill: impl FnOnce(&Bound<'_, PyDict>) -> PyResult<()>,
) -> PyErr {
    let filled = error.value(py).getattr("__dict__").and_then(|fields| {
        let fields = fields.cast_into::<PyDict>()?;
        fill(&fields)
    });
    filled.err().unwrap_or(error)
}

/// The exception that tells of a panic, which is an error of the program.
pub(crate) fn panicked(py: Python<'_>, payload: &(dyn Any + Send)) -> PyErr {
    let words = (payload.downcast_ref::<String>().map(String::as_str))
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("no message");
    exception(
        py,
        "InternalError",
        &format!("internal error of landscape, please report it: {words}"),
    )
}

/// An exception for a wrong argument.
pub(crate) fn input(py: Python<'_>, told: impl AsRef<str>) -> PyErr {
    exception(py, "InputError", told.as_ref())
}

/// The exception of an error of the library.
pub(crate) fn of(py: Python<'_>, error: &(dyn Error + 'static)) -> PyErr {
    Failure::of(error).raised(py)
}
