//! The marginal density of two states, from the masses of the particles.

/// A density on cells of a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneDensity {
    /// Edges of the cells along the first state.
    pub x: Vec<f64>,
    /// Edges of the cells along the second.
    pub y: Vec<f64>,
    /// The density at the centre of each cell; each row is at one value of the second state.
    pub values: Vec<Vec<f64>>,
}

/// Cells along each axis.
const CELLS: usize = 140;
/// Truncation of the kernel, in bandwidths: beyond it the kernel is below 4e-6 of its peak.
const REACH: f64 = 5.0;

/// Kernel density estimate of two states; `None` where the cloud does not span the plane.
///
/// It is `sum_i mu_i N(x; x_i, b^2 C)` with the covariance `C` of the cloud in their plane and the bandwidth `b` in
/// its standard deviations. Its variance exceeds that of the density by the factor `1 + b^2`: use it for pictures, not
/// as an estimate.
#[must_use]
pub fn plane_density<const D: usize>(
    positions: &[[f64; D]],
    masses: &[f64],
    [across, up]: [usize; 2],
    bandwidth: f64,
) -> Option<PlaneDensity> {
    let points: Vec<[f64; 2]> = positions.iter().map(|x| [x[across], x[up]]).collect();
    let whitening = Whitening::of(&points, masses)?;
    let whitened: Vec<[f64; 2]> = points.iter().map(|x| whitening.whiten(x)).collect();
    let edges = |axis: usize| -> Vec<f64> {
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x[axis]), high.max(x[axis]))
            });
        let room = bandwidth * whitening.deviation(axis);
        let (low, width) = (low - room, high - low + 2.0 * room);
        (0..=CELLS).map(|k| low + width * k as f64 / CELLS as f64).collect()
    };
    let (x, y) = (edges(0), edges(1));
    let middle = |edges: &[f64], k: usize| f64::midpoint(edges[k], edges[k + 1]);
    let norm = 1.0 / (std::f64::consts::TAU * bandwidth * bandwidth * whitening.determinant());
    let value = |a: usize, b: usize| -> f64 {
        let at = whitening.whiten(&[middle(&x, a), middle(&y, b)]);
        let mut sum = 0.0;
        for (point, mass) in whitened.iter().zip(masses) {
            let (d_0, d_1) = ((at[0] - point[0]) / bandwidth, (at[1] - point[1]) / bandwidth);
            let square = d_0 * d_0 + d_1 * d_1;
            if square < REACH * REACH {
                sum += mass * (-0.5 * square).exp();
            }
        }
        norm * sum
    };
    let values = (0..CELLS).map(|b| (0..CELLS).map(|a| value(a, b)).collect()).collect();
    Some(PlaneDensity { x, y, values })
}

/// The map that transforms the covariance in the plane to the unit matrix.
struct Whitening {
    mean: [f64; 2],
    /// Lower triangle of the Cholesky factor: `l_00, l_10, l_11`.
    factor: [f64; 3],
}

impl Whitening {
    fn of(points: &[[f64; 2]], masses: &[f64]) -> Option<Self> {
        let total: f64 = masses.iter().sum();
        let mean_of = |f: &dyn Fn(&[f64; 2]) -> f64| -> f64 {
            points.iter().zip(masses).map(|(x, mass)| mass * f(x)).sum::<f64>() / total
        };
        let mean = [mean_of(&|x| x[0]), mean_of(&|x| x[1])];
        let entry = |i: usize, j: usize| mean_of(&|x| (x[i] - mean[i]) * (x[j] - mean[j]));
        let l_00 = entry(0, 0).sqrt();
        let l_10 = entry(0, 1) / l_00;
        let l_11 = (entry(1, 1) - l_10 * l_10).sqrt();
        (l_00 > 0.0 && l_11 > 0.0).then_some(Self { mean, factor: [l_00, l_10, l_11] })
    }

    fn whiten(&self, x: &[f64; 2]) -> [f64; 2] {
        let [l_00, l_10, l_11] = self.factor;
        let y_0 = (x[0] - self.mean[0]) / l_00;
        [y_0, (x[1] - self.mean[1] - l_10 * y_0) / l_11]
    }

    fn determinant(&self) -> f64 {
        self.factor[0] * self.factor[2]
    }

    fn deviation(&self, axis: usize) -> f64 {
        let [l_00, l_10, l_11] = self.factor;
        if axis == 0 { l_00 } else { l_10.hypot(l_11) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_over_a_normal_law_gives_that_law_widened_by_the_kernel() {
        // States (x_0, x_1, x_2) with x_2 = x_0 + x_1: the plane of 0 and 2 has the covariance [[1, 1], [1, 2]].
        let spacing = 0.25;
        let (mut positions, mut masses) = (Vec::new(), Vec::new());
        for a in -20..=20 {
            for b in -20..=20 {
                let (x, y) = (spacing * f64::from(a), spacing * f64::from(b));
                positions.push([x, y, x + y]);
                masses.push(
                    (-0.5 * (x * x + y * y)).exp() * spacing * spacing / std::f64::consts::TAU,
                );
            }
        }
        let bandwidth = 0.3;
        let density = plane_density(&positions, &masses, [0, 2], bandwidth).unwrap();
        let cell = (density.x[1] - density.x[0]) * (density.y[1] - density.y[0]);
        let mass: f64 = density.values.iter().flatten().sum::<f64>() * cell;
        // The lattice omits 6e-7 at its ends, the kernel 4e-6.
        assert!((mass - 1.0).abs() < 1e-5, "{mass}");
        let peak = density.values.iter().flatten().copied().fold(0.0, f64::max);
        let expected = 1.0 / (std::f64::consts::TAU * (1.0 + bandwidth * bandwidth));
        // The centre of the peak's cell is up to half a cell, 0.06 deviations, off the peak.
        assert!((peak / expected - 1.0).abs() < 5e-3, "{peak} against {expected}");
    }

    #[test]
    fn a_cloud_on_a_line_has_no_density_on_the_plane() {
        let positions = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        assert!(plane_density(&positions, &[0.2, 0.5, 0.3], [0, 0], 0.3).is_none());
    }
}
