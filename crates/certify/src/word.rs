use std::collections::HashSet;

/// Returns a name as one word of printable ASCII characters.
pub(crate) fn word(name: &str) -> String {
    let word: String = name.chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect();
    if word.is_empty() { "_".to_owned() } else { word }
}

/// Returns the names of objects as words that differ from each other. A slash is kept for the numbers of parts.
pub(crate) fn object_words<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    let distinct = |name: &str| {
        let plain = word(name).replace('/', "_");
        let numbered = (2..).map(|number| format!("{plain}~{number}"));
        let mut candidates = std::iter::once(plain.clone()).chain(numbered);
        let chosen = candidates.find(|candidate| !taken.contains(candidate)).unwrap_or_default();
        taken.insert(chosen.clone());
        chosen
    };
    names.map(distinct).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_objects_are_distinct_printable_words() {
        let names = ["upper board", "upper_board", "upper_board~2", "board/0", "\u{1b}[2K", "Stuhl ü", ""];
        let words = object_words(names.into_iter());
        let expected = ["upper_board", "upper_board~2", "upper_board~2~2", "board_0", "_[2K", "Stuhl__", "_"];
        assert_eq!(words, expected);
    }
}
