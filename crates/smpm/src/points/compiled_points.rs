//! The points of the materials of `constitutive-models`, compiled once, in this crate: over `f64` several particles at once, over jets
//! one by one. A material from outside compiles its own.

use constitutive_models::{Model, Varying};
use perturbation_moments::Jet;

use crate::number::CarriedNumber;
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

/// A number of which bodies are made: `f64`, or a [`Jet`], which carries the derivatives of its history.
///
/// A material may be computed with any [`Scalar`](crate::Scalar); a run takes one of these two.
pub trait Number: CarriedNumber {
    /// The particles of a body, at their places; whether the motion stays in the plane of the first two axes.
    #[doc(hidden)]
    #[allow(private_interfaces, reason = "a number is one of this crate's")]
    fn points(model: &Model<Self>, plane: bool, places: &[[f64; 3]]) -> Boxed<Self>;

    /// The same of a material whose constants vary, by that of each particle; `None` where they cannot.
    #[doc(hidden)]
    #[allow(private_interfaces, reason = "a number is one of this crate's")]
    fn varying_points(
        models: &[Model<Self>],
        plane: bool,
        places: &[[f64; 3]],
    ) -> Option<Boxed<Self>>;
}

/// Bodies over a number type.
macro_rules! number {
    ($number:ty, $points:ident) => {
        #[allow(private_interfaces, reason = "a number is one of this crate's")]
        impl Number for $number {
            fn points(model: &Model<Self>, plane: bool, places: &[[f64; 3]]) -> Boxed<Self> {
                of_each!(model, material => Box::new($points::at_start(*material, plane, places)))
            }

            fn varying_points(
                models: &[Model<Self>],
                plane: bool,
                places: &[[f64; 3]],
            ) -> Option<Boxed<Self>> {
                of_those_that_vary!(models, materials => {
                    let starts = Varying::starts::<$number>(&materials, places);
                    Box::new($points::of_states(Varying::like(materials[0]), plane, &starts))
                }; Elastic, ShockedPlastic, Metal)
            }
        }
    };
}

// Several particles at once; one by one.
number!(f64, PointsInLanes);
number!(Jet, Points);
