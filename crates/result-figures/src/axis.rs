//! Mapping from values to positions on the sheet, and the tick labels of an axis.

use crate::data::Scale;

/// One axis: its range in values and on the sheet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    scale: Scale,
    /// Values, or their decimal logarithms.
    from: f64,
    to: f64,
    start: f64,
    end: f64,
}

/// One end of an error bar on the sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum BarEnd {
    /// Inside the frame, drawn with a cap.
    At(f64),
    /// Outside the frame: the bar is cut at this position, without a cap.
    Beyond(f64),
}

impl BarEnd {
    pub(super) const fn at(self) -> f64 {
        match self {
            Self::At(at) | Self::Beyond(at) => at,
        }
    }
}

/// A grid line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    /// `None` for minor grid lines.
    pub(super) label: Option<String>,
}

impl Axis {
    /// An axis that spans `values` with a small margin, from `start` to `end` on the sheet.
    pub(super) fn spanning(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        (start, end): (f64, f64),
    ) -> Self {
        let values = values.map(|value| if scale == Scale::Log { value.log10() } else { value });
        let (mut from, mut to) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        // A single value, or none, also needs a range.
        if !(from.is_finite() && to.is_finite()) {
            (from, to) = (0.0, 1.0);
        }
        let least = if scale == Scale::Log { 0.8 } else { 1e-12_f64.max(1e-9 * from.abs()) };
        if to - from < least {
            let middle = f64::midpoint(from, to);
            let half = if scale == Scale::Log { 0.4 } else { 0.5 * middle.abs().max(1.0) };
            (from, to) = (middle - half, middle + half);
        }
        let room = 0.06 * (to - from);
        Self { scale, from: from - room, to: to + room, start, end }
    }

    /// Position of a value on the sheet.
    pub(super) fn place(&self, value: f64) -> f64 {
        let value = if self.scale == Scale::Log { value.log10() } else { value };
        self.start + (value - self.from) / (self.to - self.from) * (self.end - self.start)
    }

    /// End of an error bar: its position, or the edge of the frame if it lies beyond the axis.
    pub(super) fn place_end(&self, value: f64) -> BarEnd {
        if self.scale == Scale::Log && value <= 0.0 {
            return BarEnd::Beyond(self.start);
        }
        let at = self.place(value);
        let held = at.clamp(self.start.min(self.end), self.start.max(self.end));
        if (at - held).abs() > 0.5 { BarEnd::Beyond(held) } else { BarEnd::At(held) }
    }

    pub(super) const fn start(&self) -> f64 {
        self.start
    }

    pub(super) const fn end(&self) -> f64 {
        self.end
    }

    pub(super) fn ticks(&self) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(),
            Scale::Log => self.log_ticks(),
        }
    }

    fn linear_ticks(&self) -> Vec<Tick> {
        let rough = (self.to - self.from) / 8.0;
        let decade = 10_f64.powf(rough.log10().floor());
        // Subdivisions that are round numbers: 2 in fours, 1 and 5 in fives.
        let rounds = [(1.0, 5.0), (2.0, 4.0), (5.0, 5.0), (10.0, 5.0)];
        let (digit, n_minor) =
            rounds.into_iter().find(|round| round.0 * decade >= rough).unwrap_or(rounds[3]);
        let step = digit * decade;
        let minor = step / n_minor;
        let first = (self.from / minor).ceil();
        let n = ((self.to / minor).floor() - first).max(0.0);
        let index = |i: i32| first + f64::from(i);
        #[expect(clippy::cast_possible_truncation, reason = "an axis has tens of ticks")]
        let n = n as i32;
        let tick = |i: i32| {
            let value = index(i) * minor;
            let is_major = index(i).rem_euclid(n_minor) == 0.0;
            Tick { at: self.place(value), label: is_major.then(|| linear_label(value, step)) }
        };
        (0..=n).map(tick).collect()
    }

    /// Labels decades; a short axis also labels 2 and 5, a long one only every other decade.
    fn log_ticks(&self) -> Vec<Tick> {
        let span = self.to - self.from;
        let every = (span / 9.0).ceil().max(1.0);
        let short = span < 2.2;
        let plain = self.from >= -3.2 && self.to <= 4.0;
        let mut ticks = Vec::new();
        let mut decade = self.from.floor();
        while decade <= self.to {
            for digit in 1..=9_u8 {
                let exponent = decade + f64::from(digit).log10();
                if exponent < self.from || exponent > self.to {
                    continue;
                }
                let numbered = match digit {
                    1 => decade.rem_euclid(every) == 0.0,
                    2 | 5 => short,
                    _ => false,
                };
                let at = self.start + (exponent - self.from) / span * (self.end - self.start);
                ticks.push(Tick { at, label: numbered.then(|| log_label(digit, decade, plain)) });
            }
            decade += 1.0;
        }
        ticks
    }
}

fn linear_label(value: f64, step: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e6).contains(&step) {
        return format!("{value:.1e}");
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 4")]
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// A number in decimal form or as a power of ten; one axis uses only one of the two forms.
fn log_label(digit: u8, decade: f64, plain: bool) -> String {
    if plain {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and 3"
        )]
        let decimals = (-decade).max(0.0) as usize;
        return format!("{:.decimals$}", f64::from(digit) * 10_f64.powf(decade));
    }
    let power = format!("10{}", superscript(decade));
    if digit == 1 { power } else { format!("{digit}·{power}") }
}

fn superscript(exponent: f64) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => {
            digit.to_digit(10).and_then(|digit| char::from_u32('⁰' as u32 + digit)).unwrap_or(digit)
        }
    };
    format!("{exponent:.0}").chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn decades_are_numbered() {
        let axis = Axis::spanning(Scale::Log, [1e-4, 10.0].into_iter(), (0.0, 100.0));
        assert_eq!(labels(axis), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"]);
        let plain = Axis::spanning(Scale::Log, [0.003, 100.0].into_iter(), (0.0, 100.0));
        assert_eq!(labels(plain), ["0.01", "0.1", "1", "10", "100"]);
        assert!(axis.place(1e-4) > 0.0 && axis.place(10.0) < 100.0);
        assert!((axis.place(1e-4) + axis.place(10.0) - 100.0).abs() < 1e-9);
    }

    #[test]
    fn a_short_axis_has_numbers_between_the_decades() {
        let axis = Axis::spanning(Scale::Log, [3e-4, 8e-4].into_iter(), (0.0, 100.0));
        assert!(labels(axis).len() >= 2, "{:?}", labels(axis));
        let single = Axis::spanning(Scale::Log, std::iter::once(0.7), (0.0, 100.0));
        assert!(labels(single).len() >= 2, "{:?}", labels(single));
    }

    #[test]
    fn a_linear_axis_counts_in_ones_twos_or_fives() {
        let axis = Axis::spanning(Scale::Linear, [0.0, 10.0].into_iter(), (0.0, 100.0));
        assert_eq!(labels(axis), ["0", "2", "4", "6", "8", "10"]);
        let axis = Axis::spanning(Scale::Linear, [-0.03, 0.02].into_iter(), (100.0, 0.0));
        assert_eq!(labels(axis), ["-0.03", "-0.02", "-0.01", "0", "0.01", "0.02"]);
        assert!(axis.place(-0.03) > axis.place(0.02));
    }

    #[test]
    fn an_error_bar_ends_at_the_frame() {
        let axis = Axis::spanning(Scale::Log, [1e-3, 1.0].into_iter(), (100.0, 0.0));
        assert_eq!(axis.place_end(-1.0), BarEnd::Beyond(100.0));
        assert_eq!(axis.place_end(1e9), BarEnd::Beyond(0.0));
        assert_eq!(axis.place_end(0.1), BarEnd::At(axis.place(0.1)));
    }

    #[test]
    fn exponents_are_raised() {
        assert_eq!(superscript(-12.0), "⁻¹²");
        assert_eq!(superscript(307.0), "³⁰⁷");
    }
}
