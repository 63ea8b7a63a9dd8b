//! Checks of a crack scene.

use serde_json::Value;

use super::positive::positive;
use super::scene::{CrackScene, NotchScene, PrecisionScene};
use super::scene_body::ToughnessScene;
use super::scene_load::LoadingScene;
use crate::retired::RETIRED;
use scene_runs::scene::{Objection, Retired, Scene, WrongKey, read_keys};

impl Scene for CrackScene {
    type Built = ();
    const RETIRED: &[Retired] = RETIRED;

    fn from_keys(keys: &Value) -> Result<Self, WrongKey> {
        read_keys(keys)
    }

    fn check(&self) -> Result<(), Objection> {
        self.body.check()?;
        positive("material.young_modulus", "Young's modulus", self.material.young_modulus)?;
        self.check_law()?;
        self.check_procedure()?;
        self.check_count()?;
        self.check_notch()?;
        self.check_load()?;
        self.check_output()
    }

    fn seed(&mut self) -> Option<&mut u64> {
        Some(&mut self.ensemble.seed)
    }
}

/// Most nodes of a body.
const MOST_NODES: f64 = 4e6;
/// Bytes of a bond in a list: two nodes, length, factors, state.
const BYTES_OF_A_BOND: f64 = 64.0;

impl CrackScene {
    /// Rejects what a law does not have.
    fn check_law(&self) -> Result<(), Objection> {
        let is_solid = !self.material.law.is_bond_based();
        let softens = matches!(self.material.toughness, ToughnessScene::Softening { .. });
        let softening = "material.toughness.softening";
        if softens && is_solid {
            let message = "bonds of a linear peridynamic solid break at once";
            let help = "use `energy_release_rate`, or the law `bond_based`";
            return Err(Objection::new(softening, message).with_help(help));
        }
        if softens && !self.is_quasi_static() {
            let message = "bonds that soften are followed under a quasi-static load alone";
            let help = "use `dynamics.quasi_static`, or `energy_release_rate`";
            return Err(Objection::new(softening, message).with_help(help));
        }
        if !self.stiffness.is_uniform() && (is_solid || softens) {
            let what = if is_solid { "a linear peridynamic solid" } else { "bonds that soften" };
            let message = format!("the stiffness of {what} is uniform");
            let help = "leave this key out, or use bonds of a pair potential that break at once";
            return Err(Objection::new("stiffness", message).with_help(help));
        }
        Ok(())
    }

    /// Rejects steps in time of a load without time, and a run in time without steps.
    fn check_procedure(&self) -> Result<(), Objection> {
        match (&self.time, self.is_quasi_static()) {
            (Some(_), true) => {
                let message = "a quasi-static load has no steps in time";
                Err(Objection::new("time", message).with_help("leave this key out"))
            }
            (None, false) => {
                let message = "dynamics in time need the key `time`";
                let help = "as in \"time\": { \"step\": { \"z\": 1.6 }, \"steps\": 3000 }";
                Err(Objection::new("dynamics", message).with_help(help))
            }
            (None, true) if self.ensemble.precision == PrecisionScene::F32 => {
                let message = "equilibria are found in double precision";
                Err(Objection::new("ensemble.precision", message).with_help("use \"f64\""))
            }
            _ => Ok(()),
        }
    }

    /// Rejects more nodes than a run holds, with the memory that their bonds would take.
    fn check_count(&self) -> Result<(), Objection> {
        let (body, spacing) = (&self.body, self.body.spacing);
        let nodes = body.size[0] / spacing * (body.size[1] / spacing);
        if nodes <= MOST_NODES {
            return Ok(());
        }
        let reach = self.bonds.horizon.of(spacing)?.radius() / spacing;
        let bonds = 0.5 * std::f64::consts::PI * reach * reach * nodes;
        let message = format!(
            "the body has {nodes:.3e} nodes, whose {bonds:.3e} bonds take about {:.0} GB for each realisation at work; at most {MOST_NODES:e} are allowed",
            bonds * BYTES_OF_A_BOND * 1e-9
        );
        let help = "choose a larger spacing, or a smaller part of the body around the notch";
        Err(Objection::new("body.spacing", message).with_help(help))
    }

    /// Rejects a notch that does not come from an edge or a hole, or whose tip a hole removes.
    fn check_notch(&self) -> Result<(), Objection> {
        let NotchScene { mouth, tip } = self.notch;
        let (size, near) = (self.body.size, 0.5 * self.body.spacing);
        let on_edge = (0..2).any(|k| mouth[k].min(size[k] - mouth[k]).abs() <= near);
        if !on_edge && !self.body.holes.iter().any(|hole| hole.contains(&mouth)) {
            let [x, y] = mouth;
            let message = format!("the mouth of the notch, [{x}, {y}] m, is on no edge");
            let help = format!(
                "it must be at x = 0 or {} m, at y = 0 or {} m, or in a hole: the body is not cut from inside",
                size[0], size[1]
            );
            return Err(Objection::new("notch.mouth", message).with_help(help));
        }
        let hole = self.body.holes.iter().position(|hole| hole.contains(&tip));
        let Some(hole) = hole else { return Ok(()) };
        let message =
            format!("the tip of the notch lies in hole {hole}, so that no crack starts there");
        let help = "end the notch before the hole, or leave out one of the two";
        Err(Objection::new("notch.tip", message).with_help(help))
    }

    /// Rejects a body that is held twice or not at all, and a motion that does not fit.
    fn check_load(&self) -> Result<(), Objection> {
        match (&self.grips, self.supports.is_empty()) {
            (Some(grips), true) => grips.check(&self.body)?,
            (Some(_), false) => {
                let message = "the body is held by `grips` already";
                let objection = Objection::new("supports", message);
                return Err(objection.with_help("leave out one of the two"));
            }
            (None, true) => {
                let help = "add `grips`, or `supports` for a load by `displacement`";
                return Err(Objection::new("loading", "nothing holds the body").with_help(help));
            }
            (None, false) => {}
        }
        for (i, support) in self.supports.iter().enumerate() {
            support.region.check(&format!("supports[{i}]"), support.protected)?;
        }
        let refused = |key: &str, message: &str, help: &str| {
            Err(Objection::new(format!("loading.{key}"), message).with_help(help))
        };
        match (self.loading, self.grips.is_some()) {
            (LoadingScene::Displacement { .. }, true) => refused(
                "displacement",
                "the nodes of a region are displaced, and the body is held by `grips`",
                "use `supports` in place of `grips`, or `stretch`",
            ),
            (LoadingScene::Displacement { region, until, protected }, false) => {
                region.check("loading.displacement", protected)?;
                let largest = until[0].abs().max(until[1].abs());
                positive("loading.displacement.until", "the displacement", largest)
            }
            (LoadingScene::Stretch { .. }, false) => {
                refused("stretch", "it moves `grips`, and there are none", "add `grips`")
            }
            (LoadingScene::Velocity { .. }, false) => {
                refused("velocity", "it moves `grips`, and there are none", "add `grips`")
            }
            (LoadingScene::Velocity { .. }, true) if self.is_quasi_static() => refused(
                "velocity",
                "a quasi-static load has no speed",
                "use `stretch`, whose end is a mean strain",
            ),
            (LoadingScene::Stretch { .. } | LoadingScene::Velocity { .. }, true) => Ok(()),
        }
    }

    fn check_output(&self) -> Result<(), Objection> {
        let n = self.ensemble.realisations;
        if n == 0 {
            let message = "0 realisations; at least 1 is needed";
            return Err(Objection::new("ensemble.realisations", message));
        }
        if let Some(i) = self.output.vtu.iter().position(|&id| id >= n) {
            let (id, last) = (self.output.vtu[i], n - 1);
            let message = format!("there is no realisation {id}: numbers go from 0 to {last}");
            return Err(Objection::new(format!("output.vtu[{i}]"), message));
        }
        let (windows, steps) = (self.output.windows, self.n_steps());
        if steps == 0 {
            return Err(Objection::new("time.steps", "0 steps; at least 1 is needed"));
        }
        if windows == 0 || windows > steps {
            let message = format!("{windows} windows of the load over {steps} steps");
            return Err(Objection::new("output.windows", message));
        }
        let threshold = self.output.damage_threshold;
        if !(threshold > 0.0 && threshold < 1.0) {
            let message =
                format!("the threshold of damage is {threshold}; it must lie between 0 and 1");
            return Err(Objection::new("output.damage_threshold", message));
        }
        let width = self.body.size[0];
        for (i, &x) in self.output.abscissae.iter().enumerate() {
            if !(x > 0.0 && x < width) {
                let message = format!("the abscissa {x} m lies outside the body, 0 to {width} m");
                return Err(Objection::new(format!("output.abscissae[{i}]"), message));
            }
        }
        Ok(())
    }
}
