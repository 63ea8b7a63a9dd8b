//! Derivatives along the directions `L e_k`, as carried by the jets of a solver.

use crate::error::{Error, require_finite, require_positive};
use crate::numbers::jet::{Jet, LANES};
use crate::random_vector::RandomVector;

/// Value, first and second derivatives along the `N` independent standard normals $t$ of a random vector.
///
/// $$ a_k = \frac{\partial y}{\partial t_k}, \qquad A_{kk} = \frac{\partial^2 y}{\partial t_k^2}, \qquad x = x(L t) $$
///
/// This suffices for the second-order mean, also for correlated inputs, because
/// $\operatorname{tr}(H \Sigma) = \sum_k A_{kk}$. A second-order variance also requires the mixed $A_{kl}$.
///
/// Probes estimate the mixed terms: along a direction of signs $v_k = \pm 1$ the second derivative is
/// $\operatorname{tr} A + 2 \sum_{k<l} A_{kl} v_k v_l$. Therefore
/// $2 \sum_{k \ne l} A_{kl}^2 = \operatorname{E} (v^T A v - \operatorname{tr} A)^2$ over random signs. A few probes
/// give an estimate; the $2^{N-1}$ signs with $v_1 = 1$ give the exact value.
///
/// Source of the estimator: Hutchinson 1989, A stochastic estimator of the trace, for the square of the matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlongDirections<const N: usize> {
    /// $y_0$.
    pub value: f64,
    /// $a_k$, in the unit of the response.
    pub first: [f64; N],
    /// $A_{kk}$, in the unit of the response.
    pub second: [f64; N],
    /// An estimate of $\sum_{k \ne l} A_{kl}^2$ from probes, if any.
    pub mixed_squares: Option<f64>,
}

/// Value and first derivatives along the `N` independent standard normals $t$ of a random vector: the first-order mean and
/// variance, and no curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slopes<const N: usize> {
    /// $y_0$.
    pub value: f64,
    /// $a_k = \partial y / \partial t_k$, in the unit of the response.
    pub first: [f64; N],
}

impl<const N: usize> Slopes<N> {
    /// One-sided differences from the responses at the centre and at the `+` of each direction of a
    /// [`star`](AlongDirections::star), in order.
    ///
    /// $$ a_k = \frac{y_k^+ - y_0}{d} , $$
    ///
    /// too large by $\tfrac12 d A_{kk}$ for the curvature $A_{kk}$.
    ///
    /// # Errors
    /// As [`AlongDirections::from_star`].
    pub fn from_half_star(distance: f64, values: &[f64]) -> Result<Self, Error> {
        check_points(distance, values, N as u64 + 1)?;
        let value = values[0];
        Ok(Self { value, first: std::array::from_fn(|k| (values[k + 1] - value) / distance) })
    }
}

/// Refuses a distance, or responses at the points of a star, that give no differences.
fn check_points(distance: f64, values: &[f64], limit: u64) -> Result<(), Error> {
    require_positive("distance of the points of a star", distance)?;
    let value = values.len() as u64;
    if value < limit {
        return Err(Error::TooFew { quantity: "points of a star", value, limit });
    }
    for (index, &value) in values.iter().enumerate() {
        require_finite("response at point", index, value)?;
    }
    Ok(())
}

impl<const N: usize> AlongDirections<N> {
    /// Derivatives from the jet of a response, for inputs with or without probes.
    ///
    /// The inputs are [`RandomVector::jets`] or [`RandomVector::jets_with_probes`].
    ///
    /// The `n_probes` lanes after the first `N` count as probes.
    ///
    /// ```
    /// use perturbation_moments::{AlongDirections, Moments, RandomVector};
    ///
    /// // Var(x1 x2) = (m2 s1)^2 + (m1 s2)^2 + (s1 s2)^2; for two inputs one probe is exact.
    /// let inputs = RandomVector::independent([2.0, 3.0], [0.2, 0.25])?;
    /// let [x1, x2] = inputs.jets_with_probes(&[[1.0, -1.0]]);
    /// let known = AlongDirections::<2>::from_jet(&(x1 * x2), 1);
    /// let moments = Moments::along(&inputs, &known)?;
    /// let exact = (3.0 * 0.2_f64).powi(2) + (2.0 * 0.25_f64).powi(2) + (0.2 * 0.25_f64).powi(2);
    /// assert!((moments.variance_with_curvature()? / exact - 1.0).abs() < 1e-14);
    /// # Ok::<(), perturbation_moments::Error>(())
    /// ```
    #[must_use]
    pub fn from_jet(jet: &Jet, n_probes: usize) -> Self {
        const { assert!(N <= LANES, "a jet has eight lanes") }
        Self::of_passes(std::slice::from_ref(jet), n_probes)
    }

    /// Derivatives from the jets of one response in several passes.
    ///
    /// Jet `p` has the inputs [`RandomVector::jets_of_pass`] of pass `p`.
    ///
    /// More than eight inputs require several passes. The value is that of the first pass; lanes after the first `N`
    /// are probes, as in [`from_jet`](Self::from_jet).
    ///
    /// # Errors
    /// [`Error::TooFew`] for missing passes.
    pub fn from_passes(jets: &[Jet], n_probes: usize) -> Result<Self, Error> {
        let (value, limit) = (jets.len() as u64, N.div_ceil(LANES).max(1) as u64);
        if value < limit {
            return Err(Error::TooFew { quantity: "passes", value, limit });
        }
        Ok(Self::of_passes(jets, n_probes))
    }

    /// Lane `k % 8` of pass `k / 8` is direction `k`, or a probe for `k >= N`.
    fn of_passes(jets: &[Jet], n_probes: usize) -> Self {
        let second_of = |k: usize| jets[k / LANES].second[k % LANES];
        let second: [f64; N] = std::array::from_fn(second_of);
        let trace: f64 = second.iter().sum();
        let probes = N..(LANES * jets.len()).min(N + n_probes);
        let n_probes = probes.len();
        let squares: f64 = probes.map(|k| (second_of(k) - trace).powi(2)).sum();
        Self {
            value: jets[0].value,
            first: std::array::from_fn(|k| jets[k / LANES].first[k % LANES]),
            second,
            mixed_squares: (n_probes > 0).then(|| 0.5 * squares / n_probes as f64),
        }
    }

    /// The `2N + 1` points of a star in the independent standard normals.
    ///
    /// They are the centre, then `+` and `-` of each direction at `distance` deviations.
    #[must_use]
    pub fn star(distance: f64) -> Vec<[f64; N]> {
        let mut points = vec![[0.0; N]];
        for k in 0..N {
            for signed in [distance, -distance] {
                let mut t = [0.0; N];
                t[k] = signed;
                points.push(t);
            }
        }
        points
    }

    /// Central differences from the responses at the points of a [`star`](Self::star), in order.
    ///
    /// $$ a_k = \frac{y_k^+ - y_k^-}{2 d}, \qquad A_{kk} = \frac{y_k^+ - 2 y_0 + y_k^-}{d^2} $$
    ///
    /// # Errors
    /// [`Error::NotPositive`] for the distance, [`Error::TooFew`] for too few values, [`Error::NotFinite`] for one of them.
    pub fn from_star(distance: f64, values: &[f64]) -> Result<Self, Error> {
        check_points(distance, values, 2 * N as u64 + 1)?;
        let (value, pair) = (values[0], |k: usize| (values[2 * k + 1], values[2 * k + 2]));
        Ok(Self {
            value,
            first: std::array::from_fn(|k| (pair(k).0 - pair(k).1) / (2.0 * distance)),
            second: std::array::from_fn(|k| {
                ((pair(k).0 - value) + (pair(k).1 - value)) / (distance * distance)
            }),
            mixed_squares: None,
        })
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        require_finite("value of the response", 0, self.value)?;
        for k in 0..N {
            require_finite("first derivative along direction", k, self.first[k])?;
            require_finite("second derivative along direction", k, self.second[k])?;
        }
        require_finite("sum of squared mixed derivatives", 0, self.mixed_squares.unwrap_or(0.0))
    }
}

impl<const N: usize> RandomVector<N> {
    /// The inputs as jets along the directions `L e_k`, one per lane; the other lanes are zero.
    ///
    /// ```
    /// use perturbation_moments::RandomVector;
    ///
    /// // y = x1 x2 along the directions of a correlated pair: 2 (L e_1)_1 (L e_1)_2.
    /// let inputs = RandomVector::new([2.0, 3.0], [0.5, 0.25], [[1.0, 0.5], [0.5, 1.0]])?;
    /// let [x1, x2] = inputs.jets();
    /// assert_eq!((x1 * x2).second[0], 2.0 * 0.5 * (0.25 * 0.5));
    /// # Ok::<(), perturbation_moments::Error>(())
    /// ```
    #[must_use]
    pub fn jets(&self) -> [Jet; N] {
        self.jets_with_probes(&[])
    }

    /// The inputs as in [`jets`](Self::jets), with lane `N + p` along the combination `probes[p]` of the directions.
    ///
    /// Use signs for [`AlongDirections::from_jet`], or any weights. Probes beyond the eighth lane are ignored.
    #[must_use]
    pub fn jets_with_probes(&self, probes: &[[f64; N]]) -> [Jet; N] {
        const { assert!(N <= LANES, "a jet has eight lanes") }
        self.jets_of_pass(0, probes)
    }

    /// The inputs as jets along the eight directions `L e_k` from `8 pass` on; probes follow the last direction.
    ///
    /// This supports any number of inputs, in `ceil(N/8)` passes that [`AlongDirections::from_passes`] merges.
    ///
    /// ```
    /// use perturbation_moments::{AlongDirections, Moments, RandomVector};
    ///
    /// // The sum of twelve: Var = 12.
    /// let inputs = RandomVector::independent([0.0; 12], [1.0; 12])?;
    /// let pass = |p| inputs.jets_of_pass(p, &[]).into_iter().reduce(|a, b| a + b).unwrap();
    /// let known = AlongDirections::from_passes(&[pass(0), pass(1)], 0)?;
    /// assert_eq!(Moments::along(&inputs, &known)?.variance_first_order(), 12.0);
    /// # Ok::<(), perturbation_moments::Error>(())
    /// ```
    #[must_use]
    pub fn jets_of_pass(&self, pass: usize, probes: &[[f64; N]]) -> [Jet; N] {
        self.jets_along(|lane| match LANES * pass + lane {
            k if k < N => Some(unit(k)),
            k => probes.get(k - N).copied(),
        })
    }

    /// The inputs as jets, each lane along a combination of the directions, or zero.
    fn jets_along(&self, of_lane: impl Fn(usize) -> Option<[f64; N]>) -> [Jet; N] {
        let centre = self.centre();
        let (slopes, curvatures, _) = self.marginal_derivatives();
        let l = self.lower_factor();
        let mut jets = centre.map(|value| Jet::new(value, [0.0; LANES]));
        for lane in 0..LANES {
            let Some(weights) = of_lane(lane) else { continue };
            for (i, jet) in jets.iter_mut().enumerate() {
                let u: f64 = (0..=i).map(|k| l[i][k] * weights[k]).sum();
                jet.first[lane] = slopes[i] * u;
                jet.second[lane] = curvatures[i] * u * u;
            }
        }
        jets
    }
}

fn unit<const N: usize>(k: usize) -> [f64; N] {
    std::array::from_fn(|i| f64::from(u8::from(i == k)))
}
