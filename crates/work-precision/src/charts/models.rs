//! Ablation pages: which ingredients of the built-in scenes affect their results.

use std::fmt::Write as _;

use result_figures::number::{percent, short};
use result_figures::{Drawing, markdown};
use scenes::ladder::BuiltIn;
use scenes::machine::{Machine, commit, commit_words};
use scenes::models::{Change, Effect, Study, study};
use serde::Serialize;

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const FPK: ChartKind = ChartKind {
    name: "fpk",
    title: "dampers, hysteresis, filters, modulating functions, remeshing: which ingredients each scene needs",
    draw: |context| page(context, "fpk", "fpk-sph"),
};

pub(crate) const SMPM: ChartKind = ChartKind {
    name: "smpm",
    title: "random parameters, strengths, shape functions, viscosity: which ingredients each scene needs",
    draw: |context| page(context, "smpm", "smpm"),
};

pub(crate) const PERIDYN: ChartKind = ChartKind {
    name: "peridyn",
    title: "random fields, holes, corrections, noise: which ingredients each scene needs",
    draw: |context| page(context, "peridyn", "peridyn-sde"),
};

/// Change of every quantity below which an ingredient is not needed.
const TOLERANCE: f64 = 0.01;

/// Largest cost of a run with all ingredients (CPU s).
const fn budget(profile: Profile) -> f64 {
    match profile {
        Profile::Quick => 0.3,
        Profile::Default => 6.0,
        Profile::Full => 60.0,
    }
}

/// Ingredients kept although no requested quantity needs them, with the reason.
const KEPT: [(&str, &str, &str); 7] = [
    ("smpm/contact_explosion", "the limit of tension of water", TENSION),
    ("smpm/plate_impact", "the randomness of steel.equation.gruneisen", EXACT),
    ("smpm/plate_impact", "the randomness of steel.equation.gruneisen_slope", EXACT),
    (
        "smpm/plate_impact",
        "the second transfer of momentum",
        "one scheme serves all scenes, and others need it",
    ),
    ("smpm/contact_explosion_thick", "the randomness of steel.equation.gruneisen", SOURCE),
    ("smpm/contact_explosion_thick", "the randomness of steel.equation.gruneisen_slope", SOURCE),
    ("smpm/contact_explosion_thick", "the limit of tension of water", TENSION),
];
const TENSION: &str = "it costs nothing, and water in tension at a later time needs it";
const EXACT: &str = "the exact result does not depend on it, and `verify smpm/plate-impact` claims this for the methods";
const SOURCE: &str = "the first example of the source varies these together";

/// Data of a page.
#[derive(Serialize)]
struct Row {
    scene: String,
    run: String,
    ingredient: String,
    verdict: String,
    quantity: Option<String>,
    change: Option<f64>,
    error: Option<f64>,
    cost_ratio: Option<f64>,
}

fn page(context: &Context<'_>, folder: &str, solver: &str) -> Result<Vec<Drawing>, CaseError> {
    let (mut rows, mut text) = (Vec::new(), head(solver));
    for scene in
        BuiltIn::all(scenes::ALL, &reference_problems::record::workspace().join("tests/scenes"))?
    {
        if scene.name.split('/').next() != Some(folder) {
            continue;
        }
        context.progress(&scene.name);
        let tell = |what: &str| context.progress(&format!("  {what}"));
        let Some(study) = study(&scene, budget(context.profile), TOLERANCE, tell) else {
            let _ = writeln!(
                text,
                "\n## {}\n\nNo run of its own method ended in an answer.",
                scene.name
            );
            continue;
        };
        text.push_str(&section(&scene.name, &study));
        rows.extend(study.effects.iter().map(|effect| row(&scene.name, &study.base, effect)));
    }
    let _ =
        writeln!(text, "\n{}, {}.", Machine::read().hardware(), commit_words(commit().as_deref()));
    Ok(vec![Drawing::page(&format!("{folder}-models"), text, &rows)?])
}

fn head(solver: &str) -> String {
    format!(
        "# What the scenes of {solver} need\n\nWritten by `cargo xtask chart --ladder`. Each built-in scene is run by its own method, at the \
         largest size within the budget of the run, with and without each ingredient. An ingredient is needed if a quantity at the \
         last time changes by more than {} % beyond the errors of both runs; it is not needed if every change stays below that, \
         errors included, or if the runs agree in every digit; otherwise the result is undecided. A change is printed without an error if the runs estimate none. If the scene without the ingredient fails, the table has the error text. Cost is the ratio of the run without the ingredient to the run with it.\n",
        100.0 * TOLERANCE
    )
}

fn section(name: &str, study: &Study) -> String {
    let mut section = format!(
        "\n## {name}\n\n{}: {} s of CPU.\n\n",
        markdown::text(&study.base),
        short(Some(study.cost))
    );
    if study.effects.is_empty() {
        section.push_str("Nothing can be left out of it.\n");
        return section;
    }
    let heads = ["without", "is", "largest change", "in", "cost"].map(str::to_owned);
    let rows: Vec<Vec<String>> =
        study.effects.iter().map(|(ingredient, effect)| cells(name, ingredient, effect)).collect();
    section.push_str(&markdown::table(&heads, &rows));
    section
}

fn cells(scene: &str, ingredient: &str, effect: &Effect) -> Vec<String> {
    let (verdict, change) = match effect {
        Effect::Needed(change) => ("needed".to_owned(), change),
        Effect::NotNeeded(change) => (not_needed(scene, ingredient), change),
        Effect::Undecided(change) => ("undecided".to_owned(), change),
        Effect::Fails { reason } => {
            let reason = reason.lines().next().unwrap_or_default();
            let cells = [ingredient, "the run failed", "", reason, ""];
            return cells.map(markdown::text).to_vec();
        }
    };
    let Change { quantity, relative, error, cost_ratio } = change;
    let size = if *error > 0.0 {
        format!("{} ± {}", percent(*relative), percent(*error))
    } else {
        percent(*relative)
    };
    let cells = [ingredient, &verdict, &size, quantity, &short(Some(*cost_ratio))];
    cells.map(markdown::text).to_vec()
}

fn not_needed(scene: &str, ingredient: &str) -> String {
    let kept = KEPT.iter().find(|(other, name, _)| *other == scene && *name == ingredient);
    kept.map_or_else(|| "NOT NEEDED".to_owned(), |(_, _, why)| format!("not needed; kept: {why}"))
}

fn row(scene: &str, run: &str, (ingredient, effect): &(String, Effect)) -> Row {
    let (verdict, change) = match effect {
        Effect::Needed(change) => ("needed".to_owned(), Some(change)),
        Effect::NotNeeded(change) => (not_needed(scene, ingredient), Some(change)),
        Effect::Undecided(change) => ("undecided".to_owned(), Some(change)),
        Effect::Fails { reason } => (format!("the run fails: {reason}"), None),
    };
    Row {
        scene: scene.to_owned(),
        run: run.to_owned(),
        ingredient: ingredient.clone(),
        verdict,
        quantity: change.map(|change| change.quantity.clone()),
        change: change.map(|change| change.relative),
        error: change.map(|change| change.error),
        cost_ratio: change.map(|change| change.cost_ratio),
    }
}
