//! When an expansion has enough terms.

use crate::error::{Error, between};

/// Most terms of an expansion.
pub(crate) const MOST_TERMS: usize = 20_000;

/// How many terms of an expansion are kept. Terms are ordered by their share of the mean variance over the body.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Truncation {
    /// So many terms, from 1 to 20,000.
    Terms(usize),
    /// As many terms as hold this share of the mean variance, between 0 and 1. The pointwise share is lower near the ends of
    /// the body: [`RandomField::left_out_variance`](crate::RandomField::left_out_variance) states it.
    Share(f64),
}

impl Truncation {
    pub(crate) fn check(self) -> Result<(), Error> {
        match self {
            Self::Terms(0) => Err(Error::NotPositive { name: "number of terms", value: 0.0 }),
            Self::Terms(value) if value > MOST_TERMS => {
                let name = "number of terms";
                let to = MOST_TERMS as f64;
                Err(Error::OutOfRange { name, value: value as f64, from: 1.0, to })
            }
            Self::Terms(_) => Ok(()),
            Self::Share(share) => between("share of the variance", share, 0.0, 1.0),
        }
    }

    /// Whether so many terms with this share are enough.
    pub(crate) fn is_reached(self, n_terms: usize, share: f64) -> bool {
        match self {
            Self::Terms(asked) => n_terms >= asked,
            Self::Share(asked) => share >= asked,
        }
    }

    /// The share that is asked for, one where terms are counted.
    pub(crate) fn share(self) -> f64 {
        match self {
            Self::Terms(_) => 1.0,
            Self::Share(share) => share,
        }
    }
}
