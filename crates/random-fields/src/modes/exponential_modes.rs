//! Eigenfunctions of the exponential correlation on an interval.

/// The Karhunen-Loève expansion of $e^{-\lvert x - y \rvert/l}$ on an interval of half-length `a` about its centre.
///
/// With $b = a/l$ the eigenvalues are, for $m = 0, 1, \ldots$,
///
/// $$ \lambda_m = \frac{2 l}{1 + (\theta_m/b)^2}, \qquad \theta_m = m \pi/2 + \arctan(b/\theta_m), $$
///
/// with one root in each interval of length $\pi/2$, and the eigenfunctions of unit norm, of the distance `x` from the centre,
///
/// $$ \frac{\cos(\theta_m x/a)}{\sqrt{a (1 + \sin(2\theta_m)/(2\theta_m))}} \quad (m \text{ even}), \qquad
/// \frac{\sin(\theta_m x/a)}{\sqrt{a (1 - \sin(2\theta_m)/(2\theta_m))}} \quad (m \text{ odd}) . $$
///
/// The equation for $\theta_m$ is $\theta \tan \theta = b$ for even and $\theta = -b \tan \theta$ for odd `m`, written so that it has
/// no pole.
///
/// Source: Ghanem and Spanos 1991, Stochastic finite elements, section 2.3.3.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ExponentialModes {
    length: f64,
    half: f64,
    /// `theta_m` of the modes so far, with the amplitude of each.
    modes: Vec<[f64; 2]>,
}

impl ExponentialModes {
    /// For an interval of half-length `half > 0`.
    pub(crate) fn new(length: f64, half: f64) -> Self {
        Self { length, half, modes: vec![] }
    }

    /// Eigenvalue `m` over the length of the interval: its share of the mean variance. Modes up to it are kept.
    pub(crate) fn share(&mut self, m: usize) -> f64 {
        let b = self.half / self.length;
        // lambda/(2 a) = (l/a)/(1 + (theta/b)^2)
        let share = |theta: f64| 1.0 / (b * (1.0 + (theta / b) * (theta / b)));
        while self.modes.len() <= m {
            let m = self.modes.len();
            let theta = root(m, b);
            let overlap = libm::sin(2.0 * theta) / (2.0 * theta);
            let norm = if m.is_multiple_of(2) { 1.0 + overlap } else { 1.0 - overlap };
            // lambda/(a (1 +- overlap))
            self.modes.push([theta, (2.0 * share(theta) / norm).sqrt()]);
        }
        share(self.modes[m][0])
    }

    /// All modes that are kept at a distance from the centre, each as $\sqrt{\lambda_m} f_m(x)$, into `out`.
    pub(crate) fn values(&self, x: f64, out: &mut [f64]) {
        let q = x / self.half;
        for (m, (out, [theta, amplitude])) in out.iter_mut().zip(&self.modes).enumerate() {
            let angle = theta * q;
            let wave = if m.is_multiple_of(2) { libm::cos(angle) } else { libm::sin(angle) };
            *out = amplitude * wave;
        }
    }

    /// Keeps the first modes only.
    pub(crate) fn truncate(&mut self, n_modes: usize) {
        self.modes.truncate(n_modes);
    }

    /// Number of modes that are kept.
    pub(crate) fn n_modes(&self) -> usize {
        self.modes.len()
    }
}

/// The root of `theta - m pi/2 - arctan(b/theta)` between `m pi/2` and `(m + 1) pi/2`, in which it increases: by Newton's
/// method, kept in the bracket by bisection.
fn root(m: usize, b: f64) -> f64 {
    const QUARTER: f64 = std::f64::consts::FRAC_PI_2;
    let start = m as f64 * QUARTER;
    let (mut low, mut high) = (start, start + QUARTER);
    let mut theta = 0.5 * (low + high);
    for _ in 0..100 {
        let value = theta - start - libm::atan2(b, theta);
        if value > 0.0 {
            high = theta;
        } else {
            low = theta;
        }
        let newton = theta - value / (1.0 + b / (theta * theta + b * b));
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - theta).abs() <= f64::EPSILON * theta {
            return next;
        }
        theta = next;
    }
    theta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_solve_the_printed_equations() {
        for b in [1e-3, 0.3, 1.0, 7.0, 1e3] {
            for m in 0..60 {
                let theta = root(m, b);
                let (sine, cosine) = (theta.sin(), theta.cos());
                // theta tan theta = b, and theta = -b tan theta, without poles.
                let residual =
                    if m % 2 == 0 { theta * sine - b * cosine } else { theta * cosine + b * sine };
                // One bit of theta moves the residual by (theta + b + 1) of it.
                let limit = 4.0 * f64::EPSILON * (theta + b + 1.0) * theta.max(1.0);
                assert!(residual.abs() < limit, "b {b}, m {m}: {residual:e}");
            }
        }
    }

    #[test]
    fn modes_are_orthonormal_and_solve_the_integral_equation() {
        let (length, half, n) = (0.6, 1.3, 12);
        let mut modes = ExponentialModes::new(length, half);
        let eigenvalues: Vec<f64> = (0..n).map(|m| 2.0 * half * modes.share(m)).collect();
        // Gauss' rule of two points in each of 4000 intervals: an error of h^4.
        let h = 2.0 * half / 4000.0;
        let offset = 0.5 * h / 3.0_f64.sqrt();
        let points: Vec<f64> = (0..8000)
            .map(|i| {
                (f64::from(i / 2) + 0.5) * h - half + if i % 2 == 0 { -offset } else { offset }
            })
            .collect();
        let mut at = vec![0.0; n];
        let mut products = vec![0.0; n * n];
        let mut images = vec![0.0; n];
        for &y in &points {
            modes.values(y, &mut at);
            for i in 0..n {
                // From one end of the interval, where the kernel has no kink.
                images[i] += 0.5 * h * (-(half + y) / length).exp() * at[i];
                for j in 0..n {
                    products[i * n + j] += 0.5 * h * at[i] * at[j];
                }
            }
        }
        modes.values(-half, &mut at);
        for i in 0..n {
            assert!((images[i] - eigenvalues[i] * at[i]).abs() < 1e-9, "{i}");
            for j in 0..n {
                let expected = if i == j { eigenvalues[i] } else { 0.0 };
                assert!((products[i * n + j] - expected).abs() < 1e-9, "{i}, {j}");
            }
        }
    }
}
