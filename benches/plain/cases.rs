//! The cases, each with the step of the library and its baseline.

use peridyn_sde::{BondList, Condition, LatticeBody, Strain};
use smpm::material::{Fluid, Solid, StiffenedGas};

use crate::bonded;
use crate::case::Case;
use crate::fluid::Gas;
use crate::lattice::Lattice;
use crate::list::List;
use crate::material_points::{self, GAS};

/// Sums over nodes are in another order: roundoff, amplified in twenty steps by the stiffness of the material.
const ROUNDOFF: f64 = 1e-11;

/// Relative difference expected from roundoff.
///
/// The bond force is a polynomial in the library, within 8.4e-13 of the exact one (`Real::SERIES`). The hand-written
/// code takes a difference of two lengths, which loses three digits at these strains.
const BONDED_ROUNDOFF: f64 = 1e-11;

const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };

pub(crate) const CASES: [Case; 3] = [
    Case {
        name: "smpm-gas",
        what: "stiffened gas in plane strain, quadratic B-splines, FLIP",
        element: "particle",
        edges: [400, 100],
        ours: |edge| {
            let material = Solid { equation: StiffenedGas::new(GAS)?, strength: Fluid };
            Ok(Box::new(material_points::simulation(edge, material)?))
        },
        plain: |edge| Ok(Box::new(Gas::new(&material_points::body(edge)?))),
        tolerance: ROUNDOFF,
    },
    Case {
        name: "peridyn-list",
        what: "elastic block, bonds in a list, f64, velocity Verlet",
        element: "bond",
        edges: [31, 15],
        ours: |edge| {
            let (nodes, bonds) = bonded::body::<3>(edge, Condition::Solid)?;
            let strengths = vec![bonded::STRENGTH; bonds.len()];
            bonded::ours(BondList::<f64, 3, 1>::new(nodes, bonds, Strain::Finite, &strengths)?)
        },
        plain: |edge| {
            let (nodes, bonds) = bonded::body::<3>(edge, Condition::Solid)?;
            Ok(Box::new(List::new(&nodes, &bonds, &bonded::Start::of(&nodes))?))
        },
        tolerance: BONDED_ROUNDOFF,
    },
    Case {
        name: "peridyn-lattice",
        what: "elastic plate, bonds of a lattice, f64, velocity Verlet",
        element: "bond",
        edges: [100, 50],
        ours: |edge| {
            let (nodes, bonds) = bonded::body::<2>(edge, PLATE)?;
            bonded::ours(LatticeBody::<f64, 2>::new(
                nodes,
                bonds,
                Strain::Finite,
                bonded::STRENGTH,
            )?)
        },
        plain: |edge| {
            let (nodes, bonds) = bonded::body::<2>(edge, PLATE)?;
            let start = bonded::Start::of(&nodes);
            Ok(Box::new(Lattice::new((&nodes, edge as usize), &bonds, &start)?))
        },
        tolerance: BONDED_ROUNDOFF,
    },
];
