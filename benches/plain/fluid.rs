//! A hand-written step of a stiffened gas in plane strain.
//!
//! Quadratic B-splines, modified update stress last, FLIP, one thread, certain parameters.
//!
//! Its pressure is a function of volume and energy: it stores no stress.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch;

use crate::case::{Failure, Run, State};
use crate::grid::{EMPTY, Grid};
use crate::material_points::{Body, COURANT_NUMBER, GAS, LINEAR, MOST_GROWTH, QUADRATIC};

/// Time-dependent data of a particle.
#[derive(Debug, Clone, Copy)]
struct Particle {
    x: [f64; 2],
    v: [f64; 2],
    /// Displacement in the step.
    displacement: [f64; 2],
    pressure: f64,
    viscosity: f64,
    /// `V/V_0`.
    volume: f64,
    wave_speed: f64,
    energy: f64,
}

/// The body with its grid.
#[derive(Debug)]
pub(crate) struct Gas {
    grid: Grid,
    particles: Vec<Particle>,
    mass: f64,
    reference_volume: f64,
    dt: f64,
    supplied: f64,
}

/// Observations of a pass over the particles.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    fastest: f64,
    kinetic: f64,
    internal: f64,
}

impl Gas {
    pub(crate) fn new(body: &Body) -> Self {
        let energy = (GAS.pressure + GAS.exponent * GAS.stiffness) / (GAS.exponent - 1.0);
        let wave_speed = (GAS.exponent * (GAS.pressure + GAS.stiffness) / GAS.density).sqrt();
        let particle = |(x, v): (&[f64; 2], &[f64; 2])| Particle {
            x: *x,
            v: *v,
            displacement: [0.0; 2],
            pressure: GAS.pressure,
            viscosity: 0.0,
            volume: 1.0,
            wave_speed,
            energy,
        };
        let particles: Vec<_> = body.positions.iter().zip(&body.velocities).map(particle).collect();
        let mut plain = Self {
            grid: Grid::around_unit_square(body.cell),
            particles,
            mass: GAS.density * body.volume,
            reference_volume: body.volume,
            dt: 0.0,
            supplied: 0.0,
        };
        let mut seen = Seen::default();
        for p in &plain.particles {
            let square = p.v[0] * p.v[0] + p.v[1] * p.v[1];
            seen.fastest = seen.fastest.max(square.sqrt() + p.wave_speed);
            seen.kinetic += 0.5 * plain.mass * square;
            seen.internal += p.energy * plain.reference_volume;
        }
        plain.dt = COURANT_NUMBER * body.cell / seen.fastest;
        plain.supplied = seen.kinetic + seen.internal;
        plain
    }

    #[inline(always)]
    fn give(&mut self) {
        for p in &self.particles {
            let w = self.grid.weights(p.x);
            let push =
                (p.pressure + p.viscosity) * p.volume * self.reference_volume / self.grid.cell;
            let momentum = [self.mass * p.v[0], self.mass * p.v[1]];
            for j in 0..3 {
                let (value, slope) = (w.value[1][j], w.slope[1][j]);
                let (mass, along, across) = (self.mass * value, push * value, push * slope);
                let motion = [momentum[0] * value, momentum[1] * value];
                let start = w.first + j * self.grid.width;
                let row = &mut self.grid.nodes[start..start + 3];
                for i in 0..3 {
                    let (value, slope, node) = (w.value[0][i], w.slope[0][i], &mut row[i]);
                    node.mass += mass * value;
                    for c in 0..2 {
                        node.motion[c] += motion[c] * value;
                    }
                    node.change[0] += along * slope;
                    node.change[1] += across * value;
                }
            }
        }
    }

    #[inline(always)]
    fn take_motion(&mut self) {
        for p in &mut self.particles {
            let w = self.grid.weights(p.x);
            let (mut velocity, mut changed) = ([0.0; 2], [0.0; 2]);
            for j in 0..3 {
                let start = w.first + j * self.grid.width;
                let row = &self.grid.nodes[start..start + 3];
                let (mut v, mut change) = ([0.0; 2], [0.0; 2]);
                for i in 0..3 {
                    for c in 0..2 {
                        v[c] += row[i].motion[c] * w.value[0][i];
                        change[c] += row[i].change[c] * w.value[0][i];
                    }
                }
                for c in 0..2 {
                    velocity[c] += v[c] * w.value[1][j];
                    changed[c] += change[c] * w.value[1][j];
                }
            }
            for k in 0..2 {
                p.v[k] += changed[k];
                p.displacement[k] = self.dt * velocity[k];
            }
        }
    }

    /// Second particle-to-grid transfer, from the accelerated particles.
    #[inline(always)]
    fn give_momentum(&mut self) {
        for p in &self.particles {
            let w = self.grid.weights(p.x);
            let momentum = [self.mass * p.v[0], self.mass * p.v[1]];
            for j in 0..3 {
                let value = w.value[1][j];
                let motion = [momentum[0] * value, momentum[1] * value];
                let start = w.first + j * self.grid.width;
                let row = &mut self.grid.nodes[start..start + 3];
                for i in 0..3 {
                    for c in 0..2 {
                        row[i].motion[c] += motion[c] * w.value[0][i];
                    }
                }
            }
        }
    }

    /// The first volume that is not positive, if any.
    #[inline(always)]
    fn deform_and_move(&mut self, seen: &mut Seen) -> Option<f64> {
        let (dt, per_cell) = (self.dt, 1.0 / self.grid.cell);
        for at in 0..self.particles.len() {
            let mut p = self.particles[at];
            let mut l = self.gradient(p.x);
            for k in 0..2 {
                for m in 0..2 {
                    l[k][m] *= per_cell;
                }
                p.x[k] += p.displacement[k];
            }
            let trace = l[0][0] + l[1][1];
            let stretch =
                (1.0 + dt * l[0][0]) * (1.0 + dt * l[1][1]) - dt * l[0][1] * (dt * l[1][0]);
            let volume = p.volume * stretch;
            // Rejects NaN too.
            if volume.is_nan() || volume <= 0.0 {
                return Some(volume);
            }
            compress(&mut p, volume, trace, self.grid.cell);
            let square = p.v[0] * p.v[0] + p.v[1] * p.v[1];
            let c = p.wave_speed;
            let speed = if trace >= 0.0 {
                square.sqrt() + c
            } else {
                let q = LINEAR * c - QUADRATIC * self.grid.cell * trace;
                square.sqrt() + q + (q * q + c * c).sqrt()
            };
            seen.fastest = seen.fastest.max(speed);
            seen.kinetic += 0.5 * self.mass * square;
            seen.internal += p.energy * self.reference_volume;
            self.particles[at] = p;
        }
        None
    }

    /// Velocity gradient, per cell.
    #[inline(always)]
    fn gradient(&self, x: [f64; 2]) -> [[f64; 2]; 2] {
        let w = self.grid.weights(x);
        let mut gradient = [[0.0; 2]; 2];
        for j in 0..3 {
            let start = w.first + j * self.grid.width;
            let row = &self.grid.nodes[start..start + 3];
            let (mut v, mut steep) = ([0.0; 2], [0.0; 2]);
            for i in 0..3 {
                for c in 0..2 {
                    v[c] += row[i].motion[c] * w.value[0][i];
                    steep[c] += row[i].motion[c] * w.slope[0][i];
                }
            }
            for c in 0..2 {
                gradient[c][0] += steep[c] * w.value[1][j];
                gradient[c][1] += v[c] * w.slope[1][j];
            }
        }
        gradient
    }
}

impl Run for Gas {
    /// One step with the length that the Courant number allows. It fails if a volume is inverted or the energy grows.
    fn step(&mut self) -> Result<(), Failure> {
        self.grid.nodes.fill(EMPTY);
        dispatch(
            #[inline(always)]
            || self.give(),
        );
        let (dt, least) = (self.dt, 1e-12 * self.mass);
        dispatch(
            #[inline(always)]
            || self.grid.solve(dt, least),
        );
        dispatch(
            #[inline(always)]
            || self.take_motion(),
        );
        for node in &mut self.grid.nodes {
            node.motion = [0.0; 2];
        }
        dispatch(
            #[inline(always)]
            || self.give_momentum(),
        );
        for node in &mut self.grid.nodes {
            let inverse = if node.mass > least { 1.0 / node.mass } else { 0.0 };
            for k in 0..2 {
                node.motion[k] *= inverse;
            }
        }
        let mut seen = Seen::default();
        let faulty = dispatch(
            #[inline(always)]
            || self.deform_and_move(&mut seen),
        );
        if let Some(volume) = faulty {
            return Err(format!("V/V_0 is {volume}").into());
        }
        self.dt = COURANT_NUMBER * self.grid.cell / seen.fastest;
        let (energy, limit) = (seen.kinetic + seen.internal, MOST_GROWTH * self.supplied);
        if energy <= limit { Ok(()) } else { Err(format!("the energy grew to {energy}").into()) }
    }

    fn state(&self) -> State {
        let of = |f: &dyn Fn(&Particle) -> f64| self.particles.iter().map(f).collect();
        vec![
            ("x", of(&|p| p.x[0])),
            ("y", of(&|p| p.x[1])),
            ("velocity x", of(&|p| p.v[0])),
            ("velocity y", of(&|p| p.v[1])),
            ("stress xx", of(&|p| -p.pressure)),
            ("stress yy", of(&|p| -p.pressure)),
            ("stress xy", of(&|_| 0.0)),
            ("energy", of(&|p| p.energy)),
        ]
    }

    fn n_elements(&self) -> usize {
        self.particles.len()
    }
}

/// Pressure at a new volume, implicit in the energy and linear in it.
#[inline(always)]
fn compress(p: &mut Particle, volume: f64, trace: f64, cell: f64) {
    p.viscosity = if trace < 0.0 {
        let slope = trace * (QUADRATIC * cell) - p.wave_speed * LINEAR;
        GAS.density / volume * slope * trace * cell
    } else {
        0.0
    };
    let half_change = 0.5 * (volume - p.volume);
    let per_energy = (GAS.exponent - 1.0) / volume;
    let half_way = p.energy - (p.pressure + 2.0 * p.viscosity) * half_change;
    p.pressure =
        (per_energy * half_way - GAS.exponent * GAS.stiffness) / (1.0 + per_energy * half_change);
    p.energy = half_way - p.pressure * half_change;
    p.volume = volume;
    p.wave_speed = (GAS.exponent * (p.pressure + GAS.stiffness) * volume / GAS.density).sqrt();
}
