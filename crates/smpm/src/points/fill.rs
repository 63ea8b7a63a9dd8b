//! Where the particles of a body start.

use constitutive_models::{finite, positive};

use crate::error::Error;

/// Where the particles of a body start.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill<const D: usize> {
    /// Their places (length).
    pub positions: Vec<[f64; D]>,
    /// The distance between them along each axis (length); each represents a box of that size.
    pub spacing: [f64; D],
}

impl<const D: usize> Fill<D> {
    /// Most places of a lattice: particles have numbers of 32 bits.
    pub const MOST_PLACES: u32 = u32::MAX;

    /// Places at the centres of the boxes of a lattice from `low` to `high` that lie inside a shape.
    ///
    /// ```
    /// use smpm::Fill;
    ///
    /// let disk = Fill::of([0.5, 0.5], ([-1.0, -1.0], [1.0, 1.0]), |[x, y]| x * x + y * y < 1.0)?;
    /// assert_eq!(disk.positions.len(), 12); // of 16, the four corners lie outside
    /// # Ok::<(), smpm::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for a spacing, [`Error::Parameter`] for a corner; [`Error::TooManyPlaces`] for a lattice of more than
    /// [`Fill::MOST_PLACES`], inside or not.
    pub fn of(
        spacing: [f64; D],
        (low, high): ([f64; D], [f64; D]),
        inside: impl Fn(&[f64; D]) -> bool,
    ) -> Result<Self, Error> {
        for k in 0..D {
            positive("spacing of particles", spacing[k])?;
            finite("corner of a body", low[k])?;
            finite("corner of a body", high[k])?;
        }
        let along: [f64; D] =
            std::array::from_fn(|k| ((high[k] - low[k]) / spacing[k]).round().max(0.0));
        let (value, limit) = (along.iter().product::<f64>(), Self::MOST_PLACES);
        // A product that is no number has a factor beyond all limits.
        if value.is_nan() || value > f64::from(limit) || along.iter().any(|&n| n > f64::from(limit))
        {
            return Err(Error::TooManyPlaces { value, limit });
        }
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of boxes, within its limit"
        )]
        let count = along.map(|n| n as usize);
        let total: usize = count.iter().product();
        let positions = (0..total)
            .map(|index| {
                let mut rest = index;
                std::array::from_fn(|k| {
                    let along = rest % count[k];
                    rest /= count[k];
                    low[k] + (along as f64 + 0.5) * spacing[k]
                })
            })
            .filter(|place| inside(place))
            .collect();
        Ok(Self { positions, spacing })
    }

    /// The places in three dimensions, refused where they, or the spacing, cannot be.
    pub(crate) fn checked(&self) -> Result<Vec<[f64; 3]>, Error> {
        for &spacing in &self.spacing {
            positive("spacing of particles", spacing)?;
        }
        if self.positions.is_empty() {
            return Err(Error::EmptyBody { spacing: self.spacing[0] });
        }
        let in_space = |place: &[f64; D]| {
            place.iter().try_for_each(|&value| finite("position of a particle", value))?;
            Ok(std::array::from_fn(|k| if k < D { place[k] } else { 0.0 }))
        };
        self.positions.iter().map(in_space).collect()
    }
}
