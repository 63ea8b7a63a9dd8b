//! The paper's method: derivatives of the material's formulas at the local state of the reference run.

use perturbation_moments::{Jet, LANES, Scalar};

use super::experiment::Experiment;
use super::series::Series;
use super::study::{Study, unit};
use crate::error::Error;
use crate::record::gathered::Reader;
use crate::record::observation::{Located, Quantity};
use crate::simulation::Simulation;
use constitutive_models::tensor::Symmetric;
use constitutive_models::{LocalFlow, LocalState};

/// Which of the formulas of Chen et al. (2019).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrozenForm {
    /// As printed: no second derivatives of the flow stress (eq 34-35 have zeros where `n` and `m` have some). Eq 30 for the
    /// variance of every component of the deviator, $\operatorname{D} S_{ij} = \tfrac23 (3G/(3G + H))^2
    /// \operatorname{D} \sigma_y$.
    Printed,
    /// With the second derivatives, and the deviator in proportion to the flow stress, $S_{ij} \propto \sigma_y$: with
    /// equation 30 put right for the flow stress at the end of the step, $\operatorname{D} S_{ij} = (S_{ij}/\sigma_y)^2
    /// \operatorname{D} \sigma_y$. The state is still taken for certain.
    Corrected,
}

/// Reads a run in numbers through the formulas of materials in jets.
struct FrozenReader<'a, const D: usize> {
    form: FrozenForm,
    of_jets: &'a Simulation<Jet, D>,
}

fn has_form(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::Pressure | Quantity::FlowStress | Quantity::Stress(..) | Quantity::Deviator(..)
    )
}

impl<const D: usize> FrozenReader<'_, D> {
    fn flow(&self, flow: &LocalFlow<Jet>) -> Jet {
        match self.form {
            FrozenForm::Corrected => flow.stress,
            FrozenForm::Printed => Jet { second: [0.0; LANES], ..flow.stress },
        }
    }

    /// `S_ij`: random where the particle yields.
    fn deviator(
        &self,
        (stress, state): (&Symmetric<f64>, &LocalState),
        flow: Option<&LocalFlow<Jet>>,
        (i, j): (usize, usize),
    ) -> Jet {
        let value = stress.deviator().matrix()[i][j];
        let Some(flow) = flow.filter(|_| state.observed.overshoot > 0.0) else {
            return Jet::constant(value);
        };
        let surface = flow.stress.value;
        match self.form {
            FrozenForm::Corrected => self.flow(flow) * (value / surface),
            FrozenForm::Printed => {
                let elastic = 3.0 * flow.shear_modulus;
                let share = elastic / (elastic + flow.hardening_modulus);
                (self.flow(flow) - surface) * (share * (2.0_f64 / 3.0).sqrt()) + value
            }
        }
    }
}

impl<const D: usize> Reader<f64, Jet, D> for FrozenReader<'_, D> {
    fn read(&self, run: &Simulation<f64, D>, gauge: &Located, quantity: Quantity) -> Jet {
        let (body, formulas) = (&run.bodies()[gauge.body], &self.of_jets.bodies()[gauge.body]);
        gauge.mean_over(|particle| {
            let state = body.local_state(particle);
            // A material without formulas was refused before.
            let Some(local) = formulas.at_local_state(&state) else {
                return Jet::constant(f64::NAN);
            };
            let flow = local.flow.as_ref();
            let stress = body.stress(particle);
            match quantity {
                Quantity::Pressure => local.pressure,
                Quantity::FlowStress => flow.map_or(Jet::constant(0.0), |flow| self.flow(flow)),
                Quantity::Deviator(i, j) => self.deviator((&stress, &state), flow, (i, j)),
                Quantity::Stress(i, j) => {
                    let deviator = self.deviator((&stress, &state), flow, (i, j));
                    if i == j { deviator - local.pressure } else { deviator }
                }
                _ => Jet::constant(0.0),
            }
        })
    }
}

impl<X: Experiment<D>, const D: usize> Study<'_, X, D> {
    /// Taylor series by the derivatives of the material's formulas at the local state of the reference run: the method of Chen et
    /// al. (2019), eq 25-35, at the cost of one run in numbers. `None` for a quantity of which the paper has no formula: there are
    /// some for pressure, flow stress and the components of stress and deviator.
    ///
    /// A **baseline**. The state depends on the parameters too, and that is left out: behind a plate impact the variance of the
    /// pressure is 4 to 5 times too large, behind an explosion in contact 97 times, at any coefficient of variation.
    ///
    /// # Errors
    /// [`Error::NoLocalFormulas`] for a gauge in a material that has none; those of the run.
    pub fn frozen(&self, form: FrozenForm) -> Result<Vec<Option<Series>>, Error> {
        let (n, all) = (self.inputs.n_random(), self.n_normals());
        let mut passes = Vec::new();
        for pass in 0..n.div_ceil(LANES).max(1) {
            let directions: Vec<Vec<f64>> =
                (LANES * pass..n.min(LANES * (pass + 1))).map(|k| unit(all, k)).collect();
            let of_jets = self.experiment.simulation(&self.inputs.jets(&directions))?;
            let mut run = self.simulation_at(&vec![0.0; all])?;
            for gauge in &self.runs.plan.gauges {
                let formulas = run.bodies().get(gauge.body).zip(of_jets.bodies().get(gauge.body));
                if formulas.is_some_and(|(b, f)| f.at_local_state(&b.local_state(0)).is_none()) {
                    return Err(Error::NoLocalFormulas { name: gauge.name.clone() });
                }
            }
            let reader = FrozenReader { form, of_jets: &of_jets };
            let name = format!("{form:?} local formulas {pass}").to_lowercase();
            passes.push(self.runs.follow(name, &mut run, &reader, ())?.0);
        }
        let keep = |(response, series)| {
            let (_, quantity, _) = self.runs.plan.parts(response);
            has_form(self.runs.plan.quantities[quantity]).then_some(series)
        };
        Ok(self.series(&passes, 0)?.into_iter().enumerate().map(keep).collect())
    }
}
