//! The step, which is most of the code of a simulation, is compiled with this crate, once for all that run it.

use std::any::Any;

use perturbation_moments::Jet;

use crate::error::Error;
use crate::simulation::{Simulation, StepReport};

/// One step of a simulation with `f64` or jets in one to three dimensions.
#[inline(never)]
pub(crate) fn compiled_step(simulation: &mut dyn Any, dt: f64) -> Result<StepReport, Error> {
    macro_rules! step {
        ($($number:ty, $dimension:literal);+) => {
            $(
                if let Some(simulation) = simulation.downcast_mut::<Simulation<$number, $dimension>>() {
                    return simulation.try_step(dt);
                }
            )+
        };
    }
    step!(f64, 1; f64, 2; f64, 3; Jet, 1; Jet, 2; Jet, 3);
    unreachable!("a step of these numbers is compiled")
}
