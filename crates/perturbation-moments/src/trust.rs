//! Trust indicators of a Taylor series.

/// Corrections to the first-order variance, relative to it.
///
/// $$ \kappa = \frac{\operatorname{tr} H\Sigma H\Sigma}{2 g^T \Sigma g}, \qquad
///    \tau = \frac{\left| \sum g_i T_{jkl} \Sigma_{ij} \Sigma_{kl} \right|}{g^T \Sigma g} $$
///
/// Both are of the same order in $\sigma$. A small $\kappa$ alone is no evidence: for Ishigami's function with
/// deviations of 0.3 it is 0.006 while the variance is wrong by 32 %, which $\tau = 0.31$ indicates. Neither detects a
/// kink away from the centre; the sigma-point ratio does if a direction $L e_k$ crosses it.
///
/// None of them is a bound. The README tabulates how often they were right on 49 reference cases.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use]
pub struct Trust {
    /// $\kappa$; `None` if too little of the Hessian is known.
    pub curvature_ratio: Option<f64>,
    /// $\tau$; `None` without third derivatives.
    pub third_ratio: Option<f64>,
    /// Relative difference of the sigma-point variance from the first-order one.
    ///
    /// `None` without [`SigmaPoints`](crate::SigmaPoints).
    pub sigma_point_ratio: Option<f64>,
}

/// Combined result of the indicators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Curvature and third derivatives are known and small.
    InPeace,
    /// An indicator exceeds [`Trust::LIMIT`].
    Warned,
    /// No known indicator exceeds the limit, but curvature or third derivatives are unknown.
    Unknown,
}

impl Trust {
    /// Value above which an indicator warns.
    ///
    /// The first-order variance errs by about $\kappa \pm \tau$; 0.05 each keeps it within 10 % where the series
    /// converges.
    pub const LIMIT: f64 = 0.05;

    /// Combined result of the indicators.
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
