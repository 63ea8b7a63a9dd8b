//! Extension traits as a user implements them: a way to compute derivatives, and a response.

use perturbation_moments::{
    CentralDifferences, Derivatives, Error, Expansion, ForwardDifferentiation, HighestOrder, Known,
    Moments, RandomVector, Response, Scalar, Verdict,
};

/// Derivatives from a table that another program wrote: here those of `y = x1^2 x2` at (2, 3).
struct Tabulated {
    rows: Vec<(Vec<usize>, f64)>,
}

impl Derivatives<2> for Tabulated {
    fn know(&self, inputs: &RandomVector<2>) -> Result<Known<2>, Error> {
        assert_eq!(inputs.centre().map(f64::to_bits), [2.0, 3.0].map(f64::to_bits));
        let entry = |by: &[usize]| {
            self.rows.iter().find(|(key, _)| key == by).map_or(0.0, |(_, value)| *value)
        };
        Ok(Known::ByInputs(Expansion::from_derivatives(entry)))
    }
}

fn table() -> Tabulated {
    let rows = vec![
        (vec![], 12.0),
        (vec![0], 12.0),
        (vec![1], 4.0),
        (vec![0, 0], 6.0),
        (vec![0, 1], 4.0),
        (vec![0, 0, 1], 2.0),
    ];
    Tabulated { rows }
}

/// The same response as a program over any number type.
struct Program;

impl Response<2> for Program {
    #[inline]
    fn value<S: Scalar>(&self, x: &[S; 2]) -> S {
        x[0].squared() * x[1]
    }
}

fn inputs() -> RandomVector<2> {
    RandomVector::new([2.0, 3.0], [0.3, 0.2], [[1.0, -0.5], [-0.5, 1.0]]).unwrap()
}

#[test]
fn users_way_gives_the_moments_derived_by_hand() {
    // S = [[0.09, -0.03], [-0.03, 0.04]], g = (12, 4), H = [[6, 4], [4, 0]].
    let moments = Moments::by(&inputs(), &table()).unwrap();
    // tr(HS)/2 = (6 * 0.09 + 2 * 4 * -0.03)/2 = 0.15.
    assert!((moments.mean_second_order().unwrap() - 12.15).abs() < 1e-14);
    // g'Sg = 144 * 0.09 + 2 * 48 * -0.03 + 16 * 0.04 = 10.72.
    assert!((moments.variance_first_order() - 10.72).abs() < 1e-13);
    // HS = [[0.42, -0.02], [0.36, -0.12]]; tr(HSHS)/2 = (0.1764 - 0.0144 + 0.0144)/2 = 0.0882 by its squares and product.
    let curvature = (0.42_f64 * 0.42 + 2.0 * -0.02 * 0.36 + 0.12 * 0.12) / 2.0;
    let with_curvature = moments.variance_with_curvature().unwrap();
    assert!((with_curvature - 10.72 - curvature).abs() < 1e-13, "{with_curvature}");
    // T112 = 2 in its three places: (Sg)_j T_jkl S_kl with Sg = (0.96, -0.2): 0.96 (2 * 2 * -0.03) - 0.2 (2 * 0.09).
    let third = 0.96 * -0.12 - 0.2 * 0.18;
    let fourth_order = moments.variance_fourth_order().unwrap();
    assert!((fourth_order - with_curvature - third).abs() < 1e-13, "{fourth_order}");
    assert_eq!(moments.trust().unwrap().verdict(), Verdict::InPeace);
}

#[test]
fn users_response_goes_through_every_way_alike() {
    let response = Program;
    let expected = Moments::by(&inputs(), &table()).unwrap();
    let ways: [(&str, Moments<2>, f64); 3] = [
        (
            "forward, third order",
            Moments::by(
                &inputs(),
                &ForwardDifferentiation { response: &response, order: HighestOrder::Third },
            )
            .unwrap(),
            1e-14,
        ),
        (
            "forward, second order",
            Moments::by(
                &inputs(),
                &ForwardDifferentiation { response: &response, order: HighestOrder::Second },
            )
            .unwrap(),
            1e-14,
        ),
        (
            "differences",
            Moments::by(
                &inputs(),
                &CentralDifferences::new(|x: &[f64; 2]| response.value(x), HighestOrder::Third),
            )
            .unwrap(),
            1e-9,
        ),
    ];
    for (name, moments, tolerance) in ways {
        let relative = moments.variance_with_curvature().unwrap()
            / expected.variance_with_curvature().unwrap()
            - 1.0;
        assert!(relative.abs() < tolerance, "{name}: {relative:e}");
        let third = moments.third_central_moment().unwrap()
            / expected.third_central_moment().unwrap()
            - 1.0;
        assert!(third.abs() < 10.0 * tolerance, "{name}: {third:e}");
    }
}

#[test]
fn users_mistakes_are_named() {
    let transposed = |_: &[f64; 2]| Expansion {
        value: 0.0,
        gradient: [1.0, 1.0],
        hessian: Some([[0.0, 1.0], [0.0, 0.0]]),
        third: None,
    };
    let error = Moments::by(&inputs(), &transposed).unwrap_err();
    assert!(
        matches!(error, Error::NotSymmetric { matrix: "Hessian", row: 1, column: 0, .. }),
        "{error}"
    );

    let infinite = |_: &[f64; 2]| Expansion {
        value: 0.0,
        gradient: [1.0, f64::INFINITY],
        hessian: None,
        third: None,
    };
    let error = Moments::by(&inputs(), &infinite).unwrap_err();
    assert!(
        matches!(error, Error::NotFinite { quantity: "gradient entry", index: 1, .. }),
        "{error}"
    );

    let slopes_only =
        |_: &[f64; 2]| Expansion { value: 0.0, gradient: [1.0, 1.0], hessian: None, third: None };
    let moments = Moments::by(&inputs(), &slopes_only).unwrap();
    assert!(matches!(moments.mean_second_order(), Err(Error::CurvatureIncomplete { .. })));
    assert_eq!(moments.trust().unwrap().verdict(), Verdict::Unknown);
}
