//! Check that a struct that is read from a file refuses unknown keys.

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Attributes of a struct that prevent lost keys: all are refused, or passed to a type that refuses them.
const REFUSING: [&str; 4] = ["deny_unknown_fields", "try_from", "transparent", "flatten"];
/// Words of a comment before a struct that explains why other keys are not refused.
const STATED: &str = "Other keys";

/// Reports structs of source files that are deserialized and drop unknown keys.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let sources = files.iter().filter(|file| file.has_extension("rs") && !file.path.contains("/tests/"));
    let dropping = sources.flat_map(|file| {
        file.text().map(structs_that_drop).unwrap_or_default().into_iter().map(|name| {
            Problem::new(
                &file.path,
                format!("the struct `{name}` is read from files and drops keys that it does not know"),
                format!("add `#[serde(deny_unknown_fields)]`, or a comment that begins `// {STATED}` and states why"),
            )
        })
    });
    dropping.collect()
}

fn structs_that_drop(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("#[derive(") {
        let item = &text[at..];
        let derives = item.split(')').next().unwrap_or_default();
        let Some(begin) = item.find("struct ").filter(|begin| !item[..*begin].contains("enum ")) else {
            continue;
        };
        let named = &item[begin + "struct ".len()..];
        // A tuple struct has no keys.
        let Some(open) = named.find(['{', ';', '(']).filter(|open| named[*open..].starts_with('{')) else {
            continue;
        };
        let end = named.find("\n}").or_else(|| named.find('}')).unwrap_or(named.len());
        let before = text[..at].rsplit("\n\n").next().unwrap_or_default();
        let whole = [before, &item[..begin], &named[..end]].concat();
        let is_read = derives.split(['(', ',']).any(|name| name.trim() == "Deserialize");
        if is_read && !REFUSING.iter().any(|word| whole.contains(word)) && !whole.contains(STATED) {
            found.push(named[..open].trim().to_owned());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        structs_that_drop(text)
    }

    #[test]
    fn a_struct_that_drops_keys_is_named() {
        assert_eq!(found("#[derive(Debug, Deserialize)]\nstruct Scene {\n    id: String,\n}\n"), ["Scene"]);
        assert_eq!(found("#[derive(Deserialize)]\npub struct A<T> {\n    a: T,\n}\n"), ["A<T>"]);
    }

    #[test]
    fn what_refuses_keys_or_states_why_not_is_fine() {
        for text in [
            "#[derive(Deserialize)]\n#[serde(deny_unknown_fields)]\nstruct Scene {\n    id: String,\n}\n",
            "// Other keys are those of the file that it begins.\n#[derive(Deserialize)]\nstruct Head {\n    id: u8,\n}\n",
            "#[derive(Serialize)]\nstruct Scene {\n    id: String,\n}\n",
            "#[derive(Deserialize)]\nstruct Metres(f64);\n",
            "#[derive(Deserialize)]\nenum Kind {\n    A { a: u8 },\n}\n",
        ] {
            assert_eq!(found(text), [] as [&str; 0], "{text}");
        }
    }
}
