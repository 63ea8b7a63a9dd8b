//! Fields given measurements.

use nalgebra::{DMatrix, DVector};
use random_fields::{ConditionedField, Measurement, RandomField, Truncation};
use result_figures::ErrorKind;
use sde_integrators::Noise;

use super::{CORNERS, largest, lattice, soil};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "random-fields/conditioning",
    title: "a field given six measurements, exact and uncertain: kriging, realisations",
    source: "Rasmussen and Williams 2006, eq 2.23 and 2.24, solved by nalgebra",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

fn measurements(standard_deviation: f64) -> Vec<Measurement<2>> {
    let at =
        |x: f64, y: f64, value: f64| Measurement { position: [x, y], value, standard_deviation };
    vec![
        at(0.3, 0.4, 1.5),
        at(1.1, 2.7, -0.5),
        at(2.6, 0.9, 0.3),
        at(2.2, 3.6, -2.0),
        at(0.7, 3.2, 1.0),
        at(1.6, 1.5, 0.0),
    ]
}

/// Mean and variance at points, by a covariance of two points.
fn kriging(
    points: &[[f64; 2]],
    data: &[Measurement<2>],
    covariance: impl Fn(&[f64; 2], &[f64; 2]) -> Result<f64, CaseError>,
) -> Result<Vec<[f64; 2]>, CaseError> {
    let m = data.len();
    let mut matrix = DMatrix::zeros(m, m);
    for i in 0..m {
        for j in 0..m {
            matrix[(i, j)] = covariance(&data[i].position, &data[j].position)?;
        }
        matrix[(i, i)] += data[i].standard_deviation.powi(2);
    }
    let factor = matrix.lu();
    let values = DVector::from_iterator(m, data.iter().map(|one| one.value));
    let mut results = Vec::new();
    for x in points {
        let row: Vec<f64> =
            data.iter().map(|one| covariance(x, &one.position)).collect::<Result<_, _>>()?;
        let row = DVector::from_vec(row);
        let weights = factor.solve(&row).ok_or("the matrix of the measurements is singular")?;
        results.push([weights.dot(&values), covariance(x, x)? - weights.dot(&row)]);
    }
    Ok(results)
}

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let points = lattice([0.1, 0.1], [8, 10], [0.4, 0.42]);
    let cover = lattice(CORNERS[0], [31, 41], [0.1, 0.1]);
    let mut claims = Vec::new();
    for (name, deviation) in [("exact", 0.0), ("uncertain", 0.4)] {
        for (way, field) in [
            ("box", RandomField::on_box(CORNERS, soil(), Truncation::Terms(200))?),
            ("points", RandomField::on_points(&cover, soil(), Truncation::Terms(100))?),
        ] {
            let id = format!("{name}/{way}");
            context.progress(&id);
            let data = measurements(deviation);
            let given = ConditionedField::new(field, &data)?;
            claims.push(dense(context, &id, &given, &data, &points)?);
            if deviation == 0.0 {
                claims.push(at_data(context, &id, &given, &data)?);
            }
            if way == "box" {
                claims.extend(whole_correlation(context, &id, &given, &data, &points)?);
                claims.push(sampled(context, &id, &given, &points)?);
            }
        }
    }
    Ok(claims)
}

fn found(given: &ConditionedField<2>, points: &[[f64; 2]]) -> Result<Vec<[f64; 2]>, CaseError> {
    let mut means = vec![0.0; points.len()];
    given.mean(points, &mut means)?;
    let both = points.iter().zip(means).map(|(x, mean)| Ok([mean, given.variance(x)?]));
    both.collect()
}

fn worst(a: &[[f64; 2]], b: &[[f64; 2]], k: usize) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| (a[k] - b[k]).abs()))
}

/// Mean and variance by the modes against the dense formula with the covariance of the terms.
fn dense(
    context: &Context<'_>,
    id: &str,
    given: &ConditionedField<2>,
    data: &[Measurement<2>],
    points: &[[f64; 2]],
) -> Result<Claim, CaseError> {
    let expected = kriging(points, data, |a, b| Ok(given.field().covariance(a, b)?))?;
    let found = found(given, points)?;
    let error = worst(&found, &expected, 0).max(worst(&found, &expected, 1));
    let subject = context.subject(
        &format!("{id}/dense"),
        "kriging mean and variance, worst error at 80 points",
        "",
        "conditioned modes; the dense formula with the covariance of the terms",
    );
    let reason = "roundoff: of a matrix of six measurements";
    Ok(Claim::within(subject, ErrorKind::Absolute, (error, 0.0), 1e-13, reason))
}

/// Realisations at exact measurements.
fn at_data(
    context: &Context<'_>,
    id: &str,
    given: &ConditionedField<2>,
    data: &[Measurement<2>],
) -> Result<Claim, CaseError> {
    let positions: Vec<[f64; 2]> = data.iter().map(|one| one.position).collect();
    let (mut xi, mut values) = (vec![0.0; given.n_terms()], vec![0.0; data.len()]);
    let mut errors = Vec::new();
    for realisation in 0..100 {
        given.coefficients(&Noise::new(61), realisation, 0, &mut xi)?;
        given.field().values(&xi, &positions, &mut values)?;
        errors.extend(values.iter().zip(data).map(|(value, one)| (value - one.value).abs()));
    }
    let subject = context.subject(
        &format!("{id}/at-data"),
        "realisation at a measurement less the measured value, worst of 600",
        "",
        "100 realisations at six exact measurements",
    );
    let reason = "roundoff: of some hundred terms";
    Ok(Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), 1e-13, reason))
}

/// Against kriging with the correlation itself: what the truncation changes.
fn whole_correlation(
    context: &Context<'_>,
    id: &str,
    given: &ConditionedField<2>,
    data: &[Measurement<2>],
    points: &[[f64; 2]],
) -> Result<Vec<Claim>, CaseError> {
    let expected = kriging(points, data, |a, b| Ok(soil().between(a, b)))?;
    let found = found(given, points)?;
    let method = "200 terms; kriging with the whole correlation";
    let left = given.field().mean_left_out_variance();
    let reason = format!("the terms leave out {left:.3} of the variance");
    let claim = |what: &str, words: &str, k: usize, tolerance: f64| {
        let subject = context.subject(&format!("{id}/whole-{what}"), words, "", method);
        let error = worst(&found, &expected, k);
        Claim::within(subject, ErrorKind::Absolute, (error, 0.0), tolerance, &reason)
    };
    Ok(vec![
        claim("mean", "kriging mean, worst error at 80 points", 0, 0.2),
        claim("variance", "kriging variance, worst error at 80 points", 1, 0.2),
    ])
}

/// Mean and variance of realisations.
fn sampled(
    context: &Context<'_>,
    id: &str,
    given: &ConditionedField<2>,
    points: &[[f64; 2]],
) -> Result<Claim, CaseError> {
    let n_terms = given.n_terms();
    let mut modes = vec![0.0; points.len() * n_terms];
    given.field().modes(points, &mut modes)?;
    let mut xi = vec![0.0; n_terms];
    let mut sums = vec![[0.0; 2]; points.len()];
    let expected = found(given, points)?;
    let draws = 5000;
    for realisation in 0..draws {
        given.coefficients(&Noise::new(62), realisation, 0, &mut xi)?;
        for ((row, sums), [mean, _]) in modes.chunks_exact(n_terms).zip(&mut sums).zip(&expected) {
            let from_mean = row.iter().zip(&xi).map(|(mode, xi)| mode * xi).sum::<f64>() - mean;
            sums[0] += from_mean;
            sums[1] += from_mean * from_mean;
        }
    }
    let n = draws as f64;
    let errors = sums.iter().zip(&expected).flat_map(|(sums, [_, variance])| {
        let of_mean = (sums[0] / n).abs() / (variance / n).sqrt();
        let of_variance = (sums[1] / n - variance).abs() / (variance * (2.0 / n).sqrt());
        [of_mean, of_variance]
    });
    let subject = context.subject(
        &format!("{id}/sampled"),
        "standard errors between mean or variance and kriging, the largest of 160",
        "s.e.",
        "5,000 realisations at 80 points",
    );
    let reason = "statistics: the largest of 160 normals is above 4.2 with a probability of 0.4 %";
    Ok(Claim::within(subject, ErrorKind::Absolute, (largest(errors), 0.0), 4.2, reason))
}
