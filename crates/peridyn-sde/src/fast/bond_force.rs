//! The force of bonds: the only text from which the passes over lattices, lists and lanes are made.
//!
//! A pass reads `xi` and `eta` of bonds. [`component`] gives direction and relative squared elongation, [`SquaredElongation`] the
//! pull. A [`Pass`] makes of these the number that is added at both ends of a bond: the tension over the length of a bond of a pair
//! potential, its part of both dilatations, or its tension in a linear peridynamic solid. Reading and adding are written three times,
//! for places in memory that have nothing in common:
//!
//! - a lattice reads `N` registers of neighbouring sites, whose constants and sums stay in registers over all vectors;
//! - realisations read the lanes of two nodes, one bond after the other;
//! - a list of one realisation has a bond to scattered nodes in each lane. It computes components of a node side by side, before
//!   the registers of bonds: filling these from places known only at run time costs more than the force itself.
//!
//! A common function would take these places as arguments; the compiler then keeps addresses where the sums would be.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into a dispatched function is not compiled for its registers"
)]

use simd_lanes::{Lanes, MOST_LANES, Mask, Registers, Work};

use super::LaneBits;
use crate::real::Real;

/// What a visit of all bonds adds at both ends of each.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    /// The force of a pair potential.
    PairForce,
    /// `omega beta V_i V_j |xi|^2 s`, the part of a bond in the dilatations of a linear peridynamic solid.
    Dilatation,
    /// The force of a linear peridynamic solid, after the dilatations.
    SolidForce,
}

/// The kind of a visit, known when it is compiled.
pub(super) trait Pass {
    const KIND: Kind;
    /// Whether both ends get the same number; they get opposite forces.
    const IS_DILATATION: bool = matches!(Self::KIND, Kind::Dilatation);
}

/// [`Kind::PairForce`].
pub(super) struct PairForce;
/// [`Kind::Dilatation`].
pub(super) struct Dilatation;
/// [`Kind::SolidForce`].
pub(super) struct SolidForce;

impl Pass for PairForce {
    const KIND: Kind = Kind::PairForce;
}

impl Pass for Dilatation {
    const KIND: Kind = Kind::Dilatation;
}

impl Pass for SolidForce {
    const KIND: Kind = Kind::SolidForce;
}

/// The stretch of bonds from relative squared elongation and pull: `sqrt(1 + w) - 1 = (1 + w) (1 - p) - 1`.
#[inline(always)]
pub(super) fn stretch<V: Lanes, const LINEAR: bool>(w: V, pull: V) -> V {
    if LINEAR { pull } else { w - (pull + w * pull) }
}

/// The tension over length of bonds of a linear peridynamic solid, from `phi tau = omega beta V_i V_j (tau_i + tau_j)` and the
/// stiffness over length at a fixed dilatation. With linear strains the tension of the dilatation acts along `xi` at rest.
#[inline(always)]
pub(super) fn solid_tension<V: Lanes, const LINEAR: bool>(stiffness: V, phi_tau: V, pull: V) -> V {
    let own = if LINEAR { stiffness } else { stiffness - phi_tau };
    own * pull + phi_tau
}

/// The same over `phi`, for bonds of one `phi` between nodes of many weighted volumes, from `B/m_i - tau_i + B/m_j - tau_j` and
/// `tau_i + tau_j`.
#[inline(always)]
pub(super) fn solid_tension_over_weight<V: Lanes, const LINEAR: bool>(
    sigma: V,
    tau: V,
    pull: V,
) -> V {
    let own = if LINEAR { (sigma + tau) * pull } else { sigma * pull };
    own + tau
}

/// Numbers of bonds, zero where a bond is not intact.
#[inline(always)]
pub(super) fn intact<T: Real, R: Registers<T>>(
    registers: R,
    of_bonds: R::Vector,
    intact: LaneBits,
) -> R::Vector {
    let all = LaneBits::MAX >> (MOST_LANES - R::N);
    if R::MASKS_ARE_BITS || intact & all != all {
        let intact = registers.mask(intact.into());
        return R::Vector::select(intact, of_bonds, registers.splat(T::ZERO));
    }
    of_bonds
}

/// One component of a bond: `xi + eta` (`xi` where strains are linear), and its part of the growth of the squared length,
/// `eta (2 xi + eta)` or `2 eta xi`. With both arguments negated, the second is bitwise the same.
#[inline(always)]
pub(super) fn component<N: Lanes, const LINEAR: bool>(xi: N, eta: N) -> (N, N) {
    let direction = if LINEAR { xi } else { xi + eta };
    (direction, eta * (xi + direction))
}

/// Direction and elongation of bonds, a bond in each lane.
pub(super) struct Separation<V, const D: usize> {
    /// `xi + eta`, or `xi` where strains are linear.
    pub(super) direction: [V; D],
    pub(super) elongation: SquaredElongation<V>,
}

impl<V: Lanes<Number: Real>, const D: usize> Separation<V, D> {
    /// The separation of bonds `xi` whose ends moved apart by `eta`.
    #[inline(always)]
    pub(super) fn new<R: Registers<V::Number, Vector = V>, const LINEAR: bool>(
        registers: R,
        (xi, inverse_square): (&[V; D], V),
        eta: &[V; D],
        intact: LaneBits,
    ) -> Self {
        let (mut square, mut direction) = (registers.splat(V::Number::ZERO), *xi);
        for k in 0..D {
            let (along, part) = component::<V, LINEAR>(xi[k], eta[k]);
            direction[k] = along;
            square = if k == 0 { part } else { square + part };
        }
        let elongation = self::intact(registers, square * inverse_square, intact);
        Self { direction, elongation: SquaredElongation(elongation) }
    }
}

/// The relative squared elongation `w = |xi + eta|^2/|xi|^2 - 1`, or `2 xi eta/|xi|^2`; zero where the bond is broken.
pub(super) struct SquaredElongation<V>(pub(super) V);

impl<V: Lanes<Number: Real>> SquaredElongation<V> {
    /// The force over stiffness over length along `direction`: `1 - 1/sqrt(1 + w)`, the stretch over the stretched length;
    /// with linear strains `w/2`. Bonds at their limit carry none, and `found` gets their lanes. No bond has a limit below `limit`;
    /// `own` are those of the bonds, which are read where an elongation reaches that.
    ///
    /// The pull of a bond depends on no other lane, so that the bits do not depend on how many there are.
    #[inline(always)]
    pub(super) fn pull<R: Registers<V::Number, Vector = V>, const LINEAR: bool>(
        self,
        registers: R,
        limit: V,
        own: impl FnOnce() -> V,
        found: impl FnOnce(LaneBits),
    ) -> V {
        let pull = self.near_pull::<LINEAR>();
        if !self.is_beyond(Self::near::<LINEAR>(limit)) {
            return pull;
        }
        let (mut values, mut limits) =
            ([V::Number::ZERO; MOST_LANES], [V::Number::ZERO; MOST_LANES]);
        registers.store_at(self.0, &mut values, 0);
        registers.store_at(own(), &mut limits, 0);
        registers.apart(Far::<_, _, LINEAR> { values: &mut values, limits: &limits, found });
        registers.load_at(&values, 0)
    }

    /// Below which `|w|` no bond is at its limit and [`near_pull`](Self::near_pull) is its pull.
    #[inline(always)]
    fn near<const LINEAR: bool>(limit: V) -> V {
        if LINEAR { limit } else { limit.min(limit.splat(V::Number::SERIES_RANGE)) }
    }

    /// Whether in any lane `|w| >= limit`.
    #[inline(always)]
    fn is_beyond(&self, limit: V) -> bool {
        self.0.abs().at_least(limit).any()
    }

    /// `1 - 1/sqrt(1 + w)` as `w/(sqrt(1 + w) (1 + sqrt(1 + w)))`, which loses no digits.
    #[inline(always)]
    fn closed_pull(&self) -> V {
        let one = self.0.splat(V::Number::of(1.0));
        let root = (one + self.0).sqrt();
        self.0 / (root * (one + root))
    }

    /// [`pull`](Self::pull) of bonds in the range of the series, below their limit.
    #[inline(always)]
    fn near_pull<const LINEAR: bool>(&self) -> V {
        let w = self.0;
        if LINEAR {
            return w * w.splat(V::Number::of(0.5));
        }
        // In pairs, with powers of w^2: half as many operations wait for each other as one by one.
        let (pairs, square) = (V::Number::SERIES.as_chunks::<2>().0, w * w);
        let pair = |&[even, odd]: &[V::Number; 2]| w.splat(even) + w * w.splat(odd);
        let mut sum = pair(&pairs[pairs.len() - 1]);
        for of in pairs[..pairs.len() - 1].iter().rev() {
            sum = pair(of) + sum * square;
        }
        sum * w
    }
}

/// The pull of a register in which not all bonds are near: a function of its own, so that the common path keeps its registers.
struct Far<'a, T, F, const LINEAR: bool> {
    /// The relative squared elongations of bonds, then their pulls.
    values: &'a mut [T; MOST_LANES],
    limits: &'a [T; MOST_LANES],
    /// Gets the lanes of bonds at their limit.
    found: F,
}

impl<T: Real, F: FnOnce(LaneBits), const LINEAR: bool> Work<T> for Far<'_, T, F, LINEAR> {
    type Output = ();

    /// The rule of bond failure in a force evaluation: a bond whose elongation is at its limit.
    #[inline(always)]
    fn run<R: Registers<T>>(self, registers: R) {
        let mut elongation = SquaredElongation(registers.load_at(self.values, 0));
        let reached = elongation.0.at_least(registers.load_at(self.limits, 0));
        if reached.any() {
            (self.found)(lanes_of(reached));
            elongation.0 = R::Vector::select(reached, registers.splat(T::ZERO), elongation.0);
        }
        let mut pull = elongation.near_pull::<LINEAR>();
        if !LINEAR {
            let is_far = elongation.0.abs().at_least(registers.splat(T::SERIES_RANGE));
            pull = R::Vector::select(is_far, elongation.closed_pull(), pull);
        }
        registers.store_at(pull, self.values, 0);
    }
}

/// A mask as bonds store it.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "at most as many lanes as bits")]
fn lanes_of(mask: impl Mask) -> LaneBits {
    mask.bits() as LaneBits
}
