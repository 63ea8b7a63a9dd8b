#![doc = include_str!("../README.md")]

mod coordinate;
mod error;
mod job;
mod message;
#[cfg(feature = "mpi")]
mod mpi_world;
mod ranks;
mod report;
mod run;
mod store;
mod threads;
mod work;

pub use error::{JobError, TransportError};
pub use job::{Finished, Job};
#[cfg(feature = "mpi")]
pub use mpi_world::World;
pub use ranks::Ranks;
pub use report::{BlockReport, Report};
pub use store::{InMemory, Store};
pub use threads::{Alone, ThreadRank};
