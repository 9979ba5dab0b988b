//! Check that a public function with slices of `f64` documents their length and their unit.
//!
//! Its own doc has a phrase for a length: "one … per …" or "one … each …" with at most two words between ("one value per
//! joint", "one for each joint"), "as many", or "any number of". It also names a unit, or that there is none ("no unit", "from
//! 0 to 1"). Values per joint have the unit of a joint, which names `rad`: a distance in metres elsewhere in the doc does not
//! count. Not detected: to which of several slices a phrase belongs, and slices behind a type alias. Methods of a trait's
//! implementation have the docs of the trait.

use syn::visit::{self, Visit};

use crate::checkout::SourceFile;
use crate::problem::Problem;
use crate::public_functions::public_functions;

/// Phrases for a length, in addition to "one … per …".
const LENGTHS: [&str; 2] = ["as many", "any number of"];
/// Words that name a unit.
const UNITS: [&str; 10] = ["m", "rad", "s", "N", "kg", "metres", "radians", "seconds", "pixels", "unit"];
/// Phrase for a fraction, which has no unit.
const SHARE: &str = "from 0 to 1";
/// Maximum distance in words: "per" is at most the third word after "one".
const APART: usize = 4;

/// Reports functions with slices or vectors of `f64` whose docs state no length, or no unit.
pub fn check(files: &[SourceFile]) -> Vec<Problem> {
    let functions =
        files.iter().flat_map(|file| public_functions(file).into_iter().map(move |own| (file, own)));
    let with_slices = functions.filter(|(_, function)| has_floats(&function.signature));
    with_slices
        .filter_map(|(file, function)| {
            let message = format!(
                "`{}` has a slice of f64, and its doc states no {}",
                function.name,
                missing(&function.doc)?
            );
            let hint = "extend a sentence, as by \"`q` (m, rad; one per joint)\"";
            Some(Problem::new(&file.path, message, hint))
        })
        .collect()
}

/// Returns the first item that a doc does not state.
fn missing(doc: &str) -> Option<&'static str> {
    let words: Vec<&str> =
        doc.split(|c: char| !(c.is_alphanumeric() || c == '\'')).filter(|word| !word.is_empty()).collect();
    let per = |at: usize| words[at..].iter().take(APART).position(|word| matches!(*word, "per" | "each"));
    let ones = (0..words.len()).filter(|at| words[*at].eq_ignore_ascii_case("one"));
    let counted: Vec<usize> = ones.filter_map(|at| Some(at + per(at)?)).collect();
    let lower = doc.to_lowercase();
    if counted.is_empty() && !LENGTHS.iter().any(|phrase| lower.contains(phrase)) {
        return Some("length");
    }
    let is_of_joints = counted.iter().any(|at| words[*at..].iter().take(2).any(|word| *word == "joint"));
    let has = |unit: &str| words.contains(&unit);
    if is_of_joints {
        (!has("rad")).then_some("unit of a joint (m, rad)")
    } else {
        (!UNITS.into_iter().any(has) && !doc.contains(SHARE)).then_some("unit")
    }
}

/// Returns true if a slice or vector of `f64` is anywhere in a signature.
fn has_floats(signature: &syn::Signature) -> bool {
    let mut floats = Floats(false);
    floats.visit_signature(signature);
    floats.0
}

struct Floats(bool);

impl<'ast> Visit<'ast> for Floats {
    fn visit_type_slice(&mut self, slice: &'ast syn::TypeSlice) {
        self.0 |= is_float(&slice.elem);
        visit::visit_type_slice(self, slice);
    }

    fn visit_path_segment(&mut self, segment: &'ast syn::PathSegment) {
        if let syn::PathArguments::AngleBracketed(arguments) = &segment.arguments
            && segment.ident == "Vec"
        {
            let of = |argument: &_| matches!(argument, syn::GenericArgument::Type(of) if is_float(of));
            self.0 |= arguments.args.iter().any(of);
        }
        visit::visit_path_segment(self, segment);
    }
}

fn is_float(of: &syn::Type) -> bool {
    matches!(of, syn::Type::Path(path) if path.path.is_ident("f64"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(doc: &str, function: &str) -> Vec<String> {
        let text = format!("impl X {{\n/// {doc}\npub fn f{function} {{}}\n}}");
        let problems = check(&[SourceFile::of_text("crates/x/src/x.rs", &text)]);
        problems.into_iter().map(|problem| problem.message).collect()
    }

    #[test]
    fn a_slice_without_length_or_unit_is_found() {
        assert_eq!(
            found("Distance at `q`, in metres.", "(q: &[f64])"),
            ["`X::f` has a slice of f64, and its doc states no length"]
        );
        let unit = "`X::f` has a slice of f64, and its doc states no unit";
        assert_eq!(found("Times, one per way point.", "() -> Option<Vec<Vec<f64>>>"), [unit]);
        let joint = format!("{unit} of a joint (m, rad)");
        assert_eq!(found("Distance (m) at `q`, one value per joint.", "(q: &mut [f64])"), [joint.as_str()]);
        assert_eq!(
            found("Distance (m). # Panics If `q` has not one value for each joint.", "(q: [&[f64]; 2])"),
            [joint]
        );
        assert_eq!(found("A unit's joints, one a leg.", "(test: &dyn Fn(&[f64]))").len(), 1);
    }

    #[test]
    fn length_and_unit_and_what_is_no_slice_are_fine() {
        for doc in [
            "Distance (m) at `q` (m, rad; one per joint).",
            "Shares, one per finger, from 0 to 1.",
            "As many as given, of no unit.",
        ] {
            assert_eq!(found(doc, "(q: &[f64])"), [""; 0], "{doc}");
        }
        assert_eq!(found("Nothing.", "(q: &[f64; 3], n: Vec<usize>, x: f64)"), [""; 0]);
        let private = "fn f(q: &[f64]) {}\npub(crate) fn g(q: &[f64]) {}\n#[cfg(test)]\nmod tests { pub fn h(q: &[f64]) {} }";
        assert_eq!(check(&[SourceFile::of_text("crates/x/src/x.rs", private)]), []);
        assert_eq!(check(&[SourceFile::of_text("crates/x/tests/x.rs", "pub fn f(q: &[f64]) {}")]), []);
    }
}
