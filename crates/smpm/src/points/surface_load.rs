//! Loads on the surface of a body.

use std::collections::BTreeSet;

use constitutive_models::finite;

use crate::config::{check_history, multiple_at};
use crate::error::Error;

/// How far beyond its region the centre of a face may be, in spacings: roundoff.
const ROUNDOFF: f64 = 1e-6;

/// A load on a part of the surface of a body, per area of the start and in directions of the start (a dead load).
///
/// The surface is that of the boxes of the particles: the faces without a particle beyond them. A face whose centre is in the region,
/// with the outward normal `n` and the area `A`, bears
///
/// $$ f = (t - p\, n)\, A\, m(\text{time}), $$
///
/// per radian where axisymmetric. The nodes take it where the particle of the face is, half a spacing within the body. The faces of a
/// curved or inclined surface are steps: their forces by a pressure add up to the right one, those by a traction have the area of the
/// steps, which is larger.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceLoad<const D: usize> {
    /// Lowest and highest corner of the region, at the start (length).
    pub within: [[f64; D]; 2],
    /// The pressure `p`, positive into the body (stress).
    pub pressure: f64,
    /// The traction `t` (stress).
    pub traction: [f64; D],
    /// Its multiple `m`, as points of time (time) and multiple in ascending order, linear between them and constant before the first and
    /// after the last. Without points it is one.
    pub history: Vec<[f64; 2]>,
}

/// A load as forces on particles.
#[derive(Debug)]
pub(crate) struct Loaded<const D: usize> {
    history: Vec<[f64; 2]>,
    faces: Vec<Face<D>>,
}

/// A loaded face.
#[derive(Debug)]
struct Face<const D: usize> {
    /// Number of its particle.
    particle: u32,
    force: [f64; D],
    /// First coordinate of its centre (length).
    radius: f64,
}

impl<const D: usize> SurfaceLoad<D> {
    /// The forces on particles at their places at the start.
    pub(crate) fn on(
        &self,
        positions: impl Iterator<Item = [f64; D]> + Clone,
        spacing: &[f64; D],
    ) -> Result<Loaded<D>, Error> {
        let [from, to] = self.within;
        for &corner in from.iter().chain(&to) {
            finite("corner of the region of a load", corner)?;
        }
        finite("pressure of a load", self.pressure)?;
        self.traction.iter().try_for_each(|&along| finite("traction of a load", along))?;
        check_history(["time in the history of a load", "multiple of a load"], &self.history)?;
        let first = positions.clone().next().unwrap_or([0.0; D]);
        #[allow(clippy::cast_possible_truncation, reason = "a whole number of spacings")]
        let site = |x: &[f64; D]| -> [i64; D] {
            std::array::from_fn(|k| ((x[k] - first[k]) / spacing[k]).round() as i64)
        };
        let sites: BTreeSet<[i64; D]> = positions.clone().map(|x| site(&x)).collect();
        let volume: f64 = spacing.iter().product();
        let mut faces = vec![];
        for (particle, x) in (0_u32..).zip(positions) {
            for axis in 0..D {
                for (side, step) in [(-1.0, -1), (1.0, 1)] {
                    let (mut beyond, mut centre) = (site(&x), x);
                    beyond[axis] += step;
                    centre[axis] += 0.5 * side * spacing[axis];
                    let is_within = (0..D).all(|k| {
                        let slack = ROUNDOFF * spacing[k];
                        (from[k] - slack..=to[k] + slack).contains(&centre[k])
                    });
                    if is_within && !sites.contains(&beyond) {
                        let area = volume / spacing[axis];
                        let mut force = self.traction.map(|along| along * area);
                        force[axis] -= side * self.pressure * area;
                        faces.push(Face { particle, force, radius: centre[0] });
                    }
                }
            }
        }
        if faces.is_empty() {
            return Err(Error::NoFaceLoaded { from: from.to_vec(), to: to.to_vec() });
        }
        Ok(Loaded { history: self.history.clone(), faces })
    }
}

impl<const D: usize> Loaded<D> {
    /// The same per radian.
    pub(crate) fn make_axisymmetric(&mut self) {
        for face in &mut self.faces {
            face.force = face.force.map(|along| along * face.radius);
        }
    }

    /// Calls with the number of each particle and the force on a face of it at a time.
    pub(crate) fn for_each(&self, time: f64, mut visit: impl FnMut(usize, [f64; D])) {
        let multiple = multiple_at(&self.history, time);
        for face in &self.faces {
            visit(face.particle as usize, face.force.map(|along| along * multiple));
        }
    }
}
