#![doc = include_str!("../README.md")]

mod bodies;
mod breaking;
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
pub use dynamics::report::StepReport;
pub use dynamics::saved::SavedState;
pub use dynamics::scheme::{Dynamics, Scheme};
pub use dynamics::simulation::Simulation;
pub use ensemble::{
    BondOrder, BrokenInStep, CrackRun, CrackStudy, FinalState, GroupProgress, HaltedRun, Precision,
    Procedure, RunOutcome, Stiffness, Strength, StudyLaw,
};
pub use equilibrium::{Breakage, EquilibriumConfig, NextBreakage, QuasiStatic, Solved, envelope};
pub use error::{Error, Requirement};
pub use fast::{BondList, LatticeBody};
pub use law::BondLaw;
pub use material::disorder::{BondValue, DisorderField, between_nodes};
pub use material::elasticity::{Condition, Influence, critical_stretch, micromodulus};
pub use material::horizon::Horizon;
pub use material::strain::Strain;
pub use material::weakest_link::{StrengthElement, WeibullByVolume, WeibullStrength};
pub use mobility::{CorrelatedMobility, Mobility};
pub use path::{Branch, CrackPath, Fractured, Notch, PathConfig, crack_path};
pub use real::Real;
pub use solid::{SolidBonds, critical_stretch_of_solid};
