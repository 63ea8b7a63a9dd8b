//! Regions of space filled by bodies.

use scene_runs::scene::Objection;

use super::polygon::Polygon;
use crate::coordinates::point;
use crate::scene::{BodyScene, SolidScene};

/// What a body fills: its shape without the regions that are cut out.
pub(crate) struct BodyRegion<const D: usize> {
    whole: Region<D>,
    cuts: Vec<Region<D>>,
}

impl<const D: usize> BodyRegion<D> {
    pub(crate) fn of(body: &BodyScene, path: &str) -> Result<Self, Objection> {
        let whole = Region::of(&body.shape, &format!("{path}.shape"))?;
        let cut = |(i, shape)| Region::of(shape, &format!("{path}.except[{i}]"));
        let cuts = body.except.iter().enumerate().map(cut).collect::<Result<_, _>>()?;
        Ok(Self { whole, cuts })
    }

    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        self.whole.bounds()
    }

    pub(crate) fn holds(&self, x: &[f64; D]) -> bool {
        self.whole.holds(x) && !self.cuts.iter().any(|cut| cut.holds(x))
    }
}

/// A region with points of the right dimension.
enum Region<const D: usize> {
    Box { from: [f64; D], to: [f64; D] },
    Ball { centre: [f64; D], radius: f64 },
    Cylinder { base: [f64; D], radius: f64, height: f64 },
    Polygon(Polygon<D>),
}

impl<const D: usize> Region<D> {
    fn of(scene: &SolidScene, path: &str) -> Result<Self, Objection> {
        let positive = |key: &str, value: f64| {
            if value > 0.0 {
                Ok(value)
            } else {
                let message = format!("the {key} is {value} and must be greater than 0");
                Err(Objection::new(format!("{path}.{key}"), message))
            }
        };
        match scene {
            SolidScene::Box { from, to } => Ok(Self::Box {
                from: point(from, &format!("{path}.box.from"))?,
                to: point(to, &format!("{path}.box.to"))?,
            }),
            SolidScene::Ball { centre, radius } => Ok(Self::Ball {
                centre: point(centre, &format!("{path}.ball.centre"))?,
                radius: positive("radius", *radius)?,
            }),
            SolidScene::Cylinder { base, radius, height } if D == 3 => Ok(Self::Cylinder {
                base: point(base, &format!("{path}.cylinder.base"))?,
                radius: positive("radius", *radius)?,
                height: positive("height", *height)?,
            }),
            SolidScene::Cylinder { .. } => {
                Err(Objection::new(path, "a cylinder is a shape in three dimensions only"))
            }
            SolidScene::Polygon { corners } => {
                Polygon::of(corners, &format!("{path}.polygon")).map(Self::Polygon)
            }
        }
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        match *self {
            Self::Box { from, to } => (from, to),
            Self::Polygon(ref polygon) => polygon.bounds(),
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
            Self::Cylinder { base, radius, height } => {
                square(base, 2) < radius * radius && (0.0..*height).contains(&(x[2] - base[2]))
            }
        }
    }
}
