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
    #[error(
        "a handle to column {index} is used on a store with {n_columns} columns: look it up by name in this store"
    )]
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
    #[error("a column named {name:?} exists already")]
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
        "entry {position} of the order is {value}: a duplicate, or not below the number of particles {n_particles}"
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
        "derived from generation {made_for} of the particles, whose current generation is {generation}: recompute"
    )]
    StaleGeneration {
        /// The generation of the data.
        made_for: u64,
        /// The generation of the store.
        generation: u64,
    },
    /// An index is out of range.
    #[error("index {place} is out of range of {n_particles} particles")]
    NoSuchPlace {
        /// The index.
        place: usize,
        /// Number of particles.
        n_particles: usize,
    },
    /// A particle occurs twice in the groups.
    #[error("index {place} occurs twice in the groups to be merged")]
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
    #[error("the mass of group {group} is {mass}; it must be positive and finite")]
    InvalidMass {
        /// The group.
        group: usize,
        /// Its mass.
        mass: f64,
    },
    /// The shares of a split are not positive or do not sum to one.
    #[error("the shares of a split sum to {sum}; they must be positive and sum to one")]
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
    #[error("the rule {rule:?} does not apply to column {name:?}")]
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
    #[error("the snapshot has format {found}; supported is {supported}")]
    UnsupportedVersion {
        /// Format of the snapshot.
        found: u32,
        /// The supported format.
        supported: u32,
    },
    /// The snapshot has another dimension.
    #[error("the snapshot has {found} dimensions; the store has {expected}")]
    DimensionMismatch {
        /// Dimension of the snapshot.
        found: u32,
        /// Dimension of the store.
        expected: usize,
    },
    /// The snapshot is truncated.
    #[error("the snapshot is truncated")]
    Truncated,
    /// The snapshot is inconsistent.
    #[error("corrupt snapshot: {what}")]
    Corrupt {
        /// Description of the inconsistency.
        what: &'static str,
    },
    /// The content does not match its hash.
    #[error(
        "corrupt snapshot: its contents have the hash {computed:016x}, stored is {stored:016x}"
    )]
    HashMismatch {
        /// Hash in the snapshot.
        stored: u64,
        /// Hash of the bytes read.
        computed: u64,
    },
    /// A `.vtu` file holds points of at most three dimensions.
    #[error("particles have {dimension} dimensions; points of a vtu file have at most three")]
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
    #[error("name {name:?} contains a control character, which XML does not allow")]
    NameNotXml {
        /// The name.
        name: String,
    },
    /// The reader or writer failed.
    #[error("reading or writing failed")]
    Io(#[from] std::io::Error),
    /// A width, radius or spacing is not positive and finite.
    #[error("{what} along axis {axis} is {value}; it must be positive and finite")]
    InvalidLength {
        /// `half width`, `radius` or `spacing`.
        what: &'static str,
        /// The axis; 0 for a value common to all axes.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// A lattice has no points along an axis.
    #[error("the lattice has no point along axis {axis}; at least one is required")]
    ZeroCount {
        /// The axis.
        axis: usize,
    },
    /// The number of points exceeds a 32-bit index, or that along an axis a signed one.
    #[error("more than {} points cannot be indexed", u32::MAX)]
    TooManyPoints,
}
