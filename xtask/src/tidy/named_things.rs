//! Check that pages name no file, flag or type that does not exist.
//!
//! Exempt are historical pages: the changelog, decisions, and the stored runs in `benchmarks/`, each of an earlier program.

use std::collections::BTreeSet;
use std::path::Path;

use crate::checkout::SourceFile;
use crate::problem::Problem;
use crate::site::links;

/// File extensions of the languages of the checkout.
const LANGUAGES: [&str; 5] = ["rs", "ts", "py", "h", "hpp"];
/// Folders whose programs have flags.
const FLAGGED: [&str; 5] = ["crates/cli/", "xtask/", "python/", "examples/", "benchmarks/"];
/// Pages that describe past states.
const HISTORY: [&str; 3] = ["CHANGELOG.md", "docs/decisions/", "benchmarks/"];

/// Reports names in code spans of Markdown pages that do not exist: a file `….rs` or of another language (relative to the folder of
/// the page if it begins with `src/`, else the end of any path), a flag `--name`, and a type name of two words or more.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let known = Known::of(files);
    let is_now = |page: &SourceFile| {
        page.path == "benchmarks/README.md" || !HISTORY.iter().any(|past| page.path.starts_with(past))
    };
    let mut problems = Vec::new();
    for page in files.iter().filter(|file| file.has_extension("md") && is_now(file)) {
        for (line, text) in prose_lines(page.text().unwrap_or_default()) {
            let spans = text.split('`').skip(1).step_by(2);
            problems.extend(spans.flat_map(|span| known.missing(page, span)).map(|name| {
                let message = format!("names `{name}`, which does not exist");
                Problem::new(format!("{}:{line}", page.path), message, "name what there is, or nothing")
            }));
        }
    }
    problems
}

/// Returns the lines outside of code blocks, each with its number from 1.
fn prose_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_code = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        (!is_code && !is_fence).then_some((index + 1, line))
    })
}

/// Names that a page may use.
struct Known<'a> {
    paths: Vec<&'a str>,
    /// Words of sources.
    words: BTreeSet<&'a str>,
    flags: BTreeSet<String>,
}

impl<'a> Known<'a> {
    fn of(files: &'a [SourceFile]) -> Self {
        let mut known = Self { paths: Vec::new(), words: BTreeSet::new(), flags: BTreeSet::new() };
        for file in files.iter().filter(|file| !file.has_extension("md")) {
            known.paths.push(&file.path);
            let text = file.text().unwrap_or_default();
            if LANGUAGES.iter().any(|ending| file.has_extension(ending)) {
                known.words.extend(text.split(|c: char| !c.is_alphanumeric()));
            }
            if FLAGGED.iter().any(|folder| file.path.starts_with(folder)) {
                known.flags.extend(flags_in(text).map(str::to_owned));
                // Flags of clap: fields of its structs, and explicit names.
                let fields = text.lines().filter_map(|line| line.split_once(": "));
                let fields = fields.map(|(field, _)| field.trim_start().trim_start_matches("pub "));
                let others = text.split("long = \"").skip(1).filter_map(|rest| rest.split('"').next());
                known.flags.extend(fields.chain(others).map(|name| format!("--{}", name.replace('_', "-"))));
            }
        }
        known
    }

    /// Returns the names in a code span of a page that do not exist.
    fn missing<'s>(&self, page: &SourceFile, span: &'s str) -> Vec<&'s str> {
        let names = span.split(|c: char| !(c.is_alphanumeric() || "_-./".contains(c)));
        let files = names.filter(|name| is_source(name) && !self.has_file(page, name));
        let flags = flags_in(span).filter(|flag| !self.flags.contains(*flag));
        let words = span.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| is_type(word));
        files.chain(flags).chain(words.filter(|word| !self.words.contains(word))).collect()
    }

    fn has_file(&self, page: &SourceFile, name: &str) -> bool {
        let folder = Path::new(&page.path).parent().unwrap_or(Path::new(""));
        let from_page = links::joined(folder, name).map(|path| path.display().to_string());
        let (end, is_anywhere) = (format!("/{name}"), !name.starts_with("src/"));
        let is_it = |path: &str| from_page.as_deref() == Some(path) || is_anywhere && path.ends_with(&end);
        self.paths.iter().any(|path| is_it(path))
    }
}

/// Returns true if a name is that of a source file, and not only an extension.
fn is_source(name: &str) -> bool {
    let is_named = |stem: &str| stem.ends_with(|c: char| c.is_alphanumeric() || c == '_');
    name.rsplit_once('.').is_some_and(|(stem, ending)| is_named(stem) && LANGUAGES.contains(&ending))
}

/// Returns true if a word has the form of a type name: two or more words, each a capital and small letters.
fn is_type(word: &str) -> bool {
    let pairs = || word.as_bytes().windows(2).map(|pair| [pair[0], pair[1]].map(|c| c.is_ascii_uppercase()));
    word.bytes().all(|c| c.is_ascii_alphabetic())
        && word.starts_with(|c: char| c.is_ascii_uppercase())
        && word.ends_with(|c: char| c.is_ascii_lowercase())
        && pairs().any(|pair| pair == [false, true])
        && !pairs().any(|pair| pair == [true, true])
}

/// Returns the flags in a text, with their dashes.
fn flags_in(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !(c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'));
    let is_name = |name: &str| name.starts_with(|c: char| c.is_ascii_lowercase());
    words.filter(move |word| word.strip_prefix("--").is_some_and(is_name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        let source = "struct Arguments {\n    view_all: bool,\n}\n// `--seed`\n#[arg(long = \"name\")]\n";
        let main = SourceFile::of_text("crates/cli/src/main.rs", source);
        let deep = SourceFile::of_text("crates/plan/src/task/place.rs", "pub struct PlaceGoal;\n");
        let page = SourceFile::of_text("crates/plan/README.md", text);
        check(&[main, deep, page]).into_iter().map(|problem| problem.message).collect()
    }

    #[test]
    fn what_does_not_exist_is_named() {
        assert_eq!(found("# P\n\n`src/place.rs` and `main.ts`").len(), 2);
        assert_eq!(
            found("`cranny plan --no-such-flag -o x`"),
            ["names `--no-such-flag`, which does not exist"]
        );
        assert_eq!(found("`NoSuchType::of`, [`PlaceGoal`]").len(), 1);
    }

    #[test]
    fn what_exists_and_what_is_no_name_is_fine() {
        let fine = "`src/task/place.rs`, `task/place.rs`, `main.rs`, `--view-all --seed=7 --name X`, `PlaceGoal::of`";
        assert_eq!(found(fine), [] as [&str; 0]);
        assert_eq!(found("NoSuchType, `RRT`, `.rs`, `SCENE`\n```\n`NoSuchType`\n```\n"), [] as [&str; 0]);
        assert_eq!(check(&[SourceFile::of_text("CHANGELOG.md", "`NoSuchType`")]), []);
    }
}
