//! Maximum response of a path up to a time, including between steps: first-passage probability.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use std::fmt;

use simd_lanes::SimdLevel;

use crate::blocks::reduce_blocks;
use crate::ensembles::follow::{Follow, Lives, Watch};
use crate::ensembles::samples::Samples;
use crate::ensembles::schedule::{EnsembleConfig, schedule};
use crate::error::Error;
use crate::integrator::Integrator;
use crate::law::InitialDistribution;
use crate::noise::lane_increments::LANES;
use crate::noise::streams::{Noise, Purpose, Stream};

/// Response whose maximum is computed.
#[derive(Debug, Clone, Copy)]
pub struct Response<'a> {
    /// Component of the state.
    pub component: usize,
    /// Side on which values are large.
    pub side: Side,
    /// Model of the response between the ends of a step.
    pub between: Between<'a>,
}

/// Side on which values of a response are large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Values above a level.
    Above,
    /// Magnitudes above a level.
    Magnitude,
}

/// Model of a response between the ends of a step. Its bias is the error of the maximum's distribution.
#[derive(Clone, Copy)]
pub enum Between<'a> {
    /// Ends only. The maximum is always too small, by `0.58 s sqrt(h)` for a component with its own diffusion.
    Endpoints,
    /// A Brownian bridge, for a component with its own diffusion `s dB`. Its maximum is drawn from its distribution,
    ///
    /// $$ M = \frac12 \left( x_0 + x_1 + \sqrt{(x_1 - x_0)^2 - 2 s^2 h \ln U} \right), $$
    ///
    /// so that `P(M > b) = exp(-2 (b - x_0)(b - x_1)/(s^2 h))` (Karatzas and Shreve 1991, eq 4.3.40; Glasserman 2003,
    /// section 6.4). It is exact for constant drift and `s`. With [`Side::Magnitude`] maximum and minimum are drawn
    /// separately: each has its distribution, and both in one step count as independent. **Wrong for the position of
    /// an oscillator**, which has no diffusion of its own.
    BrownianBridge {
        /// `s` by time and state at the start of the step: the norm of the row of `g` that belongs to the component.
        intensity: &'a (dyn Fn(f64, &[f64]) -> f64 + Sync),
    },
    /// The cubic through position and velocity at both ends, for the position of a second-order system.
    CubicHermite {
        /// Index of the velocity component.
        velocity: usize,
    },
    /// The arc `q'' = -omega^2 q` through the positions at both ends, for an oscillator and `0 < omega h < pi`.
    ///
    /// For a linear oscillator this is the path that [`StrangOscillator`](crate::StrangOscillator) takes between its
    /// kicks.
    RotationArc {
        /// `omega` (rad per unit of time).
        natural_frequency: f64,
    },
}

impl fmt::Debug for Between<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Endpoints => f.write_str("Endpoints"),
            Self::BrownianBridge { .. } => f.write_str("BrownianBridge(..)"),
            Self::CubicHermite { velocity } => write!(f, "CubicHermite(velocity {velocity})"),
            Self::RotationArc { natural_frequency } => {
                write!(f, "RotationArc({natural_frequency})")
            }
        }
    }
}

/// The maximum response of every path from the start to each output time, one sample per time.
///
/// `P(first passage of b before t) = P(maximum over [0, t] > b)`: [`Samples::exceedance`] computes it for every `b`,
/// [`Samples::quantile`] the quantiles of the maximum.
///
/// # Errors
/// Those of [`simulate`](crate::simulate); [`Error::NoSuchComponent`]; [`Error::NotPositive`] for the frequency of an
/// arc, [`Error::ArcTooLong`] if a step is half a turn or more; [`Error::NotFinite`] for a sample that is not finite,
/// as with an intensity of NaN.
pub fn maxima<S, I, L, const D: usize, const M: usize>(
    system: &S,
    integrator: &I,
    law: &L,
    config: &EnsembleConfig,
    response: &Response<'_>,
) -> Result<Vec<Samples>, Error>
where
    S: Sync + ?Sized,
    I: Integrator<S, D, M>,
    L: InitialDistribution<D> + ?Sized,
{
    let legs = schedule(config)?;
    response.check(D, legs.iter().fold(0.0, |largest, leg| leg.dt.max(largest)))?;
    let (level, seed) = (SimdLevel::best(), config.seed);
    let follow = Follow { system, integrator, law, seed, legs: &legs, level };
    let block = |ids: std::ops::Range<u64>| {
        let mut watch = Maximum::new(response, seed, legs.len());
        let mut start = ids.start;
        while start < ids.end {
            let end = ids.end.min(start + LANES as u64);
            let lives = follow.group::<D, M, _>(&(start..end), &mut watch);
            if let Some((_, error)) = lives.into_failures().next() {
                return Err(error);
            }
            start = end;
        }
        Ok(watch.samples)
    };
    let join = |mut earlier: Vec<Vec<f64>>, later: Vec<Vec<f64>>| {
        for (values, more) in earlier.iter_mut().zip(later) {
            values.extend(more);
        }
        earlier
    };
    let samples = reduce_blocks(config.n_paths, block, join)?.unwrap_or_default();
    samples.into_iter().map(Samples::new).collect()
}

impl Response<'_> {
    pub(crate) fn check(&self, n_states: usize, dt: f64) -> Result<(), Error> {
        let component = |component: usize| {
            let error = Error::NoSuchComponent { component, limit: n_states };
            if component < n_states { Ok(()) } else { Err(error) }
        };
        component(self.component)?;
        match self.between {
            Between::CubicHermite { velocity } => component(velocity),
            Between::RotationArc { natural_frequency: omega } => {
                if !(omega.is_finite() && omega > 0.0) {
                    return Err(Error::NotPositive { quantity: "natural frequency", value: omega });
                }
                let (angle, limit) = (omega * dt, std::f64::consts::PI);
                if angle < limit { Ok(()) } else { Err(Error::ArcTooLong { angle, limit }) }
            }
            Between::Endpoints | Between::BrownianBridge { .. } => Ok(()),
        }
    }
}

impl Response<'_> {
    /// The largest response over a step of one path, which both ends determine.
    ///
    /// `None` for [`Between::BrownianBridge`], whose maximum is drawn.
    #[must_use]
    pub fn largest_in_step(&self, dt: f64, before: &[[f64; 1]], after: &[[f64; 1]]) -> Option<f64> {
        let value = |x: &[[f64; 1]], component: usize| x.get(component).map_or(f64::NAN, |x| x[0]);
        let ends = [before, after].map(|x| value(x, self.component));
        let above = |sign: f64| {
            let [start, end] = ends.map(|q| sign * q);
            match self.between {
                Between::Endpoints => Some(larger(start, end)),
                Between::BrownianBridge { .. } => None,
                Between::CubicHermite { velocity } => {
                    let slopes = [before, after].map(|x| sign * value(x, velocity) * dt);
                    Some(hermite_maximum([start, end], slopes))
                }
                Between::RotationArc { natural_frequency } => {
                    let (sin, cos) = (natural_frequency * dt).sin_cos();
                    Some(arc_maximum(start, end, sin, cos))
                }
            }
        };
        match self.side {
            Side::Above => above(1.0),
            Side::Magnitude => Some(larger(above(1.0)?, above(-1.0)?)),
        }
    }
}

/// Stores the maximum response of each lane.
pub(crate) struct Maximum<'a> {
    response: &'a Response<'a>,
    noise: Noise,
    bridges: Vec<Stream>,
    /// State of one lane, for the intensity of a bridge.
    state: Vec<f64>,
    /// Word at which the numbers of the bridges begin.
    first_word: u128,
    pub(crate) running: [f64; LANES],
    samples: Vec<Vec<f64>>,
}

impl<'a> Maximum<'a> {
    pub(crate) fn new(response: &'a Response<'a>, seed: u64, n_times: usize) -> Self {
        let noise = Noise::new(seed);
        let (bridges, state, samples) = (Vec::new(), Vec::new(), vec![Vec::new(); n_times]);
        Self { response, noise, bridges, state, first_word: 0, running: [0.0; LANES], samples }
    }

    /// The same with the bridges of another of several responses, which are independent.
    pub(crate) fn with_bridges_of(self, index: usize) -> Self {
        Self { first_word: (index as u128) << 40, ..self }
    }

    /// `above(lane, sign)` is the maximum of `sign x` over the step.
    #[inline(always)]
    fn raise(&mut self, above: impl Fn(usize, f64) -> f64) {
        for lane in 0..LANES {
            self.running[lane] = larger(self.running[lane], above(lane, 1.0));
        }
        if self.response.side == Side::Magnitude {
            for lane in 0..LANES {
                self.running[lane] = larger(self.running[lane], above(lane, -1.0));
            }
        }
    }
}

impl Watch for Maximum<'_> {
    const EVERY_STEP: bool = true;

    fn start(&mut self, first: u64, x: &[[f64; LANES]]) {
        self.running = [f64::NEG_INFINITY; LANES];
        let row = &x[self.response.component];
        self.raise(|lane, sign| sign * row[lane]);
        self.bridges.clear();
        if matches!(self.response.between, Between::BrownianBridge { .. }) {
            let noise = self.noise;
            let lanes = 0..LANES as u64;
            let first_word = self.first_word;
            self.bridges.extend(lanes.map(|lane| {
                let mut stream = noise.stream(Purpose::Bridge, first.wrapping_add(lane));
                stream.seek(first_word);
                stream
            }));
        }
    }

    #[inline(always)]
    fn step(&mut self, (t, dt): (f64, f64), before: &[[f64; LANES]], after: &[[f64; LANES]]) {
        let component = self.response.component;
        let (start, end) = (&before[component], &after[component]);
        match self.response.between {
            Between::Endpoints => self.raise(|lane, sign| sign * end[lane]),
            Between::BrownianBridge { intensity } => {
                let (mut spreads, mut others) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    self.state.clear();
                    self.state.extend(before.iter().map(|row| row[lane]));
                    let s = intensity(t, &self.state);
                    // 1 - U is in (0, 1], so its logarithm is finite. Two numbers are drawn for either side.
                    let mut draw =
                        || -2.0 * s * s * dt * (1.0 - self.bridges[lane].next_uniform()).ln();
                    (spreads[lane], others[lane]) = (draw(), draw());
                }
                self.raise(|lane, sign| {
                    let spread = if sign > 0.0 { spreads[lane] } else { others[lane] };
                    let difference = end[lane] - start[lane];
                    let middle = sign * (start[lane] + end[lane]);
                    0.5 * (middle + (difference * difference + spread).sqrt())
                });
            }
            Between::CubicHermite { velocity } => {
                let (v_0, v_1) = (&before[velocity], &after[velocity]);
                self.raise(|lane, sign| {
                    let ends = [start[lane], end[lane]].map(|q| sign * q);
                    hermite_maximum(ends, [v_0[lane], v_1[lane]].map(|v| sign * v * dt))
                });
            }
            Between::RotationArc { natural_frequency } => {
                let (sin, cos) = (natural_frequency * dt).sin_cos();
                self.raise(|lane, sign| {
                    arc_maximum(sign * start[lane], sign * end[lane], sin, cos)
                });
            }
        }
    }

    fn output(&mut self, leg: usize, _: f64, _: &[[f64; LANES]], lives: &mut Lives) {
        let n_active = lives.n_active;
        self.samples[leg].extend_from_slice(&self.running[..n_active]);
    }
}

/// The larger of two values; NaN if either is NaN, so an unknown maximum is rejected with the samples.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Maximum over `[0, 1]` of the cubic with these end values and slopes; NaN if they are too large to evaluate.
#[inline(always)]
fn hermite_maximum(q: [f64; 2], slope: [f64; 2]) -> f64 {
    let drop = q[0] - q[1];
    // q' = a s^2 + b s + c
    let a = 6.0 * drop + 3.0 * (slope[0] + slope[1]);
    let b = -6.0 * drop - 4.0 * slope[0] - 2.0 * slope[1];
    let c = slope[0];
    let discriminant = b * b - 4.0 * a * c;
    if !discriminant.is_finite() {
        return f64::NAN;
    }
    // The two roots without cancellation; if there is none, a root is NaN and its value is ignored.
    let t = -0.5 * (b + discriminant.sqrt().copysign(b));
    let value = |s: f64| {
        let inside = s > 0.0 && s < 1.0;
        let cubic = q[0] + s * (c + s * (0.5 * b + s * (a / 3.0)));
        if inside { cubic } else { q[0] }
    };
    q[0].max(q[1]).max(value(t / a)).max(value(c / t))
}

/// Maximum of the arc `q'' = -q` through `start` and `end`, which is an angle of this sine and cosine later.
#[inline(always)]
fn arc_maximum(start: f64, end: f64, sin: f64, cos: f64) -> f64 {
    // Velocities over omega at both ends.
    let v_0 = (end - start * cos) / sin;
    let v_1 = (end * cos - start) / sin;
    let amplitude = (start * start + v_0 * v_0).sqrt();
    if v_0 > 0.0 && v_1 < 0.0 { amplitude } else { start.max(end) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with 2,000 points of each cubic: near its top a parabola exceeds the nearest point by 1e-6 of its
    /// curvature.
    #[test]
    fn the_maximum_of_a_cubic_is_that_of_its_points() {
        let mut stream = Noise::new(4).stream(Purpose::Field, 0);
        let mut interior = 0;
        for _ in 0..500 {
            let [q_0, q_1] = stream.next_normal_pair();
            let [s_0, s_1] = stream.next_normal_pair().map(|slope| 4.0 * slope);
            let found = hermite_maximum([q_0, q_1], [s_0, s_1]);
            let mut largest = f64::NEG_INFINITY;
            for k in 0..=2_000 {
                let s = f64::from(k) / 2_000.0;
                let (h_00, h_01) = ((1.0 + 2.0 * s) * (1.0 - s).powi(2), s * s * (3.0 - 2.0 * s));
                let (h_10, h_11) = (s * (1.0 - s).powi(2), s * s * (s - 1.0));
                largest = largest.max(h_00 * q_0 + h_10 * s_0 + h_01 * q_1 + h_11 * s_1);
            }
            assert!(found >= largest - 1e-12 && found < largest + 1e-5, "{found} {largest}");
            interior += i32::from(found > q_0.max(q_1) + 1e-9);
        }
        assert!(interior > 50, "{interior}");
        assert!((hermite_maximum([1.0, 1.0], [0.0, 0.0]) - 1.0).abs() < 1e-15);
        assert!((hermite_maximum([0.0, 1.0], [1.0, 1.0]) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_maximum_of_an_arc_is_its_amplitude_where_the_top_is_inside() {
        let q = |angle: f64| 2.0 * (angle - 1.0).cos();
        let over =
            |from: f64, angle: f64| arc_maximum(q(from), q(from + angle), angle.sin(), angle.cos());
        assert!((over(0.7, 0.5) - 2.0).abs() < 1e-14);
        assert!((over(0.2, 0.5) - q(0.7)).abs() < 1e-14);
        assert!((over(1.2, 0.5) - q(1.2)).abs() < 1e-14);
        assert!((over(3.0, 2.0) - q(3.0)).abs() < 1e-14);
    }
}
