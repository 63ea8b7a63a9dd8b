//! The responses of the reference cases, and what this crate's formulas make of them.

use perturbation_moments::{
    Expansion, ForwardDifferentiation, HighestOrder, Jet, Moments, RandomVector, Response, Scalar,
    SigmaPoints, Trust,
};

use super::closed_forms::{JohnsonCook, MieGruneisen, MieGruneisenState};
use super::reference::{ReferenceCase, State};
use crate::case::CaseError;

/// `3 x1 - 2 x2 + 0.5 x3 + 1`.
#[derive(Debug, Clone, Copy)]
pub struct Linear;

/// `x1 x2`.
#[derive(Debug, Clone, Copy)]
pub struct Product;

/// `exp(x1 + x2/2)`.
#[derive(Debug, Clone, Copy)]
pub struct Exponential;

/// `F L^3/(3 E J)` by force, modulus, length, inertia.
#[derive(Debug, Clone, Copy)]
pub struct Cantilever;

/// `sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1` (Ishigami and Homma 1990).
#[derive(Debug, Clone, Copy)]
pub struct Ishigami;

/// `1/sqrt((1 - 90 m/k)^2 + 360 z^2 m/k)` by stiffness, mass, damping ratio.
#[derive(Debug, Clone, Copy)]
pub struct Amplification;

/// Mie-Gruneisen with `S2 = S3 = 0`, by `S1`, `gamma0`, `a`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShortMieGruneisen(MieGruneisen);

impl Response<3> for Linear {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        x[0] * 3.0 - x[1] * 2.0 + x[2] * 0.5 + 1.0
    }
}

impl Response<2> for Product {
    fn value<S: Scalar>(&self, x: &[S; 2]) -> S {
        x[0] * x[1]
    }
}

impl Response<2> for Exponential {
    fn value<S: Scalar>(&self, x: &[S; 2]) -> S {
        (x[0] + x[1] * 0.5).exp()
    }
}

impl Response<4> for Cantilever {
    fn value<S: Scalar>(&self, x: &[S; 4]) -> S {
        let [force, modulus, length, inertia] = *x;
        force * length.powi(3) / (modulus * inertia * 3.0)
    }
}

impl Response<3> for Ishigami {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        x[0].sin() + x[1].sin().squared() * 7.0 + x[2].powi(4) * x[0].sin() * 0.1
    }
}

impl Response<3> for Amplification {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        let [stiffness, mass, damping] = *x;
        let ratio = mass / stiffness * 90.0;
        ((-ratio + 1.0).squared() + damping.squared() * ratio * 4.0).sqrt().recip()
    }
}

impl Response<3> for ShortMieGruneisen {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        self.0.value(&[x[0], S::constant(0.0), S::constant(0.0), x[1], x[2]])
    }
}

/// What came of one case: numbers without the number of inputs.
#[derive(Debug, Clone)]
pub struct Assessed {
    /// The largest errors of value, gradient, Hessian and third derivatives, by dual numbers, by jets and in closed form.
    pub derivative_error: f64,
    /// The largest error against OpenTURNS.
    pub openturns_error: f64,
    /// The largest error of a moment against its formula from the reference's derivatives.
    pub moment_error: f64,
    /// First-order variance.
    pub variance_first_order: f64,
    /// Variance with curvature.
    pub variance_with_curvature: f64,
    /// Variance to fourth order.
    pub variance_fourth_order: f64,
    /// Second-order mean.
    pub mean_second_order: f64,
    /// By derivatives alone.
    pub trust: Trust,
    /// With the sigma points as a witness.
    pub witnessed: Trust,
}

/// Something to do with a response of any number of inputs.
pub trait Visitor {
    /// What comes of it.
    type Output;

    /// Does it. `closed` are the derivatives in closed form, where there are any.
    ///
    /// # Errors
    /// Those of what is done.
    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        closed: Option<Expansion<N>>,
    ) -> Result<Self::Output, CaseError>;
}

/// Finds the response of a case and lets a visitor in.
///
/// # Errors
/// Of a case without a response, and those of the visitor.
pub fn visit<V: Visitor>(case: &ReferenceCase, visitor: &mut V) -> Result<V::Output, CaseError> {
    match (case.name.split('_').next().unwrap_or_default(), case.state) {
        ("linear3", _) => visitor.visit(&inputs::<3>(case)?, &Linear, None),
        ("product2", _) => visitor.visit(&inputs::<2>(case)?, &Product, None),
        ("exp2", _) => visitor.visit(&inputs::<2>(case)?, &Exponential, None),
        ("cantilever", _) => visitor.visit(&inputs::<4>(case)?, &Cantilever, None),
        ("ishigami", _) => visitor.visit(&inputs::<3>(case)?, &Ishigami, None),
        ("sdof", _) => visitor.visit(&inputs::<3>(case)?, &Amplification, None),
        (_, Some(State::JohnsonCook { ep, rate, temperature })) => {
            let response = JohnsonCook::new(ep, rate, temperature);
            let inputs = inputs::<5>(case)?;
            visitor.visit(&inputs, &response, Some(response.expansion(inputs.mean())))
        }
        (_, Some(State::MieGruneisen { mu, e, rho0, c0 })) => {
            let state =
                MieGruneisenState { bulk_modulus: rho0 * c0 * c0, compression: mu, energy: e };
            let response = MieGruneisen::new(state);
            let inputs = inputs::<3>(case)?;
            let [s1, gamma, a] = *inputs.mean();
            let closed = shorten(&response.expansion(&[s1, 0.0, 0.0, gamma, a]));
            visitor.visit(&inputs, &ShortMieGruneisen(response), Some(closed))
        }
        _ => Err(format!("no response for the case {}", case.name).into()),
    }
}

/// The derivatives by `S1`, `gamma0` and `a` alone.
fn shorten(all: &Expansion<5>) -> Expansion<3> {
    let kept = [0, 3, 4];
    Expansion::from_derivatives(|by| match *by {
        [i] => all.gradient[kept[i]],
        [i, j] => all.hessian.map_or(f64::NAN, |h| h[kept[i]][kept[j]]),
        [i, j, k] => all.third.map_or(f64::NAN, |t| t[kept[i]][kept[j]][kept[k]]),
        _ => all.value,
    })
}

fn inputs<const N: usize>(case: &ReferenceCase) -> Result<RandomVector<N>, CaseError> {
    let row = |values: &Vec<f64>| -> Result<[f64; N], CaseError> {
        values.as_slice().try_into().map_err(|_| format!("{}: not {N} inputs", case.name).into())
    };
    let mut correlation = [[0.0; N]; N];
    for (into, from) in correlation.iter_mut().zip(&case.corr) {
        *into = row(from)?;
    }
    Ok(RandomVector::new(row(&case.mean)?, row(&case.sigma)?, correlation)?)
}

/// The visitor that compares everything with the reference.
struct Assess<'a>(&'a ReferenceCase);

/// What this crate makes of a case.
///
/// # Errors
/// Of a case without a response, and those of the moments.
pub fn assess(case: &ReferenceCase) -> Result<Assessed, CaseError> {
    visit(case, &mut Assess(case))
}

impl Visitor for Assess<'_> {
    type Output = Assessed;

    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        closed: Option<Expansion<N>>,
    ) -> Result<Assessed, CaseError> {
        let case = self.0;
        let way = ForwardDifferentiation { response, order: HighestOrder::Third };
        let expansion = way.expansion(inputs.mean());
        // What jets do not carry, mixed and third derivatives, is that of dual numbers.
        let mean = inputs.mean();
        let y = response.value(&std::array::from_fn(|k| Jet::variable(mean[k], k)));
        let mut by_jets = Expansion { value: y.value, ..expansion };
        for k in 0..N {
            by_jets.gradient[k] = y.first[k];
            if let Some(hessian) = &mut by_jets.hessian {
                hessian[k][k] = y.second[k];
            }
        }
        let mut derivative_error =
            largest(derivative_error(case, &expansion), derivative_error(case, &by_jets));
        if let Some(closed) = closed {
            derivative_error = largest(derivative_error, self::derivative_error(case, &closed));
        }
        let moments = Moments::new(inputs, &expansion)?;
        let points = SigmaPoints::new(inputs, |x| response.value(x))?;
        Ok(Assessed {
            derivative_error,
            openturns_error: openturns_error(case, &expansion, &moments)?,
            moment_error: moment_error(case, &moments)?,
            variance_first_order: moments.variance_first_order(),
            variance_with_curvature: moments.variance_with_curvature()?,
            variance_fourth_order: moments.variance_fourth_order()?,
            mean_second_order: moments.mean_second_order()?,
            trust: moments.trust()?,
            witnessed: points.judge(&moments)?,
        })
    }
}

/// The largest distance between two lists, over the largest entry of the second, each entry weighted; NaN stays NaN.
fn worst(entries: &[(f64, f64, f64)]) -> f64 {
    let largest = entries.iter().fold(0.0_f64, |m, (weight, _, b)| m.max((weight * b).abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let mut worst = 0.0_f64;
    for (weight, a, b) in entries {
        let error = (weight * (a - b)).abs() / scale;
        if error.is_nan() || error > worst {
            worst = error;
        }
    }
    worst
}

fn derivative_error<const N: usize>(case: &ReferenceCase, ours: &Expansion<N>) -> f64 {
    let s = &case.sigma;
    let (mut first, mut second, mut third) = (Vec::new(), Vec::new(), Vec::new());
    let hessian = ours.hessian.unwrap_or([[f64::NAN; N]; N]);
    let tensor = ours.third.unwrap_or([[[f64::NAN; N]; N]; N]);
    for i in 0..N {
        first.push((s[i], ours.gradient[i], case.gradient[i]));
        for j in 0..N {
            second.push((s[i] * s[j], hessian[i][j], case.hessian[i][j]));
            for k in 0..N {
                third.push((s[i] * s[j] * s[k], tensor[i][j][k], case.third[i][j][k]));
            }
        }
    }
    let value = worst(&[(1.0, ours.value, case.value)]);
    [value, worst(&first), worst(&second), worst(&third)].into_iter().fold(0.0, largest)
}

fn openturns_error<const N: usize>(
    case: &ReferenceCase,
    ours: &Expansion<N>,
    moments: &Moments<N>,
) -> Result<f64, CaseError> {
    let theirs = &case.openturns;
    let factors = moments.importance_factors()?;
    let (mut first, mut second, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    let hessian = ours.hessian.unwrap_or([[f64::NAN; N]; N]);
    for i in 0..N {
        first.push((case.sigma[i], ours.gradient[i], theirs.gradient[i]));
        shares.push((1.0, factors[i], theirs.importance[i]));
        for j in 0..N {
            let weight = case.sigma[i] * case.sigma[j];
            second.push((weight, hessian[i][j], theirs.hessian[i][j]));
        }
    }
    Ok([
        worst(&[(1.0, moments.mean_first_order(), theirs.mean1)]),
        worst(&[(1.0, moments.mean_second_order()?, theirs.mean2)]),
        worst(&[(1.0, moments.variance_first_order(), theirs.var1)]),
        worst(&first),
        worst(&second),
        worst(&shares),
    ]
    .into_iter()
    .fold(0.0, largest))
}

fn moment_error<const N: usize>(
    case: &ReferenceCase,
    moments: &Moments<N>,
) -> Result<f64, CaseError> {
    let by_formula = &case.second_order;
    let variance = by_formula.var2;
    // Odd and high moments may vanish: relative to what the variance says they may be.
    let over = |a: f64, b: f64, scale: f64| (a - b).abs() / scale;
    Ok([
        over(moments.variance_with_curvature()?, by_formula.var2, variance),
        over(moments.variance_fourth_order()?, by_formula.var_o4_with_third_derivs, variance),
        over(moments.third_central_moment()?, by_formula.third_central, variance.powf(1.5)),
        over(moments.fourth_cumulant()?, by_formula.kappa4, variance * variance),
    ]
    .into_iter()
    .fold(0.0, largest))
}

/// The larger, and NaN if one is.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}
