//! Properties of lattices.

use particle_store::{Error, Lattice};
use proptest::prelude::*;

#[test]
fn box_lattice_includes_its_ends_and_runs_along_the_first_axis() {
    let lattice = Lattice::box_lattice([1.0, 0.5], [3, 2]).unwrap();
    let expected = [[-1.0, -0.5], [0.0, -0.5], [1.0, -0.5], [-1.0, 0.5], [0.0, 0.5], [1.0, 0.5]];
    assert_eq!(lattice.points, expected);
    assert_eq!(lattice.indices, [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]);
    // 2/(3-1) by 1/(2-1).
    assert!((lattice.cell_volume() - 1.0).abs() < f64::EPSILON);
}

#[test]
fn single_point_is_the_centre_of_its_width() {
    let lattice = Lattice::box_lattice([0.4, 2.0, 1.0], [1, 1, 1]).unwrap();
    assert_eq!(lattice.points, [[0.0; 3]]);
    assert!((lattice.cell_volume() - 0.8 * 4.0 * 2.0).abs() < 1e-14);
}

#[test]
fn ball_lattice_holds_as_many_points_as_lattice_sums_say() {
    // Points of Z^D with norm^2 <= R^2: OEIS A000328 (D = 2, R = 5), A000605 (D = 3, R = 2: 1+6+12+8+6), and for D = 4,
    // R^2 = 4 the sums of r_4(k): 1 + 8 + 24 + 32 + 24.
    assert_eq!(Lattice::<1>::ball_lattice(7.0, 1.0).unwrap().len(), 15);
    assert_eq!(Lattice::<2>::ball_lattice(5.0, 1.0).unwrap().len(), 81);
    assert_eq!(Lattice::<3>::ball_lattice(2.0, 1.0).unwrap().len(), 33);
    assert_eq!(Lattice::<4>::ball_lattice(2.0, 1.0).unwrap().len(), 89);
    // 1 + 12 + 4 * 15 for D = 6, R^2 = 2.
    assert_eq!(Lattice::<6>::ball_lattice(1.5, 1.0).unwrap().len(), 73);
}

#[test]
fn points_on_the_surface_are_in_the_ball_whatever_the_rounding() {
    // 0.3 / 0.1 is below 3 in double precision; N(3) = 29 points in the plane (OEIS A000328).
    assert_eq!(Lattice::<2>::ball_lattice(0.3, 0.1).unwrap().len(), 29);
    assert_eq!(Lattice::<2>::ball_lattice(0.299, 0.1).unwrap().len(), 25);
}

#[test]
fn neighbours_along_axes_are_one_step_away_or_absent() {
    let lattice = Lattice::box_lattice([1.0, 1.0], [3, 3]).unwrap();
    let neighbours = lattice.axis_neighbours();
    assert_eq!(neighbours[4], [[Some(3), Some(5)], [Some(1), Some(7)]]);
    assert_eq!(neighbours[0], [[None, Some(1)], [None, Some(3)]]);
    let ball = Lattice::<2>::ball_lattice(1.0, 1.0).unwrap();
    assert_eq!(ball.indices, [[0, -1], [-1, 0], [0, 0], [1, 0], [0, 1]]);
    assert_eq!(ball.axis_neighbours()[2], [[Some(1), Some(3)], [Some(0), Some(4)]]);
    assert_eq!(ball.axis_neighbours()[3], [[Some(2), None], [None, None]]);
}

#[test]
fn what_is_no_lattice_is_refused() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let half_width = Lattice::box_lattice([1.0, value], [2, 2]);
        assert!(matches!(half_width, Err(Error::InvalidLength { axis: 1, .. })));
        assert!(matches!(
            Lattice::<2>::ball_lattice(value, 1.0),
            Err(Error::InvalidLength { what: "radius", .. })
        ));
        assert!(matches!(
            Lattice::<2>::ball_lattice(1.0, value),
            Err(Error::InvalidLength { what: "spacing", .. })
        ));
    }
    let zero = Lattice::box_lattice([1.0, 1.0], [2, 0]);
    assert!(matches!(zero, Err(Error::ZeroCount { axis: 1 })));
    for count in [[70_000, 70_000], [usize::MAX, 2], [1, 1 << 32]] {
        let absurd = Lattice::box_lattice([1.0, 1.0], count);
        assert!(matches!(absurd, Err(Error::TooManyPoints)));
    }
    for spacing in [1e-300, 1e-9, 1e-5] {
        let absurd = Lattice::<3>::ball_lattice(1.0, spacing);
        assert!(matches!(absurd, Err(Error::TooManyPoints)), "{spacing}");
    }
}

proptest! {
    #[test]
    fn lattice_neighbours_are_mutual_and_one_spacing_apart(radius in 0.5..3.0_f64, spacing in 0.3..1.0_f64) {
        let ball = Lattice::<3>::ball_lattice(radius, spacing).unwrap();
        let mut n_links = 0;
        let all = ball.axis_neighbours();
        for (id, (neighbours, x)) in all.iter().zip(&ball.points).enumerate() {
            for (axis, [below, above]) in neighbours.iter().enumerate() {
                prop_assert!(below.is_none_or(|below| below < u32::try_from(id).unwrap()));
                let Some(above) = *above else { continue };
                n_links += 1;
                let there = all[above as usize][axis][0];
                prop_assert_eq!(there, u32::try_from(id).ok());
                let step = ball.points[above as usize][axis] - x[axis];
                // Two roundings of coordinates below the radius.
                prop_assert!((step - spacing).abs() <= f64::EPSILON * radius);
            }
        }
        prop_assert!(n_links > 0 || radius < spacing);
    }

    #[test]
    fn ball_lattice_is_the_part_of_the_box_lattice_within_the_radius(steps in 1..8_u8, part in 0.0..0.9_f64) {
        // A radius between integer multiples of the spacing, so that no point is on the surface within rounding.
        let radius = (f64::from(steps).powi(2) + part + 0.05).sqrt();
        let ball = Lattice::<3>::ball_lattice(radius, 1.0).unwrap();
        let half_width = f64::from(steps);
        let cube = Lattice::box_lattice([half_width; 3], [2 * usize::from(steps) + 1; 3]).unwrap();
        let inside = |x: &&[f64; 3]| x.iter().map(|value| value * value).sum::<f64>() <= radius * radius;
        let expected: Vec<[f64; 3]> = cube.points.iter().filter(inside).copied().collect();
        prop_assert_eq!(ball.points, expected);
    }

    #[test]
    fn box_lattice_is_centred_and_fills_its_box(
        half_width in prop::array::uniform3(0.1..10.0_f64),
        count in prop::array::uniform3(2..9_usize),
    ) {
        let lattice = Lattice::box_lattice(half_width, count).unwrap();
        prop_assert_eq!(lattice.len(), count.iter().product::<usize>());
        let (first, last) = (lattice.points[0], lattice.points[lattice.len() - 1]);
        prop_assert_eq!(first.map(f64::to_bits), half_width.map(|half_width| (-half_width).to_bits()));
        prop_assert_eq!(last.map(f64::to_bits), half_width.map(f64::to_bits));
        for (x, mirrored) in lattice.points.iter().zip(lattice.points.iter().rev()) {
            prop_assert!(x.iter().zip(mirrored).all(|(value, mirrored)| (value + mirrored).abs() == 0.0));
        }
        let volume: f64 = (0..3).map(|axis| 2.0 * half_width[axis] / (count[axis] - 1) as f64).product();
        // Nine roundings.
        prop_assert!((lattice.cell_volume() / volume - 1.0).abs() < 1e-14);
    }
}
