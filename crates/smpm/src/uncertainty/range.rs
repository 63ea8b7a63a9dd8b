//! The chance that a random parameter leaves the range of its model.

use super::experiment::Experiment;
use super::inputs::Inputs;
use crate::error::Error;

/// The largest chance, of one parameter by itself, that a sample cannot be run.
pub const MOST_CHANCE_OUT_OF_RANGE: f64 = 1e-6;

/// Where the normal distribution function is half of [`MOST_CHANCE_OUT_OF_RANGE`], in deviations.
const FARTHEST: f64 = 4.891_638_475_698_59;

/// Halvings of the interval: the edge to 1e-9 deviations.
const N_HALVINGS: usize = 32;

/// `1 - Phi(u)`.
pub(super) fn upper_tail(u: f64) -> f64 {
    0.5 * libm::erfc(u * std::f64::consts::FRAC_1_SQRT_2)
}

/// Refuses distributions under which a parameter is refused by the model too often. The model itself is asked: each parameter is
/// moved out to 4.9 deviations on either side, the others at the centre.
pub(super) fn check<const D: usize>(
    experiment: &impl Experiment<D>,
    inputs: &dyn Inputs,
) -> Result<(), Error> {
    for parameter in 0..inputs.n_normals() {
        let refused = |u: f64| experiment.simulation(&inputs.with_quantile(parameter, u)?).err();
        let (mut chance, mut reason) = (0.0, String::new());
        for side in [-1.0, 1.0] {
            let Some(error) = refused(side * FARTHEST) else { continue };
            let (mut inside, mut outside) = (0.0, FARTHEST);
            for _ in 0..N_HALVINGS {
                let middle = 0.5 * (inside + outside);
                if refused(side * middle).is_some() {
                    outside = middle;
                } else {
                    inside = middle;
                }
            }
            chance += upper_tail(outside);
            reason = error.to_string();
        }
        if chance > MOST_CHANCE_OUT_OF_RANGE {
            let limit = MOST_CHANCE_OUT_OF_RANGE;
            return Err(Error::LikelyOutOfRange { parameter, chance, limit, reason });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_is_that_of_the_normal_law() {
        assert!((upper_tail(FARTHEST) / (0.5 * MOST_CHANCE_OUT_OF_RANGE) - 1.0).abs() < 1e-6);
        assert!((upper_tail(0.0) - 0.5).abs() < 1e-16);
    }
}
