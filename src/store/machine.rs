//! The build of the program and the processor, of which the first may change the last bits of a result.

use serde::{Deserialize, Serialize};

/// The build of the program, on which the last bits of results may depend, and the vector instructions of the processor, on
/// which they do not depend: products are not contracted to fused operations, sums have a fixed order, and elementary
/// functions are those of the crate `libm`. Neural shapes are the exception. The instructions are recorded so that this can be
/// checked where results differ.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Machine {
    /// Version of the program and length of its file, which tells builds of one version apart.
    pub program: String,
    /// Processor family, system and C library.
    pub platform: String,
    /// Vector instructions of the processor.
    pub instructions: Vec<String>,
}

impl Machine {
    /// The machine on which this process runs.
    pub fn here() -> Self {
        let length = std::env::current_exe().and_then(|path| Ok(path.metadata()?.len()));
        let library = if cfg!(target_env = "gnu") {
            " gnu"
        } else if cfg!(target_env = "musl") {
            " musl"
        } else {
            ""
        };
        Self {
            program: format!(
                "{} ({} bytes)",
                env!("CARGO_PKG_VERSION"),
                length.unwrap_or_default()
            ),
            platform: format!(
                "{} {}{library}",
                std::env::consts::ARCH,
                std::env::consts::OS
            ),
            instructions: instructions(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn instructions() -> Vec<String> {
    let all = [
        ("avx", is_x86_feature_detected!("avx")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    let present = all.into_iter().filter(|(_, present)| *present);
    present.map(|(name, _)| name.to_owned()).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn instructions() -> Vec<String> {
    Vec::new()
}
