//! What is claimed of `neighbour-search`: the pairs of brute force, no more and no fewer.

use neighbour_search::{
    BruteForce, CellGrid, Criterion, Domain, LeafTree, NeighbourList, NeighbourSearch, Radii,
};
use sde_integrators::{Noise, Purpose, Stream};

use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "neighbour-search/exactness",
    title: "Cell grid and leaf tree against brute force: every pair, in every dimension, periodic or not, on clouds that break searches",
    source: "by definition: pairs within a radius in f64, the particle itself excluded",
    cost: Profile::Quick,
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

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = Vec::new();
    // Radii that give tens of neighbours to a uniform cloud of 1,500 points.
    dimension::<1>(context, 0.02, &mut claims)?;
    dimension::<2>(context, 0.08, &mut claims)?;
    dimension::<3>(context, 0.2, &mut claims)?;
    dimension::<4>(context, 0.3, &mut claims)?;
    if context.profile > Profile::Quick {
        dimension::<5>(context, 0.4, &mut claims)?;
        dimension::<6>(context, 0.5, &mut claims)?;
    }
    Ok(claims)
}

/// One claim per dimension, search, space and cloud: full and half lists, visits by rows, a uniform radius and every
/// criterion of radii that vary 70-fold.
fn dimension<const D: usize>(
    context: &Context<'_>,
    radius: f64,
    claims: &mut Vec<Claim>,
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
                let id = format!("{search_name}/{name}{space}/{D}d");
                claims.push(claim(context, &id, points.len(), different, compared));
            }
        }
    }
    Ok(())
}

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

fn claim(
    context: &Context<'_>,
    id: &str,
    n_points: usize,
    different: usize,
    compared: usize,
) -> Claim {
    let setup =
        format!("{id}, {n_points} points; one radius and four criteria, full, half and by rows");
    let subject = context.subject(id, "pairs that differ", "", &setup);
    if n_points < 2 {
        // No pair can be compared: what is claimed is that none is found.
        let none = figures::Measured::exact(different as f64);
        let reason = "a cloud of fewer than two points has no pair";
        Claim::as_measured(subject, none, 0.0, 0.0, reason)
    } else {
        let reason = "the same comparison of squared distances in both, so ties fall alike";
        Claim::same_bits(subject, different, compared, reason)
    }
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

/// Entries that stand in one list and not in the other, row by row.
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
