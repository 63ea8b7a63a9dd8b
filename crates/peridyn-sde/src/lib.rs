#![doc = include_str!("../README.md")]

mod bodies;
mod breaking;
mod compiled;
mod dynamics;
mod ensemble;
mod equilibrium;
mod error;
mod fast;
pub mod law;
mod material;
mod mobility;
mod path;
mod real;
mod solid;
pub mod statistics;
mod steps;

pub use bodies::body::{AtStrength, Body};
pub use bodies::bond_config::{BondConfig, VolumeCorrection};
pub use bodies::bonds::{Bond, Bonds};
pub use bodies::network::Network;
pub use bodies::nodes::Nodes;
pub use bodies::note::NoteAsPrinted;
pub use bodies::surface::SurfaceCorrection;
pub use breaking::broken_bond::{BrokenBond, Cause};
pub use breaking::crossing::Crossing;
pub use dynamics::config::{Breaking, SimulationConfig};
pub use dynamics::loading::{Loading, Program};
pub use dynamics::report::{BrokenAt, StepReport};
pub use dynamics::saved::SavedState;
pub use dynamics::scheme::{Dynamics, Scheme};
pub use dynamics::simulation::Simulation;
pub use ensemble::{
    BondOrder, BrokenInStep, CrackRun, CrackShard, CrackStudy, FinalState, GroupProgress,
    HaltedRun, Procedure, RunOutcome, Stiffness, Strength, StudyLaw, merge_shards,
};
pub use equilibrium::{
    Breakage, EquilibriumConfig, LoadStep, NextBreakage, QuasiStatic, Solved, envelope,
};
pub use error::Error;
pub use fast::{BondList, LatticeBody, SolidLattice, SolidList};
pub use law::BondLaw;
pub use material::disorder::{BondValue, DisorderField, between_nodes, from_column};
pub use material::elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use material::horizon::Horizon;
pub use material::strain::Strain;
pub use material::weakest_link::{StrengthElement, WeibullByVolume, WeibullStrength};
pub use mobility::{CorrelatedMobility, DisplacementNoise, Mobility};
pub use path::{Branch, CrackPath, Fractured, Notch, PathConfig, crack_path};
pub use real::Real;
pub use solid::{SolidBonds, critical_stretch_of_solid};
