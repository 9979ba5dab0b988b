use serde::de::DeserializeOwned;
use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::{Budget, Error, Options};

use crate::excerpt;

/// Error in a YAML or JSON text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
pub struct TextFault {
    /// Line of the error, counted from 1.
    pub line: usize,
    /// Description of the error, in words for the author of the text.
    pub problem: String,
}

/// Parses a YAML text. Lines of `---` and `...` at its end, as in a dump of a topic, begin no further document.
///
/// # Errors
/// The first error.
pub fn yaml<T: DeserializeOwned>(text: &str) -> Result<T, TextFault> {
    let mut text = text.trim_end();
    while let Some(before) = ["---", "..."].iter().find_map(|mark| text.strip_suffix(mark)) {
        // Marks that do not start a line belong to a value.
        let Some(before) = before.strip_suffix('\n') else { break };
        text = before.trim_end();
    }
    serde_saphyr::from_str_with_options(text, options(text.len())).map_err(|error| {
        let line = error.location().map_or(1, |location| usize::try_from(location.line()).unwrap_or(1));
        TextFault { line: line.max(1), problem: yaml_words(&error) }
    })
}

/// Parses a JSON text.
///
/// # Errors
/// The first error.
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

/// Returns options with a budget by the size of the text: the fixed one of the library would refuse 12 450 obstacles. Aliases,
/// which can grow beyond the text, keep the limits of the library, and so does the nesting depth.
fn options(bytes: usize) -> Options {
    let default = Budget::default();
    serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_reader_input_bytes: None,
            max_nodes: default.max_nodes.max(bytes),
            // A list or mapping has a start event and an end event.
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
        } => "the text is too large or too complex to be read".to_owned(),
        Error::Budget { .. }
        | Error::AliasReplayLimitExceeded { .. }
        | Error::AliasExpansionLimitExceeded { .. }
        | Error::AliasReplayStackDepthExceeded { .. } => {
            "aliases (*name) expand to too much content (write the content out instead)".to_owned()
        }
        Error::MultipleDocuments { .. } => {
            "a second document begins here ('---'), but a file holds one".to_owned()
        }
        Error::Eof { .. } => "the file ends too early (was it cut short?)".to_owned(),
        Error::NullIntoString { .. } => "expected a text, found nothing".to_owned(),
        Error::NonFiniteFloat { value, .. } => format!("'{}' is not a finite number", excerpt(value)),
        Error::BinaryNotUtf8 { .. } => "expected a text, found bytes".to_owned(),
        Error::UnknownAnchor { .. } => {
            "unknown alias (*name): its anchor (&name) must come before it".to_owned()
        }
        other => plain(&other.to_string()),
    }
}

/// Replaces the programming-language terms in serde's messages by the user's terms.
fn plain(said: &str) -> String {
    // The caller adds the location, so that of the message is cut off.
    let said = said.split(" at line ").next().unwrap_or(said);
    let mut words: String = said.to_owned();
    for (theirs, ours) in WORDS {
        words = words.replace(theirs, ours);
    }
    words
}

const WORDS: [(&str, &str); 32] = [
    ("invalid floating point", "this is not a number"),
    ("invalid boolean (strict mode expects true/false)", "this is neither true nor false"),
    ("invalid boolean", "this is neither true nor false"),
    ("invalid i64", "this is not a whole number"),
    ("invalid u128", "this is not a whole number"),
    ("invalid u64", "this is not a whole number"),
    ("invalid u32", "this is not a whole number"),
    ("invalid u16", "this is not a whole number"),
    ("invalid u8", "this is not a whole number"),
    ("invalid usize", "this is not a whole number"),
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
