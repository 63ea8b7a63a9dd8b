//! Surfaces of triangles: which points they enclose.

use std::collections::HashMap;
use std::io::Cursor;

use scene_runs::scene::NamedFile;

/// Most triangles of a surface.
const MOST_TRIANGLES: usize = 1_000_000;
/// Most entries of all columns.
const MOST_LISTED: usize = 1 << 24;
/// Bytes of a binary file before its triangles, and of a triangle.
const BINARY: (u64, u64) = (84, 50);

/// Corners of a triangle, counterclockwise from outside.
type Triangle = [[f64; 3]; 3];

/// A closed surface of triangles, read from an STL file.
///
/// It encloses a point about which its winding number is not zero: the crossings of a ray from the point, each with the sign of its
/// sense. The solid angles of all triangles, van Oosterom and Strackee 1983, eq 8, doi:10.1109/TBME.1983.325207, add up to $4 \pi$ times
/// that number.
#[derive(Debug, PartialEq)]
pub struct Surface {
    pub(crate) file: NamedFile,
    pub(crate) bounds: ([f64; 3], [f64; 3]),
    triangles: Vec<Triangle>,
    /// Numbers of the triangles above each of n x n rectangles across the first two axes.
    columns: Vec<Vec<u32>>,
    n: usize,
}

impl Surface {
    /// The surface in a file; its coordinates are scaled, then shifted. A message after the file's name otherwise.
    pub(crate) fn read(
        file: NamedFile,
        mut bytes: Vec<u8>,
        (scale, shift): (f64, [f64; 3]),
    ) -> Result<Self, String> {
        let stated = bytes.get(80..84).map_or(0, |count| {
            count.iter().rev().fold(0, |number, &byte| 256 * number + u64::from(byte))
        });
        if bytes.len() as u64 == BINARY.0 + BINARY.1 * stated {
            // The head of a binary file may begin as text does.
            bytes[..80].fill(0);
        } else if !bytes.starts_with(b"solid") || bytes.contains(&0) {
            return Err(format!("is no STL file: neither text nor of {stated} triangles"));
        } else if bytes.windows(8).filter(|word| word == b"endsolid").count() != 1 {
            return Err("has more or less than one solid".to_owned());
        } else {
            // A blank after the first word is taken for granted.
            bytes.insert(5, b' ');
        }
        // The message of the reader has text of the file.
        let broken = |error: std::io::Error| format!("cannot be read as STL: {}", error.kind());
        let mut bytes = Cursor::new(bytes);
        let reader = stl_io::create_stl_reader(&mut bytes).map_err(broken)?;
        // The last sum makes one zero of the two.
        let place =
            |x: stl_io::Vertex| std::array::from_fn(|k| scale * f64::from(x.0[k]) + shift[k] + 0.0);
        let triangles = reader.take(MOST_TRIANGLES + 1).map(|it| Ok(it?.vertices.map(place)));
        let triangles: Vec<Triangle> = triangles.collect::<Result<_, _>>().map_err(broken)?;
        let n = triangles.len();
        if n == 0 || n > MOST_TRIANGLES {
            return Err(format!("has no triangles, or more than {MOST_TRIANGLES}"));
        }
        if triangles.iter().flatten().flatten().any(|x| !x.is_finite()) {
            return Err("has a corner that is not finite".to_owned());
        }
        check_closed(&triangles)?;
        let fold = |start: f64, of: fn(f64, f64) -> f64| {
            std::array::from_fn(|k| triangles.iter().flatten().map(|x| x[k]).fold(start, of))
        };
        let bounds = (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max));
        let mut surface = Self { file, bounds, triangles, columns: Vec::new(), n: n.isqrt() };
        surface.list();
        Ok(surface)
    }

    /// Lists the triangles above each column: about as many columns as triangles, fewer where these are long.
    fn list(&mut self) {
        let range = |surface: &Self, triangle: &Triangle, k: usize| {
            let along = triangle.map(|x| surface.column(x[k], k));
            along.into_iter().min().unwrap_or(0)..along.into_iter().max().unwrap_or(0) + 1
        };
        let count = |surface: &Self| -> usize {
            let of = |it| range(surface, it, 0).len() * range(surface, it, 1).len();
            surface.triangles.iter().map(of).sum()
        };
        while self.n > 1 && count(self) > MOST_LISTED {
            self.n /= 2;
        }
        let mut columns = vec![Vec::new(); self.n * self.n];
        for (number, triangle) in (0..).zip(&self.triangles) {
            for j in range(self, triangle, 1) {
                range(self, triangle, 0).for_each(|i| columns[self.n * j + i].push(number));
            }
        }
        self.columns = columns;
    }

    /// The number of the interval with a coordinate within the bounds, of n along an axis.
    fn column(&self, x: f64, k: usize) -> usize {
        let (low, high) = (self.bounds.0[k], self.bounds.1[k]);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; no number of a flat surface becomes 0"
        )]
        let at = (self.n as f64 * ((x - low) / (high - low))) as usize;
        at.min(self.n - 1)
    }

    /// The mean number of triangles that are visited for a point.
    pub(crate) fn n_visited(&self) -> f64 {
        self.columns.iter().map(Vec::len).sum::<usize>() as f64 / self.columns.len() as f64
    }

    pub(crate) fn holds(&self, x: &[f64; 3]) -> bool {
        let (low, high) = &self.bounds;
        if (0..3).any(|k| x[k] < low[k] || x[k] > high[k]) {
            return false;
        }
        let above = &self.columns[self.n * self.column(x[1], 1) + self.column(x[0], 0)];
        above.iter().map(|&it| crossing(&self.triangles[it as usize], x)).sum::<i32>() != 0
    }
}

/// Each edge of a closed surface is run as often in one sense as in the other; a message with their number otherwise.
fn check_closed(triangles: &[Triangle]) -> Result<(), String> {
    let mut numbers = HashMap::new();
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let corners = triangle.map(|x| {
            let next = numbers.len();
            *numbers.entry(x.map(f64::to_bits)).or_insert(next)
        });
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            edges.push((a.min(b), a.max(b), i32::from(a < b) - i32::from(b < a)));
        }
    }
    edges.sort_unstable();
    let sums = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let sums: Vec<i32> = sums.map(|same| same.iter().map(|edge| edge.2).sum()).collect();
    let n_open = sums.iter().filter(|sum| sum.abs() == 1).count();
    let n_turned = sums.iter().filter(|sum| sum.abs() > 1).count();
    if n_open + n_turned == 0 {
        return Ok(());
    }
    Err(format!(
        "is not a closed surface: of {} edges {n_open} are of one triangle, and {n_turned} of two with opposite orientations",
        sums.len()
    ))
}

/// 1 if a ray from a point along the third axis leaves through a triangle, -1 if it enters, 0 if it passes by.
///
/// Triangles that share an edge decide alike on which side of it the ray passes, so that it misses none of a closed surface.
fn crossing(triangle: &Triangle, x: &[f64; 3]) -> i32 {
    let around = |k: usize| {
        let [from, to] = [triangle[k], triangle[(k + 1) % 3]];
        let (low, high, sense) = if from[1] < to[1] { (from, to, 1) } else { (to, from, -1) };
        let turn = (high[0] - low[0]) * (x[1] - low[1]) - (high[1] - low[1]) * (x[0] - low[0]);
        if (low[1]..high[1]).contains(&x[1]) && turn > 0.0 { sense } else { 0 }
    };
    let sense = around(0) + around(1) + around(2);
    if sense != 0 && f64::from(sense) * volume(triangle, x) > 0.0 { sense } else { 0 }
}

/// Six times the volume between a triangle and a point, positive from behind.
fn volume(triangle: &Triangle, x: &[f64; 3]) -> f64 {
    let [a, b, c]: Triangle = triangle.map(|corner| std::array::from_fn(|k| corner[k] - x[k]));
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A sphere by n circles of latitude and 2 n of longitude; triangles at its poles have two corners in one.
    pub(crate) fn sphere(n: usize) -> Vec<Triangle> {
        let corner = |i: usize, j: usize| {
            let [polar, around] =
                [i, j % (2 * n)].map(|k| std::f64::consts::PI * k as f64 / n as f64);
            let sin = if i.is_multiple_of(n) { 0.0 } else { polar.sin() };
            [sin * around.cos(), sin * around.sin(), polar.cos()]
        };
        let of = |i: usize, j: usize| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
            [[a, b, c], [a, c, d]]
        };
        (0..2 * n * n).flat_map(|number| of(number / (2 * n), number % (2 * n))).collect()
    }

    /// A binary file whose head begins as text does.
    pub(crate) fn binary(triangles: &[Triangle]) -> Vec<u8> {
        #[allow(clippy::cast_possible_truncation, reason = "the format has single precision")]
        let corner = |x: [f64; 3]| stl_io::Vertex::new(x.map(|x| x as f32));
        let normal = stl_io::Normal::new([0.0; 3]);
        let of = |it: &Triangle| stl_io::Triangle { normal, vertices: it.map(corner) };
        let triangles: Vec<stl_io::Triangle> = triangles.iter().map(of).collect();
        let mut bytes = Vec::new();
        stl_io::write_stl(&mut bytes, triangles.iter()).unwrap();
        bytes[..6].copy_from_slice(b"solid ");
        bytes
    }

    pub(crate) fn surface(bytes: Vec<u8>) -> Result<Surface, String> {
        Surface::read(NamedFile::of("ball.stl", &bytes), bytes, (2.0, [0.5, 0.0, -1.0]))
    }

    #[test]
    fn crossings_are_the_winding_numbers_of_solid_angles() {
        // Two balls, one within the other with the opposite orientation: a shell.
        let flipped = |triangles: &[Triangle]| -> Vec<Triangle> {
            triangles.iter().map(|&[a, b, c]| [a, c, b]).collect()
        };
        let inner = sphere(5).into_iter().map(|corners| corners.map(|x| x.map(|x| 0.6 * x)));
        let shell = [sphere(8), flipped(&inner.collect::<Vec<_>>())].concat();
        let [one, other] = [&shell, &flipped(&shell)].map(|it| surface(binary(it)).unwrap());
        let angle = |triangle: &Triangle, x: &[f64; 3]| {
            let [a, b, c]: Triangle = triangle.map(|y| std::array::from_fn(|k| y[k] - x[k]));
            let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
            let [p, q, r] = [a, b, c].map(|edge| dot(edge, edge).sqrt());
            let below = p * q * r + dot(a, b) * r + dot(a, c) * q + dot(b, c) * p;
            2.0 * volume(triangle, x).atan2(below)
        };
        // Points on the planes of symmetry too, which have edges.
        let mut n_held = 0;
        for number in 0..11_usize.pow(3) {
            let along = [number % 11, number / 11 % 11, number / 121].map(|n| 0.4 * n as f64);
            let x = [along[0] - 1.5, along[1] - 2.0, along[2] - 3.05];
            let winding = one.triangles.iter().map(|it| angle(it, &x)).sum::<f64>();
            let expected = winding.abs() > std::f64::consts::TAU;
            assert_eq!([one.holds(&x), other.holds(&x)], [expected; 2], "{x:?}");
            n_held += usize::from(expected);
        }
        assert!(n_held > 300, "{n_held}");
    }

    #[test]
    fn what_is_no_closed_surface_is_refused() {
        let ball = sphere(4);
        let (mut turned, mut infinite) = (ball.clone(), ball.clone());
        turned[16].swap(0, 1);
        infinite[16][1][2] = f64::NAN;
        let text = |middle: &str| format!("solid a\n{middle}endsolid a\n").into_bytes();
        for (bytes, words) in [
            (
                binary(&[&ball[..16], &ball[17..]].concat()),
                "edges 3 are of one triangle, and 0 of two",
            ),
            (binary(&turned), "edges 0 are of one triangle, and 3 of two"),
            (binary(&infinite), "not finite"),
            (binary(&[]), "has no triangles"),
            (binary(&ball)[..1000].to_vec(), "neither text nor of 64 triangles"),
            (text(""), "has no triangles"),
            (text("endsolid a\nsolid b\n"), "more or less than one solid"),
            (text("facet normal 0 0 secret\n"), "as STL: invalid data"),
        ] {
            let message = surface(bytes).unwrap_err();
            assert!(message.contains(words) && !message.contains("secret"), "{message}");
        }
    }
}
