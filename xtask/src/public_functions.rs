//! Public functions of a source file, with their docs.

use syn::visit::{self, Visit};

use crate::checkout::SourceFile;

/// Public function, or a method that is public or of a public trait.
pub struct PublicFunction {
    /// Name of the type or trait of a method, `::`, name.
    pub name: String,
    /// Lines of the doc comment, joined by spaces.
    pub doc: String,
    /// Parameters and result.
    pub signature: syn::Signature,
}

/// Returns the public functions of a file of a crate, without those of its tests; none for any other file.
pub fn public_functions(file: &SourceFile) -> Vec<PublicFunction> {
    let is_of_crate = file.path.starts_with("crates/") && file.path.contains("/src/");
    let text = file.text().filter(|_| is_of_crate && file.has_extension("rs"));
    let mut reader = Reader::default();
    if let Some(parsed) = text.and_then(|text| syn::parse_file(text).ok()) {
        reader.visit_file(&parsed);
    }
    reader.functions
}

/// Returns true if an item is compiled only for tests.
pub fn is_for_tests(item: &syn::Item) -> bool {
    let syn::Item::Mod(module) = item else { return false };
    module.attrs.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Path>().is_ok_and(|condition| condition.is_ident("test"))
    })
}

#[derive(Default)]
struct Reader {
    /// Enclosing type or trait, with `::`.
    around: String,
    functions: Vec<PublicFunction>,
}

impl Reader {
    fn add(&mut self, attributes: &[syn::Attribute], signature: &syn::Signature) {
        let name = format!("{}{}", self.around, signature.ident);
        self.functions.push(PublicFunction { name, doc: doc(attributes), signature: signature.clone() });
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_for_tests(item) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if is_public(&item.vis) {
            self.add(&item.attrs, &item.sig);
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        if let syn::Type::Path(own) = &*item.self_ty {
            self.around =
                own.path.segments.last().map_or_else(String::new, |last| format!("{}::", last.ident));
        }
        visit::visit_item_impl(self, item);
        self.around.clear();
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if is_public(&item.vis) {
            self.add(&item.attrs, &item.sig);
        }
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        if is_public(&item.vis) {
            self.around = format!("{}::", item.ident);
            visit::visit_item_trait(self, item);
            self.around.clear();
        }
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        self.add(&item.attrs, &item.sig);
    }
}

fn is_public(visibility: &syn::Visibility) -> bool {
    matches!(visibility, syn::Visibility::Public(_))
}

fn doc(attributes: &[syn::Attribute]) -> String {
    let line = |attribute: &syn::Attribute| match &attribute.meta {
        syn::Meta::NameValue(syn::MetaNameValue {
            path,
            value: syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }),
            ..
        }) if path.is_ident("doc") => Some(text.value().trim().to_owned()),
        _ => None,
    };
    attributes.iter().filter_map(line).collect::<Vec<_>>().join(" ")
}
