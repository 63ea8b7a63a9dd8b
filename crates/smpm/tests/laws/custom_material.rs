//! An equation of state, a strength and a whole material as a user would write them.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined is compiled for the narrowest registers"
)]

use perturbation_moments::{Jet, Real, Scalar, when};
use smpm::material::{
    EquationFamily, EquationOfState, Fluid, Line, Material, Now, Observed, Solid, Start, Strength,
};
use smpm::tensor::Symmetric;
use smpm::{Body, Config, Fault, Fill, Simulation};

// docs: equation
/// Murnaghan 1944: `p = K/n (J^-n - 1)`.
#[derive(Debug)]
struct Murnaghan<S> {
    density: S,
    bulk_modulus: S,
    exponent: f64,
}

impl<S: Scalar + std::fmt::Debug + Send + Sync> EquationOfState<S> for Murnaghan<S> {
    type State = ();

    fn density(&self) -> S {
        self.density
    }

    fn start(&self, _position: [f64; 3]) -> Start<S, ()> {
        Start { state: (), energy: S::constant(0.0), pressure: S::constant(0.0) }
    }

    fn line(&self, volume: S) -> Line<S> {
        let stiffness = self.bulk_modulus * (1.0 / self.exponent);
        Line { a: stiffness * (volume.powf(-self.exponent) - 1.0), b: S::constant(0.0) }
    }

    fn slope(&self, volume: S) -> Line<S> {
        let a = self.bulk_modulus * volume.powf(-self.exponent - 1.0) * -1.0;
        Line { a, b: S::constant(0.0) }
    }
}
// docs: end

// docs: strength
/// `S = 2 eta dev D`.
#[derive(Debug)]
struct Newtonian<S> {
    viscosity: S,
}

impl<S: Scalar + std::fmt::Debug + Send + Sync> Strength<S> for Newtonian<S> {
    type State = Symmetric<S>;

    fn start(&self) -> Symmetric<S> {
        Symmetric::zero()
    }

    fn update(&self, now: &Now<S>, state: &mut Symmetric<S>) -> Result<S, Fault> {
        let rate = Symmetric::part_of(&now.velocity_gradient).deviator();
        *state = rate.scaled(self.viscosity * 2.0);
        Ok(state.contract(&rate) * now.volume * now.dt)
    }

    fn deviator(&self, state: &Symmetric<S>) -> Option<Symmetric<S>> {
        Some(*state)
    }

    fn shear_modulus(&self, _state: &Symmetric<S>) -> Option<S> {
        None
    }

    fn observe(&self, _state: &Symmetric<S>) -> Observed<S> {
        Observed::of_energy(S::constant(0.0))
    }
}
// docs: end

// docs: material
/// A material that bears nothing.
#[derive(Debug)]
struct Dust;

impl<S: Scalar> Material<S> for Dust {
    type State = ();

    fn density(&self) -> S {
        S::constant(1.0)
    }

    fn start(&self, _position: [f64; 3]) {}

    fn update(&self, _now: &Now<S>, _state: &mut ()) -> Result<Symmetric<S>, Fault> {
        Ok(Symmetric::zero())
    }

    fn wave_speed(&self, _volume: S, _state: &()) -> S {
        S::constant(0.0)
    }

    fn observe(&self, _state: &()) -> Observed<S> {
        Observed::of_energy(S::constant(0.0))
    }
}
// docs: end

/// A squeeze along x to `J = 0.9`.
fn squeezed<S: Scalar>() -> Now<S> {
    let c = S::constant;
    let zero = c(0.0);
    Now {
        velocity_gradient: [[c(-0.1), zero, zero], [zero; 3], [zero; 3]],
        dt: 1.0,
        time: 1.0,
        volume_before: c(1.0),
        volume: c(0.9),
        viscosity: zero,
        cell: 1.0,
    }
}

// docs: test
#[test]
fn own_pressure_and_strength_make_a_material() {
    let oil = Solid {
        equation: Murnaghan {
            density: Jet::constant(0.9),
            bulk_modulus: Jet::variable(3.0, 0),
            exponent: 4.0,
        },
        strength: Newtonian { viscosity: Jet::variable(0.2, 1) },
    };
    let mut state = oil.start([0.0; 3]);
    let stress = oil.update(&squeezed(), &mut state).unwrap().0[0];
    let pressure = 3.0 / 4.0 * (0.9_f64.powi(-4) - 1.0);
    // dev D_xx = -0.1 * 2/3.
    let viscous = -0.4 * 0.2 / 3.0;
    assert!((stress.value - (viscous - pressure)).abs() < 1e-14);
    assert!((stress.first[0] + pressure / 3.0).abs() < 1e-14);
    assert!((stress.first[1] - viscous / 0.2).abs() < 1e-14);
    // rho c^2 = K J^-n, by the bulk modulus that the trait derives.
    let speed = oil.wave_speed(Jet::constant(0.9), &state);
    assert!((speed.value - (3.0 * 0.9_f64.powi(-4) / (0.9 / 0.9)).sqrt()).abs() < 1e-14);
}
// docs: end

#[test]
fn a_whole_material_is_five_methods() {
    let stress: Symmetric<f64> = Dust.update(&squeezed(), &mut ()).unwrap();
    assert_eq!(stress, Symmetric::zero());
}

// docs: lanes
/// A liquid that bears no tension: `p = -K ln J` for `J < 1`, else none.
#[derive(Debug, Clone, Copy)]
struct Drops<S> {
    density: S,
    bulk_modulus: S,
}

impl<S: Real> EquationOfState<S> for Drops<S> {
    type State = ();

    const KNOWS_ENERGY: bool = false;

    fn density(&self) -> S {
        self.density
    }

    fn start(&self, _position: [f64; 3]) -> Start<S, ()>
    where
        S: Scalar,
    {
        Start { state: (), energy: S::constant(0.0), pressure: S::constant(0.0) }
    }

    #[inline(always)]
    fn line(&self, volume: S) -> Line<S> {
        let (zero, one) = (volume.splat(0.0), volume.splat(1.0));
        let pressure = when!(volume.less(one), -(self.bulk_modulus * volume.ln()), zero);
        Line { a: pressure, b: zero }
    }

    #[inline(always)]
    fn slope(&self, volume: S) -> Line<S> {
        let (zero, one) = (volume.splat(0.0), volume.splat(1.0));
        Line { a: when!(volume.less(one), -(self.bulk_modulus / volume), zero), b: zero }
    }
}

impl EquationFamily<f64> for Drops<f64> {
    type In<S: Real> = Drops<S>;

    fn in_numbers<S: Real>(&self, of: impl Fn(f64) -> S + Copy) -> Drops<S> {
        Drops { density: of(self.density), bulk_modulus: of(self.bulk_modulus) }
    }

    fn filled<S: Real>(&self, _number: S) {}
}
// docs: end

#[test]
fn own_material_in_lanes_is_bitwise_identical_to_one_by_one() {
    let drops = || Solid { equation: Drops { density: 1.0, bulk_modulus: 10.0 }, strength: Fluid };
    // 35 particles: not a multiple of any register.
    let fill = Fill::of([0.5; 2], ([0.0; 2], [3.5, 2.5]), |_| true).unwrap();
    let bodies = [
        Body::one_by_one(drops(), &fill, [0.0; 2]).unwrap(),
        Body::in_lanes(drops(), &fill, [0.0; 2]).unwrap(),
    ];
    let [alone, together] = bodies.map(|mut body| {
        // Squeezed on one side, torn on the other.
        body.set_velocities(|[x, y]| [0.3 * (x - 1.5) * (x - 1.5) - 0.6, 0.1 * y]).unwrap();
        let mut simulation = Simulation::new(Config::with_cell(1.0), vec![body]).unwrap();
        for _ in 0..4 {
            let _ = simulation.step().unwrap();
        }
        let body = &simulation.bodies()[0];
        let pressures: Vec<f64> = (0..35).map(|particle| body.pressure(particle)).collect();
        (body.positions().to_vec(), pressures)
    });
    assert_eq!(alone, together);
    assert!(together.1.iter().any(|&p| p > 0.0) && together.1.iter().any(|&p| p <= 0.0));
}
