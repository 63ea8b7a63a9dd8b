//! An elastic body in plane strain: quadratic B-splines, update stress last, FLIP, one thread, certain parameters.
//!
//! It omits what a scene of smpm may declare and this one does not: jets, a third dimension, contact, planes, an
//! affine matrix, yield, and history other than the stress.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch;

use crate::case::{Failure, Run, State};
use crate::grid::{EMPTY, Grid, Weights};
use crate::material_points::{Body, COURANT_NUMBER, ELASTIC, LINEAR, MOST_GROWTH, QUADRATIC};

/// Time-dependent data of a particle.
#[derive(Debug, Clone, Copy)]
struct Particle {
    x: [f64; 2],
    v: [f64; 2],
    /// Deviatoric stress: xx, yy, zz, xy.
    deviator: [f64; 4],
    pressure: f64,
    viscosity: f64,
    /// `V/V_0`.
    volume: f64,
    wave_speed: f64,
    energy: f64,
}

/// The body with its grid.
#[derive(Debug)]
pub(crate) struct Elastic {
    grid: Grid,
    particles: Vec<Particle>,
    mass: f64,
    reference_volume: f64,
    dt: f64,
    supplied: f64,
    bulk: f64,
    shear: f64,
    density: f64,
}

/// Observations of a pass over the particles.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    fastest: f64,
    kinetic: f64,
    internal: f64,
}

impl Elastic {
    pub(crate) fn new(body: &Body) -> Self {
        let bulk = ELASTIC.young_modulus / (3.0 * (1.0 - 2.0 * ELASTIC.poisson_ratio));
        let shear = ELASTIC.young_modulus / (2.0 * (1.0 + ELASTIC.poisson_ratio));
        let wave_speed = ((bulk + shear * (4.0 / 3.0)) / ELASTIC.density).sqrt();
        let particle = |(x, v): (&[f64; 2], &[f64; 2])| Particle {
            x: *x,
            v: *v,
            deviator: [0.0; 4],
            pressure: 0.0,
            viscosity: 0.0,
            volume: 1.0,
            wave_speed,
            energy: 0.0,
        };
        let particles: Vec<_> = body.positions.iter().zip(&body.velocities).map(particle).collect();
        let mut plain = Self {
            grid: Grid::around_unit_square(body.cell),
            particles,
            mass: ELASTIC.density * body.volume,
            reference_volume: body.volume,
            dt: 0.0,
            supplied: 0.0,
            bulk,
            shear,
            density: ELASTIC.density,
        };
        let mut seen = Seen::default();
        for p in &plain.particles {
            let square = p.v[0] * p.v[0] + p.v[1] * p.v[1];
            seen.fastest = seen.fastest.max(square.sqrt() + p.wave_speed);
            seen.kinetic += 0.5 * plain.mass * square;
        }
        plain.dt = COURANT_NUMBER * body.cell / seen.fastest;
        plain.supplied = seen.kinetic;
        plain
    }

    #[inline(always)]
    fn give(&mut self) {
        for p in &self.particles {
            let w = self.grid.weights(p.x);
            let factor = -p.volume * self.reference_volume / self.grid.cell;
            let mean = p.pressure + p.viscosity;
            let [xx, yy, _, xy] = p.deviator;
            let (xx, yy, xy) = ((xx - mean) * factor, (yy - mean) * factor, xy * factor);
            let momentum = [self.mass * p.v[0], self.mass * p.v[1]];
            for j in 0..3 {
                let (value, slope) = (w.value[1][j], w.slope[1][j]);
                let mass = self.mass * value;
                let motion = [momentum[0] * value, momentum[1] * value];
                let along = [xx * value, xy * value];
                let across = [xy * slope, yy * slope];
                let start = w.first + j * self.grid.width;
                let row = &mut self.grid.nodes[start..start + 3];
                for i in 0..3 {
                    let (value, slope, node) = (w.value[0][i], w.slope[0][i], &mut row[i]);
                    node.mass += mass * value;
                    for c in 0..2 {
                        node.motion[c] += motion[c] * value;
                    }
                    for c in 0..2 {
                        node.change[c] += across[c] * value + along[c] * slope;
                    }
                }
            }
        }
    }

    /// The first volume that is not positive, if any.
    #[inline(always)]
    fn take(&mut self, seen: &mut Seen) -> Option<f64> {
        let (dt, per_cell) = (self.dt, 1.0 / self.grid.cell);
        for at in 0..self.particles.len() {
            let mut p = self.particles[at];
            let w = self.grid.weights(p.x);
            let (v, change, mut l) = self.sums(&w);
            for k in 0..2 {
                p.v[k] += change[k];
                p.x[k] += dt * v[k];
                for m in 0..2 {
                    l[k][m] *= per_cell;
                }
            }
            let trace = l[0][0] + l[1][1];
            let volume = self.update(&mut p, &l, trace);
            // Rejects NaN too.
            if volume.is_nan() || volume <= 0.0 {
                return Some(volume);
            }
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

    /// Velocity, its change, and its gradient per cell.
    #[inline(always)]
    fn sums(&self, w: &Weights) -> ([f64; 2], [f64; 2], [[f64; 2]; 2]) {
        let (mut velocity, mut changed, mut gradient) = ([0.0; 2], [0.0; 2], [[0.0; 2]; 2]);
        for j in 0..3 {
            let (value, slope) = (w.value[1][j], w.slope[1][j]);
            let start = w.first + j * self.grid.width;
            let row = &self.grid.nodes[start..start + 3];
            let (mut v, mut change, mut steep) = ([0.0; 2], [0.0; 2], [0.0; 2]);
            for i in 0..3 {
                for c in 0..2 {
                    v[c] += row[i].motion[c] * w.value[0][i];
                    change[c] += row[i].change[c] * w.value[0][i];
                    steep[c] += row[i].motion[c] * w.slope[0][i];
                }
            }
            for c in 0..2 {
                velocity[c] += v[c] * value;
                changed[c] += change[c] * value;
                gradient[c][0] += steep[c] * value;
                gradient[c][1] += v[c] * slope;
            }
        }
        (velocity, changed, gradient)
    }

    /// Updates the material over the step; returns `V/V_0` at its end.
    #[inline(always)]
    fn update(&self, p: &mut Particle, l: &[[f64; 2]; 2], trace: f64) -> f64 {
        let (dt, cell) = (self.dt, self.grid.cell);
        let stretch = (1.0 + dt * l[0][0]) * (1.0 + dt * l[1][1]) - dt * l[0][1] * (dt * l[1][0]);
        let volume = p.volume * stretch;
        p.viscosity = if trace < 0.0 {
            let slope = trace * (QUADRATIC * cell) - p.wave_speed * LINEAR;
            self.density / volume * slope * trace * cell
        } else {
            0.0
        };
        // The old deviatoric stress rotated with the spin (Hughes and Winget), plus the strain increment.
        let mean = trace / 3.0;
        let rate = [l[0][0] - mean, l[1][1] - mean, -mean, 0.5 * (l[0][1] + l[1][0])];
        let c = (l[1][0] - l[0][1]) * (0.25 * dt);
        let factor = 2.0 / (1.0 + c * c);
        let (cosine, sine) = (factor - 1.0, factor * c);
        let [xx, yy, zz, xy] = p.deviator;
        let shear = sine * (xx - yy) + 2.0 * cosine * xy;
        let moved = sine * shear;
        let twice = self.shear * (2.0 * dt);
        let after = [
            xx - moved + twice * rate[0],
            yy + moved + twice * rate[1],
            zz + twice * rate[2],
            cosine * shear - xy + twice * rate[3],
        ];
        let mut work = 0.0;
        for k in 0..4 {
            let twice = if k == 3 { 2.0 } else { 1.0 };
            work += twice * (p.deviator[k] + after[k]) * rate[k];
        }
        let pressure = -self.bulk * volume.ln();
        let half_change = 0.5 * (volume - p.volume);
        p.energy += work * ((p.volume + volume) * (0.25 * dt))
            - (p.pressure + pressure + 2.0 * p.viscosity) * half_change;
        (p.deviator, p.pressure, p.volume) = (after, pressure, volume);
        p.wave_speed = ((self.bulk + self.shear * (4.0 / 3.0)) * volume / self.density).sqrt();
        volume
    }
}

impl Run for Elastic {
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
        let mut seen = Seen::default();
        let faulty = dispatch(
            #[inline(always)]
            || self.take(&mut seen),
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
            ("stress xx", of(&|p| p.deviator[0] - p.pressure)),
            ("stress yy", of(&|p| p.deviator[1] - p.pressure)),
            ("stress xy", of(&|p| p.deviator[3])),
            ("energy", of(&|p| p.energy)),
        ]
    }

    fn n_elements(&self) -> usize {
        self.particles.len()
    }
}
