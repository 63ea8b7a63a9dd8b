//! Reader of the paths by which a file names items.

use std::collections::BTreeMap;

use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

/// A path from the root of a package: modules, then an item.
pub(crate) type Names = Vec<String>;

/// Names in the text of a file.
#[derive(Default)]
pub(crate) struct Reader {
    /// Module being read.
    pub(crate) module: Names,
    /// Paths from the root, and as written.
    pub(crate) used: Vec<(Names, String)>,
    /// Re-exported names and their targets.
    pub(crate) exported: BTreeMap<Names, Names>,
}

impl Reader {
    pub(crate) fn read(file: &str, text: &str) -> Self {
        let names = file.trim_end_matches(".rs").split('/');
        let modules = names.filter(|name| !["lib", "main", "mod"].contains(name));
        let mut reader = Self { module: modules.map(String::from).collect(), ..Self::default() };
        reader.visit_file(&syn::parse_file(text).expect(file));
        reader
    }

    /// A path that begins with a simple name counts as one of a child module: no file matches another crate's.
    fn absolute(&self, written: &str) -> Names {
        let mut path = self.module.clone();
        for name in written.split("::") {
            match name {
                "crate" => path.clear(),
                "super" => drop(path.pop()),
                "self" => {}
                name => path.push(name.to_owned()),
            }
        }
        path
    }

    /// A single name may be a variable named like a module.
    fn note(&mut self, written: &str) {
        if written.contains("::") {
            self.used.push((self.absolute(written), written.to_owned()));
        }
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_for_tests(item) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        self.module.push(module.ident.to_string());
        visit::visit_item_mod(self, module);
        self.module.pop();
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        for (path, name) in leaves(&item.tree, "") {
            if matches!(item.vis, Visibility::Inherited) {
                self.note(&path);
            } else {
                assert!(name != "*" && name != "self", "{path}: re-exported without its name");
                self.exported.insert(self.absolute(&name), self.absolute(&path));
            }
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Names = path.segments.iter().map(|name| name.ident.to_string()).collect();
        self.note(&names.join("::"));
        visit::visit_path(self, path);
    }

    /// Arguments of a macro have no syntax yet, but their paths look like paths.
    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        let text = called.tokens.to_string().replace(" :: ", "::");
        for path in text.split(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | ':'))) {
            self.note(path.trim_matches(':'));
        }
        visit::visit_macro(self, called);
    }

    /// `pub(in path)` states who may use an item, and is no use itself.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}
}

fn is_for_tests(item: &Item) -> bool {
    let (Item::Mod(syn::ItemMod { attrs, .. })
    | Item::Fn(syn::ItemFn { attrs, .. })
    | Item::Use(syn::ItemUse { attrs, .. })
    | Item::Impl(syn::ItemImpl { attrs, .. })
    | Item::Const(syn::ItemConst { attrs, .. })
    | Item::Struct(syn::ItemStruct { attrs, .. })) = item
    else {
        return false;
    };
    let is_test = |of: &syn::Attribute| of.parse_args::<syn::Ident>().is_ok_and(|of| of == "test");
    attrs.iter().any(|attribute| attribute.path().is_ident("cfg") && is_test(attribute))
}

/// Paths of a `use`, and the names that they introduce.
fn leaves(tree: &UseTree, before: &str) -> Vec<(String, String)> {
    let leaf = |last: &dyn ToString, name: &dyn ToString| {
        vec![(format!("{before}{}", last.to_string()), name.to_string())]
    };
    match tree {
        UseTree::Path(path) => leaves(&path.tree, &format!("{before}{}::", path.ident)),
        UseTree::Name(name) => leaf(&name.ident, &name.ident),
        UseTree::Rename(name) => leaf(&name.ident, &name.rename),
        UseTree::Glob(_) => leaf(&'*', &'*'),
        UseTree::Group(group) => group.items.iter().flat_map(|of| leaves(of, before)).collect(),
    }
}
