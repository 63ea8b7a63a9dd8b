//! Transfers between the particles of a step and its nodes, and their adjoints.
//!
//! With the derivatives $\bar u$ of a response by a quantity `u`, particle-to-grid $p_i = \sum_p m_p (v_p + C_p a_{ip}) N_{ip}$ has the
//! adjoint
//!
//! $$ \bar v_p = m_p \sum_i \bar p_i N_{ip}, \quad \bar C_p = m_p \sum_i \bar p_i a_{ip}^T N_{ip}, \quad
//!    \bar x_p = \sum_i m_p \bar p_i \cdot (v_p + C_p a_{ip}) \nabla N_{ip} - m_p C_p^T \bar p_i N_{ip} $$
//!
//! and so on: every sum over particles becomes one over nodes and the reverse; shape functions have their derivatives by the place.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use super::adjoint::BodyAdjoint;
use super::eight::Eight;
use super::solution::{NodeAdjoint, NodeSums, Solution};
use super::weights::Weight;
use crate::particle_terms::ENTRY;

/// What transfers take from a configuration and a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transfers<const D: usize> {
    pub(super) dt: f64,
    /// Shares of FLIP and PIC.
    pub(super) shares: (f64, f64),
    pub(super) affine: bool,
    /// `1/d` of APIC's `D_p = d I`; none where the gradient serves.
    pub(super) inverse_inertia: Option<f64>,
    pub(super) gravity: [f64; D],
    pub(super) axisymmetric: bool,
}

/// The numbers of a particle that transfers read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Particle<const D: usize> {
    pub(super) position: [f64; D],
    pub(super) velocity: [f64; D],
    pub(super) affine: [[f64; D]; D],
    pub(super) mass: f64,
    pub(super) reference_volume: f64,
    pub(super) stress: [f64; 6],
    pub(super) viscosity: f64,
    pub(super) volume: f64,
}

impl<const D: usize> Particle<D> {
    /// Entry of the stress with the bulk viscosity.
    fn stress(&self, k: usize, l: usize) -> f64 {
        self.stress[ENTRY[k][l]] - if k == l { self.viscosity } else { 0.0 }
    }

    /// `v + C (x_i - x_p)`.
    #[inline(always)]
    fn velocity_at(&self, arm: &[f64; D], affine: bool) -> [f64; D] {
        let mut velocity = self.velocity;
        if affine {
            for k in 0..D {
                for l in 0..D {
                    velocity[k] += self.affine[k][l] * arm[l];
                }
            }
        }
        velocity
    }
}

impl<const D: usize> Transfers<D> {
    /// The hoop and gravity.
    fn force_on_all_nodes(&self, of: &Particle<D>) -> [f64; D] {
        let mut force = self.gravity.map(|along| along * of.mass);
        if self.axisymmetric {
            let hoop = of.volume * of.reference_volume * (of.stress[2] - of.viscosity);
            force[0] -= hoop / of.position[0];
        }
        force
    }

    /// Particle-to-grid of a particle, with force or momentum alone.
    pub(super) fn give(
        &self,
        of: &Particle<D>,
        weights: &[Weight<D>],
        with_force: bool,
        sums: &mut NodeSums<D>,
    ) {
        let (volume, everywhere) = (of.volume * of.reference_volume, self.force_on_all_nodes(of));
        for weight in weights {
            let velocity = of.velocity_at(&weight.arm, self.affine);
            let part = of.mass * weight.value;
            for k in 0..D {
                sums.momentum[weight.node][k] += part * velocity[k];
            }
            if with_force {
                sums.mass[weight.node] += part;
                for k in 0..D {
                    let mut force = everywhere[k] * weight.value;
                    for l in 0..D {
                        force -= volume * of.stress(k, l) * weight.slope[l];
                    }
                    sums.force[weight.node][k] += force;
                }
            }
        }
    }

    /// Velocity and APIC's matrix of a particle after a step.
    pub(super) fn receive(
        &self,
        of: &Particle<D>,
        weights: &[Weight<D>],
        nodes: &Solution<D>,
    ) -> ([f64; D], [[f64; D]; D]) {
        let (flip, pic) = self.shares;
        let (mut velocity, mut affine) = (of.velocity.map(|v| v * flip), [[0.0; D]; D]);
        for weight in weights {
            let (v, dv) = (&nodes.velocity[weight.node], &nodes.velocity_change[weight.node]);
            for k in 0..D {
                velocity[k] += (flip * dv[k] + pic * v[k]) * weight.value;
                for l in 0..D {
                    affine[k][l] += v[k]
                        * match self.inverse_inertia {
                            None => weight.slope[l],
                            Some(inverse) => inverse * weight.arm[l] * weight.value,
                        };
                }
            }
        }
        (velocity, affine)
    }

    /// The velocity gradient of a particle.
    pub(super) fn gradient(
        &self,
        of: &Particle<D>,
        weights: &[Weight<D>],
        velocities: &[[f64; D]],
    ) -> [[f64; 3]; 3] {
        let (mut l, mut radial) = ([[0.0; 3]; 3], 0.0);
        for weight in weights {
            let v = &velocities[weight.node];
            for k in 0..D {
                for m in 0..D {
                    l[k][m] += v[k] * weight.slope[m];
                }
            }
            radial += v[0] * weight.value;
        }
        if self.axisymmetric {
            l[2][2] = radial / of.position[0];
        }
        l
    }

    /// The adjoint of [`gradient`](Self::gradient).
    #[inline(always)]
    pub(super) fn reverse_gradient(
        &self,
        (of, particle): (&Particle<D>, usize),
        weights: &[Weight<D>],
        velocities: &[[f64; D]],
        (adjoint, nodes): (&mut BodyAdjoint<D>, &mut NodeAdjoint<D>),
    ) {
        let (by_gradient, mut by_place) = (&adjoint.gradient[particle], [Eight::ZERO; D]);
        // w_k of the second derivatives, and the radial velocity.
        let (mut seconds, mut radial) = ([[[0.0; D]; D]; D], (0.0, [0.0; D]));
        for weight in weights {
            let (v, node) = (&velocities[weight.node], &mut nodes.velocity[weight.node]);
            for k in 0..D {
                for m in 0..D {
                    node[k].add(weight.slope[m], &by_gradient[k][m]);
                    for l in 0..D {
                        seconds[k][m][l] += v[k] * weight.second[m][l];
                    }
                }
            }
            if self.axisymmetric {
                node[0].add(weight.value / of.position[0], &adjoint.hoop[particle]);
                radial.0 += v[0] * weight.value;
                for l in 0..D {
                    radial.1[l] += v[0] * weight.slope[l];
                }
            }
        }
        for l in 0..D {
            for k in 0..D {
                for m in 0..D {
                    by_place[l].add(seconds[k][m][l], &by_gradient[k][m]);
                }
            }
            if self.axisymmetric {
                by_place[l].add(radial.1[l] / of.position[0], &adjoint.hoop[particle]);
            }
        }
        if self.axisymmetric {
            let radius = of.position[0];
            by_place[0].add(-radial.0 / (radius * radius), &adjoint.hoop[particle]);
        }
        for l in 0..D {
            adjoint.position[particle][l].add(1.0, &by_place[l]);
        }
    }

    /// The adjoint of [`receive`](Self::receive) and of the motion: derivatives by velocity and matrix before the step replace those
    /// by what they are after it.
    #[inline(always)]
    pub(super) fn reverse_receive(
        &self,
        particle: usize,
        weights: &[Weight<D>],
        nodes: &Solution<D>,
        (adjoint, by_nodes): (&mut BodyAdjoint<D>, &mut NodeAdjoint<D>),
    ) {
        let (flip, pic) = self.shares;
        let after = adjoint.velocity[particle];
        let matrix = adjoint.affine.get(particle).copied().unwrap_or([[Eight::ZERO; D]; D]);
        let (mut by_sum, mut by_change) = (after, after);
        let mut by_place = adjoint.position[particle];
        for k in 0..D {
            by_sum[k] = by_sum[k].scaled(pic);
            by_sum[k].add(self.dt, &adjoint.moved[particle][k]);
            by_change[k] = by_change[k].scaled(flip);
        }
        for weight in weights {
            let (v, dv) = (&nodes.velocity[weight.node], &nodes.velocity_change[weight.node]);
            for k in 0..D {
                // Of the node's velocity, as the particle's sums take it: value times `by`, slope times `across`.
                let mut by = by_sum[k];
                let mut across = [Eight::ZERO; D];
                if self.affine {
                    match self.inverse_inertia {
                        None => across = matrix[k],
                        Some(inverse) => {
                            for l in 0..D {
                                by.add(inverse * weight.arm[l], &matrix[k][l]);
                                by_place[l].add(-inverse * v[k] * weight.value, &matrix[k][l]);
                            }
                        }
                    }
                }
                by_nodes.velocity[weight.node][k].add(weight.value, &by);
                by_nodes.change[weight.node][k].add(weight.value, &by_change[k]);
                for l in 0..D {
                    by_place[l].add(v[k] * weight.slope[l], &by);
                    by_place[l].add(dv[k] * weight.slope[l], &by_change[k]);
                    if self.affine && self.inverse_inertia.is_none() {
                        by_nodes.velocity[weight.node][k].add(weight.slope[l], &across[l]);
                        for m in 0..D {
                            by_place[m].add(v[k] * weight.second[l][m], &across[l]);
                        }
                    }
                }
            }
        }
        adjoint.position[particle] = by_place;
        adjoint.velocity[particle] = by_change;
        if let Some(matrix) = adjoint.affine.get_mut(particle) {
            *matrix = [[Eight::ZERO; D]; D];
        }
    }

    /// The adjoint of [`give`](Self::give).
    #[inline(always)]
    pub(super) fn reverse_give(
        &self,
        (of, particle, slots): (&Particle<D>, usize, usize),
        weights: &[Weight<D>],
        with_force: bool,
        (adjoint, nodes): (&mut BodyAdjoint<D>, &NodeAdjoint<D>),
    ) {
        let zero = [Eight::ZERO; D];
        let (mut by_velocity, mut by_matrix) = (zero, [zero; D]);
        let (mut by_place, mut by_mass) = (adjoint.position[particle], adjoint.mass[particle]);
        // Sums of the derivatives by forces: of values, of slopes.
        let (mut values, mut slopes) = (zero, [zero; D]);
        let everywhere = self.force_on_all_nodes(of);
        let volume = of.volume * of.reference_volume;
        for weight in weights {
            let (momentum, force) = (&nodes.velocity[weight.node], &nodes.change[weight.node]);
            let velocity = of.velocity_at(&weight.arm, self.affine);
            // What all of the weight times its value is.
            let mut common = Eight::ZERO;
            for k in 0..D {
                common.add(velocity[k], &momentum[k]);
                by_velocity[k].add(of.mass * weight.value, &momentum[k]);
                if self.affine {
                    for l in 0..D {
                        by_matrix[k][l].add(of.mass * weight.value * weight.arm[l], &momentum[k]);
                        by_place[l].add(-of.mass * of.affine[k][l] * weight.value, &momentum[k]);
                    }
                }
            }
            if with_force {
                common.add(1.0, &nodes.mass[weight.node]);
            }
            by_mass.add(weight.value, &common);
            let mut whole = common.scaled(of.mass);
            if with_force {
                for k in 0..D {
                    whole.add(everywhere[k], &force[k]);
                    values[k].add(weight.value, &force[k]);
                    for l in 0..D {
                        slopes[k][l].add(weight.slope[l], &force[k]);
                        for m in 0..D {
                            by_place[m]
                                .add(-volume * of.stress(k, l) * weight.second[l][m], &force[k]);
                        }
                    }
                }
            }
            for l in 0..D {
                by_place[l].add(weight.slope[l], &whole);
            }
        }
        for k in 0..D {
            adjoint.velocity[particle][k].add(1.0, &by_velocity[k]);
            if let Some(matrix) = adjoint.affine.get_mut(particle) {
                for l in 0..D {
                    matrix[k][l].add(1.0, &by_matrix[k][l]);
                }
            }
        }
        if with_force {
            for k in 0..D {
                by_mass.add(self.gravity[k], &values[k]);
            }
            let material = &mut adjoint.material[particle * slots..(particle + 1) * slots];
            self.reverse_force(of, (&values, &slopes), (material, &mut by_place));
        }
        adjoint.position[particle] = by_place;
        adjoint.mass[particle] = by_mass;
    }

    /// The part of stress, viscosity and volume.
    #[inline(always)]
    fn reverse_force(
        &self,
        of: &Particle<D>,
        (values, slopes): (&[Eight; D], &[[Eight; D]; D]),
        (material, by_place): (&mut [Eight], &mut [Eight; D]),
    ) {
        const VISCOSITY: usize = 6;
        const VOLUME: usize = 7;
        let volume = of.volume * of.reference_volume;
        for k in 0..D {
            for l in 0..D {
                material[ENTRY[k][l]].add(-volume, &slopes[k][l]);
                material[VOLUME].add(-of.reference_volume * of.stress(k, l), &slopes[k][l]);
            }
            material[VISCOSITY].add(volume, &slopes[k][k]);
        }
        if self.axisymmetric {
            let (radius, hoop) = (of.position[0], of.stress[2] - of.viscosity);
            material[2].add(-volume / radius, &values[0]);
            material[VISCOSITY].add(volume / radius, &values[0]);
            material[VOLUME].add(-of.reference_volume * hoop / radius, &values[0]);
            by_place[0].add(volume * hoop / (radius * radius), &values[0]);
        }
    }
}
