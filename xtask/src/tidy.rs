//! Rules on the structure of the code that the compiler does not enforce.
//!
//! Each check is a pure function from crates and files to [`Problem`]s, in a module of its own, with tests on bad examples.

mod citations;
mod crate_table;
mod file_length;
mod file_opening;
mod floors;
mod folder_size;
mod foreign_data;
mod frame_names;
mod machine_paths;
mod module_circles;
mod module_names;
mod named_things;
pub mod notices;
mod page_links;
mod slice_docs;
mod system_calls;
mod test_files;
mod unknown_keys;
mod unsafe_code;
mod walks;

use crate::c_api::header;
use crate::checkout::{self, SourceFile};
use crate::comment_words;
use crate::member::{self, Member};
use crate::problem::Problem;
use crate::released_data;

/// Treatment of the generated sections of pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Generated {
    /// Report a section that differs from the generated text.
    Compare,
    /// Write the generated text.
    Write,
}

/// Runs all checks and returns true if the checkout is tidy; prints every problem to stderr.
///
/// # Errors
/// If cargo or git cannot describe the checkout, a page cannot be written, or `CRANNY_DATA` is wrong or required but unset.
pub fn run(generated: Generated) -> Result<bool, String> {
    let (root, members) = member::read_workspace()?;
    if generated == Generated::Write {
        crate_table::write(&root, &members)?;
        notices::write(&root)?;
        header::write(&root)?;
    }
    let files = checkout::read_files(&root)?;
    let data = released_data::folder()?;

    let mut problems = problems_of(&members, &files);
    problems.extend(notices::check(&root, &files)?);
    problems.extend(header::check(&root, &files)?);
    match &data {
        Some(folder) => problems.extend(foreign_data::check(&files, folder)?),
        None => eprintln!("SKIPPED: tidy, comparison with the released data (set {})", released_data::DATA),
    }
    for problem in &problems {
        eprintln!("{problem}");
    }
    match problems.len() {
        0 => println!("tidy: {} crates and {} files in order", members.len(), files.len()),
        count => eprintln!("tidy: {count} problem{}", if count == 1 { "" } else { "s" }),
    }
    Ok(problems.is_empty())
}

/// Returns the findings of the checks that need only the checkout.
fn problems_of(members: &[Member], files: &[SourceFile]) -> Vec<Problem> {
    [
        floors::check(members),
        crate_table::check(members, files),
        module_circles::check(files),
        module_names::check(files),
        file_length::check(files),
        file_opening::check(files),
        folder_size::check(files),
        system_calls::check(files),
        unsafe_code::check(members, files),
        machine_paths::check(files),
        test_files::check(files),
        walks::check(files),
        page_links::check(files),
        unknown_keys::check(files),
        citations::check(files),
        named_things::check(files),
        slice_docs::check(files),
        frame_names::check(files),
        comment_words::check(files),
    ]
    .concat()
}
