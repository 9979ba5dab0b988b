use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cranny_bench::Results;
use cranny_bench::report::{Summary, plots};

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::{progress, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench report results.db                          a page: results.html
  cranny bench report results.db -o page.html --plots plots
  cranny bench report results.db --format json            every figure, on standard output
  cranny bench report results.db --format latex -o table.tex
  cranny bench report results.db --format markdown
  cranny bench report results.db --format csv > table.csv

The page holds everything and needs no network. latex (with the package booktabs), markdown and csv are the paper's
Table I: goals, success, mean and standard deviation of the time, a failure counted as the limit. Plots are written as
SVG and PNG, named by environment, planner and criterion.")]
pub struct ReportArguments {
    /// Results of campaigns, as `cranny bench run` wrote them
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Where to write the report [default: the name of RESULTS with .html, in this folder; standard output
    /// for the other formats]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What to write [default: by the ending of FILE, html if it has none]
    #[arg(long, value_enum)]
    format: Option<ReportFormat>,
    /// Write each plot to this folder, as SVG and as PNG
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReportFormat {
    /// One page with tables and plots
    Html,
    /// Every figure, curves included
    Json,
    /// The paper's table
    Latex,
    /// The paper's table
    Markdown,
    /// The paper's table, a line a cell, with all digits
    Csv,
}

impl ReportFormat {
    /// What the ending of a file's name asks for.
    fn of_file(file: &Path) -> Option<Self> {
        match file.extension()?.to_str()? {
            "html" | "htm" => Some(Self::Html),
            "json" => Some(Self::Json),
            "tex" => Some(Self::Latex),
            "md" => Some(Self::Markdown),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }

    fn kind(self) -> FileKind {
        match self {
            Self::Html => FileKind::ReportPage,
            Self::Json => FileKind::ReportJson,
            Self::Latex => FileKind::LatexTable,
            Self::Markdown => FileKind::MarkdownTable,
            Self::Csv => FileKind::CsvTable,
        }
    }
}

pub fn run(arguments: &ReportArguments, output: Output) -> Result<Answer, Failure> {
    let summary = Summary::of_results(&Results::open(&arguments.results)?)?;
    if let Some(folder) = &arguments.plots {
        let count = write_plots(&summary, folder, output)?;
        if !output.quiet && !output.json {
            eprintln!("{count} plots in {}, each as SVG and PNG", folder.display());
        }
    }
    if output.json {
        text::print_json(&summary)?;
    }
    let named = arguments.output.as_deref().and_then(ReportFormat::of_file);
    let format = arguments.format.or(named).unwrap_or(ReportFormat::Html);
    let file = match &arguments.output {
        Some(file) => Some(file.clone()),
        None if format == ReportFormat::Html => Some(default_page(&arguments.results)),
        None => None,
    };
    match file {
        // One document on standard output is what was asked for; a file only if it was named.
        _ if output.json && arguments.output.is_none() => {}
        None => text::print(&content(&summary, format)?)?,
        Some(file) => {
            output_file::write(&file, format.kind(), content(&summary, format)?.as_bytes(), output)?;
            if !output.quiet && !output.json {
                let (trials, rows) = (summary.trials, summary.rows.len());
                text::print(&format!("{}: {trials} trials in {rows} rows\n", file.display()))?;
            }
        }
    }
    Ok(Answer::Done)
}

fn content(summary: &Summary, format: ReportFormat) -> Result<String, Failure> {
    Ok(match format {
        ReportFormat::Html => summary.html(),
        ReportFormat::Json => text::json(summary)?,
        ReportFormat::Latex => summary.latex(),
        ReportFormat::Markdown => summary.markdown(),
        ReportFormat::Csv => summary.csv(),
    })
}

/// `results.db` → `results.html`, in this folder.
fn default_page(results: &Path) -> PathBuf {
    let name = results.file_stem().unwrap_or(results.as_os_str());
    PathBuf::from(name).with_extension("html")
}

/// How many plots.
fn write_plots(summary: &Summary, folder: &Path, output: Output) -> Result<usize, Failure> {
    let plots = plots(summary);
    let bar = progress::bar(plots.len() as u64, output.quiet);
    let mut files = Vec::new();
    for plot in &plots {
        let mut add = |ending: &str, kind, content| {
            files.push(NamedFile { name: format!("{}.{ending}", plot.name), kind, content });
        };
        add("svg", FileKind::Svg, plot.svg().into_bytes());
        add("png", FileKind::Png, plot.png()?);
        bar.inc(1);
    }
    output_file::write_all(folder, &files, output)?;
    bar.finish_and_clear();
    Ok(plots.len())
}
