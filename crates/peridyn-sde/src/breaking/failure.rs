//! Where bonds break.
//!
//! Three rules find bonds that break and leave them intact: forces that find a stretch at its strength
//! ([`AtStrength::Break`](crate::AtStrength::Break), for wide registers `SquaredElongation::pull`), the bridge between the ends
//! of a step ([`Crossing`](crate::Crossing)), and the law of a body with memory ([`BondLaw`](crate::BondLaw)). Every scheme and
//! every body hands what they find to one function, [`Failures::apply`].

use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::cut_numbers;
use crate::breaking::broken_bond::{BrokenBond, Cause};
use crate::breaking::crossing::Crossing;
use crate::error::Error;
use crate::real::Real;

/// The lanes of `L` realisations, a bit for each.
pub(crate) const fn all_lanes<const L: usize>() -> u16 {
    u16::MAX >> (16 - L)
}

/// Bonds that broke and are not yet reported.
#[derive(Debug, Default)]
pub(crate) struct Failures {
    broken: Vec<BrokenBond>,
    /// How many of them the body knows of.
    applied: usize,
}

impl Failures {
    /// Breaks the bonds that were found: nothing else turns an intact bond of a running body into a broken one.
    fn apply<T: Real, const D: usize, const L: usize>(&mut self, body: &mut dyn Body<T, D, L>) {
        for found in &self.broken[self.applied..] {
            let intact = body.intact(found.bond);
            body.set_intact(found.bond, intact & !found.lanes);
        }
        self.applied = self.broken.len();
    }

    /// Forces under displacements; bonds at their strength break.
    pub(crate) fn forces<T: Real, const D: usize, const L: usize>(
        &mut self,
        body: &mut dyn Body<T, D, L>,
        u: &[T],
        forces: &mut [T],
    ) -> Result<(), Error> {
        body.forces(u, forces, AtStrength::Break(&mut self.broken))?;
        self.apply(body);
        Ok(())
    }

    /// Takes bonds over a step from one displacement to another.
    pub(crate) fn advance<T: Real, const D: usize, const L: usize>(
        &mut self,
        body: &mut dyn Body<T, D, L>,
        (from, to): (&[T], &[T]),
        dt: f64,
        crossing: Option<&mut Crossing<L>>,
    ) -> Result<(), Error> {
        body.advance(from, to, dt, crossing, &mut self.broken)?;
        self.apply(body);
        Ok(())
    }

    /// Cuts bonds in all lanes, as a notch does.
    pub(crate) fn cut<T: Real, const D: usize, const L: usize>(
        &mut self,
        body: &mut dyn Body<T, D, L>,
        bonds: &[usize],
    ) -> Result<(), Error> {
        cut_numbers(bonds, body.bonds().len())?;
        let lanes = all_lanes::<L>();
        self.broken.extend(bonds.iter().map(|&bond| BrokenBond { bond, lanes, cause: Cause::Cut }));
        self.apply(body);
        Ok(())
    }

    /// The lanes of which a bond broke since the last report.
    pub(crate) fn lanes(&self) -> u16 {
        self.broken.iter().fold(0, |lanes, broken| lanes | broken.lanes)
    }

    /// The bonds that broke since the last report.
    pub(crate) fn take(&mut self) -> Vec<BrokenBond> {
        self.applied = 0;
        std::mem::take(&mut self.broken)
    }
}
