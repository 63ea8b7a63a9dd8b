//! Forward automatic differentiation: derivatives exact within roundoff.

use num_dual::{HyperDual64, HyperHyperDual64};

use crate::expansion::{Expansion, set_symmetric};
use crate::response::Response;

/// Highest order of the derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HighestOrder {
    /// Up to the Hessian: `N(N+1)/2` evaluations over hyper-dual numbers.
    Second,
    /// Up to all third derivatives: `N(N+1)(N+2)/6` evaluations over numbers with eight parts.
    Third,
}

/// All derivatives of a response by the dual numbers of num-dual.
///
/// They are exact within roundoff, also where differences fail. The response must be a [`Response`]. A branch is
/// evaluated as at the centre, so a nearby kink is not detected.
///
/// Source: Fike and Alonso 2011, The development of hyper-dual numbers for exact second-derivative calculations.
///
/// ```
/// use perturbation_moments::{ForwardDifferentiation, HighestOrder, Moments, RandomVector, Response, Scalar};
///
/// struct Ishigami;
/// impl Response<3> for Ishigami {
///     fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
///         x[0].sin() + x[1].sin().squared() * 7.0 + x[2].powi(4) * x[0].sin() * 0.1
///     }
/// }
///
/// let inputs = RandomVector::independent([1.0, 0.8, 1.5], [0.3; 3])?;
/// let way = ForwardDifferentiation { response: Ishigami, order: HighestOrder::Third };
/// let trust = Moments::new(&inputs, &way.expansion(&inputs.centre()))?.trust()?;
/// assert!(trust.curvature_ratio.unwrap() < 0.01 && trust.third_ratio.unwrap() > 0.3);
/// # Ok::<(), perturbation_moments::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ForwardDifferentiation<R> {
    /// The response.
    pub response: R,
    /// Highest order of the derivatives.
    pub order: HighestOrder,
}

impl<R> ForwardDifferentiation<R> {
    /// The derivatives at a point.
    #[must_use]
    pub fn expansion<const N: usize>(&self, x: &[f64; N]) -> Expansion<N>
    where
        R: Response<N>,
    {
        match self.order {
            HighestOrder::Second => second_order(&self.response, x),
            HighestOrder::Third => third_order(&self.response, x),
        }
    }
}

fn second_order<const N: usize>(response: &impl Response<N>, x: &[f64; N]) -> Expansion<N> {
    let mut out = empty(response, x);
    let mut hessian = [[0.0; N]; N];
    for i in 0..N {
        for j in i..N {
            let mut seeded = x.map(HyperDual64::from_re);
            seeded[i].eps1 = 1.0;
            seeded[j].eps2 = 1.0;
            let y = response.value(&seeded);
            (hessian[i][j], hessian[j][i]) = (y.eps1eps2, y.eps1eps2);
            out.gradient[j] = y.eps2;
        }
    }
    Expansion { hessian: Some(hessian), ..out }
}

fn third_order<const N: usize>(response: &impl Response<N>, x: &[f64; N]) -> Expansion<N> {
    let mut out = empty(response, x);
    let mut hessian = [[0.0; N]; N];
    let mut third = [[[0.0; N]; N]; N];
    for i in 0..N {
        for j in i..N {
            for k in j..N {
                let mut seeded = x.map(HyperHyperDual64::from_re);
                seeded[i].eps1 = 1.0;
                seeded[j].eps2 = 1.0;
                seeded[k].eps3 = 1.0;
                let y = response.value(&seeded);
                set_symmetric(&mut third, [i, j, k], y.eps1eps2eps3);
                (hessian[j][k], hessian[k][j]) = (y.eps2eps3, y.eps2eps3);
                out.gradient[k] = y.eps3;
            }
        }
    }
    Expansion { hessian: Some(hessian), third: Some(third), ..out }
}

fn empty<const N: usize>(response: &impl Response<N>, x: &[f64; N]) -> Expansion<N> {
    Expansion { value: response.value(x), gradient: [0.0; N], hessian: None, third: None }
}
