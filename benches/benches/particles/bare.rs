//! Bare columns: the work of a particle store in vectors and loops.

use particle_store::{Child, ParticleStore};
use serde::{Deserialize, Serialize};

use crate::{N, N_PARTICLES};

const VECTORS: [&str; 2] = ["position", "velocity"];
const SCALARS: [&str; 3] = ["mass", "density", "smoothing_length"];

/// The columns with the ids.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Columns {
    pub(crate) ids: Vec<u64>,
    next_id: u64,
    /// Position, velocity.
    pub(crate) vectors: [Vec<[f64; 2]>; 2],
    /// Mass, density, smoothing length.
    pub(crate) scalars: [Vec<f64>; 3],
}

impl Columns {
    pub(crate) fn new() -> Self {
        let numbers = |offset: f64| (0..N_PARTICLES).map(move |k| offset + f64::from(k));
        Self {
            ids: (0..u64::from(N_PARTICLES)).collect(),
            next_id: u64::from(N_PARTICLES),
            vectors: [0.25, 0.5].map(|offset| numbers(offset).map(|x| [x, -x]).collect()),
            scalars: [1.0, 2.0, 3.0].map(|offset| numbers(offset).collect()),
        }
    }

    pub(crate) fn store(&self) -> ParticleStore<2> {
        let mut store = ParticleStore::new(self.ids.len());
        for (name, values) in VECTORS.into_iter().zip(&self.vectors) {
            store.add(name, values.clone()).unwrap();
        }
        for (name, values) in SCALARS.into_iter().zip(&self.scalars) {
            store.add(name, values.clone()).unwrap();
        }
        store
    }

    /// Gathers into `next` and swaps it in.
    pub(crate) fn permute(&mut self, order: &[u32], next: &mut Self) {
        gather(&self.ids, order, &mut next.ids);
        for (from, to) in self.vectors.iter().zip(&mut next.vectors) {
            gather(from, order, to);
        }
        for (from, to) in self.scalars.iter().zip(&mut next.scalars) {
            gather(from, order, to);
        }
        std::mem::swap(self, next);
    }

    pub(crate) fn save(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        for vectors in &self.vectors {
            bytes.extend(vectors.iter().flatten().flat_map(|value| value.to_le_bytes()));
        }
        for scalars in &self.scalars {
            bytes.extend(scalars.iter().flat_map(|value| value.to_le_bytes()));
        }
    }

    pub(crate) fn load(bytes: &[u8]) -> Self {
        let (words, rest) = bytes.as_chunks::<8>();
        assert!(rest.is_empty());
        let mut columns = words.chunks_exact(N);
        let mut numbers = |columns_each: usize| -> Vec<f64> {
            let words = columns.by_ref().take(columns_each).flatten();
            words.map(|word| f64::from_le_bytes(*word)).collect()
        };
        let ids = numbers(1).iter().map(|id| id.to_bits()).collect();
        let vectors = [(); 2].map(|()| numbers(2).as_chunks::<2>().0.to_vec());
        let scalars = [(); 3].map(|()| numbers(1));
        Self { ids, next_id: u64::from(N_PARTICLES), vectors, scalars }
    }

    pub(crate) fn append(&mut self, other: &Self) {
        for (values, more) in self.vectors.iter_mut().zip(&other.vectors) {
            values.extend_from_slice(more);
        }
        for (values, more) in self.scalars.iter_mut().zip(&other.scalars) {
            values.extend_from_slice(more);
        }
        self.ids.extend(self.next_id..self.next_id + other.ids.len() as u64);
        self.next_id += other.ids.len() as u64;
    }

    pub(crate) fn split(&mut self, place: usize, children: &[Child<2>]) {
        let [positions, velocities] = &mut self.vectors;
        let [masses, densities, lengths] = &mut self.scalars;
        let ([x, y], mass) = (positions[place], masses[place]);
        for (k, &Child { offset, share }) in children.iter().enumerate() {
            let ([x, y], mass) = ([x + offset[0], y + offset[1]], share * mass);
            if k == 0 {
                (positions[place], masses[place], self.ids[place]) = ([x, y], mass, self.next_id);
            } else {
                positions.push([x, y]);
                velocities.push(velocities[place]);
                masses.push(mass);
                densities.push(densities[place]);
                lengths.push(lengths[place]);
                self.ids.push(self.next_id);
            }
            self.next_id += 1;
        }
    }

    pub(crate) fn merge(&mut self, groups: &[[usize; 4]]) {
        let mut keep = vec![true; self.ids.len()];
        for group in groups {
            let weights = group.map(|place| self.scalars[0][place]);
            let mass: f64 = weights.iter().sum();
            let (mut vectors, mut density) = ([[0.0; 2]; 2], 0.0);
            for (&place, weight) in group.iter().zip(weights) {
                let share = weight / mass;
                for (sum, values) in vectors.iter_mut().zip(&self.vectors) {
                    *sum = [0, 1].map(|axis| sum[axis] + values[place][axis] * share);
                }
                density += self.scalars[1][place] * share;
                keep[place] = false;
            }
            let first = group[0];
            keep[first] = true;
            for (values, sum) in self.vectors.iter_mut().zip(vectors) {
                values[first] = sum;
            }
            (self.scalars[0][first], self.scalars[1][first]) = (mass, density);
            self.ids[first] = self.next_id;
            self.next_id += 1;
        }
        self.vectors.iter_mut().for_each(|values| retain(values, &keep));
        self.scalars.iter_mut().for_each(|values| retain(values, &keep));
        retain(&mut self.ids, &keep);
    }

    /// Asserts that a store is bitwise identical.
    pub(crate) fn assert_in(&self, store: &ParticleStore<2>) {
        assert_eq!(store.ids(), self.ids);
        for (name, values) in VECTORS.into_iter().zip(&self.vectors) {
            assert_eq!(store.get(store.handle::<[f64; 2]>(name).unwrap()).unwrap(), values);
        }
        for (name, values) in SCALARS.into_iter().zip(&self.scalars) {
            assert_eq!(store.get(store.handle::<f64>(name).unwrap()).unwrap(), values);
        }
    }
}

fn gather<T: Copy>(from: &[T], order: &[u32], to: &mut Vec<T>) {
    to.clear();
    to.extend(order.iter().map(|&k| from[k as usize]));
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| keep.next() == Some(&true));
}
