#![doc = include_str!("../README.md")]

mod cubic_spline;
mod geometry;
mod kernel;
mod lucy;
mod truncated_gaussian;
mod wendland_c2;

pub use cubic_spline::CubicSpline;
pub use geometry::{power, unit_sphere_surface};
pub use kernel::Kernel;
pub use lucy::Lucy;
pub use truncated_gaussian::TruncatedGaussian;
pub use wendland_c2::WendlandC2;

/// Every kernel of this crate by name: the table that the laws, the charts and the documentation loop over.
///
/// A new kernel is one file, and its line here.
///
/// ```
/// let names: Vec<_> = smoothing_kernels::all::<3>().into_iter().map(|(name, _)| name).collect();
/// assert_eq!(names, ["Lucy", "CubicSpline", "WendlandC2", "TruncatedGaussian"]);
/// ```
#[must_use]
pub fn all<const D: usize>() -> Vec<(&'static str, Box<dyn Kernel<D>>)> {
    vec![
        ("Lucy", Box::new(Lucy)),
        ("CubicSpline", Box::new(CubicSpline)),
        ("WendlandC2", Box::new(WendlandC2)),
        ("TruncatedGaussian", Box::new(TruncatedGaussian)),
    ]
}
