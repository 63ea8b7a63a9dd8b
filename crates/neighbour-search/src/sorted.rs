//! Points in an order that preserves locality, and the interface of such an order.

use core::ops::Range;

use simd_lanes::MOST_LANES;

use crate::criterion::Criterion;
use crate::domain::Domain;
use crate::error::Error;
use crate::frame::{Bounds, Frame};
use crate::index::stored;
use crate::parallel;
use crate::radii::Radii;

/// Points in the order of a search, in single precision, padded so that a full vector can be read from any slot.
#[derive(Debug, Clone)]
pub(crate) struct Sorted<const D: usize> {
    pub(crate) domain: Domain<D>,
    /// Point of each slot, padded, and the slots themselves.
    pub(crate) ids: Vec<u32>,
    pub(crate) slots: Vec<u32>,
    /// Coordinates in the frame, within the first period along a periodic axis.
    pub(crate) columns: [Vec<f32>; D],
    pub(crate) frame: Frame<D>,
    /// Radii, where each point has its own, without padding.
    pub(crate) radii: Vec<f64>,
    /// Bounds on the radii in units of the frame, padded.
    pub(crate) lower: Vec<f32>,
    pub(crate) upper: Vec<f32>,
    /// Largest radius.
    pub(crate) largest: f64,
    /// Coordinates in double precision, within the first period along a periodic axis.
    pub(crate) points: Vec<[f64; D]>,
}

impl<const D: usize> Default for Sorted<D> {
    fn default() -> Self {
        Self {
            domain: Domain::unbounded(),
            ids: Vec::new(),
            slots: Vec::new(),
            columns: [const { Vec::new() }; D],
            frame: Frame::default(),
            radii: Vec::new(),
            lower: Vec::new(),
            upper: Vec::new(),
            largest: 0.0,
            points: Vec::new(),
        }
    }
}

impl<const D: usize> Sorted<D> {
    /// Number of points.
    pub(crate) fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Point of each slot.
    pub(crate) fn order(&self) -> &[u32] {
        &self.ids[..self.n_points()]
    }

    /// Copies coordinates and radii in the order of the ids; `bounds` is a box of most points.
    pub(crate) fn gather(&mut self, points: &[[f64; D]], radii: Radii<'_>, bounds: &Bounds<D>) {
        let Self { domain, ids, slots, columns, radii: own, points: kept, .. } = self;
        let n = points.len();
        self.largest = radii.largest();
        let reach = if n == 0 { 1.0 } else { self.largest };
        let frame = Frame::new(bounds, reach, domain, 2.0_f64.powi(-22));
        ids.resize(n + MOST_LANES, 0);
        slots.resize(n + MOST_LANES, 0);
        parallel::fill(slots, stored);
        kept.resize(n, [0.0; D]);
        parallel::fill_from(kept, ids, |&id| domain.wrap_all(&points[id as usize]));
        for ((axis, column), place) in columns.iter_mut().enumerate().zip(frame.places(&[0.0; D])) {
            column.resize(n + MOST_LANES, 0.0);
            parallel::fill_from(&mut column[..n], kept, |x| place.of(x[axis]));
        }
        self.frame = frame;
        match radii {
            Radii::Uniform(_) => own.clear(),
            Radii::PerPoint { radii, .. } => {
                own.resize(n, 0.0);
                parallel::fill_from(own, ids, |&id| radii[id as usize]);
                for (column, which) in [(&mut self.lower, 0), (&mut self.upper, 1)] {
                    column.resize(n + MOST_LANES, 0.0);
                    parallel::fill_from(&mut column[..n], own, |&radius| {
                        frame.bounds(radius)[which]
                    });
                }
            }
        }
    }

    /// Box around some slots and the largest of their radii, in units of the frame; not finite if it is too wide.
    #[inline(always)]
    pub(crate) fn narrow_bounds(&self, slots: Range<usize>) -> ([f32; D], [f32; D], f64) {
        let (mut low, mut high) = ([0.0; D], [0.0; D]);
        for axis in 0..D {
            let column = &self.columns[axis][slots.clone()];
            let (mut least, mut most) = (column[0], column[0]);
            for &x in column {
                least = if x < least { x } else { least };
                most = if x > most { x } else { most };
            }
            (low[axis], high[axis]) = (least, most);
        }
        let radius = if self.radii.is_empty() {
            0.0
        } else {
            self.radii[slots].iter().fold(0.0, |largest: f64, &radius| largest.max(radius))
        };
        (low, high, radius)
    }

    /// Box in the unit of the points, slightly enlarged.
    #[inline(always)]
    pub(crate) fn widened(&self, (low, high, radius): ([f32; D], [f32; D], f64)) -> Bounds<D> {
        let Frame { origin, scale, fixed, .. } = self.frame;
        let mut bounds = Bounds { low: origin, high: origin, radius };
        for axis in 0..D {
            bounds.low[axis] += (f64::from(low[axis]) - fixed) / scale;
            bounds.high[axis] += (f64::from(high[axis]) + fixed) / scale;
        }
        bounds
    }
}

/// Criterion of a pair, as in [`Radii`].
#[derive(Debug, Clone, Copy)]
pub(crate) enum Rule {
    Uniform(f64),
    PerPoint(Criterion),
}

impl Rule {
    pub(crate) fn of(radii: Radii<'_>) -> Self {
        match radii {
            Radii::Uniform(radius) => Self::Uniform(radius),
            Radii::PerPoint { criterion, .. } => Self::PerPoint(criterion),
        }
    }

    /// Contribution of one point to the search radius.
    ///
    /// The search radius is this value, or the larger or the mean of both points' values.
    #[inline(always)]
    pub(crate) fn mine(self, h_i: f64) -> f64 {
        match self {
            Self::Uniform(radius) => radius,
            Self::PerPoint(Criterion::Scatter) => 0.0,
            Self::PerPoint(_) => h_i,
        }
    }

    /// Search radius between a point of radius `h_i` and a point of radius `h_j`; increases with both.
    #[inline(always)]
    pub(crate) fn limit(self, h_i: f64, h_j: f64) -> f64 {
        match self {
            Self::Uniform(radius) => radius,
            Self::PerPoint(criterion) => criterion.limit(h_i, h_j),
        }
    }
}

/// Pairs to be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Listed {
    /// All pairs, mutual ones in both directions.
    Full,
    /// Each pair once, under the point with the smaller slot.
    Half,
}

/// Slots that may hold candidates, and the displacement of their points.
#[derive(Debug, Clone)]
pub(crate) struct Stretch<const D: usize> {
    pub(crate) slots: Range<usize>,
    pub(crate) shift: [f64; D],
}

/// An order of points in which the points near a box are stretches of slots.
pub(crate) trait Order<const D: usize>: Sync {
    fn sorted(&self) -> &Sorted<D>;

    /// Group of a slot: groups are stretches of slots with neighbouring points.
    fn group_of(&self, slot: usize) -> usize;

    /// End of a group.
    fn group_end(&self, group: usize) -> usize;

    /// Appends the stretches with candidates of the group `targets`.
    ///
    /// These are its own points, their images, and all other points near it.
    ///
    /// Returns the number of stretches of its own points.
    fn stretches(
        &self,
        targets: &Range<usize>,
        bounds: &Bounds<D>,
        rule: Rule,
        listed: Listed,
        found: &mut Vec<Stretch<D>>,
    ) -> usize;
}

/// Construction of an order, and its search near a box.
pub(crate) trait Near<const D: usize>: Order<D> {
    /// Checks the input and sorts points and radii, by a typical radius.
    fn sort(&mut self, points: &[[f64; D]], radii: Radii<'_>) -> Result<(), Error>;

    /// Checks the points and sorts them for queries within about `edge` of a position.
    fn build(&mut self, points: &[[f64; D]], edge: f64) -> Result<(), Error>;

    /// Calls `visit` with stretches of slots that hold every neighbour, by `rule`, of a point of the box.
    ///
    /// Stretches ascend and contain each slot at most once; all points are displaced by `shift`.
    fn for_each_stretch(
        &self,
        bounds: &Bounds<D>,
        rule: Rule,
        shift: &[f64; D],
        visit: impl FnMut(Range<usize>),
    );

    /// A radius that probably contains a given number of points around a position.
    fn radius_for(&self, place: &[f64; D], wanted: usize) -> f64;
}

/// Implements [`Order::stretches`] for an order with [`Near`].
#[inline]
pub(crate) fn stretches<const D: usize>(
    order: &impl Near<D>,
    targets: &Range<usize>,
    bounds: &Bounds<D>,
    rule: Rule,
    listed: Listed,
    found: &mut Vec<Stretch<D>>,
) -> usize {
    let sorted = order.sorted();
    let reach = rule.limit(bounds.radius, sorted.largest);
    let mut push = |slots: Range<usize>, shift: &[f64; D]| {
        if !slots.is_empty() {
            found.push(Stretch { slots, shift: *shift });
        }
        found.len()
    };
    let mut own = push(targets.clone(), &[0.0; D]);
    if sorted.domain.is_periodic() {
        for_each_image(sorted, bounds, reach, |bounds, shift| {
            if shift.iter().any(|&along| along != 0.0) {
                order.for_each_stretch(bounds, rule, shift, |slots| {
                    own = push(slots.start.max(targets.start)..slots.end.min(targets.end), shift);
                });
            }
        });
    }
    for_each_image(sorted, bounds, reach, |bounds, shift| {
        order.for_each_stretch(bounds, rule, shift, |slots| {
            if listed == Listed::Full {
                push(slots.start..slots.end.min(targets.start), shift);
            }
            push(slots.start.max(targets.end)..slots.end, shift);
        });
    });
    own
}

/// Calls `visit` with every displacement that may bring points of a periodic space within reach of a box.
#[inline]
pub(crate) fn for_each_image<const D: usize>(
    sorted: &Sorted<D>,
    bounds: &Bounds<D>,
    reach: f64,
    mut visit: impl FnMut(&Bounds<D>, &[f64; D]),
) {
    let mut shift = [0.0; D];
    if !sorted.domain.is_periodic() {
        return visit(bounds, &shift);
    }
    let (periods, reach) = (sorted.domain.periods(), sorted.domain.reach(reach));
    let choices: [[bool; 3]; D] = core::array::from_fn(|axis| match periods[axis] {
        None => [true, false, false],
        Some(period) => {
            [true, bounds.low[axis] - reach[axis] <= 0.0, bounds.high[axis] + reach[axis] >= period]
        }
    });
    let mut choice = [0; D];
    loop {
        if (0..D).all(|axis| choices[axis][choice[axis]]) {
            for axis in 0..D {
                let period = periods[axis].unwrap_or(0.0);
                shift[axis] = [0.0, -period, period][choice[axis]];
            }
            visit(bounds, &shift);
        }
        let mut axis = 0;
        while axis < D && choice[axis] == 2 {
            choice[axis] = 0;
            axis += 1;
        }
        if axis == D {
            return;
        }
        choice[axis] += 1;
    }
}
