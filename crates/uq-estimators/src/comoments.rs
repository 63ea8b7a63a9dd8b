//! Means and covariances of several numbers per sample.

/// Means and covariances of a sample of vectors, accumulated by vectors or by blocks.
///
/// $$ \bar x_i = \frac1n \sum_k x_{ik}, \qquad C_{ij} = \frac1{n-1} \sum_k (x_{ik} - \bar x_i)(x_{jk} - \bar x_j) $$
///
/// Blocks that are merged in a fixed order give bitwise identical sums, wherever they were computed.
///
/// Source: Chan, Golub and LeVeque 1983, Algorithms for computing the sample variance, eq 2.1, for products of two variables.
///
/// ```
/// let mut pairs = uq_estimators::Comoments::new(2);
/// [[1.0, 2.0], [3.0, 6.0]].iter().for_each(|x| pairs.push(x));
/// assert_eq!((pairs.mean(1), pairs.covariance(0, 1)), (4.0, 4.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Comoments {
    count: u64,
    means: Vec<f64>,
    /// Sums of products of the deviations from the means, `(i, j)` with `j <= i`, row by row.
    products: Vec<f64>,
}

impl Comoments {
    /// An empty sample of vectors with `n` components.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self { count: 0, means: vec![0.0; n], products: vec![0.0; n * (n + 1) / 2] }
    }

    /// Adds one vector; components without an entry count as zero.
    pub fn push(&mut self, x: &[f64]) {
        self.count += 1;
        let n = self.count as f64;
        let mut place = 0;
        for i in 0..self.means.len() {
            let value = x.get(i).copied().unwrap_or(0.0);
            let distance = value - self.means[i];
            self.means[i] += distance / n;
            for j in 0..=i {
                let other = x.get(j).copied().unwrap_or(0.0);
                self.products[place] += distance * (other - self.means[j]);
                place += 1;
            }
        }
    }

    /// Adds a later sample of vectors of the same length.
    pub fn merge(&mut self, later: &Self) {
        if later.count == 0 {
            return;
        }
        let (n_a, n_b) = (self.count as f64, later.count as f64);
        let n = n_a + n_b;
        let weight = n_a * (n_b / n);
        let mut place = 0;
        for i in 0..self.means.len() {
            let distance = later.means[i] - self.means[i];
            for j in 0..=i {
                let other = later.means[j] - self.means[j];
                self.products[place] += later.products[place] + distance * other * weight;
                place += 1;
            }
        }
        for (mean, later) in self.means.iter_mut().zip(&later.means) {
            *mean += (later - *mean) * (n_b / n);
        }
        self.count += later.count;
    }

    /// Number of vectors.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Number of components.
    #[must_use]
    pub fn n_components(&self) -> usize {
        self.means.len()
    }

    /// Mean of a component; 0 for an empty sample.
    #[must_use]
    pub fn mean(&self, i: usize) -> f64 {
        self.means[i]
    }

    /// Unbiased covariance of two components; NaN for fewer than two vectors.
    #[must_use]
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.max(j), i.min(j));
        if self.count < 2 {
            return f64::NAN;
        }
        self.products[i * (i + 1) / 2 + j] / (self.count - 1) as f64
    }

    /// Unbiased variance of a component; NaN for fewer than two vectors.
    #[must_use]
    pub fn variance(&self, i: usize) -> f64 {
        self.covariance(i, i)
    }
}
