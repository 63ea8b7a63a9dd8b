//! Conservative remapping along a line of cells.

/// Cells of equal width along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    pub(crate) centre: f64,
    pub(crate) width: f64,
    cells: usize,
}

impl Axis {
    pub(crate) fn new(centre: f64, half: f64, cells: usize) -> Self {
        Self { centre, width: 2.0 * half / cells as f64, cells }
    }

    /// Lower edge of a cell.
    pub(crate) fn edge(&self, cell: usize) -> f64 {
        self.centre + (cell as f64 - 0.5 * self.cells as f64) * self.width
    }

    /// Centre of a cell.
    pub(crate) fn centre_of(&self, cell: usize) -> f64 {
        self.centre + (cell as f64 + 0.5 - 0.5 * self.cells as f64) * self.width
    }

    /// Position in cells from the first edge.
    pub(crate) fn in_cells(&self, x: f64) -> f64 {
        (x - self.centre) / self.width + 0.5 * self.cells as f64
    }

    /// Power of a cell's centre with Sheppard's correction for the cell width.
    pub(crate) fn sheppard(&self, cell: usize, power: u32) -> f64 {
        let (x, h) = (self.centre_of(cell), self.width);
        match power {
            0 => 1.0,
            1 => x,
            2 => x * x - h * h / 12.0,
            3 => x * (x * x - 0.25 * h * h),
            _ => x * x * (x * x - 0.5 * h * h) + 7.0 / 240.0 * h * h * h * h,
        }
    }
}

/// A line of masses with two empty cells at either end, for remapping.
#[derive(Debug)]
pub(crate) struct Line {
    padded: Vec<f64>,
}

/// Empty cells at either end, the half-width of the interpolation stencil.
const PADDING: usize = 2;

/// A position on the line: cell, offset in the cell, and the mass of that cell up to it.
#[derive(Debug, Clone, Copy)]
struct Cut {
    cell: usize,
    mass: f64,
}

impl Line {
    pub(crate) fn new(cells: usize) -> Self {
        Self { padded: vec![0.0; cells + 2 * PADDING] }
    }

    /// The masses between consecutive cuts, which increase and are counted in cells from the first edge.
    ///
    /// The first cut is moved to the beginning of the line and the last to its end, so no mass is lost. Within a cell
    /// the cumulative distribution is interpolated with degree 5 at the six nearest edges. It is limited to the range
    /// from zero to the mass of the cell and never decreases, so the masses are not negative and their sum is
    /// conserved.
    pub(crate) fn remap(&mut self, masses: &[f64], cuts: &[f64], moved: &mut [f64]) {
        let n = masses.len();
        self.padded[PADDING..PADDING + n].copy_from_slice(masses);
        let mut before = Cut { cell: 0, mass: 0.0 };
        let last = moved.len() - 1;
        for (k, to) in moved.iter_mut().enumerate() {
            let cut = if k == last { Cut { cell: n, mass: 0.0 } } else { self.cut(cuts[k + 1], n) };
            let (cut, mass) = self.between(before, cut);
            *to = mass;
            before = cut;
        }
    }

    /// The mass between two cuts, and the second cut, moved up to the first if it lies before it.
    fn between(&self, from: Cut, to: Cut) -> (Cut, f64) {
        if to.cell < from.cell || (to.cell == from.cell && to.mass <= from.mass) {
            return (from, 0.0);
        }
        if to.cell == from.cell {
            return (to, to.mass - from.mass);
        }
        let first = self.padded[PADDING + from.cell] - from.mass;
        let whole: f64 = self.padded[PADDING + from.cell + 1..PADDING + to.cell].iter().sum();
        (to, first + whole + to.mass)
    }

    fn cut(&self, place: f64, n: usize) -> Cut {
        if place <= 0.0 || place.is_nan() {
            return Cut { cell: 0, mass: 0.0 };
        }
        if place >= n as f64 {
            return Cut { cell: n, mass: 0.0 };
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in [0, n)")]
        let cell = place as usize;
        let x = place - cell as f64;
        let [m_2, m_1, m, m1, m2] = [0, 1, 2, 3, 4].map(|k| self.padded[cell + k]);
        let (a, b, c, d, e) = (x + 2.0, x + 1.0, x - 1.0, x - 2.0, x - 3.0);
        // Lagrange polynomials at the edges -2, -1, 1, 2, 3; the distribution is counted from edge 0.
        let far_left = b * x * c * d * e / 120.0;
        let left = -a * x * c * d * e / 24.0;
        let right = a * b * x * d * e / 12.0;
        let further = -a * b * x * c * e / 24.0;
        let far_right = a * b * x * c * d / 120.0;
        let mass = far_left * (m_2 + m_1)
            + left * m_1
            + right * m
            + further * (m + m1)
            + far_right * (m + m1 + m2);
        Cut { cell, mass: mass.clamp(0.0, m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_degree_four_is_remapped_exactly() {
        // Masses of the density 1 + x^4/500 over [-5, 5], whose integral is x + x^5/2500; cuts away from the ends.
        let integral = |x: f64| x + x.powi(5) / 2500.0;
        let axis = Axis::new(0.0, 5.0, 10);
        let masses: Vec<f64> =
            (0..10).map(|k| integral(axis.edge(k + 1)) - integral(axis.edge(k))).collect();
        let cuts = [0.0, 2.3, 2.9, 4.1, 6.6, 7.0, 10.0];
        let mut moved = [0.0; 6];
        Line::new(10).remap(&masses, &cuts, &mut moved);
        for k in 1..5 {
            let expected = integral(cuts[k + 1] - 5.0) - integral(cuts[k] - 5.0);
            assert!((moved[k] - expected).abs() < 1e-13, "{k}: {} {expected}", moved[k]);
        }
        let (before, after): (f64, f64) = (masses.iter().sum(), moved.iter().sum());
        assert!((before - after).abs() < 1e-14);
    }

    #[test]
    fn rough_masses_stay_positive_and_keep_their_sum() {
        // Spikes between empty cells, where the interpolant oscillates.
        let masses = [0.0, 1.0, 0.0, 0.0, 7.0, 1e-9, 0.0, 3.0, 0.0];
        for shift in 0..40 {
            let shift = 0.1 * f64::from(shift) - 2.0;
            let cuts: Vec<f64> = (0..=9).map(|k| f64::from(k) + shift).collect();
            let mut moved = [0.0; 9];
            Line::new(9).remap(&masses, &cuts, &mut moved);
            assert!(moved.iter().all(|&m| m >= 0.0), "{shift}: {moved:?}");
            assert!((moved.iter().sum::<f64>() - 11.000000001).abs() < 1e-14, "{shift}");
        }
    }

    #[test]
    fn sheppard_takes_the_width_of_the_cells_out_of_a_normal_law() {
        // Masses of a standard normal in cells of one deviation: the remainder of density times sinc is below 1e-7.
        let axis = Axis::new(0.1, 10.0, 40);
        let mass = |k: usize| {
            let below = sde_integrators::normal_probability;
            below(axis.edge(k + 1)) - below(axis.edge(k))
        };
        for (power, expected) in [(0, 1.0), (1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)] {
            let moment: f64 = (0..40).map(|k| mass(k) * axis.sheppard(k, power)).sum();
            assert!((moment - expected).abs() < 1e-12, "{power}: {moment}");
        }
    }
}
