//! What an ensemble of cracks is of.

use crate::bonds::Bonds;
use crate::config::SimulationConfig;
use crate::disorder::{BondValue, DisorderField};
use crate::loading::Loading;
use crate::nodes::Nodes;
use crate::path::{Notch, PathConfig};
use crate::strain::Strain;
use crate::weakest_link::WeibullStrength;

/// The stretches at which bonds break.
#[derive(Debug, Clone, Copy)]
pub enum Strength<'a> {
    /// One for all.
    Uniform(f64),
    /// From a field of its own in each realisation.
    Field {
        /// The critical stretch at the nodes.
        field: &'a DisorderField,
        /// Between them.
        value: BondValue,
    },
    /// From values at the nodes that are given, the same in each realisation.
    Given {
        /// The critical stretch at the nodes.
        values: &'a [f64],
        /// Between them.
        value: BondValue,
    },
    /// Independent strengths of bonds, nodes or blocks, by their volumes; others in each realisation.
    Weibull(&'a WeibullStrength),
}

/// Factors on the stiffness of bonds.
#[derive(Debug, Clone, Copy)]
pub enum Stiffness<'a> {
    /// One.
    Uniform,
    /// From a field of its own in each realisation.
    Field {
        /// The factor at the nodes, of mean one.
        field: &'a DisorderField,
        /// Between them.
        value: BondValue,
    },
    /// From factors at the nodes that are given, the same in each realisation.
    Given {
        /// The factor at the nodes.
        values: &'a [f64],
        /// Between them.
        value: BondValue,
    },
}

/// A tension-test ensemble of one notched body: each realisation has its own noise or field of strength.
///
/// The numbers of a realisation follow from the seed and its own number alone: not from how many there are, which run side by
/// side, or how many threads run them.
#[derive(Debug, Clone, Copy)]
pub struct CrackStudy<'a> {
    /// The nodes.
    pub nodes: &'a Nodes<2>,
    /// The bonds.
    pub bonds: &'a Bonds,
    /// How strains are measured.
    pub strain: Strain,
    /// When bonds break.
    pub strength: Strength<'a>,
    /// How stiff they are, over their mean. A field of stiffness bends the stresses on the length of its correlation; a smooth
    /// field of strength turns a crack only by what one horizon sees of it.
    pub stiffness: Stiffness<'a>,
    /// Nodes whose bonds never break, such as those near prescribed edges.
    pub no_fail: &'a [usize],
    /// The notch that cracks are followed from; it is cut in.
    pub notch: Notch,
    /// What is done to the body.
    pub loading: &'a Loading<2>,
    /// How it moves.
    pub simulation: &'a SimulationConfig,
    /// Steps of each realisation.
    pub n_steps: u64,
    /// Load measurement: prescribed nodes, and the component of the force.
    pub load: (&'a [usize], usize),
    /// Load is averaged over so many windows of equal length, without the remainder of the steps; the largest mean is the failure
    /// load.
    pub n_windows: u64,
    /// What counts as a crack.
    pub path: PathConfig,
    /// The abscissa at which a crack leaves the body (length).
    pub border: f64,
    /// Damage from which a node counts as damaged in the map.
    pub damage_threshold: f64,
}
