//! A file of material cards that a material names.

use scene_runs::scene::NamedFile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::units_scene::UnitsScene;
use crate::keyword_file::Constants;

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
