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

// Names are unique. Checked by the compiler: a unit test that names a table compiles every chart once more.
const _: () = {
    assert!(are_names_unique(ALL) && are_names_unique(MODELS) && are_names_unique(STABILITY));
};

const fn are_names_unique(table: &[ChartKind]) -> bool {
    let mut i = 0;
    while i < table.len() {
        let mut k = i + 1;
        while k < table.len() {
            if are_equal(table[i].name.as_bytes(), table[k].name.as_bytes()) {
                return false;
            }
            k += 1;
        }
        i += 1;
    }
    !table.is_empty()
}

const fn are_equal(mut a: &[u8], mut b: &[u8]) -> bool {
    while let ([first, rest @ ..], [other, others @ ..]) = (a, b) {
        if *first != *other {
            return false;
        }
        (a, b) = (rest, others);
    }
    a.is_empty() && b.is_empty()
}
