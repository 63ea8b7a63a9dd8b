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
/// reference of [`SolidLattice`](crate::SolidLattice) and [`SolidList`](crate::SolidList), and the body of failure by energy.
#[derive(Debug, Clone)]
pub struct SolidNetwork<const D: usize> {
    nodes: Nodes<D>,
    solid: SolidBonds,
    strain: Strain,
    failure: BondFailure,
    intact: Vec<bool>,
    /// Done on each bond, where it breaks by energy.
    work: Vec<f64>,
    /// Of bonds and of nodes, in an evaluation of forces.
    stretches: Vec<f64>,
    sums: Vec<f64>,
}

/// The stretch of a bond that carries nothing, which none that does can have.
const NONE: f64 = f64::NEG_INFINITY;

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
        let (stretches, sums) = (Vec::new(), Vec::new());
        Ok(Self { nodes, solid, strain, failure, intact, work, stretches, sums })
    }

    /// The dilatation `theta` of each node under displacements (length).
    ///
    /// # Errors
    /// Those of the forces.
    pub fn dilatations(&self, u: &[[f64; D]]) -> Result<Vec<f64>, Error> {
        let mut sums = self.sums(&self.stretches(u)?);
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
        Ok(self.energies_of(&self.stretches(u)?))
    }

    fn energies_of(&self, stretches: &[f64]) -> Vec<f64> {
        let (bonds, m) = (self.solid.bonds(), self.solid.weighted_volumes());
        let mut energies = self.sums(stretches);
        for (energy, n) in energies.iter_mut().zip(self.solid.nodal()) {
            *energy = 0.5 * n * *energy * *energy;
        }
        for (((i, j), of), &stretch) in bonds.pairs().zip(bonds.all()).zip(stretches) {
            if stretch > NONE {
                // The part of either end is inverse to its weighted volume.
                let energy = 0.5 * of.stiffness * of.length * stretch * stretch;
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

    /// Of the intact bonds, [`NONE`] of the others.
    fn stretches(&self, u: &[[f64; D]]) -> Result<Vec<f64>, Error> {
        let mut stretches = Vec::new();
        self.find_stretches(u, self.strain, &mut stretches)?;
        Ok(stretches)
    }

    fn find_stretches(
        &self,
        u: &[[f64; D]],
        strain: Strain,
        stretches: &mut Vec<f64>,
    ) -> Result<(), Error> {
        let bonds = self.solid.bonds();
        same_length("displacements", u.len(), bonds.n_nodes())?;
        for (node, u) in u.iter().enumerate() {
            if let Some(&value) = u.iter().find(|c| !c.is_finite()) {
                return Err(Error::Node { name: "a displacement", node, value, must: "finite" });
            }
        }
        stretches.clear();
        let is_linear = strain == Strain::Linear;
        for i in 0..bonds.n_nodes() {
            for bond in bonds.row(i) {
                if !self.intact[bond] {
                    stretches.push(NONE);
                    continue;
                }
                let j = bonds.partner(bond);
                let (x, r) = (self.nodes.positions(), bonds.all()[bond].length);
                let (mut elongation, mut square) = (0.0, 0.0);
                for k in 0..D {
                    let (xi, eta) = (x[j][k] - x[i][k], u[j][k] - u[i][k]);
                    let now = if is_linear { xi } else { xi + eta };
                    elongation += eta * (xi + now);
                    square += now * now;
                }
                let length = square.sqrt();
                if length <= 0.0 {
                    return Err(Error::Coincident { first: i, second: j });
                }
                // With linear strains the length is r, but for roundoff.
                stretches.push(elongation / (r * (r + length)));
            }
        }
        Ok(())
    }

    /// `sum omega beta V_i V_j |xi| e` of each node.
    fn sums(&self, stretches: &[f64]) -> Vec<f64> {
        let mut sums = Vec::new();
        self.find_sums(stretches, &mut sums);
        sums
    }

    fn find_sums(&self, stretches: &[f64], sums: &mut Vec<f64>) {
        let bonds = self.solid.bonds();
        sums.clear();
        sums.resize(bonds.n_nodes(), 0.0);
        for i in 0..bonds.n_nodes() {
            let mut sum = 0.0;
            for bond in bonds.row(i).filter(|&bond| stretches[bond] > NONE) {
                let length = bonds.all()[bond].length;
                let part = self.solid.weights()[bond] * length * length * stretches[bond];
                sum += part;
                sums[bonds.partner(bond)] += part;
            }
            sums[i] += sum;
        }
    }

    /// The tension of a bond, given the sums of its ends.
    fn tension(&self, (i, j): (usize, usize), bond: usize, stretch: f64, sums: &[f64]) -> f64 {
        let (of, n) = (self.solid.bonds().all()[bond], self.solid.nodal());
        let of_dilatation = n[i] * sums[i] + n[j] * sums[j];
        of.stiffness * stretch + self.solid.weights()[bond] * of.length * of_dilatation
    }

    /// Forces by bonds of these stretches.
    fn find_forces(
        &self,
        (u, strain): (&[[f64; D]], Strain),
        (stretches, sums): (&[f64], &[f64]),
        forces: &mut [[f64; D]],
    ) {
        let (bonds, x) = (self.solid.bonds(), self.nodes.positions());
        let moved = if strain == Strain::Linear { 0.0 } else { 1.0 };
        forces.fill([0.0; D]);
        for i in 0..bonds.n_nodes() {
            let mut sum = [0.0; D];
            for bond in bonds.row(i).filter(|&bond| stretches[bond] > NONE) {
                let (j, stretch) = (bonds.partner(bond), stretches[bond]);
                let length = bonds.all()[bond].length * (1.0 + moved * stretch);
                let tension = self.tension((i, j), bond, stretch, sums) / length;
                for k in 0..D {
                    let now = x[j][k] - x[i][k] + moved * (u[j][k] - u[i][k]);
                    sum[k] += tension * now;
                    forces[j][k] -= tension * now;
                }
            }
            for k in 0..D {
                forces[i][k] += sum[k];
            }
        }
    }

    /// Forces under displacements; bonds at their strength carry none where they are to break.
    fn evaluate(
        &mut self,
        (u, strain): (&[f64], Strain),
        forces: &mut [f64],
        at: AtStrength<'_>,
    ) -> Result<(), Error> {
        same_length("displacements", u.len(), self.nodes.positions().len() * D)?;
        same_length("forces", forces.len(), u.len())?;
        let u = u.as_chunks().0;
        let (mut stretches, mut sums) =
            (std::mem::take(&mut self.stretches), std::mem::take(&mut self.sums));
        self.find_stretches(u, strain, &mut stretches)?;
        if let (AtStrength::Break(reached), BondFailure::Stretch(strengths)) = (at, &self.failure) {
            for (bond, (stretch, &strength)) in stretches.iter_mut().zip(strengths).enumerate() {
                if *stretch >= strength {
                    *stretch = NONE;
                    reached.push(BrokenBond { bond, lanes: 1, cause: Cause::Stretch });
                }
            }
        }
        self.find_sums(&stretches, &mut sums);
        self.find_forces((u, strain), (&stretches, &sums), forces.as_chunks_mut().0);
        (self.stretches, self.sums) = (stretches, sums);
        Ok(())
    }

    /// Takes the work of each bond over a step and adds the bonds that break to a list.
    fn advance_work(
        &mut self,
        [from, to]: [&[[f64; D]]; 2],
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        let BondFailure::Energy(critical) = &self.failure else { return Ok(()) };
        let (before, after) = (self.stretches(from)?, self.stretches(to)?);
        let sums = [self.sums(&before), self.sums(&after)];
        let (bonds, volumes) = (self.solid.bonds(), self.solid.volumes());
        let mut work = std::mem::take(&mut self.work);
        for (bond, (pair, of)) in bonds.pairs().zip(bonds.all()).enumerate() {
            let (before, after) = (before[bond], after[bond]);
            if before <= NONE {
                continue;
            }
            let tension = self.tension(pair, bond, before, &sums[0])
                + self.tension(pair, bond, after, &sums[1]);
            work[bond] += 0.5 * tension * of.length * (after - before);
            if after > 0.0 && work[bond] >= critical[bond] * volumes[bond] {
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
        self.evaluate((u, self.strain), forces, at)
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
        match self.stretches(u.as_chunks().0) {
            Ok(stretches) => self.energies_of(&stretches).iter().sum(),
            Err(_) => f64::NAN,
        }
    }

    fn linear_forces(&mut self, v: &[f64], forces: &mut [f64]) -> Result<(), Error> {
        self.evaluate((v, Strain::Linear), forces, AtStrength::Hold)
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
