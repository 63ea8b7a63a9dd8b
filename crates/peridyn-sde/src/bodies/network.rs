//! A body of nodes and bonds with what they remember: forces, energy, damage.

use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::{Bonds, cut_numbers};
use crate::bodies::linear_pull::linear_pull;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::breaking::crossing::{BondOverStep, Crossing};
use crate::error::{Error, same_length};
use crate::law::BondLaw;

/// A body whose bonds follow a law.
#[derive(Debug, Clone, PartialEq)]
pub struct Network<L: BondLaw, const D: usize> {
    nodes: Nodes<D>,
    bonds: Bonds,
    law: L,
    /// One for each bond.
    strengths: Vec<f64>,
    states: Vec<L::State>,
    /// Bonds that are cut, whatever their state.
    is_cut: Vec<bool>,
}

/// A bond as deformed.
struct Stretched<const D: usize> {
    stretch: f64,
    /// From the first node to the second, of length one.
    direction: [f64; D],
}

impl<L: BondLaw, const D: usize> Network<L, D> {
    /// A body as yet untouched; `strengths` are the stretches at which bonds break, in the order of [`Bonds::all`].
    ///
    /// # Errors
    /// [`Error::Length`] where nodes, bonds and strengths are not of one body; [`Error::Parameter`] for a strength.
    pub fn new(nodes: Nodes<D>, bonds: Bonds, law: L, strengths: Vec<f64>) -> Result<Self, Error> {
        let expected = bonds.n_nodes();
        same_length("nodes", nodes.positions().len(), expected)?;
        same_length("strengths", strengths.len(), bonds.len())?;
        for &strength in &strengths {
            crate::error::positive("strength of a bond", strength)?;
        }
        let (states, is_cut) = (vec![L::State::default(); bonds.len()], vec![false; bonds.len()]);
        Ok(Self { nodes, bonds, law, strengths, states, is_cut })
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    /// The bonds.
    #[must_use]
    pub fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    /// The histories of bonds, in the order of [`Bonds::all`]; of a cut bond, up to the cut.
    #[must_use]
    pub fn states(&self) -> &[L::State] {
        &self.states
    }

    /// Cuts bonds, as a notch does.
    ///
    /// # Errors
    /// [`Error::Length`] for a number that no bond has; none is cut then.
    pub fn cut(&mut self, bonds: &[usize]) -> Result<(), Error> {
        cut_numbers(bonds, self.bonds.len())?;
        for &bond in bonds {
            self.is_cut[bond] = true;
        }
        Ok(())
    }

    /// Forces on the nodes (force) under their displacements `u` (length), and the energy of the bonds:
    ///
    /// $$ F_i = \sum_j \kappa_{ij} \sigma(s_{ij})  e_{ij}, \qquad V = \sum_{i<j} \kappa_{ij} r_{ij} \int_0^{s_{ij}} \sigma ds, $$
    ///
    /// with the direction `e_ij` from `i` to `j` as deformed and the stretch
    /// `s = eta (2 xi + eta)/(r (r + |xi + eta|))` of a bond `xi` of the length `r` whose ends move apart by `eta`: written so, it
    /// loses no digits where it is small. This is the reference for every faster path.
    ///
    /// # Errors
    /// [`Error::Length`] for columns of another body; [`Error::Node`] for a displacement that is not finite;
    /// [`Error::Coincident`] for two bonded nodes that have come to one place.
    pub fn forces(&self, u: &[[f64; D]], forces: &mut [[f64; D]]) -> Result<f64, Error> {
        self.check(u)?;
        same_length("forces", forces.len(), self.bonds.n_nodes())?;
        forces.fill([0.0; D]);
        let mut energy = 0.0;
        for i in 0..self.bonds.n_nodes() {
            for bond in self.bonds.row(i) {
                let j = self.bonds.partner(bond);
                let Stretched { stretch, direction } = self.stretched((i, j), bond, u)?;
                if self.is_cut[bond] {
                    continue;
                }
                let (of, state) = (self.bonds.all()[bond], &self.states[bond]);
                let strength = self.strengths[bond];
                let tension = of.stiffness * self.law.tension(strength, stretch, state);
                for k in 0..D {
                    forces[i][k] += tension * direction[k];
                    forces[j][k] -= tension * direction[k];
                }
                energy += of.stiffness * of.length * self.law.energy(strength, stretch, state);
            }
        }
        Ok(energy)
    }

    /// Takes all bonds over a step of the length `dt` (time) in which nodes move from one displacement to another, each bond
    /// on a straight line of its stretch.
    ///
    /// # Errors
    /// As [`Network::forces`]; [`Error::Parameter`] for the step.
    pub fn advance(&mut self, from: &[[f64; D]], to: &[[f64; D]], dt: f64) -> Result<(), Error> {
        crate::error::positive("step", dt)?;
        self.check(from)?;
        self.check(to)?;
        for i in 0..self.bonds.n_nodes() {
            for bond in self.bonds.row(i) {
                let pair = (i, self.bonds.partner(bond));
                let before = self.stretched(pair, bond, from)?.stretch;
                let after = self.stretched(pair, bond, to)?.stretch;
                if !self.is_cut[bond] {
                    let state = &mut self.states[bond];
                    self.law.advance(self.strengths[bond], before, after, dt, state);
                }
            }
        }
        Ok(())
    }

    /// The damage of each node: the part of its bonds that is lost, each weighed by its stiffness.
    #[must_use]
    pub fn damage(&self) -> Vec<f64> {
        self.bonds.damage_of_nodes(|bond| self.damage_of(bond))
    }

    fn damage_of(&self, bond: usize) -> f64 {
        if self.is_cut[bond] {
            return 1.0;
        }
        self.law.damage(self.strengths[bond], &self.states[bond])
    }

    fn stretched(
        &self,
        (i, j): (usize, usize),
        bond: usize,
        u: &[[f64; D]],
    ) -> Result<Stretched<D>, Error> {
        let (x, r) = (self.nodes.positions(), self.bonds.all()[bond].length);
        let (mut now, mut elongation, mut square) = ([0.0; D], 0.0, 0.0);
        for k in 0..D {
            let (xi, eta) = (x[j][k] - x[i][k], u[j][k] - u[i][k]);
            now[k] = xi + eta;
            elongation += eta * (2.0 * xi + eta);
            square += now[k] * now[k];
        }
        let length = square.sqrt();
        if length <= 0.0 {
            return Err(Error::Coincident { first: i, second: j });
        }
        let inverse = 1.0 / length;
        let stretch = elongation / (r * (r + length));
        Ok(Stretched { stretch, direction: now.map(|c| c * inverse) })
    }

    /// Takes a bond over a step by its law; why it broke, if it did.
    fn advance_bond(
        &mut self,
        bond: usize,
        stretch: [f64; 2],
        dt: f64,
        crossing: Option<&mut Crossing<1>>,
    ) -> Option<Cause> {
        let damage_before = self.damage_of(bond);
        if self.is_cut[bond] {
            return None;
        }
        let ([before, after], strength) = (stretch, self.strengths[bond]);
        let state = &mut self.states[bond];
        let threshold = self.law.threshold(strength, state);
        self.law.advance(strength, before, after, dt, state);
        let mut cause = match threshold {
            Some(threshold) if after >= threshold => Cause::Stretch,
            _ => Cause::Wear,
        };
        if self.law.damage(strength, state) < 1.0
            && let (Some(threshold), Some(crossing)) = (threshold, crossing)
            && let Some(found) =
                crossing.test(bond, 0, BondOverStep { stretch, strength: threshold })
        {
            self.law.advance(strength, before.max(after), threshold, dt, state);
            cause = found;
        }
        (damage_before < 1.0 && self.law.damage(strength, state) >= 1.0).then_some(cause)
    }

    fn check(&self, u: &[[f64; D]]) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds.n_nodes())?;
        for (node, u) in u.iter().enumerate() {
            if let Some(&value) = u.iter().find(|c| !c.is_finite()) {
                return Err(Error::Node { name: "a displacement", node, value, must: "finite" });
            }
        }
        Ok(())
    }
}

/// One realisation, whose bonds follow their law from step to step.
impl<L: BondLaw + Send, const D: usize> Body<f64, D, 1> for Network<L, D> {
    fn nodes(&self) -> &Nodes<D> {
        &self.nodes
    }

    fn bonds(&self) -> &Bonds {
        &self.bonds
    }

    fn forces(&mut self, u: &[f64], forces: &mut [f64], _at: AtStrength<'_>) -> Result<(), Error> {
        same_length("displacements", u.len(), self.bonds.n_nodes() * D)?;
        same_length("forces", forces.len(), u.len())?;
        Network::forces(self, u.as_chunks().0, forces.as_chunks_mut().0).map(|_| ())
    }

    fn intact(&self, bond: usize) -> u16 {
        u16::from(self.damage_of(bond) < 1.0)
    }

    fn set_intact(&mut self, bond: usize, lanes: u16) {
        if lanes != Body::intact(self, bond) {
            self.is_cut[bond] = lanes == 0;
            if lanes != 0 {
                self.states[bond] = L::State::default();
            }
        }
    }

    fn strength(&self, bond: usize, _lane: usize) -> f64 {
        self.strengths[bond]
    }

    fn slope(&self, bond: usize, _lane: usize) -> f64 {
        if self.is_cut[bond] {
            return 0.0;
        }
        self.law.slope(self.strengths[bond], &self.states[bond])
    }

    fn secant(&self, bond: usize, _lane: usize) -> f64 {
        1.0 - self.damage_of(bond)
    }

    fn secant_forces(&mut self, v: &[f64], forces: &mut [f64]) -> Result<(), Error> {
        let secant = |bond, _| 1.0 - self.damage_of(bond);
        linear_pull::<f64, D, 1>(&self.nodes, &self.bonds, secant, v, forces)
    }

    fn next_stretch(&self, bond: usize, _lane: usize) -> f64 {
        if self.is_cut[bond] {
            return f64::INFINITY;
        }
        let threshold = self.law.threshold(self.strengths[bond], &self.states[bond]);
        threshold.unwrap_or(f64::INFINITY)
    }

    fn pass(&mut self, bond: usize, stretch: f64) {
        self.law.advance(self.strengths[bond], 0.0, stretch, 0.0, &mut self.states[bond]);
    }

    fn is_piecewise_linear(&self) -> bool {
        self.law.is_piecewise_linear()
    }

    fn bond_damage(&self, bond: usize, _lane: usize) -> f64 {
        self.damage_of(bond)
    }

    fn energy(&self, u: &[f64], _lane: usize) -> f64 {
        let mut forces = vec![[0.0; D]; self.bonds.n_nodes()];
        Network::forces(self, u.as_chunks().0, &mut forces).unwrap_or(f64::NAN)
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn advance(
        &mut self,
        from: &[f64],
        to: &[f64],
        dt: f64,
        mut crossing: Option<&mut Crossing<1>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        crate::error::positive("step", dt)?;
        let (from, to) = (from.as_chunks::<D>().0, to.as_chunks::<D>().0);
        self.check(from)?;
        self.check(to)?;
        for bond in 0..self.bonds.len() {
            let ends = self.bonds.ends(bond);
            let before = self.stretched(ends, bond, from)?.stretch;
            let after = self.stretched(ends, bond, to)?.stretch;
            let cause = self.advance_bond(bond, [before, after], dt, crossing.as_deref_mut());
            broken.extend(cause.map(|cause| BrokenBond { bond, lanes: 1, cause }));
        }
        Ok(())
    }
}
