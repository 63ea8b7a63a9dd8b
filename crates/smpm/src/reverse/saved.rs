//! The numbers of a run at the begin of a step, in rows, and where each of them is.

use crate::config::Transfer;
use crate::error::Error;
use crate::number::Number;
use crate::simulation::Simulation;
use crate::snapshot::Clock;

/// Numbers of a particle that are not of its material's state: six of the stress, viscosity, volume, wave speed, rate.
const CONDITION: usize = 10;

/// Where the numbers of a particle of a body are in its row.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    dimension: usize,
    with_affine: bool,
    /// Numbers of the material that a step may change.
    pub(super) n_changing: usize,
    /// Numbers of a row.
    pub(super) len: usize,
    /// Numbers of the material that no step changes and that depend on the coefficients: their places behind
    /// [`state`](Self::state).
    pub(super) constants: Vec<usize>,
}

/// What derivatives by a number of a row are kept in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Position(usize),
    Velocity(usize),
    /// APIC's matrix, row and column.
    Affine(usize, usize),
    Mass,
    /// Of the material: [`Layout::slot`].
    Material(usize),
    /// Nothing depends on it.
    None,
}

impl Layout {
    fn mass(&self) -> usize {
        2 * self.dimension + if self.with_affine { self.dimension * self.dimension } else { 0 }
    }

    /// Where the condition begins.
    pub(super) fn condition(&self) -> usize {
        self.mass() + 2
    }

    /// Where the state of the material begins.
    pub(super) fn state(&self) -> usize {
        self.condition() + CONDITION
    }

    /// Derivatives by numbers of the material that are kept: of six stresses, viscosity, volume, wave speed, then of what steps
    /// change, then of constants.
    pub(super) fn n_slots(&self) -> usize {
        CONDITION - 1 + self.n_changing + self.constants.len()
    }

    /// Which number of the condition and state belongs to a slot.
    pub(super) fn number_of(&self, slot: usize) -> usize {
        match slot.checked_sub(CONDITION - 1) {
            None => slot,
            Some(k) if k < self.n_changing => CONDITION + k,
            Some(k) => CONDITION + self.constants[k - self.n_changing],
        }
    }

    /// What a number of the row is.
    pub(super) fn kind(&self, number: usize) -> Kind {
        let d = self.dimension;
        match number {
            _ if number < d => Kind::Position(number),
            _ if number < 2 * d => Kind::Velocity(number - d),
            _ if number < self.mass() => {
                let entry = number - 2 * d;
                Kind::Affine(entry / d, entry % d)
            }
            _ if number == self.mass() => Kind::Mass,
            _ if number < self.condition() => Kind::None,
            _ => {
                let of_material = number - self.condition();
                let slots = 0..self.n_slots();
                let found = slots.into_iter().find(|&slot| self.number_of(slot) == of_material);
                found.map_or(Kind::None, Kind::Material)
            }
        }
    }
}

/// The state of a run, in the order of memory.
#[derive(Debug, Clone)]
pub(super) struct Saved {
    pub(super) clock: Clock,
    pub(super) bodies: Vec<SavedBody>,
}

/// Rows of the particles of a body, and their numbers.
#[derive(Debug, Clone)]
pub(super) struct SavedBody {
    pub(super) rows: Vec<f64>,
    pub(super) number: Vec<u32>,
}

impl Saved {
    /// Bytes of a state.
    pub(super) fn bytes(&self) -> usize {
        let of = |body: &SavedBody| 8 * body.rows.len() + 4 * body.number.len();
        self.bodies.iter().map(of).sum()
    }

    pub(super) fn of<const D: usize>(run: &Simulation<f64, D>, layouts: &[Layout]) -> Self {
        let bodies = run.bodies().iter().zip(layouts).map(|(body, layout)| {
            let mut rows = Vec::with_capacity(layout.len * body.n_particles());
            for place in 0..body.n_particles() {
                let _ = body.show_numbers(place, &mut |number: &mut f64| rows.push(*number));
            }
            SavedBody { rows, number: body.particles.number.clone() }
        });
        Self { clock: run.clock(), bodies: bodies.collect() }
    }

    /// Brings a run to this state.
    pub(super) fn put<const D: usize>(&self, run: &mut Simulation<f64, D>, layouts: &[Layout]) {
        run.set_clock(self.clock);
        for ((body, saved), layout) in run.bodies_mut().iter_mut().zip(&self.bodies).zip(layouts) {
            body.particles.number.clone_from(&saved.number);
            for (place, row) in saved.rows.chunks_exact(layout.len).enumerate() {
                let mut numbers = row.iter();
                let _ = body.visit_numbers(place, &mut |number: &mut f64| {
                    if let Some(&kept) = numbers.next() {
                        *number = kept;
                    }
                });
            }
            body.renumbered();
        }
    }
}

/// Where the numbers of each body are; constants are those of `depends`, a run whose numbers have derivatives.
///
/// # Errors
/// [`Error::MaterialNotStored`] for a material that does not show its state.
pub(super) fn layouts<S: Number, const D: usize>(
    run: &Simulation<S, D>,
    depends: impl Fn(&S) -> bool,
) -> Result<Vec<Layout>, Error> {
    let with_affine = run.config().transfer == Transfer::Apic;
    let layout = |(number, body): (usize, &crate::body::Body<S, D>)| {
        let n_changing = body.points.n_changing(0);
        let (dimension, constants) = (D, vec![]);
        let mut layout = Layout { dimension, with_affine, n_changing, len: 0, constants };
        let first = layout.state();
        for place in 0..body.n_particles() {
            let mut n = 0_usize;
            let is_whole = body.show_numbers(place, &mut |value: &mut S| {
                let constant = n.checked_sub(first + n_changing).map(|_| n - first);
                if let Some(constant) = constant.filter(|_| depends(value))
                    && !layout.constants.contains(&constant)
                {
                    layout.constants.push(constant);
                }
                n += 1;
            });
            if !is_whole {
                return Err(Error::MaterialNotStored { body: number });
            }
            layout.len = n;
        }
        layout.constants.sort_unstable();
        Ok(layout)
    };
    run.bodies().iter().enumerate().map(layout).collect()
}
