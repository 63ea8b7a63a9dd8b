//! What a time step needs from a body.

use crate::bodies::bonds::Bonds;
use crate::bodies::linear_pull::linear_pull;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::crossing::{BondOverStep, Crossing};
use crate::error::Error;
use crate::material::strain::Strain;
use crate::real::Real;

/// What a force evaluation does with bonds whose stretch is at their strength.
#[derive(Debug)]
pub enum AtStrength<'a> {
    /// They carry no force and are added to this list. The evaluation leaves them intact: the caller breaks them by
    /// [`Body::set_intact`].
    Break(&'a mut Vec<BrokenBond>),
    /// They carry their force: the displacements are not those of a finished step, or bond failure is checked elsewhere.
    Hold,
}

/// A body of `L` realisations side by side. Displacements and forces are slices of `L D N` numbers: node by node, component
/// by component, lane by lane.
///
/// A body computes forces and stores which bonds are intact; a [`Simulation`](crate::Simulation) decides when bonds break. Five
/// methods are required. The provided ones describe elastic bonds of the stiffness in [`Bonds`] that break nowhere but in
/// [`forces`](Self::forces) and by cuts.
pub trait Body<T: Real, const D: usize, const L: usize>: Send {
    /// The nodes.
    fn nodes(&self) -> &Nodes<D>;

    /// The bonds.
    fn bonds(&self) -> &Bonds;

    /// Forces on the nodes (force) under displacements `u` (length).
    ///
    /// # Errors
    /// Those of the body, as for two nodes that have come to one place.
    fn forces(&mut self, u: &[T], forces: &mut [T], at: AtStrength<'_>) -> Result<(), Error>;

    /// The lanes in which a bond is intact, a bit for each.
    fn intact(&self, bond: usize) -> u16;

    /// Makes a bond intact in these lanes, a bit for each, and broken in the others.
    fn set_intact(&mut self, bond: usize, lanes: u16);

    /// How strains are measured.
    fn strain(&self) -> Strain {
        Strain::Finite
    }

    /// The strength of a bond in a lane (a stretch), at which it breaks between the ends of a step; infinite for never.
    fn strength(&self, _bond: usize, _lane: usize) -> f64 {
        f64::INFINITY
    }

    /// The stretch of a bond between two nodes in a lane.
    fn stretch(&self, bond: usize, ends: (usize, usize), u: &[T], lane: usize) -> f64 {
        let shape = (ends, self.bonds().all()[bond].length);
        let strain = self.strain();
        strain.stretch(strain.squared_elongation_of::<T, D, L>(self.nodes(), shape, u, lane))
    }

    /// The slope of the tension over the stretch at rest in a lane, as part of the stiffness of the bond.
    fn slope(&self, bond: usize, lane: usize) -> f64 {
        f64::from(self.intact(bond) >> lane & 1)
    }

    /// The damage of a bond in a lane: 0 intact, 1 broken.
    fn bond_damage(&self, bond: usize, lane: usize) -> f64 {
        f64::from(self.intact(bond) & 1 << lane == 0)
    }

    /// The energy of the bonds in a lane (energy).
    fn energy(&self, u: &[T], lane: usize) -> f64 {
        elastic_energy(self, u, lane)
    }

    /// `-K v`: forces under small displacements `v` from rest, linear in them, of the bonds in their present state.
    ///
    /// # Errors
    /// [`Error::Length`] for columns of another body.
    fn linear_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        linear_pull::<T, D, L>(
            self.nodes(),
            self.bonds(),
            |bond, lane| self.slope(bond, lane),
            v,
            forces,
        )
    }

    /// The tension of a pulled bond over that of the same bond undamaged: its secant stiffness in a lane as a part of the
    /// intact one. What an [equilibrium](crate::QuasiStatic) takes a bond for.
    fn secant(&self, bond: usize, lane: usize) -> f64 {
        self.slope(bond, lane)
    }

    /// As [`linear_forces`](Self::linear_forces), by the [`secant`](Self::secant) of each bond.
    ///
    /// # Errors
    /// As [`linear_forces`](Self::linear_forces).
    fn secant_forces(&mut self, v: &[T], forces: &mut [T]) -> Result<(), Error> {
        self.linear_forces(v, forces)
    }

    /// The stretch at which the secant of a bond next changes for good in a lane; infinite for never. The strength, unless a
    /// body says otherwise.
    fn next_stretch(&self, bond: usize, lane: usize) -> f64 {
        self.strength(bond, lane)
    }

    /// Takes a bond past a stretch without time, in all lanes: what it is afterwards is seen by its secant. It breaks, unless a
    /// body says otherwise.
    fn pass(&mut self, bond: usize, _stretch: f64) {
        self.set_intact(bond, 0);
    }

    /// Whether the tension of a pulled bond is its secant times its stretch up to [`next_stretch`](Self::next_stretch), and
    /// depends on no rate: what equilibrium event by event is exact for.
    fn is_piecewise_linear(&self) -> bool {
        true
    }

    /// Whether bonds remember more than whether they are intact. Such bonds change in [`advance`](Self::advance) alone, and
    /// the body cannot be saved.
    fn has_memory(&self) -> bool {
        false
    }

    /// Takes bonds over a step from one displacement to another and adds those that break to a list. With `crossing`, bonds
    /// that crossed their strength between the ends of the step break too.
    ///
    /// # Errors
    /// Those of the body.
    fn advance(
        &mut self,
        from: &[T],
        to: &[T],
        _dt: f64,
        crossing: Option<&mut Crossing<L>>,
        broken: &mut Vec<BrokenBond>,
    ) -> Result<(), Error> {
        if let Some(crossing) = crossing {
            test_all(self, crossing, (from, to), broken);
        }
        Ok(())
    }
}

/// The energy of elastic bonds of the stiffness in [`Bonds`], over those intact in a lane.
pub(crate) fn elastic_energy<B, T: Real, const D: usize, const L: usize>(
    body: &B,
    u: &[T],
    lane: usize,
) -> f64
where
    B: Body<T, D, L> + ?Sized,
{
    let mut energy = 0.0;
    for (bond, (ends, of)) in body.bonds().pairs().zip(body.bonds().all()).enumerate() {
        if body.intact(bond) & 1 << lane != 0 {
            let stretch = body.stretch(bond, ends, u, lane);
            energy += 0.5 * of.stiffness * of.length * stretch.powi(2);
        }
    }
    energy
}

/// Tests every intact bond over a step from one displacement to another.
pub(crate) fn test_all<B, T: Real, const D: usize, const L: usize>(
    body: &B,
    crossing: &mut Crossing<L>,
    (from, to): (&[T], &[T]),
    broken: &mut Vec<BrokenBond>,
) where
    B: Body<T, D, L> + ?Sized,
{
    for (bond, ends) in body.bonds().pairs().enumerate() {
        let intact = body.intact(bond);
        for lane in (0..L).filter(|lane| intact & 1 << lane != 0) {
            let stretch = [from, to].map(|u| body.stretch(bond, ends, u, lane));
            let over = BondOverStep { stretch, strength: body.strength(bond, lane) };
            let cause = crossing.test(bond, lane, over);
            broken.extend(cause.map(|cause| BrokenBond { bond, lanes: 1 << lane, cause }));
        }
    }
}
