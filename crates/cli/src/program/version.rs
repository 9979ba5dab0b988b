use std::fmt::Write;
use std::sync::LazyLock;

use cranny_spatial::simd_level_name;

/// The commit that this program was built from, where git knew it.
pub const COMMIT: Option<&str> = option_env!("CRANNY_COMMIT");

/// The machine that it was built for, as Rust names it.
pub const TARGET: &str = env!("CRANNY_TARGET");

/// What `--version` says: after the number what reports of faults need.
pub fn long() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let mut text = String::from(env!("CARGO_PKG_VERSION"));
        let _ = writeln!(text);
        let _ = writeln!(text, "commit:  {}", COMMIT.unwrap_or("unknown"));
        let _ = writeln!(text, "target:  {TARGET}");
        let _ = write!(text, "vectors: {}", simd_level_name());
        text
    });
    &TEXT
}
