//! Refinement of a path: increments over parts of a step, given that of the whole step.

use crate::noise::{Increment, Noise, Purpose, Stream, WORDS_PER_PAIR};

impl<const M: usize> Increment<M> {
    /// Increments over the two halves of a step of length `dt`, given that over the whole step.
    ///
    /// This is a Brownian bridge with its space-time area. `normals` are two independent standard normals per motion.
    ///
    /// $$ a = \tfrac34 H + \tfrac18 \sqrt h  z_1, \quad w_{1,2} = \tfrac12 w \pm 2a, \quad
    ///    H_{1,2} = (H - a) \pm \tfrac12 \sqrt{h/12}  z_2 $$
    ///
    /// The halves have the distribution of two independent steps, and [`from_halves`](Self::from_halves) recovers the
    /// whole step. Derivation: in that formula `H` is the sum of `(w_1 - w_2)/4 ~ N(0, h/16)` and
    /// `(H_1 + H_2)/2 ~ N(0, h/48)`.
    #[must_use]
    pub fn halves(&self, dt: f64, normals: &[[f64; 2]; M]) -> [Self; 2] {
        let (mut first, mut second) = (Self::ZERO, Self::ZERO);
        let (skew_deviation, area_deviation) = (0.125 * dt.sqrt(), 0.5 * (dt / 12.0).sqrt());
        for m in 0..M {
            let (w, area) = (self.brownian[m], self.space_time_area[m]);
            let skew = 0.75 * area + skew_deviation * normals[m][0];
            let difference = area_deviation * normals[m][1];
            first.brownian[m] = 0.5 * w + 2.0 * skew;
            second.brownian[m] = 0.5 * w - 2.0 * skew;
            first.space_time_area[m] = (area - skew) + difference;
            second.space_time_area[m] = (area - skew) - difference;
        }
        [first, second]
    }
}

/// The path of one realisation at every dyadic part of its steps, as a pure function of position.
///
/// Adaptive steps must use the **same** path after a rejected step: redrawing conditions the accepted steps on
/// acceptance, which biases every statistic. Here a rejected step is halved, and the increments of its halves are
/// looked up.
///
/// ```
/// use sde_integrators::{BrownianTree, Increment, Noise};
///
/// let tree = BrownianTree::<1>::new(Noise::new(7), 42, 0.1);
/// let whole = tree.increment(3, &[]);
/// let (first, second) = (tree.increment(3, &[0]), tree.increment(3, &[1]));
/// let joined = Increment::from_halves(&first, &second);
/// assert!((joined.brownian[0] - whole.brownian[0]).abs() < 1e-15);
/// // The steps themselves are those of every other method.
/// assert_eq!(whole, Noise::new(7).path::<1>(42).increment_at(3, 0.1));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrownianTree<const M: usize> {
    noise: Noise,
    realisation: u64,
    dt: f64,
}

impl<const M: usize> BrownianTree<M> {
    /// Largest number of halvings of a step.
    pub const MAX_DEPTH: usize = 20;

    /// The path of a realisation, with steps of length `dt > 0` at the root.
    #[must_use]
    pub const fn new(noise: Noise, realisation: u64, dt: f64) -> Self {
        Self { noise, realisation, dt }
    }

    /// Increment over a part of a step: `halves` selects the half at each level, 0 for the first.
    ///
    /// Entries beyond [`MAX_DEPTH`](Self::MAX_DEPTH) are ignored. The cost is one draw per halving.
    #[must_use]
    pub fn increment(&self, step: u64, halves: &[u8]) -> Increment<M> {
        self.descend(step, halves).increment
    }

    /// Increments over a part of a step, as in [`increment`](Self::increment), and over its two halves.
    #[must_use]
    pub fn parts(&self, step: u64, halves: &[u8]) -> (Increment<M>, [Increment<M>; 2]) {
        let mut node = self.descend(step, halves);
        let parts = node.split();
        (node.increment, parts)
    }

    fn descend(&self, step: u64, halves: &[u8]) -> Node<M> {
        let mut node = Node {
            stream: self.noise.stream(Purpose::Refinement, self.realisation),
            step,
            number: 1,
            dt: self.dt,
            increment: self.noise.path::<M>(self.realisation).increment_at(step, self.dt),
        };
        for &half in halves.iter().take(Self::MAX_DEPTH) {
            let parts = node.split();
            let is_second = half > 0;
            node.increment = parts[usize::from(is_second)];
            node.number = 2 * node.number + u64::from(is_second);
            node.dt *= 0.5;
        }
        node
    }
}

/// A part of a step and its number in the tree: the whole is 1, the halves of `k` are `2k` and `2k + 1`.
struct Node<const M: usize> {
    stream: Stream,
    step: u64,
    number: u64,
    dt: f64,
    increment: Increment<M>,
}

impl<const M: usize> Node<M> {
    fn split(&mut self) -> [Increment<M>; 2] {
        let place = u128::from(self.step) << BrownianTree::<M>::MAX_DEPTH | u128::from(self.number);
        self.stream.seek(place * M as u128 * WORDS_PER_PAIR);
        let normals = std::array::from_fn(|_| self.stream.next_normal_pair());
        self.increment.halves(self.dt, &normals)
    }
}
