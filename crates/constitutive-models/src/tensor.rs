//! Symmetric tensors over any number type.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use std::ops::{Add, Sub};

use perturbation_moments::{Real, Scalar, when};
use simd_lanes::Mask;

// No closures: they are not always inlined, and then not compiled for the widest registers.

/// A symmetric 3 x 3 tensor: `[xx, yy, zz, xy, yz, xz]`, the order of VTK.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric<S>(pub [S; 6]);

impl<S: Scalar> Symmetric<S> {
    /// All entries zero.
    #[must_use]
    #[inline(always)]
    pub fn zero() -> Self {
        Self([S::constant(0.0); 6])
    }

    /// The values, without derivatives.
    #[must_use]
    pub fn values(&self) -> [f64; 6] {
        self.0.map(Scalar::value)
    }
}

impl<S: Real> Symmetric<S> {
    /// `value` times the identity.
    #[must_use]
    #[inline(always)]
    pub fn isotropic(value: S) -> Self {
        let zero = value.splat(0.0);
        Self([value, value, value, zero, zero, zero])
    }

    /// `inside` in the lanes where the mask is true, `outside` in the others.
    #[must_use]
    #[inline(always)]
    pub fn select(mask: S::Mask, inside: &Self, outside: &Self) -> Self {
        let mut chosen = inside.0;
        for k in 0..6 {
            chosen[k] = S::select(mask, inside.0[k], outside.0[k]);
        }
        Self(chosen)
    }

    /// The symmetric part of a matrix, `(A + A^T)/2`: the rate of deformation of a velocity gradient.
    #[must_use]
    #[inline(always)]
    pub fn part_of(a: &[[S; 3]; 3]) -> Self {
        let (xy, yz, xz) = (a[0][1] + a[1][0], a[1][2] + a[2][1], a[0][2] + a[2][0]);
        Self([a[0][0], a[1][1], a[2][2], xy * 0.5, yz * 0.5, xz * 0.5])
    }

    /// The sum of the diagonal.
    #[must_use]
    #[inline(always)]
    pub fn trace(&self) -> S {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// What is left without the mean of the diagonal.
    #[must_use]
    #[inline(always)]
    pub fn deviator(&self) -> Self {
        let mean = self.trace() * (1.0 / 3.0);
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Self([xx - mean, yy - mean, zz - mean, xy, yz, xz])
    }

    /// The double contraction `A : B = sum_ij A_ij B_ij`.
    #[must_use]
    #[inline(always)]
    pub fn contract(&self, other: &Self) -> S {
        let (a, b) = (&self.0, &other.0);
        let shear = a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + shear * 2.0
    }

    /// `A : A`, cheaper for a jet than the contraction with itself.
    #[must_use]
    #[inline(always)]
    pub fn square(&self) -> S {
        let a = &self.0;
        let mut squares = *a;
        for k in 0..6 {
            squares[k] = a[k].squared();
        }
        let [xx, yy, zz, xy, yz, xz] = squares;
        xx + yy + zz + (xy + yz + xz) * 2.0
    }

    /// Every entry times a number.
    #[must_use]
    #[inline(always)]
    pub fn scaled(&self, factor: S) -> Self {
        let a = &self.0;
        Self([
            a[0] * factor,
            a[1] * factor,
            a[2] * factor,
            a[3] * factor,
            a[4] * factor,
            a[5] * factor,
        ])
    }

    /// Every entry times a constant.
    #[must_use]
    #[inline(always)]
    pub fn times(&self, factor: f64) -> Self {
        let a = &self.0;
        let mut product = *a;
        for k in 0..6 {
            product[k] = a[k] * factor;
        }
        Self(product)
    }

    /// Turned with the spin of a velocity gradient over a time `dt` (Hughes & Winget 1980): `R A R^T` with
    ///
    /// $$ R = (I - \tfrac12 W dt)^{-1} (I + \tfrac12 W dt) = I + \frac{2}{1 + |a|^2} (P + P^2), \quad P = \tfrac12 W dt, $$
    ///
    /// `W = (L - L^T)/2` and `a` the axial vector of `P`. To first order in `dt` this is the rate of Jaumann,
    /// `W A - A W`; for any `dt` it is a rotation, so that no invariant changes.
    ///
    /// Where the four entries of `L` that leave the plane are zero, as in one and two dimensions, it is a rotation by one
    /// angle at a sixth of the cost. Zero is what the values say: such entries are taken to depend on nothing.
    #[must_use]
    #[inline(always)]
    pub fn turned(&self, velocity_gradient: &[[S; 3]; 3], dt: f64) -> Self {
        let stays = stays_in_plane(velocity_gradient);
        if stays.all() {
            return self.turned_in_plane(velocity_gradient, dt);
        }
        let turned = self.turned_in_space(velocity_gradient, dt);
        if stays.any() {
            return Self::select(stays, &self.turned_in_plane(velocity_gradient, dt), &turned);
        }
        turned
    }

    #[inline(always)]
    fn turned_in_space(&self, l: &[[S; 3]; 3], dt: f64) -> Self {
        // P = [[0, -c, b], [c, 0, -a], [-b, a, 0]].
        let (a, b, c) = (l[2][1] - l[1][2], l[0][2] - l[2][0], l[1][0] - l[0][1]);
        let (a, b, c) = (a * (0.25 * dt), b * (0.25 * dt), c * (0.25 * dt));
        let (aa, bb, cc) = (a.squared(), b.squared(), c.squared());
        let (ab, bc, ac) = (a * b, b * c, a * c);
        let factor = (aa + bb + cc + 1.0).recip() * 2.0;
        let mut rotation = [
            [-(bb + cc), ab - c, ac + b],
            [ab + c, -(aa + cc), bc - a],
            [ac - b, bc + a, -(aa + bb)],
        ];
        for i in 0..3 {
            for j in 0..3 {
                rotation[i][j] = rotation[i][j] * factor;
            }
            rotation[i][i] = rotation[i][i] + 1.0;
        }
        let (m, r) = (self.matrix(), rotation);
        let mut half_way = m;
        for i in 0..3 {
            for j in 0..3 {
                half_way[i][j] = r[i][0] * m[0][j] + r[i][1] * m[1][j] + r[i][2] * m[2][j];
            }
        }
        let mut turned = self.0;
        for (k, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].into_iter().enumerate()
        {
            let (h, r) = (&half_way[i], &r[j]);
            turned[k] = h[0] * r[0] + h[1] * r[1] + h[2] * r[2];
        }
        Self(turned)
    }

    /// Turned about the third axis, with `c` the tangent of half the angle.
    #[inline(always)]
    fn turned_in_plane(&self, l: &[[S; 3]; 3], dt: f64) -> Self {
        let c = (l[1][0] - l[0][1]) * (0.25 * dt);
        let [xx, yy, zz, xy, yz, xz] = self.0;
        let factor = (c.squared() + 1.0).recip() * 2.0;
        let (cosine, sine) = (factor - 1.0, factor * c);
        let shear = sine * (xx - yy) + cosine * xy * 2.0;
        let moved = sine * shear;
        Self([
            xx - moved,
            yy + moved,
            zz,
            cosine * shear - xy,
            sine * xz + cosine * yz,
            cosine * xz - sine * yz,
        ])
    }

    /// The whole matrix.
    #[must_use]
    #[inline(always)]
    pub fn matrix(&self) -> [[S; 3]; 3] {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
}

impl<S: Real> Add for Symmetric<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut sum = *a;
        for k in 0..6 {
            sum[k] = a[k] + b[k];
        }
        Self(sum)
    }
}

impl<S: Real> Sub for Symmetric<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut difference = *a;
        for k in 0..6 {
            difference[k] = a[k] - b[k];
        }
        Self(difference)
    }
}

/// `sqrt(3/2 S:S)` of a deviator: the von Mises stress (Chen et al. 2019, eq 14).
#[must_use]
#[inline(always)]
pub fn von_mises<S: Real>(deviator: &Symmetric<S>) -> S {
    (deviator.square() * 1.5).sqrt()
}

/// The determinant of `I + dt L`: by how much a step changes a volume.
///
/// Where the four entries that leave the plane are zero it is that of the plane, as in [`Symmetric::turned`].
#[must_use]
#[inline(always)]
pub fn volume_change<S: Real>(velocity_gradient: &[[S; 3]; 3], dt: f64) -> S {
    let stays = stays_in_plane(velocity_gradient);
    if stays.all() {
        return volume_change_in_plane(velocity_gradient, dt);
    }
    let change = volume_change_in_space(velocity_gradient, dt);
    when!(stays, volume_change_in_plane(velocity_gradient, dt), change)
}

#[inline(always)]
fn volume_change_in_plane<S: Real>(l: &[[S; 3]; 3], dt: f64) -> S {
    let (xx, yy, zz) = (l[0][0] * dt + 1.0, l[1][1] * dt + 1.0, l[2][2] * dt + 1.0);
    (xx * yy - l[0][1] * dt * (l[1][0] * dt)) * zz
}

#[inline(always)]
fn volume_change_in_space<S: Real>(l: &[[S; 3]; 3], dt: f64) -> S {
    let mut m = *l;
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = m[i][j] * dt;
        }
        m[i][i] = m[i][i] + 1.0;
    }
    let first = m[1][1] * m[2][2] - m[1][2] * m[2][1];
    let second = m[1][0] * m[2][2] - m[1][2] * m[2][0];
    let third = m[1][0] * m[2][1] - m[1][1] * m[2][0];
    m[0][0] * first - m[0][1] * second + m[0][2] * third
}

/// A velocity gradient with zeros, known to the compiler, where entries leave the plane of the first two axes.
#[inline(always)]
pub fn in_plane<S: Real>(l: &[[S; 3]; 3]) -> [[S; 3]; 3] {
    let zero = l[0][0].splat(0.0);
    [[l[0][0], l[0][1], zero], [l[1][0], l[1][1], zero], [zero, zero, l[2][2]]]
}

/// Where the motion stays in the plane of the first two axes, by the values.
#[inline(always)]
fn stays_in_plane<S: Real>(l: &[[S; 3]; 3]) -> S::Mask {
    let zero = l[0][0].splat(0.0);
    let mut stays = zero.at_least(zero);
    for entry in [l[0][2], l[1][2], l[2][0], l[2][1]] {
        stays = stays.and(entry.at_least(zero)).and(zero.at_least(entry));
    }
    stays
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_tensor_keeps_its_invariants_and_follows_the_rate_of_jaumann() {
        let stress = Symmetric([1.0, -2.0, 0.5, 0.3, -0.7, 0.2]);
        let l = [[0.1, 0.7, -0.3], [-0.2, 0.4, 0.9], [0.5, -0.6, -0.2]];
        for dt in [1e-6, 0.5, 20.0] {
            let turned = stress.turned(&l, dt);
            assert!((turned.trace() - stress.trace()).abs() < 1e-14);
            assert!((turned.contract(&turned) - stress.contract(&stress)).abs() < 1e-13);
        }
        let (dt, m) = (1e-6, stress.matrix());
        let turned = stress.turned(&l, dt).matrix();
        let w = |i: usize, j: usize| 0.5 * (l[i][j] - l[j][i]);
        for i in 0..3 {
            for j in 0..3 {
                let rate: f64 = (0..3).map(|k| w(i, k) * m[k][j] - m[i][k] * w(k, j)).sum();
                // The next term is of order dt.
                assert!(((turned[i][j] - m[i][j]) / dt - rate).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn in_the_plane_the_rotation_is_the_general_one() {
        let stress = Symmetric([1.0, -2.0, 0.5, 0.3, -0.7, 0.2]);
        for dt in [1e-3, 0.5, 20.0] {
            let flat = [[0.1, 0.7, 0.0], [-0.2, 0.4, 0.0], [0.0, 0.0, 0.3]];
            // Symmetric entries out of the plane do not spin, but take the general way.
            let mut general = flat;
            (general[0][2], general[2][0]) = (0.6, 0.6);
            let (a, b) = (stress.turned(&flat, dt), stress.turned(&general, dt));
            for k in 0..6 {
                assert!((a.0[k] - b.0[k]).abs() < 1e-14, "{k}");
            }
        }
    }

    #[test]
    fn the_change_of_volume_is_a_determinant() {
        let l = [[1.0, 2.0, 0.0], [0.0, 3.0, 4.0], [5.0, 0.0, 6.0]];
        // det [[2, 2, 0], [0, 4, 4], [5, 0, 7]] = 2 * 28 - 2 * (0 - 20) = 96
        assert!((volume_change(&l, 1.0) - 96.0_f64).abs() < 1e-12);
        // In the plane: (2 * 4 - 2 * 5) * 7 = -14.
        let flat = [[1.0, 2.0, 0.0], [5.0, 3.0, 0.0], [0.0, 0.0, 6.0]];
        assert!((volume_change(&flat, 1.0) + 14.0_f64).abs() < 1e-12);
    }
}
