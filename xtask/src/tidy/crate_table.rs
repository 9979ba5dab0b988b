//! Check of the crate table of `ARCHITECTURE.md` against the manifests.

use std::cmp::Reverse;
use std::fmt::Write as _;
use std::path::Path;

use crate::checkout::SourceFile;
use crate::member::Member;
use crate::problem::Problem;

const PAGE: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- crates:begin -->";
const END: &str = "<!-- crates:end -->";

/// Reports a missing page, missing markers, or a table that differs from the manifests.
pub fn check(members: &[Member], files: &[SourceFile]) -> Vec<Problem> {
    let Some(page) = files.iter().find(|file| file.path == PAGE).and_then(SourceFile::text) else {
        return vec![Problem::new(PAGE, "no such page", format!("write it, with {BEGIN} and {END} in it"))];
    };
    match with_table(page, &table(members)) {
        None => vec![Problem::new(
            PAGE,
            "no place for the crate table",
            format!("put the lines {BEGIN} and {END} where it belongs"),
        )],
        Some(right) if right != page => vec![Problem::new(
            PAGE,
            "the crate table differs from the manifests",
            "run `cargo xtask tidy --write`",
        )],
        Some(_) => Vec::new(),
    }
}

/// Writes the table into the page if it differs.
///
/// # Errors
/// If the page cannot be read or written. A page without markers is left as it is, for [`check`] to report.
pub fn write(root: &Path, members: &[Member]) -> Result<(), String> {
    let path = root.join(PAGE);
    let page = std::fs::read_to_string(&path).map_err(|error| format!("{PAGE}: {error}"))?;
    match with_table(&page, &table(members)) {
        Some(right) if right != page => {
            std::fs::write(&path, right).map_err(|error| format!("{PAGE}: {error}"))?;
            println!("tidy: wrote the crate table of {PAGE}");
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Returns the table as Markdown, highest layer (floor) first, then by name.
fn table(members: &[Member]) -> String {
    let mut rooms: Vec<&Member> = members.iter().filter(|member| member.is_room()).collect();
    rooms.sort_by_key(|room| (Reverse(room.floor), &room.name));
    let mut text = String::from("| floor | crate | what it answers |\n|---|---|---|\n");
    for room in rooms {
        let floor = room.floor.map_or_else(|| "?".to_owned(), |floor| floor.to_string());
        let _ = writeln!(text, "| {floor} | [`{}`]({}) | {} |", room.name, room.folder, room.description);
    }
    text
}

/// Returns `page` with `table` between the markers, `None` if they are missing or in the wrong order.
fn with_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(name: &str, floor: u64, description: &str) -> Member {
        Member {
            name: format!("cranny-{name}"),
            folder: format!("crates/{name}"),
            description: description.to_owned(),
            floor: Some(floor),
            ..Member::default()
        }
    }

    fn house() -> [Member; 3] {
        [room("grasp", 2, "Grasps"), room("robot", 2, "Links"), room("plan", 4, "Planners")]
    }

    fn page(table: &str) -> SourceFile {
        SourceFile::of_text(PAGE, &format!("# House\n\n{BEGIN}\n{table}{END}\n\nMore.\n"))
    }

    #[test]
    fn the_highest_floor_comes_first_and_names_decide_within_one() {
        assert_eq!(
            table(&house()),
            "| floor | crate | what it answers |\n|---|---|---|\n\
             | 4 | [`cranny-plan`](crates/plan) | Planners |\n\
             | 2 | [`cranny-grasp`](crates/grasp) | Grasps |\n\
             | 2 | [`cranny-robot`](crates/robot) | Links |\n"
        );
    }

    #[test]
    fn a_table_of_the_manifests_is_fine_and_any_other_fails() {
        let right = table(&house());
        assert_eq!(check(&house(), &[page(&right)]), []);
        for wrong in ["", &right.replace("Links", "Where the links are"), &right.replace("| 4 ", "| 3 ")] {
            let problems = check(&house(), &[page(wrong)]);
            assert_eq!(problems.len(), 1, "{wrong}");
            assert!(problems[0].hint.contains("--write"));
        }
    }

    #[test]
    fn a_missing_page_or_marker_fails() {
        assert_eq!(check(&house(), &[]).len(), 1);
        for text in ["# House\n".to_owned(), format!("{BEGIN}\n"), format!("{END}\n{BEGIN}\n")] {
            assert_eq!(check(&house(), &[SourceFile::of_text(PAGE, &text)]).len(), 1, "{text}");
        }
    }

    #[test]
    fn write_mends_what_check_finds_and_keeps_the_rest() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join(PAGE);
        std::fs::write(&path, &page("old\n").bytes).expect("write");
        write(folder.path(), &house()).expect("written");
        let written = std::fs::read_to_string(&path).expect("read");
        assert!(written.starts_with("# House\n") && written.ends_with("\n\nMore.\n"), "{written}");
        assert_eq!(check(&house(), &[SourceFile::of_text(PAGE, &written)]), []);
    }
}
