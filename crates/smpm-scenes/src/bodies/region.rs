//! Regions of space filled by bodies.

use std::sync::Arc;

use scene_runs::scene::Objection;
use smpm::Fill;

use super::files::positive;
use super::point_list::PointList;
use super::polygon::Polygon;
use super::rotation::Rotation;
use super::surface::Surface;
use crate::coordinates::point;
use crate::scene::{BodyScene, SolidScene};

/// Largest part of a spacing by which a rotated body may reach beyond the lattice: roundoff.
const ROUNDOFF: f64 = 1e-6;

/// What a body fills: its shape without the regions that are cut out, rotated.
pub(crate) struct BodyRegion<const D: usize> {
    whole: Region<D>,
    cuts: Vec<Region<D>>,
    rotation: Option<Rotation<D>>,
}

impl<const D: usize> BodyRegion<D> {
    pub(crate) fn of(body: &BodyScene, path: &str) -> Result<Self, Objection> {
        let whole = Region::of(&body.shape, &format!("{path}.shape"))?;
        let cut = |(i, shape): (usize, &SolidScene)| {
            let path = format!("{path}.except[{i}]");
            if matches!(shape, SolidScene::Points { .. }) {
                return Err(Objection::new(path, "particles are no region to cut out"));
            }
            Region::of(shape, &path)
        };
        let cuts = body.except.iter().enumerate().map(cut).collect::<Result<_, _>>()?;
        let path = format!("{path}.rotation");
        if let (Some(_), Region::Points(_)) = (&body.rotation, &whole) {
            let message = "particles from a file are not rotated";
            return Err(Objection::new(path, message).with_help("rotate the places in the file"));
        }
        let rotation =
            body.rotation.as_ref().map(|scene| Rotation::of(scene, &path)).transpose()?;
        Ok(Self { whole, cuts, rotation })
    }

    /// The box about it.
    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        let bounds = self.whole.bounds();
        self.rotation.as_ref().map_or(bounds, |rotation| rotation.bounds(bounds))
    }

    /// The box that its particles fill: of a box whole layers, which may be others than its size; of another shape that about it.
    pub(crate) fn filled(&self, fill: &Fill<D>) -> ([f64; D], [f64; D]) {
        let Region::Box { .. } = self.whole else { return self.bounds() };
        let end = |start: f64, of: fn(f64, f64) -> f64, half: f64| {
            std::array::from_fn(|k| {
                fill.positions.iter().map(|x| x[k]).fold(start, of) + half * fill.spacing[k]
            })
        };
        (end(f64::INFINITY, f64::min, -0.5), end(f64::NEG_INFINITY, f64::max, 0.5))
    }

    /// The box of its lattice: that about it or, if it is rotated, boxes of the lattice of the grid.
    pub(crate) fn lattice(&self, spacing: f64) -> ([f64; D], [f64; D]) {
        let (low, high) = self.bounds();
        if self.rotation.is_none() {
            return (low, high);
        }
        (
            low.map(|x| (x / spacing + ROUNDOFF).floor() * spacing),
            high.map(|x| (x / spacing - ROUNDOFF).ceil() * spacing),
        )
    }

    pub(crate) fn holds(&self, x: &[f64; D]) -> bool {
        let x = &self.rotation.as_ref().map_or(*x, |rotation| rotation.back(x));
        self.whole.holds(x) && !self.cuts.iter().any(|cut| cut.holds(x))
    }

    /// Where points of the body are after it has turned to the rotation of another region, if both are rotated.
    pub(crate) fn turn(&self, to: &Self) -> Option<impl Fn(&[f64; D]) -> [f64; D]> {
        let (from, to) = (self.rotation.as_ref()?, to.rotation.as_ref()?);
        Some(|x: &[f64; D]| to.forward(&from.back(x)))
    }

    /// Its particles, if a file lists them.
    pub(crate) fn listed(&self) -> Option<Fill<D>> {
        let Region::Points(list) = &self.whole else { return None };
        let places = list.places.iter().map(|place| std::array::from_fn(|k| place[k]));
        let positions = places.filter(|x| !self.cuts.iter().any(|cut| cut.holds(x))).collect();
        Some(Fill { positions, spacing: [list.spacing; D] })
    }

    /// The mean number of triangles of surfaces that are visited for a point.
    pub(crate) fn n_visited(&self) -> f64 {
        let of = |region: &Region<D>| match region {
            Region::Surface(surface) => surface.n_visited(),
            _ => 0.0,
        };
        of(&self.whole) + self.cuts.iter().map(of).sum::<f64>()
    }
}

/// A region with points of the right dimension.
enum Region<const D: usize> {
    Box { from: [f64; D], to: [f64; D] },
    Ball { centre: [f64; D], radius: f64 },
    Cylinder { base: [f64; D], radius: f64, height: f64 },
    Polygon(Polygon<D>),
    Surface(Arc<Surface>),
    Points(Arc<PointList>),
}

impl<const D: usize> Region<D> {
    fn of(scene: &SolidScene, path: &str) -> Result<Self, Objection> {
        match scene {
            SolidScene::Box { from, to } => Ok(Self::Box {
                from: point(from, &format!("{path}.box.from"))?,
                to: point(to, &format!("{path}.box.to"))?,
            }),
            SolidScene::Ball { centre, radius } => Ok(Self::Ball {
                centre: point(centre, &format!("{path}.ball.centre"))?,
                radius: positive("radius", *radius, path)?,
            }),
            SolidScene::Cylinder { base, radius, height } if D == 3 => Ok(Self::Cylinder {
                base: point(base, &format!("{path}.cylinder.base"))?,
                radius: positive("radius", *radius, path)?,
                height: positive("height", *height, path)?,
            }),
            SolidScene::Cylinder { .. } => {
                Err(Objection::new(path, "a cylinder is a shape in three dimensions only"))
            }
            SolidScene::Polygon { corners } => {
                Polygon::of(corners, &format!("{path}.polygon")).map(Self::Polygon)
            }
            SolidScene::Surface { read: Some(surface), .. } if D == 3 => {
                Ok(Self::Surface(surface.clone()))
            }
            SolidScene::Surface { .. } if D != 3 => {
                Err(Objection::new(path, "a surface is a shape in three dimensions only"))
            }
            SolidScene::Points { read: Some(points), .. } => Ok(Self::Points(points.clone())),
            SolidScene::Surface { .. } | SolidScene::Points { .. } => {
                Err(Objection::new(path, "the file of the shape has not been read"))
            }
        }
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        match *self {
            Self::Box { from, to } => (from, to),
            Self::Polygon(ref polygon) => polygon.bounds(),
            Self::Surface(ref surface) => {
                let (low, high) = surface.bounds;
                (std::array::from_fn(|k| low[k]), std::array::from_fn(|k| high[k]))
            }
            Self::Points(ref list) => {
                let end = |start: f64, of: fn(f64, f64) -> f64, half: f64| {
                    std::array::from_fn(|k| {
                        list.places.iter().map(|x| x[k]).fold(start, of) + half * list.spacing
                    })
                };
                (end(f64::INFINITY, f64::min, -0.5), end(f64::NEG_INFINITY, f64::max, 0.5))
            }
            Self::Ball { centre, radius } => {
                (centre.map(|x| x - radius), centre.map(|x| x + radius))
            }
            Self::Cylinder { base, radius, height } => {
                let end = |k: usize, along: f64, across: f64| {
                    base[k] + if k == 2 { along } else { across }
                };
                (
                    std::array::from_fn(|k| end(k, 0.0, -radius)),
                    std::array::from_fn(|k| end(k, height, radius)),
                )
            }
        }
    }

    fn holds(&self, x: &[f64; D]) -> bool {
        let square =
            |from: &[f64; D], n: usize| (0..n).map(|k| (x[k] - from[k]).powi(2)).sum::<f64>();
        match self {
            Self::Box { from, to } => (0..D).all(|k| (from[k]..to[k]).contains(&x[k])),
            Self::Ball { centre, radius } => square(centre, D) < radius * radius,
            Self::Polygon(polygon) => polygon.holds(x),
            Self::Surface(surface) => surface.holds(&in_space(x)),
            Self::Points(list) => list.holds(&in_space(x)),
            Self::Cylinder { base, radius, height } => {
                square(base, 2) < radius * radius && (0.0..*height).contains(&(x[2] - base[2]))
            }
        }
    }
}

/// The point in three dimensions.
fn in_space<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|k| if k < D { x[k] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::surface::tests::{binary, sphere, surface};
    use crate::scene::{GridScene, SmpmScene};

    /// The particles of a shape, with other keys of its body, at the spacing 0.1.
    fn fill<const D: usize>(shape: SolidScene, keys: &str) -> Vec<[f64; D]> {
        let text = include_str!("../../../../tests/scenes/smpm/plate_impact.json");
        let scene = SmpmScene::read("a", text).unwrap();
        let keys = format!(
            "{{ 'name': 'a', 'material': 'a', 'shape': {{ 'box': {{ 'from': [], 'to': [] }} }}{keys} }}"
        );
        let body: BodyScene = serde_json::from_str(&keys.replace('\'', "\"")).unwrap();
        let grid = GridScene { cell: 0.2, particles_per_cell: 2 };
        let bodies = vec![BodyScene { shape, ..body }];
        SmpmScene { grid, bodies, dimension: D, ..scene }.fill(0).unwrap().positions
    }

    #[test]
    fn a_rotated_region_holds_what_the_region_holds() {
        let solid =
            |from: &[f64], to: &[f64]| SolidScene::Box { from: from.to_vec(), to: to.to_vec() };
        let with = |degrees: &str| {
            let keys = format!(", 'rotation': {{ 'about': [0, 0], 'degrees': {degrees} }}");
            fill::<2>(solid(&[0.0, 0.0], &[4.0, 2.0]), &keys)
        };
        let direct = fill::<2>(solid(&[-2.0, 0.0], &[0.0, 4.0]), "");
        let turned = with("90");
        assert_eq!(turned.len(), 800);
        for (x, y) in turned.iter().zip(&direct) {
            assert!((0..2).all(|k| (x[k] - y[k]).abs() < 1e-12), "{x:?} {y:?}");
        }
        // 17 more at 45 degrees, where particles lie on the edges; 1 less elsewhere.
        for degrees in ["10", "20", "30", "45", "77"] {
            let n = with(degrees).len();
            assert!(n.abs_diff(800) <= 20, "{degrees}: {n}");
        }
        let cylinder = || SolidScene::Cylinder { base: vec![0.0; 3], radius: 0.5, height: 1.0 };
        let keys = ", 'except': [{ 'box': { 'from': [0, -1, 0], 'to': [1, 1, 0.5] } }]";
        let rotation = ", 'rotation': { 'about': [0, 0, 0], 'axis': [2, 0, 0], 'degrees': 90 }";
        let upright = fill::<3>(cylinder(), keys);
        let lying = fill::<3>(cylinder(), &format!("{keys}{rotation}"));
        assert_eq!(lying.len(), upright.len());
        assert!(lying.iter().all(|x| x[1] < 0.0 && (x[0] < 0.0 || x[1] < -0.5)));
    }

    #[test]
    fn a_surface_of_a_ball_is_filled_as_the_ball_is() {
        let read = Some(Arc::new(surface(binary(&sphere(70))).unwrap()));
        let (file, scale, shift) = (String::new(), 1.0, vec![]);
        let filled = fill::<3>(SolidScene::Surface { file, scale, shift, read }, "");
        let ball = fill::<3>(SolidScene::Ball { centre: vec![0.5, 0.0, -1.0], radius: 2.0 }, "");
        // The same particles: none of 33552 is between the sphere and its chords.
        assert_eq!(filled.len(), 33_552);
        assert_eq!(filled, ball);
    }
}
