//! How far a node sees.

use crate::error::{Error, positive};

/// By how much of a spacing a horizon reaches beyond a shell of nodes.
const BEYOND: f64 = 0.015;

/// A squared horizon nearer than this to a whole number, in squared spacings, ends on nodes.
const ON_NODES: f64 = 1e-6;

/// The horizon `delta`: nodes within it are bonded.
///
/// On a lattice of spacing `dx` it must not end at a distance between nodes, `delta^2/dx^2` a whole number: with
/// `delta = 3 dx` in floating point `<` keeps 0 to 51 % of the bonds of length `3 dx` and `<=` 56 to 100 %, not the same
/// to both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizon {
    radius: f64,
    spacing: f64,
}

impl Horizon {
    /// `(m + 0.015) dx`: with `shells = m` whole spacings, and a little more.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a spacing, [`Error::HorizonTooShort`] for no shell.
    pub fn of_shells(shells: u32, spacing: f64) -> Result<Self, Error> {
        Self::new((f64::from(shells) + BEYOND) * spacing, spacing)
    }

    /// A horizon over nodes at a spacing (both lengths).
    ///
    /// # Errors
    /// [`Error::Parameter`], [`Error::HorizonTooShort`], [`Error::HorizonOnNodes`].
    pub fn new(radius: f64, spacing: f64) -> Result<Self, Error> {
        positive("spacing of the nodes", spacing)?;
        positive("horizon", radius)?;
        let square = (radius / spacing).powi(2);
        if square < 1.0 - ON_NODES {
            return Err(Error::HorizonTooShort { value: radius, spacing });
        }
        let nearest = square.round();
        if (square - nearest).abs() < ON_NODES {
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number above zero"
            )]
            let whole = nearest as u64;
            let suggestion = (nearest.sqrt() + BEYOND) * spacing;
            return Err(Error::HorizonOnNodes {
                value: radius,
                square: whole,
                spacing,
                suggestion,
            });
        }
        Ok(Self { radius, spacing })
    }

    /// `delta` (length).
    #[must_use]
    pub fn radius(self) -> f64 {
        self.radius
    }

    /// `dx` (length).
    #[must_use]
    pub fn spacing(self) -> f64 {
        self.spacing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_horizon_that_ends_on_nodes_is_refused_with_one_that_does_not() {
        for spacing in [1.0, 0.1, 5e-4, 1.0 / 3.0] {
            for square in [1.0_f64, 2.0, 4.0, 5.0, 8.0, 9.0, 16.0] {
                let error = Horizon::new(square.sqrt() * spacing, spacing).unwrap_err();
                let Error::HorizonOnNodes { suggestion, .. } = error else {
                    unreachable!("{error}");
                };
                assert!(Horizon::new(suggestion, spacing).is_ok());
            }
            let horizon = Horizon::of_shells(3, spacing).unwrap();
            assert!((horizon.radius() / spacing - 3.015).abs() < 1e-12);
        }
        let short = Horizon::new(0.9, 1.0).unwrap_err();
        assert_eq!(
            short.to_string(),
            "the horizon is 0.9; it must be greater than the spacing 1 of the nodes"
        );
        assert!(matches!(Horizon::of_shells(0, 1.0), Err(Error::HorizonTooShort { .. })));
        assert!(matches!(Horizon::new(f64::NAN, 1.0), Err(Error::Parameter { .. })));
        assert!(matches!(Horizon::new(1.5, -1.0), Err(Error::Parameter { .. })));
    }
}
