//! Check that a comment that cites a publication names a section of it.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Capitalised words before a number of four digits that are not names.
const NO_NAMES: &str =
    "Default January February March April May June July August September October November December";
/// Abbreviations that precede a number, and words that locate a passage if a number or a capital follows.
const SHORT: &str = "eq. eqs. Eq. Alg. ch. Fig.";
const LONG: &str = "section algorithm chapter table appendix theorem definition example";

/// Reports comments in the sources of crates that cite a name and a year without a section, an equation or similar, or ",
/// whole", before the next citation.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let is_source = |path: &str| path.starts_with("crates/") && path.split('/').nth(2) == Some("src");
    let sources = files.iter().filter(|file| file.has_extension("rs") && is_source(&file.path));
    let vague = sources.flat_map(|file| {
        paragraphs(file.text().unwrap_or_default()).into_iter().flat_map(move |(line, words)| {
            let problem = move |source| {
                let message = format!("cites '{source}' without a place in it");
                let hint = "add its section or equation (`, §3`), or `, whole` if all of it is used";
                Problem::new(format!("{}:{line}", file.path), message, hint)
            };
            vague_sources(&words).into_iter().map(problem)
        })
    });
    vague.collect()
}

/// Returns the paragraphs of all comments, as words, each with its first line from 1.
fn paragraphs(text: &str) -> Vec<(usize, Vec<&str>)> {
    let mut all: Vec<(usize, Vec<&str>)> = Vec::new();
    let mut is_open = false;
    for (index, line) in text.lines().enumerate() {
        let comment = line.trim_start().strip_prefix("//").map(|rest| rest.trim_start_matches(['/', '!']));
        let words: Vec<&str> = comment.unwrap_or_default().split_whitespace().collect();
        let continues = !words.is_empty();
        match all.last_mut().filter(|_| is_open) {
            Some((_, paragraph)) => paragraph.extend(words),
            None => all.push((index + 1, words)),
        }
        is_open = continues;
    }
    all
}

/// Returns the names and years that no location follows.
fn vague_sources(words: &[&str]) -> Vec<String> {
    let is_year = |at: &usize| {
        let (name, year) = (core(words[*at - 1]), core(words[*at]));
        let is_name = name.starts_with(char::is_uppercase) && name.contains(char::is_lowercase);
        let is_recent = year.len() == 4 && (year.starts_with("19") || year.starts_with("20"));
        is_recent && year.parse::<u32>().is_ok() && (is_name || name == "al") && !lists(NO_NAMES, name)
    };
    let years: Vec<usize> = (1..words.len()).filter(is_year).collect();
    let ends = years.iter().skip(1).copied().chain([words.len()]);
    let vague = years.iter().zip(ends).filter(|(year, end)| !names_a_place(&words[**year..*end]));
    vague.map(|(&year, _)| format!("{} {}", core(words[year - 1]), core(words[year]))).collect()
}

fn names_a_place(words: &[&str]) -> bool {
    words.windows(2).any(|pair| {
        let [before, word] = [pair[0], pair[1]].map(|word| word.trim_start_matches(['(', '"']));
        let is_place = word.starts_with(|c: char| c.is_ascii_digit() || c.is_uppercase());
        let is_whole = before.ends_with(',') && core(word) == "whole";
        word.starts_with('§')
            || lists(SHORT, before)
            || is_whole
            || is_place && lists(LONG, &before.to_lowercase())
    })
}

fn core(word: &str) -> &str {
    word.trim_matches(|c: char| !c.is_alphanumeric())
}

fn lists(words: &str, word: &str) -> bool {
    words.split(' ').any(|one| one == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_without_a_place_in_it_fails() {
        let found = |text: &str| check(&[SourceFile::of_text("crates/shape/src/hull.rs", text)]).len();
        assert_eq!(found("/// (Gilbert & Keerthi 1988)"), 1);
        assert_eq!(found("/// Eppner et al. 2019,\n/// on the whole."), 1);
        assert_eq!(found("// Pham 2018, §4; Andrew (1979)\n//\n// §3"), 1);
        assert_eq!(found("/// Andrew 1979, \"Hulls\", whole; Schlick 1994, eq. (15)"), 0);
        assert_eq!(
            found("/// Nguyen 1988, Theorem 5; Ericson 2005, §5.1 and §9.5; Knuth\n/// 1997, Algorithm P"),
            0
        );
        assert_eq!(found("/// Default 2000. Of July 2026, as RFC 1952; 2000 points."), 0);
    }
}
