//! The table of methods: a new one is a line in the list of its class.

use sde_integrators::{
    Additive, DiagonalNoise, DiagonalSde, EulerMaruyama, Heun, Increment, Integrator, Milstein,
    Sde, SecondOrder, SemiImplicitEuler, Shark, Sra3, Sriw1, StateSpace, StepError,
    StochasticTheta, StrangOscillator, StratonovichForm,
};

/// The state at the end of a path from `start`, over the given increments of equal steps of length `dt`.
pub type Run<S, const D: usize, const M: usize> =
    dyn Fn(&S, [f64; D], f64, &[Increment<M>]) -> Result<[f64; D], StepError> + Sync;

/// What a method is documented to do for a class of problems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// Strong order.
    pub strong: f64,
    /// Weak order.
    pub weak: f64,
    /// Order without noise.
    pub noise_free: f64,
}

/// A method as the harness sees it.
pub struct Method<S: ?Sized, const D: usize, const M: usize> {
    /// The name in ids, `sra1`.
    pub id: &'static str,
    /// The name for the reader.
    pub name: &'static str,
    /// Its documented orders.
    pub orders: Orders,
    /// Follows one path.
    pub run: Box<Run<S, D, M>>,
}

impl<S: ?Sized, const D: usize, const M: usize> std::fmt::Debug for Method<S, D, M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Method")
            .field("id", &self.id)
            .field("orders", &self.orders)
            .finish_non_exhaustive()
    }
}

/// The state at the end of a path.
pub fn follow<S, I, const D: usize, const M: usize>(
    system: &S,
    method: &I,
    start: [f64; D],
    dt: f64,
    increments: &[Increment<M>],
) -> Result<[f64; D], StepError>
where
    S: ?Sized,
    I: Integrator<S, D, M>,
{
    let (mut x, mut memory) = (start, I::Memory::default());
    for (n, dw) in increments.iter().enumerate() {
        method.step(system, n as f64 * dt, dt, dw, &mut x, &mut memory)?;
    }
    Ok(x)
}

/// One line of a table.
pub fn method<S, I, const D: usize, const M: usize>(
    id: &'static str,
    name: &'static str,
    integrator: I,
    [strong, weak, noise_free]: [f64; 3],
) -> Method<S, D, M>
where
    S: ?Sized + 'static,
    I: Integrator<S, D, M> + 'static,
{
    Method {
        id,
        name,
        orders: Orders { strong, weak, noise_free },
        run: Box::new(move |system, start, dt, increments| {
            follow(system, &integrator, start, dt, increments)
        }),
    }
}

/// Methods for additive noise, on a drift that is nonlinear in the noisy variable: strong, weak, noise-free order.
#[must_use]
pub fn additive<S, const D: usize, const M: usize>() -> Vec<Method<S, D, M>>
where
    S: Sde<D, M, Noise = Additive> + 'static,
{
    vec![
        method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, [1.0, 1.0, 1.0]),
        method("heun", "Heun", Heun, [1.0, 2.0, 2.0]),
        method("sra3", "SRA3", Sra3, [1.5, 2.0, 3.0]),
        method("shark", "ShARK", Shark, [1.5, 2.0, 2.0]),
        method("trapezoidal", "trapezoidal", StochasticTheta::TRAPEZOIDAL, [1.0, 2.0, 2.0]),
        method(
            "backward-euler",
            "backward Euler",
            StochasticTheta::BACKWARD_EULER,
            [1.0, 1.0, 1.0],
        ),
    ]
}

/// Methods for diagonal noise; the system is the wrapper that all of them accept.
#[must_use]
pub fn diagonal<S, const D: usize>() -> Vec<Method<DiagonalNoise<S>, D, D>>
where
    S: DiagonalSde<D> + Copy + 'static,
{
    let heun = Method {
        id: "heun",
        name: "Heun (Stratonovich form)",
        orders: Orders { strong: 1.0, weak: 1.0, noise_free: 2.0 },
        run: Box::new(|system: &DiagonalNoise<S>, start, dt, increments: &[Increment<D>]| {
            follow(&StratonovichForm(system.0), &Heun, start, dt, increments)
        }),
    };
    vec![
        method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, [0.5, 1.0, 1.0]),
        method("milstein", "Milstein", Milstein, [1.0, 1.0, 1.0]),
        heun,
        method("sriw1", "SRIW1", Sriw1, [1.5, 2.0, 2.0]),
        method("trapezoidal", "trapezoidal", StochasticTheta::TRAPEZOIDAL, [0.5, 1.0, 2.0]),
    ]
}

/// Methods for oscillators. Noise acts on the velocity and the force depends on the position, so that the methods of
/// strong order 1.5 have 2 here.
#[must_use]
pub fn second_order<S>() -> Vec<Method<StateSpace<S>, 2, 1>>
where
    S: SecondOrder<1, 1> + 'static,
{
    vec![
        method("euler-maruyama", "Euler-Maruyama", EulerMaruyama, [1.0, 1.0, 1.0]),
        method("semi-implicit-euler", "semi-implicit Euler", SemiImplicitEuler, [1.0, 1.0, 1.0]),
        method("heun", "Heun", Heun, [1.0, 2.0, 2.0]),
        method("strang-oscillator", "Strang", StrangOscillator, [1.0, 2.0, 2.0]),
        method("sra3", "SRA3", Sra3, [2.0, 2.0, 3.0]),
        method("shark", "ShARK", Shark, [2.0, 2.0, 2.0]),
        method("trapezoidal", "trapezoidal", StochasticTheta::TRAPEZOIDAL, [1.0, 2.0, 2.0]),
    ]
}
