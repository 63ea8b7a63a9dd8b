//! The shape functions and transfers by which elastic problems are solved.

use smpm::{Config, Shape, Transfer};

/// A shape function and a transfer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Method {
    pub(super) shape: Shape,
    pub(super) transfer: Transfer,
}

/// Every shape function with every transfer.
pub(super) const METHODS: [Method; 4] = [
    Method { shape: Shape::QuadraticBSpline, transfer: Transfer::Flip },
    Method { shape: Shape::QuadraticBSpline, transfer: Transfer::Apic },
    Method { shape: Shape::CubicBSpline, transfer: Transfer::Flip },
    Method { shape: Shape::CubicBSpline, transfer: Transfer::Apic },
];

impl Method {
    /// In ids: `quadratic-musl`, `quadratic-musl-apic`.
    pub(super) fn name(self) -> String {
        let shape = match self.shape {
            Shape::QuadraticBSpline => "quadratic",
            Shape::CubicBSpline => "cubic",
        };
        let transfer = if self.transfer == Transfer::Apic { "-apic" } else { "" };
        format!("{shape}-musl{transfer}")
    }

    /// The default configuration with this shape function and transfer.
    pub(super) fn config<const D: usize>(self, cell: f64) -> Config<D> {
        let Self { shape, transfer } = self;
        Config { shape, transfer, ..Config::with_cell(cell) }
    }
}
