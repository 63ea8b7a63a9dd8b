//! What is claimed of `neighbour-search`: the pairs of brute force, no more and no fewer.

use std::collections::BTreeMap;

use neighbour_search::{
    BruteForce, CellGrid, Criterion, Domain, LeafTree, NeighbourList, NeighbourSearch, Radii,
    SkinList, Update,
};
use sde_integrators::{Noise, Purpose, Stream};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "neighbour-search/exactness",
    title: "Cell grid and leaf tree against brute force: every pair, in every dimension, periodic or not, on clouds that break searches",
    source: "by definition: pairs within a radius in f64, the particle itself excluded",
    cost: Profile::Default,
    schedule: Schedule::Together,
    run,
};

/// A cloud by name, from uniform numbers in `[0, 1)`.
#[derive(Debug, Clone, Copy)]
enum Cloud {
    Uniform,
    /// Many distances equal the radius.
    Lattice,
    Clustered,
    /// All points on one line.
    Collinear,
    /// Every point four times.
    Duplicated,
    /// One point 1e9 away.
    Outlier,
    OnePoint,
    Empty,
}

const CLOUDS: [(Cloud, &str); 8] = [
    (Cloud::Uniform, "uniform"),
    (Cloud::Lattice, "lattice"),
    (Cloud::Clustered, "clustered"),
    (Cloud::Collinear, "collinear"),
    (Cloud::Duplicated, "duplicated"),
    (Cloud::Outlier, "outlier"),
    (Cloud::OnePoint, "one-point"),
    (Cloud::Empty, "empty"),
];

/// Entries that differ from brute force and entries compared, of all dimensions, by the name of the claim.
type Found = BTreeMap<String, (usize, usize)>;

/// The claim of the clouds that have no pair.
const NO_PAIR: &str = "no-pair";
const DIMENSIONS: &str = "one to 6 dimensions";

/// One claim per search, space and cloud, over all dimensions; one for the clouds without a pair.
fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut found = Found::new();
    // Radii that give tens of neighbours to a uniform cloud of 1,500 points.
    dimension::<1>(context, 0.02, &mut found)?;
    dimension::<2>(context, 0.08, &mut found)?;
    dimension::<3>(context, 0.2, &mut found)?;
    dimension::<4>(context, 0.3, &mut found)?;
    dimension::<5>(context, 0.4, &mut found)?;
    dimension::<6>(context, 0.5, &mut found)?;
    let mut claims: Vec<Claim> =
        found.iter().map(|(id, counts)| claim(context, id, *counts)).collect();
    claims.push(skin(context)?);
    Ok(claims)
}

/// A list with a skin has the pairs of brute force after every step of points that move by a fifth of the skin a step, whether it
/// is rebuilt or reused.
fn skin(context: &Context<'_>) -> Result<Claim, CaseError> {
    const N: usize = 600;
    const N_STEPS: usize = 60;
    const SKIN: f64 = 0.05;
    let radii = Radii::Uniform(0.15);
    let mut random = Noise::new(13).stream(Purpose::Field, 0);
    let mut uniform = || -> [f64; 3] { std::array::from_fn(|_| random.next_uniform()) };
    let mut points: Vec<[f64; 3]> = (0..N).map(|_| uniform()).collect();
    let steps: Vec<[f64; 3]> = (0..N)
        .map(|_| {
            let direction = uniform().map(|x| x - 0.5);
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            direction.map(|x| 0.2 * SKIN * x / length)
        })
        .collect();
    let mut list = SkinList::<3>::new(SKIN)?;
    let mut expected = NeighbourList::new();
    let (mut different, mut compared, mut reused) = (0, 0, 0);
    for _ in 0..N_STEPS {
        reused += usize::from(list.update(&points, radii)? == Update::Reused);
        BruteForce::new().full_list(&points, radii, &mut expected)?;
        let mut n_found = 0;
        list.for_each_pair(&points, |pair| {
            n_found += 1;
            let is_expected =
                u32::try_from(pair.j).is_ok_and(|j| expected.of(pair.i).binary_search(&j).is_ok());
            different += usize::from(!is_expected);
        })?;
        different += expected.n_pairs().abs_diff(n_found);
        compared += expected.n_pairs();
        for (x, step) in points.iter_mut().zip(&steps) {
            for k in 0..3 {
                x[k] += step[k];
            }
        }
    }
    if reused == 0 {
        return Err("no list was reused: the skin is not tested".into());
    }
    let method = format!(
        "{N} points, {N_STEPS} steps of a fifth of the skin, {reused} of them without a new list"
    );
    let subject = context.subject("skin-list", "pairs that differ", "", &method);
    let reason = "a list is reused only while no two points can have come closer by its skin";
    Ok(Claim::same_bits(subject, different, compared, reason))
}

/// Full and half lists, visits by rows, a uniform radius and every criterion of radii that vary 70-fold.
fn dimension<const D: usize>(
    context: &Context<'_>,
    radius: f64,
    found: &mut Found,
) -> Result<(), CaseError> {
    context.progress(&format!("{D}-D"));
    for (cloud, name) in CLOUDS {
        let mut random = Noise::new(11).stream(Purpose::Field, D as u64);
        let points = cloud.points::<D>(&mut random);
        let own: Vec<f64> =
            points.iter().map(|_| radius * 70_f64.powf(random.next_uniform() - 0.7)).collect();
        let largest = own.iter().copied().fold(radius, f64::max);
        // Every other axis is periodic, by barely two radii.
        let periods = std::array::from_fn(|axis| (axis % 2 == 0).then_some(2.0 * largest));
        let spaces = [("", Domain::unbounded()), ("/periodic", Domain::periodic(periods)?)];
        for (space, domain) in spaces {
            let searches: [(&str, Box<dyn NeighbourSearch<D>>); 2] = [
                ("cell-grid", Box::new(CellGrid::in_domain(domain))),
                ("leaf-tree", Box::new(LeafTree::in_domain(domain))),
            ];
            for (search_name, mut search) in searches {
                let (different, compared) =
                    compare(search.as_mut(), &domain, &points, &own, radius)?;
                let id = format!("{search_name}/{name}{space}");
                let has_pairs = points.len() > 1;
                let id = if has_pairs { id } else { NO_PAIR.to_owned() };
                let counts = found.entry(id).or_default();
                counts.0 += different;
                // Without a pair the lists are compared, one by one.
                counts.1 += if has_pairs { compared } else { LISTS };
            }
        }
    }
    Ok(())
}

/// How many full lists a comparison makes: one radius and four criteria.
const LISTS: usize = 5;

/// Entries that differ from brute force, and entries and points compared.
fn compare<const D: usize>(
    search: &mut dyn NeighbourSearch<D>,
    domain: &Domain<D>,
    points: &[[f64; D]],
    own: &[f64],
    radius: f64,
) -> Result<(usize, usize), CaseError> {
    let per_point = Criterion::ALL.map(|criterion| Radii::PerPoint { radii: own, criterion });
    let (mut expected, mut found) = (NeighbourList::new(), NeighbourList::new());
    let (mut different, mut compared) = (0, 0);
    for radii in [Radii::Uniform(radius)].into_iter().chain(per_point) {
        BruteForce::in_domain(*domain).full_list(points, radii, &mut expected)?;
        search.full_list(points, radii, &mut found)?;
        found.sort_rows();
        compared += expected.n_pairs() + expected.len();
        different += differences(&expected, &found);

        let mut rows = vec![Vec::new(); points.len()];
        search.for_each_row(points, radii, &mut |row| rows[row.i] = row.j.to_vec())?;
        for row in &mut rows {
            row.sort_unstable();
        }
        let same = rows.iter().map(Vec::as_slice).eq(expected.rows());
        different += usize::from(!same);

        let is_symmetric = !matches!(
            radii,
            Radii::PerPoint { criterion: Criterion::Gather | Criterion::Scatter, .. }
        );
        if is_symmetric {
            search.half_list(points, radii, &mut found)?;
            different += (2 * found.n_pairs()).abs_diff(expected.n_pairs());
            let listed =
                (0_u32..).zip(found.rows()).flat_map(|(i, row)| row.iter().map(move |&j| [i, j]));
            different +=
                listed.filter(|&[i, j]| expected.of(i as usize).binary_search(&j).is_err()).count();
        }
    }
    Ok((different, compared))
}

fn claim(context: &Context<'_>, id: &str, (different, compared): (usize, usize)) -> Claim {
    let (quantity, setup, reason) = if id == NO_PAIR {
        let setup = format!("both searches, no point and one point, periodic or not, {DIMENSIONS}");
        ("pairs found where there is none", setup, "a cloud of fewer than two points has no pair")
    } else {
        let setup = format!(
            "{id}, 1,500 points, {DIMENSIONS}; one radius and four criteria, full, half and by rows"
        );
        let reason = "the same comparison of squared distances in both, so ties fall alike";
        ("pairs that differ", setup, reason)
    };
    Claim::same_bits(context.subject(id, quantity, "", &setup), different, compared, reason)
}

impl Cloud {
    fn points<const D: usize>(self, random: &mut Stream) -> Vec<[f64; D]> {
        const N: usize = 1_500;
        let mut uniform = || -> [f64; D] { std::array::from_fn(|_| random.next_uniform()) };
        match self {
            Self::Uniform => (0..N).map(|_| uniform()).collect(),
            // Spacings of a twentieth: many distances equal the radius of 0.2, 0.3, 0.4 or 0.5.
            Self::Lattice => (0..N).map(|_| uniform().map(|x| (20.0 * x).floor() * 0.05)).collect(),
            Self::Clustered => {
                (0..N).map(|k| uniform().map(|x| (k % 3) as f64 + 0.2 * x.powi(4))).collect()
            }
            Self::Collinear => (0..N).map(|_| [uniform()[0]; D]).collect(),
            Self::Duplicated => {
                let once: Vec<[f64; D]> = (0..N / 4).map(|_| uniform()).collect();
                (0..N).map(|k| once[k / 4 % once.len()]).collect()
            }
            Self::Outlier => (0..N)
                .map(|k| uniform().map(|x| if k == 700 { 1e9 * (x + 1.0) } else { x }))
                .collect(),
            Self::OnePoint => vec![uniform()],
            Self::Empty => Vec::new(),
        }
    }
}

/// Entries of one list that the other does not have, row by row.
fn differences(expected: &NeighbourList, found: &NeighbourList) -> usize {
    if expected.len() != found.len() {
        return expected.len().max(found.len());
    }
    expected
        .rows()
        .zip(found.rows())
        .map(|(a, b)| {
            let missing = a.iter().filter(|id| b.binary_search(id).is_err()).count();
            let invented = b.iter().filter(|id| a.binary_search(id).is_err()).count();
            missing + invented
        })
        .sum()
}
