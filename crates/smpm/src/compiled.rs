//! What is compiled with this crate, once for all that run it: the step, which is most of the code of a simulation, and the update of
//! the materials that a scene may name. Materials from outside compile their own update.

#[cfg(not(test))]
mod materials;

use perturbation_moments::Jet;

use crate::material::Material;
use crate::material_points::UpdateBatch;
use crate::number::Number;

#[cfg(not(test))]
macro_rules! compiled {
    ($number:ty: $($dimension:literal $step:ident),+) => {
        impl Number for $number {
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
compiled!(Jet: 1 in_one, 2 in_two, 3 in_three);

// The unit tests run no step.
#[cfg(test)]
impl Number for f64 {}
#[cfg(test)]
impl Number for Jet {}

/// The update of a material: the one that is compiled with this crate, or one that is compiled for the caller.
pub(crate) fn update_of<M, S, const PLANE: bool>() -> UpdateBatch<M, S, PLANE>
where
    M: Material<S> + 'static,
    S: Number,
    M::State: 'static,
{
    #[cfg(not(test))]
    if const { M::IS_COMPILED && !S::COMPILED.is_empty() } {
        let of_this_material = |update: &&(dyn std::any::Any + Send + Sync)| {
            update.downcast_ref::<UpdateBatch<M, S, PLANE>>().copied()
        };
        return match materials::updates().iter().find_map(of_this_material) {
            Some(update) => update,
            None => unreachable!("the update of this material is compiled"),
        };
    }
    UpdateBatch::HERE
}
