//! A file of material cards that a material names.

use std::path::Path;

use scene_runs::scene::{NamedFile, Objection};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use smpm::material::Units;

use super::material_scene::{MaterialPart, MaterialScene};
use super::scene::UnitsScene;
use crate::keyword_file::{Cards, Constants};

/// A keyword file of LS-DYNA that has constants of a material. Includes, parameters, expressions and the long format are not read.
///
/// Cards: `*MAT_JOHNSON_COOK` for the strength `johnson_cook` and `damage`, `*MAT_PLASTIC_KINEMATIC` for `von_mises`, `*EOS_GRUNEISEN`
/// for `mie_gruneisen`, `*EOS_JWL` and `*MAT_HIGH_EXPLOSIVE_BURN` for `jwl`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeywordFileScene {
    /// Its path, from the folder of the scene.
    pub path: String,
    /// System of units of its numbers, which need not be that of the scene. Temperatures are in kelvin.
    pub units: UnitsScene,
    /// `MID` of the material card, where the file has several of its kind (no unit).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = 1)]
    pub mid: Option<u64>,
    /// `EOSID` of the equation of state, where the file has several of its kind (no unit).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(example = 1)]
    pub eosid: Option<u64>,
    /// What was read of it.
    #[serde(skip)]
    pub(crate) read: Option<(NamedFile, Constants)>,
}

impl KeywordFileScene {
    pub(super) fn example() -> Self {
        let (path, units) = ("steel.k".to_owned(), UnitsScene::MmKgMs);
        Self { path, units, mid: None, eosid: None, read: None }
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
}
