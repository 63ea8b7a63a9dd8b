//! What is claimed of `smoothing-kernels`: every kernel integrates to one and has the gradient it says.

use figures::{ErrorKind, Measured, Reference};
use smoothing_kernels::{Kernel, all, unit_sphere_surface};

use crate::case::{Case, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "smoothing-kernels/laws",
    title: "Every kernel in one to six dimensions: unit integral, gradient, compact support",
    source: "definition of a kernel; Canor & Denoël 2013, section 2.2",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run: |context| Ok(run(context)),
};

fn run(context: &Context<'_>) -> Vec<Claim> {
    let mut claims = Vec::new();
    dimension::<1>(context, &mut claims);
    dimension::<2>(context, &mut claims);
    dimension::<3>(context, &mut claims);
    dimension::<4>(context, &mut claims);
    dimension::<5>(context, &mut claims);
    dimension::<6>(context, &mut claims);
    claims
}

fn dimension<const D: usize>(context: &Context<'_>, claims: &mut Vec<Claim>) {
    for (name, kernel) in all::<D>() {
        let kernel = kernel.as_ref();
        let id = words(name);
        let claim = |what: &str, quantity: &str, measured, expected, tolerance, reason| {
            let subject = context.subject(
                &format!("{id}/{what}/{D}d"),
                quantity,
                "",
                &format!("{name}, {D}-D"),
            );
            let criterion = Criterion::Within { tolerance, reason };
            Claim::judge(
                subject,
                ErrorKind::Absolute,
                Measured::exact(measured),
                Reference::exact(expected),
                criterion,
            )
        };
        claims.push(claim(
            "integral",
            "integral of W over its support",
            integral::<D>(kernel, 0.7),
            1.0,
            1e-9,
            "Gauss-Legendre with 5 points on 400 intervals: 1e-12 where the kernel is smooth, less at its knots",
        ));
        claims.push(claim(
            "gradient",
            "largest |dW/dr - difference|, relative to the largest |dW/dr|",
            gradient_error::<D>(kernel, 0.7),
            0.0,
            1e-7,
            "central differences at 1e-5 h: third derivatives times 1e-10, roundoff 1e-11",
        ));
        let beyond = kernel.support() * 0.7 * (1.0 + 1e-12);
        claims.push(claim(
            "beyond",
            "W beyond its support",
            kernel.value(beyond, 0.7),
            0.0,
            0.0,
            "compact support",
        ));
    }
}

/// `WendlandC2` as `wendland-c2`: a hyphen before each capital but the first, and none within a number.
fn words(name: &str) -> String {
    let mut words = String::new();
    for character in name.chars() {
        if character.is_uppercase() && !words.is_empty() {
            words.push('-');
        }
        words.extend(character.to_lowercase());
    }
    words
}

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
    unit_sphere_surface::<D>() * sum
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

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn names_become_words() {
        assert_eq!(words("WendlandC2"), "wendland-c2");
        assert_eq!(words("CubicSpline"), "cubic-spline");
        assert_eq!(words("Lucy"), "lucy");
    }
}
