//! What gravity and planes have given to the bodies.

/// What gravity and the planes have given to the bodies since the start.
///
/// The momentum of all bodies changes by the sum of these impulses, within roundoff; where axisymmetric along the axis alone.
/// Symmetry planes, clamped planes and rigid walls without friction do no work.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct External<const D: usize> {
    /// Impulse of gravity (momentum).
    pub gravity_impulse: [f64; D],
    /// Work of gravity: its impulse in each step times the mean of the velocities before and after (energy).
    pub gravity_work: f64,
    /// Impulse of each plane (momentum), in the order of [`Config::boundaries`](crate::Config::boundaries); where axisymmetric the axis
    /// follows unless it is one of them. Where planes meet, a component goes to the plane normal to it, else to the first that acts
    /// along itself.
    pub reactions: Vec<[f64; D]>,
    /// Momentum of the bodies after the last step, along gravity.
    momentum: [f64; D],
}

impl<const D: usize> External<D> {
    pub(crate) fn none(n_planes: usize) -> Self {
        let (zero, reactions) = ([0.0; D], vec![[0.0; D]; n_planes]);
        Self { gravity_impulse: zero, gravity_work: 0.0, reactions, momentum: zero }
    }

    /// Adds the impulse of gravity on a mass over a step, and its work.
    pub(crate) fn add_gravity(&mut self, mass: f64, impulse: [f64; D], momentum: &[f64; D]) {
        for k in 0..D {
            self.gravity_impulse[k] += impulse[k];
            self.gravity_work += impulse[k] * 0.5 * (self.momentum[k] + momentum[k]) / mass;
        }
        self.momentum = *momentum;
    }

    /// Calls with every number, to be read or written.
    pub(crate) fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        self.gravity_impulse.iter_mut().chain(&mut self.momentum).for_each(&mut *visit);
        visit(&mut self.gravity_work);
        self.reactions.iter_mut().flatten().for_each(visit);
    }
}
