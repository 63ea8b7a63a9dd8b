//! Lines, markers and text in units of 1/96 inch, drawn as SVG through plotters.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

use super::axis::BarEnd;
use crate::error::ChartError;

/// Scale factor of the drawing: the backend accepts only integer coordinates.
const FINENESS: f64 = 4.0;

/// Text.
pub(super) const INK: RGBColor = RGBColor(27, 36, 48);
/// Secondary text.
pub(super) const SOFT: RGBColor = RGBColor(91, 103, 117);
/// The frame.
pub(super) const FRAME: RGBColor = RGBColor(120, 130, 142);
/// Major grid lines.
pub(super) const GRID: RGBColor = RGBColor(218, 223, 229);
/// Minor grid lines.
pub(super) const MINOR_GRID: RGBColor = RGBColor(238, 241, 244);
/// Background of a strip outside the scale.
pub(super) const STRIP: RGBColor = RGBColor(246, 247, 249);
/// Background of the picture.
pub(super) const GROUND: RGBColor = RGBColor(255, 255, 255);

/// Okabe and Ito's colours that are legible on white, the most distinct first, and a grey.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(125, 125, 125),
];

/// Lengths of dash and gap; none for a solid line.
const DASHES: [&[f64]; 5] = [&[], &[9.0, 4.0], &[2.5, 3.0], &[10.0, 3.5, 2.5, 3.5], &[16.0, 5.0]];

/// Appearance of a series: colour, marker and dashes, each sufficient to identify it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) colour: RGBColor,
    pub(super) marker: Marker,
    pub(super) dashes: &'static [f64],
}

impl Look {
    pub(super) fn of_series(index: usize) -> Self {
        Self {
            colour: PALETTE[index % PALETTE.len()],
            marker: Marker::ALL[index % Marker::ALL.len()],
            dashes: DASHES[index % DASHES.len()],
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    InvertedTriangle,
    Pentagon,
}

impl Marker {
    const ALL: [Self; 6] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::InvertedTriangle,
        Self::Pentagon,
    ];

    /// Corners of a marker of radius 1 around the origin; none for a circle.
    fn corners(self) -> Vec<(f64, f64)> {
        let regular = |n: u32, turn: f64, radius: f64| {
            let corner = |i: u32| {
                let angle = std::f64::consts::TAU * (f64::from(i) / f64::from(n) + turn);
                (radius * angle.sin(), -radius * angle.cos())
            };
            (0..n).map(corner).collect()
        };
        match self {
            Self::Circle => Vec::new(),
            Self::Square => regular(4, 0.125, 1.25),
            Self::Triangle => regular(3, 0.0, 1.3),
            Self::Diamond => regular(4, 0.0, 1.3),
            Self::InvertedTriangle => regular(3, 0.5, 1.3),
            Self::Pentagon => regular(5, 0.0, 1.2),
        }
    }
}

/// Position of a text relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
    /// Centred and rotated to read upwards.
    Upwards,
}

/// Size, weight and colour of a text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Type {
    pub(super) size: f64,
    pub(super) weight: Weight,
    pub(super) colour: RGBColor,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    Normal,
    Bold,
}

impl Type {
    pub(super) const fn new(size: f64, colour: RGBColor) -> Self {
        Self { size, weight: Weight::Normal, colour }
    }
    pub(super) const fn bold(size: f64, colour: RGBColor) -> Self {
        Self { size, weight: Weight::Bold, colour }
    }
}

/// Estimated width of a text: the backend has no font metrics, so a layout must tolerate an error.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let width_of = |c: char| match c {
        'i' | 'l' | 'j' | '.' | ',' | ':' | ';' | '|' | '\'' | ' ' => 0.3,
        'm' | 'w' | 'M' | 'W' => 0.85,
        c if c.is_uppercase() => 0.68,
        _ => 0.56,
    };
    text.chars().map(width_of).sum::<f64>() * size
}

/// The drawing area.
pub(super) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

pub(super) type Drawn = Result<(), ChartError>;

/// Draws on a sheet of `width` by `height` and returns the SVG; screen readers read `title`.
pub(super) fn draw_svg(
    (width, height): (f64, f64),
    title: &str,
    draw: impl FnOnce(&Canvas<'_>) -> Drawn,
) -> Result<String, ChartError> {
    let mut svg = String::new();
    let fine = |length: f64| u32::try_from(fine(length)).unwrap_or(0);
    let (fine_width, fine_height) = (fine(width), fine(height));
    {
        let canvas = Canvas {
            area: SVGBackend::with_string(&mut svg, (fine_width, fine_height)).into_drawing_area(),
        };
        canvas.rectangle((0.0, 0.0), (width, height), GROUND)?;
        draw(&canvas)?;
        canvas.area.present().map_err(picture)?;
    }
    let own_size = format!("width=\"{fine_width}\" height=\"{fine_height}\"");
    let title = title.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    let size = format!("width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"{title}\"");
    Ok(svg.replacen(&own_size, &size, 1))
}

fn picture<E: std::fmt::Display>(error: E) -> ChartError {
    ChartError::Picture { message: error.to_string() }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a picture is thousands of units wide, not billions"
)]
fn fine(length: f64) -> i32 {
    (length * FINENESS).round() as i32
}

fn fine_point((x, y): (f64, f64)) -> (i32, i32) {
    (fine(x), fine(y))
}

fn stroke(colour: RGBColor, width: f64) -> ShapeStyle {
    colour.stroke_width(u32::try_from(fine(width)).unwrap_or(1))
}

impl Canvas<'_> {
    pub(super) fn line(&self, points: &[(f64, f64)], colour: RGBColor, width: f64) -> Drawn {
        let points: Vec<(i32, i32)> = points.iter().copied().map(fine_point).collect();
        self.area.draw(&PathElement::new(points, stroke(colour, width))).map_err(picture)
    }

    /// A dashed line with the given dash lengths; solid if there are none.
    pub(super) fn dashed_line(&self, points: &[(f64, f64)], look: Look, width: f64) -> Drawn {
        if look.dashes.is_empty() {
            return self.line(points, look.colour, width);
        }
        dashes(points, look.dashes).iter().try_for_each(|dash| self.line(dash, look.colour, width))
    }

    /// A filled transparent polygon.
    pub(super) fn veil(&self, points: &[(f64, f64)], colour: RGBColor) -> Drawn {
        let points: Vec<(i32, i32)> = points.iter().copied().map(fine_point).collect();
        self.area.draw(&Polygon::new(points, colour.mix(0.2).filled())).map_err(picture)
    }

    pub(super) fn rectangle(&self, from: (f64, f64), to: (f64, f64), fill: RGBColor) -> Drawn {
        let corners = [fine_point(from), fine_point(to)];
        self.area.draw(&Rectangle::new(corners, fill.filled())).map_err(picture)
    }

    /// A filled marker with a thin white rim that separates it from lines and neighbouring markers.
    pub(super) fn marker(&self, at: (f64, f64), look: Look, radius: f64) -> Drawn {
        self.shape(at, look.marker, radius + 1.2, GROUND)?;
        self.shape(at, look.marker, radius, look.colour)
    }

    /// A marker drawn as an outline, filled white.
    pub(super) fn open_marker(&self, at: (f64, f64), look: Look, radius: f64) -> Drawn {
        self.shape(at, look.marker, radius, look.colour)?;
        self.shape(at, look.marker, radius - 1.6, GROUND)
    }

    fn shape(&self, at: (f64, f64), marker: Marker, radius: f64, fill: RGBColor) -> Drawn {
        let corners = marker.corners();
        if corners.is_empty() {
            let radius = u32::try_from(fine(radius)).unwrap_or(1);
            return self
                .area
                .draw(&Circle::new(fine_point(at), radius, fill.filled()))
                .map_err(picture);
        }
        let corner = |&(x, y): &(f64, f64)| fine_point((at.0 + radius * x, at.1 + radius * y));
        let corners: Vec<(i32, i32)> = corners.iter().map(corner).collect();
        self.area.draw(&Polygon::new(corners, fill.filled())).map_err(picture)
    }

    pub(super) fn cross(&self, (x, y): (f64, f64), radius: f64, colour: RGBColor) -> Drawn {
        self.line(&[(x - radius, y - radius), (x + radius, y + radius)], colour, 2.2)?;
        self.line(&[(x - radius, y + radius), (x + radius, y - radius)], colour, 2.2)
    }

    /// A vertical error bar at `x`.
    pub(super) fn vertical_bar(&self, x: f64, ends: [BarEnd; 2], colour: RGBColor) -> Drawn {
        self.bar(ends, colour, |along, across| (x + across, along))
    }

    /// A horizontal error bar at `y`.
    pub(super) fn horizontal_bar(&self, y: f64, ends: [BarEnd; 2], colour: RGBColor) -> Drawn {
        self.bar(ends, colour, |along, across| (along, y + across))
    }

    fn bar(
        &self,
        ends: [BarEnd; 2],
        colour: RGBColor,
        point: impl Fn(f64, f64) -> (f64, f64),
    ) -> Drawn {
        const CAP: f64 = 3.0;
        let [from, to] = ends.map(BarEnd::at);
        self.line(&[point(from, 0.0), point(to, 0.0)], colour, 1.1)?;
        for end in ends {
            if let BarEnd::At(at) = end {
                self.line(&[point(at, -CAP), point(at, CAP)], colour, 1.1)?;
            }
        }
        Ok(())
    }

    /// One line of text; `at` is its vertical centre.
    pub(super) fn text(&self, text: &str, at: (f64, f64), anchor: Anchor, face: Type) -> Drawn {
        let horizontal = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle | Anchor::Upwards => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let turn =
            if anchor == Anchor::Upwards { FontTransform::Rotate270 } else { FontTransform::None };
        let weight = if face.weight == Weight::Bold { FontStyle::Bold } else { FontStyle::Normal };
        // The backend divides the size by 1.24.
        let font = ("sans-serif", face.size * FINENESS * 1.24, weight).into_font().transform(turn);
        let style =
            TextStyle::from(font).color(&face.colour).pos(Pos::new(horizontal, VPos::Center));
        self.area.draw(&Text::new(text.to_owned(), fine_point(at), style)).map_err(picture)
    }
}

/// Cuts a line into dashes; the pattern continues around corners.
fn dashes(points: &[(f64, f64)], pattern: &[f64]) -> Vec<Vec<(f64, f64)>> {
    let mut drawn = Vec::new();
    let (mut step, mut left) = (0, pattern[0]);
    let mut dash: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    for ends in points.windows(2) {
        let (from, to) = (ends[0], ends[1]);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let share = done / length;
            let cut = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            if step % 2 == 0 {
                dash.push(cut);
                drawn.push(std::mem::take(&mut dash));
            } else {
                dash = vec![cut];
            }
            step = (step + 1) % pattern.len();
            left = pattern[step];
        }
        left -= length - done;
        if step % 2 == 0 {
            dash.push(to);
        }
    }
    if dash.len() > 1 {
        drawn.push(dash);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_cover_their_share_of_a_line_around_a_corner() {
        let line = [(0.0, 0.0), (30.0, 0.0), (30.0, 70.0)];
        let drawn = dashes(&line, &[6.0, 4.0]);
        let length = |dash: &Vec<(f64, f64)>| -> f64 {
            dash.windows(2).map(|ends| (ends[1].0 - ends[0].0).hypot(ends[1].1 - ends[0].1)).sum()
        };
        let total: f64 = drawn.iter().map(length).sum();
        assert!((total - 60.0).abs() < 1e-9, "{total}");
        assert_eq!(drawn.len(), 10);
    }

    #[test]
    fn text_stays_text_in_a_generic_family() {
        let svg = draw_svg((100.0, 50.0), "a & b", |canvas| {
            canvas.text("E[q^2] < 1", (10.0, 10.0), Anchor::Left, Type::new(12.0, INK))
        });
        let svg = svg.unwrap();
        assert!(
            svg.contains("E[q^2] &lt; 1") && svg.contains("font-family=\"sans-serif\""),
            "{svg}"
        );
        assert!(
            svg.contains("width=\"100\" height=\"50\"") && svg.contains("aria-label=\"a &amp; b\""),
            "{svg}"
        );
    }
}
