//! What is compiled with this crate, once for all programs that run it: all of the method for one to six states but the drift and the
//! diffusion of a system.

#[cfg(not(test))]
use std::any::Any;
use std::io::{Read, Write};

use sde_integrators::GaussianMixture;

use crate::conditional_step::Conditional;
use crate::density::cell_integral::CellIntegral;
use crate::density::density_field::DensityField;
use crate::error::Error;
use crate::method::config::Config;
use crate::method::remapping::{Remapped, Remapping};
use crate::score::ScoreEstimator;
use crate::solver::Solver;
use crate::solver::report::StepReport;
use crate::step::GoesOn;
use crate::system::coefficients::Coefficients;

/// The passes over a cloud in one dimension.
pub(crate) struct Passes<const D: usize> {
    pub(crate) start: Start<D>,
    pub(crate) step_towards:
        fn(&mut Solver<D>, &dyn Coefficients<D>, f64) -> Result<StepReport, Error>,
    pub(crate) advance_while:
        fn(&mut Solver<D>, &dyn Coefficients<D>, f64, GoesOn<'_>) -> Result<(), Error>,
    pub(crate) conditional_step: ConditionalStep<D>,
    pub(crate) remap: fn(&mut Solver<D>, &Remapping) -> Result<Remapped, Error>,
    pub(crate) snapshot: fn(&Solver<D>, &mut dyn Write) -> Result<(), Error>,
    pub(crate) restore: fn(&mut Solver<D>, &mut dyn Read) -> Result<(), Error>,
    pub(crate) cell_integral: fn(&Solver<D>) -> Result<CellIntegral<D>, Error>,
    pub(crate) density_field: fn(&Solver<D>) -> Result<DensityField<D>, Error>,
}

/// The solver at the start, with the estimator of the method or that of the caller.
type Start<const D: usize> = fn(
    &GaussianMixture<D>,
    &Config<D>,
    Option<Box<dyn ScoreEstimator<D> + Sync>>,
) -> Result<Solver<D>, Error>;

/// A step, not beyond a time, of a structure whose filter states are conditioned out.
type ConditionalStep<const D: usize> =
    fn(&mut Solver<D>, &mut Conditional<D>, &dyn Coefficients<D>, f64) -> Result<StepReport, Error>;

impl<const D: usize> Passes<D> {
    const HERE: Self = Self {
        start: |law, config, estimator| {
            let of_method = || config.method.combination_in(D).estimator.build();
            Solver::new(law, config, estimator.unwrap_or_else(of_method))
        },
        step_towards: Solver::step_towards,
        advance_while: Solver::advance_while,
        conditional_step: Solver::conditional_step,
        remap: Solver::remap,
        snapshot: Solver::snapshot,
        restore: Solver::restore,
        cell_integral: CellIntegral::new,
        density_field: DensityField::new,
    };
}

/// The passes that are compiled with this crate, as their own type.
#[cfg(not(test))]
#[inline(never)]
fn with_this_crate(dimension: usize) -> &'static (dyn Any + Send + Sync) {
    macro_rules! passes {
        ($($dimension:literal),+) => {
            match dimension {
                $($dimension => {
                    static PASSES: Passes<$dimension> = Passes::HERE;
                    &PASSES
                })+
                _ => &(),
            }
        };
    }
    passes!(1, 2, 3, 4, 5, 6)
}

/// The passes in one dimension; beyond six they are compiled with who runs them.
#[cfg(not(test))]
pub(crate) fn passes<const D: usize>() -> &'static Passes<D> {
    if const { D >= 1 && D <= 6 } {
        match with_this_crate(D).downcast_ref() {
            Some(passes) => passes,
            None => unreachable!("the passes in one to six dimensions are compiled"),
        }
    } else {
        const { &Passes::HERE }
    }
}

/// Unit tests compile what they run.
#[cfg(test)]
pub(crate) fn passes<const D: usize>() -> &'static Passes<D> {
    const { &Passes::HERE }
}
