//! The passes of the flow-map fit over the lattice, compiled for every level of registers.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{MOST_LANES, Registers, Work};

use super::lattice_sums::{LatticeSums, PART};
use super::stencils::Stencils;
use crate::parallel::Split;
use crate::score::Carried;
use crate::score::cells::{damped_push_forward, is_thick, push_forward, volume};

/// A cell smaller than this part of the mean of those around it is not resolved.
pub const SMALLEST_CELL: f64 = 0.135;

/// A lattice as the passes need it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice<'a, const D: usize> {
    pub(crate) stencils: &'a Stencils<D>,
    pub(crate) sums: &'a LatticeSums<D>,
}

/// Deformation, volume and density of the cells of a part, and the departure from the Gaussian that follows from them.
pub(crate) struct Deform<'a, const D: usize> {
    pub(crate) lattice: Lattice<'a, D>,
    pub(crate) part: usize,
    /// Positions `y`, the same in blocks, and masses of all particles.
    pub(crate) y: &'a [[f64; D]],
    pub(crate) blocks: &'a [[f64; 4]],
    pub(crate) masses: &'a [f64],
    pub(crate) out: Deformed<'a, D>,
}

/// Output of [`Deform`]: an entry for each particle of the part.
pub(crate) struct Deformed<'a, const D: usize> {
    pub(crate) deformation: &'a mut [[[f64; D]; D]],
    pub(crate) volume: &'a mut [f64],
    pub(crate) density: &'a mut [f64],
    pub(crate) departure: &'a mut [f64],
    pub(crate) upright: &'a mut [f64],
    pub(crate) fours: &'a mut [[f64; 4]],
}

impl<const D: usize> Split for Deformed<'_, D> {
    fn n(&self) -> usize {
        self.volume.len()
    }

    fn split(self, at: usize) -> (Self, Self) {
        let (deformation, deformation_high) = self.deformation.split_at_mut(at);
        let (volume, volume_high) = self.volume.split_at_mut(at);
        let (density, density_high) = self.density.split_at_mut(at);
        let (departure, departure_high) = self.departure.split_at_mut(at);
        let (upright, upright_high) = self.upright.split_at_mut(at);
        let (fours, fours_high) = self.fours.split_at_mut(at);
        let high = Self {
            deformation: deformation_high,
            volume: volume_high,
            density: density_high,
            departure: departure_high,
            upright: upright_high,
            fours: fours_high,
        };
        (Self { deformation, volume, density, departure, upright, fours }, high)
    }
}

impl<const D: usize> Work<f64> for Deform<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { lattice: Lattice { stencils, sums }, part, y, blocks, masses, out } = self;
        let mut columns = [[[0.0; D]; PART]; D];
        sums.gradients(registers, stencils, part, (y, blocks), &mut columns);
        let n = out.volume.len();
        let here = part * PART..part * PART + n;
        for (p, f) in out.deformation.iter_mut().enumerate() {
            for k in 0..D {
                for l in 0..D {
                    f[k][l] = columns[l][p][k];
                }
            }
            out.volume[p] = volume(f);
        }
        let (y, masses) = (&y[here.clone()], &masses[here]);
        let (volume, density) = (&out.volume[..n], &mut out.density[..n]);
        let (departure, upright) = (&mut out.departure[..n], &mut out.upright[..n]);
        for p in 0..n {
            let is_upright = volume[p] > 0.0;
            density[p] = masses[p] / volume[p];
            let d = logarithm(density[p]) + half_square(&y[p]);
            departure[p] = if is_upright { d } else { 0.0 };
            upright[p] = if is_upright { volume[p] } else { 0.0 };
        }
        for (p, four) in out.fours.iter_mut().enumerate() {
            *four = [departure[p], departure[p], departure[p], upright[p]];
        }
    }
}

/// What a pass of [`Differentiate`] computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Which cells are resolved: those that are upright and no smaller than [`SMALLEST_CELL`] of those around them.
    Check,
    /// The same and the score.
    CheckAndScore,
    /// The score; all cells count as resolved, those that were not have been repaired.
    Score,
}

/// Which cells are resolved, and the score inside the lattice.
pub(crate) struct Differentiate<'a, const D: usize> {
    pub(crate) lattice: Lattice<'a, D>,
    pub(crate) part: usize,
    pub(crate) pass: Pass,
    /// Singular values of a deformation are taken as no smaller.
    pub(crate) least: f64,
    /// Of all particles.
    pub(crate) y: &'a [[f64; D]],
    pub(crate) deformation: &'a [[[f64; D]; D]],
    pub(crate) volume: &'a [f64],
    pub(crate) carried: &'a Carried,
    /// Of the part.
    pub(crate) score: &'a mut [[f64; D]],
    /// Becomes NaN where a cell is not resolved.
    pub(crate) density: &'a mut [f64],
}

impl<const D: usize> Work<f64> for Differentiate<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { lattice: Lattice { stencils, sums }, part, carried, .. } = self;
        let (mut on_lattice, mut mean) = ([[0.0; PART]; D], [0.0; PART]);
        let fields = (&carried.departure[..], &carried.upright[..], &carried.fours[..]);
        let out = (&mut on_lattice, &mut mean);
        sums.gradients_and_means(registers, stencils, part, fields, out);

        let (n, first) = (self.density.len(), part * PART);
        let deformation = &self.deformation[first..first + n];
        let (y, score) = (&self.y[first..first + n], &mut self.score[..n]);
        if self.pass != Pass::Score {
            let volume = &self.volume[first..first + n];
            for (p, density) in self.density.iter_mut().enumerate() {
                // A mean is not negative.
                let is_resolved = volume[p] > SMALLEST_CELL * mean[p];
                *density = if is_resolved { *density } else { f64::NAN };
            }
        }
        if self.pass == Pass::Check {
            return;
        }
        let mut thick = [true; PART];
        for p in 0..n {
            let mut g = [0.0; D];
            for l in 0..D {
                g[l] = on_lattice[l][p];
            }
            let gradient = push_forward(&deformation[p], &g);
            for k in 0..D {
                score[p][k] = gradient[k] - y[p][k];
            }
            thick[p] = is_thick(&deformation[p], self.least);
        }
        if thick.iter().fold(true, |all, is_thick| all & is_thick) {
            return;
        }
        let is_thin = |p: &usize| !thick[*p] && !stencils.at_rim(first + p);
        let mut thin = [0; MOST_LANES];
        let mut found = 0;
        for p in (0..n).filter(is_thin) {
            thin[found] = p;
            found += 1;
            if found == R::N {
                damp(registers, &thin[..found], (deformation, &on_lattice), self.least, y, score);
                found = 0;
            }
        }
        damp(registers, &thin[..found], (deformation, &on_lattice), self.least, y, score);
    }
}

/// Replaces the scores of some particles of a part, a lane each, by those with gradients that are damped across thin cells.
#[inline(always)]
fn damp<R: Registers<f64>, const D: usize>(
    registers: R,
    thin: &[usize],
    (deformation, on_lattice): (&[[[f64; D]; D]], &[[f64; PART]; D]),
    least: f64,
    y: &[[f64; D]],
    score: &mut [[f64; D]],
) {
    if thin.is_empty() {
        return;
    }
    let mut f_lanes = [[[0.0; MOST_LANES]; D]; D];
    let mut g_lanes = [[0.0; MOST_LANES]; D];
    for (lane, &p) in thin.iter().enumerate() {
        for k in 0..D {
            g_lanes[k][lane] = on_lattice[k][p];
            for l in 0..D {
                f_lanes[k][l][lane] = deformation[p][k][l];
            }
        }
    }
    let (mut f, mut g) = ([[registers.splat(0.0); D]; D], [registers.splat(0.0); D]);
    for k in 0..D {
        g[k] = registers.load_at(&g_lanes[k], 0);
        for l in 0..D {
            f[k][l] = registers.load_at(&f_lanes[k][l], 0);
        }
    }
    let damped = damped_push_forward(&f, &g, least);
    for k in 0..D {
        registers.store_at(damped[k], &mut g_lanes[k], 0);
    }
    for (lane, &p) in thin.iter().enumerate() {
        for k in 0..D {
            score[p][k] = g_lanes[k][lane] - y[p][k];
        }
    }
}

/// Positions of a part, moved towards the polynomial's value by a share of the distance.
pub(crate) struct Settle<'a, const D: usize> {
    pub(crate) lattice: Lattice<'a, D>,
    pub(crate) part: usize,
    /// Positions of all particles before.
    pub(crate) before: &'a [[f64; D]],
    pub(crate) share: f64,
    /// Rate of each particle over that of the share; empty where all are 1.
    pub(crate) rates: &'a [f64],
    /// Of the part.
    pub(crate) x: &'a mut [[f64; D]],
}

impl<const D: usize> Work<f64> for Settle<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<R: Registers<f64>>(self, registers: R) {
        let Self { lattice: Lattice { stencils, sums }, part, before, share, rates, x } = self;
        sums.values(registers, stencils, part, before, x);
        let here = part * PART..part * PART + x.len();
        let before = &before[here.clone()];
        if rates.is_empty() {
            for (x, before) in x.as_flattened_mut().iter_mut().zip(before.as_flattened()) {
                *x = before + share * (*x - before);
            }
            return;
        }
        let rest = (1.0 - share).ln();
        let mut shares = [0.0; PART];
        for (share, rate) in shares.iter_mut().zip(&rates[here]) {
            *share = 1.0 - simd_lanes::exp(rate * rest);
        }
        for ((x, before), share) in x.iter_mut().zip(before).zip(&shares) {
            for k in 0..D {
                x[k] = before[k] + share * (x[k] - before[k]);
            }
        }
    }
}

/// `|y|^2 / 2`: minus the logarithm of the unit Gaussian, but for a constant.
#[inline(always)]
pub(crate) fn half_square<const D: usize>(y: &[f64; D]) -> f64 {
    0.5 * y.iter().fold(0.0, |sum, c| sum + c * c)
}

/// `ln x` for positive `x`, those below the normal numbers included.
#[inline(always)]
fn logarithm(x: f64) -> f64 {
    const LIFT: f64 = (1_u64 << 54) as f64;
    const LN_LIFT: f64 = 54.0 * std::f64::consts::LN_2;
    let is_small = x < f64::MIN_POSITIVE;
    let lifted = simd_lanes::ln(if is_small { x * LIFT } else { x });
    lifted - if is_small { LN_LIFT } else { 0.0 }
}
