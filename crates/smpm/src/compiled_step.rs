//! The step, which is most of the code of a simulation, is compiled with this crate, once for all that run it.

use perturbation_moments::Jet;

use crate::number::{Number, show_derivatives};

#[cfg(not(test))]
macro_rules! compiled {
    ($number:ty: $($dimension:literal $step:ident),+ $(; $($derivatives:tt)+)?) => {
        #[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
        impl Number for $number {
            $(show_derivatives!($($derivatives)+);)?

            const COMPILED: &'static [usize] = &[$($dimension),+];

            fn compiled_step(dimension: usize) -> &'static (dyn std::any::Any + Send + Sync) {
                $(
                    #[inline(never)]
                    fn $step(
                        simulation: &mut crate::simulation::Simulation<$number, $dimension>,
                        dt: f64,
                    ) -> Result<crate::simulation::StepReport, crate::error::Error> {
                        simulation.try_step(dt)
                    }
                )+
                match dimension {
                    $(
                        $dimension => {
                            static STEP: crate::simulation::Step<$number, $dimension> = $step;
                            &STEP
                        }
                    )+
                    _ => &(),
                }
            }
        }
    };
}

#[cfg(not(test))]
compiled!(f64: 1 in_one, 2 in_two, 3 in_three);
#[cfg(not(test))]
compiled!(Jet: 1 in_one, 2 in_two, 3 in_three; 2: 1 => first, 2 => second);

// The unit tests run no step.
#[cfg(test)]
impl Number for f64 {}
#[cfg(test)]
#[allow(clippy::inline_always, reason = "part of loops inside a dispatched closure")]
impl Number for Jet {
    show_derivatives!(2: 1 => first, 2 => second);
}
