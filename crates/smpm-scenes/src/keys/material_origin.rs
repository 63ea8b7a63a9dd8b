//! Where the constants of a scene are from: the library, and files of cards.

use std::path::Path;

use scene_runs::scene::{NamedFile, Objection};
use smpm::material::Units;
use smpm::material::library::ALL;

use super::material_scene::{MaterialPart, MaterialScene};
use crate::keyword_file::{Cards, Constants};
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
    /// Reads constants that are neither set nor of the library from the file that it names, if any.
    pub(crate) fn read_file(
        &mut self,
        folder: &Path,
        units: &Units,
        path: &str,
    ) -> Result<(), Objection> {
        let Some(file) = &self.keyword_file else { return Ok(()) };
        let key = format!("{path}.keyword_file");
        let from = file.units.units().map_err(|objection| Objection {
            path: format!("{key}.{}", objection.path),
            ..objection
        })?;
        let named = NamedFile::beside((&file.path, folder), &format!("{key}.path"), "")?;
        // Titles and comments may be in any encoding; a number is in ASCII.
        let text = String::from_utf8_lossy(&named.1);
        // Damage is of the same card as the strength.
        let has_flow = matches!(&self.strength, Some(it) if it.parts().2.library.is_none());
        let models = self.models().into_iter().filter(|(part, .., given)| {
            given.library.is_none() && (*part != MaterialPart::Damage || has_flow)
        });
        let wanted = models.map(|(part, model, names, given)| {
            let names = names.iter().copied().filter(|name| !given.set.contains_key(*name));
            (part, model, names.collect())
        });
        let cards = Cards::of(&text, &key, &file.path);
        let constants =
            Constants::of(&cards, &wanted.collect(), [file.mid, file.eosid], [&from, units])?;
        if constants.numbers.is_empty() {
            let message = "no constant of this material is taken from the file";
            return Err(Objection::new(key, message).with_help(
                "it has those of mie_gruneisen, jwl, johnson_cook, damage and von_mises that neither `set` nor `library` gives",
            ));
        }
        if let Some(file) = &mut self.keyword_file {
            file.read = Some((named.0, constants));
        }
        Ok(())
    }

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
                (_, Some((file, _))) => file.path.clone(),
                _ => continue,
            };
            let set: Vec<&str> = given.set.keys().map(String::as_str).collect();
            let set =
                if set.is_empty() { String::new() } else { format!(" ({} set)", set.join(", ")) };
            origins.push(format!("{model}: {source}{set}"));
        }
        origins.extend(read.map(|(file, it)| {
            let cards: Vec<&str> = it.cards.iter().map(|(card, _)| card.as_str()).collect();
            format!("cards of {}: {}", file.path, cards.join(", "))
        }));
        origins
    }
}
