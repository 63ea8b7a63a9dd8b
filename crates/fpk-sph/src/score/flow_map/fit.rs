//! The estimator that follows the flow: local polynomials over the lattice that the particles started from.

use neighbour_search::Criterion;
use simd_lanes::SimdLevel;

use super::lattice_sums::{LatticeSums, PART};
use super::passes::{Deform, Deformed, Differentiate, Lattice, Pass, SMALLEST_CELL, Settle};
use super::stencils::Stencils;
use crate::cloud::Cloud;
use crate::error::Error;
use crate::parallel::for_each_part;
use crate::score::cell_geometry::determinant;
use crate::score::cells::trace_on_lattice;
use crate::score::monomials::{Monomials, unknowns};
use crate::score::settling::Settling;
use crate::score::{Carried, Degree, Estimates, LatticePlaces, LocalMap, ScoreEstimator};

/// Density and score from the flow map `y(X)`, where `X` are places on the lattice of the start. With the deformation
/// gradient `F = dy/dX`, in spacings, and masses that never change,
///
/// $$ \psi(y(X)) = \frac{\mu(X)}{\det F(X)}, \qquad
/// \nabla\log\psi = -y + F^{-T} \nabla_X \left( \log\psi + \tfrac12 |y|^2 \right), $$
///
/// in whitened coordinates. Both derivatives are those of local polynomials over the lattice neighbours, whose weights are
/// computed once: no search, no equations to solve in a step. What is differentiated is the departure from the cloud's
/// Gaussian, so a Gaussian is carried without error of space by any lattice.
///
/// * At the rim, where neighbours lie on one side, the departure's gradient is the mean of those further inside: one-sided
///   gradients of one-sided gradients let modes at the rim grow.
/// * Across a cell that the flow has made thinner than `thinnest` spacings, the departure's gradient is damped: the fit
///   degrades in the collapsed direction only, and the step does not collapse with it.
/// * A cell that is turned over, or smaller than [`SMALLEST_CELL`] of those around it, is not resolved: it takes its
///   departure and deformation from its neighbours. [`Estimates::unresolved`] counts such cells with their mass.
///
/// A total Lagrangian method; the source is this project.
#[derive(Debug, Clone, Default)]
pub struct FlowMapFit<const D: usize> {
    degree: usize,
    /// Spacing in the metric at the start.
    spacing: f64,
    /// Square of the length that the diffusion limit holds against, in spacings.
    resolved: f64,
    thinnest: f64,
    settling: Settling,
    /// Rate of settling of each particle over the uniform one; none where all are uniform.
    settling_rates: Vec<f64>,
    stencils: Stencils<D>,
    sums: LatticeSums<D>,
    level: Level,
}

/// The registers that the passes use.
#[derive(Debug, Clone, Copy)]
struct Level(SimdLevel);

impl Default for Level {
    fn default() -> Self {
        Self(SimdLevel::best())
    }
}

/// Means over resolved cells, for one that is not.
struct Taken<const D: usize> {
    i: usize,
    departure: f64,
    deformation: [[f64; D]; D],
    volume: f64,
}

/// Trace of the diffusion matrix on the lattice times step times the steepest gradient's square is at most this times the
/// scheme's diffusion limit: 2.6 for Runge-Kutta 4, whose interval ends at 2.785. The cubic over 2.8 spacings in 2-D would
/// have 3.7 with its reach alone.
pub(crate) const WAVE_DAMPING: f64 = 10.4;

impl<const D: usize> FlowMapFit<D> {
    /// An estimator of the given degree that resolves cells down to `thinnest` spacings, with uniform settling.
    #[must_use]
    pub fn new(degree: Degree, thinnest: f64) -> Self {
        Self::with_settling(degree, thinnest, Settling::UNIFORM)
    }

    /// As [`Self::new`], with the given time constants of settling.
    #[must_use]
    pub fn with_settling(degree: Degree, thinnest: f64, settling: Settling) -> Self {
        Self { degree: degree.value(), thinnest, settling, ..Self::default() }
    }

    fn lattice(&self) -> Lattice<'_, D> {
        Lattice { stencils: &self.stencils, sums: &self.sums }
    }

    /// Deformation, volume, density and departure of every particle.
    fn deform(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) {
        let (lattice, y, masses) = (self.lattice(), cloud.positions, cloud.masses);
        let Estimates { deformation, volume, density, carried, .. } = out;
        let Carried { departure, upright, fours, blocks, .. } = carried;
        LatticeSums::blocks_of(y, blocks);
        let blocks = &blocks[..];
        let all = Deformed { deformation, volume, density, departure, upright, fours };
        for_each_part(all, PART, &|part, out| {
            self.level.0.run(Deform { lattice, part, y, blocks, masses, out });
        });
    }

    /// Scores, or which cells are resolved: the density of one that is not becomes NaN.
    fn differentiate(&self, pass: Pass, y: &[[f64; D]], out: &mut Estimates<D>) {
        let lattice = self.lattice();
        let least = self.thinnest * self.spacing;
        let Estimates { score, density, deformation, volume, carried, .. } = out;
        let (deformation, volume, carried) = (&deformation[..], &volume[..], &*carried);
        for_each_part((&mut score[..], &mut density[..]), PART, &|part, (score, density)| {
            self.level.0.run(Differentiate {
                lattice,
                part,
                pass,
                least,
                y,
                deformation,
                volume,
                carried,
                score,
                density,
            });
        });
        if pass != Pass::Check {
            self.stencils.score_at_rim(y, score);
        }
    }

    /// Looks again at the cells that have one that is turned over among their members: the mean is that of the others.
    fn check_near_turned(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) {
        let Estimates { density, volume, carried: Carried { near_turned, .. }, .. } = out;
        near_turned.fill(false);
        for i in (0..volume.len()).filter(|&i| is_turned(volume[i])) {
            for &j in self.stencils.of(i).members {
                near_turned[j as usize] = true;
            }
        }
        for i in (0..volume.len()).filter(|&i| near_turned[i]) {
            let is_resolved = self.is_resolved(volume, i);
            density[i] = if is_resolved { cloud.masses[i] / volume[i] } else { f64::NAN };
        }
    }

    /// Whether the cell of particle `i` is upright and no smaller than [`SMALLEST_CELL`] of those around it.
    fn is_resolved(&self, volume: &[f64], i: usize) -> bool {
        let stencil = self.stencils.of(i);
        // Four sums side by side: none waits for the one before.
        let (mut mean, mut total) = ([0.0; 4], [0.0; 4]);
        for (members, weights) in stencil.members.chunks(4).zip(stencil.weights.mean.chunks(4)) {
            for (k, (&j, &weight)) in members.iter().zip(weights).enumerate() {
                let v = volume[j as usize];
                let (weight, v) = if v > 0.0 { (weight, v) } else { (0.0, 0.0) };
                mean[k] += weight * v;
                total[k] += weight;
            }
        }
        let [mean, total] = [mean, total].map(|sums| (sums[0] + sums[1]) + (sums[2] + sums[3]));
        volume[i] > 0.0 && volume[i] * total > SMALLEST_CELL * mean
    }

    /// The mean over the resolved neighbours of particle `i`, whose cell is not resolved; `None` if no neighbour is.
    fn mean_of_resolved(&self, i: usize, out: &Estimates<D>) -> Option<Taken<D>> {
        let stencil = self.stencils.of(i);
        let mut taken = Taken { i, departure: 0.0, deformation: [[0.0; D]; D], volume: 0.0 };
        let mut total = 0.0;
        for (&j, weight) in stencil.members.iter().zip(&stencil.weights.mean) {
            let j = j as usize;
            if out.density[j].is_nan() {
                continue;
            }
            total += weight;
            taken.departure += weight * out.carried.departure[j];
            taken.volume += weight * out.volume[j];
            for k in 0..D {
                for l in 0..D {
                    taken.deformation[k][l] += weight * out.deformation[j][k][l];
                }
            }
        }
        if total == 0.0 {
            return None;
        }
        taken.departure /= total;
        taken.volume /= total;
        taken.deformation = taken.deformation.map(|row| row.map(|value| value / total));
        Some(taken)
    }

    /// Replaces unresolved cells by the mean of their resolved neighbours, layer by layer from the outside; returns whether
    /// there were any.
    fn repair(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<bool, Error> {
        if !out.density.iter().fold(false, |any, density| any | density.is_nan()) {
            return Ok(false);
        }
        let mut left: Vec<usize> =
            (0..out.density.len()).filter(|&i| out.density[i].is_nan()).collect();
        for &i in &left {
            out.unresolved.add(i, cloud.masses);
        }
        while let Some(&first) = left.first() {
            let taken: Vec<_> =
                left.iter().filter_map(|&i| self.mean_of_resolved(i, out)).collect();
            if taken.is_empty() {
                let (step, time, value) = (cloud.step, cloud.time, out.volume[first]);
                let quantity = "cell volume";
                return Err(Error::LeftStableRange {
                    step,
                    time,
                    particle: first,
                    quantity,
                    value,
                });
            }
            for Taken { i, departure, deformation, volume } in &taken {
                (out.deformation[*i], out.volume[*i]) = (*deformation, *volume);
                out.density[*i] = cloud.masses[*i] / volume;
                out.carried.departure[*i] = *departure;
                out.carried.fours[*i][..3].fill(*departure);
            }
            left.retain(|&i| out.density[i].is_nan());
        }
        Ok(true)
    }
}

/// Whether a cell of the given volume is turned over, or none at all.
#[allow(clippy::inline_always, reason = "so that a loop is compiled for registers")]
#[inline(always)]
fn is_turned(volume: f64) -> bool {
    volume.is_nan() || volume <= 0.0
}

/// Lengths of the points of the unit lattice up to `reach`, the origin excluded.
fn lattice_distances<const D: usize>(reach: f64) -> impl Iterator<Item = f64> {
    // More than 64 spacings make no difference to a count against tens.
    let half = (1..=64).take_while(|&k| f64::from(k) <= reach).last().unwrap_or(0);
    let edge = 2 * half + 1;
    let total = (0..D).fold(1_i32, |product, _| product.saturating_mul(edge));
    (0..total).filter_map(move |index| {
        let (mut rest, mut square) = (index, 0);
        for _ in 0..D {
            let coordinate = rest % edge - half;
            square += coordinate * coordinate;
            rest /= edge;
        }
        let distance = f64::from(square).sqrt();
        (square > 0 && distance <= reach).then_some(distance)
    })
}

impl<const D: usize> ScoreEstimator<D> for FlowMapFit<D> {
    fn support(&self) -> f64 {
        1.0
    }

    fn criterion(&self) -> Option<Criterion> {
        None
    }

    /// Refuses a neighbourhood that cannot carry the degree inside the lattice.
    fn check_resolution(&self, support_over_spacing: f64) -> Result<(), Error> {
        let count = lattice_distances::<D>(support_over_spacing).count() + 1;
        let carried = Monomials::carried_by::<D>(count, self.degree, 1.5);
        match Monomials::of_degree::<D>(self.degree) {
            None => Err(Error::DegreeTooHigh { degree: self.degree, dimension: D }),
            Some(asked) if carried.is_none_or(|found| found.n_unknowns < asked.n_unknowns) => {
                let limit = unknowns(D, self.degree) * 3 / 2;
                Err(Error::SupportTooSmall {
                    ratio: support_over_spacing,
                    count,
                    limit,
                    dimension: D,
                })
            }
            Some(_) => Ok(()),
        }
    }

    fn start(&mut self, lattice: &LatticePlaces<'_, D>) -> Result<(), Error> {
        self.settling.check()?;
        self.spacing = lattice.spacing;
        self.stencils =
            Stencils::new(lattice.places, lattice.neighbours, lattice.reach, self.degree)?;
        self.sums = LatticeSums::new(&self.stencils, lattice.places.len());
        self.settling_rates = self.settling.relative_rates(lattice.places, lattice.spacing);
        let steepest = self.stencils.steepest_wave(lattice.places);
        self.resolved = lattice.reach.powi(2).min(WAVE_DAMPING / steepest.powi(2));
        Ok(())
    }

    fn estimate(&self, cloud: &Cloud<'_, D>, out: &mut Estimates<D>) -> Result<(), Error> {
        out.fits = self.stencils.fits;
        out.carried.resize(cloud.n_particles());
        self.deform(cloud, out);
        // Looks at all, so that registers take several.
        let any_turned = out.volume.iter().fold(false, |any, v| any | is_turned(*v));
        if any_turned {
            self.differentiate(Pass::Check, cloud.positions, out);
            self.check_near_turned(cloud, out);
        } else {
            self.differentiate(Pass::CheckAndScore, cloud.positions, out);
        }
        if self.repair(cloud, out)? {
            self.differentiate(Pass::Score, cloud.positions, out);
        }
        Ok(())
    }

    /// `trace(F^-1 D F^-T)` over the square of a length on the lattice, with cells no thinner than the thinnest. A wave
    /// decays at the rate of that trace times the square of what the gradient makes of it, which must stay within the
    /// stability interval of the scheme: the length is the reach, or less where the gradient is steeper.
    #[allow(clippy::inline_always, reason = "what is not inlined is not compiled for registers")]
    #[inline(always)]
    fn spread(&self, diffusion: &[[f64; D]; D], _: f64, deformation: &[[f64; D]; D]) -> f64 {
        let trace: f64 = (0..D).map(|k| diffusion[k][k]).sum();
        let across = trace_on_lattice(deformation, diffusion);
        let most = trace / (self.thinnest * self.spacing).powi(2);
        across.min(most).max(0.0) / self.resolved
    }

    fn settle(&self, x: &mut [[f64; D]], before: &mut [[f64; D]], share: f64) {
        before.copy_from_slice(x);
        let (lattice, before, rates) = (self.lattice(), &*before, &self.settling_rates[..]);
        for_each_part(x, PART, &|part, x| {
            self.level.0.run(Settle { lattice, part, before, share, rates, x });
        });
    }

    fn local_maps(&self, cloud: &Cloud<'_, D>) -> Option<Vec<LocalMap<D>>> {
        let log_mass: Vec<f64> = cloud.masses.iter().map(|mu| mu.ln()).collect();
        let map = |i: usize| {
            let stencil = self.stencils.of(i);
            let mut map = LocalMap {
                edges: [[0.0; D]; D],
                curvature: [[[0.0; D]; D]; D],
                slope: stencil.gradient_of(&log_mass),
                bend: [[0.0; D]; D],
                resolved: true,
            };
            for (p, &j) in stencil.members.iter().enumerate() {
                let (j, gradient, hessian) = (j as usize, stencil.gradient(p), stencil.hessian(p));
                for k in 0..D {
                    for l in 0..D {
                        map.edges[k][l] += cloud.positions[j][k] * gradient[l];
                        map.bend[k][l] += log_mass[j] * hessian[k][l];
                        for m in 0..D {
                            map.curvature[m][k][l] += cloud.positions[j][m] * hessian[k][l];
                        }
                    }
                }
            }
            map
        };
        let mut maps: Vec<_> = (0..cloud.n_particles()).map(map).collect();
        let volume: Vec<f64> = maps.iter().map(|map| determinant(&map.edges)).collect();
        for (i, map) in maps.iter_mut().enumerate() {
            map.resolved = self.is_resolved(&volume, i);
        }
        Some(maps)
    }
}

#[cfg(test)]
mod tests {
    use neighbour_search::{CellGrid, NeighbourList, NeighbourSearch, Radii};
    use particle_store::Lattice as Places;

    use super::super::passes::half_square;
    use super::*;
    use crate::score::Unresolved;

    /// What the estimator makes of positions on a ball, at every level.
    fn estimates<const D: usize>(
        spacing: f64,
        place: impl Fn([f64; D]) -> [f64; D],
    ) -> Vec<Estimates<D>> {
        let lattice = Places::<D>::ball_lattice(4.0, spacing).unwrap();
        let places: Vec<[f64; D]> = lattice.indices.iter().map(|i| i.map(f64::from)).collect();
        let mut neighbours = NeighbourList::new();
        CellGrid::new().full_list(&places, Radii::Uniform(2.8), &mut neighbours).unwrap();
        neighbours.sort_rows();
        let positions: Vec<[f64; D]> = lattice.points.iter().map(|&p| place(p)).collect();
        let masses: Vec<f64> = lattice.points.iter().map(|p| (-half_square(p)).exp()).collect();
        let n = places.len();
        let cloud = Cloud {
            positions: &positions,
            masses: &masses,
            smoothing_lengths: &vec![1.0; n],
            neighbours: &neighbours,
            lattice: &[],
            whitened: true,
            step: 0,
            time: 0.0,
        };
        let estimate = |level| {
            let mut fit = FlowMapFit::<D>::new(Degree::Cubic, 0.2);
            fit.level = Level(level);
            let (places, neighbours) = (&places[..], &neighbours);
            fit.start(&LatticePlaces { places, neighbours, reach: 2.8, spacing }).unwrap();
            let mut out = Estimates::new(n);
            fit.estimate(&cloud, &mut out).unwrap();
            let (mut x, mut before) = (positions.clone(), positions.clone());
            fit.settle(&mut x, &mut before, 0.3);
            out.score.extend(x);
            fit.settling_rates = Settling::GRADED.relative_rates(places, spacing);
            let mut x = positions.clone();
            fit.settle(&mut x, &mut before, 0.3);
            out.score.extend(x);
            out
        };
        SimdLevel::available().map(estimate).collect()
    }

    fn levels_agree<const D: usize>(
        spacing: f64,
        place: impl Fn([f64; D]) -> [f64; D],
    ) -> Unresolved {
        let all = estimates(spacing, place);
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        for other in &all[1..] {
            assert_eq!(bits(other.score.as_flattened()), bits(all[0].score.as_flattened()));
            assert_eq!(bits(&other.density), bits(&all[0].density));
            assert_eq!(bits(&other.volume), bits(&all[0].volume));
            assert_eq!(other.deformation, all[0].deformation);
            assert_eq!(other.unresolved, all[0].unresolved);
        }
        all[0].unresolved
    }

    #[test]
    fn every_level_gives_the_same_bits_for_thin_and_for_folded_cells_too() {
        let bent = |[x, y]: [f64; 2]| [x + 0.1 * y * y, y - 0.05 * x * y];
        assert_eq!(levels_agree(0.37, bent).particles, 0);
        // The width in x falls to 1e-4 over the upper half; x runs back around the origin.
        let squeezed = |[x, y]: [f64; 2]| [x * 10.0_f64.powf(-y.max(0.0)), y + 0.1 * x * x];
        levels_agree(0.4, squeezed);
        let folded = |[x, y]: [f64; 2]| [x - 2.2 * x * (-0.5 * x * x).exp(), y];
        assert!(levels_agree(0.4, folded).particles > 10);
        let thin = |[x, y, z]: [f64; 3]| [x + 0.4 * y, 0.05 * y + 0.02 * z * z, z + 0.02 * x * x];
        assert_eq!(levels_agree(0.7, thin).particles, 0);
        let folded = |[x, y, z]: [f64; 3]| [x - 2.2 * x * (-0.5 * x * x).exp(), y + 0.1 * z, z];
        assert!(levels_agree(0.7, folded).particles > 10);
        levels_agree(1.0, |[x, y, z, w]: [f64; 4]| [x + 0.1 * y * y, y, 0.03 * z, w + 0.2 * x]);
    }
}
