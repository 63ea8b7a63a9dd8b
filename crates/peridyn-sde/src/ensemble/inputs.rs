//! Strengths and stiffnesses of the bonds of realisations.

use super::study::{CrackStudy, Stiffness, Strength};
use crate::error::{Error, exists};
use crate::material::disorder::{DisorderField, between_nodes};

/// A stretch that no bond comes to.
const NEVER: f64 = 1e6;

/// Strengths of the realisations of a group.
pub(super) struct Strengths {
    /// Strengths of the bonds, lane by lane, or one for all.
    pub(super) of_bonds: Vec<Vec<f64>>,
    /// At the nodes, lane by lane; none where they are one.
    pub(super) at_nodes: Vec<Vec<f64>>,
}

impl CrackStudy<'_> {
    /// A field at the nodes, lane by lane.
    fn sample<const L: usize>(
        &self,
        field: &DisorderField,
        ids: [u64; L],
    ) -> Result<Vec<Vec<f64>>, Error> {
        ids.iter()
            .map(|&id| {
                let mut values = vec![0.0; self.nodes.positions().len()];
                field.sample(self.noise(), id, &mut values)?;
                Ok(values)
            })
            .collect()
    }

    /// The strengths of a group.
    pub(super) fn strengths<const L: usize>(&self, ids: [u64; L]) -> Result<Strengths, Error> {
        let (of_bonds, at_nodes) = match self.strength {
            Strength::Uniform(strength) => (vec![vec![strength; self.bonds.len()]], Vec::new()),
            Strength::Given { values, value } => {
                (vec![between_nodes(self.bonds, values, value)?], vec![values.to_vec(); L])
            }
            Strength::Field { field, value } => {
                let fields = self.sample(field, ids)?;
                let of = |field: &Vec<f64>| between_nodes(self.bonds, field, value);
                (fields.iter().map(of).collect::<Result<_, _>>()?, fields)
            }
            Strength::Weibull(weibull) => {
                let mut drawn = vec![vec![0.0; self.bonds.len()]; L];
                for (strengths, &id) in drawn.iter_mut().zip(&ids) {
                    weibull.sample(self.noise(), id, strengths)?;
                }
                let at_nodes =
                    drawn.iter().map(|of| weibull.weakest_at_nodes(self.bonds, of)).collect();
                (drawn, at_nodes)
            }
        };
        let of_bonds =
            of_bonds.into_iter().map(|of| self.protected(of)).collect::<Result<_, _>>()?;
        Ok(Strengths { of_bonds, at_nodes })
    }

    /// Factors of the bonds, lane by lane; none where they are all one.
    pub(super) fn stiffness_factors<const L: usize>(
        &self,
        ids: [u64; L],
    ) -> Result<Option<Vec<Vec<f64>>>, Error> {
        match self.stiffness {
            Stiffness::Uniform => Ok(None),
            Stiffness::Given { values, value } => {
                Ok(Some(vec![between_nodes(self.bonds, values, value)?; L]))
            }
            Stiffness::Field { field, value } => {
                let fields = self.sample(field, ids)?;
                let of = |field: &Vec<f64>| between_nodes(self.bonds, field, value);
                fields.iter().map(of).collect::<Result<_, _>>().map(Some)
            }
        }
    }

    /// Strengths with those of bonds that must not break out of reach.
    fn protected(&self, mut strengths: Vec<f64>) -> Result<Vec<f64>, Error> {
        let n = self.nodes.positions().len();
        let mut is_protected = vec![false; n];
        for &node in self.no_fail {
            exists("the number of a node", node, n)?;
            is_protected[node] = true;
        }
        for (strength, (i, j)) in strengths.iter_mut().zip(self.bonds.pairs()) {
            if is_protected[i] || is_protected[j] {
                *strength = NEVER;
            }
        }
        Ok(strengths)
    }
}
