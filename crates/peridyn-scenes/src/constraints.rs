//! Nodes of a body with prescribed displacements.

use peridyn_sde::{Error, Loading, Nodes, Program};
use scene_runs::scene::Objection;

use super::positive::positive;
use super::scene::CrackScene;
use super::scene_load::{LoadingScene, RegionScene, StrainScene};

/// Nodes with prescribed displacements, and nodes whose bonds do not break.
#[derive(Debug)]
pub(super) struct Constraints {
    supports: Vec<(Vec<usize>, [bool; 2])>,
    moved: Moved,
    /// Nodes at which the load is measured, and its component.
    pub(super) load: (Vec<usize>, usize),
    pub(super) protected: Vec<usize>,
}

#[derive(Debug)]
enum Moved {
    /// The lower and the upper edge, along the vertical.
    Edges { lower: Vec<usize>, upper: Vec<usize>, directions: [bool; 2], by: Edges },
    /// A region, by a displacement (m).
    Region { nodes: Vec<usize>, until: [f64; 2] },
}

#[derive(Debug, Clone, Copy)]
enum Edges {
    Strain,
    Velocity,
}

/// The load at the end of a run, as a strain or a displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadEnd {
    /// A mean strain.
    Strain(f64),
    /// A displacement (m).
    Displacement(f64),
}

impl LoadEnd {
    /// The strain, if it is one.
    #[must_use]
    pub const fn strain(self) -> Option<f64> {
        match self {
            Self::Strain(value) => Some(value),
            Self::Displacement(_) => None,
        }
    }

    /// The displacement (m), if it is one.
    #[must_use]
    pub const fn displacement(self) -> Option<f64> {
        match self {
            Self::Strain(_) => None,
            Self::Displacement(value) => Some(value),
        }
    }
}

impl Constraints {
    pub(super) fn of(scene: &CrackScene, nodes: &Nodes<2>) -> Result<Self, Objection> {
        let mut protected = Vec::new();
        let mut within = |region: &RegionScene, path: &str, distance: f64| {
            protected.extend(chosen(nodes, |x| distance > 0.0 && region.distance(x) < distance));
            in_region(nodes, region, &format!("{path}.region"))
        };
        let mut supports = Vec::new();
        for (i, support) in scene.supports.iter().enumerate() {
            let path = format!("supports[{i}]");
            let held = within(&support.region, &path, support.protected)?;
            supports.push((held, support.hold.directions()));
        }
        if let LoadingScene::Displacement { region, until, protected: distance } = scene.loading {
            let moved = within(&region, "loading.displacement", distance)?;
            let component = usize::from(until[1].abs() > until[0].abs());
            let load = (moved.clone(), component);
            let moved = Moved::Region { nodes: moved, until };
            return Ok(Self { supports, moved, load, protected });
        }
        let Some(grips) = &scene.grips else {
            // The check of the scene comes first.
            return Err(Objection::new("loading", "nothing holds the body"));
        };
        let [lower, upper] = within_edges(scene, nodes, grips.height);
        for (nodes, edge) in [(&lower, "lower"), (&upper, "upper")] {
            if nodes.is_empty() {
                let message = format!("no node lies within {} m of the {edge} edge", grips.height);
                return Err(Objection::new("grips.height", message));
            }
        }
        let by = match scene.loading {
            LoadingScene::Velocity { .. } => Edges::Velocity,
            LoadingScene::Stretch { .. } | LoadingScene::Displacement { .. } => Edges::Strain,
        };
        protected = within_edges(scene, nodes, grips.protected).concat();
        let load = (upper.clone(), 1);
        let moved = Moved::Edges { lower, upper, directions: grips.hold.directions(), by };
        Ok(Self { supports, moved, load, protected })
    }

    /// Prescribed displacements with a rate: of the mean strain (1/s), of each edge (m/s), or of the displacement of a region
    /// over that at the end (1/s).
    pub(super) fn loading(&self, nodes: &Nodes<2>, rate: f64) -> Result<Loading<2>, Error> {
        let mut loading = Loading::new(nodes.positions().len());
        for (held, directions) in &self.supports {
            loading = loading.displace(held, *directions, [0.0; 2], Program::Constant(0.0))?;
        }
        match &self.moved {
            Moved::Edges { lower, upper, directions, by: Edges::Strain } => {
                let both = [lower.as_slice(), upper].concat();
                let gradient = [[0.0, 0.0], [0.0, 1.0]];
                loading.stretch(nodes, &both, *directions, gradient, Program::Linear { rate })
            }
            Moved::Edges { lower, upper, directions, by: Edges::Velocity } => loading
                .velocity(lower, *directions, [0.0, -rate])?
                .velocity(upper, *directions, [0.0, rate]),
            Moved::Region { nodes, until } => {
                let directions = until.map(|u| u.abs() > 0.0);
                loading.displace(nodes, directions, *until, Program::Linear { rate })
            }
        }
    }
}

fn chosen(nodes: &Nodes<2>, is: impl Fn(&[f64; 2]) -> bool) -> Vec<usize> {
    let places = nodes.positions().iter().enumerate();
    places.filter(|(_, x)| is(x)).map(|(node, _)| node).collect()
}

/// The nodes of a region; at least one.
fn in_region(nodes: &Nodes<2>, region: &RegionScene, path: &str) -> Result<Vec<usize>, Objection> {
    let found = chosen(nodes, |x| region.distance(x) <= 0.0);
    if !found.is_empty() {
        return Ok(found);
    }
    let distance = |x: &&[f64; 2]| region.distance(x);
    let nearest = nodes.positions().iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let [x, y] = nearest.copied().unwrap_or([f64::NAN; 2]);
    let help = format!(
        "the nearest one is at [{x}, {y}] m; nodes are in the middles of the lattice's cells"
    );
    Err(Objection::new(path, "no node lies in the region").with_help(help))
}

/// Nodes within a distance of the lower and of the upper edge.
fn within_edges(scene: &CrackScene, nodes: &Nodes<2>, distance: f64) -> [Vec<usize>; 2] {
    let height = scene.body.size[1];
    [chosen(nodes, |x| x[1] < distance), chosen(nodes, |x| x[1] > height - distance)]
}

/// Rate of the loading, and what it comes to at the end.
pub(super) fn rate(
    scene: &CrackScene,
    stretch: f64,
    duration: f64,
) -> Result<(f64, LoadEnd), Objection> {
    match scene.loading {
        LoadingScene::Stretch { strain } => {
            let (key, value) = match strain {
                StrainScene::Value(value) => ("value", value),
                StrainScene::OverCriticalStretch(ratio) => {
                    ("over_critical_stretch", ratio * stretch)
                }
            };
            let path = format!("loading.stretch.strain.{key}");
            positive(&path, "the mean strain", value)?;
            Ok((value / duration, LoadEnd::Strain(value)))
        }
        LoadingScene::Velocity { speed } => {
            positive("loading.velocity.speed", "the speed of the edges", speed)?;
            Ok((speed, LoadEnd::Strain(2.0 * speed * duration / scene.body.size[1])))
        }
        LoadingScene::Displacement { until, .. } => {
            let along = until[0].abs().max(until[1].abs());
            Ok((1.0 / duration, LoadEnd::Displacement(along)))
        }
    }
}
