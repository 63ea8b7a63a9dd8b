//! Second-order systems in first-order form.

use crate::system::{Additive, Sde, SecondOrder, linear_part_of};

/// A [`SecondOrder`] system with 1, 2 or 3 degrees of freedom as an [`Sde`] of the state `(q_1.., v_1..)`,
///
/// $$ dq = v dt, \qquad dv = (r - c v - \omega^2 q) dt + s dB . $$
///
/// It also implements [`SecondOrder`], so one declaration serves every method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateSpace<S>(
    /// The second-order system.
    pub S,
);

impl<S, const N: usize, const M: usize> SecondOrder<N, M> for StateSpace<S>
where
    S: SecondOrder<N, M>,
{
    #[inline]
    fn natural_frequency(&self) -> [f64; N] {
        self.0.natural_frequency()
    }

    #[inline]
    fn linear_damping(&self) -> [f64; N] {
        self.0.linear_damping()
    }

    #[inline]
    fn remaining_acceleration(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        self.0.remaining_acceleration(t, q, v)
    }

    #[inline]
    fn remaining_flow(&self, t: f64, dt: f64, q: &[f64; N], v: &mut [f64; N]) {
        self.0.remaining_flow(t, dt, q, v);
    }

    #[inline]
    fn noise_intensity(&self, t: f64) -> [[f64; M]; N] {
        self.0.noise_intensity(t)
    }

    #[inline]
    fn acceleration(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> [f64; N] {
        self.0.acceleration(t, q, v)
    }
}

macro_rules! first_order_form {
    ($($n:literal => $d:literal),+) => { $(
        impl<S, const M: usize> Sde<$d, M> for StateSpace<S>
        where
            S: SecondOrder<$n, M>,
        {
            type Noise = Additive;

            #[inline]
            fn drift(&self, t: f64, x: &[f64; $d]) -> [f64; $d] {
                let q = std::array::from_fn(|k| x[k]);
                let v: [f64; $n] = std::array::from_fn(|k| x[$n + k]);
                let acceleration = self.0.acceleration(t, &q, &v);
                let mut drift = [0.0; $d];
                drift[..$n].copy_from_slice(&v);
                drift[$n..].copy_from_slice(&acceleration);
                drift
            }

            #[inline]
            fn noise(&self, t: f64, _x: &[f64; $d]) -> [[f64; M]; $d] {
                let mut noise = [[0.0; M]; $d];
                noise[$n..].copy_from_slice(&self.0.noise_intensity(t));
                noise
            }

            #[inline]
            fn linear_part(&self) -> Option<[[f64; $d]; $d]> {
                Some(linear_part_of(&self.0))
            }
        }
    )+ };
}

first_order_form!(1 => 2, 2 => 4, 3 => 6);
