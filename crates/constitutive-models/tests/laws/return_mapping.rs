//! A point of von Mises material against closed forms: strained one way, back, and at a right angle.

use constitutive_models::{Now, Strength, VonMises, VonMisesParameters, VonMisesState};
use perturbation_moments::Jet;

use super::materials::Number;

/// Megapascal. The hardening is strong, so that a wrong share of it shows.
const METAL: VonMisesParameters<f64> =
    VonMisesParameters { shear_modulus: 77500.0, yield_stress: 800.0, hardening_modulus: 20_000.0 };

/// Axial, and shear at a right angle to it: deviators of the same norm, `sqrt(3/2)`.
const AXIAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5]];
const SHEAR: [[f64; 3]; 3] =
    [[0.0, HALF_ROOT_OF_THREE, 0.0], [HALF_ROOT_OF_THREE, 0.0, 0.0], [0.0; 3]];
const HALF_ROOT_OF_THREE: f64 = 0.866_025_403_784_438_6;

/// Strain along the axis before any other path, and back.
const FIRST: f64 = 0.05;
const BACK: f64 = 0.04;

/// Adds an equivalent strain along a direction in equal steps.
fn strain<S: Number>(
    material: &VonMises<S>,
    state: &mut VonMisesState<S>,
    direction: &[[f64; 3]; 3],
    strain: f64,
    n_steps: u32,
) {
    let c = S::constant;
    let now = Now {
        velocity_gradient: direction.map(|row| row.map(c)),
        dt: strain / f64::from(n_steps),
        time: 0.0,
        volume_before: c(1.0),
        volume: c(1.0),
        viscosity: c(0.0),
        cell: 1.0,
    };
    for _ in 0..n_steps {
        material.update(&now, state).unwrap();
    }
}

/// The plastic strain after the first path and, if asked for, the way back: `sigma = 3 G (eps - eps_p) = Y + H eps_p` on the way
/// there, and back again from `sigma` to `-sigma` elastically.
fn closed<S: Number>([g, y, h]: [S; 3], back: bool) -> S {
    let three_g = g * 3.0;
    let first = (three_g * FIRST - y) / (three_g + h);
    let turned = y + h * first;
    if back { first + (three_g * BACK - turned * 2.0) / (three_g + h) } else { first }
}

/// Along one direction the return is exact for any step, with its derivatives by `G`, `Y` and `H`.
#[test]
fn a_straight_path_and_its_return_have_the_plastic_strain_of_the_closed_form() {
    let values = [METAL.shear_modulus, METAL.yield_stress, METAL.hardening_modulus];
    let parameters: [Jet; 3] = std::array::from_fn(|k| Jet::variable(values[k], k));
    let [shear_modulus, yield_stress, hardening_modulus] = parameters;
    let metal = VonMisesParameters { shear_modulus, yield_stress, hardening_modulus };
    let material = VonMises::new(metal).unwrap();
    for (back, n_steps) in [false, true].into_iter().flat_map(|back| [1, 7, 50].map(|n| (back, n)))
    {
        let mut state = Strength::<Jet>::start(&material);
        strain(&material, &mut state, &AXIAL, FIRST, n_steps);
        if back {
            strain(&material, &mut state, &AXIAL.map(|row| row.map(|x| -x)), BACK, n_steps);
        }
        let (found, exact) = (state.plastic_strain, closed(parameters, back));
        assert!((found.value / exact.value - 1.0).abs() < 1e-12, "{found:?} {exact:?}");
        for k in 0..3 {
            let off = found.first[k] / exact.first[k] - 1.0;
            assert!(off.abs() < 1e-11, "{back}, {n_steps} steps, parameter {k}: {off:e}");
        }
    }
}

/// Krieg and Krieg 1977, with hardening: with `beta = H/(3 G + H)` the flow stress is `sigma_0 sin(psi)^-beta` once the angle
/// between stress and strain rate has come from a right one down to `psi`, after the equivalent strain
/// `sigma_0/(3 G) * integral from psi to pi/2 of sin^-(1 + beta)`. Backward differences along a path that bends: first order.
#[test]
fn a_turn_converges_to_the_closed_form_at_first_order() {
    const LAST_ANGLE: f64 = std::f64::consts::FRAC_PI_6;
    let three_g = 3.0 * METAL.shear_modulus;
    let beta = METAL.hardening_modulus / (three_g + METAL.hardening_modulus);
    let plastic = closed([METAL.shear_modulus, METAL.yield_stress, METAL.hardening_modulus], false);
    let first = METAL.yield_stress + METAL.hardening_modulus * plastic;
    // Simpson's rule: the integrand is smooth, its error far below a part in 1e12.
    let n = 2000;
    let width = (std::f64::consts::FRAC_PI_2 - LAST_ANGLE) / f64::from(n);
    let at = |k: i32| (LAST_ANGLE + width * f64::from(k)).sin().powf(-1.0 - beta);
    let inner: f64 = (1..n).map(|k| at(k) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
    let turn = first / three_g * (at(0) + inner + at(n)) * width / 3.0;

    let material = VonMises::new(METAL).unwrap();
    let errors = |n_steps: u32| {
        let mut state = Strength::<f64>::start(&material);
        strain(&material, &mut state, &AXIAL, FIRST, 1);
        strain(&material, &mut state, &SHEAR, turn, n_steps);
        let flow = Strength::<f64>::observe(&material, &state).flow_stress;
        let deviator = state.deviator.matrix();
        // In the plane of both directions: the axial and the shear part of the stress.
        let angle = deviator[0][0].atan2(deviator[0][1] / HALF_ROOT_OF_THREE);
        (flow / (first * LAST_ANGLE.sin().powf(-beta)) - 1.0, angle - LAST_ANGLE)
    };
    let ((flow, angle), (_, fine)) = (errors(100), errors(400));
    assert!(flow.abs() < 2e-4 && angle.abs() < 6e-3, "{flow:e} {angle:e}");
    let order = 0.5 * (angle / fine).log2();
    assert!((order - 1.0).abs() < 0.02, "{order}");
}
