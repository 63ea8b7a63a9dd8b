//! Where bodies are damaged, and how often.

use sde_integrators::{Estimate, Uncertainty};

use crate::error::{Error, at_least, at_most, between, same_length};

/// Damage is counted in units of this: sums of whole numbers do not depend on their order.
const UNIT: f64 = 1.0 / (1_u64 << 40) as f64;

/// The damage of each node over realisations: how often it reaches a threshold, and its mean.
///
/// Sums are integers in units of 2^-40, so that maps of shards merge bitwise identically in any order; a mean is off
/// by that at most. A map that is read is refused where its realisations cannot have its sums.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Read")
)]
pub struct DamageMap {
    threshold: f64,
    /// Ascending.
    realisations: Vec<u64>,
    /// For each node how often it reached the threshold, the sum of its damage, and the sum of the squares.
    sums: Vec<[u64; 3]>,
}

/// A map as it is read.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Read {
    threshold: f64,
    realisations: Vec<u64>,
    sums: Vec<[u64; 3]>,
}

#[cfg(feature = "serde")]
impl TryFrom<Read> for DamageMap {
    type Error = Error;

    fn try_from(read: Read) -> Result<Self, Error> {
        let Read { threshold, realisations, sums } = read;
        let empty = Self::new(sums.len(), threshold)?;
        Self::room(realisations.len())?;
        if let Some(pair) = realisations.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(Error::Doubled { realisation: pair[1] });
        }
        let map = Self { realisations, sums, ..empty };
        map.require_possible()?;
        Ok(map)
    }
}

impl DamageMap {
    /// The most realisations that a sum holds.
    pub const MOST_REALISATIONS: usize = 1 << 23;

    /// A map of no realisation as yet, for a body of so many nodes; `threshold` is between 0 and 1.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the threshold, [`Error::TooFew`] for no node.
    pub fn new(n_nodes: usize, threshold: f64) -> Result<Self, Error> {
        between("threshold of damage", threshold, 0.0, 1.0)?;
        at_least("nodes", n_nodes, 1)?;
        Ok(Self { threshold, realisations: vec![], sums: vec![[0; 3]; n_nodes] })
    }

    /// Takes in the damage of each node, from 0 to 1, in a realisation.
    ///
    /// # Errors
    /// [`Error::Length`] for another number of nodes, [`Error::Node`] for a damage that cannot be, [`Error::Doubled`] for a
    /// realisation that is in already, [`Error::TooMany`]; nothing is taken in then.
    pub fn push(&mut self, realisation: u64, damage: &[f64]) -> Result<(), Error> {
        same_length("damage", damage.len(), self.sums.len())?;
        let possible = |damage: &f64| (0.0..=1.0).contains(damage);
        if let Some(node) = damage.iter().position(|damage| !possible(damage)) {
            let value = damage[node];
            return Err(Error::Node { name: "the damage", node, value, must: "from 0 to 1" });
        }
        let Err(place) = self.realisations.binary_search(&realisation) else {
            return Err(Error::Doubled { realisation });
        };
        Self::room(self.realisations.len() + 1)?;
        self.realisations.insert(place, realisation);
        for (sums, &damage) in self.sums.iter_mut().zip(damage) {
            sums[0] += u64::from(damage >= self.threshold);
            sums[1] += units(damage);
            sums[2] += units(damage * damage);
        }
        Ok(())
    }

    /// Takes in the realisations of another map of the same body.
    ///
    /// # Errors
    /// As [`DamageMap::push`], with [`Error::Foreign`] for another threshold; nothing is taken in then.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        same_length("damage", other.sums.len(), self.sums.len())?;
        if other.threshold.to_bits() != self.threshold.to_bits() {
            let (value, expected) = (other.threshold, self.threshold);
            return Err(Error::Foreign { name: "threshold of damage", value, expected });
        }
        let doubled =
            other.realisations.iter().find(|id| self.realisations.binary_search(id).is_ok());
        if let Some(&realisation) = doubled {
            return Err(Error::Doubled { realisation });
        }
        Self::room(self.realisations.len() + other.realisations.len())?;
        self.realisations.extend(&other.realisations);
        self.realisations.sort_unstable();
        for (sums, more) in self.sums.iter_mut().zip(&other.sums) {
            for k in 0..3 {
                sums[k] += more[k];
            }
        }
        Ok(())
    }

    /// Refuses sums that its realisations cannot have, which overflow when they are added.
    #[cfg(feature = "serde")]
    fn require_possible(&self) -> Result<(), Error> {
        const NAMES: [&str; 3] =
            ["a count of damage", "a sum of damage", "a sum of squared damage"];
        let n = self.realisations.len() as u64;
        let most = [n, n * units(1.0), n * units(1.0)];
        for (k, name) in NAMES.into_iter().enumerate() {
            let unit = if k == 0 { 1.0 } else { UNIT };
            for sums in self.sums.iter().filter(|sums| sums[k] > most[k]) {
                between(name, sums[k] as f64 * unit, 0.0, most[k] as f64 * unit)?;
            }
        }
        Ok(())
    }

    /// The realisations that are in, ascending.
    #[must_use]
    pub fn realisations(&self) -> &[u64] {
        &self.realisations
    }

    /// For each node the probability that its damage reaches the threshold; the bound of three over the number of realisations
    /// where it always or never does.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no realisation.
    pub fn probability(&self) -> Result<Vec<Estimate>, Error> {
        let n = self.realisations.len();
        at_least("realisations", n, 1)?;
        let too_few = |_| Error::TooFew { name: "realisations", value: n, limit: 1 };
        let of = |sums: &[u64; 3]| Estimate::probability(sums[0], n as u64).map_err(too_few);
        self.sums.iter().map(of).collect()
    }

    /// The mean damage of each node, with its standard error.
    ///
    /// # Errors
    /// [`Error::TooFew`] for fewer than two realisations.
    pub fn mean(&self) -> Result<Vec<Estimate>, Error> {
        let count = self.realisations.len();
        at_least("realisations", count, 2)?;
        let n = count as f64;
        let of = |sums: &[u64; 3]| {
            let value = sums[1] as f64 * UNIT / n;
            let square = sums[2] as f64 * UNIT / n;
            // Below zero by roundoff alone.
            let variance = (square - value * value).max(0.0) / (n - 1.0);
            Estimate { value, uncertainty: Uncertainty::StandardError(variance.sqrt()) }
        };
        Ok(self.sums.iter().map(of).collect())
    }

    fn room(value: usize) -> Result<(), Error> {
        at_most("realisations", value, Self::MOST_REALISATIONS)
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 2^40")]
fn units(share: f64) -> u64 {
    (share / UNIT).round() as u64
}

#[cfg(test)]
mod tests {
    use sde_integrators::Accumulator;

    use super::*;

    fn damage(realisation: u64) -> Vec<f64> {
        let of = |node: u64| (0.5 + 0.5 * (1.3 * realisation as f64 + node as f64).sin()).powi(2);
        (0..4).map(of).chain([0.0]).collect()
    }

    fn map(realisations: impl IntoIterator<Item = u64>) -> DamageMap {
        let mut map = DamageMap::new(5, 0.4).unwrap();
        for realisation in realisations {
            map.push(realisation, &damage(realisation)).unwrap();
        }
        map
    }

    #[test]
    fn probabilities_and_means_are_those_of_the_realisations() {
        let map = map(0..50);
        let (probability, mean) = (map.probability().unwrap(), map.mean().unwrap());
        for node in 0..4 {
            let mut sample = Accumulator::default();
            (0..50).for_each(|realisation| sample.push(damage(realisation)[node]));
            let expected = sample.estimate().unwrap();
            assert!((mean[node].value - expected.value).abs() < 1e-12);
            let (one, two) = (mean[node].standard_error(), expected.standard_error());
            assert!((one.unwrap() - two.unwrap()).abs() < 1e-11);
            let hits = (0..50).filter(|&realisation| damage(realisation)[node] >= 0.4).count();
            assert_eq!(probability[node], Estimate::probability(hits as u64, 50).unwrap());
        }
        assert_eq!(probability[4].uncertainty, Uncertainty::Bound(0.06));
    }

    #[test]
    fn maps_merge_to_the_same_bits_in_any_order() {
        let whole = map(0..30);
        let (mut one, mut two) = (map(20..30), map((0..7).rev()));
        one.merge(&map(7..20)).unwrap();
        one.merge(&two).unwrap();
        assert_eq!(one, whole);
        two.merge(&map((7..30).rev())).unwrap();
        assert_eq!(two, whole);
        assert_eq!(one.merge(&map([3])), Err(Error::Doubled { realisation: 3 }));
        assert_eq!(one, whole);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let mut map = map(0..1);
        assert_eq!(map.push(0, &damage(0)), Err(Error::Doubled { realisation: 0 }));
        assert!(matches!(map.push(1, &[0.0; 4]), Err(Error::Length { .. })));
        let over = map.push(1, &[0.0, 0.0, 1.1, 0.0, 0.0]).unwrap_err();
        assert_eq!(over.to_string(), "the damage of node 2 is 1.1; it must be from 0 to 1");
        assert!(map.push(1, &[f64::NAN; 5]).is_err() && map.mean().is_err());
        let other = DamageMap::new(5, 0.5).unwrap();
        assert!(matches!(map.merge(&other), Err(Error::Foreign { .. })));
        assert!(DamageMap::new(5, 0.0).is_err() && other.probability().is_err());
    }

    #[cfg(feature = "serde")]
    #[test]
    fn a_map_that_cannot_be_is_not_read() {
        let text = serde_json::to_string(&map(0..3)).unwrap();
        assert_eq!(serde_json::from_str::<DamageMap>(&text).unwrap(), map(0..3));
        let read = |from: &str, to: &str| {
            assert!(text.contains(from), "{text}");
            serde_json::from_str::<DamageMap>(&text.replacen(from, to, 1)).unwrap_err().to_string()
        };
        assert_eq!(read("[0,1,2]", "[0,2,2]"), "realisation 2 is there twice");
        let many = read("[0,0,0]]", "[4,0,0]]");
        assert!(many.starts_with("a count of damage is 4; it must lie between 0 and 3"), "{many}");
        let large = read("[0,0,0]]", "[0,0,18446744073709551615]]");
        assert!(large.starts_with("a sum of squared damage is 16777216"), "{large}");
        assert!(read("0.4", "1.5").contains("threshold of damage"));
        let empty = r#"{"threshold":0.4,"realisations":[],"sums":[]}"#;
        assert!(serde_json::from_str::<DamageMap>(empty).is_err());
    }
}
