//! Least squares over all folds of the samples but one.

/// A Cholesky factor of normal equations, `A = L L^T`.
#[derive(Debug)]
pub(crate) struct Factor {
    /// Rows of `L`, each `p` long.
    rows: Vec<f64>,
    p: usize,
}

/// Smallest square of a pivot over the diagonal entry: far above roundoff, far below what twice as many samples as terms
/// leave of it.
const LEAST_PIVOT: f64 = 1e-8;

impl Factor {
    /// Factors of the equations without each fold, then of all samples, in the first `p` of the `width` columns; none where one
    /// of them is singular.
    pub(crate) fn without_each_fold(
        rows: &[f64],
        width: usize,
        p: usize,
        n_folds: usize,
    ) -> Option<Vec<Self>> {
        let mut of_fold = vec![vec![0.0; p * p]; n_folds];
        for (k, row) in rows.chunks_exact(width).enumerate() {
            let gram = &mut of_fold[k % n_folds];
            for i in 0..p {
                for j in 0..=i {
                    gram[i * p + j] += row[i] * row[j];
                }
            }
        }
        let mut all = vec![0.0; p * p];
        for gram in &of_fold {
            all.iter_mut().zip(gram).for_each(|(all, own)| *all += own);
        }
        let without = |own: &Vec<f64>| all.iter().zip(own).map(|(all, own)| all - own).collect();
        let mut factors: Vec<Self> =
            of_fold.iter().map(|own| Self::of(without(own), p)).collect::<Option<_>>()?;
        factors.push(Self::of(all, p)?);
        Some(factors)
    }

    fn of(mut a: Vec<f64>, p: usize) -> Option<Self> {
        for i in 0..p {
            for j in 0..=i {
                let inner: f64 = (0..j).map(|k| a[i * p + k] * a[j * p + k]).sum();
                let rest = a[i * p + j] - inner;
                if i == j {
                    if rest.is_nan() || rest <= LEAST_PIVOT * a[i * p + i] {
                        return None;
                    }
                    a[i * p + i] = rest.sqrt();
                } else {
                    a[i * p + j] = rest / a[j * p + j];
                }
            }
        }
        Some(Self { rows: a, p })
    }

    /// The solution for a right side.
    pub(crate) fn solve(&self, mut x: Vec<f64>) -> Vec<f64> {
        let (p, l) = (self.p, &self.rows);
        for i in 0..p {
            let inner: f64 = (0..i).map(|k| l[i * p + k] * x[k]).sum();
            x[i] = (x[i] - inner) / l[i * p + i];
        }
        for i in (0..p).rev() {
            let inner: f64 = (i + 1..p).map(|k| l[k * p + i] * x[k]).sum();
            x[i] = (x[i] - inner) / l[i * p + i];
        }
        x
    }
}
