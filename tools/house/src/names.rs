//! Names of types that exist more than once, and names that a library shows.

use std::collections::{BTreeMap, BTreeSet};

use syn::{Attribute, Item, UseTree, Visibility};

use crate::sources::{Target, attributes_of};

/// Types of a target by name, with the files that define them; those for tests are left out.
pub fn types(target: &Target) -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in target.files.iter().filter(|file| !file.is_test) {
        let mut add = |name: &syn::Ident| {
            found.entry(name.to_string()).or_default().push(file.path.display().to_string());
        };
        file.items.iter().for_each(|item| add_types(item, &mut add));
    }
    found
}

fn add_types(item: &Item, add: &mut impl FnMut(&syn::Ident)) {
    match item {
        Item::Enum(item) => add(&item.ident),
        Item::Struct(item) => add(&item.ident),
        Item::Trait(item) => add(&item.ident),
        Item::Type(item) => add(&item.ident),
        Item::Union(item) => add(&item.ident),
        Item::Mod(inner) => {
            let items = inner.content.iter().flat_map(|(_, items)| items);
            items.for_each(|item| add_types(item, add));
        }
        _ => {}
    }
}

/// Names that rustdoc shows of a library, with their modules: what is public, reachable, and not hidden.
pub fn public(target: &Target) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let is_module = |path: &[String]| target.files.iter().any(|file| file.module == path);
    let mut todo = vec![Vec::new()];
    while let Some(module) = todo.pop() {
        let Some(file) = target.files.iter().find(|file| file.module == module) else { continue };
        for item in file.items.iter().filter(|item| !is_hidden(attributes_of(item))) {
            let (visibility, name) = match item {
                Item::Const(item) => (&item.vis, &item.ident),
                Item::Enum(item) => (&item.vis, &item.ident),
                Item::Fn(item) => (&item.vis, &item.sig.ident),
                Item::Static(item) => (&item.vis, &item.ident),
                Item::Struct(item) => (&item.vis, &item.ident),
                Item::Trait(item) => (&item.vis, &item.ident),
                Item::Type(item) => (&item.vis, &item.ident),
                Item::Union(item) => (&item.vis, &item.ident),
                Item::Use(item) => {
                    if matches!(item.vis, Visibility::Public(_)) {
                        leaves(&item.tree, &mut |name| {
                            names.insert([module.clone(), vec![name]].concat().join("::"));
                        });
                    }
                    continue;
                }
                _ => continue,
            };

            if matches!(visibility, Visibility::Public(_)) {
                names.insert([module.clone(), vec![name.to_string()]].concat().join("::"));
            }
        }

        for inner in public_modules(&file.text) {
            let path = [module.clone(), vec![inner]].concat();
            if is_module(&path) {
                todo.push(path);
            }
        }
    }

    names
}

/// Modules in files of their own that a file declares as public and does not hide.
fn public_modules(text: &str) -> Vec<String> {
    let syntax = syn::parse_file(text).map(|file| file.items).unwrap_or_default();
    let shown = syntax.into_iter().filter_map(|item| match item {
        Item::Mod(inner) if matches!(inner.vis, Visibility::Public(_)) && !is_hidden(&inner.attrs) => {
            Some(inner.ident.to_string())
        }
        _ => None,
    });
    shown.collect()
}

fn is_hidden(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) if list.path.is_ident("doc") => list.tokens.to_string().contains("hidden"),
        _ => false,
    })
}

fn leaves(tree: &UseTree, add: &mut impl FnMut(String)) {
    match tree {
        UseTree::Path(path) => leaves(&path.tree, add),
        UseTree::Group(group) => group.items.iter().for_each(|tree| leaves(tree, add)),
        UseTree::Name(name) => add(name.ident.to_string()),
        UseTree::Rename(rename) => add(rename.rename.to_string()),
        UseTree::Glob(_) => add("*".to_owned()),
    }
}
