//! What can go wrong with columns, snapshots, files and lattices.

use crate::kind::Kind;
use crate::rule::Rule;

/// Why a store, a snapshot, a file or a lattice could not do what was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No column has this name.
    #[error("there is no column named {name:?}")]
    UnknownColumn {
        /// The name.
        name: String,
    },
    /// A handle points beyond the columns of this store: it comes from another.
    #[error("a handle to column {index} is used on a store of {n_columns} columns")]
    UnknownHandle {
        /// The column the handle points to.
        index: usize,
        /// Number of columns of the store.
        n_columns: usize,
    },
    /// A column holds another kind of values.
    #[error("column {name:?} holds {found:?} values, not {expected:?}")]
    KindMismatch {
        /// Name of the column.
        name: String,
        /// What was asked for.
        expected: Kind,
        /// What it holds.
        found: Kind,
    },
    /// A column of this name exists.
    #[error("there is a column named {name:?} already")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// One column was asked for twice, both times to be written.
    #[error("column {name:?} cannot be written through two handles at once")]
    SameColumn {
        /// Name of the column.
        name: String,
    },
    /// A column, a permutation or a mask does not have one entry for each particle.
    #[error("{what} has {length} entries for {n_particles} particles")]
    LengthMismatch {
        /// Name of the column, or `permutation`, or `mask`.
        what: String,
        /// Its number of entries.
        length: usize,
        /// Number of particles.
        n_particles: usize,
    },
    /// An order names a particle twice, or one that is not there.
    #[error(
        "entry {position} of the order is {value}: out of range of {n_particles} or named before"
    )]
    NotAPermutation {
        /// Where in the order.
        position: usize,
        /// The entry.
        value: u32,
        /// Number of particles.
        n_particles: usize,
    },
    /// What was made from places, a neighbour list say, is older than the present order of the particles.
    #[error(
        "made for generation {made_for} of the particles, which are in generation {generation}"
    )]
    StaleGeneration {
        /// The generation it was made for.
        made_for: u64,
        /// The generation of the store.
        generation: u64,
    },
    /// A place is beyond the particles.
    #[error("there is no place {place} among {n_particles} particles")]
    NoSuchPlace {
        /// The place.
        place: usize,
        /// Number of particles.
        n_particles: usize,
    },
    /// A particle is to be merged twice.
    #[error("place {place} is named twice in the groups to be merged")]
    NamedTwice {
        /// The place.
        place: usize,
    },
    /// One particle cannot be merged, nor can none.
    #[error("group {group} has {length} particles; a merge needs at least two")]
    GroupTooSmall {
        /// Which group.
        group: usize,
        /// Its number of particles.
        length: usize,
    },
    /// The mass of a group, by which means are taken, is not a positive number.
    #[error("group {group} has the mass {mass}, not positive and finite")]
    InvalidMass {
        /// Which group.
        group: usize,
        /// Its mass.
        mass: f64,
    },
    /// The shares of a split are not positive or do not add up to one.
    #[error("the shares of a split are positive and add up to one; here the sum is {sum}")]
    InvalidShares {
        /// Their sum.
        sum: f64,
    },
    /// A column has no rule for splitting and merging.
    #[error("column {name:?} has no rule for splitting and merging")]
    NoRule {
        /// Name of the column.
        name: String,
    },
    /// A rule cannot be followed: the column holds no real numbers, or is the mass or position, whose rules are fixed.
    #[error("column {name:?} cannot follow the rule {rule:?}")]
    RuleMismatch {
        /// Name of the column.
        name: String,
        /// The rule.
        rule: Rule,
    },
    /// The bytes do not begin as a snapshot does.
    #[error("not a snapshot: it begins with {found:02x?}")]
    NotASnapshot {
        /// The first eight bytes.
        found: [u8; 8],
    },
    /// The snapshot is of a format this version does not read.
    #[error("snapshot format {found} is not the supported {supported}")]
    UnsupportedVersion {
        /// Format of the snapshot.
        found: u32,
        /// The format this version reads and writes.
        supported: u32,
    },
    /// The snapshot holds particles of another dimension.
    #[error("a snapshot of {found} dimensions is restored in {expected}")]
    DimensionMismatch {
        /// Dimension of the snapshot.
        found: u32,
        /// Dimension of the store.
        expected: usize,
    },
    /// The bytes end before the snapshot does.
    #[error("the snapshot ends too early")]
    Truncated,
    /// The snapshot contradicts itself.
    #[error("corrupt snapshot: {what}")]
    Corrupt {
        /// What is wrong.
        what: &'static str,
    },
    /// The content is not what was written.
    #[error("corrupt snapshot: content hash {computed:016x}, {stored:016x} was written")]
    HashMismatch {
        /// Hash in the snapshot.
        stored: u64,
        /// Hash of what was read.
        computed: u64,
    },
    /// A `.vtu` file holds points of at most three dimensions.
    #[error(
        "particles in {dimension} dimensions are no points of a vtu file, which have three at most"
    )]
    TooManyDimensions {
        /// Dimension of the store.
        dimension: usize,
    },
    /// A position or a time to be drawn, a point to be ordered or an offset is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which one.
        what: String,
    },
    /// A name holds a character that an XML file cannot.
    #[error("name {name:?} holds a control character and cannot be written as XML")]
    NameNotXml {
        /// The name.
        name: String,
    },
    /// The reader or writer failed.
    #[error("reading or writing failed")]
    Io(#[from] std::io::Error),
    /// A width, radius or spacing is not a positive number.
    #[error("{what} along axis {axis} is {value}, not positive and finite")]
    InvalidLength {
        /// `half width`, `radius` or `spacing`.
        what: &'static str,
        /// The axis; 0 where all axes share the value.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// A lattice has no points along an axis.
    #[error("a lattice needs at least one point along axis {axis}")]
    ZeroCount {
        /// The axis.
        axis: usize,
    },
    /// There are more points than a 32-bit index counts, or more along an axis of a lattice than a signed one.
    #[error("more than {} points cannot be indexed", u32::MAX)]
    TooManyPoints,
}
