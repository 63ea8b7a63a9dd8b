//! The front of a crack in three dimensions.

use super::PathConfig;
use super::cluster::{Cluster, Tree};
use super::fractured::Fractured;
use crate::error::{Error, finite, positive};

/// A flat notch in three dimensions: the parallelogram of [`Bonds::across_plane`](crate::Bonds::across_plane) with one of its
/// edges as the front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneNotch {
    /// A corner at the mouth (length).
    pub corner: [f64; 3],
    /// From there to the front (length).
    pub growth: [f64; 3],
    /// Along the front (length).
    pub front: [f64; 3],
}

/// How far a crack has come in one slice across the front of its notch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontPoint {
    /// Where the slice lies along the front of the notch (length).
    pub along: f64,
    /// How far before that front the farthest node of the crack in this slice is (length); 0 where there is none.
    pub extent: f64,
}

/// The front of the crack that has grown from a flat notch: in slices about a spacing thick across the front, the largest
/// distance from it, in its plane and across it, of a node of the connected damage that comes within a horizon of the front.
///
/// The crack itself need not be flat; its distance from the plane and its branches are not returned.
///
/// # Errors
/// As [`crack_path`](super::crack_path), with [`Error::NotPositive`] for a notch without area.
pub fn crack_front(
    body: &Fractured<'_, 3>,
    notch: &PlaneNotch,
    config: &PathConfig,
) -> Result<Vec<FrontPoint>, Error> {
    body.check()?;
    config.check()?;
    let axes = Axes::new(notch)?;
    let cluster = Cluster::new(body, config.damage)?;
    let tree = Tree::new(&cluster, |x| axes.distance(x));
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of slices; one at least"
    )]
    let slices = (axes.length / body.nodes.spacing()).round().max(1.0) as usize;
    let thickness = axes.length / slices as f64;
    let point = |slice: usize| FrontPoint { along: (slice as f64 + 0.5) * thickness, extent: 0.0 };
    let mut front: Vec<FrontPoint> = (0..slices).map(point).collect();
    for (member, x) in cluster.positions.iter().enumerate() {
        let [ahead, along, _] = axes.coordinates(x);
        if !tree.reaches(member) || along < 0.0 {
            continue;
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and beyond the last slice there is none"
        )]
        let slice = (along / thickness) as usize;
        if let Some(point) = front.get_mut(slice) {
            point.extent = point.extent.max(ahead);
        }
    }
    Ok(front)
}

/// Ahead of the front, along it, and out of the plane.
struct Axes {
    origin: [f64; 3],
    directions: [[f64; 3]; 3],
    length: f64,
}

impl Axes {
    fn new(notch: &PlaneNotch) -> Result<Self, Error> {
        let PlaneNotch { corner, growth, front } = *notch;
        for value in corner.into_iter().chain(growth).chain(front) {
            finite("a corner of the notch", value)?;
        }
        let length = dot(&front, &front).sqrt();
        positive("length of the front", length)?;
        let along = front.map(|c| c / length);
        let forward = dot(&growth, &along);
        let across: [f64; 3] = std::array::from_fn(|k| growth[k] - forward * along[k]);
        let depth = dot(&across, &across).sqrt();
        positive("area of the notch", depth * length)?;
        let ahead = across.map(|c| c / depth);
        let out = [
            ahead[1] * along[2] - ahead[2] * along[1],
            ahead[2] * along[0] - ahead[0] * along[2],
            ahead[0] * along[1] - ahead[1] * along[0],
        ];
        let origin = std::array::from_fn(|k| corner[k] + growth[k]);
        Ok(Self { origin, directions: [ahead, along, out], length })
    }

    fn coordinates(&self, x: &[f64; 3]) -> [f64; 3] {
        let off: [f64; 3] = std::array::from_fn(|k| x[k] - self.origin[k]);
        self.directions.map(|axis| dot(&axis, &off))
    }

    /// To the front of the notch.
    fn distance(&self, x: &[f64; 3]) -> f64 {
        let [ahead, along, out] = self.coordinates(x);
        let beyond = (along - self.length).max(-along).max(0.0);
        (ahead * ahead + out * out + beyond * beyond).sqrt()
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}
