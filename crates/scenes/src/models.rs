//! Ablation study: a scene without each of its ingredients.
//!
//! A scene kind lists the ingredients that can be left out. The scene runs with and without each, and all quantities
//! are compared.

pub mod edit;
mod ingredient;

pub use self::ingredient::Ingredient;
use crate::ladder::{Answer, BuiltIn, LadderError, Limits, Outcome, Trial, climb, try_scene};

/// Effect of leaving out an ingredient.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// A quantity changes by more than the tolerance and by more than both errors.
    Needed(Change),
    /// No quantity changes by more than the tolerance including errors, or all are identical.
    NotNeeded(Change),
    /// The change is within the errors, and the errors exceed the tolerance.
    Undecided(Change),
    /// The scene without the ingredient does not run.
    Fails {
        /// Error text.
        reason: String,
    },
}

/// The quantity with the largest change.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Description of the quantity.
    pub quantity: String,
    /// Change over scale.
    pub relative: f64,
    /// Sum of the errors of both runs, over scale.
    pub error: f64,
    /// CPU time without the ingredient, over that with it.
    pub cost_ratio: f64,
}

/// A scene and the effects of its ingredients.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Method and size of the runs.
    pub base: String,
    /// CPU time of the full scene (s).
    pub cost: f64,
    /// Effect of each ingredient, by name.
    pub effects: Vec<(String, Effect)>,
}

/// Runs a built-in scene by its own method with and without each ingredient.
///
/// The size is the largest that costs no more than `budget` (CPU s).
///
/// # Errors
/// [`LadderError`]. A scene whose own method has no result has no study.
pub fn study(
    scene: &BuiltIn,
    budget: f64,
    tolerance: f64,
    mut tell: impl FnMut(&str),
) -> Result<Option<Study>, LadderError> {
    let limits = Limits { budget, longest: None };
    let trials = climb(scene.kind, &scene.file, &scene.ladder, 0, limits, |method, rung| {
        tell(&method.at(&rung.label));
    })?;
    let base = trials.iter().rev().find_map(|trial| Some((trial, trial.answer()?)));
    let Some((Trial { rung, .. }, answer)) = base else { return Ok(None) };
    let mut effects = Vec::new();
    for ingredient in (scene.kind.ingredients)(&rung.trial) {
        tell(&format!("without {}", ingredient.name));
        let outcome = try_scene(scene.kind, &scene.file, &ingredient.scene, None)?;
        effects.push((ingredient.name.clone(), effect(answer, &outcome, &ingredient, tolerance)));
    }
    let base = scene.ladder.methods[0].at(&rung.label);
    Ok(Some(Study { base, cost: answer.cpu_seconds, effects }))
}

fn effect(with: &Answer, without: &Outcome, ingredient: &Ingredient, tolerance: f64) -> Effect {
    let without = match without {
        Outcome::Answered(answer) => answer,
        Outcome::Failed { reason, .. } => return Effect::Fails { reason: reason.clone() },
    };
    let cost_ratio = without.cpu_seconds / with.cpu_seconds;
    let change = |quantity: &crate::ladder::Quantity| {
        let id = id_without(&quantity.id, ingredient.states_lost)?;
        let other = without.get(&id)?;
        let error = quantity.error.unwrap_or(0.0) + other.error.unwrap_or(0.0);
        // A quantity with an error as large as its scale is not compared.
        (quantity.scale > 0.0 && quantity.error.unwrap_or(0.0) < quantity.scale).then(|| Change {
            quantity: quantity.words.clone(),
            relative: (other.value - quantity.value).abs() / quantity.scale,
            error: error / quantity.scale,
            cost_ratio,
        })
    };
    let changes: Vec<Change> = with.quantities.iter().filter_map(change).collect();
    let largest =
        |of: fn(&Change) -> f64| changes.iter().max_by(|a, b| of(a).total_cmp(&of(b))).cloned();
    let Some(seen) = largest(|change| change.relative - change.error) else {
        return Effect::Fails { reason: "no quantity is left to compare".to_owned() };
    };
    if changes.iter().all(|change| change.relative == 0.0) {
        // Both runs are identical, and so are their errors.
        return Effect::NotNeeded(Change { error: 0.0, ..seen });
    }
    if seen.relative - seen.error > tolerance {
        return Effect::Needed(seen);
    }
    match largest(|change| change.relative + change.error) {
        Some(bound) if bound.relative + bound.error > tolerance => Effect::Undecided(bound),
        Some(bound) => Effect::NotNeeded(bound),
        None => Effect::NotNeeded(seen),
    }
}

/// The id of the same quantity with fewer states; none for a moment of a removed state.
fn id_without(id: &str, states_lost: usize) -> Option<String> {
    let Some(powers) = id.strip_prefix("moment/").filter(|_| states_lost > 0) else {
        return Some(id.to_owned());
    };
    let powers: Vec<&str> = powers.split('-').collect();
    let (kept, lost) = powers.split_at(powers.len().checked_sub(states_lost)?);
    lost.iter().all(|power| *power == "0").then(|| format!("moment/{}", kept.join("-")))
}

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;
    use crate::ladder::Quantity;

    fn answer(values: &[(&str, f64, f64)]) -> Answer {
        let quantity = |&(id, value, error): &(&str, f64, f64)| Quantity {
            id: id.into(),
            words: id.into(),
            value,
            error: Some(error),
            scale: value.abs(),
        };
        Answer { cpu_seconds: 2.0, quantities: values.iter().map(quantity).collect() }
    }

    fn effect_of(
        with: &[(&str, f64, f64)],
        without: &[(&str, f64, f64)],
        states_lost: usize,
    ) -> Effect {
        let ingredient = Ingredient { name: "it".into(), scene: Map::new(), states_lost };
        effect(&answer(with), &Outcome::Answered(answer(without)), &ingredient, 0.01)
    }

    #[test]
    fn a_change_beyond_errors_and_tolerance_is_needed_and_one_within_is_not() {
        let with = [("a", 1.0, 0.001), ("b", 2.0, 0.001)];
        assert!(matches!(
            effect_of(&with, &[("a", 1.001, 0.001), ("b", 2.1, 0.001)], 0),
            Effect::Needed(Change { quantity, .. }) if quantity == "b"
        ));
        let without = [("a", 1.001, 0.001), ("b", 2.002, 0.001)];
        assert!(matches!(effect_of(&with, &without, 0), Effect::NotNeeded(_)));
        let rough = [("a", 1.001, 0.1), ("b", 2.002, 0.001)];
        assert!(matches!(effect_of(&with, &rough, 0), Effect::Undecided(_)));
        let same = [("a", 1.0, 0.1), ("b", 2.0, 0.1)];
        assert!(matches!(
            effect_of(&same, &same, 0),
            Effect::NotNeeded(Change { error, .. }) if error.abs() < f64::EPSILON
        ));
    }

    #[test]
    fn moments_of_lost_states_are_not_compared_and_others_found_by_their_first_powers() {
        let with = [("moment/2-0-0", 1.0, 0.0), ("moment/0-0-2", 5.0, 0.0)];
        let found = effect_of(&with, &[("moment/2-0", 1.0, 0.0)], 1);
        assert!(
            matches!(found, Effect::NotNeeded(Change { quantity, .. }) if quantity == "moment/2-0-0")
        );
        assert!(matches!(
            effect_of(&with[1..], &[("moment/2-0", 1.0, 0.0)], 1),
            Effect::Fails { .. }
        ));
    }
}
