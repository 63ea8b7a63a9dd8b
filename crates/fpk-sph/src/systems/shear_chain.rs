//! Frequencies and Rayleigh damping of a chain of masses and springs.

use crate::error::{Error, positive};

/// Circular frequencies of a chain of `(mass, stiffness)` from the ground upwards, increasing.
///
/// The eigenvalues of the symmetric tridiagonal `M^(-1/2) K M^(-1/2)` by bisection, counted by the negative pivots of its
/// factorisation (Barth, Martin and Wilkinson 1967, Calculation of the eigenvalues of a symmetric tridiagonal matrix by the
/// method of bisection).
pub(super) fn natural_frequencies(chain: &[(f64, f64)]) -> Vec<f64> {
    let n = chain.len();
    let above = |i: usize| chain.get(i + 1).map_or(0.0, |(_, stiffness)| *stiffness);
    let diagonal: Vec<f64> = (0..n).map(|i| (chain[i].1 + above(i)) / chain[i].0).collect();
    let squares: Vec<f64> =
        (0..n - 1).map(|i| above(i) * above(i) / (chain[i].0 * chain[i + 1].0)).collect();
    let count_below = |value: f64| {
        let (mut count, mut pivot) = (0, 1.0);
        for i in 0..n {
            let known = if i == 0 { 0.0 } else { squares[i - 1] / pivot };
            pivot = diagonal[i] - value - known;
            if pivot == 0.0 {
                pivot = f64::MIN_POSITIVE;
            }
            count += usize::from(pivot < 0.0);
        }
        count
    };
    // Gershgorin: no eigenvalue exceeds twice the largest diagonal entry of a chain.
    let largest = 2.0 * diagonal.iter().copied().fold(0.0, f64::max);
    let frequency = |k: usize| {
        let (mut low, mut high) = (0.0, largest);
        for _ in 0..120 {
            let middle = 0.5 * (low + high);
            if count_below(middle) > k {
                high = middle;
            } else {
                low = middle;
            }
        }
        (0.5 * (low + high)).sqrt()
    };
    (0..n).map(frequency).collect()
}

/// Rayleigh damping: `C = of_mass M + of_stiffness K`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rayleigh {
    pub(super) of_mass: f64,
    pub(super) of_stiffness: f64,
}

/// Rayleigh damping with these ratios in two modes, counted from 1.
pub(super) fn rayleigh(
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
