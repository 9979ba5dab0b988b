//! Embeds the built page of `web/` into the crate: copies it, and writes a table of its files in Rust.
//!
//! 1. Uses the folder in the environment variable `CRANNY_WEB_DIST`.
//! 2. Otherwise uses `page` in this crate, which a published crate has and a checkout does not; otherwise `web/dist`, unless it
//!    is older than its sources.
//! 3. Otherwise builds a copy of `web/` with npm in the output folder of this build. Nothing is written beside the sources.
//! 4. Otherwise uses an older `web/dist`; without one, there is no page, and `cranny view` names what to install.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// Files that every page folder must contain: the served page and the single-file page.
const PAGES: [&str; 2] = ["index.html", "single.html"];

/// Entries of `web/` that are not sources of the page.
const NO_SOURCES: [&str; 7] = ["dist", "build", "node_modules", "screenshots", "tests", "check", "README.md"];

/// Timeout of one npm command: twenty times its usual duration, so that no build hangs on a dead network.
const PATIENCE: Duration = Duration::from_mins(4);

const DIST: &str = "CRANNY_WEB_DIST";

fn main() {
    let folder = |name: &str| PathBuf::from(std::env::var_os(name).expect("cargo names its folders"));
    let (out, own) = (folder("OUT_DIR"), folder("CARGO_MANIFEST_DIR"));
    let page = out.join("page");
    clear(&page);
    fs::create_dir_all(&page).expect("the folder of this build can be written");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={DIST}");
    find(&own, &out, &page);
    let table = table(&page).expect("the page can be read");
    fs::write(out.join("page_files.rs"), table).expect("the folder of this build can be written");
}

/// Returns the Rust code of a table with the names and contents of the files of the page.
fn table(page: &Path) -> io::Result<String> {
    let mut names = Vec::new();
    list(page, "", &mut names)?;
    names.sort();
    let row = |name: &String| {
        format!("    ({name:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/page/\", {name:?}))),\n")
    };
    let rows: Vec<String> = names.iter().map(row).collect();
    Ok(format!("static FILES: &[(&str, &[u8])] = &[\n{}];\n", rows.concat()))
}

/// Adds the names of all files below a folder, with `/` between folders.
fn list(folder: &Path, before: &str, names: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{before}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            list(&entry.path(), &format!("{name}/"), names)?;
        } else {
            names.push(name);
        }
    }
    Ok(())
}

/// Copies the page to `page`, from where the head of this file states; leaves it empty if there is none.
fn find(own: &Path, out: &Path, page: &Path) {
    let web = own.join("../../web");
    // 1.
    if let Some(dist) = std::env::var_os(DIST).filter(|dist| !dist.is_empty()).map(PathBuf::from) {
        println!("cargo::rerun-if-changed={}", dist.display());
        assert!(is_ready(&dist), "{DIST}: '{}' has not all of {PAGES:?}", dist.display());
        return copy(&dist, page, &[]).expect("the page can be copied");
    }
    // 2.
    let packed = own.join("page");
    if is_ready(&packed) {
        println!("cargo::rerun-if-changed={}", packed.display());
        return copy(&packed, page, &[]).expect("the page can be copied");
    }
    let dist = web.join("dist");
    let sources = sources(&web);
    for source in &sources {
        println!("cargo::rerun-if-changed={}", source.display());
    }
    if is_ready(&dist) {
        println!("cargo::rerun-if-changed={}", dist.display());
        if newest(&sources) <= newest(&[dist.join(PAGES[0])]) {
            return copy(&dist, page, &[]).expect("the page can be copied");
        }
    }
    // 3.
    match build(&web, &out.join("web")) {
        Ok(built) => copy(&built, page, &[]).expect("the page can be copied"),
        Err(reason) if is_ready(&dist) => {
            println!("cargo::warning=web/dist is older than its sources, and cannot be built: {reason}");
            copy(&dist, page, &[]).expect("the page can be copied");
        }
        Err(reason) => {
            // Installing Node changes PATH.
            println!("cargo::rerun-if-env-changed=PATH");
            println!("cargo::warning=`cranny view` is built without its page: {reason}");
        }
    }
}

/// Builds a copy of `web` and returns the folder with the page.
fn build(web: &Path, copied: &Path) -> Result<PathBuf, String> {
    if !web.join("package-lock.json").is_file() {
        return Err("there is no web/package-lock.json".to_owned());
    }
    let fault = |error: io::Error| format!("{}: {error}", copied.display());
    clear(copied);
    copy(web, copied, &NO_SOURCES).map_err(fault)?;
    npm(
        copied,
        &[
            "ci",
            "--ignore-scripts",
            "--no-audit",
            "--no-fund",
            "--prefer-offline",
            "--fetch-retries=0",
            "--fetch-timeout=20000",
        ],
    )?;
    npm(copied, &["run", "build"])?;
    // This folder is a hundred times as large as the page, and npm restores it quickly from its own store.
    clear(&copied.join("node_modules"));
    let dist = copied.join("dist");
    if is_ready(&dist) { Ok(dist) } else { Err(format!("`npm run build` makes not all of {PAGES:?}")) }
}

/// Runs npm. The error is a single line.
fn npm(folder: &Path, words: &[&str]) -> Result<(), String> {
    let program = if cfg!(windows) { "npm.cmd" } else { "npm" };
    let log = folder.join("npm.log");
    let lines = fs::File::create(&log).map_err(|error| format!("{}: {error}", log.display()))?;
    let errors = lines.try_clone().map_err(|error| format!("{}: {error}", log.display()))?;
    let mut command = Command::new(program);
    command.args(words).current_dir(folder).stdin(Stdio::null()).stdout(lines).stderr(errors);
    let mut child =
        command.spawn().map_err(|_| "no npm; install Node 20 or later (https://nodejs.org)".to_owned())?;
    let begin = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => {
                return Err(format!("`npm {}`: {status}, see {}", words.join(" "), log.display()));
            }
            Ok(None) if begin.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(50)),
            Ok(None) | Err(_) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("`npm {}` took longer than {} s", words.join(" "), PATIENCE.as_secs()));
            }
        }
    }
}

fn is_ready(dist: &Path) -> bool {
    PAGES.iter().all(|page| dist.join(page).is_file())
}

/// Returns the source files and folders of the page.
fn sources(web: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(web).into_iter().flatten().flatten();
    let is_source = |entry: &fs::DirEntry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        !NO_SOURCES.contains(&name.as_str()) && !name.starts_with('.')
    };
    let mut sources: Vec<PathBuf> = entries.filter(is_source).map(|entry| entry.path()).collect();
    sources.sort();
    sources
}

/// Returns the latest modification time of these paths and everything below them.
fn newest(paths: &[PathBuf]) -> Option<SystemTime> {
    let of = |path: &PathBuf| {
        let own = fs::metadata(path).and_then(|data| data.modified()).ok();
        let inner: Vec<PathBuf> =
            fs::read_dir(path).into_iter().flatten().flatten().map(|e| e.path()).collect();
        own.max(newest(&inner))
    };
    paths.iter().filter_map(of).max()
}

/// Copies files and folders of a folder, except entries with these names.
fn copy(from: &Path, to: &Path, without: &[&str]) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if without.iter().any(|other| name == *other) {
            continue;
        }
        let kind = entry.file_type()?;
        if kind.is_dir() {
            copy(&entry.path(), &to.join(name), &[])?;
        } else if kind.is_file() {
            fs::copy(entry.path(), to.join(name))?;
        }
    }
    Ok(())
}

/// Removes the file or folder at `path`, if there is one.
fn clear(path: &Path) {
    let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
}
