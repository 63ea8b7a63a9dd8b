//! Oscillators as systems of first order.

/// `first_order!(System)` implements `Sde<2, 1>` for an oscillator by its `SecondOrder<1, 1>`, with the state `(q, q')`.
macro_rules! first_order {
    ($system:ty) => {
        impl sde_integrators::Sde<2, 1> for $system {
            type Noise = sde_integrators::Additive;

            #[inline]
            fn drift(&self, t: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
                let [acceleration] = self.acceleration(t, &[q], &[v]);
                [v, acceleration]
            }

            #[inline]
            fn noise(&self, t: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
                let [intensity] = sde_integrators::SecondOrder::noise_intensity(self, t);
                [[0.0], intensity]
            }

            #[inline]
            fn linear_part(&self) -> Option<[[f64; 2]; 2]> {
                Some(sde_integrators::linear_part_of(self))
            }
        }
    };
}
pub(crate) use first_order;
