//! What a contender found, and whether it is what the others found.

use kiddo::PairQueryResult;
use linkcell::PairColumns;
use neighbour_search::NeighbourList;

/// Rows of a list that a rival's queries make: row `i` is `indices[offsets[i]..offsets[i + 1]]`.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    offsets: Vec<usize>,
    pub(crate) indices: Vec<u32>,
}

impl Rows {
    pub(crate) fn restart(&mut self) {
        self.indices.clear();
        self.offsets.clear();
        self.offsets.push(0);
    }

    pub(crate) fn end_row(&mut self) {
        self.offsets.push(self.indices.len());
    }
}

/// Pairs in memory, in whatever order and form.
pub(crate) trait Pairs {
    fn for_each(&self, visit: impl FnMut(u32, u32));
}

impl Pairs for NeighbourList {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (row, i) in self.rows().zip(0..) {
            for &j in row {
                visit(i, j);
            }
        }
    }
}

impl Pairs for Rows {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (ends, i) in self.offsets.windows(2).zip(0..) {
            for &j in &self.indices[ends[0]..ends[1]] {
                visit(i, j);
            }
        }
    }
}

impl Pairs for Vec<[u32; 2]> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for &[i, j] in self {
            visit(i, j);
        }
    }
}

/// kiddo's join of a cloud with itself, in which each point finds itself as well.
impl Pairs for Vec<PairQueryResult<u32, u32, ()>> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for pair in self.iter().filter(|pair| pair.left_item != pair.right_item) {
            visit(pair.left_item, pair.right_item);
        }
    }
}

impl Pairs for Vec<linkcell::Pair> {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        let id = |index: usize| u32::try_from(index).unwrap();
        for pair in self {
            visit(id(pair.i), id(pair.j));
        }
    }
}

impl Pairs for PairColumns {
    fn for_each(&self, mut visit: impl FnMut(u32, u32)) {
        for (i, j) in self.i.iter().zip(&self.j) {
            visit(i.cast_unsigned(), j.cast_unsigned());
        }
    }
}

/// How a pair is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sense {
    /// A mutual pair is two: (i, j) and (j, i).
    Directed,
    /// Either order is the same pair.
    Unordered,
}

/// A set of pairs: their number, and a sum over them of 64 mixed bits, so that order does not matter. A set with one pair
/// more, less, twice or other has the same sum by chance only, once in 2^64.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    sense: Sense,
    pub(crate) n_pairs: usize,
    sum: u64,
}

impl Fingerprint {
    pub(crate) fn of(pairs: &impl Pairs, sense: Sense) -> Self {
        let (mut n_pairs, mut sum) = (0, 0_u64);
        pairs.for_each(|i, j| {
            let [first, second] = match sense {
                Sense::Directed => [i, j],
                Sense::Unordered => [i.min(j), i.max(j)],
            };
            n_pairs += 1;
            sum = sum.wrapping_add(mixed(u64::from(first) << 32 | u64::from(second)));
        });
        Self { sense, n_pairs, sum }
    }
}

/// SplitMix64's output function: every bit of the input reaches every bit of the output.
fn mixed(mut bits: u64) -> u64 {
    bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ bits >> 31
}

/// Runs a search once, checks that it finds what is expected, and returns it ready to be measured, its buffers kept.
pub(crate) fn agreed<B: Pairs>(
    expected: Fingerprint,
    name: &'static str,
    mut buffer: B,
    mut search: impl FnMut(&mut B),
) -> impl FnMut() {
    search(&mut buffer);
    assert_eq!(Fingerprint::of(&buffer, expected.sense), expected, "{name}");
    move || search(&mut buffer)
}
