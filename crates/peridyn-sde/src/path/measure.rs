//! What is asked of a path.

use crate::error::{Error, at_least, finite};

/// A crack in a plane from the tip of a notch on.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackPath {
    points: Vec<[f64; 2]>,
    branches: Vec<Branch>,
}

/// A branch of a crack.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    points: Vec<[f64; 2]>,
}

impl Branch {
    /// From the branching point to its tip (length).
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Where it leaves the crack: where the lines through both arms, between one and three horizons from where their zones of
    /// damage part, meet; where they are too short or meet nowhere near, where the zones part.
    #[must_use]
    pub fn start(&self) -> [f64; 2] {
        self.points[0]
    }

    /// Its tip.
    #[must_use]
    pub fn tip(&self) -> [f64; 2] {
        self.points[self.points.len() - 1]
    }
}

impl CrackPath {
    /// A path through points (length).
    ///
    /// # Errors
    /// [`Error::Parameter`] for a coordinate, and where all points are one place; [`Error::TooFew`] for fewer than two points.
    pub fn from_points(points: Vec<[f64; 2]>) -> Result<Self, Error> {
        for &value in points.iter().flatten() {
            finite("a coordinate of a path", value)?;
        }
        at_least("points of a path", points.len(), 2)?;
        crate::error::positive("length of a path", length(&points))?;
        Ok(Self { points, branches: vec![] })
    }

    /// From the tip of the notch to that of the crack, about a spacing apart (length).
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// Branches, the longest first as they were found.
    #[must_use]
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// Where the crack ends.
    #[must_use]
    pub fn tip(&self) -> [f64; 2] {
        self.points[self.points.len() - 1]
    }

    /// The tip of the crack and those of its branches.
    #[must_use]
    pub fn tips(&self) -> Vec<[f64; 2]> {
        std::iter::once(self.tip()).chain(self.branches.iter().map(Branch::tip)).collect()
    }

    /// How long it is, without branches (length).
    #[must_use]
    pub fn length(&self) -> f64 {
        length(&self.points)
    }

    /// How high it is where it first comes to an abscissa, if it does.
    #[must_use]
    pub fn height_at(&self, x: f64) -> Option<f64> {
        height_at(&self.points, x)
    }

    /// Its beginning, up to a length, without branches; all of it where it is shorter.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub fn until(&self, limit: f64) -> Result<Self, Error> {
        crate::error::positive("length of a path", limit)?;
        let (mut points, mut so_far) = (vec![self.points[0]], 0.0);
        for pair in self.points.windows(2) {
            let step = length(pair);
            if so_far + step >= limit {
                points.push(between(&pair[0], &pair[1], (limit - so_far) / step));
                break;
            }
            points.push(pair[1]);
            so_far += step;
        }
        Ok(Self { points, branches: vec![] })
    }

    /// The angle from a direction to the line fitted to its points, of least distance to them (radian, counter-clockwise, in
    /// the sense of the crack, from `-pi` to `pi`).
    ///
    /// # Errors
    /// [`Error::Parameter`] for a direction that is not finite or has no length.
    pub fn angle_of_fit(&self, direction: [f64; 2]) -> Result<f64, Error> {
        let (first, tip) = (self.points[0], self.tip());
        let chord = [tip[0] - first[0], tip[1] - first[1]];
        let line = fitted(&self.points);
        let forward = if line.along[0] * chord[0] + line.along[1] * chord[1] < 0.0 {
            line.along.map(|c| -c)
        } else {
            line.along
        };
        angle(direction, forward)
    }
}

/// A path with its branches, each begun where its arm and the other meet.
pub(super) fn joined(points: Vec<[f64; 2]>, arms: Vec<Vec<[f64; 2]>>, horizon: f64) -> CrackPath {
    let mut paths = vec![points];
    for arm in arms {
        let joined = join(&paths, arm, horizon);
        paths.push(joined);
    }
    let mut paths = paths.into_iter();
    let points = paths.next().unwrap_or_default();
    CrackPath { points, branches: paths.map(|points| Branch { points }).collect() }
}

fn join(paths: &[Vec<[f64; 2]>], arm: Vec<[f64; 2]>, horizon: f64) -> Vec<[f64; 2]> {
    let Some(&start) = arm.first() else {
        return arm;
    };
    let Some(other) = beyond_nearest(paths, &start) else {
        return arm;
    };
    let meeting = [&arm[..], other].map(|points| fitted_if_long(&part(points, horizon)));
    let [Some(one), Some(two)] = meeting else {
        return arm;
    };
    match one.meets(&two).filter(|place| length(&[*place, start]) < 4.0 * horizon) {
        Some(place) => {
            let mut so_far = 0.0;
            let mut points = vec![place];
            for pair in arm.windows(2) {
                so_far += length(pair);
                if so_far >= horizon {
                    points.push(pair[1]);
                }
            }
            points
        }
        None => arm,
    }
}

/// What follows a place on the path that comes nearest to it.
fn beyond_nearest<'a>(paths: &'a [Vec<[f64; 2]>], place: &[f64; 2]) -> Option<&'a [[f64; 2]]> {
    let far = |path: &[[f64; 2]], point: usize| length(&[path[point], *place]);
    paths
        .iter()
        .flat_map(|path| (0..path.len()).map(move |point| (path, point)))
        .min_by(|(a, i), (b, j)| far(a, *i).total_cmp(&far(b, *j)))
        .map(|(path, point)| &path[point..])
}

/// What lies between one and three horizons from the start.
fn part(points: &[[f64; 2]], horizon: f64) -> Vec<[f64; 2]> {
    let mut so_far = 0.0;
    let mut kept = vec![];
    for pair in points.windows(2) {
        so_far += length(pair);
        if so_far >= horizon && so_far <= 3.0 * horizon {
            kept.push(pair[1]);
        }
    }
    kept
}

fn fitted_if_long(points: &[[f64; 2]]) -> Option<Line> {
    (points.len() >= 3).then(|| fitted(points))
}

struct Line {
    through: [f64; 2],
    /// The direction, of length one.
    along: [f64; 2],
}

impl Line {
    /// Where they cross; nowhere for directions less than 10 degrees apart.
    fn meets(&self, other: &Self) -> Option<[f64; 2]> {
        let sine = cross(&self.along, &other.along);
        let off = [other.through[0] - self.through[0], other.through[1] - self.through[1]];
        let far = cross(&off, &other.along) / sine;
        (sine.abs() > 0.17).then(|| [0, 1].map(|k| self.through[k] + far * self.along[k]))
    }
}

/// The line of least squares of the distances of points to it.
fn fitted(points: &[[f64; 2]]) -> Line {
    let n = points.len() as f64;
    let sum = points.iter().fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
    let mean = sum.map(|c| c / n);
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for point in points {
        let off = [point[0] - mean[0], point[1] - mean[1]];
        xx += off[0] * off[0];
        xy += off[0] * off[1];
        yy += off[1] * off[1];
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    Line { through: mean, along: [angle.cos(), angle.sin()] }
}

fn angle(from: [f64; 2], to: [f64; 2]) -> Result<f64, Error> {
    for value in from {
        finite("the direction of an angle", value)?;
    }
    crate::error::positive("length of the direction of an angle", from[0].hypot(from[1]))?;
    Ok(cross(&from, &to).atan2(from[0] * to[0] + from[1] * to[1]))
}

fn cross(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Where a polyline first comes to an abscissa.
pub(crate) fn height_at(points: &[[f64; 2]], x: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let (from, to) = (pair[0][0], pair[1][0]);
        let step = to - from;
        match (from.min(to)..=from.max(to)).contains(&x) {
            true if step.abs() > 0.0 => Some(between(&pair[0], &pair[1], (x - from) / step)[1]),
            true => Some(pair[0][1]),
            false => None,
        }
    })
}

pub(crate) fn length(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
}

fn between(from: &[f64; 2], to: &[f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| from[k] + share * (to[k] - from[k]))
}

/// The direction from one point to another, of length one; none where they are one.
pub(super) fn along(from: &[f64; 2], to: &[f64; 2]) -> Option<[f64; 2]> {
    let length = length(&[*from, *to]);
    (length > 0.0).then(|| [0, 1].map(|k| (to[k] - from[k]) / length))
}

/// Points along a polyline that are `spacing` apart along it, its first and its last one among them.
pub(super) fn resampled(way: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let Some(&first) = way.first() else {
        return vec![];
    };
    let (mut points, mut left) = (vec![first], spacing);
    for pair in way.windows(2) {
        let step = length(pair);
        let mut at = left;
        while at < step {
            points.push(between(&pair[0], &pair[1], at / step));
            at += spacing;
        }
        left = at - step;
    }
    // The last point, in place of one that is nearer than half a spacing to it.
    if points.len() > 1 && left > 0.5 * spacing {
        points.pop();
    }
    points.extend(way.last());
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[[f64; 2]]) -> CrackPath {
        CrackPath::from_points(points.to_vec()).unwrap()
    }

    #[test]
    fn the_height_is_that_of_the_first_crossing() {
        let path = path(&[[0.0, 0.0], [2.0, 1.0], [2.0, 3.0], [1.0, 4.0]]);
        assert_eq!(path.height_at(1.0), Some(0.5));
        assert_eq!(path.height_at(2.0), Some(1.0));
        assert_eq!(path.height_at(2.5), None);
        assert_eq!(path.height_at(f64::NAN), None);
    }

    #[test]
    fn a_line_has_its_angle_and_its_length() {
        let path = path(&[[1.0, 1.0], [0.0, 2.0], [-2.0, 4.0]]);
        // Backwards and up: 135 degrees from the first axis, -45 from the opposite one.
        let right = std::f64::consts::FRAC_PI_4;
        assert!((path.angle_of_fit([1.0, 0.0]).unwrap() - 3.0 * right).abs() < 1e-14);
        assert!((path.angle_of_fit([-2.0, 0.0]).unwrap() + right).abs() < 1e-14);
        assert!((path.length() - 18_f64.sqrt()).abs() < 1e-14);
        let part = path.until(2.0).unwrap();
        assert!((part.length() - 2.0).abs() < 1e-14 && part.points().len() == 3);
        assert_eq!(path.until(9.0).unwrap(), path);
        assert!(path.angle_of_fit([0.0; 2]).is_err() && path.until(-1.0).is_err());
    }

    /// Points symmetric about the diagonal, and longer along it than across.
    #[test]
    fn the_fit_does_not_know_which_axis_is_which() {
        let one = path(&[[0.0, 0.0], [2.0, 1.0], [1.0, 2.0], [3.0, 3.0]]);
        assert!((one.angle_of_fit([1.0, 1.0]).unwrap()).abs() < 1e-14);
    }

    #[test]
    fn a_polyline_is_resampled_evenly_with_its_ends() {
        let points = resampled(&[[0.0, 0.0], [0.7, 0.0], [0.7, 1.5]], 0.5);
        let expected = [[0.0, 0.0], [0.5, 0.0], [0.7, 0.3], [0.7, 0.8], [0.7, 1.5]];
        assert_eq!(points.len(), expected.len());
        for (point, expected) in points.iter().zip(expected) {
            assert!(length(&[*point, expected]) < 1e-12, "{points:?}");
        }
    }

    #[test]
    fn a_path_needs_two_places() {
        assert!(matches!(CrackPath::from_points(vec![[0.0; 2]]), Err(Error::TooFew { .. })));
        assert!(matches!(CrackPath::from_points(vec![[0.0; 2]; 2]), Err(Error::Parameter { .. })));
        let nan = CrackPath::from_points(vec![[0.0, f64::NAN], [0.0; 2]]);
        assert!(matches!(nan, Err(Error::Parameter { .. })));
    }
}
