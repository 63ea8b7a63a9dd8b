//! Linear regressions of a drift along the running normal distribution, under several strengths.

/// Mean and covariance at a time, of any number of states.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RunningLaw {
    pub(crate) mean: Vec<f64>,
    /// Row by row.
    pub(crate) covariance: Vec<f64>,
}

impl RunningLaw {
    /// All states zero with certainty.
    pub(crate) fn at_rest(n_states: usize) -> Self {
        Self { mean: vec![0.0; n_states], covariance: vec![0.0; n_states * n_states] }
    }

    pub(crate) fn covariance(&self, i: usize, j: usize) -> f64 {
        self.covariance[i * self.mean.len() + j]
    }

    pub(crate) fn largest_variance(&self) -> f64 {
        let n = self.mean.len();
        (0..n).map(|i| self.covariance(i, i)).fold(0.0, f64::max)
    }
}

/// `f(x) ~ slope x + constant` at a time.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Regression {
    /// The entries of the [`Pattern`].
    pub(crate) slope: Vec<f64>,
    pub(crate) constant: Vec<f64>,
}

/// Row and column of the entries of a slope, row by row.
pub(crate) type Pattern = Vec<(usize, usize)>;

/// Regressions at equally spaced times from 0 on.
#[derive(Debug, Clone)]
pub(crate) struct Regressions {
    pub(crate) pattern: Pattern,
    /// Distance of the times.
    pub(crate) spacing: f64,
    /// The running normal distribution of the linearisation at each time.
    pub(crate) laws: Vec<RunningLaw>,
    /// Per strength, per time.
    pub(crate) of_strength: Vec<Vec<Regression>>,
}

impl Regressions {
    /// The regression of a strength at a time, linearly interpolated, written into `result`.
    pub(crate) fn interpolate(&self, strength: usize, t: f64, result: &mut Regression) {
        let regressions = &self.of_strength[strength];
        let (before, part) = self.place(t);
        let (a, b) = (&regressions[before], &regressions[before + 1]);
        let between = |a: &[f64], b: &[f64], values: &mut Vec<f64>| {
            values.clear();
            values.extend(a.iter().zip(b).map(|(a, b)| a + part * (b - a)));
        };
        between(&a.slope, &b.slope, &mut result.slope);
        between(&a.constant, &b.constant, &mut result.constant);
    }

    /// The running normal distribution at the start of the interval that contains a time.
    pub(crate) fn law_at(&self, t: f64) -> &RunningLaw {
        &self.laws[self.place(t).0]
    }

    /// Variance of the rate of a state at a time, under the regression of strength 1 and the running distribution.
    pub(crate) fn rate_variance(&self, component: usize, t: f64) -> f64 {
        let mut regression = Regression::default();
        self.interpolate(0, t, &mut regression);
        let law = self.law_at(t);
        let row = || {
            let entries = self.pattern.iter().zip(&regression.slope);
            entries.filter(|((i, _), _)| *i == component).map(|((_, j), value)| (*j, *value))
        };
        row().map(|(i, a)| row().map(|(j, b)| a * law.covariance(i, j) * b).sum::<f64>()).sum()
    }

    /// The interval that contains a time, and the part of it before the time.
    fn place(&self, t: f64) -> (usize, f64) {
        let place = t / self.spacing;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a number of intervals, and a cast saturates"
        )]
        let before = (place as usize).min(self.laws.len() - 2);
        (before, place - before as f64)
    }
}
