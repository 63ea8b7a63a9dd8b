//! From particles to nodes and back.

use crate::body::{Body, Condition, Particles};
use crate::config::{Config, Geometry, Transfer};
use crate::grid::{Grid, Node, block_edge, block_len};
use crate::number::Number;
use crate::parallel::{for_each, for_each_pair};
use crate::shape::{Axis, Shape, ShapeFunction, for_each_node};

/// Entry `kl` of a symmetric tensor.
const ENTRY: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// What particles give to the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Given {
    /// Mass and momentum.
    Motion,
    /// Mass, momentum and force.
    MotionAndForce,
}

/// Calls with the type of the shape function.
macro_rules! with_shape {
    ($shape:expr, $function:ident :: <$($other:ty),*> ($($argument:expr),*)) => {
        match $shape {
            Shape::Linear => $function::<crate::shape::Linear, $($other),*>($($argument),*),
            Shape::Gimp => $function::<crate::shape::Gimp, $($other),*>($($argument),*),
            Shape::QuadraticBSpline => {
                $function::<crate::shape::QuadraticBSpline, $($other),*>($($argument),*)
            }
            Shape::CubicBSpline => $function::<crate::shape::CubicBSpline, $($other),*>($($argument),*),
        }
    };
}
pub(crate) use with_shape;

/// What places and nodes have to do with each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places<const D: usize> {
    pub(crate) origin: [f64; D],
    pub(crate) cell: f64,
}

impl<const D: usize> Places<D> {
    /// The shape function of a particle along all axes.
    #[inline]
    fn axes<F: ShapeFunction, S: Number>(&self, x: &[S; D], half_length: &[S; D]) -> [Axis<S>; D] {
        let inverse = 1.0 / self.cell;
        std::array::from_fn(|k| {
            F::along((x[k] - self.origin[k]) * inverse, half_length[k] * inverse)
        })
    }

    /// The lowest node that each particle of a body sees.
    pub(crate) fn bases<F: ShapeFunction, S: Number>(&self, body: &mut Body<S, D>) {
        let Particles { position, half_length, .. } = &body.particles;
        let inverse = 1.0 / self.cell;
        for_each(&mut body.bases, |i, base| {
            *base = std::array::from_fn(|k| {
                let place = (position[i][k].value() - self.origin[k]) * inverse;
                F::base(place, half_length[i][k].value() * inverse)
            });
        });
    }
}

/// Where in its block a particle's lowest node is.
#[inline]
fn offset<S, const D: usize>(axes: &[Axis<S>; D], corner: &[i32; D]) -> usize {
    let mut index = 0;
    for k in (0..D).rev() {
        index = index * block_edge(D) + axes[k].base.abs_diff(corner[k]) as usize;
    }
    index
}

/// Particles give mass, momentum `m (v + C (x_i - x_p))` and the force
///
/// $$ f_i = \sum_p m_p N_i b - V_p \sigma_p \nabla N_i $$
///
/// to the nodes (Chen et al. 2019, eq 3-6 with their errata).
pub(crate) fn give<F: ShapeFunction, S: Number, const D: usize>(
    grid: &mut Grid<S, D>,
    bodies: &[Body<S, D>],
    config: &Config<D>,
    given: Given,
) {
    let places = Places { origin: grid.origin, cell: grid.cell };
    grid.collect(|slot, corner, block| {
        for body in bodies {
            let (particles, conditions) = (&body.particles, body.constitution.conditions());
            for &p in body.binning.of(slot) {
                let p = p as usize;
                let axes = places.axes::<F, S>(&particles.position[p], &particles.half_length[p]);
                let force = match given {
                    Given::Motion => None,
                    Given::MotionAndForce => Some(Force::of(particles, &conditions[p], p, config)),
                };
                let nodes = &mut block[offset(&axes, &corner)..];
                give_one::<F, S, D>(
                    &axes,
                    places.cell,
                    particles,
                    p,
                    force.as_ref(),
                    config,
                    nodes,
                );
            }
        }
    });
}

/// The force of a particle: `- V sigma` over the cell, what acts on its nodes alike, and the hoop.
struct Force<S, const D: usize> {
    by_gradient: [[S; D]; D],
    by_value: [S; D],
}

impl<S: Number, const D: usize> Force<S, D> {
    #[inline]
    fn of(
        particles: &Particles<S, D>,
        condition: &Condition<S>,
        p: usize,
        config: &Config<D>,
    ) -> Self {
        let volume = condition.volume * particles.reference_volume[p];
        let factor = volume * (-1.0 / config.cell);
        let stress = &condition.stress.0;
        let by_gradient =
            std::array::from_fn(|k| std::array::from_fn(|l| stress[ENTRY[k][l]] * factor));
        let mut by_value: [S; D] = std::array::from_fn(|k| particles.mass[p] * config.gravity[k]);
        if config.geometry == Geometry::Axisymmetric {
            by_value[0] = by_value[0] - volume * stress[2] / particles.position[p][0];
        }
        Self { by_gradient, by_value }
    }
}

#[inline]
fn give_one<F: ShapeFunction, S: Number, const D: usize>(
    axes: &[Axis<S>; D],
    cell: f64,
    particles: &Particles<S, D>,
    p: usize,
    force: Option<&Force<S, D>>,
    config: &Config<D>,
    nodes: &mut [Node<S, D>],
) {
    let mass = particles.mass[p];
    let momentum: [S; D] = std::array::from_fn(|k| mass * particles.velocity[p][k]);
    for_each_node::<S, F, D>(axes, block_edge(D), |at, value, gradient| {
        let node = &mut nodes[at];
        node.mass = node.mass + mass * value;
        for k in 0..D {
            node.motion[k] = node.motion[k] + momentum[k] * value;
        }
        if let Some(Force { by_gradient, by_value }) = force {
            for k in 0..D {
                let mut sum = by_value[k] * value;
                for l in 0..D {
                    sum = sum + by_gradient[k][l] * gradient[l];
                }
                node.change[k] = node.change[k] + sum;
            }
        }
    });
    if config.transfer == Transfer::Apic {
        let affine = &particles.affine[p];
        let x = &particles.position[p];
        let base: [S; D] =
            std::array::from_fn(|k| -(x[k] - config.origin[k]) + f64::from(axes[k].base) * cell);
        for_each_node::<S, F, D>(axes, block_edge(D), |at, value, _| {
            let (mut rest, mut arm) = (at, base);
            for component in &mut arm {
                *component = *component + (rest % block_edge(D)) as f64 * cell;
                rest /= block_edge(D);
            }
            for k in 0..D {
                let mut sum = affine[k][0] * arm[0];
                for l in 1..D {
                    sum = sum + affine[k][l] * arm[l];
                }
                nodes[at].motion[k] = nodes[at].motion[k] + mass * value * sum;
            }
        });
    }
}

/// Particles take velocity and displacement from the nodes; with APIC its matrix too.
pub(crate) fn take_motion<F: ShapeFunction, S: Number, const D: usize>(
    grid: &Grid<S, D>,
    bodies: &mut [Body<S, D>],
    config: &Config<D>,
    dt: f64,
) {
    let places = Places { origin: grid.origin, cell: grid.cell };
    let (flip, picked) = match config.transfer {
        Transfer::Flip { damping_time } => {
            let share = (-dt / damping_time).exp();
            (share, 1.0 - share)
        }
        Transfer::Apic => (0.0, 1.0),
    };
    for body in bodies {
        let Particles { position, velocity, displacement, half_length, affine, .. } =
            &mut body.particles;
        let (position, half_length, slots) = (&*position, &*half_length, &body.binning.slot);
        for_each_pair(velocity, displacement, |p, velocity, displacement| {
            let axes = places.axes::<F, S>(&position[p], &half_length[p]);
            let slot = slots[p] as usize;
            let nodes = &grid.blocks[slot * block_len(D)..][offset(&axes, &grid.corner(slot))..];
            let zero = [S::constant(0.0); D];
            let (mut new, mut change) = (zero, zero);
            for_each_node::<S, F, D>(&axes, block_edge(D), |at, value, _| {
                for k in 0..D {
                    new[k] = new[k] + nodes[at].motion[k] * value;
                    change[k] = change[k] + nodes[at].change[k] * value;
                }
            });
            for k in 0..D {
                displacement[k] = new[k] * dt;
                velocity[k] = (velocity[k] + change[k]) * flip + new[k] * picked;
            }
        });
        if config.transfer == Transfer::Apic {
            let inertia = inverse_inertia(config);
            for_each(affine, |p, affine| {
                let axes = places.axes::<F, S>(&position[p], &half_length[p]);
                let slot = slots[p] as usize;
                let corner = grid.corner(slot);
                let nodes = &grid.blocks[slot * block_len(D)..][offset(&axes, &corner)..];
                *affine = affine_of::<F, S, D>(&axes, nodes, (&position[p], &places), inertia);
            });
        }
    }
}

/// `1/d` of `D_p = d I` where the shape function has such (B-splines); none where the gradient serves.
fn inverse_inertia<const D: usize>(config: &Config<D>) -> Option<f64> {
    let square = config.cell * config.cell;
    match config.shape {
        Shape::QuadraticBSpline => Some(4.0 / square),
        Shape::CubicBSpline => Some(3.0 / square),
        Shape::Linear | Shape::Gimp => None,
    }
}

/// APIC's matrix `C = sum_i v_i (x_i - x_p)^T N_i D_p^-1` (Jiang et al. 2015, eq 8); for shape functions of the hat
/// `sum_i v_i grad N_i^T`, to which it comes down there.
fn affine_of<F: ShapeFunction, S: Number, const D: usize>(
    axes: &[Axis<S>; D],
    nodes: &[Node<S, D>],
    (x, places): (&[S; D], &Places<D>),
    inertia: Option<f64>,
) -> [[S; D]; D] {
    let mut affine = [[S::constant(0.0); D]; D];
    let base: [S; D] =
        std::array::from_fn(|k| -(x[k] - places.origin[k]) + f64::from(axes[k].base) * places.cell);
    for_each_node::<S, F, D>(axes, block_edge(D), |at, value, gradient| {
        let arm: [S; D] = match inertia {
            None => gradient.map(|slope| slope * (1.0 / places.cell)),
            Some(inverse) => {
                let mut rest = at;
                base.map(|from| {
                    let steps = rest % block_edge(D);
                    rest /= block_edge(D);
                    (from + steps as f64 * places.cell) * value * inverse
                })
            }
        };
        for k in 0..D {
            for l in 0..D {
                affine[k][l] = affine[k][l] + nodes[at].motion[k] * arm[l];
            }
        }
    });
    affine
}

/// Particles take the velocity gradient `L = sum_i v_i grad N_i^T` from the nodes.
pub(crate) fn take_gradient<F: ShapeFunction, S: Number, const D: usize>(
    grid: &Grid<S, D>,
    bodies: &mut [Body<S, D>],
    config: &Config<D>,
) {
    let places = Places { origin: grid.origin, cell: grid.cell };
    for body in bodies {
        let Particles { position, half_length, velocity_gradient, .. } = &mut body.particles;
        let (position, half_length, slots) = (&*position, &*half_length, &body.binning.slot);
        for_each(velocity_gradient, |p, l| {
            let axes = places.axes::<F, S>(&position[p], &half_length[p]);
            let slot = slots[p] as usize;
            let nodes = &grid.blocks[slot * block_len(D)..][offset(&axes, &grid.corner(slot))..];
            let zero = S::constant(0.0);
            let mut gradient = [[zero; D]; D];
            let mut radial = zero;
            for_each_node::<S, F, D>(&axes, block_edge(D), |at, value, slope| {
                let velocity = &nodes[at].motion;
                for k in 0..D {
                    for m in 0..D {
                        gradient[k][m] = gradient[k][m] + velocity[k] * slope[m];
                    }
                }
                radial = radial + velocity[0] * value;
            });
            for k in 0..D {
                for m in 0..D {
                    l[k][m] = gradient[k][m] * (1.0 / places.cell);
                }
            }
            if config.geometry == Geometry::Axisymmetric {
                l[2][2] = radial / position[p][0];
            }
        });
    }
}
