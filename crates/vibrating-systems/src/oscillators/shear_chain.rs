//! Frequencies and Rayleigh damping of a chain of masses and springs.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::error::{Error, positive};

/// Largest number of iterations for each eigenvalue; two are usual.
const MOST_ITERATIONS: usize = 100;

/// Circular frequencies of a chain of `(mass, stiffness)` from the ground upwards, increasing.
///
/// They are the roots of the eigenvalues of the symmetric `M^(-1/2) K M^(-1/2)`; infinite where these exceed all numbers.
pub(crate) fn natural_frequencies(chain: &[(f64, f64)]) -> Vec<f64> {
    let n = chain.len();
    let above = |i: usize| chain.get(i + 1).map_or(0.0, |(_, stiffness)| *stiffness);
    let diagonal = |i: usize| (chain[i].1 + above(i)) / chain[i].0;
    // Entries of at most 1, whose squares do not overflow.
    let largest = (0..n).map(diagonal).fold(0.0, f64::max);
    let entry = |i: usize, j: usize| match j.abs_diff(i) {
        0 => diagonal(i) / largest,
        1 => -above(i.min(j)) / (chain[i].0.sqrt() * chain[j].0.sqrt()) / largest,
        _ => 0.0,
    };
    let matrix = DMatrix::from_fn(n, n, entry);
    let eigen = if matrix.iter().all(|entry| entry.is_finite()) {
        SymmetricEigen::try_new(matrix, f64::EPSILON, MOST_ITERATIONS * n)
    } else {
        None
    };
    let Some(eigen) = eigen else { return vec![f64::INFINITY; n] };
    // Positive definite: only roundoff is below zero.
    let frequency = |square: &f64| (square.max(0.0) * largest).sqrt();
    let mut frequencies: Vec<f64> = eigen.eigenvalues.iter().map(frequency).collect();
    frequencies.sort_unstable_by(f64::total_cmp);
    frequencies
}

/// Rayleigh damping: `C = of_mass M + of_stiffness K`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rayleigh {
    pub(crate) of_mass: f64,
    pub(crate) of_stiffness: f64,
}

/// Rayleigh damping with these ratios in two modes, counted from 1.
pub(crate) fn rayleigh(
    frequencies: &[f64],
    modes: [usize; 2],
    ratios: [f64; 2],
) -> Result<Rayleigh, Error> {
    for (mode, ratio) in modes.into_iter().zip(ratios) {
        positive("ratios", ratio)?;
        if !(1..=frequencies.len()).contains(&mode) {
            let (value, to) = (mode as f64, frequencies.len() as f64);
            return Err(Error::OutOfRange { name: "modes", value, from: 1.0, to });
        }
    }
    if modes[1] <= modes[0] {
        let (name, other) = ("modes", "the mode before it");
        return Err(Error::OutOfOrder {
            name,
            value: modes[1] as f64,
            other,
            limit: modes[0] as f64,
        });
    }
    let [low, high] = modes.map(|mode| frequencies[mode - 1]);
    let span = high * high - low * low;
    let of_mass = 2.0 * low * high * (ratios[0] * high - ratios[1] * low) / span;
    let of_stiffness = 2.0 * (ratios[1] * high - ratios[0] * low) / span;
    for value in [of_mass, of_stiffness] {
        if value.is_nan() || value < 0.0 {
            return Err(Error::Negative { name: "Rayleigh damping of these ratios", value });
        }
    }
    Ok(Rayleigh { of_mass, of_stiffness })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_of_equal_storeys_are_the_closed_form() {
        for n in [1, 2, 6, 10] {
            let found = natural_frequencies(&vec![(2.0, 50.0); n]);
            for (k, found) in found.iter().enumerate() {
                let angle = (2 * k + 1) as f64 * std::f64::consts::PI / (2.0 * (2 * n + 1) as f64);
                let exact = 10.0 * angle.sin();
                assert!((found / exact - 1.0).abs() < 1e-12, "{n}, {k}: {found} {exact}");
            }
        }
    }

    #[test]
    fn frequencies_of_any_masses_and_springs_end() {
        for chain in [
            vec![(1e-300, 1e300), (1.0, 1.0)],
            vec![(f64::MAX, f64::MIN_POSITIVE); 3],
            vec![(1.0, 1e200), (1e-200, 1.0), (1e100, 1e-100)],
        ] {
            let found = natural_frequencies(&chain);
            assert!(found.len() == chain.len() && found.iter().all(|w| *w >= 0.0), "{found:?}");
            assert!(found.is_sorted(), "{found:?}");
        }
        assert_eq!(natural_frequencies(&[(1e-300, 1e300)]), [f64::INFINITY]);
        assert_eq!(natural_frequencies(&[(4.0, 1.0)]), [0.5]);
    }

    #[test]
    fn rayleigh_damping_has_the_ratios_in_its_two_modes() {
        let frequencies = [3.0, 8.0, 13.0];
        let Rayleigh { of_mass, of_stiffness } =
            rayleigh(&frequencies, [1, 3], [0.05, 0.04]).unwrap();
        for (omega, ratio) in [(3.0, 0.05), (13.0, 0.04)] {
            assert!((0.5 * (of_mass / omega + of_stiffness * omega) - ratio).abs() < 1e-15);
        }
        let message =
            |modes, ratios| rayleigh(&frequencies, modes, ratios).unwrap_err().to_string();
        assert_eq!(message([1, 4], [0.05; 2]), "modes is 4; it must be from 1 to 3");
        assert_eq!(
            message([2, 2], [0.05; 2]),
            "modes is 2; it must be greater than the mode before it, which is 2"
        );
        assert!(message([1, 2], [0.05, 0.001]).contains("it must be 0 or greater"));
    }
}
