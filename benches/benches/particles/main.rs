//! Operations of a particle store, compared with a minimal implementation and with specialised crates.
//!
//! The store holds the data of a particle solver: positions, velocities, three numbers. "Bare columns" are vectors,
//! gathered, appended, split and merged in loops without names, checks or rules; their bytes are written and read
//! without a hash. All contenders are checked for the same results.

#![expect(clippy::unwrap_used, reason = "a rejected store is an error of the benchmark")]

mod bare;
mod vtk;

use std::hint::black_box;

use benches::CpuTime;
use benches::ratios::{Ratios, Work};
use criterion::Criterion;
use morton_encoding::morton_encode;
use particle_store::{Child, ParticleStore, Rule, Rules, morton_order};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform};

use crate::bare::Columns;

const N_PARTICLES: u32 = 20_000;
const N: usize = N_PARTICLES as usize;
const N_POINTS: usize = 100_000;

/// Number of split particles, and of merged groups.
const N_ADAPTED: usize = 1000;
const CHILDREN: [Child<2>; 4] = [
    Child { offset: [0.1, 0.1], share: 0.25 },
    Child { offset: [-0.1, 0.1], share: 0.25 },
    Child { offset: [0.1, -0.1], share: 0.25 },
    Child { offset: [-0.1, -0.1], share: 0.25 },
];
const RULES: [(&str, Rule); 3] =
    [("velocity", Rule::Mean), ("density", Rule::Mean), ("smoothing_length", Rule::First)];

fn permute(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let mut columns = Columns::new();
    let mut store = columns.store();
    let mut next = columns.clone();
    // 7919 and 20000 have no common factor: consecutive particles are far apart.
    let order: Vec<u32> = (0..N_PARTICLES).map(|k| k * 7919 % N_PARTICLES).collect();
    store.permute(&order).unwrap();
    columns.permute(&order, &mut next);
    columns.assert_in(&store);

    let work = Work::new("particles/permute 20k", N, "ParticleStore", || {
        store.permute(black_box(&order)).unwrap();
    });
    let bare = || columns.permute(black_box(&order), &mut next);
    ratios.measure(work.rival("bare columns", bare).in_criterion(criterion));
}

fn snapshot(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let columns = Columns::new();
    let store = columns.store();
    let [mut bytes, mut bare, mut packed] = [(); 3].map(|()| Vec::new());
    let mut ours = || {
        bytes.clear();
        store.snapshot(&mut bytes).unwrap();
        ParticleStore::<2>::restore(black_box(&bytes[..])).unwrap()
    };
    let mut bare = || {
        bare.clear();
        columns.save(&mut bare);
        Columns::load(black_box(&bare))
    };
    let mut postcard = || {
        packed.clear();
        packed = postcard::to_extend(&columns, std::mem::take(&mut packed)).unwrap();
        postcard::from_bytes::<Columns>(black_box(&packed)).unwrap()
    };
    assert_eq!(ours().content_hash(), store.content_hash());
    assert_eq!(bare(), columns);
    assert_eq!(postcard(), columns);

    ratios.measure(
        Work::new("particles/snapshot and restore 20k", N, "ParticleStore", || drop(ours()))
            .rival("bytes of bare columns", || drop(bare()))
            .rival("postcard", || drop(postcard()))
            .in_criterion(criterion),
    );
}

fn vtu(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let columns = Columns::new();
    let store = columns.store();
    let position = store.handle("position").unwrap();
    let [mut ours, mut its] = [(); 2].map(|()| Vec::new());
    store.write_vtu(position, &mut ours).unwrap();
    vtk::write(&columns, &mut its);
    vtk::assert_same(&ours, &its);

    let work = Work::new("particles/vtu 20k", N, "ParticleStore, raw", || {
        ours.clear();
        store.write_vtu(position, black_box(&mut ours)).unwrap();
    });
    let vtkio = || {
        its.clear();
        vtk::write(black_box(&columns), black_box(&mut its));
    };
    ratios.measure(work.rival("vtkio, base64", vtkio).in_criterion(criterion));
}

/// Independent points in the unit square.
fn random_points() -> Vec<[f64; 2]> {
    let mut generator = ChaCha8Rng::seed_from_u64(20);
    (0..N_POINTS).map(|_| [(); 2].map(|()| StandardUniform.sample(&mut generator))).collect()
}

/// Keys as in `morton_order`, interleaved by a crate, each with the index of its point.
fn morton_keys(points: &[[f64; 2]]) -> Vec<(u64, u32)> {
    let (mut lower, mut upper) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for x in points {
        for axis in 0..2 {
            lower[axis] = lower[axis].min(x[axis]);
            upper[axis] = upper[axis].max(x[axis]);
        }
    }
    let width = (upper[0] - lower[0]).max(upper[1] - lower[1]);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the fraction goes; the upper end is in the last cell"
    )]
    let cell = |x: f64, axis: usize| ((x - lower[axis]) / width * 4294967296.0) as u32;
    let keys = points.iter().map(|&[x, y]| morton_encode([cell(y, 1), cell(x, 0)]));
    keys.zip(0..).collect()
}

fn places(keyed: &[(u64, u32)]) -> Vec<u32> {
    keyed.iter().map(|&(_, place)| place).collect()
}

fn morton(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let points = random_points();
    let ours = || morton_order(black_box(&points)).unwrap();
    let sorted = || {
        let mut keyed = morton_keys(black_box(&points));
        keyed.sort_unstable();
        places(&keyed)
    };
    let by_radix = || {
        let mut keyed = morton_keys(black_box(&points));
        radsort::sort_by_key(&mut keyed, |&(key, _)| key);
        places(&keyed)
    };
    assert_eq!(sorted(), ours());
    assert_eq!(by_radix(), ours());
    ratios.measure(
        Work::new("particles/Morton order 100k", N_POINTS, "morton_order", || drop(ours()))
            .rival("morton-encoding, sort", || drop(sorted()))
            .rival("morton-encoding, radsort", || drop(by_radix()))
            .in_criterion(criterion),
    );
}

/// Appending, splitting and merging change the store, so each run begins with a copy, for both contenders.
fn adapt(criterion: &mut Criterion<CpuTime>, ratios: &mut Ratios) {
    let columns = Columns::new();
    let store = columns.store();
    let rules = Rules {
        mass: store.handle("mass").unwrap(),
        position: store.handle("position").unwrap(),
        others: &RULES,
    };
    let groups: Vec<[usize; 4]> =
        (0..N_ADAPTED).map(|k| [0, 1, 2, 3].map(|member| 16 * k + 5 * member)).collect();

    let ours = || {
        let mut copy = black_box(&store).clone();
        copy.append(&store).unwrap();
        copy
    };
    let bare = || {
        let mut copy = black_box(&columns).clone();
        copy.append(&columns);
        copy
    };
    bare().assert_in(&ours());
    let work = Work::new("particles/copy, append 20k", N, "ParticleStore", || drop(ours()));
    ratios.measure(work.rival("bare columns", || drop(bare())).in_criterion(criterion));

    let ours = || {
        let mut copy = black_box(&store).clone();
        for k in 0..N_ADAPTED {
            copy.split(7 * k, &CHILDREN, &rules).unwrap();
        }
        copy
    };
    let bare = || {
        let mut copy = black_box(&columns).clone();
        (0..N_ADAPTED).for_each(|k| copy.split(7 * k, &CHILDREN));
        copy
    };
    bare().assert_in(&ours());
    let name = "particles/copy, split 1000 of 20k in four";
    let work = Work::new(name, N_ADAPTED, "ParticleStore", || drop(ours()));
    ratios.measure(work.rival("bare columns", || drop(bare())).in_criterion(criterion));

    let ours = || {
        let mut copy = black_box(&store).clone();
        copy.merge(&groups, &rules).unwrap();
        copy
    };
    let bare = || {
        let mut copy = black_box(&columns).clone();
        copy.merge(&groups);
        copy
    };
    bare().assert_in(&ours());
    let name = "particles/copy, merge 1000 times four of 20k";
    let work = Work::new(name, N_ADAPTED, "ParticleStore", || drop(ours()));
    ratios.measure(work.rival("bare columns", || drop(bare())).in_criterion(criterion));
}

fn main() {
    let mut ratios = Ratios::from_args("particles");
    let mut criterion = benches::criterion();
    permute(&mut criterion, &mut ratios);
    snapshot(&mut criterion, &mut ratios);
    vtu(&mut criterion, &mut ratios);
    morton(&mut criterion, &mut ratios);
    adapt(&mut criterion, &mut ratios);
    criterion.final_summary();
    ratios.print();
}
