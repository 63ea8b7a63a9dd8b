#![doc = include_str!("../README.md")]

mod answer;
mod bytes;
mod chart;
mod error;
mod lighter;
mod motion;
mod page;
mod render;
mod table;

pub use self::answer::{Answer, Note, below};
pub use self::chart::{Chart, Point, Series};
pub use self::error::PageError;
pub use self::motion::{Cells, Frame, Layer, Motion, Place, Points, Scale};
pub use self::page::{Fact, Page, SceneKey, Source};
pub use self::render::{SORT, STYLE, THEME, render};
pub use self::table::{Cell, Table};
