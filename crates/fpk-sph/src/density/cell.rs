//! A lattice cell as the flow has deformed it, with the density over it.

use crate::score::LocalMap;

/// `y(u) = centre + E u + u.K u / 2` and the mass per unit of `u`, `weight exp(slope.u + u.bend u / 2)`, in lattice
/// coordinates `u` of the cell, from -1/2 to 1/2.
#[derive(Debug)]
pub(super) struct Cell<const D: usize> {
    /// Centre in the metric.
    pub(super) centre: [f64; D],
    pub(super) map: LocalMap<D>,
    pub(super) weight: f64,
    /// Places on the lattice beyond the cloud to which this cell goes on, as steps from it.
    pub(super) beyond: Vec<[i32; D]>,
    /// Mass with what lies beyond.
    pub(super) mass: f64,
}

/// Subdivisions of a cell per axis: about a hundred points where the dimension allows.
pub(super) const fn subdivisions(dimension: usize) -> usize {
    match dimension {
        1 => 64,
        2 => 12,
        3 => 5,
        4 => 3,
        _ => 2,
    }
}

impl<const D: usize> Cell<D> {
    /// Takes in those places beyond the cloud towards which the mass falls. A cell that goes on has its map taken as
    /// affine: a curvature by neighbours on one side is no ground to go beyond them.
    pub(super) fn go_on(&mut self, beyond: Vec<[i32; D]>) {
        if beyond.is_empty() {
            return;
        }
        self.map.curvature = [[[0.0; D]; D]; D];
        self.beyond = beyond;
        let LocalMap { slope, bend, .. } = self.map;
        self.beyond.retain(|step| {
            let (mut along, mut curvature) = (0.0, 0.0);
            for k in 0..D {
                along += slope[k] * f64::from(step[k]);
                for l in 0..D {
                    curvature += f64::from(step[k]) * bend[k][l] * f64::from(step[l]);
                }
            }
            curvature <= 0.0 && along + 0.5 * curvature < 0.0
        });
    }

    /// The point with the lattice coordinates `u` of the cell.
    pub(super) fn point(&self, u: &[f64; D]) -> [f64; D] {
        let mut y = self.centre;
        for k in 0..D {
            for a in 0..D {
                y[k] += self.map.edges[k][a] * u[a];
                for b in 0..D {
                    y[k] += 0.5 * u[a] * self.map.curvature[k][a][b] * u[b];
                }
            }
        }
        y
    }

    /// `exp(slope.u + u.bend u / 2)` at the lattice coordinates `u`.
    fn shape(&self, u: &[f64; D]) -> f64 {
        let mut exponent = 0.0;
        for k in 0..D {
            exponent += self.map.slope[k] * u[k];
            for l in 0..D {
                exponent += 0.5 * u[k] * self.map.bend[k][l] * u[l];
            }
        }
        exponent.exp()
    }

    /// By how much the logarithm of the mass per unit of `u` grows across a part along each axis.
    pub(super) fn slope_across_part(&self, u: &[f64; D]) -> [f64; D] {
        let LocalMap { slope, bend, .. } = &self.map;
        std::array::from_fn(|k| {
            (slope[k] + (0..D).map(|l| bend[k][l] * u[l]).sum::<f64>()) / subdivisions(D) as f64
        })
    }

    /// The mean of the mass per unit of `u` over a part, over its value at the centre: of `exp(slope s + bend s^2 / 2)` for
    /// `s` from -1/2 to 1/2 along each axis.
    pub(super) fn mean_over_part(&self, u: &[f64; D]) -> f64 {
        self.mean_by_bend(u, &self.means_of_bend())
    }

    /// The factor of the curvature in [`mean_over_part`](Self::mean_over_part) along each axis, the same for all parts.
    fn means_of_bend(&self) -> [f64; D] {
        let parts = subdivisions(D) as f64;
        std::array::from_fn(|k| (self.map.bend[k][k] / (24.0 * parts * parts)).exp())
    }

    fn mean_by_bend(&self, u: &[f64; D], means_of_bend: &[f64; D]) -> f64 {
        let slope = self.slope_across_part(u);
        (0..D).map(|k| sinhc(0.5 * slope[k]) * means_of_bend[k]).product()
    }

    pub(super) fn integral(&self) -> f64 {
        let mut mass = 0.0;
        self.for_each_part(|_, part| mass += part);
        mass
    }

    /// Calls with the centre (lattice coordinates) and the mass of every part of the cell and of what lies beyond.
    pub(super) fn for_each_part(&self, mut visit: impl FnMut(&[f64; D], f64)) {
        let parts = subdivisions(D);
        let part_weight = self.weight / (parts as f64).powi(i32::try_from(D).unwrap_or(0));
        let means_of_bend = self.means_of_bend();
        for place in std::iter::once(&[0; D]).chain(&self.beyond) {
            let mut index = [0; D];
            'parts: loop {
                let u: [f64; D] = std::array::from_fn(|k| {
                    f64::from(place[k]) + (index[k] as f64 + 0.5) / parts as f64 - 0.5
                });
                visit(&u, part_weight * self.shape(&u) * self.mean_by_bend(&u, &means_of_bend));
                // The next index, first axis fastest.
                for axis in 0..D {
                    index[axis] += 1;
                    if index[axis] < parts {
                        continue 'parts;
                    }
                    index[axis] = 0;
                }
                break;
            }
        }
    }

    /// Fills `parts` with all parts of the cell and of what lies beyond.
    pub(super) fn parts(&self, demand: impl Fn(&[f64; D]) -> f64, parts: &mut Vec<Part<D>>) {
        parts.clear();
        self.for_each_part(|u, mass| {
            parts.push(Part {
                mass,
                beyond: u.iter().any(|u_k| u_k.abs() > 0.5),
                slope: self.slope_across_part(u),
                centre: demand(u),
                faces: faces_of_part(&demand, u),
            });
        });
    }

    /// Whether the demand is further from the threshold, at the centre of the cell and of each of those beyond, than twice
    /// what it varies from there to any corner: no part of them comes near.
    pub(super) fn is_far(&self, demand_above_threshold: impl Fn(&[f64; D]) -> f64) -> bool {
        std::iter::once(&[0; D]).chain(&self.beyond).all(|place| {
            let centre = demand_above_threshold(&place.map(f64::from));
            let to_corner =
                |bits: usize| (demand_above_threshold(&corner(place, bits)) - centre).abs();
            let variation = (0..1 << D).map(to_corner).fold(0.0, f64::max);
            centre.abs() > 2.0 * variation
        })
    }

    /// The greatest demand at the centre and at all corners of the cell and of what lies beyond; NaN if one of them is.
    pub(super) fn greatest(&self, demand: impl Fn(&[f64; D]) -> f64) -> f64 {
        std::iter::once(&[0; D])
            .chain(&self.beyond)
            .flat_map(|place| (0..1 << D).map(|bits| corner(place, bits)))
            .map(|corner| demand(&corner))
            .fold(demand(&[0.0; D]), |a, b| if a.is_nan() || a >= b { a } else { b })
    }
}

/// A corner of the cell at a place on the lattice, by the bits of its number.
fn corner<const D: usize>(place: &[i32; D], bits: usize) -> [f64; D] {
    std::array::from_fn(|k| f64::from(place[k]) + if bits >> k & 1 == 0 { -0.5 } else { 0.5 })
}

/// A part of a cell with the demand over it, for any number of thresholds.
pub(super) struct Part<const D: usize> {
    pub(super) mass: f64,
    /// Whether it lies outside the cell itself.
    pub(super) beyond: bool,
    /// Growth of the logarithm of the density across the part, along each axis.
    slope: [f64; D],
    /// The demand at the centre, and in the middle of both faces across each axis.
    centre: f64,
    faces: [[f64; 2]; D],
}

impl<const D: usize> Part<D> {
    /// The share of the part's mass where the demand exceeds the threshold: over the part the demand is uniform with its
    /// standard deviation there, `w/sqrt(12)`, and the logarithm of the density is linear in it.
    pub(super) fn fraction_above(&self, threshold: f64) -> f64 {
        let centre = self.centre - threshold;
        let across = self.faces.map(|[below, above]| (above - threshold) - (below - threshold));
        let width = across.iter().map(|a| a * a).sum::<f64>().sqrt();
        if centre.abs() >= 0.5 * width {
            return f64::from(u8::from(centre > 0.0));
        }
        // The density is exp(tilt s) for s from -1/2 to 1/2, and the demand exceeds where s > -centre/width.
        let tilt = (0..D).map(|k| self.slope[k] * across[k]).sum::<f64>() / width;
        let above = 0.5 + centre / width;
        exponential_share(tilt, above)
    }
}

/// The share of the mass of `exp(tilt s)`, `s` from 0 to 1, that lies in the last part of length `above`.
fn exponential_share(tilt: f64, above: f64) -> f64 {
    if tilt.abs() < 1e-6 {
        above
    } else if tilt > 0.0 {
        (-tilt * above).exp_m1() / (-tilt).exp_m1()
    } else {
        // The same with a power that does not overflow.
        (tilt * (1.0 - above)).exp() * (tilt * above).exp_m1() / tilt.exp_m1()
    }
}

/// How much the demand varies across a part, were it linear there.
pub(super) fn variation<const D: usize>(demand: impl Fn(&[f64; D]) -> f64, u: &[f64; D]) -> f64 {
    across_part(demand, u).iter().map(|a| a.abs()).sum()
}

/// By how much the demand grows across a part along each axis.
fn across_part<const D: usize>(demand: impl Fn(&[f64; D]) -> f64, u: &[f64; D]) -> [f64; D] {
    faces_of_part(demand, u).map(|[below, above]| above - below)
}

/// The demand in the middle of both faces of a part across each axis.
fn faces_of_part<const D: usize>(demand: impl Fn(&[f64; D]) -> f64, u: &[f64; D]) -> [[f64; 2]; D] {
    let half = 0.5 / subdivisions(D) as f64;
    std::array::from_fn(|axis| {
        [-half, half].map(|offset| {
            let mut face = *u;
            face[axis] += offset;
            demand(&face)
        })
    })
}

/// `sinh(x)/x`.
fn sinhc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 + x * x / 6.0 } else { x.sinh() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_of_an_exponential_is_right_on_both_sides_and_does_not_overflow() {
        for above in [0.1, 0.5, 0.9] {
            for tilt in [1e-7, 0.3, 4.0, 30.0] {
                let share = exponential_share(tilt, above);
                let rest = exponential_share(-tilt, 1.0 - above);
                // What lies above with one tilt lies below with the other.
                assert!((share + rest - 1.0).abs() < 1e-12, "{tilt} {above}: {share} {rest}");
            }
            assert!((exponential_share(1e4, above) - 1.0).abs() < 1e-12);
            let far = exponential_share(-1e4, above);
            assert!((0.0..1e-12).contains(&far), "{far}");
        }
    }
}
