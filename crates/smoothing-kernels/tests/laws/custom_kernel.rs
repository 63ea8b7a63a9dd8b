//! A kernel as a user would write it: four functions, and the rest follows.

use smoothing_kernels::{Error, Kernel, all, check_kernel, power, unit_sphere_surface};

// docs: kernel
/// Poly6 of Mueller, Charypar & Gross 2003: `w(q) = (1 - q^2)^3` on one smoothing length.
#[derive(Debug)]
struct Poly6;

impl<const D: usize> Kernel<D> for Poly6 {
    fn support(&self) -> f64 {
        1.0
    }

    fn shape(&self, q: f64) -> f64 {
        if q >= 1.0 { 0.0 } else { (1.0 - q * q).powi(3) }
    }

    fn shape_derivative(&self, q: f64) -> f64 {
        if q >= 1.0 { 0.0 } else { -6.0 * q * (1.0 - q * q).powi(2) }
    }

    fn normalisation(&self) -> f64 {
        // ∫ (1 - q^2)^3 q^(D-1) dq = 1/D - 3/(D+2) + 3/(D+4) - 1/(D+6).
        let d = D as f64;
        let integral = 1.0 / d - 3.0 / (d + 2.0) + 3.0 / (d + 4.0) - 1.0 / (d + 6.0);
        1.0 / (unit_sphere_surface::<D>() * integral)
    }
}
// docs: end

/// Density at the origin as a solver computes it: generic in the kernel, the particle itself included.
fn density<const D: usize, K: Kernel<D>>(
    kernel: &K,
    points: &[[f64; D]],
    mass: f64,
    h: f64,
) -> f64 {
    let distance = |x: &[f64; D]| x.iter().map(|c| c * c).sum::<f64>().sqrt();
    points.iter().map(|x| mass * kernel.value(distance(x), h)).sum()
}

// docs: test
#[test]
fn users_kernel_has_its_published_constant() {
    // Mueller, Charypar & Gross 2003, eq 20: 315/(64 pi h^9) (h^2 - r^2)^3, that is 315/(64 pi h^3) (1 - q^2)^3.
    let published = 315.0 / (64.0 * std::f64::consts::PI * power::<3>(0.4));
    assert!((Kernel::<3>::value(&Poly6, 0.0, 0.4) / published - 1.0).abs() < 1e-13);
}

#[test]
fn users_kernel_keeps_the_laws_of_a_kernel() {
    check_kernel::<1, _>(&Poly6).unwrap();
    check_kernel::<2, _>(&Poly6).unwrap();
    check_kernel::<3, _>(&Poly6).unwrap();
}
// docs: end

/// Poly6 with one of its functions replaced.
#[derive(Debug, Clone, Copy)]
struct Broken {
    support: f64,
    beyond: f64,
    slope: f64,
    normalisation: f64,
    quotient: f64,
}

const WHOLE: Broken =
    Broken { support: 1.0, beyond: 0.0, slope: 1.0, normalisation: 1.0, quotient: 1.0 };

impl<const D: usize> Kernel<D> for Broken {
    fn support(&self) -> f64 {
        self.support
    }

    fn shape(&self, q: f64) -> f64 {
        if q >= 1.0 { self.beyond } else { Kernel::<D>::shape(&Poly6, q) }
    }

    fn shape_derivative(&self, q: f64) -> f64 {
        self.slope * Kernel::<D>::shape_derivative(&Poly6, q)
    }

    fn normalisation(&self) -> f64 {
        self.normalisation * Kernel::<D>::normalisation(&Poly6)
    }

    fn shape_derivative_over_q(&self, q: f64) -> f64 {
        self.quotient * self.slope * Kernel::<D>::shape_derivative_over_q(&Poly6, q)
    }
}

#[test]
fn broken_laws_are_named_with_place_and_value() {
    check_kernel::<2, _>(&WHOLE).unwrap();
    for (broken, words) in [
        (Broken { beyond: 1e-9, ..WHOLE }, "the shape beyond the support is 0.000000001 at q = 1"),
        (Broken { slope: 1.0001, ..WHOLE }, "the slope is -0.044999"),
        (Broken { normalisation: 1.000001, ..WHOLE }, "the integral is 1.000001"),
        (Broken { normalisation: f64::NAN, ..WHOLE }, "the integral is NaN"),
        (Broken { quotient: 1.01, ..WHOLE }, "the slope over q, times q, is"),
    ] {
        let error = check_kernel::<2, _>(&broken).unwrap_err();
        assert!(matches!(error, Error::KernelLaw { dimension: 2, .. }));
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn no_kernel_is_without_support() {
    for value in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let error = check_kernel::<1, _>(&Broken { support: value, ..WHOLE }).unwrap_err();
        assert!(error.to_string().contains(&format!("is {value}; it must be positive")), "{error}");
    }
}

#[test]
fn every_kernel_of_the_crate_keeps_the_laws() {
    for (name, kernel) in all::<3>() {
        check_kernel(&*kernel).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn users_kernel_gets_its_gradient_for_nothing() {
    // sigma_1 = 35/32; dW/dx = -6 sigma q (1 - q^2)^2 / h^2 = -6 * 35/32 * 0.5 * 0.5625 at x = 0.5, h = 1.
    let gradient = Poly6.gradient(&[0.5], 0.5, 1.0);
    assert!((gradient[0] + 6.0 * 35.0 / 32.0 * 0.5 * 0.5625).abs() < 1e-14);
    // And at 0 the provided quotient is the limit, -6 sigma, to the 1e-8 it promises.
    let factor = Kernel::<1>::gradient_factor(&Poly6, 0.0, 1.0);
    assert!((factor + 6.0 * 35.0 / 32.0).abs() < 1e-7);
}

#[test]
fn solver_takes_the_kernel_itself_a_reference_or_a_box() {
    // A line of unit spacing and mass: density one, to the error of the sum, which for this kernel at h = 4 is below 1 %.
    let line: Vec<[f64; 1]> = (-8..=8).map(|k| [f64::from(k)]).collect();
    let itself = density(&Poly6, &line, 1.0, 4.0);
    let boxed: Box<dyn Kernel<1>> = Box::new(Poly6);
    assert!((itself - 1.0).abs() < 0.01, "{itself}");
    assert_eq!(itself.to_bits(), density(&&Poly6, &line, 1.0, 4.0).to_bits());
    assert_eq!(itself.to_bits(), density(&boxed, &line, 1.0, 4.0).to_bits());
}
