//! Columns, what they hold, and the handles they are reached by.

use core::marker::PhantomData;

use crate::bytes::Bytes;

/// What a column holds, one value for each particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// `f64`
    Scalar,
    /// `[f64; D]`
    Point,
    /// `i64`
    Integer,
    /// `[i32; D]`
    Index,
}

/// A type that a column of a store in `D` dimensions can hold: `f64`, `[f64; D]`, `i64` or `[i32; D]`.
///
/// Sealed: a snapshot knows these kinds and no others.
pub trait Element<const D: usize>: sealed::Stored<D> {
    /// The kind of a column of these.
    const KIND: Kind;
}

/// A typed reference to a column: by name once, by handle in every step.
///
/// It stays valid while the store lives, through reordering, removal of particles and further columns. It belongs to the
/// store that gave it; another store, a restored one included, is asked by name again.
#[derive(Debug)]
pub struct Handle<T> {
    pub(crate) index: usize,
    pub(crate) holds: PhantomData<fn() -> T>,
}

impl<T> Clone for Handle<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Handle<T> {}

impl<T> PartialEq for Handle<T> {
    fn eq(&self, other: &Self) -> bool {
        self.index == other.index
    }
}

impl<T> Eq for Handle<T> {}

/// The values of a column.
#[derive(Debug, Clone)]
pub enum Values<const D: usize> {
    Scalar(Vec<f64>),
    Point(Vec<[f64; D]>),
    Integer(Vec<i64>),
    Index(Vec<[i32; D]>),
}

impl<const D: usize> Values<D> {
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::Scalar(_) => Kind::Scalar,
            Self::Point(_) => Kind::Point,
            Self::Integer(_) => Kind::Integer,
            Self::Index(_) => Kind::Index,
        }
    }
}

/// One buffer of each kind, exchanged with a column when that is put in another order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scratch<const D: usize> {
    scalars: Vec<f64>,
    points: Vec<[f64; D]>,
    integers: Vec<i64>,
    indices: Vec<[i32; D]>,
}

impl<const D: usize> Values<D> {
    /// Entry `k` becomes what entry `order[k]` was.
    pub(crate) fn permute(&mut self, order: &[u32], scratch: &mut Scratch<D>) {
        match self {
            Self::Scalar(values) => permute(values, order, &mut scratch.scalars),
            Self::Point(values) => permute(values, order, &mut scratch.points),
            Self::Integer(values) => permute(values, order, &mut scratch.integers),
            Self::Index(values) => permute(values, order, &mut scratch.indices),
        }
    }

    pub(crate) fn retain(&mut self, keep: &[bool]) {
        match self {
            Self::Scalar(values) => retain(values, keep),
            Self::Point(values) => retain(values, keep),
            Self::Integer(values) => retain(values, keep),
            Self::Index(values) => retain(values, keep),
        }
    }
}

pub(crate) fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32], scratch: &mut Vec<T>) {
    scratch.clear();
    scratch.extend(order.iter().map(|&old| values[old as usize]));
    core::mem::swap(values, scratch);
}

pub(crate) fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    values.retain(|_| kept.next().copied().unwrap_or(true));
}

pub(crate) mod sealed {
    use super::{Bytes, Values};

    pub trait Stored<const D: usize>: Bytes {
        fn wrap(values: Vec<Self>) -> Values<D>;
        fn of(values: &Values<D>) -> Option<&[Self]>;
        fn of_mut(values: &mut Values<D>) -> Option<&mut [Self]>;
    }
}

macro_rules! elements {
    ($($element:ty => $kind:ident),*) => {$(
        impl<const D: usize> Element<D> for $element {
            const KIND: Kind = Kind::$kind;
        }

        impl<const D: usize> sealed::Stored<D> for $element {
            fn wrap(values: Vec<Self>) -> Values<D> {
                Values::$kind(values)
            }
            fn of(values: &Values<D>) -> Option<&[Self]> {
                if let Values::$kind(values) = values { Some(values) } else { None }
            }
            fn of_mut(values: &mut Values<D>) -> Option<&mut [Self]> {
                if let Values::$kind(values) = values { Some(values) } else { None }
            }
        }
    )*};
}
elements!(f64 => Scalar, [f64; D] => Point, i64 => Integer, [i32; D] => Index);
