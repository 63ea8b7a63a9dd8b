//! Random fields of a scene on its particles.

use perturbation_moments::Scalar;
use random_fields::{CorrelationFunction, Error, Marginal, RandomField};
use scene_runs::scene::Objection;
use smpm::{Fill, Number};

use super::coordinates::point;
use super::material_scene::{MaterialPart, MaterialScene};
use super::method_scene::MethodScene;
use super::random_field_scene::{RandomFieldScene, TermsScene};
use super::region::BodyRegion;
use super::scene::SmpmScene;

/// Where the chance that a normal is farther is 1e-6, as for random parameters.
const FARTHEST: f64 = 4.891_638_475_698_59;
/// Points along a correlation length by which a field is expanded.
const POINTS_OF_LENGTH: f64 = 4.0;
/// Points for each term that is asked for.
const POINTS_OF_TERM: f64 = 4.0;
/// Fewest points along an axis.
const FEWEST_POINTS: f64 = 8.0;
/// Most points of a field.
const MOST_POINTS: f64 = 1e4;
/// Most terms of all fields of a scene.
const MOST_TERMS: usize = 2000;

/// The name of a material, and keys of some of its constants.
type Constants = (String, Vec<(MaterialPart, &'static str)>);

/// A random field with its modes at the particles.
#[derive(Debug)]
pub(super) struct PreparedField {
    /// The name of its material.
    pub(super) material: String,
    /// Keys of the constants.
    pub(super) keys: Vec<(MaterialPart, &'static str)>,
    /// Words of the constants.
    pub(super) parameters: Vec<String>,
    /// Distribution of the factor, of mean 1.
    marginal: Marginal,
    /// Number of its first coefficient.
    first: usize,
    pub(super) n_terms: usize,
    /// By body, then particle, then term; empty for bodies of other materials. The sum of squares is one at each particle.
    modes: Vec<Vec<f64>>,
    /// Variance of the normal field that the terms leave out, before they are scaled to unit variance: mean over the box, and
    /// the largest at a particle.
    pub(super) left_out: [f64; 2],
}

impl PreparedField {
    /// The factors at all particles of a body, by the coefficients of all fields; none for a body of another material.
    ///
    /// Value and both derivatives of the translation at the normal of the particle: exact for jets.
    pub(super) fn factors<S: Number>(&self, body: usize, coefficients: &[S]) -> Vec<S> {
        let own = &coefficients[self.first..self.first + self.n_terms];
        let factor = |modes: &[f64]| {
            let zero = <S as Scalar>::constant(0.0);
            let normal = own.iter().zip(modes).fold(zero, |sum, (&xi, &mode)| sum + xi * mode);
            let z = normal.value();
            let value = self.marginal.at(z);
            if S::DERIVATIVES == 0 {
                return <S as Scalar>::constant(value);
            }
            let step = normal - <S as Scalar>::constant(z);
            let (slope, curvature) = (self.marginal.derivative(z), curvature(&self.marginal, z));
            step * slope + step * step * (0.5 * curvature) + value
        };
        self.modes[body].chunks_exact(self.n_terms).map(factor).collect()
    }
}

/// The second derivative of a translation, by differences of fourth order of the first: to about 1e-9 of it.
fn curvature(marginal: &Marginal, z: f64) -> f64 {
    const H: f64 = 0.01;
    let across =
        |steps: f64| marginal.derivative(z + steps * H) - marginal.derivative(z - steps * H);
    (8.0 * across(1.0) - across(2.0)) / (12.0 * H)
}

impl SmpmScene {
    /// The constants of each random field: material and keys.
    pub(super) fn field_parameters(&self) -> Result<Vec<Constants>, Objection> {
        let numbers = self.numbers()?;
        let mut seen: Vec<&String> = Vec::new();
        let mut all = Vec::new();
        for (i, field) in self.random_fields.iter().enumerate() {
            let path = format!("random_fields[{i}].parameters");
            let (mut material, mut keys) = (None, Vec::new());
            for (k, parameter) in field.parameters.iter().enumerate() {
                let path = format!("{path}[{k}]");
                let (name, rest) = parameter.split_once('.').unwrap_or((parameter, ""));
                let Some(of_material) = numbers.get(name) else {
                    return Err(Objection::unknown(&path, "material", name, self.materials.keys()));
                };
                let key = MaterialScene::parameter(of_material, rest, &path)?;
                let mean = of_material[&key];
                if mean.is_nan() || mean <= 0.0 {
                    let message = format!(
                        "`{parameter}` is {mean}; a constant that varies must be greater than 0"
                    );
                    return Err(Objection::new(path, message));
                }
                if seen.contains(&parameter) {
                    return Err(Objection::new(path, format!("`{parameter}` is given twice")));
                }
                if *material.get_or_insert(name) != name {
                    let message = "the constants of a field belong to one material";
                    return Err(Objection::new(path, message).with_help("add another field"));
                }
                seen.push(parameter);
                keys.push(key);
            }
            let Some(material) = material else {
                return Err(Objection::new(path, "a random field needs a constant at least"));
            };
            let of = |part, name| numbers[material][&(part, name)];
            let model = self.materials[material].model::<f64>(&of);
            if model.is_ok_and(|model| !model.can_vary()) {
                let message = "the constants of this material cannot vary in space";
                return Err(Objection::new(path, message).with_help(
                    "they can of `elastic_bulk` with `elastic`, and of `mie_gruneisen` with `von_mises` or `johnson_cook` without damage",
                ));
            }
            if self.bodies.iter().all(|body| body.material != material) {
                return Err(Objection::new(path, format!("no body is made of `{material}`")));
            }
            all.push((material.to_owned(), keys));
        }
        Ok(all)
    }

    /// Rejects random parameters beside random fields, and methods that there are not for fields.
    pub(super) fn check_field_method(&self) -> Result<(), Objection> {
        if self.random_fields.is_empty() {
            return Ok(());
        }
        if !self.random.is_empty() {
            let message = "a scene has `random` parameters or `random_fields`, not both";
            let help = "a field whose correlation lengths are many sizes of the body is one random parameter";
            return Err(Objection::new("random_fields", message).with_help(help));
        }
        if self.has_for_fields(self.method) {
            return Ok(());
        }
        let message = "this method does not go with `random_fields`";
        let help = "take `monte_carlo`, `multilevel`, `forward_difference`, `finite_difference`, `propagated` or `deterministic`";
        Err(Objection::new("method", message).with_help(help))
    }

    /// Whether a method is one for random fields.
    pub(super) const fn has_for_fields(&self, method: MethodScene) -> bool {
        self.random_fields.is_empty()
            || matches!(
                method,
                MethodScene::Deterministic
                    | MethodScene::MonteCarlo { .. }
                    | MethodScene::Multilevel(_)
                    | MethodScene::ForwardDifference { .. }
                    | MethodScene::FiniteDifference { .. }
                    | MethodScene::Propagated
            )
    }

    /// Checks the fields without expanding them: constants, distributions, lengths, and the material at either end of each
    /// distribution.
    pub(super) fn check_fields<const D: usize>(&self) -> Result<(), Objection> {
        let numbers = self.numbers()?;
        for (i, (material, keys)) in self.field_parameters()?.iter().enumerate() {
            let (scene, path) = (&self.random_fields[i], format!("random_fields[{i}]"));
            let marginal = marginal_of(scene, &path)?;
            lengths_of::<D>(scene, &path)?;
            let numbers = &numbers[material.as_str()];
            for z in [-FARTHEST, FARTHEST] {
                let of = |part, name| {
                    let key = (part, name);
                    numbers[&key] * if keys.contains(&key) { marginal.at(z) } else { 1.0 }
                };
                self.materials[material].model::<f64>(&of).map_err(|error| {
                    let message = format!("at {z} deviations of the field: {error}");
                    Objection::new(format!("{path}.marginal"), message)
                })?;
            }
        }
        Ok(())
    }

    /// The box of some bodies, as the scene has it: the same on every grid.
    fn bounds<const D: usize>(
        &self,
        is_own: &dyn Fn(usize) -> bool,
    ) -> Result<[[f64; D]; 2], Objection> {
        let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for (i, body) in self.bodies.iter().enumerate().filter(|(i, _)| is_own(*i)) {
            let (from, to) = BodyRegion::<D>::of(body, &format!("bodies[{i}]"))?.bounds();
            for k in 0..D {
                (low[k], high[k]) = (low[k].min(from[k]), high[k].max(to[k]));
            }
        }
        Ok([low, high])
    }

    /// The random fields on the particles of all bodies.
    ///
    /// # Errors
    /// An [`Objection`] to a constant, distribution, correlation or number of terms.
    pub(super) fn prepared_fields<const D: usize>(
        &self,
        fills: &[Fill<D>],
    ) -> Result<Vec<PreparedField>, Objection> {
        let (mut first, mut all) = (0, Vec::new());
        for (i, (material, keys)) in self.field_parameters()?.into_iter().enumerate() {
            let (scene, path) = (&self.random_fields[i], format!("random_fields[{i}]"));
            let marginal = marginal_of(scene, &path)?;
            let is_own = |body: usize| self.bodies[body].material == material;
            let corners = self.bounds::<D>(&is_own)?;
            let field = expand(scene, corners, &path)?;
            let n_terms = field.n_terms();
            if first + n_terms > MOST_TERMS {
                let n = first + n_terms;
                let message = format!("{n} terms of all fields; a scene may have {MOST_TERMS}");
                return Err(Objection::new(format!("{path}.terms"), message));
            }
            let mut largest = 0.0_f64;
            let at = |(body, fill): (usize, &Fill<D>)| -> Result<Vec<f64>, Error> {
                let places = if is_own(body) { fill.positions.as_slice() } else { &[] };
                let mut modes = vec![0.0; places.len() * n_terms];
                field.modes(places, &mut modes)?;
                for of_particle in modes.chunks_exact_mut(n_terms) {
                    largest = largest.max(1.0 - scale_to_unit_variance(of_particle));
                }
                Ok(modes)
            };
            let modes = fills.iter().enumerate().map(at).collect::<Result<_, _>>();
            let modes = modes.map_err(|error: Error| Objection::new(&path, error.to_string()))?;
            let left_out = [field.mean_left_out_variance(), largest];
            let parameters = scene.parameters.clone();
            all.push(PreparedField {
                material,
                keys,
                parameters,
                marginal,
                first,
                n_terms,
                modes,
                left_out,
            });
            first += n_terms;
        }
        Ok(all)
    }
}

/// The distribution of the factor of a field.
fn marginal_of(scene: &RandomFieldScene, path: &str) -> Result<Marginal, Objection> {
    let (marginal, key) = scene.marginal.factor();
    marginal.map_err(|error| {
        let path = format!("{path}.marginal.{key}.coefficient_of_variation");
        Objection::new(path, error.to_string())
    })
}

/// The correlation lengths of a field, one for each axis.
fn lengths_of<const D: usize>(scene: &RandomFieldScene, path: &str) -> Result<[f64; D], Objection> {
    let path = format!("{path}.correlation.lengths");
    let lengths = point(&scene.correlation.lengths, &path)?;
    match scene.correlation.between(lengths).check() {
        Ok(()) => Ok(lengths),
        Err(error) => Err(Objection::new(path, error.to_string())),
    }
}

/// Scales the modes at a point so that their squares sum to one; the sum before.
fn scale_to_unit_variance(modes: &mut [f64]) -> f64 {
    let square: f64 = modes.iter().map(|mode| mode * mode).sum();
    let scale = 1.0 / square.sqrt();
    for mode in modes.iter_mut() {
        *mode *= scale;
    }
    square
}

/// The expansion of a field over a box: by eigenfunctions where they are known, else by a lattice of points that follows from the
/// correlation lengths alone, so that a realisation is the same on every grid.
fn expand<const D: usize>(
    scene: &RandomFieldScene,
    [low, high]: [[f64; D]; 2],
    path: &str,
) -> Result<RandomField<D>, Objection> {
    let at = format!("{path}.correlation.lengths");
    let lengths = lengths_of::<D>(scene, path)?;
    let correlation = scene.correlation.between(lengths);
    let (truncation, key) = scene.terms.truncation();
    let refused = |error: Error| {
        let place = match error {
            Error::LengthBeyondBody { .. } => at.clone(),
            Error::NotPositive { .. }
            | Error::OutOfRange { .. }
            | Error::TooFewPoints { .. }
            | Error::TooManyTerms { .. } => {
                format!("{path}.terms.{key}")
            }
            _ => path.to_owned(),
        };
        Objection::new(place, error.to_string())
    };
    let is_product = D == 1 || scene.correlation.separable;
    if is_product && scene.correlation.function.function() == CorrelationFunction::Exponential {
        return RandomField::on_box([low, high], correlation, truncation).map_err(refused);
    }
    let fewest =
        |k: usize| ((high[k] - low[k]) * POINTS_OF_LENGTH / lengths[k]).ceil().max(FEWEST_POINTS);
    let asked = match scene.terms {
        TermsScene::Number(terms) => POINTS_OF_TERM * terms as f64,
        TermsScene::ShareOfVariance(_) => 0.0,
    };
    let value: f64 = (0..D).map(fewest).product();
    let finer = (asked / value).max(1.0).powf(1.0 / D as f64);
    let along = |k: usize| (fewest(k) * finer).ceil();
    let value: f64 = (0..D).map(along).product();
    if value > MOST_POINTS {
        let message = format!(
            "the correlation lengths {lengths:?} need {value:e} points, {POINTS_OF_LENGTH} a length; at most {MOST_POINTS:e} are possible"
        );
        return Err(Objection::new(at, message).with_help("take longer correlation lengths"));
    }
    let spacing = std::array::from_fn(|k| (high[k] - low[k]) / along(k));
    let lattice = Fill::of(spacing, (low, high), |_| true);
    let lattice = lattice.map_err(|error| Objection::new(&at, error.to_string()))?;
    RandomField::on_points(&lattice.positions, correlation, truncation).map_err(refused)
}
