//! Boundary conditions and loads: prescribed displacements and velocities, forces.

use crate::bodies::nodes::Nodes;
use crate::error::{Error, exists, finite, positive, same_length};

/// A number over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Program {
    /// The same always.
    Constant(f64),
    /// `rate t`.
    Linear {
        /// Per unit of time.
        rate: f64,
    },
    /// `rate t` up to a time, then what was reached.
    Ramp {
        /// Per unit of time.
        rate: f64,
        /// Until when (time).
        until: f64,
    },
}

impl Program {
    /// The number at a time.
    #[must_use]
    pub fn at(self, t: f64) -> f64 {
        match self {
            Self::Constant(value) => value,
            Self::Linear { rate } => rate * t,
            Self::Ramp { rate, until } => rate * t.min(until),
        }
    }

    fn check(self) -> Result<(), Error> {
        match self {
            Self::Constant(value) => finite("value of a program", value),
            Self::Linear { rate } => finite("rate of a program", rate),
            Self::Ramp { rate, until } => {
                finite("rate of a ramp", rate)?;
                positive("end of a ramp", until)
            }
        }
    }
}

/// Prescribed displacements of nodes, and forces on them.
///
/// A body that a ramp moves at its ends alone breaks there: the motion travels inwards as fast as the body relaxes, over
/// `O(n^2)` overdamped steps. With a predictor every free node moves along with the affine field of the ends, and relaxation has
/// only the difference to make.
#[derive(Debug, Clone, PartialEq)]
pub struct Loading<const D: usize> {
    n_nodes: usize,
    drives: Vec<Drive<D>>,
    loads: Vec<Load<D>>,
    prescribed: Vec<[bool; D]>,
}

/// `u = program(t) field` where prescribed; elsewhere the change of that in a step is added.
#[derive(Debug, Clone, PartialEq)]
struct Drive<const D: usize> {
    program: Program,
    field: Vec<[f64; D]>,
}

/// `program(t) force` on nodes.
#[derive(Debug, Clone, PartialEq)]
struct Load<const D: usize> {
    program: Program,
    nodes: Vec<usize>,
    /// On each of them (force).
    force: Vec<[f64; D]>,
}

impl<const D: usize> Loading<D> {
    /// No condition, on a body of so many nodes.
    #[must_use]
    pub fn new(n_nodes: usize) -> Self {
        Self {
            n_nodes,
            drives: Vec::new(),
            loads: Vec::new(),
            prescribed: vec![[false; D]; n_nodes],
        }
    }

    /// Fixes nodes in all directions.
    ///
    /// # Errors
    /// [`Error::Length`] for a node that does not exist.
    pub fn hold(self, nodes: &[usize]) -> Result<Self, Error> {
        self.displace(nodes, [true; D], [0.0; D], Program::Constant(0.0))
    }

    /// Prescribes the velocity of nodes (length over time) in some directions.
    ///
    /// # Errors
    /// As [`Loading::displace`].
    pub fn velocity(
        self,
        nodes: &[usize],
        directions: [bool; D],
        velocity: [f64; D],
    ) -> Result<Self, Error> {
        self.displace(nodes, directions, velocity, Program::Linear { rate: 1.0 })
    }

    /// Prescribes the displacement `program(t) unit` of nodes (lengths) in some directions.
    ///
    /// # Errors
    /// [`Error::Length`] for a node that does not exist, [`Error::Parameter`] for a number that is not finite or a ramp
    /// that ends at no time after 0, [`Error::PrescribedTwice`].
    pub fn displace(
        mut self,
        nodes: &[usize],
        directions: [bool; D],
        unit: [f64; D],
        program: Program,
    ) -> Result<Self, Error> {
        let mut field = vec![[0.0; D]; self.n_nodes];
        self.prescribe(nodes, directions)?;
        for &node in nodes {
            field[node] = std::array::from_fn(|k| if directions[k] { unit[k] } else { 0.0 });
        }
        self.drive(field, program)?;
        Ok(self)
    }

    /// Prescribes the affine field `u = program(t) gradient x` at some nodes, rows of `gradient` by component; free nodes move along
    /// with its change in each step.
    ///
    /// # Errors
    /// As [`Loading::displace`].
    pub fn stretch(
        mut self,
        nodes: &Nodes<D>,
        prescribed: &[usize],
        directions: [bool; D],
        gradient: [[f64; D]; D],
        program: Program,
    ) -> Result<Self, Error> {
        same_length("nodes", nodes.positions().len(), self.n_nodes)?;
        self.prescribe(prescribed, directions)?;
        let field = nodes
            .positions()
            .iter()
            .map(|x| std::array::from_fn(|row| (0..D).map(|k| gradient[row][k] * x[k]).sum()));
        self.drive(field.collect(), program)?;
        Ok(self)
    }

    /// A force on each of some nodes (force): `program(t) force`.
    ///
    /// # Errors
    /// [`Error::Length`], [`Error::Parameter`], as [`Loading::displace`].
    pub fn force(
        mut self,
        nodes: &[usize],
        force: &[[f64; D]],
        program: Program,
    ) -> Result<Self, Error> {
        program.check()?;
        same_length("forces of a load", force.len(), nodes.len())?;
        self.exist(nodes)?;
        for &value in force.iter().flatten() {
            finite("force of a load", value)?;
        }
        self.loads.push(Load { program, nodes: nodes.to_vec(), force: force.to_vec() });
        Ok(self)
    }

    /// Which displacement components of which nodes are prescribed.
    #[must_use]
    pub fn prescribed(&self) -> &[[bool; D]] {
        &self.prescribed
    }

    /// The displacement that the fields of all drives have at a node and a time.
    pub(crate) fn field(&self, node: usize, t: f64) -> [f64; D] {
        let mut sum = [0.0; D];
        for drive in &self.drives {
            let value = drive.program.at(t);
            for k in 0..D {
                sum[k] += value * drive.field[node][k];
            }
        }
        sum
    }

    pub(crate) fn is_driven(&self) -> bool {
        self.drives.iter().any(|drive| drive.program != Program::Constant(0.0))
    }

    /// Whether all displacements and loads grow in proportion to time.
    pub(crate) fn is_proportional(&self) -> bool {
        let programs = self.drives.iter().map(|drive| &drive.program);
        let mut all = programs.chain(self.loads.iter().map(|load| &load.program));
        all.all(|program| {
            matches!(program, Program::Linear { .. }) || *program == Program::Constant(0.0)
        })
    }

    /// Calls `add(node, force)` for every load at a time.
    pub(crate) fn for_each_force(&self, t: f64, mut add: impl FnMut(usize, [f64; D])) {
        for load in &self.loads {
            let value = load.program.at(t);
            for (&node, force) in load.nodes.iter().zip(&load.force) {
                add(node, force.map(|f| value * f));
            }
        }
    }

    pub(crate) fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    fn exist(&self, nodes: &[usize]) -> Result<(), Error> {
        nodes.iter().try_for_each(|&node| exists("the number of a node", node, self.n_nodes))
    }

    fn prescribe(&mut self, nodes: &[usize], directions: [bool; D]) -> Result<(), Error> {
        self.exist(nodes)?;
        for &node in nodes {
            for k in 0..D {
                if self.prescribed[node][k] && directions[k] {
                    return Err(Error::PrescribedTwice { node, component: k });
                }
                self.prescribed[node][k] |= directions[k];
            }
        }
        Ok(())
    }

    fn drive(&mut self, field: Vec<[f64; D]>, program: Program) -> Result<(), Error> {
        program.check()?;
        for &value in field.iter().flatten() {
            finite("a prescribed displacement", value)?;
        }
        self.drives.push(Drive { program, field });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_what_they_say() {
        let ramp = Program::Ramp { rate: 2.0, until: 3.0 };
        assert!((ramp.at(1.0) - 2.0).abs() < 1e-15 && (ramp.at(7.0) - 6.0).abs() < 1e-15);
        assert!(matches!(
            Program::Ramp { rate: 2.0, until: 0.0 }.check(),
            Err(Error::Parameter { .. })
        ));
    }

    #[test]
    fn a_displacement_prescribed_twice_is_refused() {
        let loading = Loading::<2>::new(3).hold(&[0]).unwrap();
        let error = loading.velocity(&[1, 0], [false, true], [0.0, 1.0]).unwrap_err();
        assert_eq!(error, Error::PrescribedTwice { node: 0, component: 1 });
        assert!(Loading::<2>::new(3).hold(&[3]).is_err());
    }
}
