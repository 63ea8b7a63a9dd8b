#![doc = include_str!("../README.md")]

mod batch;
mod check;
mod corrections;
mod cubic_spline;
mod error;
mod exponential;
mod geometry;
mod kernel;
mod lucy;
mod marginal;
mod quartic_spline;
mod quintic_spline;
mod truncated_gaussian;
mod wendland_c2;
mod wendland_c4;
mod wendland_c6;

pub use check::check_kernel;
pub use corrections::{
    SMALLEST_RECIPROCAL_CONDITION, SMALLEST_SHEPARD_SUM, corrected_gradient,
    renormalisation_matrix, shepard_factor,
};
pub use cubic_spline::CubicSpline;
pub use error::Error;
pub use geometry::{power, unit_sphere_surface};
pub use kernel::Kernel;
pub use lucy::Lucy;
pub use quartic_spline::QuarticSpline;
pub use quintic_spline::QuinticSpline;
pub use truncated_gaussian::TruncatedGaussian;
pub use wendland_c2::WendlandC2;
pub use wendland_c4::WendlandC4;
pub use wendland_c6::WendlandC6;

/// Every kernel of this crate by name: the table for property tests, charts and documentation.
///
/// A new kernel is one file, and its line here.
///
/// ```
/// let names: Vec<_> = smoothing_kernels::all::<3>().into_iter().map(|(name, _)| name).collect();
/// assert!(names.contains(&"Lucy") && names.contains(&"WendlandC6"));
/// ```
#[must_use]
pub fn all<const D: usize>() -> Vec<(&'static str, Box<dyn Kernel<D>>)> {
    vec![
        ("Lucy", Box::new(Lucy)),
        ("CubicSpline", Box::new(CubicSpline)),
        ("QuarticSpline", Box::new(QuarticSpline)),
        ("QuinticSpline", Box::new(QuinticSpline)),
        ("WendlandC2", Box::new(WendlandC2)),
        ("WendlandC4", Box::new(WendlandC4)),
        ("WendlandC6", Box::new(WendlandC6)),
        ("TruncatedGaussian", Box::new(TruncatedGaussian)),
    ]
}
