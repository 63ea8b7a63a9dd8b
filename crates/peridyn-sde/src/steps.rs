//! The steps themselves.

use crate::body::{AtStrength, Body};
use crate::error::Error;
use crate::real::Real;
use crate::resistance::Resistance;
use crate::scheme::{Dynamics, Scheme};
use crate::simulation::Simulation;
use crate::update::{CHUNK, Unknowns, Which};

impl<T: Real, B: Body<T, D, L>, const D: usize, const L: usize> Simulation<T, B, D, L> {
    /// `u += h M F(u) + sqrt(2 kT h) L z`, with `z` the mean of two steps for Leimkuhler and Matthews' method.
    pub(crate) fn euler_step(&mut self, scheme: Scheme) -> Result<(), Error> {
        self.evaluate(AtStrength::Break)?;
        let temperature = self.config.dynamics.temperature();
        let mut amplitude = (2.0 * temperature * self.config.dt).sqrt();
        let averaged = scheme == Scheme::LeimkuhlerMatthews && temperature > 0.0;
        if averaged {
            amplitude *= 0.5;
            self.have_last_kick()?;
        }
        if let Resistance::Diagonal { .. } = self.resistance {
            self.total_forces(self.time);
            self.move_apart(amplitude, averaged);
        } else {
            self.drift()?;
            self.draw()?;
            self.move_together(amplitude, averaged);
        }
        self.finish()
    }

    /// An Euler step of a mobility that is a number at each unknown, in one pass: normals are used while they are near.
    fn move_apart(&mut self, amplitude: f64, averaged: bool) {
        let Self { resistance, unknowns, kicks, level, step, .. } = self;
        let Resistance::Diagonal { values, factor } = &*resistance else { return };
        let Unknowns { u, drift, work: [last, ..], .. } = unknowns;
        let (h, is_noisy) = (T::of(self.config.dt), amplitude > 0.0);
        let amplitude = T::of(amplitude);
        for first in (0..values.len()).step_by(CHUNK) {
            let range = first..values.len().min(first + CHUNK);
            let lanes = range.start * L..range.end * L;
            let normals = if is_noisy { kicks.normals(*step, range.clone()) } else { &[] };
            let (values, factor) = (&values[range.clone()], &factor[range]);
            let forces = drift[lanes.clone()].as_chunks::<L>().0;
            let last = if averaged { &mut last[lanes.clone()] } else { &mut [] };
            let last = last.as_chunks_mut::<L>().0;
            let (u, z) = (u[lanes].as_chunks_mut::<L>().0, normals.as_chunks::<L>().0);
            level.call(
                #[inline(always)]
                || {
                    for m in 0..u.len() {
                        let mut kick = [T::ZERO; L];
                        if is_noisy {
                            kick = std::array::from_fn(|lane| T::of(z[m][lane]) * factor[m]);
                        }
                        if averaged {
                            let this = kick;
                            for lane in 0..L {
                                kick[lane] += last[m][lane];
                            }
                            last[m] = this;
                        }
                        for lane in 0..L {
                            let drift = forces[m][lane] * values[m];
                            u[m][lane] += h * drift + amplitude * kick[lane];
                        }
                    }
                },
            );
        }
    }

    /// An Euler step of a drift and a kick that are there already.
    fn move_together(&mut self, amplitude: f64, averaged: bool) {
        let h = T::of(self.config.dt);
        let (amplitude, unknowns) = (T::of(amplitude), &mut self.unknowns);
        if averaged {
            for (last, kick) in unknowns.work[0].iter_mut().zip(&mut unknowns.kick) {
                let this = *kick;
                *kick += *last;
                *last = this;
            }
        }
        let moves = unknowns.drift.iter().zip(&unknowns.kick);
        for (u, (&drift, &kick)) in unknowns.u.iter_mut().zip(moves) {
            *u += h * drift + amplitude * kick;
        }
    }

    /// `u* = u + h M F(u) + sqrt(2 kT h) L z`, then the same with the mean of `M F` at `u` and `u*`.
    pub(crate) fn heun_step(&mut self) -> Result<(), Error> {
        let h = T::of(self.config.dt);
        self.evaluate(AtStrength::Break)?;
        self.drift()?;
        let amplitude = T::of(self.draw()?);
        let unknowns = &mut self.unknowns;
        let [start, first, at_start, _] = &mut unknowns.work;
        start.clone_from(&unknowns.u);
        first.clone_from(&unknowns.drift);
        at_start.clone_from(&unknowns.forces);
        for (i, u) in unknowns.u.iter_mut().enumerate() {
            *u += h * unknowns.drift[i] + amplitude * unknowns.kick[i];
        }
        self.follow();
        self.evaluate(AtStrength::Hold)?;
        self.drift()?;
        let unknowns = &mut self.unknowns;
        let [start, first, at_start, _] = &mut unknowns.work;
        let half = h * T::of(0.5);
        for (i, u) in unknowns.u.iter_mut().enumerate() {
            let drift = first[i] + unknowns.drift[i];
            *u = start[i] + (half * drift + amplitude * unknowns.kick[i]);
        }
        std::mem::swap(&mut unknowns.forces, at_start);
        self.finish()
    }

    /// `v += h/2 F/m`, `u += h/2 v`, `v = c v + sqrt((1 - c^2) kT/m) z`, `u += h/2 v`, `v += h/2 F/m` with `c = exp(-gamma h)`.
    pub(crate) fn baoab_step(&mut self) -> Result<(), Error> {
        let Dynamics::Inertial { friction, temperature, .. } = self.config.dynamics else {
            return Ok(());
        };
        let dt = self.config.dt;
        let half = T::of(0.5 * dt);
        let kept = (-friction * dt).exp();
        // 1 - c^2 without cancellation.
        let amplitude = (-(-2.0 * friction * dt).exp_m1() * temperature).sqrt();
        self.drift()?;
        if amplitude > 0.0 {
            self.kicks.kick(&self.resistance, Which::Step(self.step), &mut self.unknowns.kick)?;
        }
        let (kept, amplitude) = (T::of(kept), T::of(amplitude));
        let Unknowns { u, v, drift, kick, .. } = &mut self.unknowns;
        self.level.call(
            #[inline(always)]
            || {
                let moves = u.iter_mut().zip(v).zip(drift.iter().zip(&*kick));
                for ((u, v), (&drift, &kick)) in moves {
                    let before = *v + half * drift;
                    *v = kept * before + amplitude * kick;
                    *u += half * (before + *v);
                }
            },
        );
        self.finish()?;
        self.evaluate(AtStrength::Break)?;
        self.drift_at(self.time_after())?;
        let Unknowns { v, drift, .. } = &mut self.unknowns;
        self.level.call(
            #[inline(always)]
            || {
                for (v, &drift) in v.iter_mut().zip(&*drift) {
                    *v += half * drift;
                }
            },
        );
        Ok(())
    }

    /// The kick of this step, and what it is to be multiplied by; nothing is drawn at `kT = 0`.
    pub(crate) fn draw(&mut self) -> Result<f64, Error> {
        let temperature = self.config.dynamics.temperature();
        if temperature > 0.0 {
            self.kicks.kick(&self.resistance, Which::Step(self.step), &mut self.unknowns.kick)?;
        }
        Ok((2.0 * temperature * self.config.dt).sqrt())
    }

    /// Makes the kick of the step before, where it is not kept.
    fn have_last_kick(&mut self) -> Result<(), Error> {
        let last = &mut self.unknowns.work[0];
        if last.is_empty() {
            let which = self.step.checked_sub(1).map_or(Which::BeforeFirst, Which::Step);
            self.kicks.kick(&self.resistance, which, last)?;
        }
        Ok(())
    }

    /// `M (F + loads - epsilon u)` at the time of the step.
    pub(crate) fn drift(&mut self) -> Result<(), Error> {
        self.drift_at(self.time)
    }

    fn drift_at(&mut self, time: f64) -> Result<(), Error> {
        self.total_forces(time);
        let drift = &mut self.unknowns.drift;
        match &self.resistance {
            Resistance::Diagonal { values, .. } => {
                self.level.call(
                    #[inline(always)]
                    || {
                        for (drift, &value) in drift.as_chunks_mut::<L>().0.iter_mut().zip(values) {
                            for drift in drift {
                                *drift = *drift * value;
                            }
                        }
                    },
                );
                Ok(())
            }
            coupled @ Resistance::Coupled { .. } => {
                self.kicks.back(coupled, drift)?;
                self.kicks.forth(coupled, drift)
            }
        }
    }

    /// Forces of bonds, repulsion, loads and confinement, into `drift`.
    pub(crate) fn total_forces(&mut self, time: f64) {
        let epsilon = T::of(self.config.confinement);
        let unknowns = &mut self.unknowns;
        unknowns.drift.clone_from(&unknowns.forces);
        if self.config.confinement > 0.0 {
            for (drift, &u) in unknowns.drift.iter_mut().zip(&unknowns.u) {
                *drift -= epsilon * u;
            }
        }
        let drift = &mut unknowns.drift;
        if let Some(repelled) = &self.repulsion {
            repelled.contact.add(drift);
        }
        self.loading.for_each_force(time, |node, force| {
            for k in 0..D {
                for drift in &mut drift[(node * D + k) * L..(node * D + k + 1) * L] {
                    *drift += T::of(force[k]);
                }
            }
        });
    }

    pub(crate) fn time_after(&self) -> f64 {
        (self.step + 1) as f64 * self.config.dt
    }

    /// Takes free nodes along with the fields of the drives, puts gripped ones where they are given, and looks whether all is
    /// finite.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        self.follow();
        let u = &self.unknowns.u;
        let probe = self.level.call(
            #[inline(always)]
            || u.iter().fold(T::ZERO, |sum, &u| sum + u * T::ZERO),
        );
        if probe.is_finite() { Ok(()) } else { Err(self.lost()) }
    }

    pub(crate) fn follow(&mut self) {
        if !self.loading.is_driven() {
            return;
        }
        let (from, to) = (self.time, self.time_after());
        let nodes = self.unknowns.u.as_chunks_mut::<L>().0.as_chunks_mut::<D>().0;
        for (node, (u, gripped)) in nodes.iter_mut().zip(self.loading.gripped()).enumerate() {
            let (before, after) = (self.loading.field(node, from), self.loading.field(node, to));
            for k in 0..D {
                let (place, change) = (T::of(after[k]), T::of(after[k] - before[k]));
                for u in &mut u[k] {
                    *u = if gripped[k] { place } else { *u + change };
                }
            }
        }
    }

    /// Puts gripped nodes where they are given at the present time.
    pub(crate) fn grip(&mut self) {
        let nodes = self.unknowns.u.as_chunks_mut::<L>().0.as_chunks_mut::<D>().0;
        for (node, (u, gripped)) in nodes.iter_mut().zip(self.loading.gripped()).enumerate() {
            let place = self.loading.field(node, self.time);
            for k in 0..D {
                if gripped[k] {
                    u[k] = [T::of(place[k]); L];
                }
            }
        }
    }
}
