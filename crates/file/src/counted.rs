use std::fmt::Display;

/// Formats a number with the singular noun that it counts: `1 trial`, `2 trials`, `0 bodies`.
///
/// The plural is regular: `body` gives `bodies`, `search` and `box` give `searches` and `boxes`; for a noun with another plural
/// (`vertex`) the result is wrong.
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, noun: &str) -> String {
    if count == N::from(1) {
        return format!("{count} {noun}");
    }
    match noun.strip_suffix('y') {
        Some(stem) if !stem.ends_with(['a', 'e', 'o', 'u']) => format!("{count} {stem}ies"),
        _ if ["s", "x", "ch", "sh"].iter().any(|ending| noun.ends_with(ending)) => {
            format!("{count} {noun}es")
        }
        _ => format!("{count} {noun}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular_and_all_else_plural() {
        assert_eq!((counted(1_usize, "run"), counted(0_usize, "run")), ("1 run".into(), "0 runs".into()));
        assert_eq!(counted(2_u64, "way point"), "2 way points");
        assert_eq!(counted(3_u32, "body"), "3 bodies");
        assert_eq!(counted(3_u32, "way"), "3 ways");
        assert_eq!(
            (counted(2_u32, "search"), counted(2_u32, "box")),
            ("2 searches".into(), "2 boxes".into())
        );
    }
}
