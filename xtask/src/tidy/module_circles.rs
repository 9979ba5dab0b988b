//! Check that the modules of a crate have no circular dependencies.
//!
//! Names in `use` and qualified paths of a file are followed through re-exports to the file that defines them; arguments of
//! macros are not parsed. Tests may name any module. The root of a crate never belongs to a circle.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::Visit;

use crate::checkout::SourceFile;
use crate::problem::Problem;
use crate::public_functions::is_for_tests;

/// Path of a module in its crate, from the root, which is empty.
type Module = Vec<String>;

/// Names of other modules in a file of a crate.
#[derive(Default)]
struct Names {
    /// Paths from the crate's root, including the item at their end.
    named: BTreeSet<Vec<String>>,
    /// Re-exports, by name.
    exported: BTreeMap<String, Vec<String>>,
}

/// Reports modules that depend on each other in a circle.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let mut crates: BTreeMap<&str, BTreeMap<Module, Names>> = BTreeMap::new();
    let mut problems = Vec::new();
    for file in files.iter().filter(|file| file.has_extension("rs")) {
        let Some((root, inside)) = file.path.split_once("/src/") else { continue };
        if !(root.starts_with("crates/") || root == "xtask" || root == "python") {
            continue;
        }
        let module = module_of(inside);
        match file.text().map(syn::parse_file) {
            Some(Ok(parsed)) => {
                let mut reader =
                    Reader { module: &module, children: children(&parsed), names: Names::default() };
                reader.visit_file(&parsed);
                let names = reader.names;
                crates.entry(root).or_default().insert(module, names);
            }
            _ => problems.push(Problem::new(&file.path, "is no Rust", "mend it first")),
        }
    }
    for (root, modules) in &crates {
        if let Some(circle) = circle(&graph(modules)) {
            let names: Vec<String> = circle.iter().map(|module| module.join("::")).collect();
            problems.push(Problem::new(
                format!("{root}/src"),
                format!("modules know each other in a circle: {}", names.join(" → ")),
                "move what both need to a module of its own, or a method to where what it needs is known",
            ));
        }
    }
    problems
}

fn module_of(inside: &str) -> Module {
    let stem = inside.strip_suffix(".rs").unwrap_or(inside);
    let mut module: Module = stem.split('/').map(str::to_owned).collect();
    if matches!(module.last().map(String::as_str), Some("lib" | "main" | "mod")) {
        module.pop();
    }
    module
}

/// Returns the modules that a file declares.
fn children(file: &syn::File) -> BTreeSet<String> {
    let name = |item: &syn::Item| match item {
        syn::Item::Mod(module) if module.content.is_none() => Some(module.ident.to_string()),
        _ => None,
    };
    file.items.iter().filter_map(name).collect()
}

struct Reader<'a> {
    module: &'a Module,
    /// Names of its child modules.
    children: BTreeSet<String>,
    names: Names,
}

impl Reader<'_> {
    /// Returns the path from the root of the crate; `None` for one into another crate.
    fn path_from_root(&self, path: &[String]) -> Option<Vec<String>> {
        let mut base = match path.first()?.as_str() {
            "crate" => Vec::new(),
            "self" => self.module.clone(),
            "super" => self.module[..self.module.len().saturating_sub(1)].to_vec(),
            child if self.children.contains(child) => [self.module.as_slice(), &[child.to_owned()]].concat(),
            _ => return None,
        };
        for part in &path[1..] {
            if part == "super" {
                base.pop();
            } else {
                base.push(part.clone());
            }
        }
        Some(base)
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_for_tests(item) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let mut paths = Vec::new();
        flatten(&item.tree, &mut Vec::new(), &mut paths);
        for (path, name) in paths {
            let Some(path) = self.path_from_root(&path) else { continue };
            if matches!(item.vis, syn::Visibility::Inherited) {
                self.names.named.insert(path);
            } else {
                self.names.exported.insert(name, path);
            }
        }
    }

    /// Skips visibilities, because `pub(super)` is no dependency.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let parts: Vec<String> = path.segments.iter().map(|part| part.ident.to_string()).collect();
        self.names.named.extend(self.path_from_root(&parts));
        syn::visit::visit_path(self, path);
    }
}

/// Collects every path of a `use`, with the name that it introduces.
fn flatten(tree: &syn::UseTree, before: &mut Vec<String>, paths: &mut Vec<(Vec<String>, String)>) {
    let with = |last: &syn::Ident| [before.as_slice(), &[last.to_string()]].concat();
    match tree {
        syn::UseTree::Path(path) => {
            before.push(path.ident.to_string());
            flatten(&path.tree, before, paths);
            before.pop();
        }
        syn::UseTree::Name(name) if name.ident == "self" => {
            paths.push((before.clone(), before.last().cloned().unwrap_or_default()));
        }
        syn::UseTree::Name(name) => paths.push((with(&name.ident), name.ident.to_string())),
        syn::UseTree::Rename(name) => paths.push((with(&name.ident), name.rename.to_string())),
        syn::UseTree::Glob(_) => paths.push((before.clone(), "*".to_owned())),
        syn::UseTree::Group(group) => group.items.iter().for_each(|item| flatten(item, before, paths)),
    }
}

/// Returns the modules on which each module depends.
fn graph(modules: &BTreeMap<Module, Names>) -> BTreeMap<&Module, BTreeSet<&Module>> {
    let known = |(module, names): (_, &Names)| {
        let home = |path: &Vec<String>| home_of(modules, path);
        (module, names.named.iter().filter_map(home).filter(|other| *other != module).collect())
    };
    modules.iter().filter(|(module, _)| !module.is_empty()).map(known).collect()
}

/// Returns the module that defines the item of a path from the root, through re-exports; `None` for the root.
fn home_of<'a>(modules: &'a BTreeMap<Module, Names>, path: &[String]) -> Option<&'a Module> {
    /// Maximum number of re-exports followed.
    const MOST: usize = 8;
    let mut path = path.to_vec();
    for _ in 0..MOST {
        let depth = (0..=path.len()).rev().find(|&depth| modules.contains_key(&path[..depth]))?;
        let (module, names) = modules.get_key_value(&path[..depth])?;
        match path.get(depth).and_then(|name| names.exported.get(name)) {
            Some(exported) => path.splice(..=depth, exported.iter().cloned()).for_each(drop),
            None => return (!module.is_empty()).then_some(module),
        }
    }
    None
}

/// Returns a circle, with its first module repeated at its end.
fn circle<'a>(graph: &BTreeMap<&'a Module, BTreeSet<&'a Module>>) -> Option<Vec<&'a Module>> {
    // A module without a remaining dependency is in no circle.
    let mut left: BTreeSet<&Module> = graph.keys().copied().collect();
    loop {
        let before = left.len();
        let living = left.clone();
        left.retain(|module| graph[module].iter().any(|other| living.contains(other)));
        if left.len() == before {
            break;
        }
    }
    let mut way: Vec<&Module> = vec![left.first()?];
    loop {
        let next = graph[way[way.len() - 1]].iter().find(|other| left.contains(**other))?;
        if let Some(begin) = way.iter().position(|module| module == next) {
            way.push(next);
            return Some(way.split_off(begin));
        }
        way.push(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problems(files: &[(&str, &str)]) -> Vec<String> {
        let files: Vec<SourceFile> =
            files.iter().map(|(path, text)| SourceFile::of_text(path, text)).collect();
        check(&files).into_iter().map(|problem| problem.message).collect()
    }

    #[test]
    fn a_circle_through_the_door_is_found() {
        let found = problems(&[
            ("crates/x/src/lib.rs", "mod a; mod b; pub use a::A; pub use b::{B, b as other};"),
            ("crates/x/src/a.rs", "use crate::other; pub struct A;"),
            ("crates/x/src/b.rs", "pub struct B; pub fn b() -> crate::A { crate::A }"),
        ]);
        assert_eq!(found, ["modules know each other in a circle: a → b → a"]);
    }

    #[test]
    fn a_circle_of_parent_and_child_is_found() {
        let found = problems(&[
            ("crates/x/src/report.rs", "mod row; pub struct Figures(row::Row);"),
            ("crates/x/src/report/row.rs", "use super::Figures; pub struct Row;"),
        ]);
        assert_eq!(found, ["modules know each other in a circle: report → report::row → report"]);
    }

    #[test]
    fn one_direction_and_tests_and_other_crates_are_fine() {
        let found = problems(&[
            ("crates/x/src/lib.rs", "mod a; mod b; pub use b::B;"),
            ("crates/x/src/a.rs", "use crate::B; use other::a; pub struct A(B);"),
            ("crates/x/src/b.rs", "pub struct B; #[cfg(test)] mod tests { use crate::a::A; }"),
            ("crates/y/src/a.rs", "use cranny_x::B;"),
        ]);
        assert_eq!(found, [""; 0]);
    }

    #[test]
    fn what_is_no_rust_is_said() {
        assert_eq!(problems(&[("xtask/src/a.rs", "pub struct {")]), ["is no Rust"]);
    }
}
