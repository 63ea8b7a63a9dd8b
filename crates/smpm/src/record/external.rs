//! What gravity, loads, planes and a rigid body have given to the others.

/// What gravity, loads, the planes and a rigid body have given to the bodies since the start; the rigid body is none of them.
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
    /// Impulse of the loads on surfaces (momentum).
    pub load_impulse: [f64; D],
    /// Work of the loads: the force on each particle times its displacement in each step (energy).
    pub load_work: f64,
    /// Impulse of each plane (momentum), in the order of [`Config::boundaries`](crate::Config::boundaries); where axisymmetric the axis
    /// follows unless it is one of them. Where planes meet, a component goes to the plane normal to it, else to the first that acts
    /// along itself.
    pub reactions: Vec<[f64; D]>,
    /// Impulse of the rigid body, if there is one (momentum): the change of momentum of all others less the other impulses, so that it
    /// has what [damping](crate::Config::damping) takes. Where axisymmetric that along the axis.
    pub rigid_impulse: [f64; D],
    /// Its work: the impulse times its velocity (energy).
    pub rigid_work: f64,
    /// Momentum at the start, and after the last step.
    momenta: [[f64; D]; 2],
}

impl<const D: usize> External<D> {
    /// At the start, with the momentum there.
    pub(crate) fn none(n_planes: usize, momentum: [f64; D]) -> Self {
        Self {
            gravity_impulse: [0.0; D],
            gravity_work: 0.0,
            load_impulse: [0.0; D],
            load_work: 0.0,
            reactions: vec![[0.0; D]; n_planes],
            rigid_impulse: [0.0; D],
            rigid_work: 0.0,
            momenta: [momentum; 2],
        }
    }

    /// Adds the impulse of the loads over a step, and their work.
    pub(crate) fn add_loads(&mut self, impulse: [f64; D], work: f64) {
        for k in 0..D {
            self.load_impulse[k] += impulse[k];
        }
        self.load_work += work;
    }

    /// Adds the impulse of gravity on a mass over a step, and its work.
    pub(crate) fn add_gravity(&mut self, mass: f64, impulse: [f64; D], momentum: &[f64; D]) {
        for k in 0..D {
            self.gravity_impulse[k] += impulse[k];
            self.gravity_work += impulse[k] * 0.5 * (self.momenta[1][k] + momentum[k]) / mass;
        }
        self.momenta[1] = *momentum;
    }

    /// Finds the impulse of a rigid body from those of a step that is complete; its work in the step.
    pub(crate) fn add_rigid(
        &mut self,
        velocity: &[f64; D],
        is_conserved: impl Fn(usize) -> bool,
    ) -> f64 {
        let mut work = 0.0;
        for k in (0..D).filter(|&k| is_conserved(k)) {
            let planes: f64 = self.reactions.iter().map(|reaction| reaction[k]).sum();
            let change = self.momenta[1][k] - self.momenta[0][k];
            let impulse = change - self.gravity_impulse[k] - self.load_impulse[k] - planes;
            work += velocity[k] * (impulse - self.rigid_impulse[k]);
            self.rigid_impulse[k] = impulse;
        }
        self.rigid_work += work;
        work
    }

    /// Calls with every number, to be read or written.
    pub(crate) fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let vectors = [&mut self.gravity_impulse, &mut self.load_impulse, &mut self.rigid_impulse];
        vectors.into_iter().flatten().for_each(&mut *visit);
        self.momenta.as_flattened_mut().iter_mut().for_each(&mut *visit);
        let work = [&mut self.gravity_work, &mut self.load_work, &mut self.rigid_work];
        work.into_iter().for_each(&mut *visit);
        self.reactions.iter_mut().flatten().for_each(visit);
    }
}
