//! Noise as a pure function of its address: (seed, purpose, realisation, step).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use simd_lanes::{Registers, SimdLevel, Work};

use crate::noise::chacha::{BLOCK_WORDS, blocks, key};
use crate::noise::normal::{BLOCK_NORMALS, normal_blocks, normal_pair};

/// 32-bit words taken by one pair of normals, always.
pub const WORDS_PER_PAIR: u128 = 4;

/// Purpose of a draw. Draws for different purposes never share a word, for any seed.
///
/// The numbers are part of the reproducibility guarantee: they are never changed or reused. 7 was that of parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u64)]
pub enum Purpose {
    /// The Brownian motion that drives a path: its increments `w`.
    Path = 0,
    /// The initial state of a path.
    InitialDistribution = 1,
    /// Values between the ends of a step: bridges, first passage.
    Bridge = 2,
    /// A random field or the parameters of a realisation.
    Field = 3,
    /// Resampling of results.
    Bootstrap = 4,
    /// Space-time areas `H` of the Brownian motion of a path, which only some methods use.
    PathArea = 5,
    /// Proposals and acceptances of a Markov chain.
    MarkovChain = 6,
    /// Points of a unit cube: scrambles of quasi-random points, and pseudo-random points.
    UnitCube = 8,
}

impl Purpose {
    /// All purposes.
    pub const ALL: [Self; 8] = [
        Self::Path,
        Self::InitialDistribution,
        Self::Bridge,
        Self::Field,
        Self::Bootstrap,
        Self::PathArea,
        Self::MarkovChain,
        Self::UnitCube,
    ];
}

/// The increments of `M` Brownian motions over one step of length `h`.
///
/// $$ w = W_h, \qquad H = \frac1h \int_0^h \left( W_s - \frac{s}{h} w \right) ds, $$
///
/// `brownian = w ~ N(0, h)` and `space_time_area = H ~ N(0, h/12)`, independent of each other and between motions.
/// The iterated integral `int_0^h W ds` is `h (w/2 + H)`.
///
/// Source: Foster, Lyons and Oberhauser 2020, An optimal polynomial approximation of Brownian motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Increment<const M: usize> {
    /// `w`, per motion (square root of time).
    pub brownian: [f64; M],
    /// `H`, the space-time Levy area per motion (square root of time).
    pub space_time_area: [f64; M],
}

impl<const M: usize> Increment<M> {
    /// Zero noise: reduces an integrator to its method for ordinary differential equations.
    pub const ZERO: Self = Self { brownian: [0.0; M], space_time_area: [0.0; M] };

    /// Increment over a step from those over its two equal halves, exactly.
    ///
    /// `w = w_1 + w_2` and `H = (w_1 - w_2)/4 + (H_1 + H_2)/2`.
    ///
    /// It represents the same path at every step size, as studies of strong order require.
    #[must_use]
    pub fn from_halves(first: &Self, second: &Self) -> Self {
        let mut whole = Self::ZERO;
        for m in 0..M {
            let (w_1, w_2) = (first.brownian[m], second.brownian[m]);
            whole.brownian[m] = w_1 + w_2;
            whole.space_time_area[m] =
                0.25 * (w_1 - w_2) + 0.5 * (first.space_time_area[m] + second.space_time_area[m]);
        }
        whole
    }

    /// The increment of noise whose amplitude is larger by a factor.
    #[must_use]
    pub fn amplified(&self, amplitude: f64) -> Self {
        let Self { brownian, space_time_area } = self;
        Self {
            brownian: brownian.map(|w| amplitude * w),
            space_time_area: space_time_area.map(|h| amplitude * h),
        }
    }
}

/// The noise of a study: all random numbers follow from its seed.
///
/// It is ChaCha with 8 rounds used as a function. Key: seed (8 bytes, little endian), purpose (8 bytes), zeros;
/// stream: realisation; word: number of the normal times two. Every draw takes a fixed number of words. The normals
/// are computed without the platform's mathematics library, so the same address gives bitwise identical numbers on
/// every platform.
///
/// Source of the cipher: Bernstein 2008, ChaCha, a variant of Salsa20.
///
/// ```
/// use sde_integrators::Noise;
///
/// let noise = Noise::new(7);
/// let mut path = noise.path::<1>(42);
/// let first_steps = [(); 3].map(|()| path.next_increment(0.01));
/// assert_eq!(path.increment_at(1, 0.01), first_steps[1]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Noise {
    seed: u64,
}

impl Noise {
    /// The noise of a seed. Neighbouring seeds are as independent as distant ones.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The seed.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        self.seed
    }

    /// The words of one realisation for one purpose, from the first one.
    #[must_use]
    pub fn stream(&self, purpose: Purpose, realisation: u64) -> Stream {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(realisation);
        let key = crate::noise::chacha::key(self.seed, purpose as u64);
        Stream { generator, key, realisation, level: SimdLevel::best() }
    }

    /// The `M` Brownian motions of one realisation, from step 0.
    #[must_use]
    pub fn path<const M: usize>(&self, realisation: u64) -> PathNoise<M> {
        PathNoise::new(self.seed, realisation)
    }
}

/// Words, uniforms and normals of one realisation for one purpose, in order or from any position.
#[derive(Debug, Clone)]
pub struct Stream {
    generator: ChaCha8Rng,
    key: [u32; 8],
    realisation: u64,
    level: SimdLevel,
}

impl Stream {
    /// Sets the SIMD level for generating many normals; results are bitwise identical at every level.
    #[must_use]
    pub fn at_level(self, level: SimdLevel) -> Self {
        Self { level, ..self }
    }

    /// Moves to a 32-bit word, counted from the start of the stream modulo `2^68`. Costs about 100 ns.
    pub fn seek(&mut self, word: u128) {
        self.generator.set_word_pos(word);
    }

    /// The next 64 random bits: two words.
    #[inline]
    #[must_use]
    pub fn next_u64(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// A uniform number in `[0, 1)` with 53 bits: two words.
    #[inline]
    #[must_use]
    pub fn next_uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Two independent standard normals: four words.
    #[inline]
    #[must_use]
    pub fn next_normal_pair(&mut self) -> [f64; 2] {
        let radial = self.next_u64();
        let angular = self.next_u64();
        normal_pair(radial, angular)
    }

    /// Fills a slice with independent standard normals: four words for each two.
    ///
    /// The last pair is taken whole even if one is left over.
    ///
    /// The values are those of [`next_normal_pair`](Self::next_normal_pair), generated many at a time: it pays off
    /// from about 50 numbers.
    pub fn fill_normal(&mut self, normals: &mut [f64]) {
        let mut rest = normals;
        if rest.len() > FIELD_NORMALS / 2 {
            // Pair by pair up to the next block of the cipher; all of them if not aligned with the pairs.
            while !rest.is_empty()
                && !self.generator.get_word_pos().is_multiple_of(BLOCK_WORDS as u128)
            {
                rest = self.fill_pair(rest);
            }
            let start = self.generator.get_word_pos();
            if !rest.is_empty() {
                let words = rest.len().div_ceil(2) as u128 * WORDS_PER_PAIR;
                let (key, stream) = (&self.key, self.realisation);
                let block = low_u64(start / BLOCK_WORDS as u128);
                self.level.run(FillField { key, stream, block, normals: rest });
                self.generator.set_word_pos(start + words);
                return;
            }
        }
        while !rest.is_empty() {
            rest = self.fill_pair(rest);
        }
    }

    fn fill_pair<'a>(&mut self, normals: &'a mut [f64]) -> &'a mut [f64] {
        let (pair, rest) = normals.split_at_mut(normals.len().min(2));
        pair.copy_from_slice(&self.next_normal_pair()[..pair.len()]);
        rest
    }
}

#[allow(clippy::cast_possible_truncation, reason = "a counter of blocks wraps at 2^64")]
const fn low_u64(x: u128) -> u64 {
    x as u64
}

/// Blocks of one stream generated together.
const FIELD_BLOCKS: usize = 16;
/// Normals of these blocks.
const FIELD_NORMALS: usize = FIELD_BLOCKS * BLOCK_NORMALS;

/// The normals of one stream from a block on.
struct FillField<'a> {
    key: &'a [u32; 8],
    stream: u64,
    block: u64,
    normals: &'a mut [f64],
}

impl Work<f64> for FillField<'_> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let mut rows = [[0.0; FIELD_BLOCKS]; BLOCK_NORMALS];
        let mut block = self.block;
        for part in self.normals.chunks_mut(FIELD_NORMALS) {
            let counters = simd_lanes::from_fn(|lane| block.wrapping_add(lane as u64));
            normal_blocks(self.key, &[self.stream; FIELD_BLOCKS], &counters, &mut rows);
            if let Ok(whole) = <&mut [f64; FIELD_NORMALS]>::try_from(&mut *part) {
                for lane in 0..FIELD_BLOCKS {
                    for row in 0..BLOCK_NORMALS {
                        whole[lane * BLOCK_NORMALS + row] = rows[row][lane];
                    }
                }
            } else {
                for (k, normal) in part.iter_mut().enumerate() {
                    *normal = rows[k % BLOCK_NORMALS][k / BLOCK_NORMALS];
                }
            }
            block = block.wrapping_add(FIELD_BLOCKS as u64);
        }
    }
}

/// Increments of one path, step by step (fast) or at any step (one block of the cipher per number).
///
/// Normal number `k M + m` of [`Purpose::Path`] belongs to step `k` and motion `m`; that of [`Purpose::PathArea`]
/// belongs to its space-time area.
#[derive(Debug, Clone)]
pub struct PathNoise<const M: usize> {
    brownian: Ahead,
    area: Ahead,
    level: SimdLevel,
    /// Number of the next normal.
    next: u128,
    /// Whether the buffered normals surround the next one.
    is_ahead: bool,
}

/// Blocks of a path generated ahead.
const AHEAD_BLOCKS: usize = 8;
const AHEAD_NORMALS: u128 = (AHEAD_BLOCKS * BLOCK_NORMALS) as u128;

/// Normals generated ahead for one purpose.
#[derive(Debug, Clone)]
struct Ahead {
    key: [u32; 8],
    stream: u64,
    /// One row per normal of a block, one column per block.
    rows: [[f64; AHEAD_BLOCKS]; BLOCK_NORMALS],
}

impl Ahead {
    fn new(seed: u64, purpose: Purpose, stream: u64) -> Self {
        let rows = [[0.0; AHEAD_BLOCKS]; BLOCK_NORMALS];
        Self { key: key(seed, purpose as u64), stream, rows }
    }

    /// One normal by its number.
    fn one(&self, number: u128) -> f64 {
        let block = low_u64(number / BLOCK_NORMALS as u128);
        let place = (number % BLOCK_NORMALS as u128) as usize;
        let mut words = [[0; 1]; BLOCK_WORDS];
        blocks(&self.key, &[self.stream], &[block], &mut words);
        let first = 4 * (place / 2);
        let two = |k: usize| u64::from(words[k][0]) | u64::from(words[k + 1][0]) << 32;
        normal_pair(two(first), two(first + 2))[place % 2]
    }
}

struct DrawAhead<'a> {
    ahead: &'a mut Ahead,
    block: u64,
}

impl Work<f64> for DrawAhead<'_> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "it is compiled for the registers of the level")]
    #[inline(always)]
    fn run<R: Registers<f64>>(self, _: R) {
        let Self { ahead: Ahead { key, stream, rows }, block } = self;
        let counters = simd_lanes::from_fn(|lane| block.wrapping_add(lane as u64));
        normal_blocks(key, &[*stream; AHEAD_BLOCKS], &counters, rows);
    }
}

impl<const M: usize> PathNoise<M> {
    fn new(seed: u64, realisation: u64) -> Self {
        Self {
            brownian: Ahead::new(seed, Purpose::Path, realisation),
            area: Ahead::new(seed, Purpose::PathArea, realisation),
            level: SimdLevel::best(),
            next: 0,
            is_ahead: false,
        }
    }

    /// The increment over the next step, of length `dt >= 0`.
    #[inline]
    #[must_use]
    pub fn next_increment(&mut self, dt: f64) -> Increment<M> {
        let (brownian_deviation, area_deviation) = (dt.sqrt(), (dt / 12.0).sqrt());
        let mut increment = Increment::ZERO;
        for m in 0..M {
            let place = (self.next % AHEAD_NORMALS) as usize;
            if place == 0 || !self.is_ahead {
                self.draw_ahead();
            }
            let (row, column) = (place % BLOCK_NORMALS, place / BLOCK_NORMALS);
            increment.brownian[m] = brownian_deviation * self.brownian.rows[row][column];
            increment.space_time_area[m] = area_deviation * self.area.rows[row][column];
            self.next += 1;
        }
        increment
    }

    /// The increment over a given step, counted from 0. The path continues with the step after it.
    #[must_use]
    pub fn increment_at(&mut self, step: u64, dt: f64) -> Increment<M> {
        self.next = u128::from(step) * M as u128;
        let (brownian_deviation, area_deviation) = (dt.sqrt(), (dt / 12.0).sqrt());
        let mut increment = Increment::ZERO;
        for m in 0..M {
            increment.brownian[m] = brownian_deviation * self.brownian.one(self.next);
            increment.space_time_area[m] = area_deviation * self.area.one(self.next);
            self.next += 1;
        }
        self.is_ahead = false;
        increment
    }

    /// Generates the normals around the next one.
    #[inline(never)]
    fn draw_ahead(&mut self) {
        let block = low_u64(self.next / AHEAD_NORMALS * AHEAD_BLOCKS as u128);
        self.level.run(DrawAhead { ahead: &mut self.brownian, block });
        self.level.run(DrawAhead { ahead: &mut self.area, block });
        self.is_ahead = true;
    }
}
