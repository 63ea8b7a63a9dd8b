//! Where a response along a line exceeds a level.

use sde_integrators::normal_probability;

use crate::error::Error;

/// Where the response along a line exceeds the level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Crossing {
    /// From this place on.
    At(f64),
    /// At every place looked at.
    Everywhere,
    /// At none.
    Nowhere,
}

impl Crossing {
    /// Probability of all that is beyond it.
    pub(crate) fn probability(self) -> f64 {
        match self {
            Self::Nowhere => 0.0,
            Self::Everywhere => 1.0,
            Self::At(s) => normal_probability(-s),
        }
    }

    /// Whether the response is expected to exceed the level at a place.
    fn exceeds(self, place: f64) -> bool {
        match self {
            Self::Nowhere => false,
            Self::Everywhere => true,
            Self::At(s) => place > s,
        }
    }
}

/// Probability of all intervals of a line on which the response exceeds the level, where they are not all that is beyond the crossing
/// that is known; none where they are.
///
/// Looks at places a step apart, from the first one to `far`, and bisects between two of which one exceeds the level. Beyond the
/// outermost places it goes on as there.
pub(crate) fn several_crossings(
    known: Crossing,
    (first, step): (f64, f64),
    far: f64,
    mut excess: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Option<f64>, Error> {
    let mut places = Vec::new();
    let mut s = first;
    while s <= far {
        places.push((s, excess(s)? > 0.0));
        s += step;
    }
    if places.iter().all(|&(s, is_above)| is_above == known.exceeds(s)) {
        return Ok(None);
    }
    if let Crossing::At(s) = known {
        // The search for it ended above the level, within its tolerance.
        places.push((s, true));
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let mut probability = if places[0].1 { 1.0 } else { 0.0 };
    for pair in places.windows(2) {
        let [(mut low, is_above), (mut high, is_next)] = [pair[0], pair[1]];
        if is_above == is_next {
            continue;
        }
        while high - low > ROOT_ERROR / (1.0 + high.abs().max(low.abs())) {
            let middle = 0.5 * (low + high);
            if (excess(middle)? > 0.0) == is_above {
                low = middle;
            } else {
                high = middle;
            }
        }
        let beyond = normal_probability(-0.5 * (low + high));
        probability += if is_next { beyond } else { -beyond };
    }
    Ok(Some(probability.max(0.0)))
}

/// Relative error of the probability beyond a crossing that a root may cause.
pub(crate) const ROOT_ERROR: f64 = 1e-4;

/// Longest step without a bracket, in standard deviations.
const LONGEST_STEP: f64 = 2.0;

/// Most responses along one line: 60 halvings of any bracket reach roundoff.
const MOST_VALUES: usize = 80;

/// A place on the line with the response there, less the level.
type Place = (f64, f64);

struct Search {
    slope: f64,
    far: f64,
    /// The last place that is safe, and the one that fails, nearest to each other.
    safe: Option<Place>,
    fails: Option<Place>,
    last: Option<Place>,
    /// Width of the bracket before the last two steps.
    widths: [f64; 2],
}

/// The crossing by secants in a bracket, from `start`, with a guess of the slope there; looks from `-far` to `far`.
///
/// A secant step shorter than the tolerance ends the search, so a linear response takes one value.
pub(crate) fn crossing(
    (start, slope, far): (f64, f64, f64),
    mut excess: impl FnMut(f64) -> Result<f64, Error>,
) -> Result<Crossing, Error> {
    let mut search =
        Search { slope, far, safe: None, fails: None, last: None, widths: [f64::INFINITY; 2] };
    let mut s = start;
    for _ in 0..MOST_VALUES {
        let value = excess(s)?;
        let secant = search.secant((s, value));
        let place = if value > 0.0 { &mut search.fails } else { &mut search.safe };
        *place = Some((s, value));
        search.last = Some((s, value));
        let tolerance = ROOT_ERROR / (1.0 + s.abs());
        if let Some(root) = secant
            && (root - s).abs() <= tolerance
        {
            return Ok(Crossing::At(root));
        }
        match search.next(secant) {
            Next::At(next) => s = next,
            Next::Ends(crossing) => return Ok(crossing),
        }
    }
    // The bracket is closed within roundoff, or the response is not a function of the place.
    Ok(search.fails.map_or(Crossing::Nowhere, |(s, _)| Crossing::At(s)))
}

enum Next {
    At(f64),
    Ends(Crossing),
}

impl Search {
    /// Root of the line through the last two places, or of the slope for the first one.
    fn secant(&self, (s, value): Place) -> Option<f64> {
        let slope = match self.last {
            None => self.slope,
            Some((before, earlier)) => (value - earlier) / (s - before),
        };
        let root = s - value / slope;
        (slope > 0.0 && root.is_finite()).then_some(root)
    }

    fn next(&mut self, secant: Option<f64>) -> Next {
        match (self.safe, self.fails) {
            (Some((low, _)), Some((high, _))) => {
                let (middle, width) = (0.5 * (low + high), (high - low).abs());
                if width <= ROOT_ERROR / (1.0 + high.abs()) {
                    return Next::Ends(Crossing::At(high));
                }
                let is_slow = width > 0.5 * self.widths[0];
                self.widths = [self.widths[1], width];
                let (left, right) = (low.min(high), low.max(high));
                let inside = secant.filter(|s| !is_slow && *s > left && *s < right);
                Next::At(inside.unwrap_or(middle))
            }
            (Some((low, _)), None) if low >= self.far => Next::Ends(Crossing::Nowhere),
            (None, Some((high, _))) if high <= -self.far => Next::Ends(Crossing::Everywhere),
            (Some((low, _)), None) => {
                let s = secant.filter(|s| *s > low).unwrap_or(low + 0.5 * LONGEST_STEP);
                Next::At(s.min(low + LONGEST_STEP).min(self.far))
            }
            (None, high) => {
                let high = high.map_or(self.far, |(s, _)| s);
                let s = secant.filter(|s| *s < high).unwrap_or(high - 0.5 * LONGEST_STEP);
                let s = s.max(high - LONGEST_STEP).max(-self.far);
                // The origin is safe for a rare event: a crossing behind it is another one.
                Next::At(if high > 0.0 && s < 0.0 { 0.0 } else { s })
            }
        }
    }
}
