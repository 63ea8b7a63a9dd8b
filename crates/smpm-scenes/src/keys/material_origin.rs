//! Where the constants of a scene are from.

use smpm::material::library::ALL;

use super::material_scene::MaterialScene;
use crate::scene::SmpmScene;

impl SmpmScene {
    /// Each material with constants of the library or of a file, and their sources.
    pub(crate) fn origins(&self) -> Vec<(String, String)> {
        let named = self.materials.iter().map(|(name, it)| (format!("material `{name}`"), it));
        let all = named.map(|(name, material)| (name, material.origins().join("; ")));
        all.filter(|(_, origins)| !origins.is_empty()).collect()
    }

    /// A note for each card in a file of which some fields have no effect here.
    pub(crate) fn unused_fields(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (name, material) in &self.materials {
            let read = material.keyword_file.as_ref().and_then(|file| file.read.as_ref());
            for (card, unused) in read.iter().flat_map(|(_, it)| &it.cards) {
                if !unused.is_empty() {
                    let fields = unused.join(", ");
                    notes.push(format!("material `{name}`: without effect in {card}: {fields}"));
                }
            }
        }
        notes
    }
}

impl MaterialScene {
    /// The source of each of its models that has one.
    fn origins(&self) -> Vec<String> {
        let read = self.keyword_file.as_ref().and_then(|file| file.read.as_ref());
        let mut origins = Vec::new();
        for (part, model, _, given) in self.models() {
            let is_of = |name: &String| {
                ALL.iter().find(|entry| (entry.model, entry.name) == (model, name.as_str()))
            };
            let of_file = read.filter(|(_, it)| it.numbers.keys().any(|(of, _)| *of == part));
            let source = match (given.library.as_ref().and_then(is_of), of_file) {
                (Some(entry), _) => format!("`{}` of the library, {}", entry.name, entry.source),
                (_, Some((file, it))) => {
                    let cards: Vec<&str> = it.cards.iter().map(|(card, _)| card.as_str()).collect();
                    format!("{}, {}", file.path, cards.join(" and "))
                }
                _ => continue,
            };
            let set: Vec<&str> = given.set.keys().map(String::as_str).collect();
            let set =
                if set.is_empty() { String::new() } else { format!(" ({} set)", set.join(", ")) };
            origins.push(format!("{model}: {source}{set}"));
        }
        origins
    }
}
