#![doc = include_str!("../README.md")]

mod blocks;
mod chacha;
mod cholesky;
mod components;
mod dense_factor;
mod diagonal;
mod ensemble;
mod error;
mod estimate;
mod euler_maruyama;
mod follow;
mod guide;
mod guided;
mod guided_group;
mod guided_watch;
mod heun;
mod integrator;
mod lane_increments;
mod lane_normals;
mod lane_paths;
mod lane_sde;
mod law;
mod linear_solve;
mod maximum;
mod milstein;
mod noise;
mod noise_factor;
mod normal;
mod normal_distribution;
mod rare;
mod samples;
mod schedule;
mod semi_implicit_euler;
mod shard;
mod shark;
mod sra3;
mod sriw1;
mod state_space;
mod strang_oscillator;
mod stratonovich;
mod system;
mod tally;
mod theta;

pub use blocks::{BLOCK_LENGTH, reduce_blocks, reduce_in_tree};
pub use cholesky::{Cholesky, SmallPivot, small_cholesky};
pub use dense_factor::DenseFactor;
pub use diagonal::{DiagonalNoise, DiagonalSde, StratonovichForm, check_diagonal_noise};
pub use ensemble::{Ensemble, Study, simulate};
pub use error::{Error, StepError};
pub use estimate::{Accumulator, Estimate, Uncertainty};
pub use euler_maruyama::EulerMaruyama;
pub use guide::Guide;
pub use guided::{GuidedEnsemble, GuidedPath, Passage, Passages};
pub use heun::Heun;
pub use integrator::{Integrator, Joints};
pub use lane_increments::{LANES, LaneIncrements};
pub use lane_normals::LaneNormals;
pub use lane_paths::{LanePaths, SmallPaths};
pub use lane_sde::{DrivenLanes, LaneSde, PairTerm, PairwiseSde, WongZakai};
pub use law::{GaussianComponent, GaussianMixture, InitialDistribution};
pub use maximum::{Between, Response, Side, maxima};
pub use milstein::Milstein;
pub use noise::{Increment, Noise, PathNoise, Purpose, Stream, WORDS_PER_PAIR};
pub use noise_factor::{DiagonalFactor, LowRankFactor, NoiseFactor, SparseFactor};
pub use normal_distribution::{normal_probability, normal_quantile};
pub use rare::{
    DesignPoint, DrivenPath, NormalResponse, SubsetConfig, design_point, importance_sampling,
    subset_simulation,
};
pub use samples::Samples;
pub use schedule::EnsembleConfig;
pub use semi_implicit_euler::SemiImplicitEuler;
pub use shard::{FailedPath, Outcome, ShardRecord, merge, merge_so_far};
pub use shark::Shark;
pub use simd_lanes::SimdLevel;
pub use sra3::Sra3;
pub use sriw1::Sriw1;
pub use state_space::StateSpace;
pub use strang_oscillator::{LinearFlows, StrangOscillator};
pub use stratonovich::{ItoForm, StratonovichSde};
pub use system::{
    Additive, General, NoiseClass, Sde, SecondOrder, check_diffusion_divergence, linear_part_of,
};
pub use tally::Observable;
pub use theta::StochasticTheta;
