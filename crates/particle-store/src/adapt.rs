//! Particles appended, split and merged, for adaptive methods.

use core::ops::Range;

use crate::column::{Element, Handle, Values, of_any_kind};
use crate::error::Error;
use crate::kind::Kind;
use crate::rule::Rule;
use crate::store::{Column, ParticleStore};
use crate::tensor::SymmetricTensor;

/// Tolerance of the sum of shares: rounding of a few hundred of them.
const SHARES_ROUNDING: f64 = 1e-12;

/// The columns required for splitting and merging, and the rules of the others.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a, const D: usize> {
    /// Masses: the weights. Their rule is [`Rule::Sum`].
    pub mass: Handle<f64>,
    /// Positions. Their rule is [`Rule::Mean`]; children are displaced by their offsets.
    pub position: Handle<[f64; D]>,
    /// One rule for each other column, by name; of duplicates the first counts.
    pub others: &'a [(&'a str, Rule)],
}

/// One of the particles that result from a split.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Child<const D: usize> {
    /// Displacement from the parent. If the offsets times shares sum to zero, the centre of mass is conserved.
    pub offset: [f64; D],
    /// Fraction of the parent's mass.
    pub share: f64,
}

impl<const D: usize> ParticleStore<D> {
    /// Appends the particles of another store with the same columns, in any order, and returns their ids.
    ///
    /// They are new particles: their ids in the other store are ignored, and so are its attributes. The generation
    /// changes if there are any.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownColumn`] for a column that only one store has; [`Error::KindMismatch`]. The store is then
    /// unchanged.
    pub fn append(&mut self, other: &Self) -> Result<Range<u64>, Error> {
        for Column { name, .. } in &other.columns {
            self.column(name)?;
        }
        for Column { name, values } in &self.columns {
            let (expected, found) = (values.kind(), other.column(name)?.values.kind());
            if found != expected {
                return Err(Error::KindMismatch { name: name.clone(), expected, found });
            }
        }
        for Column { name, values } in &mut self.columns {
            let more = &other.column(name)?.values;
            of_any_kind!(values, values => extend(values, more));
        }
        let ids = self.new_ids(other.len());
        self.ids.extend(ids.clone());
        if !ids.is_empty() {
            self.generation = self.generation.wrapping_add(1);
        }
        Ok(ids)
    }

    /// Splits the particle at an index into children and returns their new ids; the parent is removed.
    ///
    /// The first child takes the parent's index, the others are appended; no other particle moves. The generation
    /// changes.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchPlace`]; [`Error::InvalidShares`] unless the shares are positive and sum to one within 1e-12;
    /// [`Error::NotFinite`] for an offset; for the rules [`Error::NoRule`], [`Error::RuleMismatch`] and
    /// [`Error::UnknownColumn`]; for the handles those of [`get`](Self::get). The store is then unchanged.
    pub fn split(
        &mut self,
        place: usize,
        children: &[Child<D>],
        rules: &Rules<'_, D>,
    ) -> Result<Range<u64>, Error> {
        let rule_of = self.rule_of_each_column(rules)?;
        self.check_place(place)?;
        let sum: f64 = children.iter().map(|child| child.share).sum();
        let all_positive = children.iter().all(|child| child.share > 0.0);
        if !(all_positive && (sum - 1.0).abs() <= SHARES_ROUNDING) {
            return Err(Error::InvalidShares { sum });
        }
        let is_finite = |child: &Child<D>| child.offset.iter().all(|value| value.is_finite());
        if let Some(wrong) = children.iter().position(|child| !is_finite(child)) {
            return Err(Error::NotFinite { what: format!("offset of child {wrong}") });
        }

        let n_before = self.len();
        for (column, rule) in self.columns.iter_mut().zip(rule_of) {
            match &mut column.values {
                Values::Scalar(values) => split(values, place, children, rule),
                Values::Point(values) => split(values, place, children, rule),
                Values::Tensor(values) => split(values, place, children, rule),
                Values::Integer(values) => copy(values, place, children.len()),
                Values::Index(values) => copy(values, place, children.len()),
                Values::Flag(values) => copy(values, place, children.len()),
                Values::Label(values) => copy(values, place, children.len()),
            }
        }
        let places = core::iter::once(place).chain(n_before..);
        let positions = self.get_mut(rules.position)?;
        for (place, child) in places.zip(children) {
            positions[place] = positions[place].plus(child.offset);
        }
        let ids = self.new_ids(children.len());
        self.ids[place] = ids.start;
        self.ids.extend(ids.start + 1..ids.end);
        self.generation = self.generation.wrapping_add(1);
        Ok(ids)
    }

    /// Merges each group of indices into one particle and returns their new ids, one for each group.
    ///
    /// The new particle takes the index of the first of its group; then the gaps of the others close as in
    /// [`retain`](Self::retain). The generation changes if there is a group.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchPlace`]; [`Error::NamedTwice`] for an index in two groups or twice in one;
    /// [`Error::GroupTooSmall`] below two particles; [`Error::InvalidMass`] unless the mass of every group is positive
    /// and finite; for the rules and the handles those of [`split`](Self::split). The store is then unchanged.
    pub fn merge<G: AsRef<[usize]>>(
        &mut self,
        groups: &[G],
        rules: &Rules<'_, D>,
    ) -> Result<Range<u64>, Error> {
        let rule_of = self.rule_of_each_column(rules)?;
        let keep = self.check_groups(groups, rules)?;
        let ids = self.new_ids(groups.len());
        let mut weights = Vec::new();
        for (group, id) in groups.iter().zip(ids.clone()) {
            let group = group.as_ref();
            let masses = self.get(rules.mass)?;
            weights.clear();
            weights.extend(group.iter().map(|&place| masses[place]));
            for (column, &rule) in self.columns.iter_mut().zip(&rule_of) {
                match &mut column.values {
                    Values::Scalar(values) => merge(values, group, &weights, rule),
                    Values::Point(values) => merge(values, group, &weights, rule),
                    Values::Tensor(values) => merge(values, group, &weights, rule),
                    // The first value is kept.
                    Values::Integer(_) | Values::Index(_) | Values::Flag(_) | Values::Label(_) => {}
                }
            }
            self.ids[group[0]] = id;
        }
        self.retain(&keep)?;
        Ok(ids)
    }

    /// Mask of the particles that remain.
    fn check_groups<G: AsRef<[usize]>>(
        &self,
        groups: &[G],
        rules: &Rules<'_, D>,
    ) -> Result<Vec<bool>, Error> {
        let masses = self.get(rules.mass)?;
        let (mut named, mut keep) = (vec![false; self.len()], vec![true; self.len()]);
        for (index, group) in groups.iter().enumerate() {
            let group = group.as_ref();
            if group.len() < 2 {
                return Err(Error::GroupTooSmall { group: index, length: group.len() });
            }
            for (k, &place) in group.iter().enumerate() {
                self.check_place(place)?;
                if named[place] {
                    return Err(Error::NamedTwice { place });
                }
                named[place] = true;
                keep[place] = k == 0;
            }
            let mass: f64 = group.iter().map(|&place| masses[place]).sum();
            if !(mass > 0.0 && mass.is_finite()) {
                return Err(Error::InvalidMass { group: index, mass });
            }
        }
        Ok(keep)
    }

    fn rule_of_each_column(&self, rules: &Rules<'_, D>) -> Result<Vec<Rule>, Error> {
        self.get(rules.mass)?;
        self.get(rules.position)?;
        for (name, _) in rules.others {
            self.column(name)?;
        }
        let mut rule_of = Vec::with_capacity(self.columns.len());
        for (index, Column { name, values }) in self.columns.iter().enumerate() {
            let stated =
                rules.others.iter().find(|(other, _)| other == name).map(|(_, rule)| *rule);
            let fixed = match index {
                _ if index == rules.mass.index => Some(Rule::Sum),
                _ if index == rules.position.index => Some(Rule::Mean),
                _ => None,
            };
            let is_real = matches!(values.kind(), Kind::Scalar | Kind::Point | Kind::Tensor);
            rule_of.push(match (fixed, stated) {
                (Some(rule), None) => rule,
                (None, Some(rule)) if is_real || rule == Rule::First => rule,
                (None, None) => return Err(Error::NoRule { name: name.clone() }),
                (_, Some(rule)) => return Err(Error::RuleMismatch { name: name.clone(), rule }),
            });
        }
        Ok(rule_of)
    }

    fn check_place(&self, place: usize) -> Result<(), Error> {
        let n_particles = self.len();
        if place < n_particles { Ok(()) } else { Err(Error::NoSuchPlace { place, n_particles }) }
    }

    fn new_ids(&mut self, count: usize) -> Range<u64> {
        let first = self.next_id;
        self.next_id += count as u64;
        first..self.next_id
    }
}

/// Real numbers, which can be split and averaged.
trait Real: Copy {
    fn times(self, factor: f64) -> Self;
    fn plus(self, other: Self) -> Self;
}

impl Real for f64 {
    fn times(self, factor: f64) -> Self {
        self * factor
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
}

impl<const N: usize> Real for [f64; N] {
    fn times(self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }
    fn plus(self, other: Self) -> Self {
        core::array::from_fn(|k| self[k] + other[k])
    }
}

impl Real for SymmetricTensor {
    fn times(self, factor: f64) -> Self {
        Self(self.0.times(factor))
    }
    fn plus(self, other: Self) -> Self {
        Self(self.0.plus(other.0))
    }
}

fn split<T: Real, const D: usize>(
    values: &mut Vec<T>,
    place: usize,
    children: &[Child<D>],
    rule: Rule,
) {
    let n_before = values.len();
    copy(values, place, children.len());
    if rule == Rule::Sum {
        for (place, child) in core::iter::once(place).chain(n_before..).zip(children) {
            values[place] = values[place].times(child.share);
        }
    }
}

/// Appends values up to `count` copies.
fn copy<T: Copy>(values: &mut Vec<T>, place: usize, count: usize) {
    let parent = values[place];
    values.extend(core::iter::repeat_n(parent, count - 1));
}

fn merge<T: Real>(values: &mut [T], group: &[usize], weights: &[f64], rule: Rule) {
    let total = |terms: &mut dyn Iterator<Item = T>| terms.reduce(T::plus);
    let merged = match rule {
        Rule::First => None,
        Rule::Sum => total(&mut group.iter().map(|&place| values[place])),
        Rule::Mean => {
            let mass: f64 = weights.iter().sum();
            let shares = weights.iter().map(|weight| weight / mass);
            total(&mut group.iter().zip(shares).map(|(&place, share)| values[place].times(share)))
        }
    };
    if let Some(merged) = merged {
        values[group[0]] = merged;
    }
}

fn extend<T: Element<D>, const D: usize>(values: &mut Vec<T>, more: &Values<D>) {
    values.extend_from_slice(T::of(more).unwrap_or_default());
}
