//! Packages of the workspace, and their files by module.

use std::fs;
use std::path::{Path, PathBuf};

use syn::{Attribute, Expr, Item, ItemMod, Lit, Meta};

/// A package's library or program.
pub struct Target {
    /// Folder of the package, from the workspace's root; empty for the root package.
    pub folder: PathBuf,
    /// Name by which other crates import it.
    pub name: String,
    /// All files that its modules are in.
    pub files: Vec<SourceFile>,
}

/// A file of a target.
pub struct SourceFile {
    /// Path from the workspace's root.
    pub path: PathBuf,
    /// Path of its module in the crate.
    pub module: Vec<String>,
    /// Whether it is compiled for tests only.
    pub is_test: bool,
    /// Text of the file.
    pub text: String,
    /// Items, without those for tests unless all of it is.
    pub items: Vec<Item>,
    /// Inner attributes, the module's doc comment among them.
    pub attributes: Vec<Attribute>,
}

/// Reads all targets below the root, `src`, `crates` and `tools`.
///
/// # Panics
/// If a file cannot be read or parsed, since nothing can be said then.
pub fn targets(root: &Path) -> Vec<Target> {
    let mut folders = vec![PathBuf::new()];
    for group in ["crates", "tools"] {
        let entries = fs::read_dir(root.join(group)).into_iter().flatten().flatten();
        let mut inner: Vec<PathBuf> = entries.map(|entry| Path::new(group).join(entry.file_name())).collect();
        inner.sort();
        folders.extend(inner);
    }

    let mut targets = Vec::new();
    for folder in folders {
        for entry in ["src/lib.rs", "src/main.rs"] {
            let entry = folder.join(entry);
            if root.join(&entry).is_file() {
                let name = package_name(&root.join(&folder)).replace('-', "_");
                let mut files = Vec::new();
                load(root, &entry, Vec::new(), false, &mut files);
                targets.push(Target { folder: folder.clone(), name, files });
            }
        }
    }

    targets
}

/// Whether an item is compiled for tests only.
pub fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("cfg") => list.tokens.to_string() == "test",
        meta => meta.path().is_ident("test"),
    })
}

/// Attributes of any item.
pub fn attributes_of(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// The name in a package's manifest.
fn package_name(folder: &Path) -> String {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("a package has a manifest");
    let package = manifest.split("[package]").nth(1).unwrap_or_default();
    let name = package.lines().find_map(|line| line.strip_prefix("name = "));
    name.unwrap_or_default().trim_matches('"').to_owned()
}

/// Adds a file and those of the modules that it declares.
fn load(root: &Path, path: &Path, module: Vec<String>, is_test: bool, files: &mut Vec<SourceFile>) {
    let text = fs::read_to_string(root.join(path)).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    let syntax = syn::parse_file(&text).unwrap_or_else(|why| panic!("{}: {why}", path.display()));

    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let beside = path.parent().unwrap_or(Path::new(""));
    let owns_folder = ["lib", "main", "mod"].contains(&&*stem);
    let below = if owns_folder { beside.to_owned() } else { beside.join(&*stem) };

    let (mut kept, mut declared) = (Vec::new(), Vec::new());
    for item in syntax.items {
        let for_tests = is_test || is_for_tests(attributes_of(&item));
        match &item {
            Item::Mod(inner) if inner.content.is_none() => declared.push((inner.clone(), for_tests)),
            _ if for_tests && !is_test => {}
            _ => kept.push(item),
        }
    }

    let this = SourceFile {
        path: path.to_owned(),
        module: module.clone(),
        is_test,
        text,
        items: kept,
        attributes: syntax.attrs,
    };

    files.push(this);

    for (inner, for_tests) in declared {
        let name = inner.ident.to_string();
        let file = match stated_path(&inner) {
            Some(stated) => beside.join(stated),
            None if root.join(&below).join(format!("{name}.rs")).is_file() => {
                below.join(format!("{name}.rs"))
            }
            None => below.join(&name).join("mod.rs"),
        };

        if files.iter().any(|known| known.path == file) {
            continue;
        }

        load(root, &file, [module.clone(), vec![name]].concat(), for_tests, files);
    }
}

/// Reads the path that `#[path = "…"]` states.
fn stated_path(module: &ItemMod) -> Option<String> {
    module.attrs.iter().find_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Str(text) => Some(text.value()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    })
}
