//! Readability of code: first lines of doc comments, paragraphs, comments, parameters.

use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Block, Expr, Lit, Meta, Type};

use crate::sources::SourceFile;

/// Lines of a body from which on it needs a paragraph, and from which on it is long.
const NEEDS_PARAGRAPH: usize = 30;
const LONG: usize = 60;

/// Words with which a first line leans on something that stands elsewhere.
const LEANING: [&str; 34] = [
    "that", "those", "these", "this", "they", "them", "their", "theirs", "it", "its", "itself", "of", "what",
    "which", "who", "whom", "whose", "such", "so", "as", "where", "when", "how", "there", "here", "then",
    "thereby", "in", "to", "by", "from", "for", "with", "likewise",
];

/// Counts of what was read.
#[derive(Debug, Default, Clone)]
pub struct Prose {
    /// Doc comments.
    pub docs: usize,
    /// Doc comments whose first line cannot be understood alone: file, line and text.
    pub leaning: Vec<(String, usize, String)>,
    /// Functions and methods with a body.
    pub functions: usize,
    /// Functions with bodies of more than 30 lines.
    pub large: usize,
    /// Large functions without a blank line inside: file, line and name.
    pub walls: Vec<(String, usize, String)>,
    /// Functions with bodies of more than 60 lines: file, line and name.
    pub long: Vec<(String, usize, String)>,
    /// Functions with a parameter that is a tuple: file, line and name.
    pub tuples: Vec<(String, usize, String)>,
    /// Lines inside of bodies.
    pub body_lines: usize,
    /// Blank ones among them.
    pub blank_lines: usize,
    /// Comments among them.
    pub comments: usize,
}

impl Prose {
    /// Reads a file.
    pub fn read(&mut self, file: &SourceFile) {
        let lines: Vec<&str> = file.text.lines().collect();
        let path = file.path.display().to_string();
        let mut reader = Reader { prose: self, lines, path, depth: 0 };
        reader.doc(&file.attributes);
        file.items.iter().for_each(|item| reader.visit_item(item));
    }
}

/// Reads one file.
struct Reader<'p> {
    prose: &'p mut Prose,
    lines: Vec<&'p str>,
    path: String,
    /// Bodies around the present place.
    depth: usize,
}

impl Reader<'_> {
    fn doc(&mut self, attributes: &[Attribute]) {
        let first = attributes.iter().find_map(|attribute| match &attribute.meta {
            Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
                Expr::Lit(literal) => match &literal.lit {
                    Lit::Str(text) => Some((attribute.span().start().line, text.value().trim().to_owned())),
                    _ => None,
                },
                _ => None,
            },
            _ => None,
        });
        let Some((line, text)) = first else { return };
        self.prose.docs += 1;
        let is_word = |c: char| c.is_alphabetic() || c == '\'';
        let word: String = text.chars().take_while(|c| is_word(*c)).collect::<String>().to_lowercase();
        if LEANING.contains(&word.as_str()) {
            self.prose.leaning.push((self.path.clone(), line, text));
        }
    }

    fn function(&mut self, signature: &syn::Signature, body: &Block) {
        let place = (self.path.clone(), signature.span().start().line, signature.ident.to_string());
        self.prose.functions += 1;
        let is_tuple = |input: &syn::FnArg| match input {
            syn::FnArg::Typed(typed) => holds_tuple(&typed.ty),
            syn::FnArg::Receiver(_) => false,
        };
        if signature.inputs.iter().any(is_tuple) {
            self.prose.tuples.push(place.clone());
        }

        let braces = body.brace_token.span;
        let (first, last) = (braces.open().start().line, braces.close().start().line);
        let inside = self.lines.get(first..last.saturating_sub(1)).unwrap_or_default();
        let blank = inside.iter().filter(|line| line.trim().is_empty()).count();

        if inside.len() > NEEDS_PARAGRAPH {
            self.prose.large += 1;
            if blank == 0 {
                self.prose.walls.push(place.clone());
            }
        }

        if inside.len() > LONG {
            self.prose.long.push(place);
        }
        if self.depth == 0 {
            self.prose.body_lines += inside.len();
            self.prose.blank_lines += blank;
            let is_comment = |line: &&&str| line.trim_start().starts_with("//");
            self.prose.comments += inside.iter().filter(is_comment).count();
        }
    }
}

/// Whether a type is a tuple of two or more, or a reference to or a slice of such.
fn holds_tuple(of: &Type) -> bool {
    match of {
        Type::Tuple(tuple) => tuple.elems.len() > 1,
        Type::Reference(reference) => holds_tuple(&reference.elem),
        Type::Slice(slice) => holds_tuple(&slice.elem),
        Type::Array(array) => holds_tuple(&array.elem),
        _ => false,
    }
}

/// Visits an item that has a doc comment, then what is in it.
macro_rules! with_docs {
    ($($visit:ident: $kind:ty),* $(,)?) => {
        $(fn $visit(&mut self, item: &'a $kind) {
            self.doc(&item.attrs);
            visit::$visit(self, item);
        })*
    };
}

impl<'a> Visit<'a> for Reader<'_> {
    with_docs! {
        visit_item_const: syn::ItemConst,
        visit_item_enum: syn::ItemEnum,
        visit_item_mod: syn::ItemMod,
        visit_item_static: syn::ItemStatic,
        visit_item_struct: syn::ItemStruct,
        visit_item_trait: syn::ItemTrait,
        visit_item_type: syn::ItemType,
        visit_item_macro: syn::ItemMacro,
        visit_field: syn::Field,
        visit_variant: syn::Variant,
        visit_impl_item_const: syn::ImplItemConst,
        visit_trait_item_const: syn::TraitItemConst,
        visit_trait_item_type: syn::TraitItemType,
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.doc(&item.attrs);
        self.function(&item.sig, &item.block);
        self.depth += 1;
        visit::visit_item_fn(self, item);
        self.depth -= 1;
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        self.doc(&item.attrs);
        self.function(&item.sig, &item.block);
        self.depth += 1;
        visit::visit_impl_item_fn(self, item);
        self.depth -= 1;
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        self.doc(&item.attrs);
        if let Some(body) = &item.default {
            self.function(&item.sig, body);
        }
        self.depth += 1;
        visit::visit_trait_item_fn(self, item);
        self.depth -= 1;
    }
}
