//! Weights of the particles around a point, by their places at the start.

/// Largest part of a spacing by which a place may miss that of the lattice: roundoff.
const ROUNDOFF: f64 = 1e-6;

/// Weights that read a linear function exactly, from the particles of a lattice around a point.
///
/// Along each axis they are the nearest one and the next on the side of the point; at a face, the next on the other side, so that
/// the point is reached by extrapolation. Without a neighbour along an axis nothing varies along it.
/// Where one of the corners is missing, the nearest particle and its neighbours along the axes take their part.
///
/// Empty without particles.
pub(crate) fn linear<const D: usize>(
    starts: &[[f64; D]],
    spacing: [f64; D],
    point: &[f64; D],
) -> Vec<(usize, f64)> {
    let square = |x: &[f64; D]| (0..D).map(|k| (x[k] - point[k]).powi(2)).sum::<f64>();
    let Some(nearest) =
        (0..starts.len()).min_by(|&a, &b| square(&starts[a]).total_cmp(&square(&starts[b])))
    else {
        return Vec::new();
    };
    let origin = starts[nearest];
    let at = |steps: [f64; D]| {
        let is_it = |x: &[f64; D]| {
            (0..D)
                .all(|k| (x[k] - origin[k] - steps[k] * spacing[k]).abs() <= ROUNDOFF * spacing[k])
        };
        starts.iter().position(is_it)
    };
    // Along each axis: the side of the neighbour, and its weight.
    let mut along = [(0.0, 0.0); D];
    for k in 0..D {
        let distance = (point[k] - origin[k]) / spacing[k];
        if distance.abs() <= ROUNDOFF {
            continue;
        }
        let side = distance.signum();
        let exists = |side: f64| {
            let mut steps = [0.0; D];
            steps[k] = side;
            at(steps).is_some()
        };
        if let Some(side) = [side, -side].into_iter().find(|&side| exists(side)) {
            along[k] = (side, distance * side);
        }
    }
    by_corners(&along, &at).unwrap_or_else(|| by_axes(&along, nearest, &at))
}

/// Products of the weights along the axes; none if a corner has no particle.
fn by_corners<const D: usize>(
    along: &[(f64, f64); D],
    at: &impl Fn([f64; D]) -> Option<usize>,
) -> Option<Vec<(usize, f64)>> {
    let mut weights = Vec::new();
    for corner in 0..1_usize << D {
        let (mut steps, mut weight) = ([0.0; D], 1.0);
        for (k, &(side, far)) in along.iter().enumerate() {
            let is_far = corner >> k & 1 == 1;
            weight *= if is_far { far } else { 1.0 - far };
            steps[k] = if is_far { side } else { 0.0 };
        }
        if weight != 0.0 {
            weights.push((at(steps)?, weight));
        }
    }
    Some(weights)
}

/// The nearest particle, and differences to its neighbours along the axes.
fn by_axes<const D: usize>(
    along: &[(f64, f64); D],
    nearest: usize,
    at: &impl Fn([f64; D]) -> Option<usize>,
) -> Vec<(usize, f64)> {
    let mut weights = vec![(nearest, 1.0)];
    for (k, &(side, far)) in along.iter().enumerate() {
        let mut steps = [0.0; D];
        steps[k] = side;
        if let Some(neighbour) = at(steps).filter(|_| far != 0.0) {
            weights[0].1 -= far;
            weights.push((neighbour, far));
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of a lattice of six by five boxes with edges 0.5 and 0.25.
    fn lattice() -> Vec<[f64; 2]> {
        let place =
            |index: u8| [0.5 * (f64::from(index % 6) + 0.5), 0.25 * (f64::from(index / 6) + 0.5)];
        (0..30).map(place).collect()
    }

    /// Largest error of the weights on one and the coordinates.
    fn error(starts: &[[f64; 2]], point: [f64; 2]) -> f64 {
        let weights = linear(starts, [0.5, 0.25], &point);
        let sum = |of: &dyn Fn(&[f64; 2]) -> f64| -> f64 {
            weights.iter().map(|&(particle, weight)| weight * of(&starts[particle])).sum()
        };
        let errors = [sum(&|_| 1.0) - 1.0, sum(&|x| x[0]) - point[0], sum(&|x| x[1]) - point[1]];
        errors.into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    #[test]
    fn linear_functions_are_exact_inside_at_faces_and_at_a_missing_corner() {
        let all = lattice();
        let mut notched = all.clone();
        notched.remove(14);
        for point in [[0.9, 0.4], [0.25, 0.125], [0.0, 0.0], [3.0, 1.25], [1.1, 0.5], [1.3, 0.6]] {
            assert!(error(&all, point) < 1e-14, "{point:?}");
            assert!(error(&notched, point) < 1e-14, "{point:?}");
        }
    }

    #[test]
    fn a_particle_reads_itself_and_a_row_of_one_particle_varies_along_its_length_alone() {
        let all = lattice();
        assert_eq!(linear(&all, [0.5, 0.25], &all[6]), [(6, 1.0)]);
        let row: Vec<[f64; 2]> = all[..6].to_vec();
        let weights = linear(&row, [0.5, 0.25], &[0.5, 0.0]);
        assert_eq!(weights, [(0, 0.5), (1, 0.5)]);
        assert!(linear::<2>(&[], [0.5, 0.25], &[0.5, 0.0]).is_empty());
    }
}
