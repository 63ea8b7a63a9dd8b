//! A body under a load that grows slowly: equilibrium after equilibrium, while bonds break.

use std::fmt;

use super::config::EquilibriumConfig;
use super::statics::{Solved, Statics};
use crate::bodies::body::Body;
use crate::dynamics::loading::Loading;
use crate::error::{Error, finite};

/// Stored energy over the largest before, at the same load, below which a body counts as separated.
const SEPARATED: f64 = 1e-6;

/// The next bonds to break, and at which load.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Breakage {
    /// The load factor at which they change. It falls from one breakage to the next where a test that controls the load or the
    /// displacement would snap.
    pub factor: f64,
    /// Those that changed, the most critical one first: that broke, or of bonds that soften went on to their next tooth.
    pub bonds: Vec<usize>,
    /// Energy of the bonds before and after, at this factor (energy).
    pub energy: [f64; 2],
    /// Energy that left the body and its loads (energy).
    pub released: f64,
    /// How the equilibrium after it was found.
    pub solved: Solved,
}

/// What comes next under a load that grows.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum NextBreakage {
    /// Bonds changed.
    At(Breakage),
    /// The body carries a millionth of what it carried, or nothing, or a loaded part of it came loose. It is left in its last
    /// equilibrium.
    Separated,
    /// No bond is stretched that could break.
    Never,
}

/// A body in quasi-static equilibrium with its loads, which the times of the [`Loading`] count.
///
/// [`next_breakage`](Self::next_breakage) follows the path event by event, for small strains. The solution `u` of `K u = f` at a
/// unit load gives the factor `min s_0/s` at which the next bond is at its strength: sequentially linear analysis (Rots 2001; for
/// lattices Herrmann, Hansen & Roux 1989). Factors may fall, so the curve has its snap-backs; [`envelope`] is what a test of a
/// prescribed displacement would see.
///
/// The body's law must be piecewise linear ([`Body::is_piecewise_linear`]): a bond that breaks at a stretch, or one that softens
/// ([`Bilinear`](crate::law::Bilinear)), which is then taken along its secant in teeth (see
/// [`EquilibriumConfig::tooth`]). A damaged bond is taken for as soft under compression as under tension.
pub struct QuasiStatic<const D: usize> {
    body: Box<dyn Body<f64, D, 1>>,
    /// At a unit load, once this has been found.
    statics: Statics<D>,
    load: f64,
    largest: f64,
    is_unit: bool,
}

impl<const D: usize> fmt::Debug for QuasiStatic<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("QuasiStatic").field("statics", &self.statics).finish_non_exhaustive()
    }
}

impl<const D: usize> QuasiStatic<D> {
    /// A body at rest at the load 0.
    ///
    /// # Errors
    /// [`Error::Length`] for a loading of another body, [`Error::Parameter`] for the configuration,
    /// [`Error::NoFreeNode`], [`Error::NotPiecewiseLinear`], [`Error::NotProportional`] for a loading that is not proportional to
    /// time.
    pub fn new(
        body: impl Body<f64, D, 1> + 'static,
        loading: Loading<D>,
        config: EquilibriumConfig,
    ) -> Result<Self, Error> {
        Self::of_any(Box::new(body), loading, config)
    }

    /// As [`QuasiStatic::new`], of a body whose kind is known at run time.
    ///
    /// # Errors
    /// As [`QuasiStatic::new`].
    pub fn of_any(
        body: Box<dyn Body<f64, D, 1>>,
        loading: Loading<D>,
        config: EquilibriumConfig,
    ) -> Result<Self, Error> {
        let statics = Statics::new(&*body, loading, config)?;
        Ok(Self { body, statics, load: 0.0, largest: 0.0, is_unit: false })
    }

    /// The body, with its bonds as they are.
    #[must_use]
    pub fn body(&self) -> &dyn Body<f64, D, 1> {
        &*self.body
    }

    /// The load of the present equilibrium.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.load
    }

    /// Displacements (length).
    #[must_use]
    pub fn displacements(&self) -> Vec<[f64; D]> {
        self.statics.u.as_chunks::<D>().0.iter().map(|u| u.map(|u| self.load * u)).collect()
    }

    /// The force of the bonds on some nodes (force): the reaction of a prescribed displacement is its opposite.
    #[must_use]
    pub fn pull_on(&self, nodes: &[usize]) -> [f64; D] {
        self.pull_at(nodes, self.load)
    }

    /// The force of the bonds on some nodes for a unit of the load (force over that of the loading's time): what
    /// [`pull_on`](Self::pull_on) is over the load, up to the next change of a bond. For small strains.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage).
    pub fn pull_of_unit_load(&mut self, nodes: &[usize]) -> Result<[f64; D], Error> {
        self.at_unit_load()?;
        Ok(self.pull_at(nodes, 1.0))
    }

    fn pull_at(&self, nodes: &[usize], load: f64) -> [f64; D] {
        let mut sum = [0.0; D];
        for &node in nodes {
            for k in 0..D {
                sum[k] += load * self.statics.bond_forces[node * D + k];
            }
        }
        sum
    }

    /// The load at which the next bonds change, as [`next_breakage`](Self::next_breakage) would find it, for small strains; none
    /// where no bond is stretched that could break.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage).
    pub fn next_factor(&mut self) -> Result<Option<f64>, Error> {
        self.at_unit_load()?;
        let first = self.statics.most_critical(&*self.body);
        Ok(first.map(|(_, ratio)| 1.0 / ratio))
    }

    /// Goes to another load without a change of bonds, as up to [`next_factor`](Self::next_factor) none is, for small strains.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage); [`Error::Parameter`] for the load.
    pub fn scale_to(&mut self, load: f64) -> Result<(), Error> {
        finite("load", load)?;
        self.at_unit_load()?;
        self.load = load;
        Ok(())
    }

    /// The energy of the bonds (energy), by their stretches.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let u = self.displacements();
        self.body.energy(u.as_flattened(), 0)
    }

    /// The damage of each node: the part of its bonds that is lost, each weighed by its stiffness.
    #[must_use]
    pub fn damage(&self) -> Vec<f64> {
        self.body.bonds().damage_of_nodes(|bond| self.body.bond_damage(bond, 0))
    }

    /// Goes to the next load at which bonds change, takes them past it, and finds equilibrium at that load without them.
    ///
    /// Strains are taken for small, whatever those of the body.
    ///
    /// # Errors
    /// [`Error::NotInEquilibrium`]; [`Error::SingularStiffness`] for a body that nothing holds before any bond has broken; those of
    /// the body. After an error the state is not to be used.
    pub fn next_breakage(&mut self) -> Result<NextBreakage, Error> {
        self.at_unit_load()?;
        let Self { body, statics, load, largest, .. } = self;
        let before = statics.works();
        // Whether the body carries next to nothing: its energy over the square of the load against the largest.
        *largest = largest.max(before[0]);
        if before[0] <= SEPARATED * *largest {
            return Ok(NextBreakage::Separated);
        }
        let Some(first) = statics.most_critical(&**body) else {
            return Ok(NextBreakage::Never);
        };
        let factor = 1.0 / first.1;
        let bonds = batch(&**body, statics, first);
        for &bond in &bonds {
            statics.pass(&mut **body, bond)?;
        }
        let before_breakage = statics.u.clone();
        *load = factor;
        let Some(solved) = statics.equilibrate(&mut **body, factor)? else {
            statics.u = before_breakage;
            statics.evaluate(&mut **body)?;
            *largest = f64::INFINITY;
            return Ok(NextBreakage::Separated);
        };
        let after = statics.works();
        let square = factor * factor;
        let potential = |[bonds, loads]: [f64; 2]| square * (0.5 * bonds - loads);
        Ok(NextBreakage::At(Breakage {
            factor,
            bonds,
            energy: [before, after].map(|works| 0.5 * square * works[0]),
            released: potential(before) - potential(after),
            solved,
        }))
    }

    /// Finds the displacements at a unit load, from the field of the drives at all nodes.
    fn at_unit_load(&mut self) -> Result<(), Error> {
        if self.is_unit {
            return Ok(());
        }
        let statics = &mut self.statics;
        for (node, u) in statics.u.as_chunks_mut::<D>().0.iter_mut().enumerate() {
            *u = statics.loading.field(node, 1.0);
        }
        statics.impose_unit_load();
        if statics.equilibrate(&mut *self.body, 1.0)?.is_none() {
            return Err(Error::SingularStiffness);
        }
        self.is_unit = true;
        Ok(())
    }
}

/// The bonds within the batch of the most critical one, that one first.
fn batch<const D: usize>(
    body: &dyn Body<f64, D, 1>,
    statics: &Statics<D>,
    (first, ratio): (usize, f64),
) -> Vec<usize> {
    if statics.config.batch <= 0.0 {
        return vec![first];
    }
    let mut all = statics.critical_from(body, (1.0 - statics.config.batch) * ratio);
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.into_iter().map(|(bond, _)| bond).collect()
}

/// The breakages whose load factor exceeds that of all before: where a test that raises the load or the displacement would see
/// bonds break, by their numbers in the list. What is in between happens at once in it.
#[must_use]
pub fn envelope(breakages: &[Breakage]) -> Vec<usize> {
    let mut highest = f64::NEG_INFINITY;
    let mut found = Vec::new();
    for (number, breakage) in breakages.iter().enumerate() {
        if breakage.factor > highest {
            highest = breakage.factor;
            found.push(number);
        }
    }
    found
}
