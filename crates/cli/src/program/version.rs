use std::fmt::Write;
use std::sync::LazyLock;

use cranny_spatial::simd_level_name;

/// Commit that this program was built from, if git knew it.
pub const COMMIT: Option<&str> = option_env!("CRANNY_COMMIT");

/// Target triple that this program was built for.
pub const TARGET: &str = env!("CRANNY_TARGET");

/// Returns the text of `--version`: the version number, and details for bug reports.
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
