//! Realisations against the correlation that was asked for.

use random_fields::{
    Correlation, CorrelationFunction, GaussianField, RandomField, SpatialCorrelation, Truncation,
};
use result_figures::{ErrorKind, Measured, Reference};
use sde_integrators::Noise;

use super::{CORNERS, largest, lattice, soil};
use crate::case::{Case, CaseError, Context, Profile, Schedule};
use crate::claim::Criterion;
use crate::report::Claim;

pub(crate) const CASE: Case = Case {
    id: "random-fields/covariance",
    title: "covariance of realisations of every kind of field; inclined axes; the mean over a box",
    source: "the correlation itself; Vanmarcke 1983, section 5.1 (variance function)",
    cost: Profile::Quick,
    schedule: Schedule::Together,
    run,
};

/// Realisations of each field.
const DRAWS: u64 = 20_000;

fn run(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let mut claims = sampled(context)?;
    claims.extend(mean_over_the_box(context)?);
    Ok(claims)
}

/// Sum over realisations of the products of all pairs of values, and the number of points.
struct Products {
    n: usize,
    sums: Vec<f64>,
}

impl Products {
    fn of(
        n: usize,
        mut draw: impl FnMut(u64, &mut [f64]) -> Result<(), CaseError>,
    ) -> Result<Self, CaseError> {
        let (mut sums, mut z) = (vec![0.0; n * n], vec![0.0; n]);
        for realisation in 0..DRAWS {
            draw(realisation, &mut z)?;
            for i in 0..n {
                for j in 0..=i {
                    sums[i * n + j] += z[i] * z[j];
                }
            }
        }
        Ok(Self { n, sums })
    }

    /// Standard errors between a mean product and its covariance, the largest of all pairs: `(1 + rho^2)/N` is the variance.
    fn worst(
        &self,
        covariance: impl Fn(usize, usize) -> Result<f64, CaseError>,
    ) -> Result<f64, CaseError> {
        let mut errors = Vec::new();
        for i in 0..self.n {
            for j in 0..=i {
                let (expected, own) = (covariance(i, j)?, covariance(i, i)? * covariance(j, j)?);
                let mean = self.sums[i * self.n + j] / DRAWS as f64;
                let error = ((own + expected * expected) / DRAWS as f64).sqrt();
                errors.push(((mean - expected) / error).abs());
            }
        }
        Ok(largest(errors))
    }
}

fn sampled(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let points = lattice([0.0, 0.0], [4, 5], [0.5, 0.5]);
    let cover = lattice(CORNERS[0], [16, 21], [0.2, 0.2]);
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let function = CorrelationFunction::Matern52;
    let inclined = SpatialCorrelation::elliptic(function, [2.0, 0.4])
        .with_axes([[cosine, sine], [-sine, cosine]]);
    let mut claims = Vec::new();
    let mut claim = |name: &str, method: &str, worst: f64| {
        let what = "standard errors between a covariance and its value, the largest of 210";
        let subject = context.subject(&format!("sampled/{name}"), what, "s.e.", method);
        let reason =
            "statistics: the largest of 210 normals is above 4.2 with a probability of 0.6 %";
        claims.push(Claim::within(subject, ErrorKind::Absolute, (worst, 0.0), 4.2, reason));
    };
    let expansions = [
        ("box", RandomField::on_box(CORNERS, soil(), Truncation::Share(0.9))?),
        ("points", RandomField::on_points(&cover, soil(), Truncation::Share(0.9))?),
        ("inclined", RandomField::on_points(&cover, inclined, Truncation::Share(0.99))?),
    ];
    for (name, field) in &expansions {
        context.progress(name);
        let n_terms = field.n_terms();
        let (mut modes, mut xi) = (vec![0.0; points.len() * n_terms], vec![0.0; n_terms]);
        field.modes(&points, &mut modes)?;
        let products = Products::of(points.len(), |realisation, z| {
            field.coefficients(&Noise::new(41), realisation, 0, &mut xi)?;
            for (z, row) in z.iter_mut().zip(modes.chunks_exact(n_terms)) {
                *z = row.iter().zip(&xi).map(|(mode, xi)| mode * xi).sum();
            }
            Ok(())
        })?;
        let worst = products.worst(|i, j| Ok(field.covariance(&points[i], &points[j])?))?;
        claim(
            name,
            &format!("20,000 realisations of {n_terms} terms; covariance of the terms"),
            worst,
        );
    }
    let lattices = [
        ("lattice", soil()),
        ("lattice-inclined", inclined),
        (
            "lattice-wendland",
            Correlation { function: CorrelationFunction::WendlandC2, length: 0.7 }.into(),
        ),
    ];
    for (name, correlation) in lattices {
        context.progress(name);
        let field = GaussianField::by_circulant_embedding(&points, 0.5, correlation)?;
        let products = Products::of(points.len(), |realisation, z| {
            Ok(field.sample(&Noise::new(42), realisation, 0, z)?)
        })?;
        let worst = products.worst(|i, j| Ok(correlation.between(&points[i], &points[j])))?;
        claim(name, "20,000 realisations by circulant embedding; the correlation", worst);
    }
    Ok(claims)
}

/// Variance of the mean of an exponential field over an interval of `q` lengths.
fn variance_function(q: f64) -> f64 {
    2.0 / (q * q) * (q - 1.0 + (-q).exp())
}

/// The variance of the mean over the box has a closed form: by terms, and by realisations on a lattice.
fn mean_over_the_box(context: &Context<'_>) -> Result<Vec<Claim>, CaseError> {
    let exact = variance_function(3.0) * variance_function(2.0);
    let fine = lattice([0.025, 0.025], [60, 80], [0.05, 0.05]);
    let field = RandomField::on_box(CORNERS, soil(), Truncation::Share(0.97))?;
    let n_terms = field.n_terms();
    let mut row = vec![0.0; n_terms];
    let mut means = vec![0.0; n_terms];
    for x in &fine {
        field.modes(std::slice::from_ref(x), &mut row)?;
        for (mean, mode) in means.iter_mut().zip(&row) {
            *mean += mode / fine.len() as f64;
        }
    }
    let variance: f64 = means.iter().map(|mean| mean * mean).sum();
    let what = "variance of the mean over a box of 3 by 2 lengths";
    let method = format!("{n_terms} terms, mean of 4,800 points");
    let subject = context.subject("mean/terms", what, "", &method);
    let reason = "what the other terms have of the mean, and the spacing of the points";
    let mut claims =
        vec![Claim::within(subject, ErrorKind::Relative, (variance, exact), 1e-3, reason)];
    let field = GaussianField::by_circulant_embedding(&fine, 0.05, soil())?;
    let (mut z, draws) = (vec![0.0; fine.len()], 2000);
    let mut sums = [0.0; 2];
    for realisation in 0..draws {
        field.sample(&Noise::new(43), realisation, 0, &mut z)?;
        let square = (z.iter().sum::<f64>() / z.len() as f64).powi(2);
        sums[0] += square;
        sums[1] += square * square;
    }
    let n = draws as f64;
    let value = sums[0] / n;
    let error = ((sums[1] / n - value * value) / n).sqrt();
    let method = "2,000 realisations by circulant embedding on 4,800 points";
    let subject = context.subject("mean/lattice", what, "", method);
    let measured = Measured { value, standard_error: Some(error) };
    let criterion = Criterion::MonteCarlo { bias_bound: 1e-3, reason: "spacing of the points" };
    claims.push(Claim::judge(
        subject,
        ErrorKind::Relative,
        measured,
        Reference::exact(exact),
        criterion,
    ));
    Ok(claims)
}
