//! Check that comments use the field's plain English.

use std::path::Path;

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// First words of docs that open with a question or a fragment instead of a noun phrase or a verb.
const OPENINGS: [&str; 9] = ["What", "How", "Where", "Which", "Of", "Whether", "When", "Why", "Who"];

/// Words and phrases that hide what a comment means, in lower case.
const HOUSE_WORDS: [&str; 23] = [
    "say",
    "says",
    "said",
    "saying",
    "tell",
    "tells",
    "told",
    "telling",
    "so many",
    "so much",
    "so far",
    "whoever",
    "nobody",
    "somebody",
    "everybody",
    "anybody",
    "looked at",
    "what came",
    "room",
    "rooms",
    "asked",
    "ways",
    "no way",
];

/// Maximum number of house words in the comments of all files of a crate.
const MOST_OF_CRATE: usize = 2;

/// Reports docs with such an opening, and the house words of crates that have more than [`MOST_OF_CRATE`].
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let (mut problems, mut words) = (Vec::new(), Vec::<(&str, Problem)>::new());
    for file in files.iter().filter(|file| Path::new(&file.path).extension() == Some("rs".as_ref())) {
        let text = file.text().unwrap_or_default();
        let mut follows_doc = false;
        for (index, line) in text.lines().enumerate() {
            let comment = line.trim_start().strip_prefix("//");
            let place = || format!("{}:{}", file.path, index + 1);
            let is_doc = comment.is_some_and(|comment| comment.starts_with('/'));
            if let Some(opening) = comment.filter(|_| is_doc && !follows_doc).and_then(opening) {
                let message = format!("a doc opens with `{opening}`");
                problems.push(Problem::new(place(), message, "open with a noun phrase or a verb"));
            }
            if let Some(word) = comment.and_then(house_word) {
                let message = format!("a comment uses `{word}`");
                let hint = "use the field's term, or name who does what";
                words.push((crate_of(&file.path), Problem::new(place(), message, hint)));
            }
            follows_doc = is_doc;
        }
    }
    let of_crate = |name: &str| words.iter().filter(|(of, _)| *of == name).count();
    let many: Vec<bool> = words.iter().map(|(name, _)| of_crate(name) > MOST_OF_CRATE).collect();
    let found = words.into_iter().zip(many).filter(|(_, is_one_of_many)| *is_one_of_many);
    problems.extend(found.map(|((_, problem), _)| problem));
    problems
}

/// Returns the folder of a crate in a path such as `crates/shape/src/lib.rs`.
fn crate_of(path: &str) -> &str {
    let folders = if path.starts_with("crates/") { 2 } else { 1 };
    path.match_indices('/').nth(folders - 1).map_or(path, |(end, _)| &path[..end])
}

/// Returns the first word of a doc comment if it is one of [`OPENINGS`].
fn opening(comment: &str) -> Option<&'static str> {
    let text = comment.trim_start_matches(['/', '!']).trim_start();
    OPENINGS.into_iter().find(|word| text.strip_prefix(word).is_some_and(|rest| rest.starts_with(' ')))
}

/// Returns the first of [`HOUSE_WORDS`] in a comment, code in backticks aside.
fn house_word(comment: &str) -> Option<&'static str> {
    let prose: String = comment.split('`').step_by(2).collect::<Vec<_>>().join(" ").to_lowercase();
    let words: Vec<&str> =
        prose.split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).collect();
    HOUSE_WORDS.into_iter().find(|phrase| {
        let phrase: Vec<&str> = phrase.split(' ').collect();
        words.windows(phrase.len()).any(|found| found == phrase)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn messages(text: &str) -> Vec<String> {
        check(&[SourceFile::of_text("crates/x/src/x.rs", text)])
            .into_iter()
            .map(|problem| problem.message)
            .collect()
    }

    #[test]
    fn an_opening_that_is_a_question_is_found() {
        assert_eq!(messages("/// What it is.\nfn f() {}"), ["a doc opens with `What`"]);
        assert_eq!(messages("    /// Of a robot.\n    x: u8,"), ["a doc opens with `Of`"]);
        assert!(messages("/// Returns the distance.\n/// Where it is known.\nfn f() {}").is_empty());
        assert!(messages("/// Offset, in metres.\n// What follows is code.\nfn f() {}").is_empty());
    }

    #[test]
    fn house_words_are_counted_by_crate() {
        let line = "// The file says so.\n";
        assert!(messages(&line.repeat(2)).is_empty());
        assert_eq!(messages(&line.repeat(3)), ["a comment uses `says`"; 3]);
        assert_eq!(messages(&"/// Maximum, so far.\n".repeat(3)), ["a comment uses `so far`"; 3]);
        assert!(messages(&"/// Field `said`, and sofar.\n".repeat(3)).is_empty());
        assert_eq!(crate_of("crates/shape/src/a/b.rs"), "crates/shape");
        assert_eq!(crate_of("xtask/src/main.rs"), "xtask");
    }
}
