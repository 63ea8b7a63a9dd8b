//! From nodes beside a crack to the middle of it.

use super::fractured::Fractured;
use super::measure::{along, resampled};

/// Middles of the bonds that a crack broke.
pub(super) struct Middles {
    places: Vec<[f64; 2]>,
    spacing: f64,
    /// How far around a point they count: half a bond, and a spacing for nodes next to the crack.
    window: f64,
}

impl Middles {
    /// The middles of bonds that the notch did not cut and that end at a node of the crack.
    pub(super) fn new(body: &Fractured<'_>, nodes_of_crack: &[usize], horizon: f64) -> Self {
        let x = body.nodes.positions();
        let mut of_crack = vec![false; x.len()];
        for &node in nodes_of_crack {
            of_crack[node] = true;
        }
        let mut counts = body.broken.to_vec();
        for &bond in body.cut {
            counts[bond] = false;
        }
        let places = body
            .bonds
            .pairs()
            .zip(counts)
            .filter(|&((i, j), counts)| counts && (of_crack[i] || of_crack[j]))
            .map(|((i, j), _)| [0, 1].map(|k| 0.5 * (x[i][k] + x[j][k])))
            .collect();
        let spacing = body.nodes.spacing();
        Self { places, spacing, window: 0.5 * horizon + spacing }
    }

    /// Points every spacing along a way, moved across it into the middle; the first stays. Twice, the second time from a way
    /// that runs in the middle.
    pub(super) fn centred(&self, way: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let once = self.moved(&resampled(way, self.spacing));
        self.moved(&resampled(&once, self.spacing))
    }

    fn moved(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let last = points.len().saturating_sub(1);
        let at = |point: usize| {
            if point == 0 {
                return points[0];
            }
            // The direction over five points, fewer at the ends.
            let (before, after) =
                (&points[point.saturating_sub(2)], &points[(point + 2).min(last)]);
            match along(before, after) {
                Some(tangent) => self.shifted(&points[point], tangent),
                None => points[point],
            }
        };
        (0..points.len()).map(at).collect()
    }

    /// A point moved across a direction onto the line fitted to the middles around it, those nearer along it weighed more.
    fn shifted(&self, point: &[f64; 2], tangent: [f64; 2]) -> [f64; 2] {
        let normal = [-tangent[1], tangent[0]];
        let [mut w, mut wa, mut wb, mut waa, mut wab] = [0.0; 5];
        for place in &self.places {
            let off = [place[0] - point[0], place[1] - point[1]];
            let a = off[0] * tangent[0] + off[1] * tangent[1];
            let b = off[0] * normal[0] + off[1] * normal[1];
            let weight = 1.0 - a.abs() / self.window;
            if weight > 0.0 && b.abs() < self.window {
                w += weight;
                wa += weight * a;
                wb += weight * b;
                waa += weight * a * a;
                wab += weight * a * b;
            }
        }
        if w <= 0.0 {
            return *point;
        }
        // A line needs middles spread along it; else their mean.
        let spread = waa - wa * wa / w;
        let slope = if spread > 0.01 * w * self.window * self.window {
            (wab - wa * wb / w) / spread
        } else {
            0.0
        };
        let shift = (wb - slope * wa) / w;
        [point[0] + shift * normal[0], point[1] + shift * normal[1]]
    }
}
