//! What one realisation came to.

use crate::error::{Error, finite};
use crate::path::CrackPath;

/// How a realisation ended.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum CrackOutcome {
    /// The crack came to where it was to leave the body.
    Through,
    /// It stopped before.
    Arrested,
    /// None grew.
    NoCrack,
    /// The body broke where it was held.
    GripsBroken,
    /// The body fell apart otherwise.
    Disconnected,
    /// The run ended with an error, in its words.
    Failed(String),
}

impl CrackOutcome {
    /// Whether its crack counts in the statistics; those of bodies that broke elsewhere and of runs that failed do not.
    #[must_use]
    pub fn counts(&self) -> bool {
        matches!(self, Self::Through | Self::Arrested | Self::NoCrack)
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Through => "through",
            Self::Arrested => "arrested",
            Self::NoCrack => "no crack",
            Self::GripsBroken => "grips broken",
            Self::Disconnected => "disconnected",
            Self::Failed(_) => "failed",
        }
    }

    pub(super) const NAMES: [&'static str; 6] =
        ["through", "arrested", "no crack", "grips broken", "disconnected", "failed"];
}

/// Result of one realisation, as data to be stored and merged.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CrackRecord {
    /// Its number.
    pub realisation: u64,
    /// How it ended.
    pub outcome: CrackOutcome,
    /// The crack from the notch to its tip (length); empty where there is none.
    pub path: Vec<[f64; 2]>,
    /// The length of the crack (length); 0 where there is none.
    pub length: f64,
    /// Where the crack left the body, by a coordinate along its border (length), if it did.
    pub exit: Option<f64>,
    /// The largest load that the body bore (force), if it was observed.
    pub failure_load: Option<f64>,
}

impl CrackRecord {
    /// The record of a crack, or of none. Its exit is the height where it crosses the abscissa `border`, if that is asked for;
    /// the outcome is then [`CrackOutcome::Through`] where it does.
    #[must_use]
    pub fn of_path(
        realisation: u64,
        path: Option<&CrackPath>,
        border: Option<f64>,
        failure_load: Option<f64>,
    ) -> Self {
        let exit = path.zip(border).and_then(|(path, border)| path.height_at(border));
        let outcome = match (path, exit) {
            (None, _) => CrackOutcome::NoCrack,
            (Some(_), Some(_)) => CrackOutcome::Through,
            (Some(_), None) => CrackOutcome::Arrested,
        };
        let length = path.map_or(0.0, CrackPath::length);
        let path = path.map_or_else(Vec::new, |path| path.points().to_vec());
        Self { realisation, outcome, path, length, exit, failure_load }
    }

    /// The record of a realisation whose crack, if there is one, does not count.
    #[must_use]
    pub fn without_crack(realisation: u64, outcome: CrackOutcome) -> Self {
        let (path, length) = (vec![], 0.0);
        Self { realisation, outcome, path, length, exit: None, failure_load: None }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        for &value in self.path.iter().flatten() {
            finite("a coordinate of a path", value)?;
        }
        finite("length of a crack", self.length)?;
        if let Some(value) = self.exit {
            finite("exit of a crack", value)?;
        }
        if let Some(value) = self.failure_load {
            finite("failure load", value)?;
        }
        Ok(())
    }
}

#[cfg(all(test, feature = "serde"))]
mod tests {
    use super::*;

    #[test]
    fn records_are_written_and_read_with_all_their_bits() {
        let path = CrackPath::from_points(vec![[0.1, 1.0 / 3.0], [0.7, 0.2]]).unwrap();
        let crack = CrackRecord::of_path(u64::MAX, Some(&path), Some(0.5), Some(1e-300));
        let failed = CrackRecord::without_crack(4, CrackOutcome::Failed("step 3: \"NaN\"".into()));
        for record in [crack, failed] {
            let text = serde_json::to_string(&record).unwrap();
            assert_eq!(serde_json::from_str::<CrackRecord>(&text).unwrap(), record);
        }
    }
}
