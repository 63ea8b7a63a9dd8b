//! What a run is asked for.

/// Requested results of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Requested<const D: usize = 2> {
    /// Times of observation.
    pub times: Vec<f64>,
    /// Raw moments `E[x_1^a_1 .. x_D^a_D]`.
    pub powers: Vec<[u32; D]>,
    /// Demand compared with the thresholds.
    pub demand: Demand,
    /// Thresholds `T` of `P(|y| > T)` for the demand `y`.
    pub thresholds: Vec<f64>,
    /// Times at which the noise has a kink, in increasing order: a step ends at each, since one across it loses its order.
    pub kinks: Vec<f64>,
    /// Whether to integrate over the particles' cells, which requires a flow map.
    pub cells: bool,
}

/// A weighted sum of the states, compared in magnitude.
#[derive(Debug, Clone, PartialEq)]
pub struct Demand {
    /// Its name.
    pub name: String,
    /// Weight of each state.
    pub weights: Vec<f64>,
}

impl Demand {
    /// The demand on one state.
    #[must_use]
    pub fn of_state(state: usize, name: &str, n_states: usize) -> Self {
        let weights = (0..n_states).map(|k| f64::from(u8::from(k == state))).collect();
        Self { name: name.to_owned(), weights }
    }

    /// `|q|` of an oscillator `(q, v)`.
    #[must_use]
    pub fn displacement() -> Self {
        Self::of_state(0, "q", 2)
    }

    /// Evaluates `|y(x)|`.
    #[must_use]
    pub fn magnitude<const D: usize>(&self, x: &[f64; D]) -> f64 {
        self.weights.iter().zip(x).map(|(weight, x)| weight * x).sum::<f64>().abs()
    }
}
