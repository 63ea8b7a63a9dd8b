//! A material over any number type, which is how several particles are computed at once.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use perturbation_moments::{Real, Scalar};

use super::{EquationOfState, Material, Strength};

/// A family of types, one for each number type, and their states.
macro_rules! family {
    ($(#[$about:meta])* $family:ident: $kind:ident) => {
        $(#[$about])*
        pub trait $family<F: Scalar>: $kind<F> {
            /// The same over another number type.
            type In<S: Real>: $kind<S> + Copy;

            /// The same over another number type, each parameter by a function of it.
            fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> Self::In<S>;

            /// A state whose numbers are all the same, to be overwritten by
            /// [`visit_numbers`](Material::visit_numbers).
            fn filled<S: Real>(&self, number: S) -> <Self::In<S> as $kind<S>>::State;
        }
    };
}

family! {
    /// A material whose text serves several particles at once: over `f64` it is computed in the lanes of a register.
    ///
    /// Its update must choose by masks where particles differ ([`Real::select`], [`when`](perturbation_moments::when)): then each lane
    /// has the bits of its particle alone. All of its state must be in [`visit_numbers`](Material::visit_numbers).
    MaterialFamily: Material
}
family! {
    /// An [`EquationOfState`] likewise.
    EquationFamily: EquationOfState
}
family! {
    /// A [`Strength`] likewise.
    StrengthFamily: Strength
}
