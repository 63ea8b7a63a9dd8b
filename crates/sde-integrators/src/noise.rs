//! Noise as a pure function of its address: (seed, purpose, realisation, step).

use pulp::Arch;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::normal::{LANES, normal_pair, normal_pairs};

/// Words of 32 bits that one pair of normals takes, always.
pub const WORDS_PER_PAIR: u128 = 4;

/// What a draw is for. Draws for different purposes never share a word, whatever the seed.
///
/// The numbers are part of the reproducibility guarantee: they are never changed or used again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
#[repr(u64)]
pub enum Purpose {
    /// The Brownian motion that drives a path.
    Path = 0,
    /// The state a path starts from.
    InitialLaw = 1,
    /// What happens between the ends of a step: bridges, first passage.
    Bridge = 2,
    /// A random field or the parameters of a realisation.
    Field = 3,
    /// Resampling of finished results.
    Bootstrap = 4,
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
    /// No noise at all: what turns an integrator into its method for ordinary differential equations.
    pub const ZERO: Self = Self { brownian: [0.0; M], space_time_area: [0.0; M] };

    /// The increment over a whole step from those over its two equal halves, exactly:
    /// `w = w_1 + w_2` and `H = (w_1 - w_2)/4 + (H_1 + H_2)/2`.
    ///
    /// The same path is thereby seen at every step size, which is what a study of strong order needs.
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
}

/// The noise of a whole study: everything that is drawn follows from its seed.
///
/// It is ChaCha with 8 rounds used as a function. Key: seed (8 bytes, little endian), purpose (8 bytes), zeros;
/// stream: realisation; word: step times words per step. Every draw takes a fixed number of words, and the normals
/// are computed without the platform's mathematics library, so that the same address gives the same bits everywhere.
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
    /// The noise that belongs to a seed. Neighbouring seeds are as independent as distant ones.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The seed it was made from.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        self.seed
    }

    /// The words of one realisation for one purpose, from the first on.
    #[must_use]
    pub fn stream(&self, purpose: Purpose, realisation: u64) -> Stream {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        let mut generator = ChaCha8Rng::from_seed(key);
        generator.set_stream(realisation);
        Stream { generator }
    }

    /// The `M` Brownian motions that drive one realisation, from step 0 on.
    #[must_use]
    pub fn path<const M: usize>(&self, realisation: u64) -> PathNoise<M> {
        PathNoise::new(self.stream(Purpose::Path, realisation))
    }
}

/// Words, uniforms and normals of one realisation for one purpose, in order or from any position.
#[derive(Debug, Clone)]
pub struct Stream {
    generator: ChaCha8Rng,
}

impl Stream {
    /// Move to a word of 32 bits, counted from the start of the stream modulo `2^68`. Costs about 100 ns.
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

    /// Independent standard normals: four words for each two, the last pair taken whole also where one is left over.
    pub fn fill_normal(&mut self, normals: &mut [f64]) {
        for pair in normals.chunks_mut(2) {
            pair.copy_from_slice(&self.next_normal_pair()[..pair.len()]);
        }
    }
}

/// The increments of one path, step after step (fast) or at any step (about 100 ns and a batch of draws).
#[derive(Debug, Clone)]
pub struct PathNoise<const M: usize> {
    stream: Stream,
    arch: Arch,
    /// Normals drawn ahead, the first of each pair and the second.
    normals: [[f64; LANES]; 2],
    /// The first of them that has not been used; [`LANES`] where there is none.
    next: usize,
}

impl<const M: usize> PathNoise<M> {
    fn new(stream: Stream) -> Self {
        Self { stream, arch: Arch::new(), normals: [[0.0; LANES]; 2], next: LANES }
    }

    /// The increment over the next step, of length `dt >= 0`.
    #[inline]
    #[must_use]
    pub fn next_increment(&mut self, dt: f64) -> Increment<M> {
        let (brownian_deviation, area_deviation) = (dt.sqrt(), (dt / 12.0).sqrt());
        let mut increment = Increment::ZERO;
        for m in 0..M {
            if self.next == LANES {
                self.draw_ahead();
            }
            increment.brownian[m] = brownian_deviation * self.normals[0][self.next];
            increment.space_time_area[m] = area_deviation * self.normals[1][self.next];
            self.next += 1;
        }
        increment
    }

    /// The increment over a given step, counted from 0. The path continues with the step after it.
    #[must_use]
    pub fn increment_at(&mut self, step: u64, dt: f64) -> Increment<M> {
        self.stream.seek(u128::from(step) * WORDS_PER_PAIR * M as u128);
        self.next = LANES;
        self.next_increment(dt)
    }

    #[inline(never)]
    fn draw_ahead(&mut self) {
        let (mut radial, mut angular) = ([0; LANES], [0; LANES]);
        for lane in 0..LANES {
            radial[lane] = self.stream.next_u64();
            angular[lane] = self.stream.next_u64();
        }
        self.normals = normal_pairs(self.arch, &radial, &angular);
        self.next = 0;
    }
}
