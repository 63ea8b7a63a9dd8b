//! A structure behind a filter: white noise becomes ground motion.

use sde_integrators::{Additive, GaussianMixture, Sde};

use crate::error::{Error, positive};
use crate::{Filter, Window};

/// Most states: those of the density solver.
const MOST_STATES: usize = 6;

/// A system whose white noise is replaced by the output `u` of a filter: from `dX = f dt + g(t) dB` with one Brownian
/// motion and additive noise it makes
///
/// $$ \dot x = f(t, x) + g(t) u, \qquad dY = A Y dt + b w(t) dB, \qquad u = c \cdot y . $$
///
/// `S` with `DS` states is any such system: an oscillator, a damper, a hysteretic one, a building, a user's own. Its
/// intensity `S_0` keeps its meaning where the filter passes low frequencies unchanged. State: that of the structure, then
/// that of the filter, `DS + DF` in all, six at most.
///
/// The shaking rises and falls by one of two windows: that of the structure, in `g(t)`, modulates the ground motion; `w`
/// modulates the white noise below it, so that the filter shakes on for its own period after the noise.
///
/// ```
/// use vibrating_systems::{
///     Filter, Filtered, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters, Window,
/// };
/// use sde_integrators::{GaussianMixture, Sde};
///
/// let structure = LinearOscillator::new(LinearOscillatorParameters {
///     natural_frequency: 3.14,
///     damping_ratio: 0.05,
///     noise_intensity: 0.2,
///     window: Window::CANOR_DENOEL_2013,
/// })?;
/// let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
/// let shaken = Filtered::new(structure, Filter::kanai_tajimi(soil)?, Window::Stationary)?;
/// let law: GaussianMixture<4> = shaken.initial_distribution(&[0.0, 0.0], &[0.01, 0.01])?;
/// let [_, acceleration, ..] = shaken.drift(1.0, &[0.0, 0.0, 0.01, 0.0]);
/// // a(1) sqrt(2 S_0) omega_g^2 x_g
/// assert!((acceleration - 0.5 * 0.4_f64.sqrt() * 15.6 * 15.6 * 0.01).abs() < 1e-14);
/// # Ok::<(), vibrating_systems::Error>(())
/// ```
///
/// A number of states that is not the sum of both does not compile:
///
/// ```compile_fail
/// # use vibrating_systems::{
/// #     Filter, Filtered, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters, Window,
/// # };
/// # let window = Window::Stationary;
/// # let (natural_frequency, damping_ratio, noise_intensity) = (3.14, 0.05, 0.2);
/// # let structure = LinearOscillator::new(LinearOscillatorParameters {
/// #     natural_frequency, damping_ratio, noise_intensity, window,
/// # })?;
/// # let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
/// let shaken = Filtered::new(structure, Filter::kanai_tajimi(soil)?, Window::Stationary)?;
/// let law = shaken.initial_distribution::<5>(&[0.0, 0.0], &[0.01, 0.01])?;
/// # Ok::<(), vibrating_systems::Error>(())
/// ```
///
/// nor do more than six, here the four of a building and the four of Clough and Penzien:
///
/// ```compile_fail
/// # use vibrating_systems::{
/// #     Filter, Filtered, KanaiTajimiParameters, TwoStorey, TwoStoreyParameters, Window,
/// # };
/// # use sde_integrators::Sde;
/// # let frame = TwoStorey::new(TwoStoreyParameters {
/// #     mass: [1.0; 2], stiffness: [10.0; 2], damping: [0.1; 2], damper_coefficient: [0.0; 2],
/// #     damper_exponent: 1.0, noise_intensity: 0.2, window: Window::Stationary,
/// # })?;
/// # let clough_penzien = Filter::<4>::new([[0.0; 4]; 4], [0.0; 4], [0.0; 4], 1.0)?;
/// let shaken = Filtered::new(frame, clough_penzien, Window::Stationary)?;
/// # Ok::<(), vibrating_systems::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered<S, const DS: usize, const DF: usize> {
    structure: S,
    filter: Filter<DF>,
    noise_window: Window,
}

impl<S, const DS: usize, const DF: usize> Filtered<S, DS, DF>
where
    S: Sde<DS, 1, Noise = Additive>,
{
    /// A structure behind a filter whose white noise has the window `w`.
    ///
    /// # Errors
    /// Those of [`Window::check`].
    pub fn new(structure: S, filter: Filter<DF>, noise_window: Window) -> Result<Self, Error> {
        const { assert!(DS + DF <= MOST_STATES, "structure and filter have more than six states") };
        noise_window.check()?;
        Ok(Self { structure, filter, noise_window })
    }

    /// The structure.
    pub fn structure(&self) -> &S {
        &self.structure
    }

    /// The filter.
    pub fn filter(&self) -> &Filter<DF> {
        &self.filter
    }

    /// The modulating function `w` of the white noise below the filter.
    pub fn noise_window(&self) -> &Window {
        &self.noise_window
    }

    /// The filter in its stationary law, the structure in independent normals with the given means and standard
    /// deviations.
    ///
    /// # Errors
    /// [`Error::NotPositive`] for a standard deviation; [`Error::Sde`] as
    /// [`GaussianMixture::gaussian`].
    pub fn initial_distribution<const D: usize>(
        &self,
        mean: &[f64; DS],
        standard_deviation: &[f64; DS],
    ) -> Result<GaussianMixture<D>, Error> {
        const { assert!(D == DS + DF, "the law needs the states of structure and filter") };
        let (mut means, mut covariance) = ([0.0; D], [[0.0; D]; D]);
        for (k, &deviation) in standard_deviation.iter().enumerate() {
            positive("standard deviation", deviation)?;
            means[k] = mean[k];
            covariance[k][k] = deviation * deviation;
        }
        for (i, row) in self.filter.stationary_covariance().iter().enumerate() {
            covariance[DS + i][DS..].copy_from_slice(row);
        }
        Ok(GaussianMixture::gaussian(means, covariance)?)
    }
}

impl<S, const DS: usize, const DF: usize, const D: usize> Sde<D, 1> for Filtered<S, DS, DF>
where
    S: Sde<DS, 1, Noise = Additive>,
{
    type Noise = Additive;

    #[inline]
    fn drift(&self, t: f64, x: &[f64; D]) -> [f64; D] {
        const { assert!(D == DS + DF, "the state is that of structure and filter") };
        let structure: [f64; DS] = std::array::from_fn(|k| x[k]);
        let filter: [f64; DF] = std::array::from_fn(|k| x[DS + k]);
        let dot = |row: &[f64; DF]| -> f64 { (0..DF).map(|k| row[k] * filter[k]).sum() };
        let ground = dot(&self.filter.output);
        let (f, g) = (self.structure.drift(t, &structure), self.structure.noise(t, &structure));
        std::array::from_fn(|k| {
            if k < DS { f[k] + g[k][0] * ground } else { dot(&self.filter.matrix[k - DS]) }
        })
    }

    #[inline]
    fn noise(&self, t: f64, _: &[f64; D]) -> [[f64; 1]; D] {
        let amplitude = self.noise_window.amplitude(t);
        std::array::from_fn(|k| [if k < DS { 0.0 } else { amplitude * self.filter.noise[k - DS] }])
    }

    /// Those of structure and filter; none where the structure has none. The ground acts through the window of the structure,
    /// which is no constant: that stays in the rest.
    fn linear_part(&self) -> Option<[[f64; D]; D]> {
        let structure = self.structure.linear_part()?;
        let mut part = [[0.0; D]; D];
        for (k, row) in structure.iter().enumerate() {
            part[k][..DS].copy_from_slice(row);
        }
        for (k, row) in self.filter.matrix.iter().enumerate() {
            part[DS + k][DS..].copy_from_slice(row);
        }
        Some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear_law::Transition;
    use crate::matrix::Matrix;
    use crate::{KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters};

    const STRUCTURE: LinearOscillatorParameters = LinearOscillatorParameters {
        natural_frequency: 2.0,
        damping_ratio: 0.1,
        noise_intensity: 0.3,
        window: Window::Stationary,
    };

    fn behind(
        ground_frequency: f64,
        window: Window,
        noise_window: Window,
    ) -> Filtered<LinearOscillator, 2, 2> {
        let soil = KanaiTajimiParameters { ground_frequency, ground_damping: 0.6 };
        let structure =
            LinearOscillator::new(LinearOscillatorParameters { window, ..STRUCTURE }).unwrap();
        Filtered::new(structure, Filter::kanai_tajimi(soil).unwrap(), noise_window).unwrap()
    }

    /// The variance of `q` that stays.
    fn variance(system: &Filtered<LinearOscillator, 2, 2>) -> f64 {
        let columns: [[f64; 4]; 4] = std::array::from_fn(|j| {
            system.drift(0.0, &std::array::from_fn(|i| f64::from(u8::from(i == j))))
        });
        let f: Matrix<4> = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        let noise = system.diffusion(0.0, &[0.0; 4]).map(|row| row.map(|d| 2.0 * d));
        Transition::stationary("shaken structure", &f, &noise).unwrap()[0][0]
    }

    #[test]
    fn behind_hard_soil_the_structure_sees_the_white_noise_and_behind_soft_soil_its_resonance() {
        // White noise: S_0/(2 xi w^3) = 0.1875. The filter passes the frequency r = w/w_g with the gain
        // (1 + (2 zeta r)^2)/((1 - r^2)^2 + (2 zeta r)^2) = 1 + 2 r^2 + ..: 2e-4 at w_g = 200.
        let white = 0.3 / (2.0 * 0.1 * 8.0);
        let hard = variance(&behind(200.0, Window::Stationary, Window::Stationary));
        // What the broad part of the spectrum adds beside the resonance is of order xi w/w_g = 1e-3.
        assert!((hard / white - 1.0).abs() < 3e-3, "{hard}");
        // At w_g = w the gain is (1 + 1.44)/1.44 = 1.69; the peak of the soil is wide beside that of the structure.
        let soft = variance(&behind(2.0, Window::Stationary, Window::Stationary));
        assert!((soft / white - 1.69).abs() < 0.1, "{soft}");
    }

    #[test]
    fn the_window_modulates_the_ground_motion_or_the_white_noise_below_it() {
        let window = Window::CANOR_DENOEL_2013;
        let x = [0.0, 0.0, 0.01, 0.0];
        let ground = behind(15.6, window.clone(), Window::Stationary);
        let noise = behind(15.6, Window::Stationary, window);
        // a(1) = 1/2.
        let (damped, whole) = (ground.drift(1.0, &x)[1], noise.drift(1.0, &x)[1]);
        assert!((damped - 0.5 * whole).abs() < 1e-15 && whole > 0.0);
        let (steady, rising) = (ground.noise(1.0, &x)[3][0], noise.noise(1.0, &x)[3][0]);
        assert!((steady - 1.0).abs() < 1e-15 && (rising - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_filter_starts_in_its_stationary_law() {
        let system = behind(15.6, Window::Stationary, Window::Stationary);
        let law: GaussianMixture<4> =
            system.initial_distribution(&[0.1, 0.0], &[0.02, 0.03]).unwrap();
        let covariance = law.covariance();
        let p = system.filter().stationary_covariance();
        assert!(
            (covariance[2][2] - p[0][0]).abs() < 1e-18
                && (covariance[3][3] - p[1][1]).abs() < 1e-18
        );
        assert!((covariance[0][0] - 4e-4).abs() < 1e-18 && (law.mean()[0] - 0.1).abs() < 1e-18);
        let refused: Result<GaussianMixture<4>, _> =
            system.initial_distribution(&[0.0; 2], &[0.02, 0.0]);
        assert!(matches!(refused, Err(Error::NotPositive { .. })));
    }
}
