//! Bonds that reach their strength between the ends of a step.

use sde_integrators::{Noise, Purpose, Stream};

use crate::breaking::broken_bond::Cause;

/// Beyond this exponent a crossing has a probability below 1e-13: it is not drawn for.
const UNLIKELY: f64 = 30.0;

/// The test of a Brownian bridge, bond by bond. With the stretches `a` and `b` below the strength `s_0` at both ends of a step
/// of the length `h`, a bond has crossed in between with the probability
///
/// $$ p = \exp\left( -\frac{2 (s_0 - a) (s_0 - b)}{\sigma^2 h} \right), \qquad \sigma^2 = 2 kT \frac{n^T (M_{ii} + M_{jj} - 2 M_{ij}) n}{|\xi|^2} $$
///
/// (Karatzas and Shreve 1991, eq 4.3.40), with `sigma^2` the rate at which noise spreads its stretch. It needs a scheme whose
/// steps are those of the path: see [`Scheme`](crate::Scheme). The draw is a function of seed, realisation, step and bond.
#[derive(Debug, Clone)]
pub struct Crossing<const L: usize> {
    /// `sigma^2` per bond (1/time).
    rates: Vec<f64>,
    streams: [Stream; L],
    step: u64,
    dt: f64,
}

impl<const L: usize> Crossing<L> {
    pub(crate) fn new(noise: Noise, realisations: [u64; L], rates: Vec<f64>) -> Self {
        let streams = realisations.map(|realisation| noise.stream(Purpose::Bridge, realisation));
        Self { rates, streams, step: 0, dt: 0.0 }
    }

    pub(crate) fn begin(&mut self, step: u64, dt: f64) {
        (self.step, self.dt) = (step, dt);
    }

    /// A bond whose `(s_0 - a)(s_0 - b)` is not below this need not be tested, with room for rounding. Steps have one length.
    pub(crate) fn least_product(&self, bond: usize) -> f64 {
        0.51 * UNLIKELY * self.rates[bond] * self.dt
    }

    /// Whether a bond that was intact breaks over the step in a lane, and how.
    pub(crate) fn test(&mut self, bond: usize, lane: usize, over: BondOverStep) -> Option<Cause> {
        let [before, after] = over.stretch.map(|stretch| over.strength - stretch);
        if after <= 0.0 {
            return Some(Cause::Stretch);
        }
        let (exponent, variance) = (2.0 * before * after, self.rates[bond] * self.dt);
        if exponent >= UNLIKELY * variance {
            return None;
        }
        let address = u128::from(self.step) * self.rates.len() as u128 + bond as u128;
        self.streams[lane].seek(2 * address);
        let hit = self.streams[lane].next_uniform() < (-exponent / variance).exp();
        hit.then_some(Cause::Crossing)
    }
}

/// A bond over a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BondOverStep {
    /// Its stretch before and after.
    pub(crate) stretch: [f64; 2],
    pub(crate) strength: f64,
}
