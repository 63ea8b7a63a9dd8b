//! What a step in time asks of a body.

use crate::bonds::Bonds;
use crate::crossing::Crossing;
use crate::error::Error;
use crate::nodes::Nodes;
use crate::real::Real;

/// What a force evaluation does with bonds that have reached their strength.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AtStrength {
    /// They break, and pull no more.
    Break,
    /// They pull on: the displacements are not those of a finished step, or breaking is looked after elsewhere.
    Hold,
}

/// Why a bond broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// A notch cut it.
    Cut,
    /// It was found at its strength at the end of a step.
    Stretch,
    /// It was below its strength at both ends of a step, and crossed it in between.
    Crossing,
    /// Its law wore it down.
    Wear,
}

/// A bond that broke.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BrokenBond {
    /// Its number in [`Bonds::all`].
    pub bond: usize,
    /// In which lanes, a bit for each.
    pub lanes: u16,
    /// Why.
    pub cause: Cause,
}

/// A body of `L` realisations side by side. Displacements and forces are slices of `L D N` numbers: node by node, component
/// by component, lane by lane.
pub trait Body<T: Real, const D: usize, const L: usize>: Send {
    /// The nodes.
    fn nodes(&self) -> &Nodes<D>;

    /// The bonds.
    fn bonds(&self) -> &Bonds;

    /// Forces on the nodes (force) under displacements `u` (length).
    ///
    /// # Errors
    /// Those of the body, as for two nodes that have come to one place.
    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength) -> Result<(), Error>;

    /// Whether bonds at their strength break where forces are evaluated with [`AtStrength::Break`]; if not, in
    /// [`advance`](Self::advance).
    fn breaks_in_forces(&self) -> bool {
        true
    }

    /// `-K v`: forces under small displacements `v` from rest, linear in them, of the bonds as they stand broken or whole.
    ///
    /// # Errors
    /// [`Error::Length`] for columns of another body.
    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error>;

    /// Takes bonds over a step from one displacement to another; with `crossing`, those that crossed their strength in
    /// between are broken too.
    ///
    /// # Errors
    /// Those of the body.
    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        dt: f64,
        crossing: Option<&mut Crossing<L>>,
    ) -> Result<(), Error>;

    /// Cuts bonds in all lanes, as a notch does.
    ///
    /// # Errors
    /// [`Error::Length`] for a number that no bond has.
    fn cut(&mut self, bonds: &[usize]) -> Result<(), Error>;

    /// How much of a bond is lost in a lane: 0 whole, 1 broken.
    fn lost(&self, bond: usize, lane: usize) -> f64;

    /// The strength of a bond in a lane (a stretch).
    fn strength(&self, bond: usize, lane: usize) -> f64;

    /// The energy of the bonds in a lane (energy).
    fn energy(&self, u: &[T], lane: usize) -> f64;

    /// For each bond the lanes in which it is whole, a bit for each; `None` where bonds remember more than that.
    fn whole(&self) -> Option<Vec<u16>>;

    /// Puts bonds back to what [`whole`](Self::whole) gave.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of bonds; [`Error::NotSaved`].
    fn set_whole(&mut self, whole: &[u16]) -> Result<(), Error>;

    /// Bonds that broke since this was last called.
    fn take_broken(&mut self) -> Vec<BrokenBond>;
}
