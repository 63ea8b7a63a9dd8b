//! A field over a plane or on particles, frame by frame, packed for a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use result_figures::number::short;
use serde::Serialize;

use crate::bytes::Range;
use crate::error::PageError;

/// A field that a slider moves through its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Its heading.
    pub title: String,
    /// What it shows and what was left out, in sentences.
    pub about: String,
    /// What the slider selects: `time`, `realisation`.
    pub slider: String,
    /// Axes with their units, one to three.
    pub axes: Vec<String>,
    /// Its frames, in the order of the slider.
    pub frames: Vec<Frame>,
    /// Where the values are.
    pub place: Place,
    /// What can be shown.
    pub layers: Vec<Layer>,
}

/// A frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Its name, e.g. `t = 5 s`.
    pub name: String,
}

/// Places of values.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// Cells of a plane, for each frame.
    Cells(Vec<Cells>),
    /// Particles.
    Points(Points),
}

/// Cells of equal size that cover a rectangle; their values go row by row from the bottom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cells {
    /// Number along each axis.
    pub count: [usize; 2],
    /// Ends of the rectangle along the first axis.
    pub x: [f64; 2],
    /// Ends of the rectangle along the second axis.
    pub y: [f64; 2],
}

/// Particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Distance between neighbours, the size at which they are drawn.
    pub spacing: f64,
    /// For each frame, or once for all, the coordinates of all particles, one particle after the other.
    pub positions: Vec<Vec<f64>>,
}

/// A quantity on all places.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name.
    pub name: String,
    /// Unit; empty for a dimensionless quantity.
    pub unit: String,
    /// Scale of its colours.
    pub scale: Scale,
    /// Its values at all places, for each frame, or once for all. Single precision is finer than the packed values.
    pub values: Vec<Vec<f32>>,
}

/// Scale of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// From the least value of all frames to the largest.
    Linear,
    /// From the largest value of all frames down to 1e-6 of it; what is below has no colour.
    SixDecades,
}

/// Decades of [`Scale::SixDecades`].
const DECADES: f64 = 6.0;

/// What the page's program reads.
#[derive(Debug, Serialize)]
pub(crate) struct Packed {
    title: String,
    slider: String,
    axes: Vec<String>,
    frames: Vec<String>,
    layers: Vec<PackedLayer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cells: Option<Vec<Cells>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<PackedPoints>,
}

#[derive(Debug, Serialize)]
struct PackedLayer {
    name: String,
    unit: String,
    is_logarithmic: bool,
    /// Range of the values, or of their decimal logarithms.
    range: Range,
    /// Largest error of a packed value, in words.
    error: String,
    /// A byte for each value, base64, for each frame or once.
    data: Vec<String>,
}

#[derive(Debug, Serialize)]
struct PackedPoints {
    count: usize,
    spacing: f64,
    /// Range of each coordinate.
    ranges: Vec<Range>,
    /// Two bytes for each coordinate, the lower first, base64, for each frame or once.
    data: Vec<String>,
}

impl Motion {
    /// Bytes that the packed fields of a page take, before base64.
    pub const BUDGET: usize = 1_600_000;
    /// Largest number of frames.
    pub const MOST_FRAMES: usize = 60;

    /// Every how many particles one is shown, so that all frames fit in the budget.
    ///
    /// A particle takes two bytes for each of `n_axes` coordinates and one for each of `n_layers` values, in each of `n_frames`.
    #[must_use]
    pub fn stride(n_points: usize, n_frames: usize, n_axes: usize, n_layers: usize) -> usize {
        let bytes = n_frames.max(1) * (2 * n_axes + n_layers);
        (n_points * bytes).div_ceil(Self::BUDGET).max(1)
    }

    /// Frames that are shown of `n`, at most `most` and [`Self::MOST_FRAMES`]: all, or every k-th, the last one among them.
    #[must_use]
    pub fn shown_frames(n: usize, most: usize) -> Vec<usize> {
        let every = n.div_ceil(most.clamp(1, Self::MOST_FRAMES)).max(1);
        let mut shown: Vec<usize> = (0..n).rev().step_by(every).collect();
        shown.reverse();
        shown
    }

    /// The form that the page's program reads.
    ///
    /// # Errors
    /// [`PageError::Field`] for a value that is not finite; [`PageError::Count`] for a frame with missing values.
    pub(crate) fn packed(&self) -> Result<Packed, PageError> {
        let n = self.frames.len();
        let (counts, cells, points): (Vec<usize>, _, _) = match &self.place {
            Place::Cells(cells) => {
                check("cells", 0, cells.len(), n)?;
                let counts = cells.iter().map(|it| it.count[0] * it.count[1]).collect();
                (counts, Some(cells.clone()), None)
            }
            Place::Points(points) => {
                let packed = self.packed_points(points)?;
                (vec![packed.count; n], None, Some(packed))
            }
        };
        let layers = self.layers.iter().map(|layer| layer.packed(&counts));
        Ok(Packed {
            title: self.title.clone(),
            slider: self.slider.clone(),
            axes: self.axes.clone(),
            frames: self.frames.iter().map(|frame| frame.name.clone()).collect(),
            layers: layers.collect::<Result<_, _>>()?,
            cells,
            points,
        })
    }

    fn packed_points(&self, points: &Points) -> Result<PackedPoints, PageError> {
        let n_axes = self.axes.len().max(1);
        let n_frames = points.positions.len();
        if n_frames != 1 {
            check("position", 0, n_frames, self.frames.len())?;
        }
        let length = points.positions.first().map_or(0, Vec::len);
        for (frame, positions) in points.positions.iter().enumerate() {
            check("position", frame, positions.len(), length / n_axes * n_axes)?;
        }
        let along = |axis: usize| {
            let values = points.positions.iter().enumerate();
            let one = move |(frame, all): (usize, &Vec<f64>)| {
                let values: Vec<f64> = all.iter().skip(axis).step_by(n_axes).copied().collect();
                values.into_iter().map(move |value| (frame, value))
            };
            Range::of("position", values.flat_map(one))
        };
        let ranges: Vec<Range> = (0..n_axes).map(along).collect::<Result<_, _>>()?;
        let pack = |positions: &Vec<f64>| {
            let code = |(k, &value): (usize, &f64)| ranges[k % n_axes].code(value, u16::MAX);
            let codes = positions.iter().enumerate().map(code);
            STANDARD.encode(codes.flat_map(u16::to_le_bytes).collect::<Vec<u8>>())
        };
        let data = points.positions.iter().map(pack).collect();
        Ok(PackedPoints { count: length / n_axes, spacing: points.spacing, ranges, data })
    }
}

impl Layer {
    fn packed(&self, counts: &[usize]) -> Result<PackedLayer, PageError> {
        if self.values.len() != 1 {
            check(&self.name, 0, self.values.len(), counts.len())?;
        }
        for (frame, (values, &count)) in self.values.iter().zip(counts).enumerate() {
            check(&self.name, frame, values.len(), count)?;
        }
        let all = self.values.iter().enumerate();
        let all =
            all.flat_map(|(frame, values)| values.iter().map(move |&v| (frame, f64::from(v))));
        let range = Range::of(&self.name, all)?;
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let (range, error) = match self.scale {
            Scale::Linear => {
                let error = range.half_step(u16::from(u8::MAX));
                (range, format!("± {}{unit}", short(Some(error))))
            }
            Scale::SixDecades => {
                // A field without a positive value has one colour, that of nothing.
                let top = range.high.max(f64::MIN_POSITIVE).log10();
                let range = Range { low: top - DECADES, high: top };
                let factor = 10f64.powf(range.half_step(u16::from(u8::MAX))) - 1.0;
                (range, format!("± {} % of it", short(Some(100.0 * factor))))
            }
        };
        let is_logarithmic = self.scale == Scale::SixDecades;
        let data =
            self.values.iter().map(|values| STANDARD.encode(codes(values, range, self.scale)));
        let (name, unit) = (self.name.clone(), self.unit.clone());
        Ok(PackedLayer { name, unit, is_logarithmic, range, error, data: data.collect() })
    }
}

/// A byte for each value. On the logarithmic scale code 0 is a value at or below the end of the scale.
fn codes(values: &[f32], range: Range, scale: Scale) -> Vec<u8> {
    let code = |&value: &f32| {
        let value = match scale {
            Scale::Linear => f64::from(value),
            Scale::SixDecades if value > 0.0 => f64::from(value).log10(),
            Scale::SixDecades => range.low,
        };
        u8::try_from(range.code(value, u16::from(u8::MAX))).unwrap_or(u8::MAX)
    };
    values.iter().map(code).collect()
}

fn check(layer: &str, frame: usize, found: usize, expected: usize) -> Result<(), PageError> {
    if found == expected {
        return Ok(());
    }
    Err(PageError::Count { layer: layer.to_owned(), frame, found, expected })
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn line(values: Vec<Vec<f32>>) -> Motion {
        let frame = |k: usize| Frame { name: format!("t = {k}") };
        Motion {
            title: "bar".into(),
            about: String::new(),
            slider: "time".into(),
            axes: vec!["x (m)".into()],
            frames: (0..values.len()).map(frame).collect(),
            place: Place::Points(Points { spacing: 1.0, positions: vec![vec![0.0, 1.0, 4.0]] }),
            layers: vec![Layer {
                name: "stress".into(),
                unit: "Pa".into(),
                scale: Scale::Linear,
                values,
            }],
        }
    }

    #[test]
    fn packed_values_are_within_the_error_that_they_state() {
        let values: Vec<f32> = vec![-3.0, 0.123, 7.0];
        let packed = line(vec![values.clone()]).packed().unwrap();
        let layer = &packed.layers[0];
        let bytes = STANDARD.decode(&layer.data[0]).unwrap();
        // 10 / 255 / 2 = 0.0196.
        assert_eq!(layer.error, "± 0.0196 Pa");
        for (byte, value) in bytes.iter().zip(&values) {
            let back = layer.range.low + f64::from(*byte) * 10.0 / 255.0;
            assert!((back - f64::from(*value)).abs() <= 0.0197, "{back} for {value}");
        }
        let points = packed.points.unwrap();
        let bytes = STANDARD.decode(&points.data[0]).unwrap();
        // A quarter of 65,535 is 16,383.75, and its nearest code 0x4000.
        assert_eq!(bytes, [0, 0, 0x00, 0x40, 0xff, 0xff]);
    }

    #[test]
    fn a_density_is_packed_by_its_logarithm_and_nothing_is_code_zero() {
        let mut motion = line(vec![vec![1.0, 1e-3, 0.0]]);
        motion.layers[0].scale = Scale::SixDecades;
        let packed = motion.packed().unwrap();
        let bytes = STANDARD.decode(&packed.layers[0].data[0]).unwrap();
        // Three of six decades below the peak: 1 + 254 / 2.
        assert_eq!((bytes[0], bytes[2]), (255, 0));
        assert!(bytes[1].abs_diff(128) <= 1, "{}", bytes[1]);
        assert_eq!(packed.layers[0].error, "± 2.75 % of it");
    }

    #[test]
    fn missing_and_infinite_values_are_refused() {
        let short = line(vec![vec![1.0, 2.0]]).packed();
        assert!(matches!(short, Err(PageError::Count { found: 2, expected: 3, .. })));
        let nan = line(vec![vec![1.0, 2.0, 3.0], vec![1.0, f32::NAN, 3.0]]).packed();
        assert!(matches!(nan, Err(PageError::Field { frame: 1, .. })));
        let mut far = line(vec![vec![1.0; 3]]);
        far.place =
            Place::Points(Points { spacing: 1.0, positions: vec![vec![0.0, f64::INFINITY, 1.0]] });
        assert!(matches!(far.packed(), Err(PageError::Field { .. })));
    }

    #[test]
    fn frames_and_particles_are_thinned_to_the_budget() {
        assert_eq!(Motion::shown_frames(3, 60), [0, 1, 2]);
        let shown = Motion::shown_frames(200, 1000);
        assert!(shown.len() <= Motion::MOST_FRAMES && shown.last() == Some(&199));
        assert_eq!(Motion::shown_frames(10, 4), [0, 3, 6, 9]);
        assert_eq!(Motion::stride(5000, 17, 2, 10), 1);
        let stride = Motion::stride(1_000_000, 17, 3, 10);
        assert!(1_000_000 / stride * 17 * 16 <= Motion::BUDGET, "{stride}");
    }
}
