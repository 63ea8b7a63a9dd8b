//! Bodies whose constants vary from particle to particle.

use scene_runs::scene::Objection;
use smpm::material::{
    ElasticBulk, ElasticBulkParameters, ElasticShear, ElasticShearParameters, JohnsonCook,
    JohnsonCookParameters, MieGruneisen, MieGruneisenParameters, Solid, VonMises,
    VonMisesParameters,
};
use smpm::{Body, Error, Fill, Number, ParameterError};

use crate::material_scene::{EquationScene, MaterialScene, Part, StrengthScene};

/// Materials whose constants may vary: those that smpm computes several particles at once.
enum Kind {
    Elastic,
    VonMises,
    JohnsonCook,
}

impl Kind {
    const fn of(material: &MaterialScene) -> Option<Self> {
        match (&material.equation, &material.strength, &material.damage) {
            (EquationScene::ElasticBulk(_), Some(StrengthScene::Elastic(_)), None) => {
                Some(Self::Elastic)
            }
            (EquationScene::MieGruneisen(_), Some(StrengthScene::VonMises(_)), None) => {
                Some(Self::VonMises)
            }
            (EquationScene::MieGruneisen(_), Some(StrengthScene::JohnsonCook(_)), None) => {
                Some(Self::JohnsonCook)
            }
            _ => None,
        }
    }
}

impl MaterialScene {
    /// Rejects a material whose constants cannot vary in space.
    pub(crate) fn check_varying(&self, path: &str) -> Result<(), Objection> {
        if Kind::of(self).is_some() {
            return Ok(());
        }
        let message = "the constants of this material cannot vary in space";
        Err(Objection::new(path, message).with_help(
            "they can of `elastic_bulk` with `elastic`, and of `mie_gruneisen` with `von_mises` or `johnson_cook` without damage",
        ))
    }

    /// A body of the material; `of` has the constants of a particle. Of a material whose constants cannot vary, those of the
    /// first.
    ///
    /// # Errors
    /// Errors of the model, with the particle.
    pub(crate) fn varying_body<S: Number, const D: usize>(
        &self,
        of: &dyn Fn(usize, Part, &'static str) -> S,
        fill: &Fill<D>,
        velocity: [f64; D],
    ) -> Result<Body<S, D>, Error> {
        let given = |particle: usize, part: Part| {
            move |name: &'static str| -> Result<S, ParameterError> { Ok(of(particle, part, name)) }
        };
        let mie_gruneisen = |particle: usize| {
            let parameters = given(particle, Part::Equation);
            MieGruneisen::new(MieGruneisenParameters::try_from_names(parameters)?)
        };
        match Kind::of(self) {
            Some(Kind::Elastic) => {
                let material = |p: usize, _: &[f64; D]| {
                    let equation = given(p, Part::Equation);
                    let equation =
                        ElasticBulk::new(ElasticBulkParameters::try_from_names(equation)?)?;
                    let strength = given(p, Part::Strength);
                    let strength =
                        ElasticShear::new(ElasticShearParameters::try_from_names(strength)?)?;
                    Ok(Solid { equation, strength })
                };
                Body::varying(material, fill, velocity)
            }
            Some(Kind::VonMises) => {
                let material = |p: usize, _: &[f64; D]| {
                    let parameters = VonMisesParameters::try_from_names(given(p, Part::Strength))?;
                    let strength = VonMises::new(parameters)?;
                    Ok(Solid { equation: mie_gruneisen(p)?, strength })
                };
                Body::varying(material, fill, velocity)
            }
            Some(Kind::JohnsonCook) => {
                let material = |p: usize, _: &[f64; D]| {
                    let strength = given(p, Part::Strength);
                    let strength =
                        JohnsonCook::new(JohnsonCookParameters::try_from_names(strength)?)?;
                    Ok(Solid { equation: mie_gruneisen(p)?, strength })
                };
                Body::varying(material, fill, velocity)
            }
            None => self.body(&|part, name| of(0, part, name), fill, velocity),
        }
    }
}
