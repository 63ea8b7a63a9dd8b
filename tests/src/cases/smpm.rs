//! What is claimed of `smpm`.

pub(crate) mod contact_explosion;
pub(crate) mod detonation;
pub(crate) mod disks;
pub(crate) mod elastic_bar;
pub(crate) mod invariance;
pub(crate) mod johnson_cook_point;
mod methods;
pub(crate) mod paper_size;
pub(crate) mod plate_impact;
pub(crate) mod refinement;
pub(crate) mod shock_tubes;
pub(crate) mod taylor_bar;
pub(crate) mod trust;

/// The `share` quantile of some numbers, the upper of two neighbours; NaN of none.
pub(crate) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index: a share of a count"
    )]
    let index = (share * sorted.len() as f64) as usize;
    sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}
