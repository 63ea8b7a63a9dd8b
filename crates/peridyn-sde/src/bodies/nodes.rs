//! Where the body is: nodes with their volumes.

use crate::error::{Error, at_most, finite, positive, same_length};
use crate::material::elasticity::Condition;

/// Nodes of a body in `D` dimensions.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes<const D: usize> {
    positions: Vec<[f64; D]>,
    volumes: Vec<f64>,
    spacing: f64,
    condition: Condition,
}

impl<const D: usize> Nodes<D> {
    /// Nodes at the centres of the boxes of a lattice from `low` to `high` (lengths) that lie inside a shape. Each has the volume
    /// `spacing^D`, times the thickness or the cross-section of the condition.
    ///
    /// ```
    /// use peridyn_sde::{Condition, Nodes};
    ///
    /// let plate = Condition::PlaneStress { thickness: 0.5 };
    /// let disk = Nodes::lattice(0.5, ([-1.0; 2], [1.0; 2]), plate, |[x, y]| x * x + y * y < 1.0)?;
    /// assert_eq!(disk.positions().len(), 12); // of 16, the four corners lie outside
    /// assert_eq!(disk.volumes()[0], 0.125);
    /// # Ok::<(), peridyn_sde::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for the spacing or a corner, and those of [`Nodes::new`].
    pub fn lattice(
        spacing: f64,
        (low, high): ([f64; D], [f64; D]),
        condition: Condition,
        inside: impl Fn(&[f64; D]) -> bool,
    ) -> Result<Self, Error> {
        positive("spacing of the nodes", spacing)?;
        let mut count = [0_usize; D];
        for k in 0..D {
            finite("corner of the body", low[k])?;
            finite("corner of the body", high[k])?;
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a count of boxes, checked against the limit below"
            )]
            let along = ((high[k] - low[k]) / spacing).round().max(0.0) as usize;
            count[k] = along;
        }
        let total = count.iter().fold(1_usize, |product, &along| product.saturating_mul(along));
        at_most("nodes", total, MOST_NODES)?;
        let place = |index: usize| {
            let mut rest = index;
            std::array::from_fn(|k| {
                let along = rest % count[k];
                rest /= count[k];
                low[k] + (along as f64 + 0.5) * spacing
            })
        };
        let positions: Vec<[f64; D]> = (0..total).map(place).filter(|x| inside(x)).collect();
        let volume = (0..D).fold(condition.across(), |volume, _| volume * spacing);
        let volumes = vec![volume; positions.len()];
        Self::new(positions, volumes, spacing, condition)
    }

    /// Nodes at given places (lengths) with given volumes (lengths cubed); `spacing` is how far they are apart.
    ///
    /// # Errors
    /// [`Error::EmptyBody`], [`Error::TooMany`], [`Error::Length`], [`Error::Node`] for a place that is not finite or a
    /// volume that is not positive, [`Error::Dimension`] for a condition of another dimension.
    pub fn new(
        positions: Vec<[f64; D]>,
        volumes: Vec<f64>,
        spacing: f64,
        condition: Condition,
    ) -> Result<Self, Error> {
        positive("spacing of the nodes", spacing)?;
        positive("thickness or cross-section", condition.across())?;
        let expected = condition.dimension();
        if expected != D {
            return Err(Error::Dimension { condition: condition.name(), value: D, expected });
        }
        if positions.is_empty() {
            return Err(Error::EmptyBody { spacing });
        }
        at_most("nodes", positions.len(), MOST_NODES)?;
        same_length("volumes", volumes.len(), positions.len())?;
        for (node, (place, &volume)) in positions.iter().zip(&volumes).enumerate() {
            if let Some(&value) = place.iter().find(|x| !x.is_finite()) {
                return Err(Error::Node { name: "a coordinate", node, value, must: "finite" });
            }
            if !(volume > 0.0 && volume.is_finite()) {
                let must = "greater than 0 and finite";
                return Err(Error::Node { name: "the volume", node, value: volume, must });
            }
        }
        Ok(Self { positions, volumes, spacing, condition })
    }

    /// Places (length).
    #[must_use]
    pub fn positions(&self) -> &[[f64; D]] {
        &self.positions
    }

    /// Volumes (length cubed).
    #[must_use]
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// How far nodes are apart (length).
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The elastic condition of the body.
    #[must_use]
    pub fn condition(&self) -> Condition {
        self.condition
    }
}

/// An index of a node has 32 bits.
const MOST_NODES: usize = u32::MAX as usize;
