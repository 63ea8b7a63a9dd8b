//! The built-in problems: each is a scene file, and has references.

use sde_integrators::GaussianMixture;

use super::reference::ReferenceTable;
use super::scene::{FpkScene, System};
use crate::case::CaseError;
use crate::scene::SceneFile;

/// A built-in scene with its references.
#[derive(Debug)]
pub struct Problem {
    /// The scene as it stands in its file.
    pub scene: FpkScene,
    /// Its system.
    pub system: System,
    /// Its initial law.
    pub law: GaussianMixture<2>,
    /// Its references.
    pub reference: ReferenceTable,
}

impl Problem {
    /// The linear oscillator of section 4.1 without its damper.
    ///
    /// # Errors
    /// Those of the scene and of the reference data.
    pub fn linear_oscillator() -> Result<Self, CaseError> {
        let text = include_str!("../../scenes/fpk/linear_oscillator.json");
        Self::new(
            "tests/scenes/fpk/linear_oscillator.json",
            text,
            ReferenceTable::linear_oscillator()?,
        )
    }

    /// The oscillator with a viscous damper of section 4.1.
    ///
    /// # Errors
    /// Those of the scene and of the reference data.
    pub fn viscous_damper() -> Result<Self, CaseError> {
        let text = include_str!("../../scenes/fpk/viscous_damper.json");
        Self::new("tests/scenes/fpk/viscous_damper.json", text, ReferenceTable::viscous_damper()?)
    }

    fn new(name: &str, text: &str, reference: ReferenceTable) -> Result<Self, CaseError> {
        let scene: FpkScene = SceneFile::from_text(name, text.to_owned())?.parse()?;
        let system = scene.system.build()?.plane().ok_or("not a system of section 4.1")?;
        let law = scene.initial.build(None)?;
        Ok(Self { scene, system, law, reference })
    }
}
