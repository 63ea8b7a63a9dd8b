//! Snapshots: the state and its lattice, written and read bitwise.

use std::io::{Read, Write};

use particle_store::{Attribute, ParticleStore};

use crate::cloud::lattice::{ParticleLattice, index_of_place};
use crate::error::Error;
use crate::solver::Solver;
use crate::time::state::{Previous, State};

impl<const D: usize> Solver<D> {
    /// Writes state and lattice.
    pub(crate) fn snapshot(&self, writer: &mut dyn Write) -> Result<(), Error> {
        self.store()?.snapshot(writer)?;
        Ok(())
    }

    /// State and lattice as columns and attributes.
    pub(crate) fn store(&self) -> Result<ParticleStore<D>, Error> {
        let mut store = ParticleStore::<D>::new(self.n_particles());
        let state = &self.state;
        store.add("position", state.positions.clone())?;
        store.add("place", self.discretisation.lattice.places.clone())?;
        store.add("mass", state.masses.clone())?;
        store.add("smoothing_length", state.smoothing_lengths.clone())?;
        store.add("smoothing_ratio", state.smoothing_ratios.clone())?;
        store.set_attribute("time", Attribute::Real(state.time));
        store.set_attribute("n_steps", Attribute::Count(state.n_steps));
        let memory = self.discretisation.combination.scheme.remembers();
        if let (Some(name), Some(Previous { values, dt })) = (memory, &state.previous) {
            store.add(name, values.clone())?;
            store.set_attribute("previous_dt", Attribute::Real(*dt));
        }
        for (name, value) in self.balance.errors.named() {
            store.set_attribute(&name, Attribute::Real(*value));
        }
        store.set_attribute("n_remaps", Attribute::Count(state.n_remaps));
        store.set_attribute("n_start", Attribute::Count(self.n_start as u64));
        Ok(store)
    }

    /// Takes state and lattice from a snapshot; after an error all is as it was.
    pub(crate) fn restore(&mut self, reader: &mut dyn Read) -> Result<(), Error> {
        self.take(&ParticleStore::<D>::restore(reader)?)
    }

    /// Takes state and lattice from columns and attributes; after an error all is as it was.
    pub(crate) fn take(&mut self, store: &ParticleStore<D>) -> Result<(), Error> {
        let memory = self.discretisation.combination.scheme.remembers();
        let state = read_state(store, self.n_start, memory)?;
        let places = store.get(store.handle::<[f64; D]>("place")?)?;
        state.check_restored(places)?;
        let lattice = &self.discretisation.lattice;
        if places != lattice.places {
            let indices = places.iter().map(index_of_place).collect();
            self.discretisation.lay(ParticleLattice::new(indices, lattice.spacing))?;
        }
        let mut errors = self.balance.errors;
        for (name, value) in errors.named_mut() {
            *value = match store.attribute(&name) {
                Some(Attribute::Real(saved)) => saved,
                _ => f64::NAN,
            };
            let (quantity, particle, value) = ("error of the moments", 0, *value);
            if !value.is_finite() {
                return Err(Error::SnapshotNumber { quantity, particle, value, must: "finite" });
            }
        }
        self.state = state;
        self.balance.errors = errors;
        self.resize_buffers();
        Ok(())
    }
}

/// The state in a store, for a simulation that started with `n_start` particles and whose scheme remembers what has the name
/// `memory`.
fn read_state<const D: usize>(
    store: &ParticleStore<D>,
    n_start: usize,
    memory: Option<&str>,
) -> Result<State<D>, Error> {
    let count = |name: &str| match store.attribute(name) {
        Some(Attribute::Count(count)) => Ok(count),
        _ => Err(Error::SnapshotWithoutTime),
    };
    let Some(Attribute::Real(time)) = store.attribute("time") else {
        return Err(Error::SnapshotWithoutTime);
    };
    let (n_steps, n_remaps) = (count("n_steps")?, count("n_remaps")?);
    // The same start; as many particles as at the start, without remeshing.
    let found = if n_remaps == 0 { store.len() as u64 } else { count("n_start")? };
    if store.is_empty() {
        return Err(Error::ForeignSnapshot { found: 0, expected: n_start });
    }
    if found != n_start as u64 {
        let found = usize::try_from(found).unwrap_or(usize::MAX);
        return Err(Error::ForeignSnapshot { found, expected: n_start });
    }
    // What another scheme remembers is of no use to this one.
    let column = memory.and_then(|name| store.handle::<[f64; D]>(name).ok());
    let previous = match (column, store.attribute("previous_dt")) {
        (Some(column), Some(Attribute::Real(dt))) => {
            Some(Previous { values: store.get(column)?.to_vec(), dt })
        }
        _ => None,
    };
    Ok(State {
        time,
        n_steps,
        n_remaps,
        positions: points(store, "position")?,
        masses: scalars(store, "mass")?,
        smoothing_lengths: scalars(store, "smoothing_length")?,
        smoothing_ratios: scalars(store, "smoothing_ratio")?,
        previous,
    })
}

fn scalars<const D: usize>(store: &ParticleStore<D>, name: &str) -> Result<Vec<f64>, Error> {
    Ok(store.get(store.handle(name)?)?.to_vec())
}

fn points<const D: usize>(store: &ParticleStore<D>, name: &str) -> Result<Vec<[f64; D]>, Error> {
    Ok(store.get(store.handle(name)?)?.to_vec())
}
