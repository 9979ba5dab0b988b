use serde::de::DeserializeOwned;
use serde_saphyr::{Budget, Options};

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
    let mut parsed = None;
    yaml_with(text, &mut |deserializer| {
        parsed = Some(erased_serde::deserialize(deserializer)?);
        Ok(())
    })?;
    parsed.ok_or_else(|| TextFault {
        line: 1,
        problem: "the file ends too early (was it cut short?)".to_owned(),
    })
}

/// Visitor of the deserializer of a text, which stores what it reads itself.
type Visit<'a> = dyn FnMut(&mut dyn erased_serde::Deserializer<'_>) -> Result<(), erased_serde::Error> + 'a;

/// Parses a YAML text by one copy of the parser for all types: a copy for each took a fifth of the first build.
fn yaml_with(text: &str, visit: &mut Visit) -> Result<(), TextFault> {
    let parsed = serde_saphyr::with_deserializer_from_str_with_options(text, options(text.len()), |parser| {
        visit(&mut <dyn erased_serde::Deserializer>::erase(parser)).map_err(serde::de::Error::custom)
    });
    parsed.map_err(|error| yaml_fault(&error.to_string()))
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
        with_snippet: false,
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

/// Returns the error for a message of the parser. Each level of nesting appends its own location to the message of an inner one.
fn yaml_fault(message: &str) -> TextFault {
    // The first mark before a location: keys of the text may contain the mark too.
    let find = |mark: &str| {
        message.match_indices(mark).find_map(|(at, _)| {
            let (line, _) = message[at + mark.len()..].split_once(", column ")?;
            let before = message[..at].trim_end_matches(" (defined").trim_end_matches(" (used");
            Some((before, line.parse::<usize>().ok()?))
        })
    };
    // An alias has two locations: where its content is, and where it is used.
    let (problem, line) = match (find(" (defined at line "), find(" (used at line "), find(" at line ")) {
        (Some((problem, _)), Some((_, line)), _) | (_, _, Some((problem, line))) => (problem, line),
        _ => (message, 1),
    };
    TextFault { line: line.max(1), problem: yaml_words(problem) }
}

/// Returns a message of the parser in the user's terms.
fn yaml_words(message: &str) -> String {
    if let Some(key) = message.strip_prefix("duplicate mapping key") {
        let key = key.strip_prefix(": ").and_then(|key| key.strip_suffix(DUPLICATE));
        let key = key.map(|key| format!(" '{}'", excerpt(key))).unwrap_or_default();
        return format!("the key{key} is given twice (keep one of the two)");
    }
    if let Some(value) = message.strip_prefix("non-finite float `").and_then(|rest| rest.split('`').next()) {
        return format!("'{}' is not a finite number", excerpt(value));
    }
    if let Some(breach) = message.strip_prefix("budget breached: ") {
        return match breach.split(|letter: char| !letter.is_alphanumeric()).next() {
            Some("Depth") => {
                format!("lists and mappings are nested more than {} deep", Budget::default().max_depth)
            }
            Some("InputBytes" | "ScalarBytes" | "CommentBytes" | "Documents" | "MergeKeys") => {
                "the text is too large or too complex to be read".to_owned()
            }
            _ => ALIASES.to_owned(),
        };
    }
    let found = KINDS.iter().find(|(start, _)| message.starts_with(start));
    found.map_or_else(|| plain(message), |(_, words)| (*words).to_owned())
}

const DUPLICATE: &str = ", set DuplicateKeyPolicy in Options if acceptable";

const ALIASES: &str = "aliases (*name) expand to too much content (write the content out instead)";

/// Starts of messages of the parser, and the messages in their place.
const KINDS: [(&str, &str); 8] = [
    ("alias replay", ALIASES),
    ("alias expansion", ALIASES),
    ("alias references unknown", "unknown alias (*name): its anchor (&name) must come before it"),
    ("multiple YAML documents", "a second document begins here ('---'), but a file holds one"),
    ("unexpected end of input", "the file ends too early (was it cut short?)"),
    ("unexpected end of file", "the file ends too early (was it cut short?)"),
    ("cannot deserialize null into string", "expected a text, found nothing"),
    ("!!binary", "expected a text, found bytes"),
];

/// Replaces the programming-language terms in serde's messages by the user's terms.
fn plain(said: &str) -> String {
    let mut words: String = said.to_owned();
    for (theirs, ours) in WORDS {
        words = words.replace(theirs, ours);
    }
    too_large(&words).unwrap_or(words)
}

/// Returns another message for a whole number beyond 64 bits, which is read as a number of another kind.
fn too_large(words: &str) -> Option<String> {
    let (before, rest) = words.split_once("invalid type: floating point `")?;
    let (number, after) = rest.split_once("`, expected a whole number")?;
    let value = number.parse::<f64>().ok().filter(|value| value.abs() >= u64::MAX as f64)?;
    let after = after.strip_prefix(", at least 0").unwrap_or(after);
    Some(format!("{before}{value:e} is too large: expected a whole number up to {}{after}", u64::MAX))
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
