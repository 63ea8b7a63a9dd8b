#![doc = include_str!("../README.md")]

mod binning;
mod blocks;
mod body;
mod boundary;
mod config;
mod constitution;
mod contact;
mod error;
mod giving;
mod grid;
pub mod material;
mod number;
mod observation;
mod parallel;
mod particles;
mod record;
mod shape;
mod simulation;
mod snapshot;
mod taking;
pub mod tensor;
mod tiles;
mod transfer;
pub mod uncertainty;

pub use body::{Body, Fill};
pub use boundary::{Boundary, BoundaryKind, Side};
pub use config::{BulkViscosity, Config, Contact, Geometry, Transfer, UpdateOrder};
pub use error::{Error, Fault};
pub use number::Number;
pub use observation::{Gauge, Place, Plan, Quantity, Window};
pub use record::{Record, Schedule};
pub use shape::Shape;
pub use simulation::{Ledger, Simulation, StepReport};
pub use snapshot::Stored;
