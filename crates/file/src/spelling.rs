use std::ffi::OsStr;
use std::fs;
use std::path::Path;

/// Returns the known names that a misspelt `name` probably meant: at most three, nearest first, none that differs in more than
/// half of its letters.
pub fn nearest_names<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    // Longer names are no typing slips, and comparing them is slow.
    const LONGEST: usize = 200;
    if name.len() > LONGEST {
        return Vec::new();
    }
    let letters = name.chars().count();
    let is_near = |distance: usize, candidate: &str| 2 * distance <= candidate.chars().count().max(2);
    let mut ranked: Vec<(usize, &str)> = known
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        // The distance is at least the difference in length, which is known at once.
        .filter(|candidate| is_near(letters.abs_diff(candidate.chars().count()), candidate))
        .map(|candidate| (edit_distance(name, candidate), candidate))
        .filter(|&(distance, candidate)| is_near(distance, candidate))
        .collect();
    ranked.sort_by_key(|&(distance, _)| distance);
    ranked.into_iter().take(3).map(|(_, candidate)| candidate.to_owned()).collect()
}

/// Returns those of the [`nearest_names`] that are as near as the first.
fn likeliest_names<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut near = nearest_names(name, known);
    let least = near.first().map(|first| edit_distance(name, first));
    near.retain(|near| Some(edit_distance(name, near)) == least);
    near
}

/// Returns the end of a message about an unknown `name`: `; did you mean 'reach'?`, with the nearest known names, if any.
pub fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    suggested(&likeliest_names(name, known))
}

/// Formats the end of that message from names that are already known to be near.
pub fn suggested(near: &[impl AsRef<str>]) -> String {
    let quoted: Vec<String> = near.iter().map(|name| format!("'{}'", name.as_ref())).collect();
    if quoted.is_empty() { String::new() } else { format!("; did you mean {}?", quoted.join(" or ")) }
}

/// Returns [`did_you_mean`] where `name` may be one of `known`, or a file or folder.
pub fn did_you_mean_here<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let mut near = likeliest_names(name, known);
    // A path in a file may count from the folder of that file.
    if !name.contains('/') {
        near.extend(nearest_files(Path::new(name)));
    }
    suggested(&near)
}

/// Returns the files and folders beside a missing `path` that it probably meant, as paths in the same form.
pub fn nearest_files(path: &Path) -> Vec<String> {
    /// Maximum number of entries of a folder that are compared.
    const MOST_ENTRIES: usize = 10_000;
    // Only the stems are compared: a common extension does not make two names similar.
    let (Some(stem), Some(folder)) = (path.file_stem().and_then(OsStr::to_str), path.parent()) else {
        return Vec::new();
    };
    let stem_of = |name: &OsStr| {
        let name = Path::new(name);
        let is_alike = name.extension() == path.extension();
        name.file_stem().filter(|_| is_alike).and_then(OsStr::to_str).map(str::to_owned)
    };
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = fs::read_dir(listed) else { return Vec::new() };
    let mut known: Vec<String> =
        entries.take(MOST_ENTRIES).flatten().filter_map(|entry| stem_of(&entry.file_name())).collect();
    known.sort();
    let near = likeliest_names(stem, known.iter().map(String::as_str));
    let named = |stem: String| match path.extension().and_then(OsStr::to_str) {
        Some(ending) => format!("{stem}.{ending}"),
        None => stem,
    };
    near.into_iter().map(|near| folder.join(named(near)).display().to_string()).collect()
}

/// Returns the least number of letters to insert, remove or replace to turn `a` into `b` (Levenshtein 1966, "Binary codes
/// capable of correcting deletions, insertions and reversals", whole), by the table of Wagner & Fischer 1974, "The
/// string-to-string correction problem", Algorithm X, of which one row is kept.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for j in 0..b.len() {
            let replaced = diagonal + usize::from(letter != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_textbook() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("same", "same"), 0);
    }

    #[test]
    fn a_typing_slip_finds_its_name_first() {
        let known = ["panda_joint1", "panda_joint2", "base_joint_x"];
        assert_eq!(nearest_names("panda_jiont2", known)[0], "panda_joint2");
        assert!(nearest_names("zzz", known).is_empty());
        assert_eq!(did_you_mean("base_joint_y", known), "; did you mean 'base_joint_x'?");
        assert_eq!(did_you_mean("zzz", known), "");
    }
}
