#![doc = include_str!("../README.md")]
#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched closure is not compiled for its registers"
)]

/// A plain struct of parameters over a number type, with their names.
macro_rules! parameters {
    ($(#[$about:meta])* $name:ident { $($(#[doc = $meaning:literal])+ $field:ident),+ $(,)? }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name<S> {
            $($(#[doc = $meaning])+ pub $field: S),+
        }

        impl<S> $name<S> {
            /// The names of the parameters.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($field)),+];

            /// What each of them is, with its unit by quantity, as documented here, in the order of [`NAMES`](Self::NAMES).
            pub const MEANINGS: &'static [&'static str] = &[$(concat!($($meaning),+)),+];

            /// Every parameter by a function of its name, in the order of [`NAMES`](Self::NAMES).
            ///
            /// # Errors
            /// The first that the function returns.
            pub fn try_from_names<F>(
                mut of: impl FnMut(&'static str) -> Result<S, F>,
            ) -> Result<Self, F> {
                Ok($name { $($field: of(stringify!($field))?),+ })
            }

            /// Every parameter by a function of its name and value, in the order of [`NAMES`](Self::NAMES): how numbers become
            /// jets.
            #[must_use]
            #[inline(always)]
            pub fn map<T>(self, mut of: impl FnMut(&'static str, S) -> T) -> $name<T> {
                $name { $($field: of(stringify!($field), self.$field)),+ }
            }
        }
    };
}

/// Makes a struct of parameters, of numbers that follow from them and of what is the same in all number types a member of its family.
macro_rules! family_member {
    ($family:ident, $kind:ident: $name:ident { $($number:ident),* $(; $kept:ident)* }, $filled:ident => $state:expr) => {
        impl<F: Scalar> $family<F> for $name<F> {
            type In<S: Real> = $name<S>;

            #[inline(always)]
            fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> $name<S> {
                $name {
                    parameters: self.parameters.map(
                        #[inline(always)]
                        |_, number| of(number),
                    ),
                    $($number: of(self.$number),)*
                    $($kept: self.$kept,)*
                }
            }

            #[inline(always)]
            fn filled<S: Real>(&self, $filled: S) -> <$name<S> as $kind<S>>::State {
                $state
            }
        }
    };
}

/// Shows the parameters of a material, and the numbers that follow from them.
macro_rules! shows_constants {
    ($($number:ident),*) => {
        #[inline(always)]
        fn visit_constants(&mut self, mut visit: impl FnMut(&mut S)) -> bool {
            self.parameters = self.parameters.map(
                #[inline(always)]
                |_, mut number| {
                    visit(&mut number);
                    number
                },
            );
            $(visit(&mut self.$number);)*
            true
        }
    };
}

mod equation_of_state;
mod error;
mod family;
pub mod library;
mod local;
mod material;
mod model;
mod neo_hookean;
mod observed;
mod solid;
mod strength;
pub mod tensor;
mod units;
mod varying;

pub use equation_of_state::{
    Detonation, ElasticBulk, ElasticBulkParameters, EquationOfState, Jwl, JwlParameters, Line,
    MieGruneisen, MieGruneisenParameters, Start, StiffenedGas, StiffenedGasParameters,
    TensionCutOff,
};
pub use error::{Error, Fault, finite, not_negative, positive, within};
pub use family::{EquationFamily, MaterialFamily, StrengthFamily};
pub use local::{LocalFlow, LocalResponse, LocalState};
pub use material::{Material, Now};
pub use model::Model;
pub use neo_hookean::{NeoHookean, NeoHookeanParameters, NeoHookeanState};
pub use observed::Observed;
pub use perturbation_moments::{Real, Scalar};
pub use solid::{LinearElasticParameters, LinearElasticSolid, Solid, SolidState};
pub use strength::{
    ElasticShear, ElasticShearParameters, Fluid, JohnsonCook, JohnsonCookDamage,
    JohnsonCookDamageParameters, JohnsonCookDamageState, JohnsonCookParameters, JohnsonCookState,
    Strength, VonMises, VonMisesParameters, VonMisesState,
};
pub use units::Units;
pub use varying::{Varying, VaryingState};
