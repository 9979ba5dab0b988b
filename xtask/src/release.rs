//! Files of a release, in `target/release-files`. `docs/releasing.md` lists where each is uploaded by hand.
//!
//! 1. Refuses a checkout with changes that are not committed.
//! 2. Builds the wheel and tries it.
//! 3. Packs the program with manual pages, completions and licences.
//! 4. Adds licences, bill of materials, the changes, and checksums of all.

mod changes;

use std::fs;
use std::path::{Path, PathBuf};

use crate::checkout;
use crate::contents::{self, Contents};
use crate::member;
use crate::python_package;
use crate::step::{self, Surroundings};
use crate::tidy::notices;

/// Folder of the files, relative to the root.
const FILES: &str = "target/release-files";

/// Folder of the content of the archive, relative to the root.
const PARTS: &str = "target/release-parts";

/// Shells for which the program has completions, with the file names that they expect.
const COMPLETIONS: [(&str, &str); 4] =
    [("bash", "cranny.bash"), ("zsh", "_cranny"), ("fish", "cranny.fish"), ("powershell", "cranny.ps1")];

/// Treatment of a checkout with changes that are not committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uncommitted {
    /// Refuse it: its files could not be made again.
    Refuse,
    /// Make the files of a trial.
    Allow,
}

/// Makes the files of a release; returns true.
///
/// # Errors
/// If the checkout has changes and they are refused, or any step fails.
pub fn run(uncommitted: Uncommitted) -> Result<bool, String> {
    let (root, _) = member::read_workspace()?;
    // 1.
    let changed = checkout::changed_files(&root)?;
    if !changed.is_empty() && uncommitted == Uncommitted::Refuse {
        return Err(format!(
            "{} not committed ({}): commit them, or use --allow-dirty for a trial",
            if changed.len() == 1 {
                "1 change is".to_owned()
            } else {
                format!("{} changes are", changed.len())
            },
            changed.join(", ")
        ));
    }
    let here = python_package::build_surroundings(root)?;
    let release = Release {
        folder: here.root.join(FILES),
        version: Contents::of(&here.root)?.version()?,
        target: target(&here)?,
        here: &here,
    };
    emptied(&release.folder)?;
    // 2.
    let wheel = python_package::built_and_tried(&here)?;
    release.copy(&wheel, &wheel.file_name().unwrap_or_default().to_string_lossy())?;
    // 3.
    release.pack_program()?;
    // 4.
    release.copy(&here.root.join(notices::PAGE), &format!("cranny-{}-notices.txt", release.version))?;
    contents::write_bill(&here.root, &release.file(".cdx.json"))?;
    let log = read(&here.root.join("CHANGELOG.md"))?;
    let changes =
        changes::of_version(&log, &release.version).ok_or("CHANGELOG.md has no section of this version")?;
    write(&release.file("-changes.md"), changes.as_bytes())?;
    release.sum()?;
    println!("release: {}", release.folder.display());
    Ok(true)
}

/// Files of a release in the making.
struct Release<'a> {
    here: &'a Surroundings,
    folder: PathBuf,
    version: String,
    /// Platform of the program, as Rust names it.
    target: String,
}

impl Release<'_> {
    /// Returns the path of a file whose name is that of the release and `ending`.
    fn file(&self, ending: &str) -> PathBuf {
        self.folder.join(format!("cranny-{}{ending}", self.version))
    }

    fn copy(&self, from: &Path, name: &str) -> Result<(), String> {
        fs::copy(from, self.folder.join(name))
            .map(drop)
            .map_err(|error| format!("{}: {error}", from.display()))
    }

    /// Packs program, manual pages, completions and licences; the same content gives the same bytes.
    fn pack_program(&self) -> Result<(), String> {
        let name = format!("cranny-{}-{}", self.version, self.target);
        let parts = self.here.root.join(PARTS);
        let content = parts.join(&name);
        emptied(&parts)?;
        emptied(&content.join("completions"))?;
        let program = self.here.program();
        for file in [
            &program,
            &self.here.root.join("LICENSE-MIT"),
            &self.here.root.join("LICENSE-APACHE"),
            &self.here.root.join(notices::PAGE),
        ] {
            fs::copy(file, content.join(file.file_name().unwrap_or_default()))
                .map_err(|error| format!("{}: {error}", file.display()))?;
        }
        for (shell, file) in COMPLETIONS {
            let output = self.here.command(&program, &["completions", shell]).output();
            let output = output.map_err(|error| format!("cranny completions {shell}: {error}"))?;
            write(&content.join("completions").join(file), &output.stdout)?;
        }
        let pages = content.join("man/man1").display().to_string();
        step::succeed(self.here.command(&program, &["man", "--quiet", "-o", &pages]))?;

        let archive = self.folder.join(format!("{name}.tar.gz")).display().to_string();
        let time = format!("--mtime=@{}", checkout::commit_time(&self.here.root)?);
        let same = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mode=u=rwX,go=rX", &time];
        let files =
            ["--use-compress-program=gzip -9n", "--directory", &parts.display().to_string(), "--create"];
        let words = [&same[..], &files, &["--file", &archive, &name]].concat();
        step::succeed(self.here.command("tar", &words))
    }

    /// Writes the checksums of all files, as `sha256sum --check` reads them.
    fn sum(&self) -> Result<(), String> {
        let entries = fs::read_dir(&self.folder).map_err(|error| error.to_string())?;
        let mut names: Vec<String> = entries
            .filter_map(Result::ok)
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        let mut command = self.here.command("sha256sum", &[]);
        let output = command.args(&names).current_dir(&self.folder).output();
        let output = output.map_err(|error| format!("`sha256sum` does not start: {error}"))?;
        if !output.status.success() {
            return Err(format!("`sha256sum`: {}", output.status));
        }
        write(&self.folder.join("SHA256SUMS"), &output.stdout)
    }
}

/// Returns the platform of this machine, as Rust names it.
fn target(here: &Surroundings) -> Result<String, String> {
    let output = here.cargo(&["--version", "--verbose"]).output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "cargo does not name the platform".to_owned())
}

/// Creates a folder without content.
fn emptied(folder: &Path) -> Result<(), String> {
    let fault = |error: std::io::Error| format!("{}: {error}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(fault)?;
    }
    fs::create_dir_all(folder).map_err(fault)
}

fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))
}

fn write(file: &Path, content: &[u8]) -> Result<(), String> {
    fs::write(file, content).map_err(|error| format!("{}: {error}", file.display()))
}
