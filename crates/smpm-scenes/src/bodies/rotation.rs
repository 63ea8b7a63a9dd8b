//! Rotations of regions.

use scene_runs::scene::Objection;

use crate::coordinates::point;
use crate::scene::RotationScene;

/// A rotation about a point.
pub(crate) struct Rotation<const D: usize> {
    about: [f64; D],
    matrix: [[f64; D]; D],
}

impl<const D: usize> Rotation<D> {
    /// Rodrigues' formula, $R = \cos\theta\, I + \sin\theta\, [a]_\times + (1 - \cos\theta)\, a a^T$.
    ///
    /// # Errors
    /// An [`Objection`] in one dimension, to an axis without direction, and to one in the plane.
    pub(crate) fn of(scene: &RotationScene, path: &str) -> Result<Self, Objection> {
        let at = format!("{path}.axis");
        let axis: [f64; 3] = match (D, scene.axis.as_slice()) {
            (2, []) => [0.0, 0.0, 1.0],
            (3, axis) => point(axis, &at)?,
            (2, _) => return Err(Objection::new(at, "a rotation in the plane has no axis")),
            _ => return Err(Objection::new(path, "there are no rotations along a line")),
        };
        let length = axis.iter().fold(0.0, |length: f64, x| length.hypot(*x));
        if !(length > 0.0 && length.is_finite()) {
            let message = format!("the axis is {length} long and must have a direction");
            return Err(Objection::new(at, message));
        }
        let a = axis.map(|x| x / length);
        let (sin, cos) = scene.degrees.to_radians().sin_cos();
        let cross = [[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]];
        let entry = |i: usize, j: usize| {
            f64::from(i == j) * cos + sin * cross[i][j] + (1.0 - cos) * a[i] * a[j]
        };
        Ok(Self {
            about: point(&scene.about, &format!("{path}.about"))?,
            matrix: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
        })
    }

    /// The place from which a point has been rotated.
    pub(crate) fn back(&self, x: &[f64; D]) -> [f64; D] {
        self.times(x, |i, j| self.matrix[j][i])
    }

    /// The place to which a point is rotated.
    pub(crate) fn forward(&self, x: &[f64; D]) -> [f64; D] {
        self.times(x, |i, j| self.matrix[i][j])
    }

    /// The box about a rotated box.
    pub(crate) fn bounds(&self, (from, to): ([f64; D], [f64; D])) -> ([f64; D], [f64; D]) {
        let corner = |number: usize| {
            let x = std::array::from_fn(|k| if number >> k & 1 == 0 { from[k] } else { to[k] });
            self.forward(&x)
        };
        let fold = |start: f64, of: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| (0..1 << D).map(|n| corner(n)[k]).fold(start, of))
        };
        (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max))
    }

    fn times(&self, x: &[f64; D], entry: impl Fn(usize, usize) -> f64) -> [f64; D] {
        let along = |i: usize, j: usize| entry(i, j) * (x[j] - self.about[j]);
        std::array::from_fn(|i| self.about[i] + (0..D).map(|j| along(i, j)).sum::<f64>())
    }
}
