use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::text;
use cranny_file::counted;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny man
  cranny man -o ~/.local/share/man/man1    then `man cranny-plan`")]
pub struct ManualArguments {
    /// Folder for one page per command [default: only the page of `cranny`, on standard output]
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Writes the manual pages of `command` and of all its subcommands, in roff.
pub fn run(arguments: &ManualArguments, command: Command, output: Output) -> Result<Answer, Failure> {
    let Some(folder) = &arguments.output else {
        if output.json {
            let problem =
                "a manual page is roff; with -o FOLDER the pages that are written are listed".to_owned();
            return Err(Failure::Flag { flag: "json", problem });
        }
        let mut page = Vec::new();
        Man::new(command).render(&mut page)?;
        text::print_as_it_is(&page)?;
        return Ok(Answer::Done);
    };
    let mut command = command.disable_help_subcommand(true);
    // Sets the full name of each subcommand.
    command.build();
    let mut pages = Vec::new();
    add_pages(command, &mut pages)?;
    let written = output_file::write_all(folder, &pages, output)?;
    let page = || format!("wrote {} into {}\n", counted(written.len(), "page"), folder.display());
    text::answer(&serde_json::json!({ "files": written }), page, output)?;
    Ok(Answer::Done)
}

/// Adds the pages of a command and of all its subcommands.
fn add_pages(command: Command, pages: &mut Vec<NamedFile>) -> Result<(), Failure> {
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        add_pages(below.clone(), pages)?;
    }
    let page = Man::new(command);
    let mut content = Vec::new();
    page.render(&mut content)?;
    pages.push(NamedFile { name: page.get_filename(), kind: FileKind::Manual, content });
    Ok(())
}
