//! What must hold of every draw, law, method and ensemble.

mod custom_diagonal;
mod custom_integrator;
mod custom_lane_sde;
mod custom_stratonovich;
mod custom_system;
mod ensemble;
mod estimate;
mod factors;
mod guided;
mod initial_distribution;
mod methods;
mod moments;
mod noise;
mod passages;
mod stability;
mod step_halving;
mod studies;
mod system;
