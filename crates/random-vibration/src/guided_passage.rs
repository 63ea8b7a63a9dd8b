//! First passage up to a time, from paths guided to the threshold at many times.

use sde_integrators::{Error, Guide, GuidedPath, Response, Side};

use crate::backward::Backward;
use crate::guided::{Event, GuidedConfig, GuidedPaths, STRENGTHS};
use crate::normal_tail::upper_tail;
use crate::tail::TailError;
use crate::weights::GuidedEstimate;

/// Largest number of times at which guides end.
const MOST_ENDS: usize = 256;
/// Smallest probability of a guide's event over the largest: rarer ones have no guide.
const LEAST: f64 = 1e-3;
/// Share of the guided paths that all guides receive alike.
const EVEN: f64 = 0.03;

impl<const D: usize, const M: usize> GuidedPaths<'_, D, M> {
    /// The probability that a response passes a threshold up to the end of the paths.
    ///
    /// The passage is that of the largest response, `max y(t) > T`. A path is guided to exceed the threshold at one of
    /// many times; where it passes the threshold before, its guide ends. With the ends `e` and their shares `c_e`,
    ///
    /// $$ \hat p = \frac1n \sum_k \frac{1[\tau_k \le t]}{c_0 + \sum_e c_e r_e(\tau_k)}, \qquad
    ///    c_e \propto \Phi\left(\frac{E y(t_e) - T}{\sigma_e}\right), $$
    ///
    /// `r_e` being the likelihood ratio of guide `e` at the passage `tau`. Two ends are half a mean excursion apart, which
    /// takes `sqrt(2 pi) sigma_y^2/(sigma_y' T)` in the linearised system; there are at most 256. Ends with a probability
    /// below a thousandth of the largest have no guide. For a magnitude both signs have guides.
    ///
    /// The estimate is unbiased for the discrete paths with the given rule between steps, whose bias remains:
    /// with [`Between::Endpoints`](sde_integrators::Between::Endpoints) passages between steps are missed.
    ///
    /// Sources: Au and Beck 2001, First excursion probabilities for linear systems by very efficient importance
    /// sampling (a mixture over the times of the passage); for controls towards a running maximum arXiv 2403.12793.
    ///
    /// # Errors
    /// Those of [`exceedance`](Self::exceedance) and of [`maxima`](sde_integrators::maxima) for the response.
    pub fn first_passage(
        &self,
        response: &Response<'_, D>,
        threshold: f64,
        config: &GuidedConfig,
    ) -> Result<GuidedEstimate, TailError> {
        config.check(threshold)?;
        let component = response.component;
        if component >= D {
            return Err(Error::NoSuchComponent { component, limit: D }.into());
        }
        let sides: &[f64] = if response.side == Side::Above { &[1.0] } else { &[1.0, -1.0] };
        let ends = self.ends(component, threshold);
        let guides = |strength: usize, share: f64| {
            self.to_passages(strength, (component, sides), (&ends, threshold), share)
        };
        let is_hit = |path: &GuidedPath<'_, D>| path.largest > threshold;
        let event = Event { is_hit: &is_hit, response: Some(response), sides: 1.0, threshold };
        let strength = self.strongest(&guides, &event, config)?;
        self.estimate(&guides(strength, 1.0 - config.unguided), &event, STRENGTHS[strength], config)
    }

    /// Guides to the threshold at all ends and on all sides, with their shares.
    fn to_passages(
        &self,
        strength: usize,
        (component, sides): (usize, &[f64]),
        (ends, threshold): (&[usize], f64),
        share: f64,
    ) -> Vec<Guide<D, M>> {
        let weights = std::array::from_fn(|i| if i == component { 1.0 } else { 0.0 });
        let mut all: Vec<(Backward<D, M>, f64, f64)> = Vec::new();
        for &n_steps in ends {
            let backward = self.backward(strength, &weights, n_steps);
            for &side in sides {
                let excess = backward.reliability(&self.start, side, threshold);
                all.push((backward.clone(), side, upper_tail(-excess)));
            }
        }
        let largest = all.iter().fold(0.0_f64, |largest, (.., p)| largest.max(*p));
        all.retain(|(.., p)| *p >= LEAST * largest);
        let (sum, even) = (all.iter().map(|(.., p)| p).sum::<f64>(), 1.0 / all.len() as f64);
        let guide = |(backward, side, p): &(Backward<D, M>, f64, f64)| {
            let likely = if sum > 0.0 { p / sum } else { even };
            let part = EVEN * even + (1.0 - EVEN) * likely;
            backward.guide(&self.start, *side, threshold, share * part)
        };
        all.iter().map(guide).collect()
    }

    /// The steps after which guides end, from the last one backwards.
    fn ends(&self, component: usize, threshold: f64) -> Vec<usize> {
        let (dt, n_steps) = (self.steps.dt, self.steps.n_steps);
        let shortest = n_steps.div_ceil(MOST_ENDS);
        let mut ends = Vec::new();
        let mut end = n_steps;
        while end > 0 {
            ends.push(end);
            let t = end as f64 * dt;
            let law = self.regressions.law_at(t);
            // The rate of the response in the linearised system, under the running distribution.
            let rate = self.regressions.at(0, t).slope[component];
            let mut of_rate = 0.0;
            for i in 0..D {
                for j in 0..D {
                    of_rate += rate[i] * law.covariance[i][j] * rate[j];
                }
            }
            let variance = law.covariance[component][component];
            let distance = (threshold.abs() - law.mean[component].abs()).max(variance.sqrt());
            let excursion = std::f64::consts::TAU.sqrt() * variance / (of_rate.sqrt() * distance);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a number of steps, and a cast saturates"
            )]
            let spacing = (0.5 * excursion / dt).round() as usize;
            end = end.saturating_sub(spacing.max(shortest));
        }
        ends
    }
}
