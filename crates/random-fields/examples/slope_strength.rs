//! Undrained strength of a slope along a vertical line, given one measured value.

use random_fields::{
    ConditionedField, Correlation, CorrelationFunction, Error, Marginal, Measurement, RandomField,
    SpatialCorrelation, Truncation,
};
use sde_integrators::Noise;

#[allow(clippy::print_stdout, reason = "an example")]
fn main() -> Result<(), Error> {
    let along = |length| Correlation { function: CorrelationFunction::Exponential, length };
    let soil = SpatialCorrelation::separable([along(20.0), along(2.0)]);
    let strength = Marginal::Lognormal { mean: 23.0, coefficient_of_variation: 0.3 };
    let field = RandomField::on_box([[0.0, 0.0], [30.0, 10.0]], soil, Truncation::Share(0.9))?;
    let value = strength.normal_score(15.0)?;
    let vane_test = Measurement { position: [15.0, 6.0], value, standard_deviation: 0.0 };
    let given = ConditionedField::new(field.with_unit_variance(), &[vane_test])?;
    let mut coefficients = vec![0.0; given.n_terms()];
    given.coefficients(&Noise::new(7), 0, 0, &mut coefficients)?;
    let line = [2.0, 4.0, 6.0, 8.0].map(|y| [15.0, y]);
    let mut z = [0.0; 4];
    given.field().values(&coefficients, &line, &mut z)?;
    println!("{} terms; at 2, 4, 6, 8 m: {:.2?} kPa", given.n_terms(), z.map(|z| strength.at(z)));
    Ok(())
}
