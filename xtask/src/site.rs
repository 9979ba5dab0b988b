//! Site: the pages of `docs/` and `benchmarks/`, the reference of all commands, a gallery of live pages and the API, in one
//! folder without external resources.
//!
//! 1. Pages are copied to `target/site/src` with the folder structure of the checkout, which keeps their links valid; links to
//!    other files lead to the repository.
//! 2. The program draws the gallery and prints its help.
//! 3. mdBook converts the pages to HTML; the API of Rust, and of Python if a wheel is installed, is added.
//! 4. Every link and every file that the result references must exist.

pub mod links;
mod stage;

use std::path::Path;

use crate::step::{self, Readiness, Surroundings};
use crate::web::gltf;

use self::stage::Stage;

/// Version of mdBook; pinned, because its themes change.
const MDBOOK: &str = "0.5.4";

/// Pages by section, in order; a page below another is indented.
const SUMMARY: &str = "# Summary

[Cranny](index.md)

# Tutorials

- [Your first plan](docs/first_plan.md)
- [Your scene](docs/your_scene.md)
- [Your object](docs/your_object.md)
- [Your robot](docs/robots.md)
- [Your planner](docs/your_planner.md)
  - [Any program: the protocol](docs/exec_protocol.md)
- [A campaign and its report](docs/your_campaign.md)
  - [All of a campaign file](docs/campaigns.md)
  - [On a cluster](docs/cluster.md)
- [Data sets for training](docs/datasets.md)
- [Carrying things out](docs/carrying_out.md)
- [Putting things down](docs/placing.md)
- [Motions for a robot](docs/motions.md)
- [Depth cameras and point clouds](docs/sensing.md)
- [C and C++](docs/cpp.md)
- [Physics](docs/physics.md)
- [ROS and MoveIt](docs/ros.md)

# Reference

- [Gallery](docs/gallery.md)
- [The command line](docs/command_line.md)
- [All flags](docs/commands.md)
- [Files and formats](docs/files.md)
  - [Recordings](docs/recordings.md)
- [Planners](docs/planners.md)

# Understanding

- [Proofs](docs/proofs.md)
- [Certificates](docs/certificate.md)
- [Limits](docs/limits.md)
- [Claims and their evidence](docs/claims.md)
- [Releasing](docs/releasing.md)
";

const BOOK: &str = r#"[book]
title = "Cranny"
language = "en"
description = "Grasp and motion planning in confined spaces, as one: exact, proven, repeatable"

[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
git-repository-url = "https://github.com/cranny-planning/cranny"
no-section-label = true

[output.html.print]
enable = false

[output.html.search]
limit-results = 20
"#;

/// Checks for Node, because only a build with Node includes the live pages.
pub fn readiness(here: &Surroundings) -> Readiness {
    gltf::readiness(here)
}

/// Builds the site into `target/site/book`.
///
/// # Errors
/// If a tool or a page fails, or a link is broken.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let mdbook = mdbook(here)?;
    step::succeed(here.cargo(&["build", "--release", "--quiet"]))?;
    let site = here.root.join("target/site");
    let source = site.join("src");
    let _ = std::fs::remove_dir_all(&site);
    let mut stage = Stage { here, source: &source, summary: SUMMARY.to_owned() };
    stage.copy_pages()?;
    stage.draw_gallery()?;
    stage.write_commands()?;
    stage.write_lists()?;
    stage.finish(BOOK)?;
    let folder = site.display().to_string();
    step::succeed(here.command(mdbook, &["build", &folder]))?;
    let book = site.join("book");
    api_of_rust(here, &book)?;
    api_of_python(here, &book)?;
    let pages = links::check(&book)?;
    println!("site: {pages} pages in {}", book.display());
    Ok(())
}

/// Returns the mdBook of this machine, or one in `target`, which is built once.
fn mdbook(here: &Surroundings) -> Result<String, String> {
    let version = |program: &str| {
        let output = here.command(program, &["--version"]).output().ok()?;
        String::from_utf8(output.stdout).ok()
    };
    let own = here.root.join("target/tools");
    for program in ["mdbook".to_owned(), own.join("bin/mdbook").display().to_string()] {
        if version(&program).is_some_and(|said| said.contains(MDBOOK)) {
            return Ok(program);
        }
    }
    println!("==> mdBook {MDBOOK}, into target/tools");
    let root = own.display().to_string();
    let words = ["install", "--quiet", "--locked", "--no-default-features", "--features", "search"];
    let words = [&words[..], &["--version", MDBOOK, "--root", &root, "mdbook"]].concat();
    step::succeed(here.cargo(&words))?;
    Ok(own.join("bin/mdbook").display().to_string())
}

fn api_of_rust(here: &Surroundings, book: &Path) -> Result<(), String> {
    step::succeed(here.cargo(&["doc", "--release", "--no-deps", "--workspace", "--quiet"]))?;
    stage::copy_folder(&here.root.join("target/doc"), &book.join("api"))
}

/// Builds the Python API from the package that the tests installed.
fn api_of_python(here: &Surroundings, book: &Path) -> Result<(), String> {
    let python = here.python.as_ref().map(|python| python.display().to_string());
    let Some(python) = python.filter(|python| {
        here.command(python, &["-c", "import cranny, pdoc"])
            .output()
            .is_ok_and(|output| output.status.success())
    }) else {
        eprintln!("SKIPPED: the API of Python (the package is not installed: run `cargo xtask test` first)");
        let folder = book.join("api/python");
        std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
        let page = "<!doctype html><title>Python</title><p>This copy of the site was built without the Python package.";
        return std::fs::write(folder.join("cranny.html"), page).map_err(|error| error.to_string());
    };
    let folder = book.join("api/python").display().to_string();
    step::succeed(here.command(python, &["-m", "pdoc", "--output-directory", &folder, "cranny"]))
}
