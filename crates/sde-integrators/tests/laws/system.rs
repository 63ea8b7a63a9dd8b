//! A system of second order in first-order form.

use sde_integrators::{Sde, SecondOrder, StateSpace, check_diffusion_divergence};

use crate::methods::Linear;

#[test]
fn the_state_space_form_says_the_same_as_the_system() {
    let linear =
        Linear { force: 0.5, stiffness: 0.3, modulation: 0.2, ..Linear::oscillator(1.3, 0.4, 0.7) };
    let system = StateSpace(linear);
    let (t, x) = (0.8, [0.6, -0.9]);
    let acceleration = linear.acceleration(t, &[x[0]], &[x[1]])[0];
    let by_hand = 0.5 * 2.4_f64.sin() - 0.3 * 0.6 + 0.4 * 0.9 - 1.3 * 1.3 * 0.6;
    assert!((acceleration - by_hand).abs() < 1e-15);
    assert_eq!(system.drift(t, &x).map(f64::to_bits), [x[1], acceleration].map(f64::to_bits));
    let s = linear.noise_intensity(t)[0][0];
    assert_eq!(system.noise(t, &x).concat(), [0.0, s]);
    assert!((system.diffusion(t, &x)[1][1] - 0.5 * s * s).abs() < 1e-16);
    assert!(check_diffusion_divergence(&system, t, &[x]).abs() < 1e-12);
}
