//! Damage of the kept realisations at some times: how their cracks grew.

use peridyn_sde::FinalState;
use result_pages::Motion;
use scene_runs::kind::RunError;

use crate::constraints::LoadEnd;
use crate::scene::CrackScene;
use crate::scene_problem::CrackProblem;

/// Largest number of times.
const MOST: usize = 24;
/// Start, first and last failure of a bond, and end.
const LEAST: usize = 4;

/// Damage at the nodes at some times.
pub(super) struct Growth {
    /// From the start to the end: times (s), or under a quasi-static load mean strains or displacements (m).
    pub(super) times: Vec<f64>,
    /// What these are: symbol and unit.
    pub(super) axis: (&'static str, &'static str),
    /// Values by realisation and time, in the order of the realisations that were given.
    pub(super) damage: Vec<Vec<Vec<f64>>>,
}

impl Growth {
    /// Follows these realisations, at fewer times the more there are.
    pub(super) fn of(
        scene: &CrackScene,
        problem: &CrackProblem,
        states: &[&FinalState],
    ) -> Result<Self, RunError> {
        let study = problem.study(scene);
        let bytes = study.bonds.n_nodes() * states.len();
        // Half of what the fields of a page may take; the map and the strengths are in the other half.
        let n = (Motion::BUDGET / 2 / bytes.max(1)).clamp(LEAST, MOST);
        let n_steps = study.n_steps();
        let steps = steps(states, n_steps, n);
        let damage = states.iter().map(|state| {
            steps.iter().map(|&step| state.damage_at(study.bonds, step)).collect::<Result<_, _>>()
        });
        let (axis, end) = axis(problem);
        let times = steps.iter().map(|&step| end * (step as f64 / n_steps as f64)).collect();
        Ok(Self {
            times,
            axis,
            damage: damage.collect::<Result<_, _>>().map_err(RunError::solver)?,
        })
    }
}

/// Along what cracks grow: symbol, unit, and its value at the end of a run.
pub(super) fn axis(problem: &CrackProblem) -> ((&'static str, &'static str), f64) {
    match (problem.resolved.duration, problem.load_end) {
        (Some(duration), _) => (("t", "s"), duration),
        (None, LoadEnd::Strain(strain)) => (("mean strain", ""), strain),
        (None, LoadEnd::Displacement(u)) => (("u", "m"), u),
    }
}

/// The start, the end, and in equal distances the steps between the first and the last in which a bond of any of these broke.
fn steps(states: &[&FinalState], n_steps: u64, n: usize) -> Vec<u64> {
    let broken =
        states.iter().flat_map(|state| &state.history).map(|at| at.step).filter(|&it| it > 0);
    let mut steps = vec![0, n_steps];
    if let Some((first, last)) = broken.clone().min().zip(broken.max()) {
        let between = n as u64 - 2;
        let at = |k: u64| first + (last - first) * k / (between - 1).max(1);
        steps.extend((0..between).map(at));
    }
    steps.sort_unstable();
    steps.dedup();
    steps
}

#[cfg(test)]
mod tests {
    use peridyn_sde::BrokenInStep;

    use super::*;

    #[test]
    fn steps_are_closest_where_bonds_break_and_each_comes_once() {
        let state = |steps: &[u64]| FinalState {
            realisation: 0,
            displacements: Vec::new(),
            damage: Vec::new(),
            history: steps.iter().map(|&step| BrokenInStep { step, bond: 0 }).collect(),
            strength: None,
        };
        let [early, late, never] = [[0, 40, 60], [0, 50, 100], [0, 0, 0]].map(|it| state(&it));
        assert_eq!(steps(&[&early, &late], 1000, 6), [0, 40, 60, 80, 100, 1000]);
        assert_eq!(steps(&[&early], 60, 4), [0, 40, 60]);
        assert_eq!(steps(&[&never], 60, 4), [0, 60]);
    }
}
