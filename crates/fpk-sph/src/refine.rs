//! A tolerance instead of a number of particles: runs on finer lattices until the error that they show is small enough.

use crate::cloud::start::InitialLattice;
use crate::error::{Error, positive};

/// How far a refinement goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refinement {
    /// The error asked for, relative to each value.
    pub tolerance: f64,
    /// The order in the spacing that the method has by theory, which bounds the one that the runs show: 2 for the quadratic
    /// log-density fit, 4 for the cubic flow-map fit, but 2 where the drift has kinks, across which the flow map is no
    /// polynomial.
    pub order: f64,
    /// Most particles of a run.
    pub most_particles: usize,
}

/// A value with the error that its own runs show.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct RefinedValue {
    /// The value: extrapolated where the runs show an order, else that of the finest run.
    pub value: f64,
    /// Its estimated error, not negative: of the finest run where the value was extrapolated, so that it holds for the
    /// worse of the two.
    pub error: f64,
    /// The order in the spacing that three runs show, whatever the bound; none with two, or where their differences do not
    /// fall at least as the first power.
    pub order: Option<f64>,
}

/// One run of a refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinementRun<const D: usize> {
    /// Its lattice.
    pub lattice: InitialLattice<D>,
    /// Particles on it.
    pub n_particles: usize,
    /// What was observed.
    pub values: Vec<f64>,
}

/// Why a refinement ended.
#[derive(Debug)]
pub enum RefinementEnd {
    /// Every error is within the tolerance.
    Met,
    /// The next run would hold more particles than allowed; some error is still above the tolerance.
    MostParticles {
        /// The particles that the next run would hold.
        needed: usize,
    },
    /// A run on a finer lattice failed; the values rest on those before it.
    Failed(Error),
}

/// What a refinement came to.
#[derive(Debug)]
#[must_use]
pub struct Refined<const D: usize> {
    /// The values, in the order observed.
    pub values: Vec<RefinedValue>,
    /// The runs, coarsest first; at least two.
    pub runs: Vec<RefinementRun<D>>,
    /// Why it ended.
    pub end: RefinementEnd,
}

/// Ratio of the spacings of successive runs. With the order 2 the difference of two runs is the error of the finer one.
const RATIO: f64 = std::f64::consts::SQRT_2;

/// The least order that is believed: below, the runs hardly converge.
const LEAST_ORDER: f64 = 1.0;

/// Runs on the given lattice, then on lattices finer by the square root of two, until the error of every observed value is
/// within the tolerance.
///
/// Let `p` be the order by theory and `r` the ratio of the spacings, the root of two. Two runs give the error of the finer
/// one, `e = |Q_1 - Q_2| / (r^p - 1)`. Three show an order of their own, `q = log_r((Q_1 - Q_2) / (Q_2 - Q_3))`, and
///
/// * where `q >= p`, part of the last difference has cancelled, or the coarsest lattice is not yet in the range where the
///   error is a power: the coarser pair gives the error by the order `p`, `e = |Q_1 - Q_2| / (r^p (r^p - 1))`, which is then
///   the larger one;
/// * where `1 <= q < p`, the finer pair gives it by the order shown, `e = |Q_2 - Q_3| / (r^q - 1)` (Roache 1994);
/// * where the differences do not fall so, it is the larger of them.
///
/// In the first two the value is extrapolated to the spacing zero, by the lesser of the two orders. An order shown that
/// passes the one of theory is not believed (Oberkampf & Roy 2010, section 8.6).
///
/// The error is that of the spacing, as these runs show it. They do not show
///
/// * what all of them share: the step of time, the reach of the lattice, and of the flow-map fit the rate of [`Settling`].
///   [`Config::with_slower_settling`] shows the last. Whether the reach matters, a run on a lattice that goes half a
///   standard deviation further shows; it costs more particles, and in four states may end in `TooMuchUnresolved`;
/// * an error that hardly depends on the spacing over the range of the runs, although it would vanish further on. With
///   three or four states lattices are coarse, 0.7 to 1.4 standard deviations. There the values of successive lattices
///   agreed within 1.4 % where both were 5 % off (cubic spring and quadratic damper behind Kanai-Tajimi, measured
///   once, 2026-11-26), and settling made most of it.
///
/// [`Settling`]: crate::Settling
/// [`Config::with_slower_settling`]: crate::Config::with_slower_settling
///
/// `observe` runs on a lattice; it returns the number of particles and the values.
///
/// # Errors
/// [`Error::NotPositive`] for the tolerance and the order; that of the first two runs. A later run that fails ends the refinement with
/// what is there.
pub fn refine<const D: usize>(
    lattice: InitialLattice<D>,
    refinement: &Refinement,
    mut observe: impl FnMut(&InitialLattice<D>) -> Result<(usize, Vec<f64>), Error>,
) -> Result<Refined<D>, Error> {
    positive("tolerance", refinement.tolerance)?;
    positive("order", refinement.order)?;
    let mut run = |lattice: InitialLattice<D>| -> Result<RefinementRun<D>, Error> {
        let (n_particles, values) = observe(&lattice)?;
        Ok(RefinementRun { lattice, n_particles, values })
    };
    let mut runs = vec![run(lattice)?, run(lattice.refined(RATIO))?];
    loop {
        let values = refined_values(&runs, refinement.order);
        let met = |v: &RefinedValue| v.error <= refinement.tolerance * v.value.abs();
        if values.iter().all(met) {
            return Ok(Refined { values, runs, end: RefinementEnd::Met });
        }
        let (last, before) = (&runs[runs.len() - 1], &runs[runs.len() - 2]);
        let growth = last.n_particles as f64 / before.n_particles as f64;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of particles"
        )]
        let needed = (last.n_particles as f64 * growth).ceil() as usize;
        if needed > refinement.most_particles {
            return Ok(Refined { values, runs, end: RefinementEnd::MostParticles { needed } });
        }
        match run(last.lattice.refined(RATIO)) {
            Ok(finer) => runs.push(finer),
            Err(error) => return Ok(Refined { values, runs, end: RefinementEnd::Failed(error) }),
        }
    }
}

/// The values that the last two or three runs give.
fn refined_values<const D: usize>(runs: &[RefinementRun<D>], order: f64) -> Vec<RefinedValue> {
    let finest = &runs[runs.len() - 1];
    (0..finest.values.len())
        .map(|k| {
            let mut newest_first = runs.iter().rev().map(|run| run.values[k]);
            let q_3 = newest_first.next().unwrap_or(f64::NAN);
            let q_2 = newest_first.next().unwrap_or(f64::NAN);
            match newest_first.next() {
                None => of_two(q_2, q_3, order),
                Some(q_1) => of_three(q_1, q_2, q_3, order),
            }
        })
        .collect()
}

fn of_two(coarse: f64, fine: f64, order: f64) -> RefinedValue {
    let error = (fine - coarse).abs() / (RATIO.powf(order) - 1.0);
    RefinedValue { value: fine, error, order: None }
}

fn of_three(q_1: f64, q_2: f64, q_3: f64, order: f64) -> RefinedValue {
    let (before, last) = (q_1 - q_2, q_2 - q_3);
    // NaN where the differences alternate or vanish together.
    let shown = (before / last).ln() / RATIO.ln();
    if shown.is_nan() || shown < LEAST_ORDER.min(order) {
        return RefinedValue { value: q_3, error: before.abs().max(last.abs()), order: None };
    }
    let factor = RATIO.powf(shown.min(order));
    let correction = last / (factor - 1.0);
    let error =
        if shown < order { correction.abs() } else { before.abs() / (factor * (factor - 1.0)) };
    RefinedValue { value: q_3 - correction, error, order: Some(shown) }
}

impl<const D: usize> InitialLattice<D> {
    /// The same reach with the spacing divided by `ratio`, to the nearest whole number of particles along an axis.
    #[must_use]
    pub fn refined(&self, ratio: f64) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of particles"
        )]
        let finer =
            |count: [usize; D]| count.map(|n| ((n.max(1) - 1) as f64 * ratio).round() as usize + 1);
        match *self {
            Self::Box { reach, count } => Self::Box { reach, count: finer(count) },
            Self::Ball { reach, spacing } => Self::Ball { reach, spacing: spacing / ratio },
            Self::Rectangle { half_width, count } => {
                Self::Rectangle { half_width, count: finer(count) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs whose value is `1 + c h^p`.
    fn observed(
        p: f64,
        c: f64,
    ) -> impl FnMut(&InitialLattice<2>) -> Result<(usize, Vec<f64>), Error> {
        move |lattice| {
            let InitialLattice::Ball { spacing, .. } = *lattice else { unreachable!() };
            Ok((1000, vec![1.0 + c * spacing.powf(p), 2.0]))
        }
    }

    const COARSE: InitialLattice<2> = InitialLattice::Ball { reach: 5.0, spacing: 0.5 };

    #[test]
    fn an_error_that_falls_as_a_power_is_extrapolated_away() {
        for p in [1.5, 2.0, 3.0, 4.0] {
            let refinement = Refinement { tolerance: 1e-3, order: p, most_particles: 10_000 };
            let refined = refine(COARSE, &refinement, observed(p, 0.1)).unwrap();
            let RefinedValue { value, error, order } = refined.values[0];
            assert!(matches!(refined.end, RefinementEnd::Met) && error <= 1e-3);
            if refined.runs.len() > 2 {
                assert!((order.unwrap() - p).abs() < 1e-6 && (value - 1.0).abs() < 1e-9, "{p}");
            } else {
                assert!((value - 1.0).abs() < error * (1.0 + 1e-9), "{p}");
            }
        }
    }

    #[test]
    fn an_order_above_that_of_theory_is_not_believed_and_one_below_is() {
        let of =
            |value: fn(f64) -> f64| of_three(value(1.0), value(0.5_f64.sqrt()), value(0.5), 2.0);
        // 2.34 is shown, where the order is 2.
        let above = of(|h| 1.0 + h * h + 0.1 * h.powi(6));
        let made = 0.25 + 0.1 / 64.0;
        assert!(above.order.is_some_and(|order| order > 2.3));
        assert!(above.error > made && above.error < 1.3 * made, "{above:?}");
        let slow = of(|h| 1.0 + h.powf(1.5));
        assert!(slow.order.is_some_and(|order| (order - 1.5).abs() < 1e-12));
        assert!((slow.error - 0.5_f64.powf(1.5)).abs() < 1e-12 && (slow.value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_converge_is_not_extrapolated() {
        let mut sign = 1.0;
        let refinement = Refinement { tolerance: 1e-3, order: 2.0, most_particles: 2_000 };
        let mut n = 1000;
        let refined = refine(COARSE, &refinement, |_| {
            (sign, n) = (-sign, n + 300);
            Ok((n, vec![1.0 + 0.01 * sign]))
        })
        .unwrap();
        let RefinedValue { error, order, .. } = refined.values[0];
        assert!(order.is_none() && (error - 0.02).abs() < 1e-12);
        assert!(matches!(refined.end, RefinementEnd::MostParticles { needed } if needed > 2_000));
    }

    #[test]
    fn a_finer_run_that_fails_leaves_what_is_there() {
        let refinement = Refinement { tolerance: 1e-9, order: 2.0, most_particles: 100_000 };
        let mut runs = 0;
        let refined = refine(COARSE, &refinement, |_| {
            runs += 1;
            if runs == 3 {
                return Err(Error::NoLatticeCell { particle: 7 });
            }
            Ok((1000, vec![f64::from(runs)]))
        })
        .unwrap();
        assert!(matches!(refined.end, RefinementEnd::Failed(Error::NoLatticeCell { particle: 7 })));
        assert_eq!(refined.runs.len(), 2);
        let refused = Refinement { tolerance: 0.0, order: 2.0, most_particles: 1 };
        assert!(refine(COARSE, &refused, |_| Ok((1, vec![1.0]))).is_err());
    }

    #[test]
    fn a_box_is_refined_along_each_axis() {
        let InitialLattice::Box { count, .. } = InitialLattice::<2>::box_of(41).refined(RATIO)
        else {
            unreachable!()
        };
        assert_eq!(count, [58, 58]);
    }
}
