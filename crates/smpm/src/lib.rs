#![doc = include_str!("../README.md")]

mod binning;
mod body;
mod boundary;
mod config;
mod contact;
mod error;
mod grid;
pub mod material;
mod number;
mod observation;
mod parallel;
mod record;
mod shape;
mod simulation;
mod snapshot;
pub mod tensor;
mod transfer;
pub mod uncertainty;

pub use body::{Body, BulkViscosity, Fill};
pub use boundary::{Boundary, BoundaryKind, Side};
pub use config::{Config, Contact, Geometry, Transfer, UpdateOrder};
pub use error::{Error, Fault};
pub use number::Number;
pub use observation::{Gauge, Place, Plan, Quantity, Window};
pub use record::{Record, Schedule};
pub use shape::Shape;
pub use simulation::{Ledger, Simulation, StepReport};
pub use snapshot::Stored;
