//! Section of a version in the changelog.

/// Begin of a section.
const HEADING: &str = "\n## [";

/// Returns the section of a version without its heading, or that of changes without a version if it has none.
pub fn of_version<'a>(log: &'a str, version: &str) -> Option<&'a str> {
    let section = |name: &str| {
        let (_, rest) = log.split_once(&format!("{HEADING}{name}]"))?;
        // The date.
        let (_, text) = rest.split_once('\n')?;
        Some(text.split(HEADING).next().unwrap_or(text).trim_start())
    };
    section(version).or_else(|| section("Unreleased"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_of_the_version_comes_before_that_without_one() {
        let log = "# Log\n\n## [Unreleased]\n\n- new\n\n## [0.1.0] - 2026-11-28\n\n### Added\n\n- a\n\n## [0.0.1]\n\n- b\n";
        assert_eq!(of_version(log, "0.1.0"), Some("### Added\n\n- a\n"));
        assert_eq!(of_version(log, "0.0.1"), Some("- b\n"));
        assert_eq!(of_version(log, "0.2.0"), Some("- new\n"));
        assert_eq!(of_version("# Log\n", "0.2.0"), None);
    }
}
