use std::thread;

use cranny_file::system;

/// Machine, program and settings of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunInformation {
    /// Name of the machine.
    pub machine: String,
    /// Name of the processor as it reports itself.
    pub processor: String,
    /// Supported vector instruction sets, of those known to Cranny.
    pub cpu_features: Vec<String>,
    /// Number of hardware threads; 0 if unknown.
    pub cores: usize,
    /// Version of Cranny.
    pub version: String,
    /// Commit of the build, if known.
    pub commit: Option<String>,
    /// Command that started the run.
    pub command: String,
    /// Number of simultaneous workers; with more than one, times are not those of an idle machine. 0 if unknown.
    pub workers: usize,
    /// Memory limit of a search, in bytes; `None` in older results.
    pub memory_limit_bytes: Option<u64>,
    /// Isolation of external programs; `None` if there were none, without isolation, or in older results.
    pub sandbox: Option<String>,
}

impl RunInformation {
    /// Returns the information on this machine and this program; the campaign adds the limits of its planners.
    pub fn here(commit: Option<&str>, command: &str, workers: usize) -> Self {
        Self {
            machine: system::machine_name().unwrap_or_else(|| UNKNOWN.to_owned()),
            processor: system::processor_name().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cpu_features: cpu_features(),
            cores: thread::available_parallelism().map_or(1, usize::from),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit.map(str::to_owned),
            command: command.to_owned(),
            workers,
            memory_limit_bytes: None,
            sandbox: None,
        }
    }

    /// Returns true if the run is missing, or was recorded by a version that stored neither memory limit nor isolation.
    pub(crate) fn is_older(&self) -> bool {
        self.memory_limit_bytes.is_none() && self.sandbox.is_none()
    }

    /// Returns the information on a run that the results do not contain, though they contain trials of it; 0 stands for an
    /// unknown number.
    pub(crate) fn unknown() -> Self {
        let unknown = || UNKNOWN.to_owned();
        Self {
            machine: unknown(),
            processor: unknown(),
            cpu_features: Vec::new(),
            cores: 0,
            version: unknown(),
            commit: None,
            command: unknown(),
            workers: 0,
            memory_limit_bytes: None,
            sandbox: None,
        }
    }
}

/// Text for an unknown value.
pub(crate) const UNKNOWN: &str = "unknown";

/// Returns the supported instruction sets among those that the lanes choose from.
fn cpu_features() -> Vec<String> {
    #[cfg(target_arch = "x86_64")]
    let known = [
        ("sse4.2", std::is_x86_feature_detected!("sse4.2")),
        ("avx2", std::is_x86_feature_detected!("avx2")),
        ("fma", std::is_x86_feature_detected!("fma")),
        ("avx512f", std::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(target_arch = "aarch64")]
    let known = [("neon", std::arch::is_aarch64_feature_detected!("neon"))];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let known: [(&str, bool); 0] = [];
    known.iter().filter(|(_, has)| *has).map(|(name, _)| (*name).to_owned()).collect()
}
