//! Columns, their contents, and their handles.

use core::marker::PhantomData;

use crate::bytes::Bytes;
use crate::kind::Kind;
use crate::tensor::SymmetricTensor;

/// An element type of a column in `D` dimensions.
///
/// The types are `f64`, `[f64; D]`, [`SymmetricTensor`], `i64`, `[i32; D]`, `u8` and `u32`.
///
/// The trait is sealed, because a snapshot supports only these kinds.
pub trait Element<const D: usize>: sealed::Stored<D> {
    /// Kind of a column with this element type.
    const KIND: Kind;
}

/// A typed reference to a column: obtained by name once, used in every step.
///
/// It stays valid while the store lives, through reordering, removal of particles and new columns. It belongs to its
/// store; other stores, including restored ones, require a new lookup by name.
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
    Tensor(Vec<SymmetricTensor>),
    Flag(Vec<u8>),
    Label(Vec<u32>),
}

/// Applies the same expression to values of every kind.
macro_rules! of_any_kind {
    ($values:expr, $vector:ident => $body:expr) => {
        match $values {
            $crate::column::Values::Scalar($vector) => $body,
            $crate::column::Values::Point($vector) => $body,
            $crate::column::Values::Integer($vector) => $body,
            $crate::column::Values::Index($vector) => $body,
            $crate::column::Values::Tensor($vector) => $body,
            $crate::column::Values::Flag($vector) => $body,
            $crate::column::Values::Label($vector) => $body,
        }
    };
}
pub(crate) use of_any_kind;

impl<const D: usize> Values<D> {
    pub(crate) fn kind(&self) -> Kind {
        fn kind<T: Element<D>, const D: usize>(_: &[T]) -> Kind {
            T::KIND
        }
        of_any_kind!(self, values => kind::<_, D>(values))
    }
}

/// One buffer of each kind, swapped with a column when it is reordered.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scratch<const D: usize> {
    scalars: Vec<f64>,
    points: Vec<[f64; D]>,
    integers: Vec<i64>,
    indices: Vec<[i32; D]>,
    tensors: Vec<SymmetricTensor>,
    flags: Vec<u8>,
    labels: Vec<u32>,
}

impl<const D: usize> Values<D> {
    /// Entry `k` becomes the former entry `order[k]`.
    pub(crate) fn permute(&mut self, order: &[u32], scratch: &mut Scratch<D>) {
        match self {
            Self::Scalar(values) => permute(values, order, &mut scratch.scalars),
            Self::Point(values) => permute(values, order, &mut scratch.points),
            Self::Integer(values) => permute(values, order, &mut scratch.integers),
            Self::Index(values) => permute(values, order, &mut scratch.indices),
            Self::Tensor(values) => permute(values, order, &mut scratch.tensors),
            Self::Flag(values) => permute(values, order, &mut scratch.flags),
            Self::Label(values) => permute(values, order, &mut scratch.labels),
        }
    }

    pub(crate) fn retain(&mut self, keep: &[bool]) {
        of_any_kind!(self, values => retain(values, keep));
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
elements!(
    f64 => Scalar, [f64; D] => Point, i64 => Integer, [i32; D] => Index,
    SymmetricTensor => Tensor, u8 => Flag, u32 => Label
);
