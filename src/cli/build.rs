//! b
use super::args::{Build, Common};
pub(super) fn run(_c: &Build, _m: &Common) -> anyhow::Result<()> { Ok(()) }
