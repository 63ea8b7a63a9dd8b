//! The random inputs of an experiment, as functions of independent standard normals.

use perturbation_moments::{Jet, LANES, RandomVector};

/// The random inputs of an experiment, as a map $x = x(t)$ from independent standard normals.
///
/// There are two: a [`RandomVector`] of parameters, and [`Coefficients`] of random fields.
pub trait Inputs: std::fmt::Debug + Send + Sync {
    /// How many normals it takes, which is also how many inputs there are.
    fn n_normals(&self) -> usize;

    /// The inputs at normals.
    fn point(&self, normals: &[f64]) -> Vec<f64>;

    /// The inputs at the centre, with their derivatives along up to [`LANES`] directions in the space of the normals.
    fn jets(&self, directions: &[Vec<f64>]) -> Vec<Jet>;

    /// Number of the first normals on which the inputs depend at all.
    fn n_random(&self) -> usize {
        self.n_normals()
    }

    /// The centre with one input at the quantile $\Phi(u)$ of its own distribution; `None` if it is not to be checked against
    /// the range of a model.
    fn with_quantile(&self, input: usize, u: f64) -> Option<Vec<f64>>;
}

impl<const N: usize> Inputs for RandomVector<N> {
    fn n_normals(&self) -> usize {
        N
    }

    fn point(&self, normals: &[f64]) -> Vec<f64> {
        Self::point(self, &filled(normals)).to_vec()
    }

    fn jets(&self, directions: &[Vec<f64>]) -> Vec<Jet> {
        // The vector has probes behind its own directions: in the first pass behind these, all lanes are probes.
        let pass = N.div_ceil(LANES);
        let mut probes = vec![[0.0; N]; LANES * pass - N];
        probes.extend(directions.iter().map(|direction| filled(direction)));
        self.jets_of_pass(pass, &probes).to_vec()
    }

    /// Up to the last parameter with a deviation.
    fn n_random(&self) -> usize {
        self.deviations().iter().rposition(|&deviation| deviation > 0.0).map_or(0, |k| k + 1)
    }

    fn with_quantile(&self, input: usize, u: f64) -> Option<Vec<f64>> {
        let mut inputs = self.centre();
        inputs[input] = self.quantiles(u)[input];
        (self.deviations()[input] > 0.0).then(|| inputs.to_vec())
    }
}

/// The first numbers; zeros where there are fewer.
fn filled<const N: usize>(numbers: &[f64]) -> [f64; N] {
    std::array::from_fn(|k| numbers.get(k).copied().unwrap_or(0.0))
}

/// Coefficients of the modes of random fields: so many independent standard normals, themselves the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coefficients(pub usize);

impl Inputs for Coefficients {
    fn n_normals(&self) -> usize {
        self.0
    }

    fn point(&self, normals: &[f64]) -> Vec<f64> {
        normals.to_vec()
    }

    fn jets(&self, directions: &[Vec<f64>]) -> Vec<Jet> {
        let slope = |k: usize| {
            move |lane: usize| directions.get(lane).map_or(0.0, |direction| direction[k])
        };
        (0..self.0).map(|k| Jet::new(0.0, std::array::from_fn(slope(k)))).collect()
    }

    fn with_quantile(&self, _input: usize, _u: f64) -> Option<Vec<f64>> {
        None
    }
}

impl<const N: usize> From<RandomVector<N>> for Box<dyn Inputs> {
    fn from(inputs: RandomVector<N>) -> Self {
        Box::new(inputs)
    }
}

impl From<Coefficients> for Box<dyn Inputs> {
    fn from(inputs: Coefficients) -> Self {
        Box::new(inputs)
    }
}
