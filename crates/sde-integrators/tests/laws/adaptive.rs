//! Steps that adapt to the path: no bias by acceptance, work saved where the drift bursts, errors by name.

use sde_integrators::{
    AdaptivePath, Additive, DiagonalSde, Error, EulerMaruyama, Increment, Integrator, Milstein,
    Noise, Sde, Shark, StepControl, StepError,
};

/// `dX = 0.2 X dt + X dB` from 1: `E X_1 = exp(0.2)`, `Var X_1 = exp(0.4) (e - 1)`.
struct Growth;

impl DiagonalSde<1> for Growth {
    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [0.2 * x[0]]
    }

    fn intensity(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [x[0]]
    }

    fn intensity_derivative(&self, _: f64, _: &[f64; 1]) -> [f64; 1] {
        [1.0]
    }
}

const CONTROL: StepControl =
    StepControl { longest: 0.25, absolute: 0.01, relative: 0.01, halvings: 12 };
const PATHS: u64 = 20_000;

fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// The same rule of acceptance with fresh increments after a rejection: what not to do. The state at 1 and the
/// Brownian motion that was accepted.
fn redrawn(realisation: u64) -> Result<(f64, f64), StepError> {
    let mut fresh = Noise::new(91).path::<1>(realisation);
    let (mut x, mut w, mut t, mut dt) = ([1.0], 0.0, 0.0, CONTROL.longest);
    while t < 1.0 {
        let halves = [fresh.next_increment(0.5 * dt), fresh.next_increment(0.5 * dt)];
        let whole = Increment::from_halves(&halves[0], &halves[1]);
        let (mut coarse, mut fine) = (x, x);
        Milstein.step(&Growth, t, dt, &whole, &mut coarse, &mut ())?;
        for half in &halves {
            Milstein.step(&Growth, t, 0.5 * dt, half, &mut fine, &mut ())?;
        }
        let size = x[0].abs().max(fine[0].abs());
        if (fine[0] - coarse[0]).abs() > CONTROL.absolute + CONTROL.relative * size {
            dt *= 0.5;
            continue;
        }
        (x, w, t) = (fine, w + whole.brownian[0], t + dt);
        // Twice as long where such a step begins: as on the tree.
        if (t / (2.0 * dt)).fract() == 0.0 && dt < CONTROL.longest {
            dt *= 2.0;
        }
    }
    Ok((x[0], w))
}

#[test]
fn acceptance_does_not_bias_the_law_and_drawing_anew_does() {
    let noise = Noise::new(90);
    let (mut ends, mut offs) = (Vec::new(), Vec::new());
    let (mut rejected, mut accepted) = (0, 0);
    for realisation in 0..PATHS {
        let mut path =
            AdaptivePath::new(&Growth, &Milstein, &noise, realisation, [1.0], &CONTROL).unwrap();
        path.run(4).unwrap();
        let mut steps = noise.path::<1>(realisation);
        let w: f64 = (0..4).map(|_| steps.next_increment(0.25).brownian[0]).sum();
        ends.push(path.state()[0]);
        offs.push(path.state()[0] - (w - 0.3).exp());
        (rejected, accepted) = (rejected + path.rejected(), accepted + path.accepted());
    }
    // Without rejections the test says nothing.
    assert!(rejected > accepted / 20, "{rejected} of {accepted}");
    let exact = 0.2_f64.exp();
    let (value, error) = mean(&ends);
    assert!((value - exact).abs() < 4.0 * error, "{value} ± {error}, exact {exact}");
    // The distance to the solution on the same path, whose noise is far smaller: the tolerance is 1 % a step.
    let (off, _) = mean(&offs);
    assert!(off.abs() < 0.01 * exact, "{off}");

    let (ends, squares): (Vec<f64>, Vec<f64>) = (0..PATHS)
        .map(|realisation| {
            let (end, w) = redrawn(realisation).unwrap();
            (end, w * w)
        })
        .unzip();
    let (value, error) = mean(&ends);
    assert!(value < exact - 10.0 * error, "drawn anew: {value} ± {error}, exact {exact}");
    let (variance, error) = mean(&squares);
    assert!(variance < 1.0 - 10.0 * error, "drawn anew: Var W = {variance} ± {error}");
}

/// `dX = -l(t) X dt + 0.5 dB`, with `l = 1`, and 4000 for 0.01 of the unit of time.
struct Burst;

impl Sde<1, 1> for Burst {
    type Noise = Additive;

    fn drift(&self, t: f64, x: &[f64; 1]) -> [f64; 1] {
        let rate = if (0.5..0.51).contains(&t) { 4000.0 } else { 1.0 };
        [-rate * x[0]]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[0.5]]
    }
}

/// An explicit method needs `h < 2/4000` in the burst: with equal steps 2048 of them, of a power of two. The adaptive one
/// takes such steps there alone.
#[test]
fn a_burst_costs_short_steps_where_it_is_and_nowhere_else() {
    let control = StepControl { longest: 0.125, absolute: 2e-3, relative: 0.0, halvings: 14 };
    let noise = Noise::new(92);
    let (mut trials, mut squares, mut shortest) = (0, Vec::new(), f64::INFINITY);
    for realisation in 0..16 {
        let mut path =
            AdaptivePath::new(&Burst, &Shark, &noise, realisation, [1.0], &control).unwrap();
        while path.time() < 1.0 {
            let step = path.step().unwrap();
            if (0.5..0.51).contains(&step.t) {
                shortest = step.dt.min(shortest);
            }
        }
        // The same path in equal steps, 8 times shorter than stability asks for.
        let mut x = [1.0];
        let tree = sde_integrators::BrownianTree::<1>::new(noise, realisation, 0.125);
        for n in 0..8_u64 * 2048 {
            let bits: Vec<u8> = (0..11).rev().map(|bit| u8::from(n >> bit & 1 == 1)).collect();
            let (dt, dw) = (0.125 / 2048.0, tree.increment(n / 2048, &bits));
            Shark.step(&Burst, n as f64 * dt, dt, &dw, &mut x, &mut ()).unwrap();
        }
        squares.push((path.state()[0] - x[0]).powi(2));
        trials += path.accepted() + path.rejected();
    }
    let error = mean(&squares).0.sqrt();
    // Three steps of the method a trial.
    let cost = 3.0 * trials as f64 / 16.0;
    assert!(shortest < 2.0 / 4000.0, "{shortest}");
    // Some ten to a hundred accepted steps add up.
    assert!(error < 5.0 * control.absolute, "{error}");
    assert!(cost < 2048.0 / 3.0, "{cost} steps of the method for 2048 equal ones");
}

/// `x' = x^2 + noise` leaves the numbers at `t = 1`.
#[derive(Debug)]
struct Square;

impl Sde<1, 1> for Square {
    type Noise = Additive;

    fn drift(&self, _: f64, x: &[f64; 1]) -> [f64; 1] {
        [x[0] * x[0]]
    }

    fn noise(&self, _: f64, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[0.0]]
    }
}

#[test]
fn a_shortest_step_that_is_too_long_is_an_error_by_name() {
    let control = StepControl { longest: 0.5, absolute: 1e-6, relative: 1e-6, halvings: 8 };
    let noise = Noise::new(93);
    let mut path = AdaptivePath::new(&Square, &EulerMaruyama, &noise, 7, [1.0], &control).unwrap();
    let error = path.run(4).unwrap_err();
    let Error::StepUnderflow { realisation: 7, t, dt, error } = error else { panic!("{error}") };
    assert_eq!([dt, t].map(f64::to_bits), [0.5 / 256.0, path.time()].map(f64::to_bits));
    assert!(error > 1.0 && t < 1.0 && path.state()[0].is_finite());
}

#[test]
fn controls_out_of_range_are_refused() {
    let new = |control| {
        AdaptivePath::new(&Square, &EulerMaruyama, &Noise::new(1), 0, [1.0], &control).unwrap_err()
    };
    let control = StepControl { longest: 0.5, absolute: 1e-6, relative: 0.0, halvings: 8 };
    for longest in [0.0, -1.0, f64::NAN] {
        assert!(matches!(new(StepControl { longest, ..control }), Error::NotPositive { .. }));
    }
    assert!(matches!(new(StepControl { absolute: 0.0, ..control }), Error::NotPositive { .. }));
    let relative = f64::NAN;
    assert!(matches!(new(StepControl { relative, ..control }), Error::OutOfRange { .. }));
    assert!(matches!(new(StepControl { halvings: 20, ..control }), Error::TooMany { .. }));
}

/// Looser or tighter, it is one path: the ends come together.
#[test]
fn tolerances_change_the_error_and_not_the_path() {
    let noise = Noise::new(94);
    let end = |tolerance: f64| {
        let control =
            StepControl { longest: 0.25, absolute: tolerance, relative: 0.0, halvings: 19 };
        let mut path = AdaptivePath::new(&Growth, &Milstein, &noise, 3, [1.0], &control).unwrap();
        path.run(4).unwrap();
        path.state()[0]
    };
    let mut steps = noise.path::<1>(3);
    let w: f64 = (0..4).map(|_| steps.next_increment(0.25).brownian[0]).sum();
    let exact = (w - 0.3).exp();
    for (tolerance, limit) in [(1e-2, 0.1), (1e-4, 0.01), (1e-6, 1e-3)] {
        assert!((end(tolerance) - exact).abs() < limit, "{tolerance}: {} {exact}", end(tolerance));
    }
}
