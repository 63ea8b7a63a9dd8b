//! The factor of safety of a slope without friction, from a run in which its weight grows until it slides.

use smpm::{Error, Simulation};

/// Where the factor is read, and how a run gets there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slide {
    /// The largest displacement of a particle from which on, and up to which, energies are compared (length).
    pub(super) displacements: [f64; 2],
    /// Time between two looks (time).
    pub(super) interval: f64,
    /// The gravity of which the factor is the multiple (length per time squared).
    pub(super) gravity: f64,
}

/// Energy of the material, work of gravity, and the largest displacement.
struct Seen {
    internal: f64,
    work: f64,
    displacement: f64,
}

impl Slide {
    fn look(&self, run: &Simulation<f64, 2>, starts: &[[f64; 2]]) -> Seen {
        let mut seen = Seen { internal: run.ledger().internal, work: 0.0, displacement: 0.0 };
        for body in run.bodies() {
            for ((x, start), mass) in body.positions().iter().zip(starts).zip(body.masses()) {
                let [along, down] = [x[0] - start[0], start[1] - x[1]];
                seen.work += mass * self.gravity * down;
                seen.displacement = seen.displacement.max(along.hypot(down));
            }
        }
        seen
    }

    /// The factor of safety of a run of one body: what the material dissipates over what gravity would do at its nominal value,
    /// between two displacements.
    ///
    /// $$ F = \frac{\int_V \sigma : \dot\varepsilon\, dV}{\int_V \rho g \cdot v\, dV} $$
    ///
    /// For a soil of undrained strength it is the upper bound of the kinematic theorem of limit analysis (Drucker, Prager and
    /// Greenberg 1952) for the velocities of the run, so errors of these enter in second order. A slope at rest has as its ratio the
    /// multiple of gravity that acts; from its collapse on the ratio stays, while inertia takes the rest of the load.
    ///
    /// None if the run ends before the slope has slid so far.
    pub(super) fn factor(
        &self,
        run: &mut Simulation<f64, 2>,
        end: f64,
    ) -> Result<Option<f64>, Error> {
        let starts: Vec<[f64; 2]> =
            run.bodies().iter().flat_map(|body| body.positions().to_vec()).collect();
        let [from, to] = self.displacements;
        let mut first: Option<Seen> = None;
        let mut n_looks = 0_u32;
        while run.time() < end {
            n_looks += 1;
            run.advance_to((f64::from(n_looks) * self.interval).min(end))?;
            let seen = self.look(run, &starts);
            match &first {
                None if seen.displacement >= from => first = Some(seen),
                Some(first) if seen.displacement >= to => {
                    return Ok(Some((seen.internal - first.internal) / (seen.work - first.work)));
                }
                _ => {}
            }
        }
        Ok(None)
    }
}
