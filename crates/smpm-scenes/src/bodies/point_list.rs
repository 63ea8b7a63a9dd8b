//! Particles of a body whose places are listed in a file.

use std::collections::{HashMap, HashSet};

use scene_runs::scene::NamedFile;

/// Most particles of a list.
const MOST_POINTS: usize = 1_000_000;
/// Most particles, on the mean, in a box of the spacing that has any.
const MOST_IN_BOX: usize = 8;

/// Places of particles, each of which represents a box with edges of the spacing, read from a file.
#[derive(Debug, PartialEq)]
pub struct PointList {
    pub(crate) file: NamedFile,
    /// With zeros along axes that the scene does not have.
    pub(crate) places: Vec<[f64; 3]>,
    pub(crate) spacing: f64,
    /// Boxes with particles, of a lattice about the first.
    boxes: HashSet<[i64; 3]>,
}

impl PointList {
    /// The places in a file with a column for each axis, separated by blanks or commas. Lines that begin with `#` are ignored.
    ///
    /// A message after the file's name otherwise.
    pub(crate) fn read(
        file: NamedFile,
        bytes: &[u8],
        (n_axes, spacing): (usize, f64),
    ) -> Result<Self, String> {
        let mut list = Self { file, places: Vec::new(), spacing, boxes: HashSet::new() };
        let mut lines = HashMap::new();
        for (line, text) in (1..).zip(String::from_utf8_lossy(bytes).lines()) {
            let fields: Vec<&str> =
                text.split([',', ' ', '\t']).filter(|x| !x.is_empty()).collect();
            if fields.first().is_none_or(|field| field.starts_with('#')) {
                continue;
            }
            if fields.len() != n_axes {
                return Err(format!("line {line} has {} columns, not {n_axes}", fields.len()));
            }
            let mut place = [0.0; 3];
            for (k, field) in fields.iter().enumerate() {
                let number = field.parse().ok().filter(|x: &f64| x.is_finite());
                let wrong = || format!("line {line} column {} is no finite number", k + 1);
                place[k] = number.ok_or_else(wrong)? + 0.0;
            }
            if let Some(first) = lines.insert(place.map(f64::to_bits), line) {
                return Err(format!("line {line} has the particle of line {first}"));
            }
            if list.places.len() == MOST_POINTS {
                return Err(format!("has more than {MOST_POINTS} particles"));
            }
            list.places.push(place);
            list.boxes.insert(list.lattice_box(&place));
        }
        let (n, n_boxes) = (list.places.len(), list.boxes.len());
        if n == 0 {
            return Err("has no particles".to_owned());
        }
        if n > MOST_IN_BOX * n_boxes {
            return Err(format!("has {n} particles in {n_boxes} boxes of the spacing {spacing}"));
        }
        Ok(list)
    }

    /// Whether a particle is in the same box as a point.
    pub(crate) fn holds(&self, x: &[f64; 3]) -> bool {
        self.boxes.contains(&self.lattice_box(x))
    }

    fn lattice_box(&self, x: &[f64; 3]) -> [i64; 3] {
        #[allow(clippy::cast_possible_truncation, reason = "one too large saturates")]
        std::array::from_fn(|k| ((x[k] - self.places[0][k]) / self.spacing).round() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_are_read_or_refused_with_their_line() {
        let read = |text: &str| {
            PointList::read(NamedFile::of("a", b""), text.as_bytes(), (2, 0.5)).map(|it| it.places)
        };
        let places = vec![[1.0, 2.0, 0.0], [0.001, 0.0, 0.0]];
        assert_eq!(read("# x, y\r\n 1, 2\r\n\n1e-3\t-0\n"), Ok(places));
        let crowd = "0 0\n1e-2 0\n2e-2 0\n3e-2 0\n4e-2 0\n5e-2 0\n6e-2 0\n7e-2 0\n8e-2 0\n";
        for (text, words) in [
            ("#\n", "has no particles"),
            ("1 2\n1\n", "line 2 has 1 columns, not 2"),
            ("1 2\n1 secret\n", "line 2 column 2 is no finite number"),
            ("1 nan\n", "line 1 column 2 is no finite number"),
            ("1 0\n\n1 -0\n", "line 3 has the particle of line 1"),
            (crowd, "has 9 particles in 1 boxes of the spacing 0.5"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
