//! After any sequence of operations a store equals a list of structs; rejected operations change nothing.

use particle_store::{Attribute, Child, Error, ParticleStore, Rule, Rules, SymmetricTensor};
use proptest::prelude::*;

/// A complete particle. Numbers are compared by their bits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Particle {
    id: u64,
    mass: f64,
    position: [f64; 2],
    velocity: [f64; 2],
    volume: f64,
    stress: [f64; 6],
    size: f64,
    cell: [i32; 2],
    flag: i64,
    phase: u8,
    body: u32,
}

/// Reference model of a store.
#[derive(Debug, Clone, Default)]
struct Model {
    particles: Vec<Particle>,
    next_id: u64,
    generation: u64,
}

const OTHERS: [(&str, Rule); 8] = [
    ("velocity", Rule::Mean),
    ("volume", Rule::Sum),
    ("stress", Rule::Mean),
    ("size", Rule::First),
    ("cell", Rule::First),
    ("flag", Rule::First),
    ("phase", Rule::First),
    ("body", Rule::First),
];

/// An endless sequence of numbers, by the multiplier of L'Ecuyer 1999 for 2^64.
struct Keys(u64);

impl Keys {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(2_862_933_555_777_941_757).wrapping_add(3_037_000_493);
        self.0 >> 20
    }

    fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next()).unwrap() % n.max(1)
    }

    fn real(&mut self) -> f64 {
        self.below(1000) as f64 / 8.0
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

fn particle(keys: &mut Keys) -> Particle {
    let mut real = || keys.real();
    let (mass, volume, size) = (1.0 + real(), real(), real());
    let (position, velocity) = ([real(), -real()], [real(), real()]);
    let stress = [real(), 1.0, 2.0, real(), 3.0, real()];
    let [phase, low, ..] = keys.next().to_le_bytes();
    let cell = [i32::from(low), -i32::from(phase)];
    let (flag, body) = (i64::from(low) - 7, u32::from(phase) * 3);
    Particle { id: 0, mass, position, velocity, volume, stress, size, cell, flag, phase, body }
}

fn particles(keys: &mut Keys, n: usize) -> Vec<Particle> {
    (0_u64..).take(n).map(|id| Particle { id, ..particle(keys) }).collect()
}

fn store_of(particles: &[Particle]) -> ParticleStore<2> {
    let mut store = ParticleStore::new(particles.len());
    let all = || particles.iter();
    store.add("mass", all().map(|p| p.mass).collect()).unwrap();
    store.add("position", all().map(|p| p.position).collect()).unwrap();
    store.add("velocity", all().map(|p| p.velocity).collect()).unwrap();
    store.add("volume", all().map(|p| p.volume).collect()).unwrap();
    store.add("stress", all().map(|p| SymmetricTensor(p.stress)).collect()).unwrap();
    store.add("size", all().map(|p| p.size).collect()).unwrap();
    store.add("cell", all().map(|p| p.cell).collect()).unwrap();
    store.add("flag", all().map(|p| p.flag).collect()).unwrap();
    store.add("phase", all().map(|p| p.phase).collect()).unwrap();
    store.add("body", all().map(|p| p.body).collect()).unwrap();
    store.set_attribute("time", Attribute::Real(0.25));
    store
}

fn column<T: particle_store::Element<2>>(store: &ParticleStore<2>, name: &str) -> Vec<T> {
    store.get::<T>(store.handle(name).unwrap()).unwrap().to_vec()
}

fn particles_of(store: &ParticleStore<2>) -> Vec<Particle> {
    let (mass, position) = (column(store, "mass"), column(store, "position"));
    let (velocity, volume) = (column(store, "velocity"), column(store, "volume"));
    let (stress, size) = (column::<SymmetricTensor>(store, "stress"), column(store, "size"));
    let (cell, flag) = (column(store, "cell"), column(store, "flag"));
    let (phase, body) = (column(store, "phase"), column(store, "body"));
    let at = |k: usize| Particle {
        id: store.ids()[k],
        mass: mass[k],
        position: position[k],
        velocity: velocity[k],
        volume: volume[k],
        stress: stress[k].0,
        size: size[k],
        cell: cell[k],
        flag: flag[k],
        phase: phase[k],
        body: body[k],
    };
    (0..store.len()).map(at).collect()
}

fn rules(store: &ParticleStore<2>) -> Rules<'static, 2> {
    Rules {
        mass: store.handle("mass").unwrap(),
        position: store.handle("position").unwrap(),
        others: &OTHERS,
    }
}

fn permute(store: &mut ParticleStore<2>, model: &mut Model, keys: &mut Keys) {
    let n = model.particles.len();
    let mut order: Vec<u32> = (0..).take(n).collect();
    for k in (1..n).rev() {
        order.swap(k, keys.below(k + 1));
    }
    if keys.one_in(4) {
        // One entry wrong, or one too many.
        match order.first().copied() {
            Some(first) if n > 1 && keys.one_in(2) => order[n - 1] = first,
            _ => order.push(0),
        }
        let refused = store.permute(&order);
        let expected =
            matches!(refused, Err(Error::NotAPermutation { .. } | Error::LengthMismatch { .. }));
        assert!(expected, "{refused:?}");
        return;
    }
    store.permute(&order).unwrap();
    let moved = order.iter().enumerate().any(|(k, &old)| k != old as usize);
    model.generation += u64::from(moved);
    model.particles = order.iter().map(|&old| model.particles[old as usize]).collect();
}

fn retain(store: &mut ParticleStore<2>, model: &mut Model, keys: &mut Keys) {
    let mut keep: Vec<bool> = model.particles.iter().map(|_| !keys.one_in(4)).collect();
    if keys.one_in(6) {
        keep.push(true);
        assert!(matches!(store.retain(&keep), Err(Error::LengthMismatch { .. })));
        return;
    }
    let removed = store.retain(&keep).unwrap();
    let before = model.particles.len();
    let mut kept = keep.iter();
    model.particles.retain(|_| *kept.next().unwrap());
    assert_eq!(removed, before - model.particles.len());
    model.generation += u64::from(removed > 0);
}

fn append(store: &mut ParticleStore<2>, model: &mut Model, keys: &mut Keys) {
    let n = keys.below(4);
    let more = particles(keys, n);
    if keys.one_in(6) {
        let mut wrong = store_of(&more);
        wrong.add("extra", vec![0_u8; more.len()]).unwrap();
        assert!(matches!(store.append(&wrong), Err(Error::UnknownColumn { .. })));
        return;
    }
    let ids = store.append(&store_of(&more)).unwrap();
    assert_eq!(ids, model.next_id..model.next_id + more.len() as u64);
    model.particles.extend(ids.zip(&more).map(|(id, p)| Particle { id, ..*p }));
    model.next_id += more.len() as u64;
    model.generation += u64::from(!more.is_empty());
}

fn split(store: &mut ParticleStore<2>, model: &mut Model, keys: &mut Keys) {
    let place = keys.below(model.particles.len() + 1);
    let n = keys.below(5);
    let share = if keys.one_in(5) { 0.3 } else { 1.0 / n.max(1) as f64 };
    let children: Vec<Child<2>> =
        (0..n).map(|_| Child { offset: [keys.real(), -keys.real()], share }).collect();
    let outcome = store.split(place, &children, &rules(store));
    let Some(parent) = model.particles.get(place).copied() else {
        assert!(matches!(outcome, Err(Error::NoSuchPlace { .. })), "{outcome:?}");
        return;
    };
    if (share * n as f64 - 1.0).abs() > 1e-9 {
        assert!(matches!(outcome, Err(Error::InvalidShares { .. })), "{outcome:?}");
        return;
    }
    let ids = outcome.unwrap();
    assert_eq!(ids, model.next_id..model.next_id + n as u64);
    let family: Vec<Particle> = ids
        .zip(&children)
        .map(|(id, child)| Particle {
            id,
            mass: parent.mass * share,
            volume: parent.volume * share,
            position: [parent.position[0] + child.offset[0], parent.position[1] + child.offset[1]],
            ..parent
        })
        .collect();
    model.particles[place] = family[0];
    model.particles.extend(&family[1..]);
    model.next_id += n as u64;
    model.generation += 1;
}

/// The same sums in the same order as the store's, so that results are bitwise identical.
fn merged(group: &[Particle], id: u64) -> Particle {
    let total: f64 = group.iter().map(|p| p.mass).sum();
    let mean = |of: &dyn Fn(&Particle) -> f64| {
        group.iter().map(|p| of(p) * (p.mass / total)).reduce(|a, b| a + b).unwrap()
    };
    let sum = |of: &dyn Fn(&Particle) -> f64| group.iter().map(of).reduce(|a, b| a + b).unwrap();
    Particle {
        id,
        mass: sum(&|p| p.mass),
        volume: sum(&|p| p.volume),
        position: [0, 1].map(|axis: usize| mean(&|p| p.position[axis])),
        velocity: [0, 1].map(|axis: usize| mean(&|p| p.velocity[axis])),
        stress: [0, 1, 2, 3, 4, 5].map(|k: usize| mean(&|p| p.stress[k])),
        ..group[0]
    }
}

fn merge(store: &mut ParticleStore<2>, model: &mut Model, keys: &mut Keys) {
    // Arbitrary indices, some of them twice, some out of range.
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); keys.below(3)];
    for group in &mut groups {
        let n = keys.below(4);
        *group = (0..n).map(|_| keys.below(model.particles.len() + 1)).collect();
    }
    let mut places: Vec<usize> = groups.concat();
    places.sort_unstable();
    let is_twice = places.windows(2).any(|pair| pair[0] == pair[1]);
    let is_beyond = places.last().is_some_and(|&last| last >= model.particles.len());
    let is_small = groups.iter().any(|group| group.len() < 2);
    let outcome = store.merge(&groups, &rules(store));
    if is_twice || is_beyond || is_small {
        let is_named = match outcome {
            Err(Error::NamedTwice { .. }) => is_twice,
            Err(Error::NoSuchPlace { .. }) => is_beyond,
            Err(Error::GroupTooSmall { .. }) => is_small,
            _ => false,
        };
        assert!(is_named, "{groups:?}");
        return;
    }
    let ids = outcome.unwrap();
    assert_eq!(ids, model.next_id..model.next_id + groups.len() as u64);
    let mut gone = vec![false; model.particles.len()];
    for (group, id) in groups.iter().zip(ids) {
        let members: Vec<Particle> = group.iter().map(|&place| model.particles[place]).collect();
        model.particles[group[0]] = merged(&members, id);
        for &place in &group[1..] {
            gone[place] = true;
        }
    }
    let mut gone = gone.into_iter();
    model.particles.retain(|_| !gone.next().unwrap());
    model.next_id += groups.len() as u64;
    model.generation += u64::from(!groups.is_empty());
}

fn restart(store: &mut ParticleStore<2>, keys: &mut Keys) {
    let mut bytes = Vec::new();
    store.snapshot(&mut bytes).unwrap();
    let mut spoilt = bytes.clone();
    let at = keys.below(spoilt.len());
    if keys.one_in(2) {
        spoilt.truncate(at);
    } else {
        spoilt[at] ^= 1 << keys.below(8);
    }
    let refused = ParticleStore::<2>::restore(&spoilt[..]);
    assert!(refused.is_err(), "byte {at} of {}", bytes.len());
    let hash = store.content_hash();
    *store = ParticleStore::restore(&bytes[..]).unwrap();
    assert_eq!(store.content_hash(), hash);
    assert_eq!(store.attribute("time"), Some(Attribute::Real(0.25)));
}

fn agree(store: &ParticleStore<2>, model: &Model) {
    assert_eq!(particles_of(store), model.particles);
    assert_eq!(store.generation(), model.generation);
    let mut ids = store.ids().to_vec();
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] < pair[1]), "an id twice: {ids:?}");
    assert!(ids.last().is_none_or(|&last| last < model.next_id));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100_000))]

    #[test]
    fn any_sequence_leaves_what_a_list_of_structs_would_hold(
        n in 0..12_usize, seed in any::<u64>(), steps in prop::collection::vec(0..6_u8, 1..8),
    ) {
        let mut keys = Keys(seed);
        let particles = particles(&mut keys, n);
        let mut store = store_of(&particles);
        let mut model = Model { particles, next_id: n as u64, generation: 0 };
        for step in steps {
            let made_for = store.generation();
            let places = store.ids().to_vec();
            match step {
                0 => permute(&mut store, &mut model, &mut keys),
                1 => retain(&mut store, &mut model, &mut keys),
                2 => append(&mut store, &mut model, &mut keys),
                3 => split(&mut store, &mut model, &mut keys),
                4 => merge(&mut store, &mut model, &mut keys),
                _ => restart(&mut store, &mut keys),
            }
            agree(&store, &model);
            // An older list is rejected if and only if an index refers to another particle.
            match store.check_generation(made_for) {
                Ok(()) => prop_assert_eq!(store.ids(), places),
                Err(Error::StaleGeneration { made_for: was, generation }) => {
                    prop_assert_eq!((was, generation), (made_for, store.generation()));
                    prop_assert_ne!(store.ids(), places);
                }
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }
}
