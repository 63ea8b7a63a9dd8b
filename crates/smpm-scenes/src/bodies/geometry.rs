//! Checks of the bodies of a scene, before anything is computed: names, overlaps, detonations; and how sizes are rounded.

use std::collections::BTreeSet;

use result_figures::number::tidy;
use scene_runs::scene::Objection;
use smpm::Fill;

use super::region::BodyRegion;
use crate::coordinates::point;
use crate::scene::{SmpmScene, SolidScene};

/// Largest part of a particle by which a body may miss the size that is asked for, without a note: roundoff.
const ROUNDOFF: f64 = 1e-6;

impl SmpmScene {
    /// Rejects names that occur twice.
    pub(crate) fn check_names(&self) -> Result<(), Objection> {
        distinct("bodies", "body", self.bodies.iter().map(|body| body.name.as_str()))?;
        distinct("gauges", "gauge", self.gauges.iter().map(|gauge| gauge.name.as_str()))
    }

    /// Rejects bodies without particles, bodies that overlap, and detonations outside of their charge.
    pub(crate) fn check_bodies<const D: usize>(&self) -> Result<(), Objection> {
        let (mut regions, mut fills) = (Vec::new(), Vec::new());
        for (i, body) in self.bodies.iter().enumerate() {
            let fill = self.fill::<D>(i)?;
            if fill.positions.is_empty() {
                let message = format!("body `{}` holds no particle", body.name);
                return Err(Objection::new(format!("bodies[{i}].shape"), message));
            }
            regions.push(BodyRegion::<D>::of(body, &format!("bodies[{i}]"))?);
            fills.push(fill);
        }
        for later in 1..regions.len() {
            for earlier in 0..later {
                self.keep_apart([earlier, later], &regions, &fills)?;
            }
        }
        self.materials.keys().try_for_each(|name| self.check_detonation(name, &fills))
    }

    /// Rejects particles of one body that lie in the region of the other: their mass would count twice.
    fn keep_apart<const D: usize>(
        &self,
        bodies: [usize; 2],
        regions: &[BodyRegion<D>],
        fills: &[Fill<D>],
    ) -> Result<(), Objection> {
        let [earlier, later] = bodies;
        for [of, within] in [[later, earlier], [earlier, later]] {
            let mut shared =
                fills[of].positions.iter().filter(|place| regions[within].holds(place));
            let Some(first) = shared.next() else { continue };
            let message = format!(
                "bodies `{}` and `{}` overlap: {} of the {} particles of `{}` lie in `{}`, the first at {first:?}",
                self.bodies[earlier].name,
                self.bodies[later].name,
                1 + shared.count(),
                fills[of].positions.len(),
                self.bodies[of].name,
                self.bodies[within].name,
            );
            let help = "cut the region of one out of the other by `except`, or move one of them";
            return Err(Objection::new(format!("bodies[{later}].shape"), message).with_help(help));
        }
        Ok(())
    }

    /// Rejects a detonation point that is farther from every particle of its charge than these are from each other.
    fn check_detonation<const D: usize>(
        &self,
        material: &str,
        fills: &[Fill<D>],
    ) -> Result<(), Objection> {
        let path = format!("materials.{material}.detonation.point");
        let Some(burn) = &self.materials[material].detonation else { return Ok(()) };
        let start = point::<D>(&burn.point, &path)?;
        let distance = |place: &[f64; D]| {
            place.iter().zip(&start).fold(0.0, |most, (x, y)| f64::max(most, (x - y).abs()))
        };
        let of_material =
            self.bodies.iter().zip(fills).filter(|(body, _)| body.material == material);
        let places = of_material.flat_map(|(_, fill)| &fill.positions);
        let nearest = places.map(distance).min_by(f64::total_cmp);
        let spacing = self.grid.cell / f64::from(self.grid.particles_per_cell);
        match nearest {
            Some(nearest) if nearest > spacing => {
                let message = format!(
                    "the detonation point {start:?} lies outside of all bodies of `{material}`: the nearest particle is {nearest} away; at most {spacing} is allowed, the distance between particles"
                );
                Err(Objection::new(path, message))
            }
            _ => Ok(()),
        }
    }

    /// What a reader must know of the sizes of boxes: particles fill whole multiples of their spacing.
    pub(crate) fn rounded_sizes(&self) -> Vec<String> {
        let spacing = self.grid.cell / f64::from(self.grid.particles_per_cell);
        let mut notes = Vec::new();
        for body in &self.bodies {
            let SolidScene::Box { from, to } = &body.shape else { continue };
            for (axis, (from, to)) in from.iter().zip(to).enumerate() {
                let asked = to - from;
                // A layer counts if its middle lies inside.
                let filled = (asked / spacing - 0.5).ceil() * spacing;
                if (filled - asked).abs() > ROUNDOFF * spacing {
                    notes.push(format!(
                        "body `{}` is {} along axis {}, not {}: particles fill whole boxes of {spacing}",
                        body.name,
                        tidy(filled),
                        axis + 1,
                        tidy(asked),
                    ));
                }
            }
        }
        notes
    }
}

/// Rejects a name that occurs twice in a list.
fn distinct<'a>(
    list: &str,
    what: &str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), Objection> {
    let mut known = BTreeSet::new();
    for (i, name) in names.enumerate() {
        if !known.insert(name) {
            let message = format!("there is another {what} `{name}`; each needs a name of its own");
            return Err(Objection::new(format!("{list}[{i}].name"), message));
        }
    }
    Ok(())
}
