//! External packages that the program, the Python package and the viewer's page contain, and their bill of materials.

use std::collections::BTreeMap;
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package, PackageId};
use serde_json::{Value, json};

/// File name of the bill of materials.
pub const BILL: &str = "cranny.cdx.json";

/// Crate of the program.
const PROGRAM: &str = "cranny-cli";

/// Distributed packages, without build tools.
const DISTRIBUTED: [&str; 3] = [PROGRAM, "cranny-capi", "cranny-python"];

/// Lock file of npm, with the version of three.js in the viewer's page.
const NPM_LOCK: &str = "web/package-lock.json";

/// Packages of a checkout.
pub struct Contents {
    metadata: Metadata,
    /// Version of three.js in the page.
    pub three_js: String,
}

impl Contents {
    /// Reads the packages of the workspace at `root`.
    ///
    /// # Errors
    /// If cargo does not know the packages, or npm's lock file lacks three.js.
    pub fn of(root: &Path) -> Result<Self, String> {
        let metadata = MetadataCommand::new().manifest_path(root.join("Cargo.toml")).exec();
        let lock = std::fs::read_to_string(root.join(NPM_LOCK));
        let lock = lock.map_err(|error| format!("{NPM_LOCK}: {error}"))?;
        let three_js = three_js_version(&lock)?.to_owned();
        Ok(Self { metadata: metadata.map_err(|error| error.to_string())?, three_js })
    }

    /// Returns the version of the program.
    ///
    /// # Errors
    /// If the workspace has no such crate.
    pub fn version(&self) -> Result<String, String> {
        let program = self.metadata.packages.iter().find(|package| package.name.as_str() == PROGRAM);
        program
            .map(|program| program.version.to_string())
            .ok_or_else(|| format!("there is no crate {PROGRAM}"))
    }

    /// Returns the external packages of the distributed ones, on any platform, by name and version.
    pub fn packages(&self) -> Vec<&Package> {
        let resolve = self.metadata.resolve.iter().flat_map(|resolve| &resolve.nodes);
        let nodes: BTreeMap<&PackageId, _> = resolve.map(|node| (&node.id, node)).collect();
        let all = &self.metadata.packages;
        let is_distributed = |package: &&Package| DISTRIBUTED.contains(&package.name.as_str());
        let mut queue: Vec<&PackageId> =
            all.iter().filter(is_distributed).map(|package| &package.id).collect();
        let mut seen = queue.clone();
        while let Some(node) = queue.pop().and_then(|id| nodes.get(id)) {
            for dependency in &node.deps {
                let is_linked = dependency.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal);
                if is_linked && !seen.contains(&&dependency.pkg) {
                    seen.push(&dependency.pkg);
                    queue.push(&dependency.pkg);
                }
            }
        }
        let mut packages: Vec<&Package> =
            all.iter().filter(|package| package.source.is_some() && seen.contains(&&package.id)).collect();
        packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
        packages
    }

    /// Returns the bill of materials (CycloneDX 1.5): program and external packages, each with version and licence.
    fn bill(&self) -> Result<Value, String> {
        let component = |kind: &str, name: &str, version: &str, address: String, licence: Option<&str>| {
            // The slash is an old spelling of cargo.
            let licence = licence.map(|licence| json!([{ "expression": licence.replace('/', " OR ") }]));
            let (version, licences) = (version.to_owned(), licence.unwrap_or_else(|| json!([])));
            json!({
                "type": kind, "bom-ref": address, "name": name, "version": version, "purl": address,
                "licenses": licences,
            })
        };
        let mut components: Vec<Value> = Vec::new();
        for package in self.packages() {
            let (name, version) = (package.name.as_str(), package.version.to_string());
            let address = format!("pkg:cargo/{name}@{}", version.replace('+', "%2B"));
            components.push(component("library", name, &version, address, package.license.as_deref()));
        }
        let address = format!("pkg:npm/three@{}", self.three_js);
        components.push(component("library", "three", &self.three_js, address, Some("MIT")));
        let version = self.version()?;
        let address = format!("pkg:pypi/cranny@{version}");
        let own = component("application", "cranny", &version, address, Some("MIT OR Apache-2.0"));
        Ok(json!({
            "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": { "component": own }, "components": components,
        }))
    }
}

/// Writes the bill of materials of the checkout at `root` to `file`.
///
/// # Errors
/// As [`Contents::of`], and if the file cannot be written.
pub fn write_bill(root: &Path, file: &Path) -> Result<(), String> {
    let bill = Contents::of(root)?.bill()?;
    std::fs::write(file, format!("{bill:#}\n")).map_err(|error| format!("{}: {error}", file.display()))
}

/// Returns the version of three.js in npm's lock file.
fn three_js_version(lock: &str) -> Result<&str, String> {
    let version = || {
        let (_, rest) = lock.split_once("\"node_modules/three\"")?;
        let (_, rest) = rest.split_once("\"version\": \"")?;
        rest.split_once('"').map(|(version, _)| version)
    };
    version().ok_or_else(|| format!("{NPM_LOCK}: no version of three"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_of_three_js_is_found() {
        let lock = r#"{"node_modules/three": {"version": "0.187.0", "dev": true}, "x": {"version": "1"}}"#;
        assert_eq!(three_js_version(lock), Ok("0.187.0"));
        assert!(three_js_version("{}").is_err());
    }

    #[test]
    fn the_bill_lists_each_package_once_with_its_licence() {
        let contents = Contents::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("a workspace");
        let bill = contents.bill().expect("a bill");
        let components = bill["components"].as_array().expect("a list");
        let names = |name: &str| components.iter().filter(|component| component["name"] == name).count();
        assert_eq!([names("clap"), names("three"), names("criterion"), names("cranny-cli")], [1, 1, 0, 0]);
        let mut addresses: Vec<&str> =
            components.iter().filter_map(|component| component["purl"].as_str()).collect();
        addresses.sort_unstable();
        addresses.dedup();
        assert_eq!(addresses.len(), components.len());
        let has_licence = |component: &Value| {
            component["licenses"][0]["expression"].as_str().is_some_and(|text| !text.contains('/'))
        };
        assert!(components.iter().all(has_licence), "{bill:#}");
        assert_eq!(bill["metadata"]["component"]["version"], contents.version().expect("a version"));
    }
}
