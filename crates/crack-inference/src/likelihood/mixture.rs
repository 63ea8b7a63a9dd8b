//! A likelihood that does not take the noise of its ensembles for information.

use random_fields::{Enough, LowRank, pivoted_cholesky};
use sde_integrators::{Noise, Purpose};
use simd_lanes::{exp, ln};

use crate::error::{Error, at_least};
use crate::likelihood::emulator::Emulator;
use crate::likelihood::gaussian::Observations;
use crate::likelihood::regressions::Regressions;

/// Part of the variances that is left out of a draw.
const LEFT_OUT: f64 = 1e-10;

/// The likelihood of an [`Emulator`], averaged over what finite ensembles leave open:
///
/// $$ \bar L(x) = \frac1B \sum_{b=1}^B L_b(x) $$
///
/// where `L_b` is the likelihood with the numbers of every ensemble moved by a draw from the normal law of their errors. A posterior
/// by it is wider by these errors. One by the emulator alone takes them for truth: where its log-likelihoods have standard errors of
/// one and more, that is information which is not there. It costs `B` times as much.
///
/// Source: O'Hagan 2006, Bayesian analysis of computer code outputs: a tutorial (the uncertainty of an emulator is
/// averaged over).
#[derive(Debug, Clone, PartialEq)]
pub struct EmulatorMixture {
    emulators: Vec<Emulator>,
}

impl EmulatorMixture {
    /// With so many draws, at least 8, from [`Purpose::Bootstrap`] of a noise. The error of the average falls with the root of
    /// their number: some 30 where log-likelihoods have standard errors near one.
    ///
    /// # Errors
    /// [`Error::TooFew`]; [`Error::Covariance`] for covariances that are none but for roundoff, which the emulator's are
    /// not.
    pub fn new(emulator: &Emulator, n_draws: usize, noise: &Noise) -> Result<Self, Error> {
        at_least("draws of a mixture", n_draws, 8)?;
        let factors = emulator.ensembles().iter().map(errors).collect::<Result<Vec<_>, _>>()?;
        let redrawn = |number: u64| {
            let mut stream = noise.stream(Purpose::Bootstrap, number);
            let moved = |(ensemble, factor): (&Regressions, &LowRank)| {
                let width = ensemble.numbers.len();
                let mut numbers = vec![0.0; width];
                let mut normals = vec![0.0; factor.columns.len() / width];
                stream.fill_normal(&mut normals);
                for (column, z) in factor.columns.chunks_exact(width).zip(&normals) {
                    for (number, entry) in numbers.iter_mut().zip(column) {
                        *number += z * entry;
                    }
                }
                for (i, number) in numbers.iter_mut().enumerate() {
                    *number *= ensemble.covariance[i * (width + 1)].sqrt();
                    *number += ensemble.numbers[i];
                }
                numbers
            };
            let numbers: Vec<_> = emulator.ensembles().iter().zip(&factors).map(moved).collect();
            emulator.with_numbers(&numbers)
        };
        Ok(Self { emulators: (0..n_draws as u64).map(redrawn).collect() })
    }

    /// The emulators that are averaged over.
    #[must_use]
    pub fn emulators(&self) -> &[Emulator] {
        &self.emulators
    }

    /// The logarithm of the averaged likelihood of all plates at a point.
    ///
    /// # Errors
    /// As [`Emulator::value`].
    pub fn value(&self, point: &[f64], data: &Observations) -> Result<f64, Error> {
        let of = |emulator: &Emulator| emulator.value(point, data);
        let values = self.emulators.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = values.iter().map(|value| exp(value - largest)).sum();
        Ok(largest + ln(sum / values.len() as f64))
    }
}

/// A factor of the correlations of the errors, which may be of a rank below their number.
fn errors(ensemble: &Regressions) -> Result<LowRank, Error> {
    let width = ensemble.numbers.len();
    let covariance = |i: usize, j: usize| ensemble.covariance[i * width + j];
    let correlation = |i: usize, j: usize| {
        let scale = (covariance(i, i) * covariance(j, j)).sqrt();
        if scale > 0.0 { covariance(i, j) / scale } else { 0.0 }
    };
    Ok(pivoted_cholesky(width, correlation, Enough::Trace(LEFT_OUT))?)
}
