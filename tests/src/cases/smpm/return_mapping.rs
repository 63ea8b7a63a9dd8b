//! The radial return of von Mises plasticity against closed forms: one direction, the opposite one, a right angle.

use perturbation_moments::{Jet, Scalar};
use reference_problems::order;
use result_figures::{ErrorKind, Reference};
use smpm::Number;
use smpm::material::{Now, Strength, VonMises, VonMisesParameters, VonMisesState};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::cases::lines::Lines;
use crate::cases::worst::Worst;
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smpm/return-mapping",
    title: "A point of von Mises material, strained one way, back, and at a right angle",
    source: "Chen et al. 2019, eq 13-20; closed forms: one direction by hand, a turn after Krieg and Krieg 1977, with hardening",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Megapascal. The hardening is strong, so that a wrong share of it shows.
const METAL: VonMisesParameters<f64> =
    VonMisesParameters { shear_modulus: 77500.0, yield_stress: 800.0, hardening_modulus: 20_000.0 };

/// Axial, and shear at a right angle to it: deviators of the same norm, `sqrt(3/2)`.
const AXIAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5]];
const SHEAR: [[f64; 3]; 3] =
    [[0.0, HALF_ROOT_OF_THREE, 0.0], [HALF_ROOT_OF_THREE, 0.0, 0.0], [0.0; 3]];
const HALF_ROOT_OF_THREE: f64 = 0.866_025_403_784_438_6;

/// Strain along the axis, before any other path.
const FIRST: f64 = 0.05;
/// Strain back along the axis.
const BACK: f64 = 0.04;

/// Adds an equivalent strain along a direction in equal steps.
fn strain<S: Number>(
    material: &VonMises<S>,
    state: &mut VonMisesState<S>,
    direction: &[[f64; 3]; 3],
    (strain, n_steps): (f64, usize),
) -> Result<(), CaseError> {
    let rate = direction.map(|row| row.map(<S as Scalar>::constant));
    let dt = strain / n_steps as f64;
    let (one, zero) = (<S as Scalar>::constant(1.0), <S as Scalar>::constant(0.0));
    let (volume_before, volume, viscosity) = (one, one, zero);
    let now =
        Now { velocity_gradient: rate, dt, time: 0.0, volume_before, volume, viscosity, cell: 1.0 };
    for _ in 0..n_steps {
        material
            .update(&now, state)
            .map_err(|fault| format!("{}: {}", fault.quantity, fault.value))?;
    }
    Ok(())
}

/// The plastic strain after the first path and, if asked for, the way back: `sigma = 3 G (eps - eps_p) = Y + H eps_p` on the
/// way there, and back again from `sigma` to `-sigma` elastically.
fn closed<S: Number>([g, y, h]: [S; 3], back: bool) -> S {
    let three_g = g * 3.0;
    let first = (three_g * FIRST - y) / (three_g + h);
    let turned = y + h * first;
    if back { first + (three_g * BACK - turned * 2.0) / (three_g + h) } else { first }
}

/// Largest relative errors of the plastic strain and of its derivatives by `G`, `Y` and `H` over numbers of steps.
fn proportional(context: &Context<'_>, name: &str, back: bool) -> Result<[Claim; 2], CaseError> {
    let VonMisesParameters { shear_modulus, yield_stress, hardening_modulus } = METAL;
    let mean = [shear_modulus, yield_stress, hardening_modulus];
    let parameters: [Jet; 3] = std::array::from_fn(|k| Jet::variable(mean[k], k));
    let [shear_modulus, yield_stress, hardening_modulus] = parameters;
    let material =
        VonMises::new(VonMisesParameters { shear_modulus, yield_stress, hardening_modulus })?;
    let exact = closed(parameters, back);
    let (mut value, mut slope) = (Worst::of_errors(), Worst::of_errors());
    for n_steps in [1, 7, 50] {
        let mut state = Strength::<Jet>::start(&material);
        strain(&material, &mut state, &AXIAL, (FIRST, n_steps))?;
        if back {
            strain(&material, &mut state, &AXIAL.map(|row| row.map(|x| -x)), (BACK, n_steps))?;
        }
        let place = format!("{n_steps} steps");
        value.take(state.plastic_strain.value / exact.value - 1.0, &place);
        for (found, exact) in state.plastic_strain.first.iter().zip(exact.first).take(3) {
            slope.take(found / exact - 1.0, &place);
        }
    }
    let lines = |worst: &Worst| Lines { context, id: name, method: worst.method("radial return") };
    let reason = "roundoff: along one direction the return is exact for any step";
    Ok([
        lines(&value).bounded(
            ("plastic-strain", "relative error of the plastic strain", ""),
            value.value(),
            1e-12,
            reason,
        ),
        lines(&slope).bounded(
            ("slopes", "relative error of its derivatives by G, Y and H", ""),
            slope.value(),
            1e-11,
            reason,
        ),
    ])
}

/// The angle between stress and strain rate at the end of the turn.
const LAST_ANGLE: f64 = std::f64::consts::PI / 6.0;

/// The turn: with `beta = H/(3 G + H)` the flow stress is `sigma_0 sin(psi)^-beta` once the angle between stress and strain
/// rate has come from a right one down to `psi`, after the equivalent strain
/// `sigma_0/(3 G) * integral from psi to pi/2 of sin^-(1 + beta)`. Krieg and Krieg have it for `H = 0`.
struct Turn {
    flow_stress: f64,
    strain: f64,
}

impl Turn {
    fn exact() -> Self {
        let three_g = 3.0 * METAL.shear_modulus;
        let beta = METAL.hardening_modulus / (three_g + METAL.hardening_modulus);
        let first = METAL.yield_stress
            + METAL.hardening_modulus
                * closed([METAL.shear_modulus, METAL.yield_stress, METAL.hardening_modulus], false);
        // Simpson's rule: the integrand is smooth, its error far below a part in 1e12.
        let (n, from) = (2000, LAST_ANGLE);
        let width = (std::f64::consts::FRAC_PI_2 - from) / f64::from(n);
        let at = |k: i32| (from + width * f64::from(k)).sin().powf(-1.0 - beta);
        let inner: f64 = (1..n).map(|k| at(k) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
        let integral = (at(0) + inner + at(n)) * width / 3.0;
        Self {
            flow_stress: first * LAST_ANGLE.sin().powf(-beta),
            strain: first / three_g * integral,
        }
    }

    /// Errors of the flow stress, relative, and of the angle (rad), with so many steps.
    fn errors(&self, n_steps: usize) -> Result<[f64; 2], CaseError> {
        let material = VonMises::new(METAL)?;
        let mut state = Strength::<f64>::start(&material);
        strain(&material, &mut state, &AXIAL, (FIRST, 1))?;
        strain(&material, &mut state, &SHEAR, (self.strain, n_steps))?;
        let flow = Strength::<f64>::observe(&material, &state).flow_stress;
        let deviator = state.deviator.matrix();
        // In the plane of both directions: the axial and the shear part of the stress.
        let angle = deviator[0][0].atan2(deviator[0][1] / HALF_ROOT_OF_THREE);
        Ok([flow / self.flow_stress - 1.0, angle - LAST_ANGLE])
    }
}

fn turn(context: &Context<'_>) -> Result<[Claim; 3], CaseError> {
    let turn = Turn::exact();
    let mut levels = Vec::new();
    for n_steps in [50_u32, 100, 200, 400] {
        levels.push((1.0 / f64::from(n_steps), turn.errors(n_steps as usize)?));
    }
    let angles: Vec<(f64, f64)> =
        levels.iter().map(|(step, errors)| (*step, errors[1].abs())).collect();
    let [flow, angle] = levels[1].1;
    let lines = |method: &str| Lines { context, id: "turn", method: method.to_owned() };
    let reason = "backward differences along a path that bends: first order in the step";
    let subject = context.subject(
        "turn/order",
        "order of the error of the angle",
        "",
        "radial return, 50 to 400 steps over the turn",
    );
    let fitted = order::fit(&angles)?;
    let criterion = Criterion::Within { tolerance: 0.02, reason };
    Ok([
        lines("radial return, 100 steps over the turn").bounded(
            ("flow-stress", "relative error of the flow stress, turned by 60 degrees", ""),
            flow,
            2e-4,
            reason,
        ),
        lines("radial return, 100 steps over the turn").bounded(
            ("angle", "error of the angle between stress and strain rate, 30 degrees", "rad"),
            angle,
            6e-3,
            reason,
        ),
        Claim::judge(subject, ErrorKind::Order, fitted, Reference::exact(1.0), criterion),
    ])
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = proportional(context, "monotonic", false)?.to_vec();
    claims.extend(proportional(context, "back", true)?);
    claims.extend(turn(context)?);
    Ok(claims)
}
