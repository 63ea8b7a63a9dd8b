//! What is claimed of `particle-store`: columns stay together, and a snapshot comes back bit for bit.

use particle_store::{Lattice, ParticleStore, morton_order};
use result_figures::ErrorKind;
use sde_integrators::{Noise, Purpose, Stream};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "particle-store/order",
    title: "Columns in one order under permutation and removal; snapshots bit for bit; lattices",
    source: "by definition",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

const N: usize = 20_000;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    let mut random = Noise::new(12).stream(Purpose::Field, 0);
    let mut store = filled(&mut random)?;
    for round in 0..5 {
        store.permute(&shuffled(store.len(), &mut random))?;
        let keep: Vec<bool> = (0..store.len()).map(|_| random.next_uniform() < 0.9).collect();
        store.retain(&keep)?;
        context.progress(&format!("round {round}"));
    }
    let subject = context.subject(
        "columns/together",
        "values that left their particle",
        "",
        "20,000 particles, five shuffles and removals of a tenth",
    );
    claims.push(Claim::same_bits(
        subject,
        strays(&store)?,
        3 * store.len(),
        "each value names its particle's id",
    ));

    let mut bytes = Vec::new();
    store.snapshot(&mut bytes)?;
    let restored = ParticleStore::<3>::restore(bytes.as_slice())?;
    let mut again = Vec::new();
    restored.snapshot(&mut again)?;
    let different = bytes.iter().zip(&again).filter(|(a, b)| a != b).count()
        + bytes.len().abs_diff(again.len());
    let subject = context.subject(
        "snapshot/round-trip",
        "bytes that differ",
        "",
        "snapshot, restore, snapshot again",
    );
    claims.push(Claim::same_bits(subject, different, bytes.len(), "a snapshot holds everything"));

    claims.push(flipped(context, &bytes));
    claims.push(morton(context, &mut random)?);
    claims.push(ball(context)?);
    Ok(claims)
}

/// A snapshot in which one bit is wrong is refused, wherever the bit is.
fn flipped(context: &Context<'_>, bytes: &[u8]) -> Claim {
    let mut refused = 0_u32;
    let tried = 200;
    for k in 0..tried {
        let mut spoilt = bytes.to_vec();
        let at = k * (spoilt.len() - 1) / (tried - 1);
        spoilt[at] ^= 1 << (k % 8);
        refused += u32::from(ParticleStore::<3>::restore(spoilt.as_slice()).is_err());
    }
    let subject = context.subject(
        "snapshot/one-bit-flipped",
        "snapshots refused",
        "",
        "200 places, one bit each",
    );
    let reason = "the content hash covers every byte";
    let all = tried as f64;
    Claim::within(subject, ErrorKind::Absolute, (f64::from(refused), all), 0.0, reason)
}

/// The cell of a place, of 2^21 along each axis.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 21 bits")]
fn cell_of(point: [f64; 3], side: f64) -> [u64; 3] {
    point.map(|x| ((x / side * 2_097_152.0) as u64).min(2_097_151))
}

/// Neighbours in Morton order by a comparison that builds no key: of two cells, the axis whose coordinates differ in the highest
/// bit decides, the last axis before the others (Chan 2002).
fn morton(context: &Context<'_>, random: &mut Stream) -> Result<Claim, CaseError> {
    const SIDE: f64 = 1023.0;
    // The corners fix the cells: places are whole numbers from 0 to SIDE, and cells keep their order.
    let mut points = vec![[0.0; 3], [SIDE; 3]];
    points.extend((2..N).map(|_| -> [f64; 3] {
        std::array::from_fn(|_| ((SIDE + 1.0) * random.next_uniform()).floor())
    }));
    let order = morton_order(&points)?;
    let cell = |place: u32| cell_of(points[place as usize], SIDE);
    let is_after = |a: [u64; 3], b: [u64; 3]| {
        let (mut axis, mut highest) = (2, a[2] ^ b[2]);
        for k in [1, 0] {
            let differs = a[k] ^ b[k];
            if highest < differs && highest < highest ^ differs {
                (axis, highest) = (k, differs);
            }
        }
        a[axis] > b[axis]
    };
    let wrong = order.windows(2).filter(|pair| is_after(cell(pair[0]), cell(pair[1]))).count();
    let subject = context.subject(
        "order/morton",
        "neighbours in the wrong order",
        "",
        "20,000 points on a lattice of 1,024 a side, 3-D",
    );
    Ok(Claim::same_bits(subject, wrong, order.len() - 1, "by definition"))
}

/// Every value is made from its particle's id, so that it can be recognised.
fn filled(random: &mut Stream) -> Result<ParticleStore<3>, CaseError> {
    let mut store = ParticleStore::<3>::new(N);
    let name = |id: usize| id as f64 + 0.25;
    store.add("scalar", (0..N).map(name).collect::<Vec<f64>>())?;
    store.add(
        "point",
        (0..N).map(|id| [name(id), -name(id), 2.0 * name(id)]).collect::<Vec<[f64; 3]>>(),
    )?;
    store.add("integer", (0..N).map(|id| i64::try_from(id).unwrap_or(-1)).collect::<Vec<i64>>())?;
    store.add("noise", (0..N).map(|_| random.next_uniform()).collect::<Vec<f64>>())?;
    Ok(store)
}

fn strays(store: &ParticleStore<3>) -> Result<usize, CaseError> {
    let scalar = store.get(store.handle::<f64>("scalar")?)?;
    let point = store.get(store.handle::<[f64; 3]>("point")?)?;
    let integer = store.get(store.handle::<i64>("integer")?)?;
    let mut strays = 0;
    for (k, &id) in store.ids().iter().enumerate() {
        let name = id as f64 + 0.25;
        strays += usize::from(scalar[k].to_bits() != name.to_bits());
        strays +=
            usize::from(point[k].map(f64::to_bits) != [name, -name, 2.0 * name].map(f64::to_bits));
        strays += usize::from(u64::try_from(integer[k]) != Ok(id));
    }
    Ok(strays)
}

/// A permutation by sorting random keys.
fn shuffled(n: usize, random: &mut Stream) -> Vec<u32> {
    let mut keyed: Vec<(u64, u32)> = (0_u32..).take(n).map(|k| (random.next_u64(), k)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, k)| k).collect()
}

/// The volume of a ball by the cells of its lattice.
fn ball(context: &Context<'_>) -> Result<Claim, CaseError> {
    let lattice = Lattice::<3>::ball_lattice(6.0, 0.25)?;
    let volume = lattice.len() as f64 * lattice.cell_volume();
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 216.0;
    let subject = context.subject(
        "lattice/ball-volume",
        "volume of the cells",
        "",
        "ball of 6, spacing 0.25, 3-D",
    );
    let reason = "lattice points in a ball: the error is random, of the order of the square root of the 7,000 cells that its \
                  surface cuts, over 58,000";
    Ok(Claim::within(subject, ErrorKind::Relative, (volume, exact), 5e-3, reason))
}
