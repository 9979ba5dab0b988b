//! Compilation of a report's table and PDF plots by LaTeX.

use std::path::{Path, PathBuf};

use crate::step::{self, Readiness, Surroundings};

/// Document that includes both; the table may be wider than its page.
const DOCUMENT: &str = r"\documentclass{article}
\usepackage{booktabs}
\usepackage{graphicx}
\begin{document}
\noindent\resizebox{\linewidth}{!}{\input{table}}

\noindent\includegraphics[width=\linewidth]{plots/all-scenarios-profile-exact}
\end{document}
";

/// Short campaign with a name whose characters LaTeX would interpret as commands if unescaped.
const CAMPAIGN: &str = r"scenarios: ['021', '031']
planners:
  - planner: reach
  - {planner: j-plus-rrt, name: '50% of_$x$ & {#1}^~\'}
runs: 3
time_limit_s: 5
";

/// Checks for pdfLaTeX and the packages of the table.
pub fn readiness(here: &Surroundings) -> Readiness {
    let found = here.command("kpsewhich", &["booktabs.sty", "graphicx.sty"]).output();
    let has_packages = found.is_ok_and(|found| String::from_utf8_lossy(&found.stdout).lines().count() == 2);
    if has_packages && here.command("pdflatex", &["--version"]).output().is_ok() {
        return Readiness::Ready;
    }
    let missing =
        "no `pdflatex` with booktabs and graphicx: install texlive-latex-recommended (Debian) or the like";
    Readiness::Missing(missing.to_owned())
}

/// Runs a short campaign and compiles its report.
///
/// # Errors
/// If any of these fails.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let folder = here.root.join("target/latex");
    // Results of an earlier run would be resumed.
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|error| fault(&folder, &error))?;
    }
    std::fs::create_dir_all(&folder).map_err(|error| fault(&folder, &error))?;
    for (name, content) in [("report.tex", DOCUMENT), ("campaign.yaml", CAMPAIGN)] {
        let file = folder.join(name);
        std::fs::write(&file, content).map_err(|error| fault(&file, &error))?;
    }
    let program = here.built_program()?;
    let pdflatex = PathBuf::from("pdflatex");
    for (program, line) in [
        (&program, "bench run campaign.yaml -o results.db --quiet"),
        (&program, "bench report results.db --plots plots -o table.tex --quiet"),
        (&pdflatex, "-halt-on-error -interaction=batchmode report.tex"),
    ] {
        let mut command = here.command(program, &line.split(' ').collect::<Vec<_>>());
        command.current_dir(&folder);
        step::succeed(command)?;
    }
    Ok(())
}

fn fault(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
