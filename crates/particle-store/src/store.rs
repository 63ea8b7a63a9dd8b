//! Particles as named columns in one order.

use std::collections::BTreeMap;

use crate::column::{Element, Handle, Scratch, Values, permute, retain};
use crate::error::Error;
use crate::kind::Kind;

/// A named value of the whole store: time, step count, seed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Attribute {
    /// A real number, stored bitwise.
    Real(f64),
    /// A count or a bit pattern.
    Count(u64),
}

#[derive(Debug, Clone)]
pub(crate) struct Column<const D: usize> {
    pub(crate) name: String,
    pub(crate) values: Values<D>,
}

/// Named columns of particle data in `D` dimensions: a structure of arrays in one order.
///
/// Every particle has an id, initially 0 to n - 1, which it keeps at any index and which is never reused. Reordering,
/// removal, appending, splitting and merging move all columns together. They change the
/// [`generation`](Self::generation), which identifies stale neighbour lists.
#[derive(Debug, Clone)]
pub struct ParticleStore<const D: usize> {
    pub(crate) ids: Vec<u64>,
    pub(crate) columns: Vec<Column<D>>,
    pub(crate) attributes: BTreeMap<String, Attribute>,
    pub(crate) generation: u64,
    pub(crate) next_id: u64,
    id_scratch: Vec<u64>,
    named: Vec<bool>,
    scratch: Scratch<D>,
}

impl<const D: usize> ParticleStore<D> {
    /// Particles without columns, with ids 0 to `n_particles - 1`.
    #[must_use]
    pub fn new(n_particles: usize) -> Self {
        Self::of_ids((0..n_particles as u64).collect(), n_particles as u64, 0)
    }

    pub(crate) fn of_ids(ids: Vec<u64>, next_id: u64, generation: u64) -> Self {
        const { assert!(D >= 1, "particles need at least one dimension") };
        Self {
            ids,
            columns: Vec::new(),
            attributes: BTreeMap::new(),
            generation,
            next_id,
            id_scratch: Vec::new(),
            named: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are no particles.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Id of the particle at each index.
    #[must_use]
    pub fn ids(&self) -> &[u64] {
        &self.ids
    }

    /// Current index of a particle, by linear search.
    #[must_use]
    pub fn index_of(&self, id: u64) -> Option<usize> {
        self.ids.iter().position(|&other| other == id)
    }

    /// Changes whenever an index may refer to another particle than before, and never otherwise.
    ///
    /// Store it with data derived from indices, such as a neighbour list, and call
    /// [`check_generation`](Self::check_generation) before using them.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Rejects data derived from indices that may refer to other particles by now.
    ///
    /// The counter belongs to one store and its history. A clone or a restored store begins a history of its own and
    /// may reach the same number with another order: recompute derived data after a restore.
    ///
    /// # Errors
    ///
    /// [`Error::StaleGeneration`] unless `made_for` is the current [`generation`](Self::generation).
    ///
    /// ```
    /// use particle_store::{Error, ParticleStore};
    ///
    /// let mut store = ParticleStore::<2>::new(3);
    /// let made_for = store.generation();
    /// store.check_generation(made_for)?;
    /// store.permute(&[2, 0, 1])?;
    /// let refused = store.check_generation(made_for);
    /// assert!(matches!(refused, Err(Error::StaleGeneration { made_for: 0, generation: 1 })));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn check_generation(&self, made_for: u64) -> Result<(), Error> {
        let generation = self.generation;
        if made_for == generation {
            Ok(())
        } else {
            Err(Error::StaleGeneration { made_for, generation })
        }
    }

    /// Adds a column of any [`Element`] type, with one value for each particle in the current order.
    ///
    /// # Errors
    ///
    /// [`Error::DuplicateName`] and [`Error::LengthMismatch`].
    pub fn add<T: Element<D>>(&mut self, name: &str, values: Vec<T>) -> Result<Handle<T>, Error> {
        if self.position(name).is_some() {
            return Err(Error::DuplicateName { name: name.to_owned() });
        }
        self.check_length(name, values.len())?;
        self.columns.push(Column { name: name.to_owned(), values: T::wrap(values) });
        Ok(handle(self.columns.len() - 1))
    }

    /// Handle of a column by its name.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownColumn`], and [`Error::KindMismatch`] if its type is not `T`.
    pub fn handle<T: Element<D>>(&self, name: &str) -> Result<Handle<T>, Error> {
        let index =
            self.position(name).ok_or_else(|| Error::UnknownColumn { name: name.to_owned() })?;
        self.get(handle(index)).map(|_: &[T]| handle(index))
    }

    /// Values of a column in the current order.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownHandle`] or [`Error::KindMismatch`] for a handle of another store.
    pub fn get<T: Element<D>>(&self, handle: Handle<T>) -> Result<&[T], Error> {
        let column = self.columns.get(handle.index).ok_or_else(|| self.unknown(handle.index))?;
        T::of(&column.values).ok_or_else(|| kind_mismatch(column, T::KIND))
    }

    /// Values of a column, mutable.
    ///
    /// # Errors
    ///
    /// Those of [`get`](Self::get).
    pub fn get_mut<T: Element<D>>(&mut self, handle: Handle<T>) -> Result<&mut [T], Error> {
        let unknown = self.unknown(handle.index);
        typed_mut(self.columns.get_mut(handle.index).ok_or(unknown)?)
    }

    /// Values of two columns, both mutable.
    ///
    /// # Errors
    ///
    /// Those of [`get`](Self::get); [`Error::SameColumn`] for equal handles.
    pub fn get_pair_mut<A: Element<D>, B: Element<D>>(
        &mut self,
        a: Handle<A>,
        b: Handle<B>,
    ) -> Result<(&mut [A], &mut [B]), Error> {
        if a.index == b.index && a.index < self.columns.len() {
            return Err(Error::SameColumn { name: self.columns[a.index].name.clone() });
        }
        let unknown = self.unknown(a.index.max(b.index));
        let [first, second] =
            self.columns.get_disjoint_mut([a.index, b.index]).map_err(|_| unknown)?;
        Ok((typed_mut(first)?, typed_mut(second)?))
    }

    /// Names and kinds of the columns, in the order of addition.
    pub fn columns(&self) -> impl ExactSizeIterator<Item = (&str, Kind)> {
        self.columns.iter().map(|column| (column.name.as_str(), column.values.kind()))
    }

    /// Reorders the particles: index `k` gets the particle that is now at index `order[k]`.
    ///
    /// The generation changes unless the order is the current one. After the first call nothing is allocated.
    ///
    /// # Errors
    ///
    /// [`Error::LengthMismatch`] and [`Error::NotAPermutation`]; the store is then unchanged.
    pub fn permute(&mut self, order: &[u32]) -> Result<(), Error> {
        self.check_length("permutation", order.len())?;
        let n_particles = self.len();
        self.named.clear();
        self.named.resize(n_particles, false);
        for (position, &value) in order.iter().enumerate() {
            match self.named.get_mut(value as usize) {
                Some(named) if !*named => *named = true,
                _ => return Err(Error::NotAPermutation { position, value, n_particles }),
            }
        }
        if order.iter().enumerate().all(|(place, &old)| place == old as usize) {
            return Ok(());
        }
        permute(&mut self.ids, order, &mut self.id_scratch);
        for column in &mut self.columns {
            column.values.permute(order, &mut self.scratch);
        }
        self.generation = self.generation.wrapping_add(1);
        Ok(())
    }

    /// Keeps the particles whose mask entry is true, in order, and returns the number removed.
    ///
    /// The generation changes if a particle was removed.
    ///
    /// # Errors
    ///
    /// [`Error::LengthMismatch`]; the store is then unchanged.
    pub fn retain(&mut self, keep: &[bool]) -> Result<usize, Error> {
        self.check_length("mask", keep.len())?;
        let removed = keep.iter().filter(|&&keep| !keep).count();
        if removed > 0 {
            retain(&mut self.ids, keep);
            for column in &mut self.columns {
                column.values.retain(keep);
            }
            self.generation = self.generation.wrapping_add(1);
        }
        Ok(removed)
    }

    /// Sets a named value of the whole store and returns the previous value.
    pub fn set_attribute(&mut self, name: &str, value: Attribute) -> Option<Attribute> {
        self.attributes.insert(name.to_owned(), value)
    }

    /// A named value of the whole store.
    #[must_use]
    pub fn attribute(&self, name: &str) -> Option<Attribute> {
        self.attributes.get(name).copied()
    }

    /// All named values, by name.
    pub fn attributes(&self) -> impl ExactSizeIterator<Item = (&str, Attribute)> {
        self.attributes.iter().map(|(name, &value)| (name.as_str(), value))
    }

    pub(crate) fn column(&self, name: &str) -> Result<&Column<D>, Error> {
        let index = self.position(name);
        index
            .map(|index| &self.columns[index])
            .ok_or_else(|| Error::UnknownColumn { name: name.to_owned() })
    }

    fn position(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    fn check_length(&self, what: &str, length: usize) -> Result<(), Error> {
        let n_particles = self.len();
        if length == n_particles {
            return Ok(());
        }
        Err(Error::LengthMismatch { what: what.to_owned(), length, n_particles })
    }

    fn unknown(&self, index: usize) -> Error {
        Error::UnknownHandle { index, n_columns: self.columns.len() }
    }
}

fn handle<T>(index: usize) -> Handle<T> {
    Handle { index, holds: core::marker::PhantomData }
}

fn typed_mut<T: Element<D>, const D: usize>(column: &mut Column<D>) -> Result<&mut [T], Error> {
    let Column { name, values } = column;
    let found = values.kind();
    let mismatch = || Error::KindMismatch { name: name.clone(), expected: T::KIND, found };
    T::of_mut(values).ok_or_else(mismatch)
}

fn kind_mismatch<const D: usize>(column: &Column<D>, expected: Kind) -> Error {
    Error::KindMismatch { name: column.name.clone(), expected, found: column.values.kind() }
}
