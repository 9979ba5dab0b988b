//! Check that a public function that takes or returns a `Pose` names both of its frames.
//!
//! A parameter states them in its name, `target_from_source`, a result in the name of the function. Otherwise the doc must
//! state them: by a name `target_from_source` in code, or by the frame of the pose ("the pose of the hand in the planning
//! frame", "two poses in one frame"), with the word "frame" in the singular. Not detected: whether the doc refers to this very
//! pose, and poses behind `Self` or a type alias.

use syn::visit::{self, Visit};

use crate::checkout::SourceFile;
use crate::problem::Problem;
use crate::public_functions::{PublicFunction, public_functions};

/// Reports functions with poses whose frames are stated neither by names nor by docs.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let functions =
        files.iter().flat_map(|file| public_functions(file).into_iter().map(move |own| (file, own)));
    functions
        .filter(|(_, function)| !states_frames(&function.doc))
        .flat_map(|(file, function)| {
            let problem = |pose| {
                let message = format!("{pose} of `{}` is a pose without frames", function.name);
                let hint = "name it `target_from_source`, or state in the doc which frame it is in";
                Problem::new(&file.path, message, hint)
            };
            nameless(&function).into_iter().map(problem).collect::<Vec<_>>()
        })
        .collect()
}

/// Returns the parameters and the result that have poses without frames in their names.
fn nameless(function: &PublicFunction) -> Vec<String> {
    let signature = &function.signature;
    let parameter = |input: &syn::FnArg| match input {
        syn::FnArg::Typed(typed) if has_pose(&typed.ty) => Some(match &*typed.pat {
            syn::Pat::Ident(name) => format!("`{}`", name.ident),
            _ => "a parameter".to_owned(),
        }),
        _ => None,
    };
    let result = match &signature.output {
        syn::ReturnType::Type(_, of) if has_pose(of) && !names_frames(&signature.ident.to_string()) => {
            Some("the result".to_owned())
        }
        _ => None,
    };
    signature.inputs.iter().filter_map(parameter).filter(|name| !names_frames(name)).chain(result).collect()
}

/// Returns true if a doc states frames, as the module doc defines it.
fn states_frames(doc: &str) -> bool {
    let is_word = |word: &str| word == "frame";
    doc.split('`').skip(1).step_by(2).any(names_frames)
        || doc.split(|c: char| !c.is_alphanumeric()).any(is_word)
}

/// Returns true if text has the form `target_from_source`.
fn names_frames(text: &str) -> bool {
    let is_part = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let between =
        |(before, after): (&str, &str)| is_part(before.chars().last()) && is_part(after.chars().next());
    text.split_once("_from_").is_some_and(between)
}

fn has_pose(of: &syn::Type) -> bool {
    let mut poses = Poses(false);
    poses.visit_type(of);
    poses.0
}

struct Poses(bool);

impl<'ast> Visit<'ast> for Poses {
    fn visit_path_segment(&mut self, segment: &'ast syn::PathSegment) {
        self.0 |= segment.ident == "Pose";
        visit::visit_path_segment(self, segment);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(doc: &str, function: &str) -> Vec<String> {
        let text = format!("/// {doc}\npub fn {function} {{}}");
        let problems = check(&[SourceFile::of_text("crates/x/src/x.rs", &text)]);
        problems.into_iter().map(|problem| problem.message).collect()
    }

    #[test]
    fn a_pose_without_frames_is_found() {
        assert_eq!(
            found("Moves it.", "f(pose: &Pose, a_from_b: Pose)"),
            ["`pose` of `f` is a pose without frames"]
        );
        assert_eq!(
            found("As `frames` has it.", "f() -> Option<Pose>"),
            ["the result of `f` is a pose without frames"]
        );
        assert_eq!(
            found("Solids.", "a_from_b((pose, n): (&[Pose], u8))"),
            ["a parameter of `a_from_b` is a pose without frames"]
        );
        assert_eq!(found("Takes it _from_ `there`.", "f(poses: Vec<(Pose, u8)>)").len(), 1);
    }

    #[test]
    fn names_and_docs_that_state_frames_are_fine() {
        assert_eq!(found("Moves it.", "f(world_from_hand: &Pose)"), [""; 0]);
        assert_eq!(found("The hand.", "world_from_hand() -> Result<Pose, ()>"), [""; 0]);
        assert_eq!(found("Moves it to its `world_from_hand`.", "f(to: &Pose)"), [""; 0]);
        assert_eq!(found("A pose in the planning frame.", "f() -> Vec<Pose>"), [""; 0]);
        assert_eq!(found("No pose.", "f(pose: PoseEntry)"), [""; 0]);
    }
}
