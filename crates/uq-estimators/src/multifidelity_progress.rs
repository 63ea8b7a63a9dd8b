//! Blocks of runs of a multifidelity estimate: what is planned, what is known.

use std::ops::Range;

use crate::error::{Error, require_finite};

/// Samples of the estimate are numbered below this; those of the pilot from it on.
pub(crate) const PILOT_START: u64 = 1 << 40;

/// Runs of one model on consecutive samples; those of the pilot have numbers from `2^40` on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ModelRange {
    /// The model.
    pub model: usize,
    /// The first sample.
    pub start: u64,
    /// One more than the last.
    pub end: u64,
}

impl std::fmt::Display for ModelRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "model {} from sample {} to {}", self.model, self.start, self.end)
    }
}

/// Responses of one block.
///
/// With the feature `serde` it can be written and read, in a format that keeps all bits of a number (`float_roundtrip` in
/// serde_json).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct ModelBlock {
    pub(crate) study: String,
    pub(crate) range: ModelRange,
    pub(crate) values: Vec<f64>,
}

impl ModelBlock {
    /// Its runs.
    #[must_use]
    pub const fn range(&self) -> ModelRange {
        self.range
    }
}

/// State of a multifidelity estimate: the blocks that are planned and those that have been computed.
///
/// The plan depends on the blocks alone, never on the order of their arrival.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MultifidelityProgress {
    /// The fields of the study, which its blocks must share: the first is its name, the second the length of a block.
    fields: Vec<(String, String)>,
    block_length: u64,
    /// Standard error for which the last round was planned; none before the pilot is known.
    pub(crate) target: Option<f64>,
    /// In order.
    planned: Vec<ModelRange>,
    /// In the order of their ranges.
    blocks: Vec<ModelBlock>,
}

impl MultifidelityProgress {
    pub(crate) fn new(fields: [(&str, String); 5], block_length: u64) -> Self {
        let fields = fields.into_iter().map(|(field, value)| (field.to_owned(), value)).collect();
        Self { fields, block_length, target: None, planned: Vec::new(), blocks: Vec::new() }
    }

    /// Blocks that are planned and not yet known, in order.
    #[must_use]
    pub fn missing(&self) -> Vec<ModelRange> {
        self.planned.iter().copied().filter(|range| self.place(range).is_err()).collect()
    }

    /// Adds a block, in any order.
    ///
    /// # Errors
    /// [`Error::ForeignBlock`] for one of another study or with another number of responses, [`Error::UnwantedBlock`] for one
    /// that is not missing, [`Error::NotFinite`] for a response.
    pub fn insert(&mut self, block: ModelBlock) -> Result<(), Error> {
        let name = self.fields.first().map_or("", |(_, name)| name);
        if block.study != name {
            let (value, expected) = (block.study, name.to_owned());
            return Err(Error::ForeignBlock { field: "name", value, expected });
        }
        let is_planned = self.planned.binary_search(&block.range).is_ok();
        let unwanted =
            Error::UnwantedBlock { pair: block.range.to_string(), block: block.range.start };
        let place = match self.place(&block.range) {
            Err(place) if is_planned => place,
            _ => return Err(unwanted),
        };
        let expected = block.range.end - block.range.start;
        if block.values.len() as u64 != expected {
            let (value, expected) = (block.values.len().to_string(), expected.to_string());
            return Err(Error::ForeignBlock { field: "number of responses", value, expected });
        }
        for (index, &value) in block.values.iter().enumerate() {
            require_finite("response", index, value)?;
        }
        self.blocks.insert(place, block);
        Ok(())
    }

    fn place(&self, range: &ModelRange) -> Result<usize, usize> {
        self.blocks.binary_search_by_key(range, |block| block.range)
    }

    pub(crate) fn require_complete(&self) -> Result<(), Error> {
        let missing = self.missing();
        missing.first().map_or(Ok(()), |first| {
            let (pair, block) = (first.to_string(), first.start);
            Err(Error::MissingBlocks { missing: missing.len(), pair, block })
        })
    }

    /// Whether the state is of a study with these fields.
    pub(crate) fn require_fields(&self, fields: &[(&'static str, String)]) -> Result<(), Error> {
        for ((_, value), (field, expected)) in self.fields.iter().zip(fields) {
            if value != expected {
                let (value, expected) = (value.clone(), expected.clone());
                return Err(Error::ForeignBlock { field, value, expected });
            }
        }
        Ok(())
    }

    pub(crate) fn has_plan(&self) -> bool {
        !self.planned.is_empty()
    }

    /// Plans the runs of a model on these samples, in blocks.
    pub(crate) fn plan(&mut self, model: usize, samples: Range<u64>) {
        let mut start = samples.start;
        while start < samples.end {
            let end = samples.end.min(start.saturating_add(self.block_length));
            let range = ModelRange { model, start, end };
            let place = self.planned.partition_point(|planned| *planned < range);
            self.planned.insert(place, range);
            start = end;
        }
    }

    /// Runs planned for a model, without the pilot.
    pub(crate) fn n_runs(&self, model: usize) -> u64 {
        let of_model = |range: &&ModelRange| range.model == model && range.start < PILOT_START;
        self.planned.iter().filter(of_model).map(|range| range.end).max().unwrap_or(0)
    }

    /// Responses of a model in the pilot.
    pub(crate) fn pilot(&self, model: usize) -> Vec<f64> {
        self.values(|range| range.model == model && range.start >= PILOT_START)
    }

    /// Responses of a model to the samples of the estimate.
    pub(crate) fn responses(&self, model: usize) -> Vec<f64> {
        self.values(|range| range.model == model && range.start < PILOT_START)
    }

    fn values(&self, is_wanted: impl Fn(&ModelRange) -> bool) -> Vec<f64> {
        let blocks = self.blocks.iter().filter(|block| is_wanted(&block.range));
        blocks.flat_map(|block| block.values.iter().copied()).collect()
    }
}
