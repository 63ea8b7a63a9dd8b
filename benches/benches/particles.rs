//! Particles put in another order, and saved to memory and restored.
//!
//! The store holds what a particle solver does: positions, velocities, three numbers. The rivals do the least that the
//! work can be: gather the bare columns by index without checking the order, and write and read their bytes without
//! names, checks or hash.

#![expect(clippy::unwrap_used, reason = "a store that is refused is a mistake of the benchmark")]

use std::hint::black_box;

use benches::CpuTime;
use criterion::{Criterion, Throughput};
use particle_store::ParticleStore;

const N_PARTICLES: u32 = 20_000;
const N_SCALARS: usize = 3;

/// The columns themselves, with the ids.
#[derive(Debug, Clone, PartialEq)]
struct Columns {
    ids: Vec<u64>,
    vectors: [Vec<[f64; 2]>; 2],
    scalars: [Vec<f64>; N_SCALARS],
}

impl Columns {
    fn new() -> Self {
        let numbers = |offset: f64| (0..N_PARTICLES).map(move |k| offset + f64::from(k));
        Self {
            ids: (0..u64::from(N_PARTICLES)).collect(),
            vectors: [0.25, 0.5].map(|offset| numbers(offset).map(|x| [x, -x]).collect()),
            scalars: [1.0, 2.0, 3.0].map(|offset| numbers(offset).collect()),
        }
    }

    fn store(&self) -> ParticleStore<2> {
        let mut store = ParticleStore::new(self.ids.len());
        for (name, values) in ["position", "velocity"].into_iter().zip(&self.vectors) {
            store.add(name, values.clone()).unwrap();
        }
        for (name, values) in ["mass", "density", "smoothing_length"].into_iter().zip(&self.scalars)
        {
            store.add(name, values.clone()).unwrap();
        }
        store
    }

    /// Gathers into `next`, then takes its place.
    fn permute(&mut self, order: &[u32], next: &mut Self) {
        gather(&self.ids, order, &mut next.ids);
        for (from, to) in self.vectors.iter().zip(&mut next.vectors) {
            gather(from, order, to);
        }
        for (from, to) in self.scalars.iter().zip(&mut next.scalars) {
            gather(from, order, to);
        }
        std::mem::swap(self, next);
    }

    fn save(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        for vectors in &self.vectors {
            bytes.extend(vectors.iter().flatten().flat_map(|value| value.to_le_bytes()));
        }
        for scalars in &self.scalars {
            bytes.extend(scalars.iter().flat_map(|value| value.to_le_bytes()));
        }
    }

    fn load(bytes: &[u8]) -> Self {
        let (words, rest) = bytes.as_chunks::<8>();
        assert!(rest.is_empty());
        let n = N_PARTICLES as usize;
        let mut columns = words.chunks_exact(n);
        let mut numbers = |columns_each: usize| -> Vec<f64> {
            let words = columns.by_ref().take(columns_each).flatten();
            words.map(|word| f64::from_le_bytes(*word)).collect()
        };
        let ids = numbers(1).iter().map(|id| id.to_bits()).collect();
        let vectors = [(); 2].map(|()| numbers(2).as_chunks::<2>().0.to_vec());
        Self { ids, vectors, scalars: [(); N_SCALARS].map(|()| numbers(1)) }
    }
}

fn gather<T: Copy>(from: &[T], order: &[u32], to: &mut Vec<T>) {
    to.clear();
    to.extend(order.iter().map(|&k| from[k as usize]));
}

fn permute(criterion: &mut Criterion<CpuTime>) {
    let mut columns = Columns::new();
    let mut store = columns.store();
    let mut next = columns.clone();
    // 7919 and 20000 have no common factor: a far jump from each particle to the next.
    let order: Vec<u32> = (0..N_PARTICLES).map(|k| k * 7919 % N_PARTICLES).collect();

    let mut group = criterion.benchmark_group("particles/permute 20000");
    group.throughput(Throughput::Elements(u64::from(N_PARTICLES)));
    group.bench_function("ParticleStore", |b| b.iter(|| store.permute(black_box(&order))));
    group.bench_function("bare columns (rival)", |b| {
        b.iter(|| columns.permute(black_box(&order), &mut next));
    });
    group.finish();
}

fn snapshot(criterion: &mut Criterion<CpuTime>) {
    let columns = Columns::new();
    let store = columns.store();
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    let size = bytes.len();
    assert_eq!(
        ParticleStore::<2>::restore(&bytes[..]).unwrap().content_hash(),
        store.content_hash()
    );
    bytes.clear();
    columns.save(&mut bytes);
    assert_eq!(Columns::load(&bytes), columns);

    let mut group = criterion.benchmark_group("particles/snapshot and restore 20000");
    group.throughput(Throughput::Bytes(size as u64));
    group.bench_function("ParticleStore", |b| {
        b.iter(|| {
            bytes.clear();
            store.snapshot(&mut bytes).unwrap();
            ParticleStore::<2>::restore(black_box(&bytes[..])).unwrap()
        });
    });
    group.bench_function("bytes of columns (rival)", |b| {
        b.iter(|| {
            bytes.clear();
            columns.save(&mut bytes);
            Columns::load(black_box(&bytes))
        });
    });
    group.finish();
}

fn main() {
    let mut criterion = benches::criterion();
    permute(&mut criterion);
    snapshot(&mut criterion);
    criterion.final_summary();
}
