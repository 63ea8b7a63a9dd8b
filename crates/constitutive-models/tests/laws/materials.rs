//! Jets through every material against differences, by every parameter.

use constitutive_models::tensor::{Symmetric, volume_change};
use constitutive_models::{
    Detonation, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, LinearElasticParameters,
    LinearElasticSolid, Material, MieGruneisen, NeoHookean, NeoHookeanParameters, Now, Observed,
    Solid, StiffenedGas, StiffenedGasParameters, TensionCutOff, Units, VonMises,
    VonMisesParameters, library,
};
use perturbation_moments::{Jet, Scalar};

/// A number type that materials take.
pub(super) trait Number: Scalar + std::fmt::Debug + Send + Sync {}
impl<S: Scalar + std::fmt::Debug + Send + Sync> Number for S {}

/// A material by its parameters, each given by `of` from its value.
trait Case {
    type Material<S: Number>: Material<S>;
    /// How many parameters do not act on this path, such as the slopes of the Hugoniot in tension: else a comparison of
    /// zeros would pass.
    const WITHOUT_EFFECT: usize;
    /// Whether it yields on the path.
    const YIELDS: bool;
    fn make<S: Number>(of: impl FnMut(f64) -> S) -> Self::Material<S>;
    /// The velocity gradient of step `k` of 80 (1/us).
    fn gradient(k: usize) -> [[f64; 3]; 3] {
        compression(k)
    }
}

/// Compression with shear and spin, a little different in each step; about a tenth of strain after 80 steps of 0.05 us.
fn compression(k: usize) -> [[f64; 3]; 3] {
    let wave = (0.05 * k as f64).sin();
    [[-0.02 - 0.004 * wave, 0.011, 0.002], [0.004 * wave, -0.005, 0.006], [-0.003, 0.001, 0.002]]
}

fn extension(k: usize) -> [[f64; 3]; 3] {
    compression(k).map(|row| row.map(|entry| -0.12 * entry))
}

/// The same without leaving the plane, where the spin has one angle.
fn in_plane(k: usize) -> [[f64; 3]; 3] {
    let [x, y, _] = compression(k);
    [[x[0], x[1], 0.0], [y[0], y[1], 0.0], [0.0; 3]]
}

const STEPS: usize = 80;

/// Stress, what is observed, and the wave speed after the path.
fn driven<C: Case, S: Number>(of: impl FnMut(f64) -> S) -> [S; 13] {
    after_history::<C, S>(&C::make(of))
}

/// Compiled once for each number, not for each way to make the material.
#[inline(never)]
fn after_history<C: Case, S: Number>(material: &C::Material<S>) -> [S; 13] {
    let mut state = material.start([0.3, 0.1, 0.0]);
    let (mut stress, mut volume) = (Symmetric::zero(), 1.0);
    let dt = 0.05;
    for k in 0..STEPS {
        let gradient = C::gradient(k);
        let after = volume * volume_change(&gradient, dt);
        let now = Now {
            velocity_gradient: gradient.map(|row| row.map(S::constant)),
            dt,
            time: (k + 1) as f64 * dt,
            volume_before: S::constant(volume),
            volume: S::constant(after),
            viscosity: S::constant(if after < volume { 1e-4 } else { 0.0 }),
            cell: 2.0,
        };
        stress = material.update(&now, &mut state).unwrap();
        volume = after;
    }
    let Observed { energy, plastic_strain, flow_stress, temperature, damage, overshoot } =
        material.observe(&state);
    let [s0, s1, s2, s3, s4, s5] = stress.0;
    let speed = material.wave_speed(S::constant(volume), &state);
    [
        s0,
        s1,
        s2,
        s3,
        s4,
        s5,
        energy,
        plastic_strain,
        flow_stress,
        temperature,
        damage,
        overshoot,
        speed,
    ]
}

/// What a material does with a parameter as a jet, and with a little more and a little less of it.
struct Responses {
    jet: [Jet; 13],
    above: [f64; 13],
    below: [f64; 13],
    jet_above: [Jet; 13],
    jet_below: [Jet; 13],
}

impl Responses {
    /// Compares the derivatives by parameter `i` with differences; whether the parameter has no effect.
    fn derivatives_are_right(&self, (i, weight, h): (usize, f64, f64), plain: &[f64; 13]) -> bool {
        let Self { jet, above, below, jet_above, jet_below } = self;
        // The components of a stress have one scale, and so has the overshoot.
        let stress = plain[..6].iter().fold(0.0_f64, |largest, s| largest.max(s.abs()));
        let scale = |j: usize| if j < 6 || j == 11 { stress } else { plain[j].abs() };
        let lane = i % 8;
        for j in 0..plain.len() {
            let first = (above[j] - below[j]) / (2.0 * h);
            let second = (jet_above[j].first[lane] - jet_below[j].first[lane]) / (2.0 * h);
            // Truncation 1e-10 times a third derivative, roundoff 1e-16/1e-5 of a history of 80 steps.
            let error = weight * (jet[j].first[lane] - first).abs();
            assert!(error <= 1e-6 * scale(j), "parameter {i}, output {j}: {error:e}, {}", scale(j));
            let error = weight * weight * (jet[j].second[lane] - second).abs();
            assert!(
                error <= 1e-5 * scale(j),
                "second, parameter {i}, output {j}: {error:e}, {}",
                scale(j)
            );
            assert!((jet[j].value - plain[j]).abs() <= 1e-12 * scale(j).max(1e-300));
        }
        jet.iter().all(|y| y.first[lane] == 0.0)
    }
}

fn jets_are_right<C: Case>() {
    let mut values = Vec::new();
    let plain = driven::<C, f64>(|value| {
        values.push(value);
        value
    });
    assert!(plain.iter().all(|y| y.is_finite()));
    let mut without_effect = 0;
    for (i, &value) in values.iter().enumerate() {
        let weight = if value == 0.0 { 1.0 } else { value.abs() };
        let h = 1e-5 * weight;
        let with = |step: f64| {
            let mut k = 0;
            move |v: f64| {
                k += 1;
                if k - 1 == i { v + step } else { v }
            }
        };
        let jet_with = |step: f64| {
            let mut k = 0;
            move |v: f64| {
                k += 1;
                if k - 1 == i { Jet::variable(v + step, i % 8) } else { Jet::constant(v) }
            }
        };
        let jet = driven::<C, Jet>(jet_with(0.0));
        let (above, below) = (driven::<C, f64>(with(h)), driven::<C, f64>(with(-h)));
        let (jet_above, jet_below) =
            (driven::<C, Jet>(jet_with(h)), driven::<C, Jet>(jet_with(-h)));
        let responses = Responses { jet, above, below, jet_above, jet_below };
        without_effect += usize::from(responses.derivatives_are_right((i, weight, h), &plain));
    }
    assert_eq!(without_effect, C::WITHOUT_EFFECT);
    assert_eq!(plain[7] > 0.0, C::YIELDS);
}

pub(super) const CGU: Units = Units::CM_G_US;

macro_rules! case {
    (
        $test:ident, $name:ident, $without:literal, $yields:literal,
        $material:ty,
        $of:ident => $make:expr $(, $gradient:ident)?
    ) => {
        struct $name;
        impl Case for $name {
            type Material<S: Number> = $material;
            const WITHOUT_EFFECT: usize = $without;
            const YIELDS: bool = $yields;
            #[allow(unused_mut, reason = "some cases hand it on")]
            fn make<S: Number>(mut $of: impl FnMut(f64) -> S) -> Self::Material<S> {
                $make
            }
            $(fn gradient(k: usize) -> [[f64; 3]; 3] {
                $gradient(k)
            })?
        }
        #[test]
        fn $test() {
            jets_are_right::<$name>();
        }
    };
}

fn steel<S: Number>(of: &mut impl FnMut(f64) -> S) -> MieGruneisen<S> {
    MieGruneisen::new(library::steel_equation(CGU).map(|_, v| of(v))).unwrap()
}

fn breaking<S: Number>(
    mut of: impl FnMut(f64) -> S,
) -> Solid<MieGruneisen<S>, JohnsonCookDamage<S>> {
    let equation = steel(&mut of);
    let flow = library::steel_strength(CGU).map(|_, v| of(v));
    let damage = library::steel_damage(CGU).map(|_, v| of(v));
    Solid { equation, strength: JohnsonCookDamage::new(flow, damage).unwrap() }
}

fn water<S: Number>(
    mut of: impl FnMut(f64) -> S,
) -> Solid<TensionCutOff<MieGruneisen<S>, S>, Fluid> {
    let water = MieGruneisen::new(library::water(CGU).map(|_, v| of(v))).unwrap();
    Solid { equation: TensionCutOff::new(water, of(1e-6)).unwrap(), strength: Fluid }
}

case!(
    jets_through_johnson_cook_steel, Steel, 1, true,
    Solid<MieGruneisen<S>, JohnsonCook<S>>,
    of => Solid {
        equation: steel(&mut of),
        strength: JohnsonCook::new(library::steel_strength(CGU).map(|_, v| of(v))).unwrap(),
    }
);
case!(
    jets_through_the_published_steel, Published, 6, true,
    Solid<MieGruneisen<S>, JohnsonCook<S>>,
    of => {
        let equation = steel(&mut of);
        let strength = library::steel_strength_as_published(CGU).map(|name, v| {
            // At chi = 0 a difference would leave its range.
            if name == "taylor_quinney" { S::constant(v) } else { of(v) }
        });
        Solid { equation, strength: JohnsonCook::new(strength).unwrap() }
    }
);
case!(
    jets_through_damage, Breaking, 2, true,
    Solid<MieGruneisen<S>, JohnsonCookDamage<S>>,
    of => breaking(of)
);
case!(
    jets_through_damage_in_tension, Torn, 5, true,
    Solid<MieGruneisen<S>, JohnsonCookDamage<S>>,
    of => breaking(of),
    extension
);
case!(
    jets_through_von_mises, Yielding, 0, true,
    Solid<MieGruneisen<S>, VonMises<S>>,
    of => {
        let copper =
            VonMisesParameters { shear_modulus: 0.43, yield_stress: 2e-3, hardening_modulus: 3e-3 };
        let equation = library::copper_equation(CGU).map(|_, v| of(v));
        Solid {
            equation: MieGruneisen::new(equation).unwrap(),
            strength: VonMises::new(copper.map(|_, v| of(v))).unwrap(),
        }
    },
    in_plane
);
case!(
    jets_through_water, Water, 1, false,
    Solid<TensionCutOff<MieGruneisen<S>, S>, Fluid>,
    of => water(of)
);
case!(
    jets_through_cavitating_water, Open, 3, false,
    Solid<TensionCutOff<MieGruneisen<S>, S>, Fluid>,
    of => water(of),
    extension
);
case!(
    jets_through_tnt_in_its_burn_front, Tnt, 0, false,
    Solid<Jwl<S>, Fluid>,
    of => {
        let lit = Detonation { point: [-1.0, 0.0, 0.0], cells: 1.0 };
        let equation = Jwl::new(library::tnt(CGU).map(|_, v| of(v)), lit).unwrap();
        Solid { equation, strength: Fluid }
    }
);
case!(
    jets_through_a_gas, Gas, 0, false,
    Solid<StiffenedGas<S>, Fluid>,
    of => {
        let gas = StiffenedGasParameters {
            density: 1.0,
            exponent: 4.4,
            stiffness: 6e-3,
            pressure: 1e-6,
        };
        Solid { equation: StiffenedGas::new(gas.map(|_, v| of(v))).unwrap(), strength: Fluid }
    }
);
case!(
    jets_through_linear_elasticity, Elastic, 0, false,
    LinearElasticSolid<S>,
    of => {
        let steel =
            LinearElasticParameters { density: 7.8, young_modulus: 2.0, poisson_ratio: 0.29 };
        LinearElasticSolid::linear_elastic(steel.map(|_, v| of(v))).unwrap()
    }
);
case!(
    jets_through_rubber, Rubber, 0, false,
    NeoHookean<S>,
    of => {
        let rubber = NeoHookeanParameters { density: 1.1, shear_modulus: 0.01, bulk_modulus: 0.05 };
        NeoHookean::new(rubber.map(|_, v| of(v))).unwrap()
    }
);
