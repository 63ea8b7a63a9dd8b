#![doc = include_str!("../README.md")]

mod blocks;
mod diagonal;
mod ensembles;
mod error;
mod estimate;
mod integrator;
mod law;
mod methods;
mod noise;
mod state_space;
mod stratonovich;
mod system;

pub use blocks::{BLOCK_LENGTH, reduce_blocks, reduce_in_tree};
pub use diagonal::{DiagonalNoise, DiagonalSde, StratonovichForm, check_diagonal_noise};
pub use ensembles::ensemble::{Ensemble, Study, simulate};
pub use ensembles::guide::Guide;
pub use ensembles::guided::{GuidedEnsemble, GuidedPath, Passage, Passages};
pub use ensembles::maximum::{Between, Response, Side, maxima};
pub use ensembles::rare::{DrivenPath, NormalResponse, SubsetConfig, subset_simulation};
pub use ensembles::samples::Samples;
pub use ensembles::schedule::EnsembleConfig;
pub use ensembles::shard::{FailedPath, Outcome, ShardRecord, merge, merge_so_far};
pub use ensembles::step_halving::StepDifference;
pub use ensembles::tally::Observable;
pub use error::{Error, StepError};
pub use estimate::{Accumulator, Estimate, Uncertainty};
pub use integrator::{Integrator, Joints};
pub use law::{GaussianComponent, GaussianMixture, InitialDistribution};
pub use methods::euler_maruyama::EulerMaruyama;
pub use methods::heun::Heun;
pub use methods::lane_paths::{LanePaths, SmallPaths};
pub use methods::lane_sde::{DrivenLanes, LaneSde, PairTerm, PairwiseSde, WongZakai};
pub use methods::milstein::Milstein;
pub use methods::semi_implicit_euler::SemiImplicitEuler;
pub use methods::shark::Shark;
pub use methods::sra3::Sra3;
pub use methods::sriw1::Sriw1;
pub use methods::strang_oscillator::{LinearFlows, StrangOscillator};
pub use methods::theta::StochasticTheta;
pub use noise::cholesky::{Cholesky, SmallPivot, small_cholesky};
pub use noise::dense_factor::DenseFactor;
pub use noise::lane_increments::{LANES, LaneIncrements};
pub use noise::lane_normals::LaneNormals;
pub use noise::noise_factor::{DiagonalFactor, LowRankFactor, NoiseFactor, SparseFactor};
pub use noise::normal_distribution::{normal_probability, normal_quantile, student_quantile};
pub use noise::streams::{Increment, Noise, PathNoise, Purpose, Stream, WORDS_PER_PAIR};
pub use simd_lanes::SimdLevel;
pub use state_space::StateSpace;
pub use stratonovich::{ItoForm, StratonovichSde};
pub use system::{
    Additive, General, NoiseClass, Sde, SecondOrder, check_diffusion_divergence, linear_part_of,
};
