#![doc = include_str!("../README.md")]

mod axis;
mod canvas;
mod cheapest;
mod colours;
mod data;
mod drawing;
mod error;
mod error_kind;
mod field;
pub mod finite;
mod legend;
pub mod markdown;
mod measured;
pub mod number;
mod path_map;
mod placement;
mod plane;
pub mod samples;
mod time_series;
mod work_precision;

pub use self::cheapest::{Candidate, Choice, Verdict, choices, choices_table, settled};
pub use self::data::{
    Band, Field, Line, Measure, Method, PathMap, PathQuantile, Plane, Reading, ReferencePoint,
    ReferencePoints, Region, Run, RunOutcome, Scale, TimeSeries, Words, WorkPrecision,
};
pub use self::drawing::{Drawing, DrawingError, Face};
pub use self::error::ChartError;
pub use self::error_kind::{ErrorKind, Spread};
pub use self::field::field;
pub use self::measured::{Measured, Reference};
pub use self::path_map::path_map;
pub use self::plane::plane;
pub use self::time_series::time_series;
pub use self::work_precision::work_precision;
