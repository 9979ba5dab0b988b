use clap::{Args, Command};
use clap_complete::Shell;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::text;

#[derive(Clone, Copy, Debug, Args)]
#[command(after_help = "Examples:
  cranny completions bash > ~/.local/share/bash-completion/completions/cranny
  cranny completions zsh > ~/.zfunc/_cranny            (with ~/.zfunc in fpath)
  cranny completions fish > ~/.config/fish/completions/cranny.fish")]
pub struct CompletionsArguments {
    /// Shell to complete for
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script that completes the words of `command` in a shell.
pub fn run(arguments: CompletionsArguments, mut command: Command, output: Output) -> Result<Answer, Failure> {
    if output.json {
        let problem = "what is printed is a script for the shell".to_owned();
        return Err(Failure::Flag { flag: "json", problem });
    }
    let mut script = Vec::new();
    let name = command.get_name().to_owned();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    text::print_as_it_is(&script)?;
    Ok(Answer::Done)
}
