//! Strengths of bonds of a linear peridynamic solid from the energy of a crack.

use super::moduli::Moduli;
use crate::error::{Error, positive};
use crate::material::elasticity::{Condition, Influence, across_plane, sphere};
use crate::material::horizon::Horizon;

/// Intervals of the midpoint rule along each of three variables: its error is below 1e-3 of the part that it gives.
const INTERVALS: u32 = 96;

/// The stretch `s_0` at which bonds of a linear peridynamic solid break, so that two halves of a body that separate along a
/// plane, each rigid, take the energy `G0` for each unit of area:
///
/// $$ G_0 = s_0^2 \left( \frac{2 \kappa B}{m} \int_0^\delta \omega \xi^{D + 2} d\xi + A \delta J \right), \qquad
/// A \delta J s_0^2 = 2 \int_0^\infty \int_0^\delta \frac{A \theta(h, u)^2}{u} dh du , $$
///
/// with `A`, `B`, `m` and `omega` of [`SolidBonds`](crate::SolidBonds) and the dilatation `theta` of a point at the depth `h` by those
/// of its bonds across the opening `u` that are not yet stretched by `s_0`. The first part is exact, the second a sum of
/// midpoints. Where `A = 0` it is [`critical_stretch`](crate::critical_stretch). For the influence of LAMMPS in three
/// dimensions the first part is `3 G delta`, as in Madenci & Oterkus 2014, who estimate the second by
/// `(3/4)^4 (K - 5 G/3) delta`.
///
/// A stretch knows nothing of the dilatation, and a crack that opens otherwise takes another energy where `A` is large.
///
/// `energy_release_rate` `G0` (energy over area), `young_modulus` (stress), `horizon` (length).
///
/// # Errors
/// [`Error::Parameter`] for a Poisson's ratio outside of -1 to 0.5.
pub fn critical_stretch_of_solid(
    energy_release_rate: f64,
    (young_modulus, poisson_ratio): (f64, f64),
    horizon: Horizon,
    influence: Influence,
    condition: Condition,
) -> Result<f64, Error> {
    positive("energy release rate", energy_release_rate)?;
    condition.check()?;
    let Moduli { a, b } = Moduli::new(young_modulus, poisson_ratio, condition)?;
    let (surface, power) = sphere(condition);
    // Both in units of the horizon; m = S M delta^(D + 2) times what is across.
    let mass = surface * influence.moment(power);
    let elongation = 2.0 * across_plane(condition) / condition.across();
    let direct = elongation * b / mass * influence.moment(power + 1);
    let dilatational = a * dilatational(influence, power, f64::from(power) / mass);
    Ok((energy_release_rate / (horizon.radius() * (direct + dilatational))).sqrt())
}

/// `J = 2 int tau int (D I(eta, tau)/(S M))^2 d eta d tau`, over the depth `eta = h/delta` and the opening `tau = u/(s_0 delta)`.
fn dilatational(influence: Influence, dimension: u32, factor: f64) -> f64 {
    let mut sum = 0.0;
    for t in midpoints() {
        // Openings up to 1, then from there on with tau = 1/t, d tau = d t/t^2.
        for (tau, part) in [(t, t), (1.0 / t, t.powi(-3))] {
            let deepest = (1.0 / tau).min(1.0);
            for depth in midpoints() {
                let theta = factor * across(influence, dimension, depth * deepest, tau);
                sum += part * deepest * theta * theta;
            }
        }
    }
    2.0 * sum / f64::from(INTERVALS).powi(2)
}

/// `I = int omega xi_n dV` over the bonds from a depth across the opening that are not yet broken: those of a length `q` whose
/// direction has a cosine `c` with the normal of `depth/q < c < min(1, q/tau)`.
fn across(influence: Influence, dimension: u32, depth: f64, tau: f64) -> f64 {
    let least = if dimension == 1 { depth.max(tau) } else { depth.max((depth * tau).sqrt()) };
    if least >= 1.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for t in midpoints() {
        let q = least + (1.0 - least) * t;
        let (low, high) = (depth / q, (q / tau).min(1.0));
        let of_directions = match dimension {
            1 => 1.0,
            2 => 2.0 * q * ((1.0 - low * low).sqrt() - (1.0 - high * high).sqrt()),
            _ => std::f64::consts::PI * q * q * (high * high - low * low),
        };
        sum += influence.weight(q) * of_directions;
    }
    sum * (1.0 - least) / f64::from(INTERVALS)
}

/// Number of equal intervals from 0 to 1.
fn midpoints() -> impl Iterator<Item = f64> {
    (0..INTERVALS).map(|interval| (f64::from(interval) + 0.5) / f64::from(INTERVALS))
}
