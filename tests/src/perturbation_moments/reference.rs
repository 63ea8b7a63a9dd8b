//! The 51 reference cases: derivatives by JAX, moments by OpenTURNS, quadrature and closed forms.

use serde::Deserialize;

use crate::case::CaseError;

/// The file as a whole.
#[derive(Debug, Clone, Deserialize)]
pub struct ReferenceTable {
    /// Where its numbers come from.
    pub origin: String,
    /// The cases.
    pub cases: Vec<ReferenceCase>,
}

/// One response at one state with one law of its inputs.
#[derive(Debug, Clone, Deserialize)]
pub struct ReferenceCase {
    /// As in the file.
    pub name: String,
    /// Means of the inputs.
    pub mean: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Vec<f64>,
    /// Their correlation.
    pub corr: Vec<Vec<f64>>,
    /// What the state of a material is.
    pub state: Option<State>,
    /// The coefficient of variation, where all inputs have one.
    pub cv: Option<f64>,
    /// The response at the means.
    pub value: f64,
    /// Its gradient.
    pub gradient: Vec<f64>,
    /// Its Hessian.
    pub hessian: Vec<Vec<f64>>,
    /// Its third derivatives.
    pub third: Vec<Vec<Vec<f64>>>,
    /// What OpenTURNS says.
    pub openturns: OpenTurns,
    /// Closed moments of the quadratic expansion.
    pub second_order: SecondOrder,
    /// The moments of the response itself.
    pub quadrature: Quadrature,
    /// The same in closed form, where there is one.
    pub exact: Option<Exact>,
}

/// The state of Johnson-Cook or of Mie-Gruneisen.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum State {
    /// Plastic strain, relative rate, homologous temperature.
    JohnsonCook {
        /// Plastic strain.
        ep: f64,
        /// Strain rate (1/s).
        rate: f64,
        /// Homologous temperature.
        #[serde(rename = "Tstar")]
        temperature: f64,
    },
    /// Compression, energy and what is certain of the material.
    MieGruneisen {
        /// Compression.
        mu: f64,
        /// Energy per initial volume (Pa).
        e: f64,
        /// Initial density (kg/m^3).
        rho0: f64,
        /// Bulk sound speed (m/s).
        c0: f64,
    },
}

/// `TaylorExpansionMoments` of OpenTURNS.
#[derive(Debug, Clone, Deserialize)]
pub struct OpenTurns {
    /// First-order mean.
    pub mean1: f64,
    /// Second-order mean.
    pub mean2: f64,
    /// First-order variance.
    pub var1: f64,
    /// Importance factors.
    pub importance: Vec<f64>,
    /// Its gradient, to six digits.
    pub gradient: Vec<f64>,
    /// Its Hessian, to six digits.
    pub hessian: Vec<Vec<f64>>,
}

/// Moments from the derivatives, by formula.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct SecondOrder {
    /// Variance with curvature.
    pub var2: f64,
    /// Third central moment.
    pub third_central: f64,
    /// Fourth cumulant.
    pub kappa4: f64,
    /// Variance to fourth order.
    pub var_o4_with_third_derivs: f64,
}

/// Moments by tensor Gauss-Hermite quadrature.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Quadrature {
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub var: f64,
    /// Relative change of mean and variance between two node counts.
    pub rel_change: [f64; 2],
}

/// Moments in closed form.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Exact {
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub var: f64,
}

impl ReferenceTable {
    /// Reads the file.
    ///
    /// # Errors
    /// Those of the JSON.
    pub fn read() -> Result<Self, CaseError> {
        Ok(serde_json::from_str(include_str!(
            "../../reference/derived/perturbation-moments/perturbation_moments.json"
        ))?)
    }
}

impl ReferenceCase {
    /// The name as words of a claim's id: lower case, no `_` and no `+`.
    #[must_use]
    pub fn id(&self) -> String {
        let word = |c: char| match c {
            '_' => Some('-'),
            '+' => None,
            other => Some(other.to_ascii_lowercase()),
        };
        self.name.chars().filter_map(word).collect::<String>().replace("--", "-minus-")
    }

    /// Whether the quadrature is a variance: it settles to 1e-6 between two node counts.
    #[must_use]
    pub fn has_a_variance(&self) -> bool {
        self.quadrature.rel_change[1] < 1e-6
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_table_holds_51_cases_with_ids_of_their_own() {
        let table = ReferenceTable::read().unwrap();
        assert!(table.origin.contains("JAX"));
        let ids: BTreeSet<String> = table.cases.iter().map(ReferenceCase::id).collect();
        assert_eq!((table.cases.len(), ids.len()), (51, 51));
        // 20 of Johnson-Cook, half of them with a closed form, 20 of Mie-Gruneisen.
        assert_eq!(table.cases.iter().filter(|case| case.exact.is_some()).count(), 10);
        assert_eq!(table.cases.iter().filter(|case| !case.has_a_variance()).count(), 2);
    }
}
