use serde::de::DeserializeOwned;
use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::{Budget, Error, Options};

use crate::excerpt;

/// What is wrong with a YAML or JSON text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
pub struct TextFault {
    /// Where, from 1.
    pub line: usize,
    /// What, in words for the one who wrote the text.
    pub problem: String,
}

/// Value of a YAML text. Lines of `---` and `...` at its end, as in a dump of a topic, begin no other document.
///
/// # Errors
/// The first fault.
pub fn yaml<T: DeserializeOwned>(text: &str) -> Result<T, TextFault> {
    let mut text = text.trim_end();
    while let Some(before) = ["---", "..."].iter().find_map(|mark| text.strip_suffix(mark)) {
        // Farther to the right they belong to a text.
        let Some(before) = before.strip_suffix('\n') else { break };
        text = before.trim_end();
    }
    serde_saphyr::from_str_with_options(text, options(text.len())).map_err(|error| {
        let line = error.location().map_or(1, |location| usize::try_from(location.line()).unwrap_or(1));
        TextFault { line: line.max(1), problem: yaml_words(&error) }
    })
}

/// What a JSON text says.
///
/// # Errors
/// The first fault.
pub fn json<T: DeserializeOwned>(text: &[u8]) -> Result<T, TextFault> {
    serde_json::from_slice(text).map_err(|error| {
        let said = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let problem = match error.classify() {
            serde_json::error::Category::Eof => "the file ends too early (was it cut short?)".to_owned(),
            _ => plain(said.strip_suffix(&place).unwrap_or(&said)),
        };
        TextFault { line: error.line().max(1), problem }
    })
}

/// A text of some bytes has no more nodes than bytes: the library's fixed budget would refuse 12 450 obstacles.
/// What can grow beyond the text, aliases, keeps the library's bounds, and so does the depth.
fn options(bytes: usize) -> Options {
    let default = Budget::default();
    serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_reader_input_bytes: None,
            max_nodes: default.max_nodes.max(bytes),
            // A list or mapping has a begin and an end.
            max_events: default.max_events.max(bytes.saturating_mul(2)),
            max_total_scalar_bytes: default.max_total_scalar_bytes.max(bytes),
            max_total_comment_bytes: default.max_total_comment_bytes.max(bytes),
        },
    }
}

fn yaml_words(error: &Error) -> String {
    match error {
        Error::AliasError { error, .. } | Error::WithSnippet { error, .. } => yaml_words(error),
        Error::DuplicateMappingKey { key, .. } => {
            let key = key.as_ref().map(|key| format!(" '{}'", excerpt(key))).unwrap_or_default();
            format!("the key{key} is given twice (keep one of the two)")
        }
        Error::Budget { breach: BudgetBreach::Depth { .. }, .. } => {
            format!("lists and mappings are nested more than {} deep", Budget::default().max_depth)
        }
        Error::Budget {
            breach:
                BudgetBreach::InputBytes { .. }
                | BudgetBreach::ScalarBytes { .. }
                | BudgetBreach::CommentBytes { .. }
                | BudgetBreach::Documents { .. }
                | BudgetBreach::MergeKeys { .. },
            ..
        } => "the text is larger or more complex than any that is read".to_owned(),
        Error::Budget { .. }
        | Error::AliasReplayLimitExceeded { .. }
        | Error::AliasExpansionLimitExceeded { .. }
        | Error::AliasReplayStackDepthExceeded { .. } => {
            "aliases (*name) repeat more than any real file does (write it out)".to_owned()
        }
        Error::MultipleDocuments { .. } => {
            "a second document begins here ('---'), but a file holds one".to_owned()
        }
        Error::Eof { .. } => "the file ends too early (was it cut short?)".to_owned(),
        Error::NullIntoString { .. } => "a text belongs here, but there is nothing".to_owned(),
        Error::NonFiniteFloat { value, .. } => format!("'{}' is not a finite number", excerpt(value)),
        Error::BinaryNotUtf8 { .. } => "a text belongs here, but these are bytes".to_owned(),
        Error::UnknownAnchor { .. } => "this alias (*name) names nothing that comes before it".to_owned(),
        other => plain(&other.to_string()),
    }
}

/// The words of serde's messages that are those of a programming language, in the user's.
fn plain(said: &str) -> String {
    // What a message adds about the place is said by whoever shows it.
    let said = said.split(" at line ").next().unwrap_or(said);
    let mut words: String = said.to_owned();
    for (theirs, ours) in WORDS {
        words = words.replace(theirs, ours);
    }
    words
}

const WORDS: [(&str, &str); 32] = [
    ("invalid floating point", "this is no number"),
    ("invalid boolean (strict mode expects true/false)", "this is neither true nor false"),
    ("invalid boolean", "this is neither true nor false"),
    ("invalid i64", "this is no whole number"),
    ("invalid u128", "this is no whole number"),
    ("invalid u64", "this is no whole number"),
    ("invalid u32", "this is no whole number"),
    ("invalid u16", "this is no whole number"),
    ("invalid u8", "this is no whole number"),
    ("invalid usize", "this is no whole number"),
    ("expected sequence start", "expected a list"),
    ("expected string scalar", "expected a text"),
    ("expected a sequence", "expected a list"),
    ("expected a map", "expected a mapping"),
    ("expected mapping start", "expected a mapping (key: value)"),
    ("expected an array of length", "expected a list of length"),
    ("expected f64", "expected a number"),
    ("expected f32", "expected a number"),
    ("expected u64", "expected a whole number, at least 0"),
    ("expected u32", "expected a whole number, at least 0"),
    ("expected usize", "expected a whole number, at least 0"),
    ("expected i64", "expected a whole number"),
    ("expected a nonzero usize", "expected a whole number, at least 1"),
    ("expected a nonzero u64", "expected a whole number, at least 1"),
    ("expected a nonzero u32", "expected a whole number, at least 1"),
    ("invalid type: sequence", "invalid type: a list"),
    ("invalid type: map", "invalid type: a mapping"),
    ("invalid type: null", "invalid type: nothing"),
    ("expected a string", "expected a text"),
    ("expected a boolean", "expected true or false"),
    ("expected struct ", "expected a mapping for "),
    ("unexpected container end", "a list or mapping ends here that did not begin"),
];
