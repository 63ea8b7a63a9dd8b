//! Sums of vectors of all particles, with numbers or matrices as factors.

use vibrating_systems::matrix::Matrix;

/// `x = x_0 + sum_s c_s k_s`.
pub(super) fn combine<const D: usize, const S: usize>(
    x: &mut [[f64; D]],
    x_0: &[[f64; D]],
    terms: &[(f64, &Vec<[f64; D]>); S],
) {
    let (x, x_0) = (x.as_flattened_mut(), x_0.as_flattened());
    let factors = terms.map(|(c, _)| c);
    let rates = terms.map(|(_, k)| &k.as_flattened()[..x_0.len()]);
    let x = &mut x[..x_0.len()];
    simd_lanes::dispatch(
        #[inline(always)]
        || {
            for i in 0..x_0.len() {
                let mut value = x_0[i];
                for s in 0..S {
                    value += factors[s] * rates[s][i];
                }
                x[i] = value;
            }
        },
    );
}

/// `out = sum_s M_s q_s` for every particle.
pub(super) fn transform<const D: usize, const S: usize>(
    out: &mut [[f64; D]],
    terms: &[(Matrix<D>, &[[f64; D]]); S],
) {
    let n = out.len();
    let matrices = terms.map(|(matrix, _)| matrix);
    let vectors = terms.map(|(_, vectors)| &vectors[..n]);
    simd_lanes::dispatch(
        #[inline(always)]
        || {
            for (i, out) in out.iter_mut().enumerate() {
                let mut sum = [0.0; D];
                for s in 0..S {
                    for k in 0..D {
                        for l in 0..D {
                            sum[k] += matrices[s][k][l] * vectors[s][i][l];
                        }
                    }
                }
                *out = sum;
            }
        },
    );
}

/// `v -= A x` for every particle: what remains of a velocity.
pub(super) fn subtract<const D: usize>(v: &mut [[f64; D]], a: &Matrix<D>, x: &[[f64; D]]) {
    let x = &x[..v.len()];
    simd_lanes::dispatch(
        #[inline(always)]
        || {
            for (i, v) in v.iter_mut().enumerate() {
                for k in 0..D {
                    for l in 0..D {
                        v[k] -= a[k][l] * x[i][l];
                    }
                }
            }
        },
    );
}
