//! A material whose constants differ from particle to particle.

use perturbation_moments::{Real, Scalar};

use super::{Material, MaterialFamily, Now, Observed};
use crate::error::Fault;
use crate::tensor::Symmetric;

/// A material whose constants differ from particle to particle: each remembers its own, with the numbers that follow from them.
///
/// $$ \sigma^{n+1}_p = \hat\sigma(\text{history}_p; \theta_p), \qquad \theta_p = \theta(X_p) $$
///
/// Symbols: $\theta_p$ = all numbers of the material of particle `p`, checked by its constructor when it was made, constant in
/// time; $X_p$ = the place of the particle in the reference state. Where all particles have the same constants, results are
/// bitwise those of the material itself. `Body::varying` of smpm makes a body of it.
///
/// Costs one more `f64` (or jet) in memory for each number of the material and particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Varying<M> {
    /// The material of one of the particles: what is not a number is the same for all.
    of_one: M,
}

/// What a particle of a [`Varying`] material remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VaryingState<M, T> {
    /// What the material remembers.
    pub history: T,
    /// Its own material.
    pub material: M,
}

impl<M> Varying<M> {
    /// Particles like one of this material, or of other constants.
    #[must_use]
    pub const fn like(of_one: M) -> Self {
        Self { of_one }
    }
}

impl<M: Copy> Varying<M> {
    /// Particles as they start, each of a material and at a place.
    #[must_use]
    pub fn starts<S: Scalar>(materials: &[M], places: &[[f64; 3]]) -> Vec<VaryingState<M, M::State>>
    where
        M: Material<S>,
    {
        let start = |(&material, &place)| Self::like(material).start(place);
        materials.iter().zip(places).map(start).collect()
    }
}

impl<S: Real, M: Material<S> + Copy> Material<S> for Varying<M> {
    type State = VaryingState<M, M::State>;

    /// That of the one particle; [`density_of`](Material::density_of) is that of each.
    fn density(&self) -> S {
        self.of_one.density()
    }

    #[inline(always)]
    fn density_of(&self, state: &Self::State, _usual: S) -> S {
        state.material.density()
    }

    fn start(&self, position: [f64; 3]) -> Self::State
    where
        S: Scalar,
    {
        VaryingState { history: self.of_one.start(position), material: self.of_one }
    }

    fn start_stress(&self, state: &Self::State) -> Symmetric<S>
    where
        S: Scalar,
    {
        state.material.start_stress(&state.history)
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut Self::State) -> Result<Symmetric<S>, Fault> {
        let VaryingState { history, material } = state;
        material.update(now, history)
    }

    #[inline(always)]
    fn wave_speed(&self, volume: S, state: &Self::State) -> S {
        state.material.wave_speed(volume, &state.history)
    }

    #[inline(always)]
    fn observe(&self, state: &Self::State) -> Observed<S>
    where
        S: Scalar,
    {
        state.material.observe(&state.history)
    }

    #[inline(always)]
    fn energy(&self, state: &Self::State) -> S
    where
        S: Scalar,
    {
        state.material.energy(&state.history)
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut Self::State, mut visit: impl FnMut(&mut S)) -> bool {
        let VaryingState { history, material } = state;
        let is_all = self.of_one.visit_numbers(history, &mut visit);
        is_all && material.visit_constants(visit)
    }

    #[inline(always)]
    fn visit_changing(&self, state: &mut Self::State, visit: impl FnMut(&mut S)) {
        self.of_one.visit_changing(&mut state.history, visit);
    }
}

impl<F: Scalar, M: MaterialFamily<F> + Copy> MaterialFamily<F> for Varying<M> {
    type In<S: Real> = Varying<M::In<S>>;

    #[inline(always)]
    fn in_numbers<S: Real>(&self, of: impl Fn(F) -> S + Copy) -> Self::In<S> {
        Varying { of_one: self.of_one.in_numbers(of) }
    }

    #[inline(always)]
    fn filled<S: Real>(&self, number: S) -> <Self::In<S> as Material<S>>::State {
        let material = self.of_one.in_numbers(
            #[inline(always)]
            |_| number,
        );
        VaryingState { history: self.of_one.filled(number), material }
    }
}
