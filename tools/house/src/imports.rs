//! Arrows from file to file: who names what another file defines.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

use crate::sources::Target;

/// Names that a file takes from others of its crate, by numbers of files.
pub type Arrows = BTreeMap<(usize, usize), BTreeSet<String>>;

/// Paths into other crates that a file names: the crate's name, then segments.
pub type Outward = BTreeSet<Vec<String>>;

/// Most aliases that lead to a definition.
const MOST_ALIASES: usize = 12;

/// A name in a module.
#[derive(Debug, Clone)]
enum Meaning {
    /// Defined in a file.
    Here(usize),
    /// Brought in from a path in the crate, and handed on or not.
    Alias { path: Vec<String>, is_public: bool },
}

/// Modules of a crate, and the names in each.
#[derive(Debug, Default)]
struct Modules {
    files: HashMap<Vec<String>, usize>,
    names: HashMap<Vec<String>, HashMap<String, Meaning>>,
    globs: HashMap<Vec<String>, Vec<Vec<String>>>,
}

/// Finds all arrows between files of a target that are not for tests.
pub fn arrows(target: &Target) -> Arrows {
    let modules = Modules::of(target);
    let mut arrows = Arrows::new();
    for (number, file) in target.files.iter().enumerate().filter(|(_, file)| !file.is_test) {
        let mut paths = Paths::default();
        file.items.iter().for_each(|item| paths.visit_item(item));
        for path in &paths.found {
            let Some(path) = modules.absolute(&file.module, path) else { continue };
            if let Some(defined) = modules.defining_file(&path).filter(|defined| *defined != number) {
                let name = path.last().cloned().unwrap_or_default();
                arrows.entry((number, defined)).or_default().insert(name);
            }
        }
    }
    arrows
}

/// Lists paths into other crates of this workspace, of all files that are not for tests.
pub fn outward(target: &Target) -> Vec<(usize, Outward)> {
    let mut all = Vec::new();
    for (number, file) in target.files.iter().enumerate().filter(|(_, file)| !file.is_test) {
        let mut paths = Paths { keeps_handed_on: true, ..Paths::default() };
        file.items.iter().for_each(|item| paths.visit_item(item));
        let is_ours = |path: &Vec<String>| path[0].starts_with("hedgehop") || path[0] == "crate";
        all.push((number, paths.found.into_iter().filter(is_ours).collect()));
    }
    all
}

impl Modules {
    fn of(target: &Target) -> Self {
        let mut modules = Self::default();
        for (number, file) in target.files.iter().enumerate() {
            modules.files.insert(file.module.clone(), number);
        }
        for (number, file) in target.files.iter().enumerate() {
            modules.add(&file.module, number, &file.items);
        }
        modules
    }

    fn add(&mut self, module: &[String], file: usize, items: &[Item]) {
        for item in items {
            let name = match item {
                Item::Const(item) => &item.ident,
                Item::Enum(item) => &item.ident,
                Item::Fn(item) => &item.sig.ident,
                Item::Static(item) => &item.ident,
                Item::Struct(item) => &item.ident,
                Item::Trait(item) => &item.ident,
                Item::Type(item) => &item.ident,
                Item::Union(item) => &item.ident,
                Item::Macro(item) => match &item.ident {
                    Some(name) => name,
                    None => continue,
                },
                Item::Mod(inner) => {
                    let module = [module, &[inner.ident.to_string()]].concat();
                    self.files.insert(module.clone(), file);
                    if let Some((_, items)) = &inner.content {
                        self.add(&module, file, items);
                    }
                    continue;
                }
                Item::Use(item) => {
                    let is_public = !matches!(item.vis, Visibility::Inherited);
                    self.add_use(module, &item.tree, Vec::new(), is_public);
                    continue;
                }
                _ => continue,
            };

            let names = self.names.entry(module.to_vec()).or_default();
            names.insert(name.to_string(), Meaning::Here(file));
        }
    }

    fn add_use(&mut self, module: &[String], tree: &UseTree, mut before: Vec<String>, is_public: bool) {
        let (path, name) = match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                return self.add_use(module, &path.tree, before, is_public);
            }
            UseTree::Group(group) => {
                for tree in &group.items {
                    self.add_use(module, tree, before.clone(), is_public);
                }
                return;
            }
            UseTree::Glob(_) => {
                if let Some(path) = self.absolute(module, &before) {
                    self.globs.entry(module.to_vec()).or_default().push(path);
                }
                return;
            }
            UseTree::Name(name) if name.ident == "self" => {
                let last = before.last().cloned().unwrap_or_default();
                (before, last)
            }
            UseTree::Name(name) => {
                before.push(name.ident.to_string());
                (before, name.ident.to_string())
            }
            UseTree::Rename(rename) => {
                if rename.ident != "self" {
                    before.push(rename.ident.to_string());
                }
                (before, rename.rename.to_string())
            }
        };

        // A name that stands alone after `use` is an external crate, or brings in what is there already.
        if path.len() > 1
            && let Some(path) = self.absolute(module, &path)
        {
            let meaning = Meaning::Alias { path, is_public };
            self.names.entry(module.to_vec()).or_default().entry(name).or_insert(meaning);
        }
    }

    /// The path from the crate's root; `None` if it leads into another crate.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Vec<String>> {
        let mut base = module.to_vec();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => (base, rest) = (Vec::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    base.pop()?;
                    rest = &rest[1..];
                }
            }
            first => {
                let inner = [module, &[first.to_owned()]].concat();
                match self.names.get(module).and_then(|names| names.get(first)) {
                    _ if self.files.contains_key(&inner) => {}
                    Some(Meaning::Alias { path, .. }) => (base, rest) = (path.clone(), &rest[1..]),
                    Some(Meaning::Here(_)) => {}
                    None => return None,
                }
            }
        }

        Some([base, rest.to_vec()].concat())
    }

    /// The file in which what a path names is defined; `None` for a module itself, or what is not known.
    fn defining_file(&self, path: &[String]) -> Option<usize> {
        let mut path = path.to_vec();
        for _ in 0..MOST_ALIASES {
            let depth = (0..=path.len()).rev().find(|depth| self.files.contains_key(&path[..*depth]))?;
            let (module, rest) = path.split_at(depth);
            let name = rest.first()?;
            match self.names.get(module).and_then(|names| names.get(name)) {
                Some(Meaning::Here(file)) => return Some(*file),
                Some(Meaning::Alias { path: target, .. }) => {
                    path = [target.clone(), rest[1..].to_vec()].concat()
                }
                None => {
                    let globs = self.globs.get(module)?;
                    let through = |glob: &Vec<String>| {
                        let path = [glob.clone(), rest.to_vec()].concat();
                        (path != [module, rest].concat()).then(|| self.directly(&path)).flatten()
                    };
                    return globs.iter().find_map(through);
                }
            }
        }

        None
    }

    /// Finds the file that defines what a module itself defines or hands on, as [`Self::defining_file`] does.
    fn directly(&self, path: &[String]) -> Option<usize> {
        let depth = (0..=path.len()).rev().find(|depth| self.files.contains_key(&path[..*depth]))?;
        match self.names.get(&path[..depth])?.get(path.get(depth)?)? {
            Meaning::Here(file) => Some(*file),
            Meaning::Alias { path: target, is_public } => {
                is_public.then(|| self.defining_file(target)).flatten()
            }
        }
    }
}

/// Paths that code names, as they are written.
#[derive(Debug, Default)]
struct Paths {
    found: BTreeSet<Vec<String>>,
    /// Whether those of `pub use` count.
    keeps_handed_on: bool,
}

impl Paths {
    fn add_use(&mut self, tree: &UseTree, mut before: Vec<String>) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_use(&path.tree, before);
            }
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_use(tree, before.clone())),
            UseTree::Name(name) => {
                if name.ident != "self" {
                    before.push(name.ident.to_string());
                }
                self.found.insert(before);
            }
            UseTree::Rename(rename) => {
                before.push(rename.ident.to_string());
                self.found.insert(before);
            }
            UseTree::Glob(_) => {}
        }
    }

    /// Paths in what a macro is given, which is no syntax yet.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.found.insert(std::mem::take(&mut path));
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(point) if point.as_char() == ':' => colons += 1,
                other => {
                    self.found.insert(std::mem::take(&mut path));
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.add_tokens(group.stream());
                    }
                }
            }
        }

        self.found.insert(path);
        self.found.remove(&Vec::new());
    }
}

impl<'a> Visit<'a> for Paths {
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        if self.keeps_handed_on || matches!(item.vis, Visibility::Inherited) {
            self.add_use(&item.tree, Vec::new());
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        self.found.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, invoked: &'a syn::Macro) {
        self.add_tokens(invoked.tokens.clone());
        visit::visit_macro(self, invoked);
    }

    fn visit_attribute(&mut self, _: &'a syn::Attribute) {}
}
