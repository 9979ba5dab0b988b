//! The crates of the workspace, as their manifests describe them.

use std::path::PathBuf;

use cargo_metadata::{DependencyKind, MetadataCommand, Package};

/// The folder that holds the rooms of the house.
pub const ROOMS: &str = "crates/";

/// The one room beside it, where Python looks for its packages.
const PYTHON: &str = "python";

/// A crate of the workspace.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Member {
    /// Package name.
    pub name: String,
    /// Folder, from the root, with forward slashes: `crates/shape`.
    pub folder: String,
    /// One line that says what the crate answers.
    pub description: String,
    /// `[package.metadata.layer] floor`, if it is there and a whole number.
    pub floor: Option<u64>,
    /// Direct dependencies, of whatever origin.
    pub dependencies: Vec<Dependency>,
}

impl Member {
    /// Path of the manifest from the root.
    pub fn manifest(&self) -> String {
        format!("{}/Cargo.toml", self.folder)
    }

    /// Whether the crate is a room of the house, and so stands on a floor.
    pub fn is_room(&self) -> bool {
        self.folder.starts_with(ROOMS) || self.folder == PYTHON
    }
}

/// A direct dependency of a crate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Package name.
    pub name: String,
    /// Section of the manifest: `dependencies`, `dev-dependencies` or `build-dependencies`.
    pub section: &'static str,
}

/// Root folder and crates of the workspace that the current folder belongs to.
///
/// # Errors
/// If cargo cannot read the manifests; the message is cargo's own.
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
