use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use cranny_bench::report::{Enclosure, Plot, Summary, plots};
use cranny_bench::{BenchError, Results};
use cranny_file::counted;
use rayon::prelude::*;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::{campaigns::report_paths, campaigns::report_pictures, progress, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench report results.db                          a page: results.html
  cranny bench report results.db -o page.html --plots plots
  cranny bench report results.db --paths                  and the worst trials' paths, a click away
  cranny bench report results.db --format json            every figure, on standard output
  cranny bench report results.db --format latex -o table.tex
  cranny bench report results.db --format markdown
  cranny bench report results.db --format csv > table.csv

The page holds everything and needs no network. latex (with the package booktabs), markdown and csv are the paper's
Table I: goals, success, mean and standard deviation of the time, a failure counted as the limit. Plots are written as
SVG, PDF and PNG, named by environment, planner and criterion; PDF is for LaTeX.")]
pub struct ReportArguments {
    /// Results of campaigns, as `cranny bench run` wrote them
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// File to write the report to [default: the name of RESULTS with .html, in this folder; standard output for the other
    /// formats]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Format of the report [default: from the extension of FILE, html if it has none]
    #[arg(long, value_enum)]
    format: Option<ReportFormat>,
    /// Write each plot to this folder, as SVG, PDF and PNG
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// Write the page of `cranny view` for each of the worst trials with a path, about 2 MB each, to a folder beside the report
    /// (`results-paths`), and link to it
    #[arg(long)]
    paths: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReportFormat {
    /// Page with tables and plots
    Html,
    /// All figures, including curves
    Json,
    /// Table of the paper
    Latex,
    /// Table of the paper
    Markdown,
    /// Table of the paper, one line per cell, with all digits
    Csv,
}

impl ReportFormat {
    /// Returns the format for the extension of a file name.
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
    let named = arguments.output.as_deref().and_then(ReportFormat::of_file);
    let format = arguments.format.or(named).unwrap_or(ReportFormat::Html);
    let file = match &arguments.output {
        Some(file) => Some(file.clone()),
        // Standard output carries one JSON document; a file is written only if it was named.
        None if format == ReportFormat::Html && !output.json => Some(default_page(&arguments.results)),
        None => None,
    };
    let page = file.as_deref().filter(|_| format == ReportFormat::Html);
    if arguments.paths && page.is_none() {
        let problem =
            "only the HTML page links to paths: give it a name with -o, or leave out --format".to_owned();
        return Err(Failure::Flag { flag: "paths", problem });
    }
    let results = Results::open(&arguments.results)?;
    let summary = Summary::of_results(&results)?;
    // Checks the output file before pictures and paths are made.
    if let Some(file) = &file {
        output_file::check(file, format.kind(), output)?;
    }
    if let Some(folder) = &arguments.plots {
        let count = write_plots(&summary, folder, output)?;
        if !output.quiet && !output.json {
            eprintln!("{count} plots in {}, each as SVG, PDF and PNG", folder.display());
        }
    }
    if output.json {
        text::print_json(&summary)?;
    }
    let mut enclosure = Enclosure::default();
    if let Some(page) = page {
        enclosure.pictures = report_pictures::pictures(&summary, &results);
        if arguments.paths {
            enclosure.paths = report_paths::write(&summary, &results, page, output)?;
        }
    }
    match file {
        None if output.json => {}
        None => text::print(&content(&summary, format, &enclosure)?)?,
        Some(file) => {
            let content = content(&summary, format, &enclosure)?;
            output_file::write(&file, format.kind(), content.as_bytes(), output)?;
            if !output.quiet && !output.json {
                let (trials, rows, paths) = (summary.trials, summary.rows.len(), enclosure.paths.len());
                let folder = report_paths::folder_of(&file);
                let beside = if arguments.paths {
                    format!(", {} in {}", counted(paths, "path"), folder.display())
                } else {
                    String::new()
                };
                let (trials, rows) = (counted(trials, "trial"), counted(rows, "row"));
                text::print(&format!("{}: {trials} in {rows}{beside}\n", file.display()))?;
            }
        }
    }
    Ok(Answer::Done)
}

fn content(summary: &Summary, format: ReportFormat, enclosure: &Enclosure) -> Result<String, Failure> {
    Ok(match format {
        ReportFormat::Html => summary.html(enclosure),
        ReportFormat::Json => text::json(summary)?,
        ReportFormat::Latex => summary.latex(),
        ReportFormat::Markdown => summary.markdown(),
        ReportFormat::Csv => summary.csv(),
    })
}

/// Default report file: `results.db` → `results.html`, in this folder.
fn default_page(results: &Path) -> PathBuf {
    let name = results.file_stem().unwrap_or(results.as_os_str());
    PathBuf::from(name).with_extension("html")
}

/// Writes the plots to `folder` and returns their number.
fn write_plots(summary: &Summary, folder: &Path, output: Output) -> Result<usize, Failure> {
    let plots = plots(summary);
    let bar = progress::bar(plots.len() as u64, output.quiet);
    let draw = |plot: &Plot| -> Result<[NamedFile; 3], BenchError> {
        bar.inc(1);
        let file =
            |ending, kind, content| NamedFile { name: format!("{}.{ending}", plot.name), kind, content };
        Ok([
            file("svg", FileKind::Svg, plot.svg().into_bytes()),
            file("pdf", FileKind::Pdf, plot.pdf()?),
            file("png", FileKind::Png, plot.png()?),
        ])
    };
    let files =
        plots.par_iter().map(draw).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect::<Vec<_>>();
    output_file::write_all(folder, &files, output)?;
    bar.finish_and_clear();
    Ok(plots.len())
}
