use std::thread;

use cranny_file::system;

/// On what, by what and how a campaign was run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunInformation {
    /// The name of the machine.
    pub machine: String,
    /// What its processor calls itself.
    pub processor: String,
    /// The vector instructions that it has, of those that Cranny knows.
    pub cpu_features: Vec<String>,
    /// How many threads it runs at once.
    pub cores: usize,
    /// The version of Cranny.
    pub version: String,
    /// The commit that it was built from, where that is known.
    pub commit: Option<String>,
    /// The command that began the run.
    pub command: String,
    /// How many workers ran at once: with more than one, times are not those of a machine at rest.
    pub workers: usize,
    /// What memory a search could take, in bytes; older results do not say.
    pub memory_limit_bytes: Option<u64>,
    /// In what the programs of others ran; nothing where there were none, or where they ran free.
    pub sandbox: Option<String>,
}

impl RunInformation {
    /// What is known of this machine and this program; the campaign adds what it gave its planners.
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
}

/// Where nobody tells.
const UNKNOWN: &str = "unknown";

/// The instruction sets that the lanes choose from.
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
