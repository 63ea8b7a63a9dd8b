//! The ways to do a step that elastic problems are solved by.

use smpm::{Config, Error, Shape, Transfer, UpdateOrder};

use crate::cases::lines::Lines;
use crate::report::Claim;

/// A shape function, an update order and a transfer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Method {
    pub(super) shape: Shape,
    pub(super) order: UpdateOrder,
    pub(super) transfer: Transfer,
}

const SHAPES: [Shape; 4] =
    [Shape::Linear, Shape::Gimp, Shape::QuadraticBSpline, Shape::CubicBSpline];
/// Update orders and transfers of each shape function; APIC with the usual order.
const STEPS: [(UpdateOrder, Transfer); 4] = [
    (UpdateOrder::StressFirst, FLIP),
    (UpdateOrder::StressLast, FLIP),
    (UpdateOrder::ModifiedStressLast, FLIP),
    (UpdateOrder::ModifiedStressLast, Transfer::Apic),
];
const FLIP: Transfer = Transfer::Flip { damping_time: f64::INFINITY };

/// Every shape function with every update order, and with APIC.
pub(super) const METHODS: [Method; 16] = {
    let none = Method { shape: SHAPES[0], order: STEPS[0].0, transfer: FLIP };
    let mut all = [none; 16];
    let mut i = 0;
    while i < all.len() {
        let (order, transfer) = STEPS[i % 4];
        all[i] = Method { shape: SHAPES[i / 4], order, transfer };
        i += 1;
    }
    all
};

impl Method {
    /// In ids: `quadratic-musl`, `quadratic-musl-apic`.
    pub(super) fn name(&self) -> String {
        let shape = match self.shape {
            Shape::Linear => "linear",
            Shape::Gimp => "gimp",
            Shape::QuadraticBSpline => "quadratic",
            Shape::CubicBSpline => "cubic",
        };
        let order = match self.order {
            UpdateOrder::StressFirst => "usf",
            UpdateOrder::StressLast => "usl",
            UpdateOrder::ModifiedStressLast => "musl",
        };
        let transfer = if self.transfer == Transfer::Apic { "-apic" } else { "" };
        format!("{shape}-{order}{transfer}")
    }

    /// All else is as usual.
    pub(super) fn config<const D: usize>(&self, cell: f64) -> Config<D> {
        let Self { shape, order, transfer } = *self;
        Config { shape, update_order: order, transfer, ..Config::with_cell(cell) }
    }
}

/// A run that ended in an error, when it was seen to: hats with USL or APIC.
pub(super) fn ended(lines: &Lines<'_>, error: &Error, band: (f64, f64)) -> Claim {
    let time = match error {
        Error::Material { time, .. } | Error::EnergyGrew { time, .. } => *time,
        _ => f64::NAN,
    };
    lines.measured(
        ("ended", "time at which the run ended in an error: a volume turned over, or energy grew", ""),
        time,
        band,
        "a particle that has just left a cell gives its new node a force but hardly any mass, and hats show it all of that node's velocity: not for USL or APIC",
    )
}
