//! Least squares over all folds of the samples but one.

use sde_integrators::Cholesky;

/// Smallest square of a pivot over the diagonal entry: far above roundoff, far below what twice as many samples as terms
/// leave of it.
const LEAST_PIVOT: f64 = 1e-8;

/// Factors of the equations without each fold, then of all samples, in the first `p` of the `width` columns; none where one
/// of them is singular.
pub(crate) fn factors_without_each_fold(
    rows: &[f64],
    width: usize,
    p: usize,
    n_folds: usize,
) -> Option<Vec<Cholesky>> {
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
    let of = |gram: Vec<f64>| Cholesky::new(p, gram, LEAST_PIVOT).ok();
    let without = |own: &Vec<f64>| all.iter().zip(own).map(|(all, own)| all - own).collect();
    let mut factors: Vec<Cholesky> =
        of_fold.iter().map(|own| of(without(own))).collect::<Option<_>>()?;
    factors.push(of(all)?);
    Some(factors)
}
