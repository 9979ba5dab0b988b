use clap::{Args, Subcommand};
use cranny_dataset::recipe_schema;

use crate::arguments::Output;
use crate::content::dataset_check::{self, CheckArguments};
use crate::content::dataset_export::{self, ExportArguments, ExtractArguments};
use crate::content::dataset_generate::{self, GenerateArguments, MergeArguments};
use crate::failure::Failure;
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
pub struct DatasetArguments {
    #[command(subcommand)]
    pub command: DatasetCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum DatasetCommand {
    /// Make a set of proven demonstrations, or a shard of one, from a recipe
    Generate(GenerateArguments),
    /// Merge the shards of a set
    Merge(MergeArguments),
    /// Prove the rows of a set again, and print statistics
    Check(CheckArguments),
    /// Write a row as the folder of a scenario, with its path as a plan file
    Extract(ExtractArguments),
    /// Write the demonstrations in the layout of another program
    Export(ExportArguments),
    /// Print the JSON Schema of recipes
    Schema,
}

pub fn run(arguments: &DatasetArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        DatasetCommand::Generate(arguments) => dataset_generate::run(arguments, output),
        DatasetCommand::Merge(arguments) => dataset_generate::merge(arguments, output),
        DatasetCommand::Check(arguments) => dataset_check::run(arguments, output),
        DatasetCommand::Extract(arguments) => dataset_export::extract(arguments, output),
        DatasetCommand::Export(arguments) => dataset_export::run(arguments, output),
        DatasetCommand::Schema => {
            text::print(&recipe_schema())?;
            Ok(Answer::Done)
        }
    }
}
