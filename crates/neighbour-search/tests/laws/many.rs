//! A hundred thousand small clouds: whatever the numbers, no panic and no missed pair.

use neighbour_search::{
    BruteForce, CellGrid, Criterion, Domain, LeafTree, NeighbourList, NeighbourSearch, Radii,
};
use proptest::prelude::*;

/// What one case is about, from its random numbers.
#[derive(Debug, Clone)]
struct Question {
    /// Numbers in [0, 1), rounded to a few values where they are to tie.
    points: Vec<[f64; 6]>,
    radii: Vec<f64>,
    /// 0 for one radius, else the criterion.
    criterion: usize,
    /// Bit `k` for a periodic axis.
    periodic: usize,
    /// Period in units of two largest radii.
    period: f64,
    half: bool,
    tree: bool,
}

fn questions() -> impl Strategy<Value = Question> {
    // Whole numbers of sevenths tie with each other and with radii; a few coordinates are far away.
    let coordinate = prop_oneof![
        4 => 0.0..1.0_f64,
        4 => (0..8_i32).prop_map(|k| f64::from(k) / 7.0),
        1 => (-20..20_i32).prop_map(|k| 3.0_f64.powi(k)),
    ];
    let points = prop::collection::vec(prop::array::uniform6(coordinate), 0..40);
    let radius = prop_oneof![0.01..1.0_f64, (1..8_i32).prop_map(|k| f64::from(k) / 7.0)];
    let rest = (0..5_usize, 0..64_usize, 1.0..4.0_f64, any::<[bool; 3]>());
    (points, prop::collection::vec(radius, 40), rest).prop_map(
        |(points, radii, (criterion, periodic, period, [half, tree, is_tight]))| Question {
            points,
            radii,
            criterion,
            periodic,
            period: if is_tight { 1.0 } else { period },
            half,
            tree,
        },
    )
}

/// Puts the question to brute force and to one search; returns the number of pairs.
fn agree<const D: usize>(question: &Question) -> usize {
    let points: Vec<[f64; D]> =
        question.points.iter().map(|x| std::array::from_fn(|axis| x[axis])).collect();
    let own = &question.radii[..points.len()];
    let radii = match question.criterion {
        0 => Radii::Uniform(question.radii[0]),
        k => Radii::PerPoint { radii: own, criterion: Criterion::ALL[k - 1] },
    };
    let largest = question.radii.iter().copied().fold(0.0, f64::max);
    let domain = Domain::periodic(std::array::from_fn(|axis| {
        (question.periodic >> axis & 1 == 1).then_some(2.0 * largest * question.period)
    }))
    .unwrap();
    let mut search: Box<dyn NeighbourSearch<D>> = if question.tree {
        Box::new(LeafTree::in_domain(domain))
    } else {
        Box::new(CellGrid::in_domain(domain))
    };
    let mut oracle = BruteForce::in_domain(domain);
    let (mut found, mut expected) = (NeighbourList::new(), NeighbourList::new());
    if question.half && !matches!(question.criterion, 1 | 2) {
        search.half_list(&points, radii, &mut found).unwrap();
        oracle.half_list(&points, radii, &mut expected).unwrap();
        let pairs = |list: &NeighbourList| {
            let rows = (0_u32..).zip(list.rows());
            let mut pairs: Vec<_> =
                rows.flat_map(|(i, row)| row.iter().map(move |&j| [i.min(j), i.max(j)])).collect();
            pairs.sort_unstable();
            pairs
        };
        assert_eq!(pairs(&found), pairs(&expected));
    } else {
        search.full_list(&points, radii, &mut found).unwrap();
        oracle.full_list(&points, radii, &mut expected).unwrap();
        found.sort_rows();
        assert_eq!(found, expected);
    }
    found.n_pairs()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn no_pair_is_missed_and_none_invented(question in questions(), dimension in 1..=6_usize) {
        let n_pairs = match dimension {
            1 => agree::<1>(&question),
            2 => agree::<2>(&question),
            3 => agree::<3>(&question),
            4 => agree::<4>(&question),
            5 => agree::<5>(&question),
            _ => agree::<6>(&question),
        };
        // Of forty points in a row, with radii of a part of its length, some are near each other.
        let is_crowded = dimension == 1 && question.criterion == 0 && question.points.len() > 30;
        prop_assert!(!is_crowded || question.radii[0] < 0.2 || n_pairs > 0);
    }
}
