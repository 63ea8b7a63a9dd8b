//! The cases of the table, and their responses.

use perturbation_moments::{Expansion, RandomVector, Response, Scalar};
use serde_json::Value;

use crate::responses::{JohnsonCook, MieGruneisen, MieGruneisenState};

/// One response at one state with one distribution of its inputs.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) sigma: Vec<f64>,
    pub(crate) data: Value,
}

/// All of the file.
pub(crate) fn table() -> Vec<Case> {
    let text = include_str!(
        "../../../../tests/reference/derived/perturbation-moments/perturbation_moments.json"
    );
    let mut file: Value = serde_json::from_str(text).unwrap();
    let cases = std::mem::take(file["cases"].as_array_mut().unwrap());
    let case = |data: Value| Case {
        name: data["name"].as_str().unwrap().to_owned(),
        sigma: flat(&data["sigma"]),
        data,
    };
    cases.into_iter().map(case).collect()
}

/// The numbers of nested lists in their order.
pub(crate) fn flat(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(flat).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

/// Something to do with a response of any number of inputs.
pub(crate) trait Visitor {
    type Output;

    /// `closed` are the derivatives in closed form, where there are any.
    fn visit<const N: usize>(
        &mut self,
        inputs: &RandomVector<N>,
        response: &(impl Response<N> + Sync),
        closed: Option<Expansion<N>>,
    ) -> Self::Output;
}

impl Case {
    /// The true variance, where quadrature settles to 1e-6 between two node counts.
    pub(crate) fn variance(&self) -> Option<f64> {
        let quadrature = &self.data["quadrature"];
        let is_settled = quadrature["rel_change"][1].as_f64().unwrap() < 1e-6;
        is_settled.then(|| quadrature["var"].as_f64().unwrap())
    }

    fn inputs<const N: usize>(&self) -> RandomVector<N> {
        let row = |values: &[f64]| -> [f64; N] { values.try_into().unwrap() };
        let correlation = flat(&self.data["corr"]);
        let correlation = std::array::from_fn(|i| row(&correlation[i * N..(i + 1) * N]));
        RandomVector::new(row(&flat(&self.data["mean"])), row(&self.sigma), correlation).unwrap()
    }

    pub(crate) fn visit<V: Visitor>(&self, visitor: &mut V) -> V::Output {
        let state = |key: &str| self.data["state"][key].as_f64().unwrap();
        match self.name.split('_').next().unwrap() {
            "linear3" => visitor.visit(&self.inputs::<3>(), &Linear, None),
            "product2" => visitor.visit(&self.inputs::<2>(), &Product, None),
            "exp2" => visitor.visit(&self.inputs::<2>(), &Exponential, None),
            "cantilever" => visitor.visit(&self.inputs::<4>(), &Cantilever, None),
            "ishigami" => visitor.visit(&self.inputs::<3>(), &Ishigami, None),
            "sdof" => visitor.visit(&self.inputs::<3>(), &Amplification, None),
            "johnson" => {
                let response = JohnsonCook::new(state("ep"), state("rate"), state("Tstar"));
                let inputs = self.inputs::<5>();
                let closed = response.expansion(inputs.mean());
                visitor.visit(&inputs, &response, Some(closed))
            }
            "mie" => {
                let response = MieGruneisen::new(MieGruneisenState {
                    bulk_modulus: state("rho0") * state("c0") * state("c0"),
                    compression: state("mu"),
                    energy: state("e"),
                });
                let inputs = self.inputs::<3>();
                let [s1, gamma, a] = *inputs.mean();
                let closed = shorten(&response.expansion(&[s1, 0.0, 0.0, gamma, a]));
                visitor.visit(&inputs, &ShortMieGruneisen(response), Some(closed))
            }
            _ => panic!("no response for {}", self.name),
        }
    }
}

/// The derivatives by `S1`, `gamma0` and `a` alone.
fn shorten(all: &Expansion<5>) -> Expansion<3> {
    let places = [0, 3, 4];
    Expansion::from_derivatives(|by| match *by {
        [i] => all.gradient[places[i]],
        [i, j] => all.hessian.unwrap()[places[i]][places[j]],
        [i, j, k] => all.third.unwrap()[places[i]][places[j]][places[k]],
        _ => all.value,
    })
}

/// `3 x1 - 2 x2 + 0.5 x3 + 1`.
struct Linear;

impl Response<3> for Linear {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        x[0] * 3.0 - x[1] * 2.0 + x[2] * 0.5 + 1.0
    }
}

/// `x1 x2`.
struct Product;

impl Response<2> for Product {
    fn value<S: Scalar>(&self, x: &[S; 2]) -> S {
        x[0] * x[1]
    }
}

/// `exp(x1 + x2/2)`.
struct Exponential;

impl Response<2> for Exponential {
    fn value<S: Scalar>(&self, x: &[S; 2]) -> S {
        (x[0] + x[1] * 0.5).exp()
    }
}

/// `F L^3/(3 E J)` by force, modulus, length, inertia.
struct Cantilever;

impl Response<4> for Cantilever {
    fn value<S: Scalar>(&self, x: &[S; 4]) -> S {
        let [force, modulus, length, inertia] = *x;
        force * length.powi(3) / (modulus * inertia * 3.0)
    }
}

/// `sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1` (Ishigami and Homma 1990).
struct Ishigami;

impl Response<3> for Ishigami {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        x[0].sin() + x[1].sin().squared() * 7.0 + x[2].powi(4) * x[0].sin() * 0.1
    }
}

/// `1/sqrt((1 - 90 m/k)^2 + 360 z^2 m/k)` by stiffness, mass, damping ratio.
struct Amplification;

impl Response<3> for Amplification {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        let [stiffness, mass, damping] = *x;
        let ratio = mass / stiffness * 90.0;
        ((-ratio + 1.0).squared() + damping.squared() * ratio * 4.0).sqrt().recip()
    }
}

/// Mie-Gruneisen with `S2 = S3 = 0`, by `S1`, `gamma0`, `a`.
struct ShortMieGruneisen(MieGruneisen);

impl Response<3> for ShortMieGruneisen {
    fn value<S: Scalar>(&self, x: &[S; 3]) -> S {
        self.0.value(&[x[0], S::constant(0.0), S::constant(0.0), x[1], x[2]])
    }
}
