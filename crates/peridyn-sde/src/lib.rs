#![doc = include_str!("../README.md")]

mod body;
mod bond_config;
mod bonds;
mod broken_bond;
mod compiled;
mod config;
mod crossing;
mod cut;
mod disorder;
mod elasticity;
mod ensemble;
mod equilibrium;
mod error;
mod failure;
mod fast;
mod horizon;
mod kicks;
pub mod law;
mod linear_pull;
mod loading;
mod mobility;
mod motion;
mod network;
mod nodes;
mod note;
mod path;
mod real;
mod report;
mod resistance;
mod saved;
mod scheme;
mod simulation;
mod solid;
pub mod statistics;
mod steps;
mod stiffest;
mod strain;
mod surface;
mod swing;
mod weakest_link;

pub use body::{AtStrength, Body};
pub use bond_config::{BondConfig, VolumeCorrection};
pub use bonds::{Bond, Bonds};
pub use broken_bond::{BrokenBond, Cause};
pub use config::{Breaking, SimulationConfig};
pub use crossing::Crossing;
pub use disorder::{BondValue, DisorderField, between_nodes, from_column};
pub use elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use ensemble::{
    BondOrder, BrokenInStep, CrackRun, CrackShard, CrackStudy, FinalState, GroupProgress,
    HaltedRun, Procedure, RunOutcome, Stiffness, Strength, StudyLaw, merge_shards,
};
pub use equilibrium::{
    Breakage, EquilibriumConfig, LoadStep, NextBreakage, QuasiStatic, Solved, envelope,
};
pub use error::Error;
pub use fast::{BondList, LatticeBody, SolidLattice, SolidList};
pub use horizon::Horizon;
pub use law::BondLaw;
pub use loading::{Loading, Program};
pub use mobility::{CorrelatedMobility, DisplacementNoise, Mobility};
pub use network::Network;
pub use nodes::Nodes;
pub use note::NoteAsPrinted;
pub use path::{Branch, CrackPath, Fractured, Notch, PathConfig, crack_path};
pub use real::Real;
pub use report::{BrokenAt, StepReport};
pub use saved::SavedState;
pub use scheme::{Dynamics, Scheme};
pub use simulation::Simulation;
pub use solid::{SolidBonds, critical_stretch_of_solid};
pub use strain::Strain;
pub use surface::SurfaceCorrection;
pub use weakest_link::{StrengthElement, WeibullByVolume, WeibullStrength};
