//! Compressible neo-Hookean elasticity.

use perturbation_moments::{Real, Scalar, when};

use super::{Material, MaterialFamily, Now, Observed};
use crate::error::{Error, Fault, positive};
use crate::tensor::Symmetric;

parameters! {
    /// What a [`NeoHookean`] is made of.
    NeoHookeanParameters {
        /// `rho_0 > 0` (mass per volume).
        density,
        /// `mu > 0` (stress).
        shear_modulus,
        /// `K > 0` of small strain (stress).
        bulk_modulus,
    }
}

/// Elasticity of large strain, with an energy of its own.
///
/// $$ W = \tfrac{\mu}{2} (\operatorname{tr} B - 3) - \mu \ln J + \tfrac{\lambda}{2} \ln^2 J, \qquad
///    \sigma = \frac{\mu}{J} (B - I) + \frac{\lambda \ln J}{J} I, \qquad \lambda = K - \tfrac23 \mu $$
///
/// Symbols: $B = F F^T$, $F^{n+1} = (I + L \Delta t) F^n$. Without bulk viscosity the energy depends on `F` alone: a closed path
/// gives back all work, up to the error of the step.
///
/// Source: Bonet and Wood 2008, eq 6.27-6.29.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookean<S> {
    parameters: NeoHookeanParameters<S>,
    lambda: S,
}

/// What a particle of a [`NeoHookean`] material remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookeanState<S> {
    /// `F`.
    pub deformation_gradient: [[S; 3]; 3],
    /// `V/V_0`.
    pub volume: S,
    /// The work of the bulk viscosity per reference volume (stress).
    pub heat: S,
}

impl<S: Scalar> NeoHookean<S> {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a parameter that is not above zero.
    pub fn new(parameters: NeoHookeanParameters<S>) -> Result<Self, Error> {
        positive("density", parameters.density.value())?;
        positive("shear modulus", parameters.shear_modulus.value())?;
        positive("bulk modulus", parameters.bulk_modulus.value())?;
        let lambda = parameters.bulk_modulus - parameters.shear_modulus * (2.0 / 3.0);
        Ok(Self { parameters, lambda })
    }
}

/// `B = F F^T`.
#[inline(always)]
fn left_cauchy_green<S: Real>(f: &[[S; 3]; 3]) -> Symmetric<S> {
    let mut entries = [f[0][0]; 6];
    for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].into_iter().enumerate() {
        entries[k] = f[i][0] * f[j][0] + f[i][1] * f[j][1] + f[i][2] * f[j][2];
    }
    Symmetric(entries)
}

impl<S: Real> Material<S> for NeoHookean<S> {
    type State = NeoHookeanState<S>;

    fn density(&self) -> S {
        self.parameters.density
    }

    fn start(&self, _position: [f64; 3]) -> NeoHookeanState<S>
    where
        S: Scalar,
    {
        let (zero, one) = (S::constant(0.0), S::constant(1.0));
        NeoHookeanState {
            deformation_gradient: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            volume: one,
            heat: zero,
        }
    }

    #[inline(always)]
    fn update(&self, now: &Now<S>, state: &mut NeoHookeanState<S>) -> Result<Symmetric<S>, Fault> {
        let (l, f) = (&now.velocity_gradient, state.deformation_gradient);
        for i in 0..3 {
            for j in 0..3 {
                let increment = l[i][0] * f[0][j] + l[i][1] * f[1][j] + l[i][2] * f[2][j];
                state.deformation_gradient[i][j] = f[i][j] + increment * now.dt;
            }
        }
        state.heat = state.heat - now.viscosity * (now.volume - now.volume_before);
        state.volume = now.volume;
        let shear = self.parameters.shear_modulus;
        let inverse = now.volume.recip();
        let bulk = (self.lambda * now.volume.ln() - shear) * inverse;
        let stress = left_cauchy_green(&state.deformation_gradient).scaled(shear * inverse)
            + Symmetric::isotropic(bulk);
        let trace = stress.trace();
        Fault::unless(trace.is_finite(), trace, "the trace of the stress", "finite")?;
        Ok(stress)
    }

    /// Along the longest stretch: `sqrt((mu b + mu + lambda (1 - ln J))/rho_0)`, `b` a bound on the largest eigenvalue of
    /// `B`, sharp where two of them are equal. Zero where that is not positive.
    #[inline(always)]
    fn wave_speed(&self, volume: S, state: &NeoHookeanState<S>) -> S {
        let stretch = left_cauchy_green(&state.deformation_gradient);
        let deviator = stretch.deviator();
        let mean = stretch.trace() * (1.0 / 3.0);
        let square = deviator.square() * (2.0 / 3.0);
        // At equal stretches the root has no derivative.
        let is_stretched = square.splat(1e-24).less(square);
        let largest = when!(is_stretched, mean + square.sqrt(), mean);
        let shear = self.parameters.shear_modulus;
        let modulus = shear * (largest + 1.0) + self.lambda * (volume.ln() * -1.0 + 1.0);
        let zero = modulus.splat(0.0);
        when!(zero.less(modulus), (modulus / self.parameters.density).sqrt(), zero)
    }

    #[inline(always)]
    fn observe(&self, state: &NeoHookeanState<S>) -> Observed<S>
    where
        S: Scalar,
    {
        let stretch = left_cauchy_green(&state.deformation_gradient);
        let logarithm = state.volume.ln();
        let shear = self.parameters.shear_modulus * ((stretch.trace() - 3.0) * 0.5 - logarithm);
        Observed::of_energy(shear + self.lambda * logarithm.squared() * 0.5 + state.heat)
    }

    #[inline(always)]
    fn visit_numbers(&self, state: &mut NeoHookeanState<S>, mut visit: impl FnMut(&mut S)) -> bool {
        let NeoHookeanState { deformation_gradient, volume, heat } = state;
        for i in 0..3 {
            for j in 0..3 {
                visit(&mut deformation_gradient[i][j]);
            }
        }
        visit(volume);
        visit(heat);
        true
    }
}

family_member!(MaterialFamily, Material: NeoHookean { lambda }, number => NeoHookeanState {
    deformation_gradient: [[number; 3]; 3],
    volume: number,
    heat: number,
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tensor::volume_change;

    const RUBBER: NeoHookeanParameters<f64> =
        NeoHookeanParameters { density: 1.1, shear_modulus: 2.0, bulk_modulus: 5.0 };

    /// Steps of one velocity gradient; the work of the stress per reference volume by the trapezoidal rule.
    fn driven(
        l: [[f64; 3]; 3],
        steps: usize,
        dt: f64,
    ) -> (Symmetric<f64>, NeoHookeanState<f64>, f64) {
        let material = NeoHookean::new(RUBBER).unwrap();
        let mut state = material.start([0.0; 3]);
        let (mut stress, mut volume, mut work) = (Symmetric::zero(), 1.0, 0.0);
        for _ in 0..steps {
            let after = volume * volume_change(&l, dt);
            let now = Now {
                velocity_gradient: l,
                dt,
                time: 0.0,
                volume_before: volume,
                volume: after,
                viscosity: 0.0,
                cell: 1.0,
            };
            let next = material.update(&now, &mut state).unwrap();
            let rate = Symmetric::part_of(&l);
            work += 0.5 * dt * (stress.times(volume) + next.times(after)).contract(&rate);
            (stress, volume) = (next, after);
        }
        (stress, state, work)
    }

    #[test]
    fn uniaxial_stretch_and_simple_shear_have_closed_forms() {
        let mut l = [[0.0; 3]; 3];
        l[0][0] = 0.5;
        let (stress, _, _) = driven(l, 1, 1.0);
        let (j, lambda): (f64, f64) = (1.5, 5.0 - 4.0 / 3.0);
        assert!((stress.0[0] - (2.0 / j * (j * j - 1.0) + lambda * j.ln() / j)).abs() < 1e-14);
        assert!((stress.0[1] - lambda * j.ln() / j).abs() < 1e-14);
        let mut l = [[0.0; 3]; 3];
        l[0][1] = 0.3;
        let (stress, _, _) = driven(l, 1, 1.0);
        let expected = [2.0 * 0.09, 0.0, 0.0, 2.0 * 0.3, 0.0, 0.0];
        for k in 0..6 {
            assert!((stress.0[k] - expected[k]).abs() < 1e-15);
        }
    }

    #[test]
    fn the_energy_is_the_work() {
        let l = [[0.3, 0.2, 0.0], [-0.1, 0.1, 0.2], [0.0, 0.3, -0.2]];
        let material = NeoHookean::new(RUBBER).unwrap();
        let error = |steps: usize| {
            let (_, state, work) = driven(l, steps, 1.0 / steps as f64);
            (work - material.observe(&state).energy).abs()
        };
        // dF = dt L F is of first order.
        let (coarse, fine) = (error(200), error(400));
        assert!(fine < 2e-3 && (coarse / fine - 2.0).abs() < 0.1, "{coarse} {fine}");
    }

    #[test]
    fn its_wave_is_that_of_the_tangent() {
        let material = NeoHookean::new(RUBBER).unwrap();
        let mut l = [[0.0; 3]; 3];
        l[0][0] = 0.4;
        let (_, state, _) = driven(l, 1, 1.0);
        // rho c^2 = J^2/J dP/dF along x, P the first Piola-Kirchhoff stress: here sigma itself.
        let piola = |stretch: f64| {
            let mut l = [[0.0; 3]; 3];
            l[0][0] = stretch - 1.0;
            driven(l, 1, 1.0).0.0[0]
        };
        let tangent = (piola(1.4 + 1e-5) - piola(1.4 - 1e-5)) / 2e-5;
        let speed: f64 = (1.4 * 1.4 * tangent / 1.1_f64).sqrt();
        assert!((material.wave_speed(1.4, &state) - speed).abs() < 1e-8);
        let rest = material.wave_speed(1.0, &material.start([0.0; 3]));
        assert!((rest - ((5.0 + 4.0 / 3.0 * 2.0) / 1.1_f64).sqrt()).abs() < 1e-14);
    }
}
