//! Common parts of every chart: title, frame, grid, tick labels, legend, caption.

use super::axis::{Axis, BarEnd};
use super::canvas::{
    Anchor, Canvas, Drawn, FRAME, GRID, INK, Look, MINOR_GRID, SOFT, Type, text_width,
};
use crate::data::Words;

/// Size of the sheet.
pub(super) const SHEET: (f64, f64) = (960.0, 580.0);
/// Left and right edge of the frame; the legend is to the right of it and so never covers data.
pub(super) const FRAME_X: (f64, f64) = (84.0, 708.0);
/// Upper edge of the frame.
pub(super) const FRAME_TOP: f64 = 74.0;
const LEGEND_X: f64 = 728.0;
const LEGEND_WIDTH: f64 = 218.0;
const CAPTION_LINE: f64 = 15.0;

/// Lower edge of the frame, above the lines of the caption.
pub(super) fn frame_bottom(words: &Words) -> f64 {
    let n_lines =
        words.caption.iter().map(|line| wrap(line, 11.0, SHEET.0 - 48.0).len()).sum::<usize>();
    SHEET.1 - 62.0 - CAPTION_LINE * n_lines as f64
}

/// Draws title, axis labels and caption.
pub(super) fn draw_words(canvas: &Canvas<'_>, words: &Words, bottom: f64) -> Drawn {
    let middle = f64::midpoint(FRAME_X.0, FRAME_X.1);
    canvas.text(&words.title, (24.0, 26.0), Anchor::Left, Type::bold(18.0, INK))?;
    canvas.text(&words.subtitle, (24.0, 50.0), Anchor::Left, Type::new(13.0, SOFT))?;
    canvas.text(&words.x_label, (middle, bottom + 42.0), Anchor::Middle, Type::new(13.5, INK))?;
    let upwards = (26.0, f64::midpoint(FRAME_TOP, bottom));
    canvas.text(&words.y_label, upwards, Anchor::Upwards, Type::new(13.5, INK))?;
    let lines = words.caption.iter().flat_map(|line| wrap(line, 11.0, SHEET.0 - 48.0));
    for (i, line) in lines.enumerate() {
        let y = bottom + 68.0 + CAPTION_LINE * i as f64;
        canvas.text(&line, (24.0, y), Anchor::Left, Type::new(11.0, SOFT))?;
    }
    Ok(())
}

/// Draws the grid, minor lines first so that the major ones lie over them.
pub(super) fn draw_grid(canvas: &Canvas<'_>, x: &Axis, y: &Axis) -> Drawn {
    for is_major in [false, true] {
        let (colour, width) = if is_major { (GRID, 1.1) } else { (MINOR_GRID, 0.9) };
        for tick in x.ticks().iter().filter(|tick| tick.label.is_some() == is_major) {
            canvas.line(&[(tick.at, y.start()), (tick.at, y.end())], colour, width)?;
        }
        for tick in y.ticks().iter().filter(|tick| tick.label.is_some() == is_major) {
            canvas.line(&[(x.start(), tick.at), (x.end(), tick.at)], colour, width)?;
        }
    }
    Ok(())
}

/// Draws the frame from `top` and its tick labels.
pub(super) fn draw_frame(canvas: &Canvas<'_>, x: &Axis, y: &Axis, top: f64) -> Drawn {
    let (left, right, bottom) = (x.start(), x.end(), y.start());
    canvas.line(
        &[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)],
        FRAME,
        1.2,
    )?;
    let face = Type::new(12.0, INK);
    for tick in x.ticks() {
        let length = if tick.label.is_some() { 5.0 } else { 2.5 };
        canvas.line(&[(tick.at, bottom), (tick.at, bottom + length)], FRAME, 1.0)?;
        if let Some(label) = &tick.label {
            canvas.text(label, (tick.at, bottom + 16.0), Anchor::Middle, face)?;
        }
    }
    for tick in y.ticks() {
        let length = if tick.label.is_some() { 5.0 } else { 2.5 };
        canvas.line(&[(left - length, tick.at), (left, tick.at)], FRAME, 1.0)?;
        if let Some(label) = &tick.label {
            canvas.text(label, (left - 9.0, tick.at), Anchor::Right, face)?;
        }
    }
    Ok(())
}

/// Sample drawn in a legend entry.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sample {
    LineAndMarker(Look),
    Line(Look),
    Points(Look),
    Cross,
}

/// Draws the legend to the right of the frame.
pub(super) fn draw_legend<'n>(
    canvas: &Canvas<'_>,
    entries: impl Iterator<Item = (Sample, &'n str)>,
) -> Drawn {
    const SAMPLE: f64 = 38.0;
    const LINE: f64 = 16.0;
    let mut y = FRAME_TOP + 10.0;
    for (sample, name) in entries {
        let (from, to) = ((LEGEND_X, y), (LEGEND_X + SAMPLE, y));
        let middle = (LEGEND_X + SAMPLE / 2.0, y);
        match sample {
            Sample::LineAndMarker(look) => {
                canvas.dashed_line(&[from, to], look, 2.0)?;
                canvas.marker(middle, look, 4.6)?;
            }
            Sample::Line(look) => canvas.dashed_line(&[from, to], look, 2.2)?,
            Sample::Points(look) => {
                canvas.vertical_bar(
                    middle.0,
                    [BarEnd::At(y - 9.0), BarEnd::At(y + 9.0)],
                    look.colour,
                )?;
                canvas.open_marker(middle, look, 4.8)?;
            }
            Sample::Cross => canvas.cross(middle, 4.5, SOFT)?,
        }
        for line in wrap(name, 12.5, LEGEND_WIDTH - SAMPLE - 10.0) {
            canvas.text(
                &line,
                (LEGEND_X + SAMPLE + 10.0, y),
                Anchor::Left,
                Type::new(12.5, INK),
            )?;
            y += LINE;
        }
        y += 8.0;
    }
    Ok(())
}

/// Breaks a text into lines of at most `width`, at spaces.
fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_broken_at_spaces() {
        let lines = wrap("log-density fit, whitened by the running covariance", 12.0, 150.0);
        assert!(
            lines.len() >= 2 && lines.iter().all(|line| text_width(line, 12.0) <= 150.0),
            "{lines:?}"
        );
        assert_eq!(lines.join(" "), "log-density fit, whitened by the running covariance");
    }
}
