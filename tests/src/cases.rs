//! What is claimed of each crate.
//!
//! A case is one file here and one line in [`ALL`].

mod advice;
mod estimators;
mod fpk;
mod lines;
mod neighbour_search;
mod particle_store;
mod peridyn;
mod perturbation_moments;
mod ranks;
mod resume;
mod sde;
mod sde_ensembles;
mod smoothing_kernels;
mod smpm;
mod worst;

use crate::case::Case;

/// Every case, in the order in which the table is printed.
pub const ALL: &[Case] = &[
    fpk::linear_oscillator::CASE,
    fpk::viscous_damper::CASE,
    fpk::viscous_damper::REFINED,
    fpk::viscous_damper::FLOW_MAP_FIT,
    fpk::linear_oscillator::FLOW_MAP_FIT,
    fpk::gaussian_mixture::CASE,
    fpk::bouc_wen::COARSE,
    fpk::bouc_wen::CASE,
    fpk::bouc_wen::TAIL,
    fpk::bouc_wen_paper::CASE,
    fpk::filtered::DAMPER,
    fpk::filtered::BOUC_WEN,
    fpk::linear_systems::CASE,
    fpk::linear_systems::KANAI_TAJIMI,
    fpk::known_densities::CASE,
    fpk::effectivity::CASE,
    fpk::first_passage::DAMPER,
    fpk::first_passage::CROSSINGS,
    fpk::first_passage::BOUC_WEN,
    fpk::first_passage::FRAGILITY,
    fpk::bouc_wen::REMAPPED,
    fpk::viscous_damper::REMAPPED,
    fpk::stationary_oscillators::DUFFING,
    fpk::stationary_oscillators::VAN_DER_POL,
    fpk::canor_denoel::CASE,
    fpk::schemes::CASE,
    fpk::monte_carlo::CASE,
    fpk::rivals::CASE,
    fpk::guided_paths::CASE,
    fpk::shear_building::CASE,
    fpk::passage_benchmarks::CASE,
    fpk::spatial_order::CASE,
    fpk::steps::CASE,
    fpk::time_schemes::CASE,
    fpk::invariance::CASE,
    fpk::failures::CASE,
    smpm::elastic_bar::CASE,
    smpm::disks::CASE,
    smpm::shock_tubes::CASE,
    smpm::plate_impact::CASE,
    smpm::detonation::CASE,
    smpm::taylor_bar::AXISYMMETRIC,
    smpm::taylor_bar::QUARTER,
    smpm::taylor_bar::BENCHMARK,
    smpm::taylor_bar::PREDICTED,
    smpm::return_mapping::CASE,
    smpm::johnson_cook_point::CASE,
    smpm::contact_explosion::DIFFERENCES,
    smpm::contact_explosion::SAMPLES,
    smpm::variance_fields::CASE,
    smpm::trust::CASE,
    smpm::refinement::CASE,
    smpm::published_tables::CASE,
    smpm::edges::CASE,
    smpm::paper_size::CASE,
    smpm::invariance::CASE,
    peridyn::forces::CASE,
    peridyn::equilibrium::CASE,
    peridyn::nonlinear_equilibrium::CASE,
    peridyn::one_bond::CASE,
    peridyn::breaking::LATTICE,
    peridyn::breaking::BACKGROUND,
    peridyn::lattice::CASE,
    peridyn::rest::CASE,
    peridyn::dispersion::CASE,
    peridyn::memory::CASE,
    peridyn::note::CASE,
    peridyn::kalthoff_winkler::CASE,
    peridyn::branching::CASE,
    peridyn::two_notches::CASE,
    peridyn::notched_plate::CASE,
    peridyn::horizon_inference::CASE,
    peridyn::inference::CASE,
    peridyn::precracked_block::CASE,
    smoothing_kernels::CASE,
    neighbour_search::CASE,
    particle_store::CASE,
    estimators::multilevel::COST,
    estimators::multilevel::LADDERS,
    estimators::coverage::CASE,
    estimators::sensitivity::CASE,
    perturbation_moments::reference::CASE,
    perturbation_moments::trust::CASE,
    perturbation_moments::judge::CASE,
    sde::normals::CASE,
    sde::orders::ADDITIVE,
    sde::orders::DIAGONAL,
    sde::orders::SECOND_ORDER,
    sde::stationary::CASE,
    sde::oscillator_limits::CASE,
    sde::mean_square::CASE,
    sde::quartic::CASE,
    sde::explosion::CASE,
    sde::oscillator_bias::CASE,
    sde::oscillator_ensemble::CASE,
    sde::fields::CASE,
    sde::refinement::CASE,
    sde_ensembles::reproducibility::CASE,
    sde_ensembles::failures::CASE,
    sde_ensembles::first_passage::CASE,
    sde_ensembles::rare_events::CASE,
    resume::CASE,
    ranks::CASE,
    advice::CASE,
];
