//! What an ensemble of cracks is of.

use sde_integrators::Noise;

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::dynamics::config::SimulationConfig;
use crate::dynamics::loading::Loading;
use crate::equilibrium::EquilibriumConfig;
use crate::law::Bilinear;
use crate::material::disorder::{BondValue, DisorderField};
use crate::material::strain::Strain;
use crate::material::weakest_link::WeibullStrength;
use crate::path::{Notch, PathConfig};
use crate::solid::SolidBonds;

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

/// How bonds pull.
#[derive(Debug, Clone, Copy)]
pub enum StudyLaw<'a> {
    /// A pair potential; a bond breaks at its strength.
    BondBased,
    /// A pair potential; a bond softens from its strength on. With [`Procedure::QuasiStatic`] alone, and a uniform stiffness. A
    /// bond counts as broken once it has lost nine tenths of its stiffness.
    Softening(Bilinear),
    /// A linear peridynamic solid, of a uniform stiffness; a bond breaks at its strength.
    LinearSolid(&'a SolidBonds),
}

/// How the bonds of a body are visited: both ways have the same forces within roundoff, and so the same cracks but where roundoff
/// decides which bond breaks first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BondOrder {
    /// In a list, any body: realisations side by side in the lanes of registers, as many as fill one.
    List,
    /// Along the rows of a lattice, one realisation after the other: in one realisation 3 to 6 times as fast as a list, in as many as
    /// fill a register as fast as these. For a uniform stiffness.
    Lattice,
}

/// The precision of the numbers of a study in time, and how many realisations of a list run side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// `f64`, 8 realisations side by side.
    Double,
    /// `f32`, 16 realisations side by side.
    Single,
}

/// How the load is applied.
#[derive(Debug, Clone, Copy)]
pub enum Procedure<'a> {
    /// In time, by steps of the equations of motion.
    Dynamic {
        /// How the body moves.
        simulation: &'a SimulationConfig,
        /// Steps of each realisation.
        n_steps: u64,
    },
    /// Quasi-static: equilibrium after equilibrium, event by event (sequentially linear analysis, Rots 2001), by
    /// [`QuasiStatic`](crate::QuasiStatic). Strains are taken for small, and displacements are proportional to a load factor, the time
    /// of the loading. A realisation ends where a test that prescribes the displacement would come to the last factor, or with
    /// the separation of the body.
    QuasiStatic {
        /// How equilibria are found.
        config: EquilibriumConfig,
        /// The last load factor.
        until: f64,
        /// Equal parts of that, by whose number the failure of a bond is recorded in place of its step.
        n_steps: u64,
        /// Noise of the random fields.
        noise: Noise,
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
    /// The bonds; of a linear peridynamic solid its [`SolidBonds::bonds`].
    pub bonds: &'a Bonds,
    /// How they pull.
    pub law: StudyLaw<'a>,
    /// How their bonds are visited. Bonds that soften have a list.
    pub order: BondOrder,
    /// The precision of its numbers; under a quasi-static load they are `f64` whatever it is.
    pub precision: Precision,
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
    /// How the load is applied.
    pub procedure: Procedure<'a>,
    /// Load measurement: prescribed nodes, and the component of the force.
    pub load: (&'a [usize], usize),
    /// Load is averaged over so many windows of equal length, without the remainder of the steps, by the trapezoidal rule; the
    /// largest mean is the failure load. A load is positive where the body resists the displacement prescribed there. Under a
    /// quasi-static load it is that at the end of each window, and the failure load the largest of all.
    pub n_windows: u64,
    /// What counts as a crack.
    pub path: PathConfig,
    /// The abscissa at which a crack leaves the body (length).
    pub border: f64,
    /// Damage from which a node counts as damaged in the map.
    pub damage_threshold: f64,
}

impl CrackStudy<'_> {
    /// The noise of random fields, and of the motion.
    pub(super) fn noise(&self) -> &Noise {
        match &self.procedure {
            Procedure::Dynamic { simulation, .. } => &simulation.noise,
            Procedure::QuasiStatic { noise, .. } => noise,
        }
    }

    /// Steps of each realisation, or parts of the last load factor.
    #[must_use]
    pub fn n_steps(&self) -> u64 {
        match self.procedure {
            Procedure::Dynamic { n_steps, .. } | Procedure::QuasiStatic { n_steps, .. } => n_steps,
        }
    }
}
