#![doc = include_str!("../README.md")]

mod config;
mod error;
mod grid;
mod number;
mod parallel;
mod points;
mod record;
mod simulation;
mod transfer;
pub mod uncertainty;

pub use config::{BulkViscosity, Config, Contact, Geometry, Transfer};
pub use constitutive_models as material;
pub use constitutive_models::{Error as ParameterError, Fault, tensor};
pub use error::Error;
pub use grid::boundary::{Boundary, BoundaryKind, Side};
pub use perturbation_moments::{Jet, Scalar};
pub use points::body::Body;
pub use points::compiled_points::Number;
pub use points::fill::Fill;
pub use points::surface_load::SurfaceLoad;
pub use record::balance::Balance;
pub use record::external::External;
pub use record::gathered::{Record, Schedule};
pub use record::observation::{Gauge, Place, Plan, Quantity, Window};
pub use record::tearing::Neighbours;
pub use simulation::{Ledger, Simulation, StepReport};
pub use transfer::shape::Shape;
