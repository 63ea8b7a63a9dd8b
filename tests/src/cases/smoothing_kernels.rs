//! What is claimed of `smoothing-kernels`: every kernel integrates to one and has the gradient it says.

use result_figures::ErrorKind;
use std::f64::consts::PI;

use smoothing_kernels::{Kernel, all};

use crate::case::{Case, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smoothing-kernels/laws",
    title: "Every kernel in one to six dimensions: unit integral, gradient, compact support",
    source: "definition of a kernel; Canor & Denoël 2013, section 2.2",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: |context| Ok(run(context)),
};

/// What a dimension gives: the worst integral and gradient over all kernels, and what they are beyond their support.
struct Worst {
    /// Error, and the kernel it is of.
    integral: (f64, &'static str),
    gradient: (f64, &'static str),
    /// Values that are not zero, and values asked for.
    beyond: (usize, usize),
}

fn run(context: &Context<'_>) -> Vec<Claim> {
    let of_dimensions = [
        dimension::<1>(),
        dimension::<2>(),
        dimension::<3>(),
        dimension::<4>(),
        dimension::<5>(),
        dimension::<6>(),
    ];
    let mut claims = Vec::new();
    for (d, Worst { integral, gradient, .. }) in (1..).zip(&of_dimensions) {
        claims.push(claim(
            context,
            &format!("integral/{d}d"),
            "worst |integral of W over its support - 1|",
            *integral,
            1e-13,
            "roundoff: sums of 2,000 positive terms; Gauss-Legendre with 5 points on 400 intervals errs by less",
        ));
        claims.push(claim(
            context,
            &format!("gradient/{d}d"),
            "worst |dW/dr - difference|, relative to the largest |dW/dr|",
            *gradient,
            2e-9,
            "central differences at 1e-5 h: third derivatives times 1e-10",
        ));
    }
    let sum = |of: fn(&Worst) -> usize| of_dimensions.iter().map(of).sum();
    let subject = context.subject(
        "beyond-support",
        "values, slopes and gradient factors that are not zero beyond the support",
        "",
        "all kernels, one to six dimensions, 1 + 1e-12, 1.5 and 100 supports away",
    );
    let (different, compared) = (sum(|worst| worst.beyond.0), sum(|worst| worst.beyond.1));
    claims.push(Claim::same_bits(subject, different, compared, "compact support"));
    claims
}

fn claim(
    context: &Context<'_>,
    id: &str,
    quantity: &str,
    (error, kernel): (f64, &str),
    tolerance: f64,
    reason: &str,
) -> Claim {
    let method = format!("worst of all kernels: {kernel}");
    let subject = context.subject(id, quantity, "", &method);
    Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, reason)
}

fn dimension<const D: usize>() -> Worst {
    const H: f64 = 0.7;
    let mut worst = Worst { integral: (0.0, ""), gradient: (0.0, ""), beyond: (0, 0) };
    for (name, kernel) in all::<D>() {
        let kernel = kernel.as_ref();
        larger(&mut worst.integral, (integral::<D>(kernel, H) - 1.0).abs(), name);
        larger(&mut worst.gradient, gradient_error::<D>(kernel, H), name);
        for away in [1.0 + 1e-12, 1.5, 100.0] {
            let r = away * kernel.support() * H;
            for value in
                [kernel.value(r, H), kernel.radial_derivative(r, H), kernel.gradient_factor(r, H)]
            {
                worst.beyond.0 += usize::from(value.abs() > 0.0 || value.is_nan());
                worst.beyond.1 += 1;
            }
        }
    }
    worst
}

/// The larger error with its kernel; NaN stays.
fn larger(worst: &mut (f64, &'static str), error: f64, name: &'static str) {
    if worst.1.is_empty() || error.is_nan() || error > worst.0 {
        *worst = (error, name);
    }
}

/// Surfaces of the unit sphere in one to six dimensions, from their closed forms and not from the crate, which normalises by its own.
const SURFACES: [f64; 6] =
    [2.0, 2.0 * PI, 4.0 * PI, 2.0 * PI * PI, 8.0 * PI * PI / 3.0, PI * PI * PI];

/// `S_D int_0^R W(r, h) r^(D-1) dr`.
fn integral<const D: usize>(kernel: &dyn Kernel<D>, h: f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let end = kernel.support() * h;
    let n = 400;
    let half = 0.5 * end / f64::from(n);
    let mut sum = 0.0;
    for k in 0..n {
        let middle = half * (2.0 * f64::from(k) + 1.0);
        for (node, weight) in NODES {
            let r = middle + half * node;
            let shell: f64 = (1..D).map(|_| r).product();
            sum += weight * half * shell * kernel.value(r, h);
        }
    }
    SURFACES[D - 1] * sum
}

fn gradient_error<const D: usize>(kernel: &dyn Kernel<D>, h: f64) -> f64 {
    let end = kernel.support() * h;
    let eps = 1e-5 * h;
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for k in 1..200 {
        // Knots, where a third derivative jumps, lie at rational parts of the support: an irrational spacing misses them.
        let r = end * f64::from(k) / 200.0 * 0.998_763;
        let given = kernel.radial_derivative(r, h);
        let difference = (kernel.value(r + eps, h) - kernel.value(r - eps, h)) / (2.0 * eps);
        worst = worst.max((given - difference).abs());
        largest = largest.max(given.abs());
    }
    worst / largest
}
