//! When a Taylor series should not be believed.

/// Sizes of the corrections to the first-order variance, relative to it.
///
/// $$ \kappa = \frac{\operatorname{tr} H\Sigma H\Sigma}{2 g^T \Sigma g}, \qquad
///    \tau = \frac{\left| \sum g_i T_{jkl} \Sigma_{ij} \Sigma_{kl} \right|}{g^T \Sigma g} $$
///
/// Both are of the same order in $\sigma$. A small $\kappa$ alone says nothing: for Ishigami's function with deviations of
/// 0.3 it is 0.006 while the variance is wrong by 32 %, and it is $\tau = 0.31$ that tells.
/// Neither sees a kink that lies away from the centre; the sigma-point ratio does, if a direction $L e_k$ crosses it.
///
/// None of them is a bound. How often they were right on the reference cases is a table of the verification
/// (`perturbation-moments/trust`).
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Trust {
    /// $\kappa$; `None` where the Hessian is not known well enough.
    pub curvature_ratio: Option<f64>,
    /// $\tau$; `None` without third derivatives.
    pub third_ratio: Option<f64>,
    /// The distance of the sigma-point variance to the first-order one, relative to it; `None` where
    /// [`SigmaPoints`](crate::SigmaPoints) were not asked.
    pub sigma_point_ratio: Option<f64>,
}

/// What the indicators say together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Curvature and third derivatives are known and small.
    InPeace,
    /// One of the indicators exceeds [`Trust::LIMIT`].
    Warned,
    /// Nothing known exceeds the limit, but curvature or third derivatives are not known.
    Unknown,
}

impl Trust {
    /// Above this an indicator warns.
    ///
    /// With the first-order variance off by about $\kappa \pm \tau$, 0.05 each keeps it within 10 % where the series
    /// converges.
    pub const LIMIT: f64 = 0.05;

    /// What the indicators say together.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let all = [self.curvature_ratio, self.third_ratio, self.sigma_point_ratio];
        if all.iter().flatten().any(|&ratio| ratio > Self::LIMIT) {
            Verdict::Warned
        } else if self.curvature_ratio.is_some() && self.third_ratio.is_some() {
            Verdict::InPeace
        } else {
            Verdict::Unknown
        }
    }
}
