//! What is claimed of each crate.
//!
//! A case is one file here and one line in [`ALL`].

mod advice;
mod estimates;
mod estimators;
mod fpk;
mod peridyn;
mod prelude;
mod random_scenes;
mod ranks;
mod resume;
mod scene_result;
mod sde;
mod smpm;
mod worst;

use crate::case::Case;

/// Every case, in the order in which the table is printed.
pub const ALL: &[Case] = &[
    fpk::viscous_damper::CASE,
    fpk::linear_oscillator::CASE,
    fpk::gaussian_mixture::CASE,
    fpk::bouc_wen::COARSE,
    fpk::bouc_wen::CASE,
    fpk::bouc_wen_paper::CASE,
    fpk::filtered::DAMPER,
    fpk::filtered::BOUC_WEN,
    fpk::conditioned::CASE,
    fpk::linear_systems::CASE,
    fpk::linear_systems::KANAI_TAJIMI,
    fpk::known_densities::CASE,
    fpk::effectivity::CASE,
    fpk::stated_errors::CASE,
    fpk::four_states::CASE,
    fpk::first_passage::DAMPER,
    fpk::first_passage::CROSSINGS,
    fpk::first_passage::BOUC_WEN,
    fpk::first_passage::FRAGILITY,
    fpk::bouc_wen::REMAPPED,
    fpk::viscous_damper::REMAPPED,
    fpk::stationary_oscillators::DUFFING,
    fpk::stationary_oscillators::VAN_DER_POL,
    fpk::canor_denoel::CASE,
    fpk::monte_carlo::CASE,
    fpk::rivals::CASE,
    fpk::guided_paths::CASE,
    fpk::shear_building::CASE,
    fpk::passage_benchmarks::CASE,
    fpk::reliability_benchmarks::CASE,
    fpk::spatial_order::CASE,
    smpm::elastic_bar::CASE,
    smpm::disks::CASE,
    smpm::shock_tubes::CASE,
    smpm::plate_impact::CASE,
    smpm::detonation::CASE,
    smpm::taylor_bar::AXISYMMETRIC,
    smpm::taylor_bar::QUARTER,
    smpm::taylor_bar::BENCHMARK,
    smpm::taylor_bar::PREDICTED,
    smpm::contact_explosion::DIFFERENCES,
    smpm::contact_explosion::SAMPLES,
    smpm::sobol_points::CASE,
    smpm::variance_fields::CASE,
    smpm::trust::CASE,
    smpm::random_fields::COLUMN,
    smpm::random_fields::PLATE,
    smpm::random_fields::TAYLOR_BAR,
    smpm::random_slope::FACTOR,
    smpm::random_slope::PROBABILITY,
    smpm::multilevel::COLUMN,
    smpm::multilevel::EXPLOSION,
    smpm::refinement::CASE,
    smpm::published_tables::CASE,
    smpm::edges::CASE,
    smpm::paper_size::CASE,
    peridyn::equilibrium::CASE,
    peridyn::nonlinear_equilibrium::CASE,
    peridyn::one_bond::CASE,
    peridyn::breaking::LATTICE,
    peridyn::breaking::BACKGROUND,
    peridyn::kalthoff_winkler::CASE,
    peridyn::branching::CASE,
    peridyn::two_notches::CASE,
    peridyn::notched_plate::CASE,
    peridyn::lattice_locking::CASE,
    peridyn::horizon_inference::CASE,
    peridyn::inference::CASE,
    peridyn::infer_scene::CASE,
    peridyn::precracked_block::CASE,
    peridyn::weibull_strength::CASE,
    peridyn::quasi_static::CASE,
    peridyn::slow_scenes::CASE,
    peridyn::concrete::CASE,
    estimators::multilevel::CASE,
    estimators::coverage::CASE,
    estimators::rare_events::CASE,
    estimators::random_field_beam::CASE,
    sde::orders::ADDITIVE,
    sde::orders::DIAGONAL,
    sde::orders::SECOND_ORDER,
    sde::mean_square::CASE,
    sde::quartic::CASE,
    sde::explosion::CASE,
    sde::oscillator_bias::CASE,
    sde::oscillator_ensemble::CASE,
    random_scenes::CASE,
    resume::CASE,
    ranks::CASE,
    advice::CASE,
];
