//! Files of `MotionBenchMaker` families.

use std::fs;
use std::path::{Path, PathBuf};

/// Returns the subfolders of a folder, sorted.
///
/// # Errors
/// Errors of the operating system.
pub fn folders_in(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries: std::io::Result<Vec<PathBuf>> =
        fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect();
    let mut folders: Vec<PathBuf> = entries?.into_iter().filter(|path| path.is_dir()).collect();
    folders.sort();
    Ok(folders)
}

/// Returns the scene files of a family, sorted.
///
/// # Errors
/// Errors of the operating system.
pub fn scenes_in(family: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries: std::io::Result<Vec<PathBuf>> =
        fs::read_dir(family)?.map(|entry| entry.map(|e| e.path())).collect();
    let is_scene = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("scene") && path.extension().is_some_and(|extension| extension == "yaml")
    };
    let mut scenes: Vec<PathBuf> = entries?.into_iter().filter(is_scene).collect();
    scenes.sort();
    Ok(scenes)
}

/// Returns the path of the request of a scene: `scene0001.yaml` → `request0001.yaml`.
pub fn request_of(scene: &Path) -> PathBuf {
    let name = scene.file_name().unwrap_or_default().to_string_lossy();
    scene.with_file_name(name.replacen("scene", "request", 1))
}
