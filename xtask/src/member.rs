//! Crates of the workspace, as their manifests describe them.

use std::path::PathBuf;

use cargo_metadata::{DependencyKind, MetadataCommand, Package};

/// Folder of the library crates.
pub const ROOMS: &str = "crates/";

/// Folder of the Python crate, which Python tools expect outside of it.
const PYTHON: &str = "python";

/// Crate of the workspace.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Member {
    /// Package name.
    pub name: String,
    /// Folder relative to the root, with forward slashes: `crates/shape`.
    pub folder: String,
    /// Description of the crate in one line.
    pub description: String,
    /// `[package.metadata.layer] floor`, if present and an integer.
    pub floor: Option<u64>,
    /// Direct dependencies from any source.
    pub dependencies: Vec<Dependency>,
}

impl Member {
    /// Returns the path of the manifest relative to the root.
    pub fn manifest(&self) -> String {
        format!("{}/Cargo.toml", self.folder)
    }

    /// Returns true if the crate belongs to a layer (a floor).
    pub fn is_room(&self) -> bool {
        self.folder.starts_with(ROOMS) || self.folder == PYTHON
    }
}

/// Direct dependency of a crate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Package name.
    pub name: String,
    /// Section of the manifest: `dependencies`, `dev-dependencies` or `build-dependencies`.
    pub section: &'static str,
}

/// Returns the root folder and the crates of the workspace of the current folder.
///
/// # Errors
/// If cargo cannot read the manifests; the message is that of cargo.
pub fn read_workspace() -> Result<(PathBuf, Vec<Member>), String> {
    let metadata = MetadataCommand::new().no_deps().exec().map_err(|error| error.to_string())?;
    let root = metadata.workspace_root.as_std_path().to_owned();
    let mut members: Vec<Member> = metadata
        .workspace_packages()
        .into_iter()
        .map(|package| Member {
            name: package.name.to_string(),
            folder: package
                .manifest_path
                .parent()
                .and_then(|folder| folder.strip_prefix(&metadata.workspace_root).ok())
                .map(|folder| folder.as_str().replace('\\', "/"))
                .unwrap_or_default(),
            description: package.description.clone().unwrap_or_default(),
            floor: floor_of(package),
            dependencies: package
                .dependencies
                .iter()
                .map(|dependency| Dependency {
                    name: dependency.name.clone(),
                    section: section_of(dependency.kind),
                })
                .collect(),
        })
        .collect();
    members.sort_by(|a, b| a.folder.cmp(&b.folder));
    Ok((root, members))
}

fn floor_of(package: &Package) -> Option<u64> {
    package.metadata.pointer("/layer/floor")?.as_u64()
}

fn section_of(kind: DependencyKind) -> &'static str {
    match kind {
        DependencyKind::Development => "dev-dependencies",
        DependencyKind::Build => "build-dependencies",
        _ => "dependencies",
    }
}
