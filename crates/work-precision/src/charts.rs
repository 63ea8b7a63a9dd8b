//! Charts and stability sweeps, by name.
//!
//! A chart is one file here and one line in [`ALL`]; a sweep one file in `stability` and one line in [`STABILITY`].

mod built_in_scenes;
mod cost;
mod estimators;
mod fpk;
mod kernels;
mod models;
mod mpi;
mod papers;
mod papers_figures;
mod peridyn;
mod sde;
mod smpm;
mod smpm_fields;
mod smpm_scheme;

use crate::draw::ChartKind;
use crate::stability;

/// Charts of the command `chart`.
pub(crate) const ALL: &[ChartKind] = &[
    fpk::CHART,
    kernels::CHART,
    sde::CHART,
    smpm::CHART,
    smpm_scheme::CHART,
    smpm_fields::CHART,
    estimators::CHART,
    papers::CHART,
    peridyn::CHART,
    mpi::CHART,
    built_in_scenes::CHART,
];

/// Pages of `chart --ladder`.
pub(crate) const MODELS: &[ChartKind] = &[models::FPK, models::SMPM, models::PERIDYN];

/// Sweeps of the command `stability`.
pub(crate) const STABILITY: &[ChartKind] = &[
    stability::fpk::MAP,
    stability::smpm::MAP,
    stability::peridyn::z::MAP,
    stability::peridyn::noise::MAP,
    stability::peridyn::horizon::MAP,
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_of_charts_and_sweeps_are_unique() {
        for table in [ALL, MODELS, STABILITY] {
            let names: BTreeSet<&str> = table.iter().map(|kind| kind.name).collect();
            assert!(!names.is_empty());
            assert_eq!(names.len(), table.len());
        }
    }
}
