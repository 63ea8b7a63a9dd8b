//! Points of the unit cube: pseudo-random and scrambled Sobol' points.

use sde_integrators::{Noise, Purpose};

use crate::designs::joe_kuo::DIRECTIONS;
use crate::error::{Error, require_at_least};

/// How points of the unit cube are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// Independent uniform points.
    PseudoRandom,
    /// Sobol' points with an independent scramble for each replica: [`SobolPoints`].
    ScrambledSobol,
}

/// Sobol' points with nested uniform scrambling.
///
/// Point `i` of a dimension is the exclusive or of the direction numbers at the binary digits of `i`; the digits of each
/// coordinate are then flipped at random, one flip for each node of the binary tree of its intervals. Each point is
/// uniform on the cube, and $2^m$ points remain a net: each elementary interval of volume $2^{t-m}$ holds $2^t$ of them.
/// The mean of $2^m$ points is unbiased; its variance is $o(2^{-m})$ for any square integrable response, and
/// $O(4^{-m})$ to $O(8^{-m})$, up to powers of $m$, for smooth ones.
///
/// Flips are hashes of the node by the output function of SplitMix64, with a key for each dimension from the seed and the
/// replica. Coordinates have 52 digits and lie inside `(0, 1)`.
///
/// Sources: Joe and Kuo 2008, Constructing Sobol sequences with better two-dimensional projections; Owen 1995, Randomly
/// permuted (t,m,s)-nets and (t,s)-sequences; Burley 2020, Practical hash-based Owen scrambling, section 3 (flips by
/// hash); Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SobolPoints {
    /// Direction numbers, 32 for each dimension.
    directions: Vec<[u32; DIGITS]>,
    /// Key of the flips, for each dimension.
    keys: Vec<u64>,
}

/// Digits with direction numbers.
const DIGITS: usize = 32;

impl SobolPoints {
    /// Largest dimension.
    pub const MOST_DIMENSIONS: usize = DIRECTIONS.len() + 1;

    /// Largest number of points.
    pub const MOST_POINTS: u64 = 1 << DIGITS;

    /// The points of a scramble: replicas of a seed are independent.
    ///
    /// # Errors
    /// [`Error::TooFew`] for dimension zero, [`Error::TooMany`] above [`MOST_DIMENSIONS`](Self::MOST_DIMENSIONS).
    pub fn new(dimension: usize, seed: u64, replica: u64) -> Result<Self, Error> {
        require_at_least("dimensions", dimension as u64, 1)?;
        if dimension > Self::MOST_DIMENSIONS {
            let (value, limit) = (dimension as f64, Self::MOST_DIMENSIONS as f64);
            return Err(Error::TooMany { quantity: "dimensions of Sobol' points", value, limit });
        }
        let mut stream = Noise::new(seed).stream(Purpose::UnitCube, replica);
        Ok(Self {
            directions: (0..dimension).map(directions).collect(),
            keys: (0..dimension).map(|_| stream.next_u64()).collect(),
        })
    }

    /// Writes a point, one coordinate for each dimension; `index` counts modulo [`MOST_POINTS`](Self::MOST_POINTS).
    pub fn point(&self, index: u64, x: &mut [f64]) {
        for (x, (directions, &key)) in x.iter_mut().zip(self.directions.iter().zip(&self.keys)) {
            *x = scrambled(digits(directions, index), key);
        }
    }

    /// Writes a point without the scramble: the first one is the corner at zero.
    pub fn unscrambled(&self, index: u64, x: &mut [f64]) {
        for (x, directions) in x.iter_mut().zip(&self.directions) {
            *x = f64::from(digits(directions, index)) / (1_u64 << u32::BITS) as f64;
        }
    }
}

/// Exclusive or of the direction numbers at the digits of an index.
fn digits(directions: &[u32; DIGITS], index: u64) -> u32 {
    let set = |(k, v): (usize, &u32)| if index >> k & 1 == 1 { *v } else { 0 };
    directions.iter().enumerate().map(set).fold(0, |sum, v| sum ^ v)
}

/// Direction numbers of a dimension, from 0, by the recurrence of its primitive polynomial.
fn directions(dimension: usize) -> [u32; DIGITS] {
    let mut v = [0_u32; DIGITS];
    let Some((a, m)) = dimension.checked_sub(1).map(|place| DIRECTIONS[place]) else {
        return std::array::from_fn(|k| 1 << (DIGITS - 1 - k));
    };
    let s = m.len();
    for k in 0..DIGITS {
        v[k] = if k < s {
            m[k] << (DIGITS - 1 - k)
        } else {
            let mut sum = v[k - s] ^ v[k - s] >> s;
            for j in 1..s {
                if a >> (s - 1 - j) & 1 == 1 {
                    sum ^= v[k - j];
                }
            }
            sum
        };
    }
    v
}

/// Digits added below those of the points, so that a coordinate has 52.
const FURTHER_DIGITS: u32 = 20;

/// A coordinate whose digit below each node of the tree is flipped by the node's hash.
///
/// Below 32 digits each node holds at most one point: all further digits come from one hash.
fn scrambled(digits: u32, key: u64) -> f64 {
    let (mut node, mut flipped) = (1_u64, 0_u64);
    for k in (0..DIGITS).rev() {
        let digit = u64::from(digits >> k & 1);
        flipped = flipped << 1 | (digit ^ hash(key, node) >> 63);
        node = node << 1 | digit;
    }
    let whole = flipped << FURTHER_DIGITS | hash(key, node) >> (64 - FURTHER_DIGITS);
    (whole as f64 + 0.5) / (1_u64 << (u32::BITS + FURTHER_DIGITS)) as f64
}

/// Output `counter` of SplitMix64 with state `key`.
const fn hash(key: u64, counter: u64) -> u64 {
    let mut z = key.wrapping_add(counter.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Points of one replica.
#[derive(Debug)]
pub(crate) enum Replica {
    /// Seed and number of the replica.
    PseudoRandom(Noise, u64),
    /// Points of a scramble.
    Scrambled(SobolPoints),
}

/// Pseudo-random points of a replica are numbered below `2^40`.
const POINT_BITS: u32 = 40;

impl Replica {
    pub(crate) fn new(
        sampling: Sampling,
        dimension: usize,
        seed: u64,
        replica: u64,
    ) -> Result<Self, Error> {
        require_at_least("dimensions", dimension as u64, 1)?;
        Ok(match sampling {
            Sampling::PseudoRandom => Self::PseudoRandom(Noise::new(seed), replica),
            Sampling::ScrambledSobol => {
                Self::Scrambled(SobolPoints::new(dimension, seed, replica)?)
            }
        })
    }

    pub(crate) fn point(&self, index: u64, x: &mut [f64]) {
        match self {
            Self::Scrambled(points) => points.point(index, x),
            Self::PseudoRandom(noise, replica) => {
                // Beyond the replicas of Sobol' points, which are below the highest bit.
                let realisation = 1 << 63 | replica << POINT_BITS | index;
                let mut stream = noise.stream(Purpose::UnitCube, realisation);
                for x in x {
                    let whole = stream.next_u64() >> 12;
                    *x = (whole as f64 + 0.5) / (1_u64 << 52) as f64;
                }
            }
        }
    }
}

/// Number of points of a replica and of replicas, with their limits.
pub(crate) fn check_points(
    sampling: Sampling,
    n_points: u64,
    n_replicas: u64,
) -> Result<(), Error> {
    require_at_least("points", n_points, 2)?;
    require_at_least("replicas", n_replicas, FEWEST_REPLICAS)?;
    let (most_points, most_replicas) = (SobolPoints::MOST_POINTS, 1_u64 << 20);
    for (quantity, value, limit) in
        [("points", n_points, most_points), ("replicas", n_replicas, most_replicas)]
    {
        if value > limit {
            return Err(Error::TooMany { quantity, value: value as f64, limit: limit as f64 });
        }
    }
    if sampling == Sampling::ScrambledSobol && !n_points.is_power_of_two() {
        return Err(Error::NotPowerOfTwo { quantity: "Sobol' points", value: n_points });
    }
    Ok(())
}

/// Replicas from which a standard error is known to a quarter, `1/sqrt(2 (8 - 1))`.
const FEWEST_REPLICAS: u64 = 8;
