//! The linear peridynamic solid as a body: the reference path.

use super::bonds::SolidBonds;
use crate::body::{AtStrength, Body, test_all};
use crate::bonds::Bonds;
use crate::broken_bond::{BrokenBond, Cause};
use crate::crossing::Crossing;
use crate::error::{Error, positive, same_length};
use crate::nodes::Nodes;
use crate::strain::Strain;

/// When a bond breaks; one number for each bond, in the order of [`Bonds::all`].
#[derive(Debug, Clone, PartialEq)]
pub enum BondFailure {
    /// At a stretch, in tension alone, as bonds of a pair potential. Its rate in noise depends on the displacements of both ends
    /// alone, so that the bridge test between steps holds as it does for these.
    Stretch(Vec<f64>),
    /// At a work for each unit of volume at both ends (energy over length to the sixth), in tension alone (Foster, Silling & Chen
    /// 2011):
    ///
    /// $$ w = \int \frac{t}{\beta V_i V_j} de $$
    ///
    /// over the history of the bond, by the trapezoidal rule from step to step. It depends on all bonds of both ends and on the
    /// path. There is no probability of crossing between the ends of a step given both, so that
    /// [`Breaking::Bridge`](crate::Breaking::Bridge) is refused.
    Energy(Vec<f64>),
}

/// A body of a linear peridynamic solid, whose law is that of [`SolidBonds`]. One realisation, in `f64`, without registers: the
/// reference of [`SolidLattice`](crate::SolidLattice), and the body of unequal nodes, strengths, and of failure by energy.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidNetwork<const D: usize> {
    nodes: Nodes<D>,
    solid: SolidBonds,
    strain: Strain,
    failure: BondFailure,
    intact: Vec<bool>,
    /// Done on each bond, where it breaks by energy.
    work: Vec<f64>,
}

/// A bond as deformed.
struct Deformed<const D: usize> {
    stretch: f64,
    /// From the first node to the second, of length one.
    direction: [f64; D],
}

impl<const D: usize> SolidNetwork<D> {
    /// A body at rest, unbroken.
    ///
    /// # Errors
    /// [`Error::Length`] where nodes, bonds and strengths are not of one body; [`Error::NotPositive`] for a strength.
    pub fn new(
        nodes: Nodes<D>,
        solid: SolidBonds,
        strain: Strain,
        failure: BondFailure,
    ) -> Result<Self, Error> {
        let bonds = solid.bonds();
        same_length("nodes", nodes.positions().len(), bonds.n_nodes())?;
        let (name, strengths) = match &failure {
            BondFailure::Stretch(strengths) => ("strength of a bond", strengths),
            BondFailure::Energy(energies) => ("critical energy of a bond", energies),
        };
        same_length("strengths", strengths.len(), bonds.len())?;
        for &strength in strengths {
            positive(name, strength)?;
        }
        let work = match failure {
            BondFailure::Stretch(_) => Vec::new(),
            BondFailure::Energy(_) => vec![0.0; bonds.len()],
        };
        let intact = vec![true; bonds.len()];
        Ok(Self { nodes, solid, strain, failure, intact, work })
    }

    /// The dilatation `theta` of each node under displacements (length).
    ///
    /// # Errors
    /// Those of the forces.
    pub fn dilatations(&self, u: &[[f64; D]]) -> Result<Vec<f64>, Error> {
        let mut sums = self.sums(&self.deformed(u, self.strain)?);
        let of_nodes = self.nodes.volumes().iter().zip(self.solid.weighted_volumes());
        for (sum, (volume, m)) in sums.iter_mut().zip(of_nodes) {
            *sum *= D as f64 / (volume * m);
        }
        Ok(sums)
    }

    /// The energy `V_i W_i` of each node under displacements (length).
    ///
    /// # Errors
    /// Those of the forces.
    pub fn energies(&self, u: &[[f64; D]]) -> Result<Vec<f64>, Error> {
        Ok(self.energies_of(&self.deformed(u, self.strain)?))
    }

    fn energies_of(&self, deformed: &[Option<Deformed<D>>]) -> Vec<f64> {
        let (bonds, m) = (self.solid.bonds(), self.solid.weighted_volumes());
        let mut energies = self.sums(deformed);
        for (energy, n) in energies.iter_mut().zip(self.solid.nodal()) {
            *energy = 0.5 * n * *energy * *energy;
        }
        for (((i, j), of), now) in bonds.pairs().zip(bonds.all()).zip(deformed) {
            if let Some(now) = now {
                // The part of either end is inverse to its weighted volume.
                let energy = 0.5 * of.stiffness * of.length * now.stretch * now.stretch;
                energies[i] += energy * m[j] / (m[i] + m[j]);
                energies[j] += energy * m[i] / (m[i] + m[j]);
            }
        }
        energies
    }

    /// The work done on each bond (energy) where bonds break by energy, otherwise empty.
    #[must_use]
    pub fn work(&self) -> &[f64] {
        &self.work
    }

    /// The intact bonds; `None` for the others.
    fn deformed(&self, u: &[[f64; D]], strain: Strain) -> Result<Vec<Option<Deformed<D>>>, Error> {
        same_length("displacements", u.len(), self.nodes.positions().len())?;
        for (node, u) in u.iter().enumerate() {
            if let Some(&value) = u.iter().find(|c| !c.is_finite()) {
                return Err(Error::Node { name: "a displacement", node, value, must: "finite" });
            }
        }
        let of = |(bond, (i, j)): (usize, (usize, usize))| {
            if !self.intact[bond] {
                return Ok(None);
            }
            let (x, r) = (self.nodes.positions(), self.solid.bonds().all()[bond].length);
            let (mut now, mut elongation, mut square) = ([0.0; D], 0.0, 0.0);
            for k in 0..D {
                let (xi, eta) = (x[j][k] - x[i][k], u[j][k] - u[i][k]);
                now[k] = if strain == Strain::Linear { xi } else { xi + eta };
                elongation += eta * (xi + now[k]);
                square += now[k] * now[k];
            }
            let length = square.sqrt();
            if length <= 0.0 {
                return Err(Error::Coincident { first: i, second: j });
            }
            // With linear strains the length is r, but for roundoff.
            let stretch = elongation / (r * (r + length));
            Ok(Some(Deformed { stretch, direction: now.map(|c| c / length) }))
        };
        self.solid.bonds().pairs().enumerate().map(of).collect()
    }

    /// `sum omega beta V_i V_j |xi| e` of each node.
    fn sums(&self, deformed: &[Option<Deformed<D>>]) -> Vec<f64> {
        let bonds = self.solid.bonds();
        let mut sums = vec![0.0; bonds.n_nodes()];
        for (bond, ((i, j), now)) in bonds.pairs().zip(deformed).enumerate() {
            if let Some(now) = now {
                let length = bonds.all()[bond].length;
                let part = self.solid.weights()[bond] * length * length * now.stretch;
                sums[i] += part;
                sums[j] += part;
            }
        }
        sums
    }

    /// The tension of a bond, given the sums of its ends.
    fn tension(&self, (i, j): (usize, usize), bond: usize, stretch: f64, sums: &[f64]) -> f64 {
        let (of, n) = (self.solid.bonds().all()[bond], self.solid.nodal());
        let of_dilatation = n[i] * sums[i] + n[j] * sums[j];
        of.stiffness * stretch + self.solid.weights()[bond] * of.length * of_dilatation
    }

    fn add_forces(&self, deformed: &[Option<Deformed<D>>], forces: &mut [[f64; D]]) {
        let sums = self.sums(deformed);
        forces.fill([0.0; D]);
        for (bond, ((i, j), now)) in self.solid.bonds().pairs().zip(deformed).enumerate() {
            let Some(Deformed { stretch, direction }) = now else { continue };
            let tension = self.tension((i, j), bond, *stretch, &sums);
            for k in 0..D {
                forces[i][k] += tension * direction[k];
                forces[j][k] -= tension * direction[k];
            }
        }
    }

    /// Takes the work of each bond over a step and adds the bonds that break to a list.
    fn advance_work(
        &mut self,
        [from, to]: [&[[f64; D]]; 2],
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        let BondFailure::Energy(critical) = &self.failure else { return Ok(()) };
        let (before, after) = (self.deformed(from, self.strain)?, self.deformed(to, self.strain)?);
        let sums = [self.sums(&before), self.sums(&after)];
        let (bonds, volumes) = (self.solid.bonds(), self.solid.volumes());
        let mut work = std::mem::take(&mut self.work);
        for (bond, (pair, of)) in bonds.pairs().zip(bonds.all()).enumerate() {
            let (Some(before), Some(after)) = (&before[bond], &after[bond]) else { continue };
            let tension = self.tension(pair, bond, before.stretch, &sums[0])
                + self.tension(pair, bond, after.stretch, &sums[1]);
            work[bond] += 0.5 * tension * of.length * (after.stretch - before.stretch);
            if after.stretch > 0.0 && work[bond] >= critical[bond] * volumes[bond] {
                broken.push(BrokenBond { bond, lanes: 1, cause: Cause::Energy });
            }
        }
        self.work = work;
        Ok(())
    }
}

impl<const D: usize> Body<f64, D, 1> for SolidNetwork<D> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        self.solid.bonds()
    }

    fn forces(&mut self, u: &[f64], forces: &mut [f64], at: AtStrength<'_>) -> Result<(), Error> {
        same_length("displacements", u.len(), self.nodes.positions().len() * D)?;
        same_length("forces", forces.len(), u.len())?;
        let mut deformed = self.deformed(u.as_chunks().0, self.strain)?;
        if let (AtStrength::Break(reached), BondFailure::Stretch(strengths)) = (at, &self.failure) {
            for (bond, (now, &strength)) in deformed.iter_mut().zip(strengths).enumerate() {
                if now.take_if(|now| now.stretch >= strength).is_some() {
                    reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                }
            }
        }
        self.add_forces(&deformed, forces.as_chunks_mut().0);
        Ok(())
    }

    fn intact(&self, bond: usize) -> u16 {
        u16::from(self.intact[bond])
    }

    /// A bond that is made intact again has had no work done on it.
    fn set_intact(&mut self, bond: usize, lanes: u16) {
        let is_intact = lanes & 1 != 0;
        if let Some(work) = self.work.get_mut(bond)
            && is_intact
            && !self.intact[bond]
        {
            *work = 0.0;
        }
        self.intact[bond] = is_intact;
    }

    fn strain(&self) -> Strain {
        self.strain
    }

    fn strength(&self, bond: usize, _lane: usize) -> f64 {
        match &self.failure {
            BondFailure::Stretch(strengths) => strengths[bond],
            BondFailure::Energy(_) => f64::INFINITY,
        }
    }

    fn energy(&self, u: &[f64], _lane: usize) -> f64 {
        let Ok(deformed) = self.deformed(u.as_chunks().0, self.strain) else { return f64::NAN };
        self.energies_of(&deformed).iter().sum()
    }

    fn linear_forces(&mut self, v: &[f64], forces: &mut [f64]) -> Result<(), Error> {
        same_length("displacements", v.len(), self.nodes.positions().len() * D)?;
        same_length("forces", forces.len(), v.len())?;
        let deformed = self.deformed(v.as_chunks().0, Strain::Linear)?;
        self.add_forces(&deformed, forces.as_chunks_mut().0);
        Ok(())
    }

    fn has_memory(&self) -> bool {
        matches!(self.failure, BondFailure::Energy(_))
    }

    fn check_bridge(&self) -> Result<(), Error> {
        match self.failure {
            BondFailure::Stretch(_) => Ok(()),
            BondFailure::Energy(_) => Err(Error::NoBridgeOfEnergy),
        }
    }

    fn advance(
        &mut self,
        from: &[f64],
        to: &[f64],
        _dt: f64,
        crossing: Option<&mut Crossing<1>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        match crossing {
            Some(crossing) => test_all(self, crossing, (from, to), broken),
            None => self.advance_work([from, to].map(|u| u.as_chunks().0), broken)?,
        }
        Ok(())
    }
}
