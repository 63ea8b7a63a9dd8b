//! What gravity, planes and a rigid body have given to the others.

/// What gravity, the planes and a rigid body have given to the bodies since the start; the rigid body is none of them.
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
        let (gravity_impulse, rigid_impulse) = ([0.0; D], [0.0; D]);
        let (gravity_work, rigid_work, momenta) = (0.0, 0.0, [momentum; 2]);
        let reactions = vec![[0.0; D]; n_planes];
        Self { gravity_impulse, gravity_work, reactions, rigid_impulse, rigid_work, momenta }
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
            let impulse = change - self.gravity_impulse[k] - planes;
            work += velocity[k] * (impulse - self.rigid_impulse[k]);
            self.rigid_impulse[k] = impulse;
        }
        self.rigid_work += work;
        work
    }

    /// Calls with every number, to be read or written.
    pub(crate) fn visit_numbers(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        let vectors = self.gravity_impulse.iter_mut().chain(&mut self.rigid_impulse);
        vectors.chain(self.momenta.as_flattened_mut()).for_each(&mut *visit);
        [&mut self.gravity_work, &mut self.rigid_work].into_iter().for_each(&mut *visit);
        self.reactions.iter_mut().flatten().for_each(visit);
    }
}
