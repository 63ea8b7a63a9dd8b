//! The points of the materials of `constitutive-models`, compiled once, in this crate: over `f64` several particles at once, over jets
//! one by one. A material from outside compiles its own.

use constitutive_models::{Model, Varying};
use perturbation_moments::Jet;

use crate::points::material_points::{MaterialPoints, Points};
use crate::points::points_in_lanes::PointsInLanes;

/// A material with the states of all particles of a body.
pub(crate) type Boxed<S> = Box<dyn MaterialPoints<S>>;

/// The same expression of each material.
#[cfg(not(test))]
macro_rules! of_each {
    ($model:expr, $material:ident => $points:expr) => {
        match $model {
            Model::Liquid($material) => $points,
            Model::CavitatingLiquid($material) => $points,
            Model::Gas($material) => $points,
            Model::Explosive($material) => $points,
            Model::Elastic($material) => $points,
            Model::Plastic($material) => $points,
            Model::ShockedElastic($material) => $points,
            Model::ShockedPlastic($material) => $points,
            Model::Metal($material) => $points,
            Model::BreakingMetal($material) => $points,
            Model::Rubber($material) => $points,
        }
    };
}

/// Unit tests compile one material.
#[cfg(test)]
macro_rules! of_each {
    ($model:expr, $material:ident => $points:expr) => {
        match $model {
            Model::Elastic($material) => $points,
            _ => unreachable!("the bodies of unit tests are elastic"),
        }
    };
}

/// The same expression of the materials of all particles, for those whose constants may vary; else `None`.
macro_rules! of_those_that_vary {
    ($models:expr, $materials:ident => $points:expr; $($name:ident),+) => {
        match $models.first()? {
            $(Model::$name(_) => {
                let of = |model: &_| match model {
                    Model::$name(material) => Some(*material),
                    _ => None,
                };
                let $materials: Vec<_> = $models.iter().map(of).collect::<Option<_>>()?;
                Some($points)
            })+
            _ => None,
        }
    };
}

/// The points of bodies over a number type: of a model, and of one whose constants vary.
macro_rules! points {
    ($of_model:ident, $varying:ident: $number:ty, $points:ident) => {
        pub(crate) fn $of_model(
            model: &Model<$number>,
            plane: bool,
            places: &[[f64; 3]],
        ) -> Boxed<$number> {
            of_each!(model, material => Box::new($points::at_start(*material, plane, places)))
        }

        pub(crate) fn $varying(
            models: &[Model<$number>],
            plane: bool,
            places: &[[f64; 3]],
        ) -> Option<Boxed<$number>> {
            of_those_that_vary!(models, materials => {
                let starts = Varying::starts::<$number>(&materials, places);
                Box::new($points::of_states(Varying::like(materials[0]), plane, &starts))
            }; Elastic, ShockedPlastic, Metal)
        }
    };
}

points! { points_in_lanes, varying_points_in_lanes: f64, PointsInLanes }
points! { points_of_jets, varying_points_of_jets: Jet, Points }
