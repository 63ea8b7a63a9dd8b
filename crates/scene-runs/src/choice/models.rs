//! Ablation study: a scene without each of its ingredients.
//!
//! A scene kind lists the ingredients that can be left out. The scene runs with and without each, and all quantities
//! are compared.

pub mod edit;
mod ingredient;

pub use self::ingredient::Ingredient;
use crate::answers::{Answer, Answers};
use crate::ladder::{BuiltIn, Limits, Outcome, Trial, climb, try_scene};

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
/// The size is the largest that costs no more than `budget` (CPU s). A scene whose own method has no answers has no study.
pub fn study(
    scene: &BuiltIn,
    budget: f64,
    tolerance: f64,
    mut tell: impl FnMut(&str),
) -> Option<Study> {
    let limits = Limits { budget, longest: None };
    let trials = climb(scene.kind, &scene.file, &scene.ladder, 0, limits, |method, rung| {
        tell(&method.at(&rung.label));
    });
    let base = trials.iter().rev().find_map(|trial| Some((trial, trial.answers()?)));
    let (Trial { rung, .. }, answers) = base?;
    let mut effects = Vec::new();
    for ingredient in (scene.kind.ingredients)(&rung.trial) {
        tell(&format!("without {}", ingredient.name));
        let outcome = try_scene(scene.kind, &scene.file, &ingredient.scene, None);
        effects.push((ingredient.name.clone(), effect(answers, &outcome, &ingredient, tolerance)));
    }
    let base = scene.ladder.methods[0].at(&rung.label);
    Some(Study { base, cost: answers.cpu_seconds, effects })
}

fn effect(with: &Answers, without: &Outcome, ingredient: &Ingredient, tolerance: f64) -> Effect {
    let without = match without {
        Outcome::Answered(answers) => answers,
        Outcome::Failed { reason, .. } => return Effect::Fails { reason: reason.clone() },
    };
    let cost_ratio = without.cpu_seconds / with.cpu_seconds;
    let change = |answer: &Answer| {
        let renamed = ingredient.renamed.iter().find(|(id, _)| *id == answer.id);
        let id = renamed.map_or(Some(&answer.id), |(_, id)| id.as_ref())?;
        let other = without.get(id)?;
        let (own, scale) = (answer.margin().unwrap_or(0.0), answer.scale);
        let error = own + other.margin().unwrap_or(0.0);
        // A quantity with an error as large as its scale is not compared.
        (scale > 0.0 && own < scale).then(|| Change {
            quantity: answer.words.clone(),
            relative: (other.last.number.value - answer.last.number.value).abs() / scale,
            error: error / scale,
            cost_ratio,
        })
    };
    let changes: Vec<Change> = with.compared().filter_map(change).collect();
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

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;
    use crate::answers::{AnswerValue, ErrorOrigin, Number, Statistic};

    fn answers(values: &[(&str, f64, f64)]) -> Answers {
        let answer = |&(id, value, error): &(&str, f64, f64)| {
            let number = Number { value, error: Some(error), error_kind: ErrorOrigin::Bound };
            let (id, last) = (id.to_owned(), AnswerValue::of(number));
            Answer::new(id.clone(), id, Statistic::Mean, last)
        };
        Answers { cpu_seconds: 2.0, list: values.iter().map(answer).collect() }
    }

    fn effect_of(with: &[(&str, f64, f64)], without: &[(&str, f64, f64)]) -> Effect {
        let lost = |id: &str| (id.to_owned(), None);
        let renamed = vec![("m/2-0".to_owned(), Some("m/2".to_owned())), lost("m/0-2")];
        let ingredient = Ingredient { name: "it".into(), scene: Map::new(), renamed };
        effect(&answers(with), &Outcome::Answered(answers(without)), &ingredient, 0.01)
    }

    #[test]
    fn a_change_beyond_errors_and_tolerance_is_needed_and_one_within_is_not() {
        let with = [("a", 1.0, 0.001), ("b", 2.0, 0.001)];
        assert!(matches!(
            effect_of(&with, &[("a", 1.001, 0.001), ("b", 2.1, 0.001)]),
            Effect::Needed(Change { quantity, .. }) if quantity == "b"
        ));
        let without = [("a", 1.001, 0.001), ("b", 2.002, 0.001)];
        assert!(matches!(effect_of(&with, &without), Effect::NotNeeded(_)));
        let rough = [("a", 1.001, 0.1), ("b", 2.002, 0.001)];
        assert!(matches!(effect_of(&with, &rough), Effect::Undecided(_)));
        let same = [("a", 1.0, 0.1), ("b", 2.0, 0.1)];
        assert!(matches!(
            effect_of(&same, &same),
            Effect::NotNeeded(Change { error, .. }) if error.abs() < f64::EPSILON
        ));
    }

    #[test]
    fn quantities_of_lost_states_are_not_compared_and_others_found_by_their_new_ids() {
        let with = [("m/2-0", 1.0, 0.0), ("m/0-2", 5.0, 0.0)];
        let found = effect_of(&with, &[("m/2", 1.0, 0.0), ("m/0-2", 9.0, 0.0)]);
        assert!(matches!(found, Effect::NotNeeded(Change { quantity, .. }) if quantity == "m/2-0"));
        assert!(matches!(effect_of(&with[1..], &[("m/2", 1.0, 0.0)]), Effect::Fails { .. }));
    }
}
