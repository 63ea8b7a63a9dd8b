//! The lattice of a scene: initial particles and remeshing.

use fpk_sph::score::Degree;
use fpk_sph::{
    Combination, Estimator, InitialLattice, MOST_NEGLIGIBLE, Method, Remapping, Settling, StepRule,
    ball_reach, box_reach,
};
use scene_runs::scene::Objection;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks::{check_length, must};
use super::scheme_scene::SchemeScene;

/// The initial lattice in standard deviations of the initial distribution: a box by `count`, or a ball by `spacing`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LatticeScene {
    /// A box: number of particles along each axis (no unit). Give either this or `spacing`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<Vec<usize>>,
    /// A ball: spacing in standard deviations of the initial distribution (no unit). Give either this or `count`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<f64>,
    /// Half-width or radius in standard deviations of the initial distribution (no unit). Give either this or
    /// `smallest_probability`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
    /// Smallest probability of interest (no unit): the lattice goes so far that it leaves at most a tenth of it outside, if
    /// the initial distribution is normal. Give either this or `reach`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = SMALLEST_PROBABILITY))]
    pub smallest_probability: Option<f64>,
    /// Remeshing where the flow has made the cloud uneven; none without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fresh_lattices: Option<FreshLatticesScene>,
    /// Minimum number of steps per natural period (no unit).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 40))]
    pub steps_per_period: Option<f64>,
    /// Time integration scheme.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = SchemeScene::RungeKutta4))]
    pub scheme: Option<SchemeScene>,
    /// Part of the second moments (no unit) whose thinnest cells the limit of the step leaves out, from 0 to 0.03: fewer steps
    /// for moments, less accurate tails.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = 0))]
    pub negligible: Option<f64>,
    /// How fast positions lose the waves that the fit does not resolve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = SettlingScene::Uniform))]
    pub settling: Option<SettlingScene>,
    /// Degree of the local polynomials.
    ///
    /// Default: cubic up to four states and quadratic from five.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degree: Option<DegreeScene>,
    /// Where a filter's states are carried. Conditioned out they need no axis of the lattice: `count` then has an entry for each
    /// state of the structure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("default" = FilterScene::Lattice), example = FilterScene::Conditioned)]
    pub filter: Option<FilterScene>,
}

/// Where the states of a filter are carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FilterScene {
    /// On the lattice, as those of the structure.
    Lattice,
    /// As their mean given the structure's states, with one covariance for all: moments and thresholds of the structure.
    Conditioned,
}

/// Smallest probability of interest where a scene names neither it nor a reach.
const SMALLEST_PROBABILITY: f64 = 1e-6;

/// Degree of a local polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DegreeScene {
    /// Degree 2.
    Quadratic,
    /// Degree 3.
    Cubic,
    /// Degree 4.
    Quartic,
}

impl DegreeScene {
    const fn degree(self) -> Degree {
        match self {
            Self::Quadratic => Degree::Quadratic,
            Self::Cubic => Degree::Cubic,
            Self::Quartic => Degree::Quartic,
        }
    }
}

/// How fast positions lose the waves that the flow-map fit does not resolve, in reference periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SettlingScene {
    /// By the time constant 0.3 everywhere.
    Uniform,
    /// By 0.6 within 2.5 initial standard deviations and 0.1 beyond 4: for hysteresis, fewer inverted cells at the rim.
    Graded,
}

impl SettlingScene {
    const fn settling(self) -> Settling {
        match self {
            Self::Uniform => Settling::UNIFORM,
            Self::Graded => Settling::GRADED,
        }
    }
}

/// When the cloud is remeshed, and the largest changes that a remeshing may make; `{}` uses the measured defaults.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FreshLatticesScene {
    /// Unevenness of the cloud above which it is remeshed (no unit).
    pub most_uneven: f64,
    /// Largest probability outside the outermost layer of the new lattice (no unit).
    pub outermost_mass: f64,
    /// Largest change of mass, mean and covariance by a remeshing before they are restored (no unit).
    pub most_change: f64,
}

impl Default for FreshLatticesScene {
    fn default() -> Self {
        let Remapping { most_uneven, outermost_mass, most_change, .. } = Remapping::MEASURED;
        Self { most_uneven, outermost_mass, most_change }
    }
}

impl LatticeScene {
    /// The method with the requested remeshing, steps, scheme, settling and degree.
    pub(crate) fn method<const D: usize>(&self, method: Method) -> Method {
        let Self { fresh_lattices, steps_per_period, scheme, negligible, settling, degree, .. } =
            self;
        let is_plain = fresh_lattices.is_none() && steps_per_period.is_none() && scheme.is_none();
        if is_plain && negligible.is_none() && settling.is_none() && degree.is_none() {
            return method;
        }
        let combination = method.combination_in(D);
        let remapping = fresh_lattices.map(|asked| {
            let FreshLatticesScene { most_uneven, outermost_mass, most_change } = asked;
            let most_particles = match D {
                1 => MOST_ALONG_A_LINE,
                _ => Remapping::MEASURED.most_particles,
            };
            Remapping { most_uneven, outermost_mass, most_change, most_particles }
        });
        let step = steps_per_period.map_or(combination.step, |steps_per_period| {
            StepRule::PeriodFraction { steps_per_period }
        });
        let scheme = scheme.map_or(combination.scheme, SchemeScene::scheme);
        let mut estimator = combination.estimator;
        // Kernel sums have neither.
        if let Estimator::FlowMapFit { degree: of_fit, settling: of_positions, .. } = &mut estimator
        {
            *of_fit = degree.map_or(*of_fit, DegreeScene::degree);
            *of_positions = settling.map_or(*of_positions, SettlingScene::settling);
        }
        let negligible = negligible.unwrap_or(combination.negligible);
        Method::Custom(Combination {
            estimator,
            remapping,
            step,
            scheme,
            negligible,
            ..combination
        })
    }

    /// The lattice with `scale` times as many particles along a length; `None` in another dimension.
    pub(crate) fn build<const D: usize>(&self, scale: f64) -> Option<InitialLattice<D>> {
        let reach = self.reach_in(D)?;
        Some(match &self.count {
            Some(count) => InitialLattice::Box { reach, count: scaled_counts(count, scale)? },
            None => InitialLattice::Ball { reach, spacing: self.spacing? / scale },
        })
    }

    /// The reach of the lattice; `None` for a smallest probability that has none, which the check of the scene rejects.
    pub(crate) fn reach_in(&self, dimension: usize) -> Option<f64> {
        self.reach.or_else(|| {
            let of = if self.count.is_some() { box_reach } else { ball_reach };
            of(dimension, self.smallest_probability.unwrap_or(SMALLEST_PROBABILITY)).ok()
        })
    }

    pub(crate) fn check(&self, path: &str, states: &[&str]) -> Result<(), Objection> {
        self.check_extent(path)?;
        if let Some(steps) = self.steps_per_period {
            must(&format!("{path}.steps_per_period"), steps, steps > 0.0, "greater than 0")?;
        }
        self.check_negligible(path)?;
        if let Some(FreshLatticesScene { most_uneven, outermost_mass, most_change }) =
            self.fresh_lattices
        {
            for (key, value) in [
                ("most_uneven", most_uneven),
                ("outermost_mass", outermost_mass),
                ("most_change", most_change),
            ] {
                let path = format!("{path}.fresh_lattices.{key}");
                must(&path, value, value > 0.0, "greater than 0")?;
            }
        }
        match (&self.count, self.spacing) {
            (Some(count), None) => check_counts(path, count, states),
            (None, Some(spacing)) => {
                let reach = self.reach_in(states.len()).unwrap_or(f64::INFINITY);
                check_ball(path, reach, spacing, states.len())
            }
            _ => Err(Objection::new(
                path,
                "either `count` for a box or `spacing` for a ball must be given",
            )),
        }
    }
}

impl LatticeScene {
    /// Rejects a negligible part out of its range.
    fn check_negligible(&self, path: &str) -> Result<(), Objection> {
        let Some(negligible) = self.negligible else { return Ok(()) };
        let is_in_range = (0.0..=MOST_NEGLIGIBLE).contains(&negligible);
        must(&format!("{path}.negligible"), negligible, is_in_range, "from 0 to 0.03")
    }

    /// Rejects a reach or a smallest probability out of its range, and both.
    fn check_extent(&self, path: &str) -> Result<(), Objection> {
        if let Some(reach) = self.reach {
            let limit = "greater than 0 standard deviations";
            must(&format!("{path}.reach"), reach, reach > 0.0, limit)?;
        }
        let Some(smallest) = self.smallest_probability else { return Ok(()) };
        let path = format!("{path}.smallest_probability");
        let is_in_range = (1e-30..=0.1).contains(&smallest);
        must(&path, smallest, is_in_range, "from 1e-30 to 0.1")?;
        if self.reach.is_none() {
            return Ok(());
        }
        Err(Objection::new(path, "`reach` is given too, and both say how far the lattice goes")
            .with_help("leave out one of them"))
    }
}

pub(crate) fn scaled_counts<const D: usize>(count: &[usize], scale: f64) -> Option<[usize; D]> {
    let count: [usize; D] = count.try_into().ok()?;
    Some(count.map(|n| scaled_count(n, scale)))
}

/// Number of particles along an axis at `scale` times the resolution; the ends of the lattice do not move.
fn scaled_count(count: usize, scale: f64) -> usize {
    let intervals = count.saturating_sub(1) as f64 * scale;
    // The nearest integer number of intervals.
    1 + (1..=MOST_PER_AXIS).take_while(|&n| n as f64 <= intervals + 0.5).last().unwrap_or(0)
}

/// Most particles of one state on a new lattice. A lattice that is refined without end, where a density closes on a boundary, was
/// refused at 100,000 particles after four minutes.
const MOST_ALONG_A_LINE: usize = 10_000;

/// Largest number of particles along an axis: their square fits the neighbour lists and the memory of a workstation.
const MOST_PER_AXIS: usize = 2_000;
/// Largest number of particles: the square of [`MOST_PER_AXIS`].
const MOST_PARTICLES: f64 = 4e6;

pub(crate) fn check_counts(path: &str, count: &[usize], states: &[&str]) -> Result<(), Objection> {
    check_length(&format!("{path}.count"), count.len(), states)?;
    for (k, &n) in count.iter().enumerate() {
        let allowed = (3..=MOST_PER_AXIS).contains(&n);
        must(&format!("{path}.count[{k}]"), n as f64, allowed, "from 3 to 2000 particles")?;
    }
    let particles: f64 = count.iter().map(|&n| n as f64).product();
    let limit = "such that there are at most 4e6 particles";
    must(&format!("{path}.count"), particles, particles <= MOST_PARTICLES, limit)
}

fn check_ball(path: &str, reach: f64, spacing: f64, dimension: usize) -> Result<(), Objection> {
    let path = format!("{path}.spacing");
    must(&path, spacing, spacing > 0.0, "greater than 0 standard deviations")?;
    // The box around the ball bounds the number of particles.
    let particles =
        (2.0 * reach / spacing + 1.0).powi(i32::try_from(dimension).unwrap_or(i32::MAX));
    let limit = "such that the box around the ball holds at most 4e6 particles";
    must(&path, spacing, particles <= MOST_PARTICLES, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene_runs::schema::defaults;

    #[test]
    fn a_negligible_part_is_refused_out_of_its_range() {
        let objection = |keys: &str| {
            let text = format!(r#"{{ "count": [21, 21], "reach": 6, {keys} }}"#);
            let lattice: LatticeScene = serde_json::from_str(&text).unwrap();
            lattice.check("method.flow_map_fit", &["q", "v"]).err().map(|error| error.to_string())
        };
        assert_eq!(objection(r#""negligible": 0.01"#), None);
        for keys in [r#""negligible": 0.04"#, r#""negligible": -1e-3"#] {
            let error = objection(keys).unwrap();
            assert!(error.contains("method.flow_map_fit.negligible"), "{error}");
        }
    }

    #[test]
    fn settling_is_that_of_the_scene() {
        let text = r#"{ "spacing": 0.6, "reach": 6, "settling": "graded" }"#;
        let lattice: LatticeScene = serde_json::from_str(text).unwrap();
        let combination = lattice.method::<3>(Method::FlowMapFit).combination_in(3);
        let Estimator::FlowMapFit { settling, .. } = combination.estimator else {
            panic!("another estimator: {combination:?}");
        };
        assert_eq!(settling, Settling::GRADED);
    }

    #[test]
    fn the_defaults_that_the_schema_tells_are_those_of_the_methods() {
        let mut told = defaults::<LatticeScene>();
        assert!(!told.is_empty());
        told.insert("reach".to_owned(), 5.into());
        let told: LatticeScene = serde_json::from_value(told.into()).unwrap();
        let method = Method::FlowMapFit;
        assert_eq!(told.method::<2>(method), Method::Custom(method.combination_in(2)));
        assert_eq!(told.method::<5>(method), Method::Custom(method.combination_in(5)));
    }
}
