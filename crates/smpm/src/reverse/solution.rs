//! The solution at the nodes of a step, and its adjoint.

use perturbation_moments::Gradient;

use super::eight::Eight;
use super::node_box::{Image, NodeBox};
use crate::boundary::Plane;

/// Sums of particle-to-grid, and what the nodes make of them.
#[derive(Debug)]
pub(super) struct Solution<const D: usize> {
    /// The step; zero for velocities alone.
    dt: f64,
    /// Whether the masses were summed with the momenta.
    with_mass: bool,
    /// Nodal masses; zero where a node is at rest.
    pub(super) mass: Vec<f64>,
    /// Velocities by momentum and mass.
    raw: Vec<[f64; D]>,
    /// Their changes by the forces.
    change: Vec<[f64; D]>,
    /// What planes leave of the velocities at the begin of the step and at its end.
    left: Vec<(usize, [f64; D], [f64; D])>,
    /// Velocities at the end of the step.
    pub(super) velocity: Vec<[f64; D]>,
    /// By how much the step changes them.
    pub(super) velocity_change: Vec<[f64; D]>,
}

/// Sums at the nodes.
#[derive(Debug)]
pub(super) struct NodeSums<const D: usize> {
    pub(super) mass: Vec<f64>,
    pub(super) momentum: Vec<[f64; D]>,
    pub(super) force: Vec<[f64; D]>,
}

/// Derivatives of the responses by what nodes hold.
#[derive(Debug)]
pub(super) struct NodeAdjoint<const D: usize> {
    /// By the velocities at the end; by the momenta after [`Solution::reverse`].
    pub(super) velocity: Vec<[Eight; D]>,
    /// By their changes; by the forces after it.
    pub(super) change: Vec<[Eight; D]>,
    pub(super) mass: Vec<Eight>,
}

impl<const D: usize> NodeSums<D> {
    pub(super) fn zero(n: usize) -> Self {
        Self { mass: vec![0.0; n], momentum: vec![[0.0; D]; n], force: vec![[0.0; D]; n] }
    }

    /// Adds the images that mirrors show.
    fn collect(&mut self, images: &[Image<D>]) {
        let Self { mass, momentum, force } = self;
        let parts = |image: &Image<D>| (mass[image.of], momentum[image.of], force[image.of]);
        // Sources may be near another mirror: all are read first.
        let read: Vec<_> = images.iter().map(parts).collect();
        for (image, (m, p, f)) in images.iter().zip(read) {
            mass[image.node] += m;
            for k in 0..D {
                momentum[image.node][k] += image.sign[k] * p[k];
                force[image.node][k] += image.sign[k] * f[k];
            }
        }
    }
}

impl<const D: usize> NodeAdjoint<D> {
    pub(super) fn zero(n: usize) -> Self {
        let none = vec![[Eight::ZERO; D]; n];
        Self { velocity: none.clone(), change: none, mass: vec![Eight::ZERO; n] }
    }
}

impl<const D: usize> Solution<D> {
    /// Of sums, over a step `dt` of the grid with this cell; `masses` are known where momenta alone were summed.
    pub(super) fn of(
        mut sums: NodeSums<D>,
        (nodes, planes): (&NodeBox<D>, &[Plane]),
        (dt, cell): (f64, f64),
        (smallest_mass, masses): (f64, Option<&[f64]>),
    ) -> Self {
        sums.collect(&nodes.collected);
        let with_mass = masses.is_none();
        let mut mass = masses.map_or(sums.mass, <[f64]>::to_vec);
        let (mut raw, mut change) = (sums.momentum, sums.force);
        for ((m, v), dv) in mass.iter_mut().zip(&mut raw).zip(&mut change) {
            if *m <= smallest_mass {
                (*m, *v, *dv) = (0.0, [0.0; D], [0.0; D]);
                continue;
            }
            for k in 0..D {
                v[k] /= *m;
                dv[k] *= dt / *m;
            }
        }
        let (mut velocity, mut velocity_change) = (raw.clone(), change.clone());
        for (v, dv) in velocity.iter_mut().zip(&change) {
            for k in 0..D {
                v[k] += dv[k];
            }
        }
        let mut left = Vec::with_capacity(nodes.constrained.len());
        for &(node, place) in &nodes.constrained {
            let at = |plane: &&Plane, v: [f64; D]| passed(plane, place[plane.axis], (dt, cell), v);
            let (mut before, mut first) = (raw[node], [1.0; D]);
            for plane in planes.iter().filter(|plane| plane.mirrors()) {
                let factor = at(&plane, before);
                scale(&mut before, &mut first, factor);
            }
            let (mut after, mut last) = (before, [1.0; D]);
            for k in 0..D {
                after[k] += change[node][k];
            }
            for plane in planes {
                let factor = at(&plane, after);
                scale(&mut after, &mut last, factor);
            }
            for k in 0..D {
                velocity_change[node][k] = after[k] - before[k];
            }
            velocity[node] = after;
            left.push((node, first, last));
        }
        for image in &nodes.filled {
            for k in 0..D {
                velocity[image.node][k] = image.sign[k] * velocity[image.of][k];
                velocity_change[image.node][k] = image.sign[k] * velocity_change[image.of][k];
            }
        }
        Self { dt, with_mass, mass, raw, change, left, velocity, velocity_change }
    }

    /// From derivatives by velocities and their changes to those by momenta and forces; those by masses are added.
    pub(super) fn reverse(&self, nodes: &NodeBox<D>, adjoint: &mut NodeAdjoint<D>) {
        let NodeAdjoint { velocity, change, mass } = adjoint;
        for image in &nodes.filled {
            for k in 0..D {
                let (v, dv) = (velocity[image.node][k].take(), change[image.node][k].take());
                velocity[image.of][k].add(image.sign[k], &v);
                change[image.of][k].add(image.sign[k], &dv);
            }
        }
        let mut left = self.left.iter().peekable();
        for (node, (v, dv)) in velocity.iter_mut().zip(change.iter_mut()).enumerate() {
            let (mut first, mut last) = ([1.0; D], [1.0; D]);
            if let Some((_, before, after)) = left.next_if(|(of, ..)| *of == node) {
                (first, last) = (*before, *after);
            }
            if self.mass[node] <= 0.0 {
                (*v, *dv, mass[node]) = ([Eight::ZERO; D], [Eight::ZERO; D], Eight::ZERO);
                continue;
            }
            let inverse = 1.0 / self.mass[node];
            for k in 0..D {
                // after = last (before + change), before = first raw; the change of the velocity is after - before.
                let (of_velocity, of_change) = (v[k], dv[k]);
                let mut by_change = of_velocity.scaled(last[k]);
                by_change.add(last[k], &of_change);
                let mut by_raw = by_change;
                by_raw.add(-1.0, &of_change);
                let by_raw = by_raw.scaled(first[k]);
                mass[node].add(-inverse * self.raw[node][k], &by_raw);
                mass[node].add(-inverse * self.change[node][k], &by_change);
                (v[k], dv[k]) = (by_raw.scaled(inverse), by_change.scaled(self.dt * inverse));
            }
        }
        let read = |image: &Image<D>| (velocity[image.node], change[image.node], mass[image.node]);
        let parts: Vec<_> = nodes.collected.iter().map(read).collect();
        for (image, (v, dv, m)) in nodes.collected.iter().zip(parts) {
            if self.with_mass {
                mass[image.of].add(1.0, &m);
            }
            for k in 0..D {
                velocity[image.of][k].add(image.sign[k], &v[k]);
                change[image.of][k].add(image.sign[k], &dv[k]);
            }
        }
    }
}

/// What a plane leaves of each component of a velocity, as a factor.
fn passed<const D: usize>(
    plane: &Plane,
    node: i32,
    of: (f64, f64),
    velocity: [f64; D],
) -> [f64; D] {
    let mut numbers = velocity.map(|value| Gradient::variable(value, 0));
    plane.constrain(node, of, &mut numbers);
    numbers.map(|number| number.first[0])
}

fn scale<const D: usize>(velocity: &mut [f64; D], all: &mut [f64; D], factor: [f64; D]) {
    for k in 0..D {
        velocity[k] *= factor[k];
        all[k] *= factor[k];
    }
}
