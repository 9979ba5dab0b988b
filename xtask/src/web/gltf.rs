//! Validation of animated glTF files in Node, by the Khronos validator and three.js.

use std::process::Command;

use crate::step::{self, Readiness, Surroundings};

/// Scenarios that are planned and drawn.
const SCENARIOS: [&str; 2] = ["021", "041"];

/// Checks for Node and the required packages, and installs missing packages.
pub fn readiness(here: &Surroundings) -> Readiness {
    for (program, word) in
        [("node", "Node 20 or later (https://nodejs.org)"), ("npm", "npm, which comes with Node")]
    {
        if !answers(here.command(program, &["--version"])) {
            return Readiness::Missing(format!("no `{program}`: install {word}"));
        }
    }
    let web = here.root.join("web");
    let wanted = std::fs::read(web.join("package-lock.json")).unwrap_or_default();
    let mark = web.join("node_modules/.cranny-lock");
    if std::fs::read(&mark).is_ok_and(|installed| installed == wanted) {
        return Readiness::Ready;
    }
    let mut install = here.command("npm", &["ci", "--no-audit", "--no-fund"]);
    install.current_dir(&web);
    if !answers(install) {
        return Readiness::Missing("the packages of web/ cannot be installed: run `npm ci` there".to_owned());
    }
    // The mark only spares the next run the installation.
    let _ = std::fs::write(mark, wanted);
    Readiness::Ready
}

/// Plans, draws and validates.
///
/// # Errors
/// If a plan or a file cannot be created, or Node reports an error in one.
pub fn check(here: &Surroundings) -> Result<(), String> {
    let folder = here.root.join("target/gltf");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let program = here.built_program()?.display().to_string();
    let mut files = Vec::new();
    for id in SCENARIOS {
        let plan = folder.join(format!("{id}.plan.json")).display().to_string();
        let file = folder.join(format!("{id}.glb")).display().to_string();
        for words in [["plan", id, "-o", &plan, "--quiet"], ["render", id, &plan, "-o", &file]] {
            step::succeed(here.command(&program, &words))?;
        }
        files.push(file);
    }
    let mut words = vec!["web/check/gltf.mjs"];
    words.extend(files.iter().map(String::as_str));
    step::succeed(here.command("node", &words))
}

fn answers(mut command: Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}
