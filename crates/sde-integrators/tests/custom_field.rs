//! A field, a factor of its noise and a method for it, as a user writes them.
#![cfg(feature = "dense")]

use sde_integrators::{
    Additive, DenseFactor, DiagonalFactor, Error, EulerMaruyama, FieldIncrement, FieldIntegrator,
    FieldPath, FieldSde, Heun, Integrator, LeimkuhlerMatthews, LowRankFactor, Noise, NoiseFactor,
    Sde, Shark, SkRock, SparseFactor, Sra1, Sra3, StepError, TamedEuler, Workspace,
};

/// Three masses on a line with springs that harden, noise correlated by `L` and growing in time; as a field and as a
/// small state.
struct Chain<F> {
    factor: F,
    rows: [[f64; 3]; 3],
}

fn force(x: &[f64], i: usize) -> f64 {
    let left = if i > 0 { x[i - 1] } else { 0.0 };
    let right = if i < 2 { x[i + 1] } else { 0.0 };
    left - 2.0 * x[i] + right - 0.3 * x[i].powi(3)
}

fn growth(t: f64) -> f64 {
    0.5 + 0.3 * t
}

impl<F: NoiseFactor> FieldSde for Chain<F> {
    type Factor = F;

    fn drift(&self, t: f64, x: &[f64], drift: &mut [f64]) {
        for (i, f) in drift.iter_mut().enumerate() {
            *f = force(x, i) + t;
        }
    }

    fn factor(&self) -> &F {
        &self.factor
    }

    fn intensity(&self, t: f64) -> f64 {
        growth(t)
    }
}

impl<F: NoiseFactor> Sde<3, 3> for Chain<F> {
    type Noise = Additive;

    fn drift(&self, t: f64, x: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| force(x, i) + t)
    }

    fn noise(&self, t: f64, _x: &[f64; 3]) -> [[f64; 3]; 3] {
        self.rows.map(|row| row.map(|l| growth(t) * l))
    }
}

/// A lower triangle, and its product with its transpose.
const L: [[f64; 3]; 3] = [[0.8, 0.0, 0.0], [0.3, 0.6, 0.0], [-0.1, 0.2, 0.5]];

fn covariance() -> Vec<f64> {
    let dot = |i: usize, j: usize| (0..3).map(|k| L[i][k] * L[j][k]).sum();
    (0..9).map(|k| dot(k / 3, k % 3)).collect()
}

/// After 50 steps the field and the small state agree within roundoff: sums in another order, 1e-13.
fn same_as_small<I>(method: &I, factor: impl NoiseFactor, name: &str)
where
    I: FieldIntegrator,
    I: Integrator<Chain<DiagonalFactor>, 3, 3>,
{
    let small = Chain {
        factor: DiagonalFactor::new(vec![1.0; 3]).expect("a path of finite states"),
        rows: L,
    };
    let field = Chain { factor, rows: L };
    let (noise, dt, start) = (Noise::new(9), 0.05, [0.4, -0.2, 0.1]);
    let mut path =
        FieldPath::new(&field, method, &noise, 3, start.to_vec()).expect("a path of finite states");
    let (mut increments, mut x) = (noise.path::<3>(3), start);
    let mut memory = <I as Integrator<Chain<DiagonalFactor>, 3, 3>>::Memory::default();
    for _ in 0..50 {
        let dw = increments.next_increment(dt);
        Integrator::step(method, &small, path.time(), dt, &dw, &mut x, &mut memory)
            .expect("a path of finite states");
        path.step(dt).expect("a path of finite states");
    }
    for (a, b) in path.state().iter().zip(x) {
        assert!((a - b).abs() < 1e-13 && b.abs() > 1e-3, "{name}: {a} and {b}");
    }
    assert_eq!(path.steps(), 50);
}

#[test]
fn a_field_sees_the_noise_and_the_method_of_a_small_state() {
    let dense = || DenseFactor::new(3, &covariance()).unwrap();
    same_as_small(&EulerMaruyama, dense(), "Euler-Maruyama");
    same_as_small(&Heun, dense(), "Heun");
    same_as_small(&Sra1, dense(), "SRA1");
    same_as_small(&Sra3, dense(), "SRA3");
    same_as_small(&Shark, dense(), "ShARK");
    same_as_small(&TamedEuler, dense(), "tamed Euler");
    same_as_small(&LeimkuhlerMatthews, dense(), "Leimkuhler-Matthews");
    same_as_small(&SkRock::new(4).unwrap(), dense(), "SK-ROCK");
    let columns = (0..3).flat_map(|j| L.map(|row| row[j])).collect();
    same_as_small(&Shark, LowRankFactor::new(3, columns).unwrap(), "low rank");
    let sparse = SparseFactor::new(
        3,
        vec![0, 1, 3, 6],
        vec![0, 0, 1, 0, 1, 2],
        vec![0.8, 0.3, 0.6, -0.1, 0.2, 0.5],
    );
    same_as_small(&Shark, sparse.unwrap(), "sparse");
}

/// A moving average over neighbours, never stored.
struct MovingAverage(usize);

impl NoiseFactor for MovingAverage {
    fn n_unknowns(&self) -> usize {
        self.0
    }

    fn n_motions(&self) -> usize {
        self.0 + 1
    }

    fn apply(&self, z: &[f64], result: &mut [f64]) {
        for (result, pair) in result.iter_mut().zip(z.windows(2)) {
            *result = 0.5 * (pair[0] + pair[1]);
        }
    }

    fn apply_transposed(&self, x: &[f64], result: &mut [f64]) {
        result.fill(0.0);
        for (i, x) in x.iter().enumerate() {
            result[i] += 0.5 * x;
            result[i + 1] += 0.5 * x;
        }
    }
}

/// Unknowns that only the noise moves, faster with time.
struct Drifting(MovingAverage);

impl FieldSde for Drifting {
    type Factor = MovingAverage;

    fn drift(&self, _t: f64, _x: &[f64], drift: &mut [f64]) {
        drift.fill(0.0);
    }

    fn factor(&self) -> &MovingAverage {
        &self.0
    }
}

/// Euler with a limit on the step.
struct Careful;

impl FieldIntegrator for Careful {
    type Memory = ();

    fn step<S: FieldSde + ?Sized>(
        &self,
        system: &S,
        t: f64,
        dt: f64,
        dw: FieldIncrement<'_>,
        x: &mut [f64],
        workspace: &mut Workspace,
        (): &mut (),
    ) -> Result<(), StepError> {
        if dt > 1.0 {
            return Err(StepError::StepTooLong { dt, limit: 1.0 });
        }
        let [drift] = workspace.buffers(x.len());
        system.drift(t, x, drift);
        for i in 0..x.len() {
            x[i] += dt * drift[i] + dw.brownian[i];
        }
        Ok(())
    }
}

/// Variance `t/2` and correlation 1/2 of neighbours. Of 100,000 unknowns, of which every second is independent, both
/// are known to about `sqrt(3/1e5)` = 0.0055 of the variance; four of these.
#[test]
fn a_factor_and_a_method_of_ones_own() {
    let system = Drifting(MovingAverage(100_000));
    let mut path =
        FieldPath::new(&system, &Careful, &Noise::new(2), 0, vec![0.0; 100_000]).unwrap();
    for _ in 0..4 {
        path.step(0.5).unwrap();
    }
    let x = path.state();
    let variance = x.iter().map(|x| x * x).sum::<f64>() / 1e5;
    let neighbours = x.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 1e5;
    assert!((variance - 1.0).abs() < 0.022, "{variance}");
    assert!((neighbours - 0.5).abs() < 0.022, "{neighbours}");
    let before = x.to_vec();
    let error = path.step(2.0).unwrap_err();
    assert!(matches!(error, Error::Step { realisation: 0, step: 4, .. }), "{error}");
    assert_eq!(path.state(), before);
}

/// `x' = x^3` with a large step.
struct Cubic(DiagonalFactor);

impl FieldSde for Cubic {
    type Factor = DiagonalFactor;

    fn drift(&self, _t: f64, x: &[f64], drift: &mut [f64]) {
        drift.iter_mut().zip(x).for_each(|(f, x)| *f = -x * x * x);
    }

    fn factor(&self) -> &DiagonalFactor {
        &self.0
    }
}

#[test]
fn an_explosion_names_path_step_time_and_unknown_and_leaves_the_state() {
    let system = Cubic(DiagonalFactor::new(vec![0.0; 3]).unwrap());
    // Beyond sqrt(2/h) = 4.47 the state grows; the second unknown is the one beyond.
    let start = vec![1.0, 5.0, -1.0];
    let mut path = FieldPath::new(&system, &EulerMaruyama, &Noise::new(1), 17, start).unwrap();
    let error = loop {
        let before = path.state().to_vec();
        if let Err(error) = path.step(0.1) {
            assert_eq!(path.state(), before);
            break error;
        }
    };
    let Error::NonFiniteState { realisation, steps, t, component, value } = error else {
        unreachable!("{error}")
    };
    assert_eq!((realisation, component, steps), (17, 1, path.steps() + 1));
    assert!((t - 0.1 * steps as f64).abs() < 1e-12 && !value.is_finite());
}

#[test]
fn bad_factors_are_refused_with_the_place() {
    assert!(matches!(
        DenseFactor::new(2, &[1.0, 2.0, 2.0, 1.0]),
        Err(Error::CovarianceNotPositiveDefinite { row: 1 })
    ));
    assert!(matches!(
        DenseFactor::new(2, &[1.0, 0.5, 0.4, 1.0]),
        Err(Error::CovarianceNotSymmetric { row: 1, column: 0, .. })
    ));
    assert!(matches!(DenseFactor::new(2, &[1.0; 3]), Err(Error::Length { expected: 4, .. })));
    assert!(matches!(
        DiagonalFactor::new(vec![1.0, f64::NAN]),
        Err(Error::NotFinite { index: 1, .. })
    ));
    assert!(matches!(LowRankFactor::new(3, vec![1.0; 4]), Err(Error::Length { expected: 6, .. })));
    assert!(matches!(LowRankFactor::new(0, vec![]), Err(Error::TooFew { .. })));
    let sparse = |starts: &[usize], columns: &[usize]| {
        SparseFactor::new(2, starts.to_vec(), columns.to_vec(), vec![1.0; columns.len()])
    };
    assert!(sparse(&[0, 1, 2], &[0, 1]).is_ok());
    assert!(matches!(sparse(&[0, 2, 1], &[0, 1]), Err(Error::SparseRow { row: 2, .. })));
    assert!(matches!(sparse(&[0, 1], &[0, 1]), Err(Error::SparseRow { row: 1, .. })));
    assert!(matches!(sparse(&[1, 2], &[0, 1]), Err(Error::SparseRow { row: 0, .. })));
    assert!(matches!(
        sparse(&[0, 1, 2], &[0, 2]),
        Err(Error::SparseColumn { entry: 1, column: 2, .. })
    ));
    assert!(matches!(
        FieldPath::new(
            &Cubic(DiagonalFactor::new(vec![1.0; 3]).unwrap()),
            &Heun,
            &Noise::new(1),
            0,
            vec![0.0; 2]
        ),
        Err(Error::Length { value: 2, expected: 3, .. })
    ));
}
