//! Steps that have become too long for a body as it is now.

use crate::error::Error;
use crate::real::Real;

/// Steps from one comparison to the next.
pub(crate) const EVERY: u64 = 8;
/// Least length of the change of all displacements over a step, in spacings; below it roundoff decides.
const LEAST: f64 = 1e-3;
/// The quotient, over its limit, from which a step is too long. An oscillation that nonlinear forces hold at one amplitude has the
/// quotient of the limit itself.
const REACHED: f64 = 0.999;

/// Compares two successive evaluations of the bond forces, every eight steps.
///
/// With the change `w` of displacements over a step beyond that of the drives, the change of the bond forces, and `h M` of the unknowns
/// (inertial `h^2/m`), the quotient
///
/// $$ z = - \frac{w \cdot \Delta F}{w \cdot (h M)^{-1} w} $$
///
/// is a Rayleigh quotient of `h M K`, with `K` the mean of the tangent stiffness from one displacement to the other: it is at most
/// the `z` of the stiffest mode, by `1 + |a|/|w|` more where drives move the body by `a`. One beyond the limit of the scheme therefore
/// proves that the step is too long for the body as it is, and an instability that grows turns the change into that mode, so that
/// the quotient comes there.
/// It does not find an instability while bonds break in every step, one of a few nodes beside larger changes of many others, one of
/// a mobility that couples nodes, or one of a body with memory.
#[derive(Debug, Default)]
pub(crate) struct Swing<T> {
    u: Vec<T>,
    forces: Vec<T>,
    /// Lanes that may be compared at the next evaluation: no bond of theirs broke.
    lanes: u16,
}

/// Where and when forces were evaluated, and what is stable.
pub(crate) struct Evaluation<'a, const L: usize> {
    pub(crate) step: u64,
    pub(crate) time: f64,
    pub(crate) realisations: &'a [u64; L],
    /// `h`, in inertial dynamics its square.
    pub(crate) step_power: f64,
    pub(crate) dt: f64,
    pub(crate) limit: f64,
    pub(crate) spacing: f64,
    /// Change of the displacement of a node by the drives since the evaluation before.
    pub(crate) driven: &'a dyn Fn(usize, usize) -> f64,
}

impl<T: Real> Swing<T> {
    /// Whether the evaluation of a step is kept or compared.
    pub(crate) const fn is_due(&self, step: u64) -> bool {
        step.is_multiple_of(EVERY) || self.lanes != 0
    }

    /// Leaves lanes out of the next comparison.
    pub(crate) const fn leave_out(&mut self, lanes: u16) {
        self.lanes &= !lanes;
    }

    /// Keeps an evaluation, or compares it with the one before. `values` is `M` or `1/m` of each unknown, zero where a displacement is
    /// prescribed; lanes of which a bond has just broken are `broken`.
    ///
    /// # Errors
    /// [`Error::Swings`].
    pub(crate) fn check<const D: usize, const L: usize>(
        &mut self,
        (u, forces): (&[T], &[T]),
        values: &[T],
        broken: u16,
        at: &Evaluation<'_, L>,
    ) -> Result<(), Error> {
        let lanes = std::mem::take(&mut self.lanes) & !broken;
        if lanes != 0 {
            self.compare::<D, L>((u, forces), values, lanes, at)?;
        }
        if (at.step - 1).is_multiple_of(EVERY) {
            self.u.clear();
            self.u.extend_from_slice(u);
            self.forces.clear();
            self.forces.extend_from_slice(forces);
            self.lanes = u16::MAX;
        }
        Ok(())
    }

    fn compare<const D: usize, const L: usize>(
        &self,
        (u, forces): (&[T], &[T]),
        values: &[T],
        lanes: u16,
        at: &Evaluation<'_, L>,
    ) -> Result<(), Error> {
        let (mut pull, mut inertia, mut square) = ([0.0; L], [0.0; L], [0.0; L]);
        let most = values.iter().fold(0.0, |most: f64, value| most.max(value.to_f64()));
        let mut driven = 0.0;
        let now = u.as_chunks::<L>().0.iter().zip(forces.as_chunks::<L>().0);
        let before = self.u.as_chunks::<L>().0.iter().zip(self.forces.as_chunks::<L>().0);
        for (unknown, ((u, f), (u_before, f_before))) in now.zip(before).enumerate() {
            let (value, drive) = (values[unknown].to_f64(), (at.driven)(unknown / D, unknown % D));
            if value <= 0.0 {
                driven += drive * drive / most;
                continue;
            }
            driven += drive * drive / value;
            for lane in 0..L {
                let change = (u[lane] - u_before[lane]).to_f64() - drive;
                pull[lane] -= change * (f[lane] - f_before[lane]).to_f64();
                inertia[lane] += change * change / value;
                square[lane] += change * change;
            }
        }
        let least = (LEAST * at.spacing).powi(2);
        for lane in (0..L).filter(|lane| lanes & 1 << lane != 0) {
            let beyond = 1.0 + (driven / inertia[lane]).sqrt();
            let value = at.step_power * pull[lane] / (inertia[lane] * beyond);
            if square[lane] > least && value > REACHED * at.limit {
                return Err(Error::Swings {
                    step: at.step,
                    time: at.time,
                    node: self.farthest::<D, L>(u, values, lane),
                    realisation: at.realisations[lane],
                    value,
                    limit: at.limit,
                    dt: at.dt,
                });
            }
        }
        Ok(())
    }

    /// The node with the largest change.
    fn farthest<const D: usize, const L: usize>(
        &self,
        u: &[T],
        values: &[T],
        lane: usize,
    ) -> usize {
        let (mut farthest, mut most) = (0, -1.0);
        for unknown in (0..values.len()).filter(|&unknown| values[unknown].to_f64() > 0.0) {
            let place = unknown * L + lane;
            let change = (u[place] - self.u[place]).to_f64().abs();
            if change > most {
                (farthest, most) = (unknown / D, change);
            }
        }
        farthest
    }
}
