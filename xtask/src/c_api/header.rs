//! Header of the C API, generated from the sources of its crate.

use std::fs;
use std::path::Path;

use crate::checkout::SourceFile;
use crate::problem::Problem;

/// Crate of the C API.
const CRATE: &str = "crates/capi";

/// Generated header.
const HEADER: &str = "crates/capi/include/cranny/cranny.h";

/// Sources in the order of the header.
const SOURCES: [&str; 13] = [
    "error",
    "version",
    "robot",
    "kinematics",
    "world",
    "cell",
    "motion",
    "grasps",
    "scenario",
    "planning",
    "plan",
    "verification",
    "samples",
];

/// Returns the text of the header.
fn text(root: &Path) -> Result<String, String> {
    let folder = root.join(CRATE);
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml"))?;
    // The types of pointers, which the settings rename.
    let sources = ["boundary"].iter().chain(&SOURCES).map(|name| folder.join(format!("src/{name}.rs")));
    let builder = sources.fold(cbindgen::Builder::new().with_config(config), cbindgen::Builder::with_src);
    let mut bytes = Vec::new();
    builder.generate().map_err(|fault| format!("{CRATE}: {fault}"))?.write(&mut bytes);
    let text = String::from_utf8(bytes).map_err(|fault| format!("{CRATE}: {fault}"))?;
    // A renamed pointer is separated from its argument by a blank too many.
    let line = |line: &str| if line.starts_with("//") { line.to_owned() } else { line.replace("* ", "*") };
    Ok(text.lines().map(|text| line(text) + "\n").collect())
}

/// Writes the header.
///
/// # Errors
/// If the sources cannot be parsed or the header cannot be written.
pub fn write(root: &Path) -> Result<(), String> {
    fs::write(root.join(HEADER), text(root)?).map_err(|fault| format!("{HEADER}: {fault}"))
}

/// Reports a header that differs from the sources.
///
/// # Errors
/// If the sources cannot be parsed.
pub fn check(root: &Path, files: &[SourceFile]) -> Result<Vec<Problem>, String> {
    let header = files.iter().find(|file| file.path == HEADER).and_then(SourceFile::text);
    if header == Some(&text(root)?[..]) {
        return Ok(Vec::new());
    }
    let message = "is not what the sources of its crate make";
    Ok(vec![Problem::new(HEADER, message, "run `cargo xtask tidy --write`")])
}
