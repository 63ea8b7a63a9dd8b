//! Searches compiled with this crate, once for all programs.
//!
//! This covers all of a search in one to six dimensions except the pair visitors.

use std::any::Any;

use crate::cells::Cells;
use crate::error::Error;
use crate::leaves::Leaves;
use crate::list::{MAX_DIMENSION, NeighbourList};
use crate::near::{Near, nearest};
use crate::radii::Radii;
use crate::row::Row;
use crate::rows::Rows;
use crate::sorted::{self, Listed};

/// The searches in one dimension.
pub(crate) struct Searches<const D: usize> {
    pub(crate) cells: Search<Cells<D>, D>,
    pub(crate) leaves: Search<Leaves<D>, D>,
}

/// A search on one point order.
pub(crate) struct Search<O, const D: usize> {
    pub(crate) list: List<O, D>,
    pub(crate) visit: Visit<O, D>,
    pub(crate) build: Build<O, D>,
    pub(crate) nearest: fn(&O, &[f64; D], usize, &mut Vec<Near<D>>),
}

/// Sorts points and lists their rows.
type List<O, const D: usize> = fn(
    (&mut O, &mut Rows<D>),
    &[[f64; D]],
    Radii<'_>,
    Listed,
    &mut NeighbourList,
) -> Result<(), Error>;

/// Sorts points and calls a visitor with their rows.
type Visit<O, const D: usize> = fn(
    (&mut O, &mut Rows<D>),
    &[[f64; D]],
    Radii<'_>,
    &mut dyn FnMut(Row<'_, D>),
) -> Result<(), Error>;

/// Sorts points for queries about positions.
type Build<O, const D: usize> = fn(&mut O, &[[f64; D]], f64) -> Result<(), Error>;

impl<const D: usize> Searches<D> {
    const HERE: Self = Self { cells: Search::HERE, leaves: Search::HERE };
}

impl<O: sorted::Near<D>, const D: usize> Search<O, D> {
    const HERE: Self = Self {
        list: |(order, rows), points, radii, listed, list| {
            order.sort(points, radii)?;
            rows.list(order, points, radii, listed, list)
        },
        visit: |(order, rows), points, radii, visit| {
            order.sort(points, radii)?;
            rows.visit(order, points, radii, visit)
        },
        build: O::build,
        nearest,
    };
}

/// The searches as their own type.
#[inline(never)]
fn with_this_crate(dimension: usize) -> &'static (dyn Any + Send + Sync) {
    match dimension {
        1 => const { &Searches::<1>::HERE },
        2 => const { &Searches::<2>::HERE },
        3 => const { &Searches::<3>::HERE },
        4 => const { &Searches::<4>::HERE },
        5 => const { &Searches::<5>::HERE },
        6 => const { &Searches::<6>::HERE },
        _ => &(),
    }
}

/// The searches in one dimension.
pub(crate) fn searches<const D: usize>() -> &'static Searches<D> {
    const { assert!(D >= 1 && D <= MAX_DIMENSION, "points have one to six coordinates") };
    match with_this_crate(D).downcast_ref() {
        Some(searches) => searches,
        None => unreachable!("the searches in one to six dimensions are compiled"),
    }
}
