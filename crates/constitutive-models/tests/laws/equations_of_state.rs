//! Equations of state against closed forms: the Hugoniot, detonation, slow expansion.

use constitutive_models::{
    Detonation, EquationOfState, Fluid, Jwl, Material, MieGruneisen, Now, Solid, library,
};
use perturbation_moments::{Jet, Real, Scalar};

use super::materials::CGU;
use super::responses::{MieGruneisen as FrozenPressure, MieGruneisenState};

#[test]
fn on_the_hugoniot_the_carried_derivative_is_the_true_one_and_the_frozen_one_twice_it() {
    // At a given particle velocity p = rho_0 (C + S1 u) u is linear in S1: dp/dS1 = rho_0 u^2.
    for (velocity, ratio) in [(0.05, 2.04), (0.1, 2.08), (0.2, 2.16), (0.4, 2.28)] {
        let u = 0.5 * velocity;
        let p = library::steel_equation(CGU);
        let s1 = Jet::variable(p.s1, 0);
        let random = p.map(|name, v| if name == "s1" { s1 } else { Jet::constant(v) });
        let solid = Solid { equation: MieGruneisen::new(random).unwrap(), strength: Fluid };
        // The volume behind the front moves with S1: J = 1 - u/U_s.
        let volume = (s1 * u + p.sound_speed).recip() * -u + 1.0;
        let zero = Jet::constant(0.0);
        let now = Now {
            velocity_gradient: [[zero; 3]; 3],
            dt: 1.0,
            time: 1.0,
            volume_before: Jet::constant(1.0),
            volume,
            viscosity: zero,
            cell: 1.0,
        };
        let mut state = solid.start([0.0; 3]);
        let pressure = -solid.update(&now, &mut state).unwrap().0[0];
        let truth = p.density * u * u;
        assert!((pressure.first[0] / truth - 1.0).abs() < 1e-12, "{velocity}");
        // Roundoff of terms of the size of the first derivative.
        assert!(pressure.second[0].abs() < 1e-12 * truth);
        let frozen = FrozenPressure::new(MieGruneisenState {
            bulk_modulus: p.density * p.sound_speed * p.sound_speed,
            compression: 1.0 / volume.value - 1.0,
            energy: state.energy.value,
        })
        .diagonal(&[p.s1, p.s2, p.s3, p.gruneisen, p.gruneisen_slope]);
        assert!((frozen.0 / pressure.value - 1.0).abs() < 1e-12);
        // The ratio to three digits.
        assert!((frozen.1[0] / truth - ratio).abs() < 0.005, "{}", frozen.1[0] / truth);
    }
}

#[test]
fn the_products_of_tnt_detonate_at_the_state_of_chapman_and_jouguet() {
    let lit = Detonation { point: [0.0; 3], cells: 1.0 };
    let parameters = library::tnt(CGU);
    let tnt = Jwl::new(parameters, lit).unwrap();
    // On the Hugoniot of the products e = E_0 + p (1 - J)/2; the least speed of the Rayleigh line, p/(rho_0 (1 - J)).
    let speed = |volume: f64| {
        let line = tnt.line(volume);
        let x = 1.0 - volume;
        let pressure = (line.a + line.b * parameters.energy) / (1.0 - 0.5 * line.b * x);
        ((pressure / (parameters.density * x)).sqrt(), pressure)
    };
    let (mut low, mut high) = (0.6, 0.9);
    while high - low > 1e-9 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if speed(left).0 < speed(right).0 { high = right } else { low = left }
    }
    let (detonation, pressure) = speed(low);
    // Reference by an independent calculation: 0.692935 cm/us, 0.209988 Mbar at V = 0.7317.
    assert!((detonation / 0.692_935_181_7 - 1.0).abs() < 1e-9, "{detonation}");
    // At a least the volume is known to the root of roundoff.
    assert!((pressure / 0.209_987_528 - 1.0).abs() < 1e-4, "{pressure} {low}");
    // There the front runs at the sound of the products behind it.
    let energy = parameters.energy + 0.5 * pressure * (1.0 - low);
    let sound = (tnt.bulk_modulus(low, energy) * low / parameters.density).sqrt();
    let particle = pressure / (parameters.density * detonation);
    assert!((particle + sound - detonation).abs() < 1e-5);
}

#[test]
fn slow_expansion_follows_the_isentrope_at_second_order() {
    let lit = Detonation { point: [0.0; 3], cells: 1.0 };
    let p = library::tnt(CGU);
    let tnt = Solid { equation: Jwl::new(p, lit).unwrap(), strength: Fluid };
    // p = A exp(-R1 J) + B exp(-R2 J) + c J^-(1 + omega), through E_0 at J = 1.
    let parts = |volume: f64| {
        let (first, second) = (p.a * (-p.r1 * volume).exp(), p.b * (-p.r2 * volume).exp());
        (first + second, first / p.r1 + second / p.r2)
    };
    let c = (p.energy - parts(1.0).1) * p.omega;
    let closed = parts(4.0).0 + c * 4.0_f64.powf(-1.0 - p.omega);
    let error = |steps: usize| {
        let mut state = Material::<f64>::start(&tnt, [0.0; 3]);
        let mut stress = 0.0;
        let now = |before: f64, after: f64| Now {
            velocity_gradient: [[0.0; 3]; 3],
            dt: 1.0,
            time: 1e3,
            volume_before: before,
            volume: after,
            viscosity: 0.0,
            cell: 1.0,
        };
        // A step at rest burns it.
        tnt.update(&now(1.0, 1.0), &mut state).unwrap();
        for k in 0..steps {
            let at = |k: usize| 1.0 + 3.0 * k as f64 / steps as f64;
            stress = tnt.update(&now(at(k), at(k + 1)), &mut state).unwrap().0[0];
        }
        (-stress / closed - 1.0).abs()
    };
    let errors = [100, 200, 400].map(error);
    assert!(errors[2] < 1e-4, "{errors:?}");
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.2, "{errors:?}");
    }
}
