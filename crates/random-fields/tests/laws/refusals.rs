//! Input that is refused, with the value and its limit.

use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, Error, GaussianField, Measurement,
    RandomField, SpatialCorrelation, Truncation,
};

const BOX: [[f64; 2]; 2] = [[0.0, 0.0], [3.0, 1.0]];

fn along(length: f64) -> Correlation {
    Correlation { function: CorrelationFunction::Exponential, length }
}

fn on_box(correlation: SpatialCorrelation<2>, truncation: Truncation) -> Error {
    RandomField::on_box(BOX, correlation, truncation).unwrap_err()
}

fn line() -> Vec<[f64; 1]> {
    (0..20).map(|k| [0.1 * f64::from(k)]).collect()
}

#[test]
fn lengths_that_are_no_lengths() {
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let soil = SpatialCorrelation::separable([along(1.0), along(length)]);
        assert!(
            matches!(on_box(soil, Truncation::Terms(3)), Error::NotPositive { .. }),
            "{length}"
        );
        let of_points = RandomField::on_points(&line(), along(length), Truncation::Terms(3));
        assert!(matches!(of_points, Err(Error::NotPositive { .. })), "{length}");
        let lattice = GaussianField::by_circulant_embedding(&line(), 0.1, along(length));
        assert!(matches!(lattice, Err(Error::NotPositive { .. })), "{length}");
    }
}

#[test]
fn points_so_far_apart_that_no_lattice_holds_them() {
    for far in [1e8, 1e15, 1e19, 1e300] {
        let points = [[0.0, 0.0], [1.0, 0.0], [far, 0.0]];
        let correlation = along(far);
        let found = GaussianField::by_circulant_embedding(&points, 1.0, correlation);
        assert!(matches!(found, Err(Error::TooManyPoints { .. })), "{far}: {found:?}");
    }
}

#[test]
fn lengths_of_more_than_a_thousand_bodies() {
    let soil = |length| SpatialCorrelation::separable([along(1.0), along(length)]);
    let refused = on_box(soil(3.1e3), Truncation::Terms(3));
    assert_eq!(refused, Error::LengthBeyondBody { length: 3.1e3, limit: 3e3 });
    assert!(RandomField::on_box(BOX, soil(2.9e3), Truncation::Terms(3)).is_ok());
    let refused = GaussianField::by_pivoted_cholesky(&line(), along(2e3), 1e-3);
    assert!(matches!(refused, Err(Error::LengthBeyondBody { .. })));
}

#[test]
fn smoothness_and_axes_that_cannot_be() {
    let function = CorrelationFunction::Matern { smoothness: 25.0 };
    let refused = RandomField::on_points(
        &line(),
        Correlation { function, length: 1.0 },
        Truncation::Terms(3),
    );
    assert!(matches!(refused, Err(Error::OutOfRange { value: 25.0, .. })));
    let skew = SpatialCorrelation::separable([along(1.0); 2]).with_axes([[1.0, 0.0], [0.1, 1.0]]);
    let refused = on_box(skew, Truncation::Terms(3));
    assert!(matches!(refused, Error::NotOrthonormal { first: 1, second: 0, .. }), "{refused}");
    let nan = SpatialCorrelation::separable([along(1.0); 2]).with_axes([[f64::NAN; 2]; 2]);
    assert!(matches!(on_box(nan, Truncation::Terms(3)), Error::NotOrthonormal { .. }));
}

#[test]
fn correlations_without_known_eigenfunctions_on_a_box() {
    let isotropic = SpatialCorrelation::from(along(1.0));
    let matern = Correlation { function: CorrelationFunction::Matern32, length: 1.0 };
    for correlation in [isotropic, SpatialCorrelation::separable([along(1.0), matern])] {
        let refused = on_box(correlation, Truncation::Terms(3));
        assert!(refused.to_string().contains("cover the body with points"), "{refused}");
    }
}

#[test]
fn truncations_that_cannot_be() {
    let soil = SpatialCorrelation::separable([along(1.0); 2]);
    assert!(matches!(on_box(soil, Truncation::Terms(0)), Error::NotPositive { .. }));
    assert!(matches!(on_box(soil, Truncation::Terms(20_001)), Error::OutOfRange { .. }));
    for share in [0.0, 1.0, -0.5, f64::NAN] {
        assert!(matches!(on_box(soil, Truncation::Share(share)), Error::OutOfRange { .. }));
    }
    let short = SpatialCorrelation::separable([along(0.01); 2]);
    let refused = on_box(short, Truncation::Share(0.99));
    assert!(matches!(refused, Error::TooManyTerms { n_terms: 20_000, .. }), "{refused}");
    // Twenty points have twenty values; a Gaussian correlation of ten lengths has fewer above roundoff.
    let smooth = Correlation { function: CorrelationFunction::Gaussian, length: 20.0 };
    let refused = RandomField::on_points(&line(), smooth, Truncation::Terms(15)).unwrap_err();
    let Error::TooFewPoints { available, asked: 15, n_points: 20 } = refused else {
        unreachable!("{refused}")
    };
    assert!((3..12).contains(&available), "{available}");
    let refused = RandomField::on_points(&line(), along(1.0), Truncation::Terms(21));
    assert!(matches!(refused, Err(Error::TooFewPoints { available: 20, .. })));
}

#[test]
fn points_outside_and_slices_of_other_lengths() {
    let soil = SpatialCorrelation::separable([along(1.0); 2]);
    let field = RandomField::on_box(BOX, soil, Truncation::Terms(4)).unwrap();
    let mut out = [0.0; 2];
    let refused = field.values(&[0.0; 4], &[[1.0, 0.5], [1.0, 1.5]], &mut out);
    assert!(matches!(refused, Err(Error::OutsideBox { point: 1, axis: 1, .. })), "{refused:?}");
    let refused = field.values(&[0.0; 4], &[[1.0, f64::NAN]; 2], &mut out);
    assert!(matches!(refused, Err(Error::Point { point: 0, .. })));
    let refused = field.values(&[f64::NAN; 4], &[[1.0, 0.5]; 2], &mut out);
    assert!(matches!(refused, Err(Error::NotFinite { .. })));
    for refused in [
        field.values(&[0.0; 3], &[[1.0, 0.5]; 2], &mut out),
        field.values(&[0.0; 4], &[[1.0, 0.5]], &mut out),
        field.modes(&[[1.0, 0.5]], &mut out),
    ] {
        assert!(matches!(refused, Err(Error::Length { .. })), "{refused:?}");
    }
    let empty = RandomField::on_box([[0.0, 1.0], [3.0, 1.0]], soil, Truncation::Terms(4));
    assert!(matches!(empty, Err(Error::EmptyInterval { low: 1.0, high: 1.0, .. })));
    let none = RandomField::<1>::on_points(&[], along(1.0), Truncation::Terms(4));
    assert_eq!(none, Err(Error::NoPoints));
    let weights =
        RandomField::on_weighted_points(&line(), &[1.0; 19], along(1.0), Truncation::Terms(4));
    assert!(matches!(weights, Err(Error::Length { value: 19, expected: 20, .. })));
    let mut volumes = [1.0; 20];
    volumes[7] = 0.0;
    let weights =
        RandomField::on_weighted_points(&line(), &volumes, along(1.0), Truncation::Terms(4));
    assert!(matches!(weights, Err(Error::Point { point: 7, .. })));
}

#[test]
fn measurements_that_contradict_or_repeat_each_other() {
    let field = RandomField::on_points(&line(), along(1.0), Truncation::Terms(5)).unwrap();
    let at = |x: f64, value: f64| Measurement { position: [x], value, standard_deviation: 0.0 };
    let given = |data: &[Measurement<1>]| ConditionedField::new(field.clone(), data).unwrap_err();
    let refused = given(&[at(0.5, 1.0), at(0.1, 0.0), at(0.5, 2.0)]);
    assert!(matches!(refused, Error::CoincidentMeasurements { first: 0, second: 2, .. }));
    assert!(refused.to_string().contains("1 and 2"), "{refused}");
    let six: Vec<_> = (0..6).map(|k| at(0.3 * f64::from(k), 0.0)).collect();
    let refused = given(&six);
    assert!(matches!(refused, Error::DependentMeasurement { measurement: 5, n_terms: 5, .. }));
    assert!(matches!(given(&[at(0.5, f64::NAN)]), Error::NotFinite { .. }));
    for standard_deviation in [1e-6, -1.0, f64::NAN, f64::INFINITY] {
        let refused = given(&[Measurement { standard_deviation, ..at(0.5, 0.0) }]);
        assert!(matches!(refused, Error::OutOfRange { .. }), "{refused}");
    }
    let uncertain = Measurement { standard_deviation: 0.1, ..at(0.5, 2.0) };
    assert!(ConditionedField::new(field, &[at(0.5, 1.0), uncertain]).is_ok());
}
