//! Value and derivatives of a response at a point.

use crate::error::{Error, require_finite};

/// Value and derivatives of a response with respect to its inputs.
///
/// They are evaluated at the centre of a [`RandomVector`](crate::RandomVector).
///
/// Symbols: `value` $y_0$, `gradient` $g_i = \partial y/\partial x_i$, `hessian` $H_{ij}$, `third` $T_{ijk}$; each in
/// the unit of the response over those of its inputs. Unknown derivatives are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expansion<const N: usize> {
    /// $y_0$.
    pub value: f64,
    /// $g$, `N` entries.
    pub gradient: [f64; N],
    /// $H$, symmetric `N x N`, complete: not a diagonal with zeros around it.
    pub hessian: Option<[[f64; N]; N]>,
    /// $T$, symmetric `N x N x N`.
    pub third: Option<[[[f64; N]; N]; N]>,
}

impl<const N: usize> Expansion<N> {
    /// An expansion from a function that returns any derivative up to the third, given the list of its inputs.
    ///
    /// `[]` is the value, `[i, j]` an entry of the Hessian. It is called once for each entry of the symmetric tensors.
    ///
    /// ```
    /// use perturbation_moments::Expansion;
    ///
    /// // y = x1 x2 at (2, 3).
    /// let y = Expansion::<2>::from_derivatives(|by| match by {
    ///     [] => 6.0,
    ///     [0] => 3.0,
    ///     [1] => 2.0,
    ///     [0, 1] => 1.0,
    ///     _ => 0.0,
    /// });
    /// assert_eq!(y.hessian, Some([[0.0, 1.0], [1.0, 0.0]]));
    /// ```
    #[must_use]
    pub fn from_derivatives(derivative: impl Fn(&[usize]) -> f64) -> Self {
        let mut hessian = [[0.0; N]; N];
        let mut third = [[[0.0; N]; N]; N];
        for i in 0..N {
            for j in i..N {
                hessian[i][j] = derivative(&[i, j]);
                hessian[j][i] = hessian[i][j];
                for k in j..N {
                    set_symmetric(&mut third, [i, j, k], derivative(&[i, j, k]));
                }
            }
        }
        Self {
            value: derivative(&[]),
            gradient: std::array::from_fn(|i| derivative(&[i])),
            hessian: Some(hessian),
            third: Some(third),
        }
    }

    /// Checks that every entry is finite and every tensor symmetric within roundoff.
    pub(crate) fn check(&self) -> Result<(), Error> {
        require_finite("value of the response", 0, self.value)?;
        for (index, &value) in self.gradient.iter().enumerate() {
            require_finite("gradient entry", index, value)?;
        }
        for (index, &value) in self.hessian.iter().flatten().flatten().enumerate() {
            require_finite("Hessian entry", index, value)?;
        }
        for (index, &value) in self.third.iter().flatten().flatten().flatten().enumerate() {
            require_finite("third derivative", index, value)?;
        }
        if let Some(hessian) = &self.hessian {
            check_symmetric("Hessian", hessian)?;
        }
        for slice in self.third.iter().flatten() {
            check_symmetric("third derivative", slice)?;
        }
        Ok(())
    }
}

/// Sets one entry and its images under permutation of the indices.
pub(crate) fn set_symmetric<const N: usize>(
    tensor: &mut [[[f64; N]; N]; N],
    [i, j, k]: [usize; 3],
    value: f64,
) {
    for [a, b, c] in [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]] {
        tensor[a][b][c] = value;
    }
}

/// Checks symmetry to 1e-9 of the larger of two entries.
///
/// A transposed or missing entry is far above this limit, the roundoff of automatic differentiation far below.
pub(crate) fn check_symmetric<const N: usize>(
    matrix: &'static str,
    entries: &[[f64; N]; N],
) -> Result<(), Error> {
    let largest = entries.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
    for row in 0..N {
        for column in 0..row {
            let (a, b) = (entries[row][column], entries[column][row]);
            let limit = 1e-9 * a.abs().max(b.abs()).max(f64::EPSILON * largest);
            let difference = (a - b).abs();
            if difference > limit {
                return Err(Error::NotSymmetric { matrix, row, column, difference, limit });
            }
        }
    }
    Ok(())
}
