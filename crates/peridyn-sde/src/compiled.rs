//! What is compiled with this crate, once for all programs that run it: bodies and their motion in one to three dimensions, one
//! realisation or as many as the widest register holds. A body from outside compiles itself, and other numbers of lanes their motion.

use std::any::Any;

use crate::bodies::body::{AtStrength, Body};
use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::breaking::broken_bond::BrokenBond;
use crate::breaking::crossing::Crossing;
use crate::dynamics::config::SimulationConfig;
use crate::dynamics::loading::Loading;
use crate::dynamics::motion::Motion;
use crate::dynamics::report::StepReport;
use crate::error::Error;
use crate::fast::{BondList, LatticeBody, SolidLattice, SolidList};
use crate::material::strain::Strain;
use crate::real::Real;
use crate::solid::SolidBonds;
use crate::steps::Stepper;

/// What is done to a body in time.
pub(crate) struct Motions<T, const D: usize, const L: usize> {
    pub(crate) start: Start<T, D, L>,
    pub(crate) step: Step<T, D, L>,
    /// Forces at displacements at which no bond breaks.
    pub(crate) evaluate: fn(&mut Motion<T, D, L>, &mut dyn Body<T, D, L>) -> Result<(), Error>,
    pub(crate) cut: Cut<T, D, L>,
}

/// A body at rest: its motion, the scheme of it, and the largest `z` or the square of `omega h`.
type Start<T, const D: usize, const L: usize> =
    fn(
        &mut dyn Body<T, D, L>,
        Loading<D>,
        SimulationConfig,
        [u64; L],
    ) -> Result<(Motion<T, D, L>, Stepper<T>, f64), Error>;

/// One step.
type Step<T, const D: usize, const L: usize> =
    fn(&mut Motion<T, D, L>, &mut Stepper<T>, &mut dyn Body<T, D, L>) -> Result<StepReport, Error>;

/// Cuts bonds in all lanes.
type Cut<T, const D: usize, const L: usize> =
    fn(&mut Motion<T, D, L>, &mut dyn Body<T, D, L>, &[usize]) -> Result<(), Error>;

impl<T: Real, const D: usize, const L: usize> Motions<T, D, L> {
    const HERE: Self = Self {
        start: |body, loading, config, realisations| {
            config.check()?;
            let mut motion = Motion::new(body, loading, config, realisations)?;
            let relative_step = motion.stable_step(body)?;
            motion.impose_displacements();
            motion.evaluate_intact(body)?;
            let stepper = Stepper::new(&motion.config.dynamics, motion.u.len());
            Ok((motion, stepper, relative_step))
        },
        step: |motion, stepper, body| {
            motion.begin_step(body);
            stepper.step(motion, body)?;
            motion.end_step(body)
        },
        evaluate: Motion::evaluate_intact,
        cut: Motion::cut,
    };
}

/// What goes through all bonds of a list.
pub(crate) struct Lists<T, const D: usize, const L: usize> {
    pub(crate) pull: Pull<BondList<T, D, L>, T>,
    pub(crate) cross: Cross<T, D, L>,
}

/// Forces of a body.
type Pull<B, T> = fn(&mut B, Strain, &[T], &mut [T], AtStrength<'_>) -> Result<(), Error>;

/// Bonds that crossed their strength from one displacement to another.
type Cross<T, const D: usize, const L: usize> = fn(
    &mut BondList<T, D, L>,
    &[T],
    &[T],
    Option<&mut Crossing<L>>,
    &mut Vec<BrokenBond>,
) -> Result<(), Error>;

impl<T: Real, const D: usize, const L: usize> Lists<T, D, L> {
    const HERE: Self = Self { pull: BondList::pull, cross: BondList::cross };
}

/// What goes through all bonds of a lattice.
pub(crate) struct Lattices<T, const D: usize> {
    pub(crate) new: fn(Nodes<D>, Bonds, Strain, f64) -> Result<LatticeBody<T, D>, Error>,
    pub(crate) pull: Pull<LatticeBody<T, D>, T>,
}

impl<T: Real, const D: usize> Lattices<T, D> {
    const HERE: Self = Self { new: LatticeBody::undamaged, pull: LatticeBody::pull };
}

/// What goes through all bonds of a linear peridynamic solid on a lattice.
pub(crate) struct Solids<T, const D: usize> {
    pub(crate) new: fn(Nodes<D>, SolidBonds, Strain, f64) -> Result<SolidLattice<T, D>, Error>,
    pub(crate) pull: Pull<SolidLattice<T, D>, T>,
}

impl<T: Real, const D: usize> Solids<T, D> {
    const HERE: Self = Self { new: SolidLattice::undamaged, pull: SolidLattice::pull };
}

/// What goes through all bonds of a linear peridynamic solid in a list.
pub(crate) struct SolidLists<T, const D: usize, const L: usize> {
    pub(crate) pull: Pull<SolidList<T, D, L>, T>,
}

impl<T: Real, const D: usize, const L: usize> SolidLists<T, D, L> {
    const HERE: Self = Self { pull: SolidList::pull };
}

/// All of them.
struct All<T, const D: usize, const L: usize> {
    motions: Motions<T, D, L>,
    lists: Lists<T, D, L>,
    lattices: Lattices<T, D>,
    solids: Solids<T, D>,
    solid_lists: SolidLists<T, D, L>,
}

impl<T: Real, const D: usize, const L: usize> All<T, D, L> {
    const HERE: Self = Self {
        motions: Motions::HERE,
        lists: Lists::HERE,
        lattices: Lattices::HERE,
        solids: Solids::HERE,
        solid_lists: SolidLists::HERE,
    };

    /// Whether they are compiled with this crate. Unit tests compile what they run.
    const COMPILED: bool =
        !cfg!(test) && D >= 1 && D <= 3 && (L == 1 || L * size_of::<T>() == WIDEST);

    fn of_this_crate() -> &'static Self {
        match with_this_crate(T::NAME, D, L).downcast_ref() {
            Some(all) => all,
            None => unreachable!("bodies in one to three dimensions are compiled"),
        }
    }
}

/// Bytes of the widest register.
const WIDEST: usize = 64;

/// What is compiled, as its own type.
#[inline(never)]
fn with_this_crate(
    number: &str,
    dimension: usize,
    lanes: usize,
) -> &'static (dyn Any + Send + Sync) {
    match (number, lanes) {
        (f64::NAME, 1) => in_dimension::<f64, 1>(dimension),
        (f64::NAME, 8) => in_dimension::<f64, 8>(dimension),
        (f32::NAME, 1) => in_dimension::<f32, 1>(dimension),
        (f32::NAME, 16) => in_dimension::<f32, 16>(dimension),
        _ => &(),
    }
}

fn in_dimension<T: Real, const L: usize>(dimension: usize) -> &'static (dyn Any + Send + Sync) {
    match dimension {
        1 => const { &All::<T, 1, L>::HERE },
        2 => const { &All::<T, 2, L>::HERE },
        3 => const { &All::<T, 3, L>::HERE },
        _ => &(),
    }
}

/// The motion of bodies.
pub(crate) fn motions<T: Real, const D: usize, const L: usize>() -> &'static Motions<T, D, L> {
    if const { All::<T, D, L>::COMPILED } {
        &All::of_this_crate().motions
    } else {
        const { &Motions::HERE }
    }
}

/// The passes over lists of bonds.
pub(crate) fn lists<T: Real, const D: usize, const L: usize>() -> &'static Lists<T, D, L> {
    if const { All::<T, D, L>::COMPILED } {
        &All::of_this_crate().lists
    } else {
        const { &Lists::HERE }
    }
}

/// The passes over lattices.
pub(crate) fn lattices<T: Real, const D: usize>() -> &'static Lattices<T, D> {
    if const { All::<T, D, 1>::COMPILED } {
        &All::<T, D, 1>::of_this_crate().lattices
    } else {
        const { &Lattices::HERE }
    }
}

/// The passes over lattices of a linear peridynamic solid.
pub(crate) fn solids<T: Real, const D: usize>() -> &'static Solids<T, D> {
    if const { All::<T, D, 1>::COMPILED } {
        &All::<T, D, 1>::of_this_crate().solids
    } else {
        const { &Solids::HERE }
    }
}

/// The passes over lists of a linear peridynamic solid.
pub(crate) fn solid_lists<T: Real, const D: usize, const L: usize>() -> &'static SolidLists<T, D, L>
{
    if const { All::<T, D, L>::COMPILED } {
        &All::of_this_crate().solid_lists
    } else {
        const { &SolidLists::HERE }
    }
}
