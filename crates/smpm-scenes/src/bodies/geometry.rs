//! Checks of the bodies of a scene, before anything is computed: names, overlaps, detonations; and how sizes are rounded.

use std::collections::BTreeSet;

use result_figures::number::{counted, tidy};
use scene_runs::scene::Objection;
use smpm::Fill;

use super::region::BodyRegion;
use crate::coordinates::point;
use crate::material_scene::EquationScene;
use crate::method_scene::MethodScene;
use crate::scene::{BodyScene, ContactScene, ShapeScene, SmpmScene, SolidScene};

/// Largest part of a particle by which a body may miss the size that is asked for, without a note: roundoff.
const ROUNDOFF: f64 = 1e-6;

/// Largest number of cells over which a burn is spread; over more than a charge has, it never detonates.
const MOST_BURN_CELLS: f64 = 100.0;

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
            if self.axisymmetric && body.rotation.is_some() {
                let message = "a rotated region is not symmetric about the axis of a scene";
                return Err(Objection::new(format!("bodies[{i}].rotation"), message));
            }
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
        if burn.cells > MOST_BURN_CELLS {
            let message = format!(
                "{} cells; the front may be spread over {MOST_BURN_CELLS} at most",
                burn.cells
            );
            return Err(Objection::new(format!("materials.{material}.detonation.cells"), message));
        }
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
        let numbers = self.random.iter().map(|random| &random.parameter);
        let numbers: Vec<&String> =
            numbers.chain(self.sweep.iter().map(|sweep| &sweep.number)).collect();
        for (i, body) in self.bodies.iter().enumerate() {
            // A rotated box is not filled by whole layers.
            let (SolidScene::Box { from, to }, None) = (&body.shape, &body.rotation) else {
                continue;
            };
            // Particles of a box whose size varies are stretched to it.
            if numbers.iter().any(|path| path.starts_with(&format!("bodies[{i}].shape."))) {
                continue;
            }
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

    /// A note for levels of a single run, which has no probabilities.
    pub(crate) fn levels_of_one_run(&self) -> Option<String> {
        let is_one = self.method == MethodScene::Deterministic;
        (is_one && !self.levels.is_empty()).then(|| {
            "`levels` are not used: one run has no probabilities; take a method for random parameters".to_owned()
        })
    }

    /// A note for one particle a cell, which is far too stiff in bending.
    pub(crate) fn sparse_particles(&self) -> Option<String> {
        (self.grid.particles_per_cell == 1 && self.dimension > 1).then(|| {
            "one particle along the edge of a cell: bodies that bend are far too stiff (a cantilever with Poisson's ratio 0.499 deflects by 0.02 in place of 0.307); take 2, except for the collapse of plastic bodies".to_owned()
        })
    }

    /// A note for each solid body that has come apart without failure of its material, by the pairs of particles of each body.
    pub(crate) fn torn(&self, pairs: &[usize]) -> Vec<String> {
        let is_solid = |body: &BodyScene| {
            self.materials.get(&body.material).is_some_and(|material| {
                material.strength.is_some()
                    || matches!(material.equation, EquationScene::NeoHookean(_))
            })
        };
        let bodies = self.bodies.iter().zip(pairs).filter(|(body, n)| **n > 0 && is_solid(body));
        let note = |(body, n): (&BodyScene, &usize)| {
            format!(
                "body `{}` is torn by the grid, not by its material: {} of neighbouring particles share no node any more at the end; numbers that depend on it are wrong from then on: take smaller cells, cubic B-splines, more particles a cell, or a material with `damage`",
                body.name,
                counted(*n, "pair"),
            )
        };
        bodies.map(note).collect()
    }

    /// Cells from which particles of two bodies share a node.
    fn reach_in_words(&self) -> &'static str {
        match self.scheme.shape {
            Some(ShapeScene::CubicBSpline) => "four",
            _ => "three",
        }
    }

    /// A note for each pair of bonded bodies that are apart at the start: they act on each other before they touch, and never part.
    ///
    /// Bodies are as far apart as the boxes about them.
    ///
    /// # Errors
    /// An [`Objection`] to a region.
    pub(crate) fn bonded_gaps<const D: usize>(&self) -> Result<Vec<String>, Objection> {
        if self.contact != ContactScene::Bonded {
            return Ok(Vec::new());
        }
        let bounds = |(i, body)| Ok(BodyRegion::<D>::of(body, &format!("bodies[{i}]"))?.bounds());
        let boxes =
            self.bodies.iter().enumerate().map(bounds).collect::<Result<Vec<_>, Objection>>()?;
        let (cell, reach) = (self.grid.cell, self.reach_in_words());
        let mut notes = Vec::new();
        for later in 1..boxes.len() {
            for earlier in 0..later {
                let ((low, high), (other_low, other_high)) = (boxes[earlier], boxes[later]);
                let along = |k: usize| f64::max(other_low[k] - high[k], low[k] - other_high[k]);
                let gap = (0..D).map(along).fold(f64::NEG_INFINITY, f64::max);
                if gap > ROUNDOFF * cell {
                    notes.push(format!(
                        "bodies `{}` and `{}` are {} cells apart and `contact` is bonded: they act on each other from {reach} cells on and stick together; write \"contact\": {{\"friction\": {{\"coefficient\": 0}}}} for bodies that meet and part",
                        self.bodies[earlier].name,
                        self.bodies[later].name,
                        tidy(gap / cell),
                    ));
                }
            }
        }
        Ok(notes)
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
