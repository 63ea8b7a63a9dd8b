//! A body under a load that grows slowly: equilibrium after equilibrium, while bonds break.

use super::config::EquilibriumConfig;
use super::statics::{Forces, Solved, Statics};
use crate::bodies::body::Body;
use crate::dynamics::loading::Loading;
use crate::error::{Error, finite};
use crate::material::strain::Strain;

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

/// A step to another load.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct LoadStep {
    /// The load (that of the programs of the loading as a time).
    pub load: f64,
    /// Bonds that changed in the step, in order.
    pub bonds: Vec<usize>,
    /// Equilibria that were solved in the step.
    pub equilibria: usize,
    /// Iterations of all, and the last residual.
    pub solved: Solved,
    /// Whether the body came apart, as [`NextBreakage::Separated`]: its displacements are those of the last equilibrium.
    pub is_separated: bool,
}

/// A body in quasi-static equilibrium with its loads, which the times of the [`Loading`] count.
///
/// Two ways lead along the path, and may be mixed:
///
/// - [`next_breakage`](Self::next_breakage) follows the path event by event. For small strains the solution `u` of `K u = f` at a
///   unit load gives the factor `min s_0/s` at which the next bond is at its strength: sequentially linear analysis (Rots 2001;
///   for lattices Herrmann, Hansen & Roux 1989). Factors may fall, so the curve has its snap-backs; [`envelope`] is what a test
///   of a prescribed displacement would see.
/// - [`step_to`](Self::step_to) goes to a load, breaks the bonds that are over their strength one at a time or in batches, and finds
///   equilibrium at this load after each, until none is.
///
/// The body's law must be piecewise linear ([`Body::is_piecewise_linear`]): a bond that breaks at a stretch, or one that softens
/// ([`Bilinear`](crate::law::Bilinear)), which is then taken along its secant in teeth (see
/// [`EquilibriumConfig::tooth`]). A damaged bond is taken for as soft under compression as under tension.
#[derive(Debug)]
pub struct QuasiStatic<B, const D: usize> {
    body: B,
    statics: Statics<D>,
    load: f64,
    largest: f64,
    is_unit: bool,
}

impl<B: Body<f64, D, 1>, const D: usize> QuasiStatic<B, D> {
    /// A body at rest at the load 0.
    ///
    /// # Errors
    /// [`Error::Length`] for a loading of another body, [`Error::NotPositive`] and [`Error::OutOfRange`] for the configuration,
    /// [`Error::NoFreeNode`], [`Error::NotPiecewiseLinear`].
    pub fn new(body: B, loading: Loading<D>, config: EquilibriumConfig) -> Result<Self, Error> {
        let statics = Statics::new(&body, loading, config)?;
        Ok(Self { body, statics, load: 0.0, largest: 0.0, is_unit: false })
    }

    /// The body, with its bonds as they are.
    pub fn body(&self) -> &B {
        &self.body
    }

    /// The load of the present equilibrium.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.load
    }

    /// Displacements (length).
    #[must_use]
    pub fn displacements(&self) -> Vec<[f64; D]> {
        let scale = self.scale();
        self.statics.u.as_chunks::<D>().0.iter().map(|u| u.map(|u| scale * u)).collect()
    }

    /// The force of the bonds on some nodes (force): the reaction of a prescribed displacement is its opposite.
    #[must_use]
    pub fn pull_on(&self, nodes: &[usize]) -> [f64; D] {
        let mut sum = [0.0; D];
        for &node in nodes {
            for k in 0..D {
                sum[k] += self.scale() * self.statics.bond_forces[node * D + k];
            }
        }
        sum
    }

    /// The force of the bonds on some nodes for a unit of the load (force over that of the loading's time): what
    /// [`pull_on`](Self::pull_on) is over the load, up to the next change of a bond. For small strains.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage).
    pub fn pull_of_unit_load(&mut self, nodes: &[usize]) -> Result<[f64; D], Error> {
        self.at_unit_load()?;
        let mut sum = [0.0; D];
        for &node in nodes {
            for k in 0..D {
                sum[k] += self.statics.bond_forces[node * D + k];
            }
        }
        Ok(sum)
    }

    /// The load at which the next bonds change, as [`next_breakage`](Self::next_breakage) would find it, for small strains; none
    /// where no bond is stretched that could break.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage).
    pub fn next_factor(&mut self) -> Result<Option<f64>, Error> {
        self.at_unit_load()?;
        let first = self.statics.most_critical(&self.body, Strain::Linear);
        Ok(first.map(|(_, ratio)| 1.0 / ratio))
    }

    /// Goes to another load without a change of bonds, as up to [`next_factor`](Self::next_factor) none is, for small strains.
    ///
    /// # Errors
    /// As [`next_breakage`](Self::next_breakage); [`Error::NotFinite`] for the load.
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
    /// [`Error::NotProportional`] for a loading that is not proportional to time; [`Error::NotInEquilibrium`];
    /// [`Error::SingularStiffness`] for a body that nothing holds before any bond has broken; those of the body.
    pub fn next_breakage(&mut self) -> Result<NextBreakage, Error> {
        self.at_unit_load()?;
        let Self { body, statics, load, largest, .. } = self;
        next_breakage(body, statics, (load, largest))
    }

    /// Goes to a load and finds equilibrium there, while bonds over their strength break.
    ///
    /// # Errors
    /// [`Error::LoadStep`] where Newton's method does not converge, [`Error::NotInEquilibrium`],
    /// [`Error::SingularStiffness`] for a body that nothing holds before any bond has broken; [`Error::NotFinite`] for the load;
    /// those of the body. After an error the state is not to be used.
    pub fn step_to(&mut self, load: f64) -> Result<LoadStep, Error> {
        finite("load", load)?;
        self.unscale();
        let Self { body, statics, load: from, largest, .. } = self;
        let step = step_to(body, statics, (*from, load), largest)?;
        self.load = load;
        Ok(step)
    }

    fn at_unit_load(&mut self) -> Result<(), Error> {
        if !self.is_unit {
            start_unit(&mut self.body, &mut self.statics, self.load)?;
            self.is_unit = true;
        }
        Ok(())
    }

    fn scale(&self) -> f64 {
        if self.is_unit { self.load } else { 1.0 }
    }

    /// Displacements at the load, in place of those at a unit load.
    fn unscale(&mut self) {
        let scale = self.scale();
        for value in self.statics.u.iter_mut().chain(&mut self.statics.bond_forces) {
            *value *= scale;
        }
        self.is_unit = false;
    }
}

/// The bonds within the batch of the most critical one, that one first.
fn batch<const D: usize>(
    body: &dyn Body<f64, D, 1>,
    statics: &Statics<D>,
    strain: Strain,
    (first, ratio): (usize, f64),
    least: f64,
) -> Vec<(usize, f64)> {
    if statics.config.batch <= 0.0 {
        return vec![(first, ratio)];
    }
    let least = least.max((1.0 - statics.config.batch) * ratio);
    let mut all = statics.critical_from(body, strain, least);
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all
}

/// Whether a body carries next to nothing: its energy over the square of the load against the largest.
fn came_apart(largest: &mut f64, stiffness: f64) -> bool {
    *largest = largest.max(stiffness);
    stiffness <= SEPARATED * *largest
}

fn next_breakage<const D: usize>(
    body: &mut dyn Body<f64, D, 1>,
    statics: &mut Statics<D>,
    (load, largest): (&mut f64, &mut f64),
) -> Result<NextBreakage, Error> {
    let before = statics.works();
    if came_apart(largest, before[0]) {
        return Ok(NextBreakage::Separated);
    }
    let Some(first) = statics.most_critical(body, Strain::Linear) else {
        return Ok(NextBreakage::Never);
    };
    let factor = 1.0 / first.1;
    let found = batch(body, statics, Strain::Linear, first, 0.0);
    let bonds: Vec<usize> = found.iter().map(|found| found.0).collect();
    for bond in bonds.iter().copied() {
        statics.pass(body, (bond, 1.0))?;
    }
    let kept = statics.u.clone();
    let Some(solved) = statics.equilibrate(body, (factor, factor), Forces::Secant)? else {
        statics.u = kept;
        statics.evaluate(body, Forces::Secant)?;
        *load = factor;
        *largest = f64::INFINITY;
        return Ok(NextBreakage::Separated);
    };
    *load = factor;
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

/// Displacements at a unit load, from those at the present one.
fn start_unit<const D: usize>(
    body: &mut dyn Body<f64, D, 1>,
    statics: &mut Statics<D>,
    load: f64,
) -> Result<(), Error> {
    if !statics.loading.is_proportional() {
        return Err(Error::NotProportional);
    }
    if load > 0.0 {
        statics.u.iter_mut().for_each(|u| *u /= load);
    } else {
        start_affine(statics);
    }
    statics.impose(1.0);
    match statics.equilibrate(body, (0.0, 1.0), Forces::Secant)? {
        Some(_) => Ok(()),
        None => Err(Error::SingularStiffness { load: 1.0 }),
    }
}

/// The field of the drives at a unit load, at all nodes.
fn start_affine<const D: usize>(statics: &mut Statics<D>) {
    for (node, u) in statics.u.as_chunks_mut::<D>().0.iter_mut().enumerate() {
        *u = statics.loading.field(node, 1.0);
    }
}

fn step_to<const D: usize>(
    body: &mut dyn Body<f64, D, 1>,
    statics: &mut Statics<D>,
    (from, load): (f64, f64),
    largest: &mut f64,
) -> Result<LoadStep, Error> {
    predict(statics, (from, load));
    let strain = body.strain();
    let mut step = LoadStep {
        load,
        bonds: Vec::new(),
        equilibria: 0,
        solved: Solved::default(),
        is_separated: false,
    };
    loop {
        let kept = statics.u.clone();
        let Some(solved) = statics.equilibrate(body, (from, load), Forces::Body)? else {
            if *largest <= 0.0 && step.bonds.is_empty() {
                return Err(Error::SingularStiffness { load });
            }
            statics.u = kept;
            statics.evaluate(body, Forces::Body)?;
            step.is_separated = true;
            return Ok(step);
        };
        step.equilibria += 1;
        step.solved.iterations += solved.iterations;
        step.solved.residual = solved.residual;
        if load.abs() > 0.0 {
            let stiffness = statics.works()[0] / (load * load);
            step.is_separated = came_apart(largest, stiffness);
        }
        let first = statics.most_critical(body, strain).filter(|first| first.1 >= 1.0);
        let Some(first) = first.filter(|_| !step.is_separated) else { return Ok(step) };
        for (bond, ratio) in batch(body, statics, strain, first, 1.0) {
            statics.pass(body, (bond, ratio))?;
            step.bonds.push(bond);
        }
    }
}

/// Displacements to begin with: those before, in proportion where the load is proportional, otherwise moved along with the
/// fields of the drives.
fn predict<const D: usize>(statics: &mut Statics<D>, (from, load): (f64, f64)) {
    if statics.loading.is_proportional() && from.abs() > 0.0 {
        statics.u.iter_mut().for_each(|u| *u *= load / from);
    } else {
        let loading = &statics.loading;
        for (node, u) in statics.u.as_chunks_mut::<D>().0.iter_mut().enumerate() {
            let (before, after) = (loading.field(node, from), loading.field(node, load));
            for k in 0..D {
                u[k] += after[k] - before[k];
            }
        }
    }
    statics.impose(load);
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
