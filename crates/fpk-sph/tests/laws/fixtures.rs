//! What several laws start from.

use fpk_sph::{Combination, Config, DEFAULT_MOST_STEPS, InitialLattice, Method, Simulation};
use sde_integrators::{Additive, GaussianComponent, GaussianMixture, Sde};
use vibrating_systems::{
    Filter, Filtered, KanaiTajimiParameters, LinearOscillator, LinearOscillatorParameters,
    ViscousDamper, ViscousDamperParameters, Window,
};

/// The building of Canor & Denoël 2013, section 4.1.
pub(crate) const BUILDING: LinearOscillatorParameters = LinearOscillatorParameters {
    natural_frequency: std::f64::consts::PI,
    damping_ratio: 0.01,
    noise_intensity: 0.2,
    window: Window::CANOR_DENOEL_2013,
};

/// [`BUILDING`] with its damper.
pub(crate) fn damper() -> ViscousDamper {
    let (structure, damper_coefficient, damper_exponent) = (BUILDING, 0.25, 0.35);
    ViscousDamper::new(ViscousDamperParameters { structure, damper_coefficient, damper_exponent })
        .unwrap()
}

/// Where [`damper`] starts.
pub(crate) fn law() -> GaussianMixture<2> {
    GaussianMixture::independent([0.0, 0.0], [0.15, 0.10]).unwrap()
}

/// Two Gaussians with this covariance, around 0 and around 0.3.
pub(crate) fn two_gaussians(weights: [f64; 2], covariance: [[f64; 2]; 2]) -> GaussianMixture<2> {
    let component = |k: usize| GaussianComponent {
        weight: weights[k],
        mean: [0.3 * k as f64, 0.0],
        covariance,
    };
    GaussianMixture::mixture(&[component(0), component(1)]).unwrap()
}

/// A linear oscillator under noise that does not change.
pub(crate) fn oscillator(
    frequency: f64,
    damping_ratio: f64,
    noise_intensity: f64,
) -> LinearOscillator {
    LinearOscillator::new(LinearOscillatorParameters {
        natural_frequency: frequency,
        damping_ratio,
        noise_intensity,
        window: Window::Stationary,
    })
    .unwrap()
}

/// A cubic spring and a quadratic damper: `q'' + 2 xi w q' + h |q'| q' + w^2 (q + e q^3) = a(t) u`.
#[derive(Debug, Clone)]
pub(crate) struct CubicSpring;

impl Sde<2, 1> for CubicSpring {
    type Noise = Additive;

    fn drift(&self, _: f64, &[q, v]: &[f64; 2]) -> [f64; 2] {
        let stiffness = std::f64::consts::PI.powi(2);
        let damping = 0.04 * std::f64::consts::PI * v + 0.5 * v.abs() * v;
        [v, -damping - stiffness * (q + 5.0 * q.powi(3))]
    }

    fn noise(&self, t: f64, _: &[f64; 2]) -> [[f64; 1]; 2] {
        [[0.0], [Window::CANOR_DENOEL_2013.amplitude(t) * 0.4_f64.sqrt()]]
    }
}

/// A structure on soil that filters the noise.
pub(crate) fn behind_soil<S: Sde<DS, 1, Noise = Additive>, const DS: usize>(
    structure: S,
) -> Filtered<S, DS, 2> {
    let soil = KanaiTajimiParameters { ground_frequency: 15.6, ground_damping: 0.6 };
    Filtered::new(structure, Filter::kanai_tajimi(soil).unwrap(), Window::Stationary).unwrap()
}

/// The flow-map fit with as many steps as a run may take.
pub(crate) fn config<const D: usize>(
    lattice: InitialLattice<D>,
    reference_period: f64,
) -> Config<D> {
    let (method, most_steps) = (Method::FlowMapFit, DEFAULT_MOST_STEPS);
    Config { method, lattice, reference_period, most_steps }
}

/// The flow-map fit with a change.
pub(crate) fn changed(change: impl Fn(&mut Combination)) -> Method {
    let mut combination = Method::FlowMapFit.combination();
    change(&mut combination);
    Method::Custom(combination)
}

/// `E[x x^T]` of a linear system with additive noise, by its moment equations and Runge-Kutta 4 in 20,000 steps.
pub(crate) fn exact_moments<const D: usize, const M: usize>(
    system: &impl Sde<D, M>,
    law: &GaussianMixture<D>,
    until: f64,
) -> [[f64; D]; D] {
    let (mean, mut moments) = (law.mean(), law.covariance());
    for k in 0..D {
        for l in 0..D {
            moments[k][l] += mean[k] * mean[l];
        }
    }
    let unit = |l: usize| std::array::from_fn(|k| f64::from(u8::from(k == l)));
    let rate = |t: f64, p: &[[f64; D]; D]| -> [[f64; D]; D] {
        let columns: [[f64; D]; D] = std::array::from_fn(|l| system.drift(t, &unit(l)));
        let noise = system.diffusion(t, &[0.0; D]);
        let moved = |k: usize, l: usize| -> f64 { (0..D).map(|m| columns[m][k] * p[m][l]).sum() };
        std::array::from_fn(|k| {
            std::array::from_fn(|l| moved(k, l) + moved(l, k) + 2.0 * noise[k][l])
        })
    };
    let n = 20_000;
    let dt = until / f64::from(n);
    let plus = |p: &[[f64; D]; D], c: f64, k: &[[f64; D]; D]| -> [[f64; D]; D] {
        std::array::from_fn(|i| std::array::from_fn(|j| p[i][j] + c * k[i][j]))
    };
    for step in 0..n {
        let t = dt * f64::from(step);
        let k_1 = rate(t, &moments);
        let k_2 = rate(t + dt / 2.0, &plus(&moments, dt / 2.0, &k_1));
        let k_3 = rate(t + dt / 2.0, &plus(&moments, dt / 2.0, &k_2));
        let k_4 = rate(t + dt, &plus(&moments, dt, &k_3));
        for (c, k) in [(1.0, k_1), (2.0, k_2), (2.0, k_3), (1.0, k_4)] {
            moments = plus(&moments, c * dt / 6.0, &k);
        }
    }
    moments
}

pub(crate) fn on_threads<T: Send>(threads: usize, run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

/// Positions and masses, bit by bit.
pub(crate) fn bits<S: Sde<D, M>, const D: usize, const M: usize>(
    simulation: &Simulation<S, D, M>,
) -> Vec<u64> {
    let positions = simulation.positions().as_flattened();
    positions.iter().chain(simulation.masses()).map(|x| x.to_bits()).collect()
}

/// Runs are bitwise identical on any number of threads, through both times or from a snapshot at the first of them.
pub(crate) fn same_bits<S: Sde<2, 1>>(
    new: impl Fn() -> Simulation<S, 2, 1> + Sync,
    [middle, end]: [f64; 2],
) {
    let at_end = |mut simulation: Simulation<S, 2, 1>| {
        simulation.advance_to(end).unwrap();
        (bits(&simulation), simulation.work().steps)
    };
    let whole = || {
        let mut simulation = new();
        simulation.advance_to(middle).unwrap();
        at_end(simulation)
    };
    let resumed = || {
        let (mut first, mut second, mut snapshot) = (new(), new(), Vec::new());
        first.advance_to(middle).unwrap();
        first.snapshot(&mut snapshot).unwrap();
        second.restore(snapshot.as_slice()).unwrap();
        at_end(second)
    };
    let one = on_threads(1, whole);
    for threads in [1, 2, 8] {
        assert!(on_threads(threads, whole) == one, "{threads} threads");
        assert!(on_threads(threads, resumed) == one, "{threads} threads, after a restart");
    }
}
