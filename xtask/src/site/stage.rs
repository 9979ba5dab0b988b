//! Input of mdBook: pages of the checkout, and generated pages.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::step::{self, Surroundings};

use super::links;

/// Address of files that are not pages.
const REPOSITORY: &str = "https://github.com/cranny-planning/cranny/blob/main";

/// Page at the root of the site.
const START: &str = "docs/index.md";

/// Camera direction of the scene on the start page: turned and raised, in degrees.
const CAMERA: &str = "--camera=-96,18";

pub struct Stage<'a> {
    pub here: &'a Surroundings,
    /// Folder that mdBook reads.
    pub source: &'a Path,
    pub summary: String,
}

impl Stage<'_> {
    /// Copies the pages of `docs` and `benchmarks`, and the files that they show.
    pub fn copy_pages(&self) -> Result<(), String> {
        for folder in ["docs", "docs/decisions", "docs/pictures", "docs/schema", "benchmarks"] {
            let to = self.source.join(folder);
            fs::create_dir_all(&to).map_err(|error| told(&to, &error))?;
            for entry in entries(&self.here.root.join(folder))? {
                if entry.is_file() {
                    let to = to.join(staged_name(&entry));
                    fs::copy(&entry, &to).map_err(|error| told(&to, &error))?;
                }
            }
        }
        Ok(())
    }

    /// Draws a live page and a picture of each built-in scenario of one pick, with the target carried out, or put inside.
    pub fn draw_gallery(&self) -> Result<(), String> {
        let live = self.source.join("docs/live");
        fs::create_dir_all(&live).map_err(|error| told(&live, &error))?;
        let listing = self.said(&["list"])?;
        let scenarios: Vec<(&str, &str)> = listing
            .lines()
            .filter_map(|line| line.trim().split_once("  "))
            .filter(|(id, _)| {
                id.len() == 3 && id.bytes().all(|byte| byte.is_ascii_digit()) && !id.starts_with('2')
            })
            .collect();
        let mut page = String::from(
            "# Gallery\n\nThe twenty scenarios, each with a plan that takes its object out, and twelve in which it is \
             brought in. A picture opens a live page: turn it, play it, look at the clearance along the way.\n\n<div class=\"gallery\" style=\"display: grid; gap: 1rem; \
             grid-template-columns: repeat(auto-fill, minmax(16rem, 1fr));\">\n",
        );
        for (id, description) in &scenarios {
            let file = |ending: &str| live.join(format!("{id}{ending}")).display().to_string();
            let (plan, html, png) = (file(".plan.json"), file(".html"), file(".png"));
            // If the target cannot be carried out, the page shows the reach alone.
            let task = if id.starts_with('1') { ["--place", "inside"] } else { ["--carry", "home"] };
            let carried = self.cranny(&[&["plan", id, "--quiet", "-o", &plan], &task[..]].concat()).status();
            if !carried.is_ok_and(|status| status.success()) {
                step::succeed(self.cranny(&["plan", id, "--quiet", "-o", &plan]))?;
            }
            step::succeed(self.cranny(&["render", id, &plan, "--quiet", "-o", &html]))?;
            let picture =
                ["render", id, &plan, "--quiet", "--size", "400x300", "--time", "1", CAMERA, "-o", &png];
            step::succeed(self.cranny(&picture))?;
            let _ = writeln!(
                page,
                "<a href=\"live/{id}.html\"><img src=\"live/{id}.png\" width=\"400\" height=\"300\" loading=\"lazy\" \
                 alt=\"\" style=\"width: 100%; height: auto; border-radius: 0.5rem;\"><br><b>{id}</b> {description}</a>"
            );
        }
        page.push_str("</div>\n");
        self.write("docs/gallery.md", &page)
    }

    /// Writes the help of every command.
    pub fn write_commands(&self) -> Result<(), String> {
        let mut page = String::from(
            "# Commands\n\n`cranny help COMMAND` prints the same. Flags of all commands (`--json`, `--quiet`, `--force`, \
             `--large-files`) stand with each.\n",
        );
        self.add_help(&mut page, &[])?;
        self.write("docs/commands.md", &page)
    }

    fn add_help(&self, page: &mut String, command: &[&str]) -> Result<(), String> {
        let help = self.said(&[command, &["--help"]].concat())?;
        let level = "#".repeat((command.len() + 1).min(3));
        if !command.is_empty() {
            let _ = write!(page, "\n{level} {}\n", command.join(" "));
        }
        let _ = write!(page, "\n```text\n{}\n```\n", help.trim_end());
        let below =
            help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
        // Continuation lines are indented further.
        let names = below.filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
        for name in names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help") {
            self.add_help(page, &[command, &[name]].concat())?;
        }
        Ok(())
    }

    /// Writes the lists of decisions and of stored runs, with entries in the summary.
    pub fn write_lists(&mut self) -> Result<(), String> {
        let mut list = String::from("# Why things are as they are\n\nDecisions, about ten lines each.\n\n");
        self.summary.push_str("- [Why things are as they are](docs/decisions.md)\n");
        self.add_pages("docs/decisions", Some(&mut list))?;
        self.write("docs/decisions.md", &list)?;
        self.summary.push_str("\n# Benchmarks\n\n- [Stored runs](benchmarks/README.md)\n");
        self.add_pages("benchmarks", None)
    }

    fn add_pages(&mut self, folder: &str, mut list: Option<&mut String>) -> Result<(), String> {
        for path in entries(&self.source.join(folder))? {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if !is_page(&path) || name == "README.md" {
                continue;
            }
            let text = fs::read_to_string(&path).map_err(|error| told(&path, &error))?;
            let title =
                text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or(&name).replace('`', "");
            let _ = writeln!(self.summary, "  - [{title}]({folder}/{name})");
            if let Some(list) = list.as_deref_mut() {
                let inner = folder.strip_prefix("docs/").unwrap_or(folder);
                let _ = writeln!(list, "- [{title}]({inner}/{name})");
            }
        }
        Ok(())
    }

    /// Redirects links to files other than pages to the repository, and writes the summary and the configuration of mdBook.
    pub fn finish(&self, book: &str) -> Result<(), String> {
        let mut staged = BTreeSet::new();
        for folder in ["docs", "docs/decisions", "docs/pictures", "docs/schema", "docs/live", "benchmarks"] {
            for path in entries(&self.source.join(folder))? {
                staged.insert(path.strip_prefix(self.source).unwrap_or(&path).to_owned());
            }
        }
        for page in staged.iter().filter(|path| is_page(path)) {
            let path = self.source.join(page);
            let text = fs::read_to_string(&path).map_err(|error| told(&path, &error))?;
            let text = links::for_the_site(&text);
            let folder = page.parent().unwrap_or(Path::new(""));
            let is_start = page == Path::new(START);
            let text = links::rewritten(&text, |link| {
                let (file, place) = link
                    .split_once('#')
                    .map_or((link, String::new()), |(file, place)| (file, format!("#{place}")));
                let target = links::joined(folder, file)?;
                let report = target.with_file_name(staged_name(&target));
                if target == Path::new(START) {
                    Some(format!("{}index.md{place}", "../".repeat(folder.components().count())))
                } else if target.starts_with("api") || staged.contains(&target) {
                    is_start.then(|| format!("{}{place}", target.display()))
                } else if staged.contains(&report) {
                    Some(format!("{}{place}", staged_name(&target)))
                } else {
                    self.here
                        .root
                        .join(&target)
                        .exists()
                        .then(|| format!("{REPOSITORY}/{}", target.display()))
                }
            });
            if is_start {
                // The start page is at the root of the site.
                self.write("index.md", &text.replace("src=\"live/", "src=\"docs/live/"))?;
                fs::remove_file(&path).map_err(|error| told(&path, &error))?;
            } else {
                fs::write(&path, text).map_err(|error| told(&path, &error))?;
            }
        }
        self.write("SUMMARY.md", &self.summary)?;
        let beside = self.source.with_file_name("book.toml");
        fs::write(&beside, book).map_err(|error| told(&beside, &error))
    }

    fn cranny(&self, words: &[&str]) -> std::process::Command {
        self.here.command(self.here.program(), words)
    }

    fn said(&self, words: &[&str]) -> Result<String, String> {
        let output = self.cranny(words).output().map_err(|error| error.to_string())?;
        String::from_utf8(output.stdout).map_err(|error| error.to_string())
    }

    fn write(&self, page: &str, text: &str) -> Result<(), String> {
        let path = self.source.join(page);
        fs::write(&path, text).map_err(|error| told(&path, &error))
    }
}

/// Returns the name of a file in the stage: a self-contained report is renamed, because the page about it has its name.
fn staged_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.strip_suffix(".html").map_or_else(|| name.to_string(), |stem| format!("{stem}_report.html"))
}

fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "md")
}

/// Returns the entries of a folder, sorted by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|error| told(folder, &error))?;
    let mut paths = entries
        .map(|entry| Ok(entry.map_err(|error| told(folder, &error))?.path()))
        .collect::<Result<Vec<_>, String>>()?;
    paths.sort();
    Ok(paths)
}

/// Copies a folder recursively.
///
/// # Errors
/// Error of the file system.
pub fn copy_folder(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(|error| told(to, &error))?;
    for entry in entries(from)? {
        let to = to.join(entry.file_name().unwrap_or_default());
        if entry.is_dir() {
            copy_folder(&entry, &to)?;
        } else {
            fs::copy(&entry, &to).map_err(|error| told(&to, &error))?;
        }
    }
    Ok(())
}

fn told(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
