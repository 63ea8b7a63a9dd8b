//! Recorded schemas checked against scenes by an external validator: built-in scenes fit, invalid ones do not.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use jsonschema::Validator;
use serde_json::{Map, Value, json};

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The JSON files of a folder and of those in it.
fn read_all(folder: &Path) -> Result<Vec<(String, Value)>, Box<dyn std::error::Error>> {
    let (mut folders, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "json") {
                let value = serde_json::from_str(&fs::read_to_string(&path)?)?;
                found.push((path.display().to_string(), value));
            }
        }
    }
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    Ok(found)
}

/// The recorded schemas, by solver.
fn schemas() -> Result<BTreeMap<String, Value>, Box<dyn std::error::Error>> {
    let all = read_all(&root().join("docs/schema"))?;
    let named = all.into_iter().map(|(path, schema)| {
        let solver = schema["properties"]["solver"]["const"].as_str();
        let solver = solver.ok_or_else(|| format!("{path} names no solver"))?.to_owned();
        Ok((solver, schema))
    });
    named.collect()
}

/// Every built-in scene, with the validator of its solver.
struct BuiltIn {
    path: String,
    scene: Value,
    solver: String,
}

fn built_in() -> Result<Vec<BuiltIn>, Box<dyn std::error::Error>> {
    let folders = ["tests/scenes", "tests/ensembles"].map(|folder| read_all(&root().join(folder)));
    let mut all = Vec::new();
    for folder in folders {
        for (path, scene) in folder? {
            let solver = scene["solver"].as_str().unwrap_or_default().to_owned();
            all.push(BuiltIn { path, scene, solver });
        }
    }
    Ok(all)
}

fn validators() -> Result<BTreeMap<String, Validator>, Box<dyn std::error::Error>> {
    let mut all = BTreeMap::new();
    for (solver, schema) in schemas()? {
        all.insert(solver, jsonschema::validator_for(&schema)?);
    }
    Ok(all)
}

#[test]
fn every_built_in_scene_fits_the_schema_of_its_solver_and_of_no_other() -> Outcome {
    let (validators, scenes) = (validators()?, built_in()?);
    let count = |solver: &str| scenes.iter().filter(|it| it.solver == solver).count();
    assert!(validators.len() >= 3 && validators.keys().all(|solver| count(solver) >= 1));
    for BuiltIn { path, scene, solver } in &scenes {
        for (of, validator) in &validators {
            let errors: Vec<String> = validator
                .iter_errors(scene)
                .map(|error| format!("{}: {error}", error.instance_path()))
                .collect();
            assert_eq!(errors.is_empty(), of == solver, "{path} by {of}: {errors:?}");
        }
    }
    Ok(())
}

/// Every schema inside a schema with the keyword `key`, with its value; property names do not count.
fn saying<'a>(schema: &'a Value, key: &str, found: &mut Vec<(&'a Map<String, Value>, &'a Value)>) {
    match schema {
        Value::Object(object) => {
            found.extend(object.get(key).map(|said| (object, said)));
            for (name, inner) in object {
                match (name.as_str(), inner) {
                    ("properties" | "$defs", Value::Object(named)) => {
                        named.values().for_each(|inner| saying(inner, key, found));
                    }
                    ("default" | "examples" | "const" | "enum", _) => {}
                    _ => saying(inner, key, found),
                }
            }
        }
        Value::Array(array) => array.iter().for_each(|inner| saying(inner, key, found)),
        _ => {}
    }
}

#[test]
fn every_example_and_default_of_a_schema_fits_where_it_stands() -> Outcome {
    for (solver, schema) in schemas()? {
        let (mut examples, mut defaults) = (Vec::new(), Vec::new());
        saying(&schema, "examples", &mut examples);
        saying(&schema, "default", &mut defaults);
        let listed = examples.iter().filter_map(|(of, said)| Some((*of, said.as_array()?)));
        let told: Vec<_> = listed
            .flat_map(|(of, said)| said.iter().map(move |example| (of, example)))
            .chain(defaults.into_iter().filter(|(_, default)| !default.is_null()))
            .collect();
        assert!(told.len() > 5, "{solver} has {} defaults", told.len());
        for (of, value) in told {
            let mut alone = of.clone();
            alone.insert("$defs".to_owned(), schema["$defs"].clone());
            let validator = jsonschema::validator_for(&Value::Object(alone))?;
            let error = validator.iter_errors(value).next().map(|error| error.to_string());
            assert_eq!(error, None, "{solver}: {value}");
        }
    }
    Ok(())
}

/// The JSON pointers of all values inside of a value.
fn pointers(value: &Value, path: &str, found: &mut Vec<String>) {
    found.push(path.to_owned());
    match value {
        Value::Object(object) => {
            object.iter().for_each(|(key, inner)| pointers(inner, &format!("{path}/{key}"), found));
        }
        Value::Array(array) => {
            let inner = array.iter().enumerate();
            inner.for_each(|(i, inner)| pointers(inner, &format!("{path}/{i}"), found));
        }
        _ => {}
    }
}

/// A scene with another value at a JSON pointer.
fn with(scene: &Value, pointer: &str, other: Value) -> Value {
    let mut changed = scene.clone();
    if let Some(place) = changed.pointer_mut(pointer) {
        *place = other;
    }
    changed
}

/// Every built-in scene with one value made invalid, in every applicable way, must be rejected.
///
/// At least `at_least` such changes exist.
fn are_refused(at_least: usize, wrong: impl Fn(&str, &Value) -> Vec<Value>) -> Outcome {
    let validators = validators()?;
    let mut n_tried = 0;
    for BuiltIn { path, scene, solver } in built_in()? {
        let mut places = Vec::new();
        pointers(&scene, "", &mut places);
        for pointer in places {
            for other in wrong(&pointer, &scene.pointer(&pointer).cloned().unwrap_or_default()) {
                let wrong = with(&scene, &pointer, other.clone());
                assert!(!validators[&solver].is_valid(&wrong), "{path}: {other} at {pointer}");
                n_tried += 1;
            }
        }
    }
    assert!(n_tried >= at_least, "{n_tried}");
    Ok(())
}

#[test]
fn a_key_that_there_is_not_and_one_that_is_misspelt_are_refused_wherever_they_stand() -> Outcome {
    are_refused(200, |pointer, value| {
        let Some(object) = value.as_object() else { return vec![] };
        let mut more = object.clone();
        more.insert("no_such_key".to_owned(), Value::Null);
        // Materials and levels have user-defined names.
        let is_free = ["/materials", "/levels"].contains(&pointer);
        let keys = object.keys().filter(|_| !is_free);
        let misspelt = keys.map(|key| {
            let spelt = |it: &String| if it == key { format!("{it}_") } else { it.clone() };
            object.iter().map(|(it, value)| (spelt(it), value.clone())).collect()
        });
        misspelt.chain([more]).map(Value::Object).collect()
    })
}

#[test]
fn a_value_of_another_type_is_refused_wherever_it_stands() -> Outcome {
    are_refused(1000, |_, value| match value {
        Value::Number(_) => vec![json!("1"), json!(true)],
        Value::String(_) => vec![json!(1), json!(["a"])],
        Value::Bool(_) => vec![json!(1), json!("true")],
        Value::Array(_) => vec![json!({ "0": 1 }), json!("[1]")],
        _ => vec![json!(1), json!([{}])],
    })
}

#[test]
fn what_must_be_whole_must_not_be_negative_either() -> Outcome {
    let validators = validators()?;
    let mut n_whole = 0;
    for BuiltIn { path, scene, solver } in built_in()? {
        let mut places = Vec::new();
        pointers(&scene, "", &mut places);
        let is_taken =
            |pointer: &str, it: Value| validators[&solver].is_valid(&with(&scene, pointer, it));
        for pointer in places.iter().filter(|it| scene.pointer(it).is_some_and(Value::is_number)) {
            if !is_taken(pointer, json!(0.5)) {
                assert!(is_taken(pointer, json!(1)), "{path}: 1 at {pointer}");
                assert!(!is_taken(pointer, json!(-1)), "{path}: -1 at {pointer}");
                n_whole += 1;
            }
        }
    }
    assert!(n_whole > 50, "{n_whole}");
    Ok(())
}

#[test]
fn a_count_below_its_range_or_with_a_fraction_and_too_short_a_list_are_refused() -> Outcome {
    let validators = validators()?;
    let scenes = built_in()?;
    let find = |name: &str| scenes.iter().find(|it| it.path.ends_with(name)).ok_or(name.to_owned());
    for (name, pointer, others) in [
        ("smpm/plate_impact.json", "/dimension", [json!(-1), json!(1.5)]),
        ("smpm/plate_impact.json", "/grid/particles_per_cell", [json!(-2), json!(2.5)]),
        ("smpm/plate_impact.json", "/times/2", [json!([7]), json!([6, 7, 8])]),
        ("smpm/contact_explosion.json", "/random/0/law", [json!("gaussian"), json!("Normal")]),
        ("ensembles/damper.json", "/method/monte_carlo/paths", [json!(-1), json!(0.5)]),
        ("peridyn/notched_plate_ensemble.json", "/ensemble/realisations", [json!(-1), json!(2.5)]),
        ("peridyn/notched_plate_ensemble.json", "/time/steps", [json!(-600), json!(0.1)]),
    ] {
        let BuiltIn { scene, solver, .. } = find(name)?;
        assert!(scene.pointer(pointer).is_some(), "{name} has no {pointer}");
        for other in others {
            let wrong = with(scene, pointer, other.clone());
            assert!(!validators[solver].is_valid(&wrong), "{name}: {other} at {pointer}");
        }
    }
    Ok(())
}
