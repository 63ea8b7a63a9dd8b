//! Errors of columns, snapshots, files and lattices.

use crate::kind::Kind;
use crate::rule::Rule;

/// Error of a store, a snapshot, a file or a lattice.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No column has this name.
    #[error("there is no column named {name:?}")]
    UnknownColumn {
        /// The name.
        name: String,
    },
    /// A handle of another store is out of range.
    #[error("a handle to column {index} is used on a store of {n_columns} columns")]
    UnknownHandle {
        /// The column the handle points to.
        index: usize,
        /// Number of columns of the store.
        n_columns: usize,
    },
    /// A column has another kind of values.
    #[error("column {name:?} holds {found:?} values, not {expected:?}")]
    KindMismatch {
        /// Name of the column.
        name: String,
        /// Requested kind.
        expected: Kind,
        /// Kind of the column.
        found: Kind,
    },
    /// A column with this name exists already.
    #[error("there is a column named {name:?} already")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// One column was requested twice for writing.
    #[error("column {name:?} cannot be written through two handles at once")]
    SameColumn {
        /// Name of the column.
        name: String,
    },
    /// A column, a permutation or a mask has the wrong number of entries.
    #[error("{what} has {length} entries for {n_particles} particles")]
    LengthMismatch {
        /// Name of the column, or `permutation`, or `mask`.
        what: String,
        /// Its number of entries.
        length: usize,
        /// Number of particles.
        n_particles: usize,
    },
    /// An order contains a duplicate or an index out of range.
    #[error(
        "entry {position} of the order is {value}: out of range of {n_particles} or named before"
    )]
    NotAPermutation {
        /// Position in the order.
        position: usize,
        /// The entry.
        value: u32,
        /// Number of particles.
        n_particles: usize,
    },
    /// Data derived from indices, such as a neighbour list, are older than the current order of the particles.
    #[error(
        "made for generation {made_for} of the particles, which are in generation {generation}"
    )]
    StaleGeneration {
        /// The generation of the data.
        made_for: u64,
        /// The generation of the store.
        generation: u64,
    },
    /// An index is out of range.
    #[error("there is no place {place} among {n_particles} particles")]
    NoSuchPlace {
        /// The index.
        place: usize,
        /// Number of particles.
        n_particles: usize,
    },
    /// A particle occurs twice in the groups.
    #[error("place {place} is named twice in the groups to be merged")]
    NamedTwice {
        /// The index.
        place: usize,
    },
    /// A group has fewer than two particles.
    #[error("group {group} has {length} particles; a merge needs at least two")]
    GroupTooSmall {
        /// The group.
        group: usize,
        /// Its number of particles.
        length: usize,
    },
    /// The mass of a group, the weight of means, is not positive and finite.
    #[error("group {group} has the mass {mass}, not positive and finite")]
    InvalidMass {
        /// The group.
        group: usize,
        /// Its mass.
        mass: f64,
    },
    /// The shares of a split are not positive or do not sum to one.
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
    /// A rule does not apply: the column has no real numbers, or is the mass or position, whose rules are fixed.
    #[error("column {name:?} cannot follow the rule {rule:?}")]
    RuleMismatch {
        /// Name of the column.
        name: String,
        /// The rule.
        rule: Rule,
    },
    /// The bytes do not begin with the signature of a snapshot.
    #[error("not a snapshot: it begins with {found:02x?}")]
    NotASnapshot {
        /// The first eight bytes.
        found: [u8; 8],
    },
    /// The snapshot has an unsupported format.
    #[error("snapshot format {found} is not the supported {supported}")]
    UnsupportedVersion {
        /// Format of the snapshot.
        found: u32,
        /// The supported format.
        supported: u32,
    },
    /// The snapshot has another dimension.
    #[error("a snapshot of {found} dimensions is restored in {expected}")]
    DimensionMismatch {
        /// Dimension of the snapshot.
        found: u32,
        /// Dimension of the store.
        expected: usize,
    },
    /// The snapshot is truncated.
    #[error("the snapshot ends too early")]
    Truncated,
    /// The snapshot is inconsistent.
    #[error("corrupt snapshot: {what}")]
    Corrupt {
        /// Description of the inconsistency.
        what: &'static str,
    },
    /// The content does not match its hash.
    #[error("corrupt snapshot: content hash {computed:016x}, {stored:016x} was written")]
    HashMismatch {
        /// Hash in the snapshot.
        stored: u64,
        /// Hash of the bytes read.
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
    /// A position, a time, a point or an offset is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Name of the quantity.
        what: String,
    },
    /// A name contains a character that XML does not allow.
    #[error("name {name:?} holds a control character and cannot be written as XML")]
    NameNotXml {
        /// The name.
        name: String,
    },
    /// The reader or writer failed.
    #[error("reading or writing failed")]
    Io(#[from] std::io::Error),
    /// A width, radius or spacing is not positive and finite.
    #[error("{what} along axis {axis} is {value}, not positive and finite")]
    InvalidLength {
        /// `half width`, `radius` or `spacing`.
        what: &'static str,
        /// The axis; 0 for a value common to all axes.
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
    /// The number of points exceeds a 32-bit index, or that along an axis a signed one.
    #[error("more than {} points cannot be indexed", u32::MAX)]
    TooManyPoints,
}
