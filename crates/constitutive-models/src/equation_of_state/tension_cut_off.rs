//! A limit of tension on any equation of state.

use perturbation_moments::{Real, Scalar};

use super::{EquationOfState, Line, Start};
use crate::error::{Error, Fault, not_negative};
use crate::{EquationFamily, Now};

/// An equation of state whose pressure does not fall below `-limit`: a liquid that cavitates.
///
/// The pressure stays at the limit while the volume grows; the energy knows the pressure that acted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TensionCutOff<E, S> {
    equation: E,
    least: S,
}

impl<E, S: Scalar> TensionCutOff<E, S> {
    /// `limit >= 0` is the largest tension (stress).
    ///
    /// # Errors
    /// [`Error::Negative`] or [`Error::NotFinite`] for the limit.
    pub fn new(equation: E, limit: S) -> Result<Self, Error> {
        not_negative("tension limit", limit.value())?;
        Ok(Self { equation, least: limit * -1.0 })
    }
}

impl<S: Real, E: EquationOfState<S>> EquationOfState<S> for TensionCutOff<E, S> {
    type State = E::State;

    const KNOWS_ENERGY: bool = E::KNOWS_ENERGY;

    #[inline(always)]
    fn density(&self) -> S {
        self.equation.density()
    }

    fn start(&self, position: [f64; 3]) -> Start<S, Self::State>
    where
        S: Scalar,
    {
        self.equation.start(position)
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        self.equation.line(volume)
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        self.equation.slope(volume)
    }

    #[inline(always)]
    fn advance(&self, now: &Now<S>, state: &mut Self::State) -> Option<S> {
        self.equation.advance(now, state)
    }

    #[inline(always)]
    fn least_pressure(&self) -> Option<S> {
        Some(self.least)
    }

    #[inline(always)]
    fn admit(&self, volume: S) -> Result<(), Fault> {
        self.equation.admit(volume)
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut Self::State, visit: impl FnMut(&mut S)) -> bool {
        self.equation.visit_numbers(state, visit)
    }
}

impl<F: Scalar, E: EquationFamily<F>> EquationFamily<F> for TensionCutOff<E, F> {
    type In<S: Real> = TensionCutOff<E::In<S>, S>;

    #[inline(always)]
    fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> Self::In<S> {
        TensionCutOff { equation: self.equation.in_numbers(of), least: of(self.least) }
    }

    #[inline(always)]
    fn filled<S: Real>(&self, number: S) -> <E::In<S> as EquationOfState<S>>::State {
        self.equation.filled(number)
    }
}
