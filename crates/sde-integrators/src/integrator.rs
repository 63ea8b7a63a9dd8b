//! The seam of the methods: one step.

use crate::error::StepError;
use crate::noise::Increment;

/// A method that takes one step of a system with `D` states and `M` Brownian motions.
///
/// A step owns no clock, no storage and no randomness: time, increment and memory come from outside. The bound that an
/// implementation puts on `S` names what it needs: any [`Sde`](crate::Sde), one with additive noise, or the parts of a
/// [`SecondOrder`](crate::SecondOrder) system.
pub trait Integrator<S: ?Sized, const D: usize, const M: usize>: Sync {
    /// What the method keeps of a path between steps, other than its state: the last normal, the last iterate.
    type Memory: Default + Clone + Send;

    /// Move `x` from `t` to `t + dt`, along the increment `dw` over that step.
    ///
    /// # Errors
    /// Where the method cannot take the step. A non-finite result is no error here; whoever drives the steps checks.
    fn step(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: &Increment<M>,
        x: &mut [f64; D],
        memory: &mut Self::Memory,
    ) -> Result<(), StepError>;
}

/// Make a method that advances `(q, v)` an integrator of the state `(q_1.., v_1..)`, for 1, 2 and 3 degrees of freedom.
macro_rules! integrate_second_order {
    ($method:ty { $($n:literal => $d:literal, $memory:ty;)+ }) => { $(
        impl<S, const M: usize> $crate::integrator::Integrator<S, $d, M> for $method
        where
            S: $crate::system::SecondOrder<$n, M> + ?Sized,
        {
            type Memory = $memory;

            #[inline]
            fn step(
                &self,
                system: &S,
                t: f64,
                dt: f64,
                dw: &$crate::noise::Increment<M>,
                x: &mut [f64; $d],
                memory: &mut Self::Memory,
            ) -> Result<(), $crate::error::StepError> {
                let mut q = std::array::from_fn(|k| x[k]);
                let mut v = std::array::from_fn(|k| x[$n + k]);
                Self::advance::<S, $n, M>(system, (t, dt), dw, (&mut q, &mut v), memory);
                x[..$n].copy_from_slice(&q);
                x[$n..].copy_from_slice(&v);
                Ok(())
            }
        }
    )+ };
}
pub(crate) use integrate_second_order;

/// `g w`: the increments of the Brownian motions as they act on each row.
#[inline]
pub(crate) fn apply<const R: usize, const M: usize>(g: &[[f64; M]; R], w: &[f64; M]) -> [f64; R] {
    let mut sum = [0.0; R];
    for (value, row) in sum.iter_mut().zip(g) {
        for (a, b) in row.iter().zip(w) {
            *value += a * b;
        }
    }
    sum
}
