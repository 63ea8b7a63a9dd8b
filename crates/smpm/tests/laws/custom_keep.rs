//! A keeper as a user would write it, and studies interrupted at each save: their results are bitwise identical.

use std::collections::BTreeMap;
use std::error::Error as StdError;
use std::sync::Mutex;

use perturbation_moments::RandomVector;
use smpm::material::{
    JohnsonCook, JohnsonCookParameters, MieGruneisen, MieGruneisenParameters, Solid, Units, library,
};
use smpm::uncertainty::{Experiment, FrozenForm, Keep, SavedRun, Study, exactly};
use smpm::{
    Body, BoundaryKind, Config, Error, Fill, Gauge, Number, Place, Plan, Quantity, Simulation,
    Window,
};

use crate::fixtures::wall;

/// Keeps in memory; all is over when it has kept so often.
#[derive(Debug)]
struct Mortal {
    kept: Mutex<BTreeMap<String, SavedRun>>,
    /// How often it was asked and has kept, in this life.
    done: Mutex<[usize; 2]>,
    /// Asks between two standings, and standings of a life.
    limits: [usize; 2],
}

impl Mortal {
    fn new(asks: usize, life: usize) -> Self {
        let (kept, done) = (Mutex::default(), Mutex::default());
        Self { kept, done, limits: [asks, life] }
    }

    fn immortal() -> Self {
        Self::new(usize::MAX, usize::MAX)
    }

    fn kept(&self) -> BTreeMap<String, SavedRun> {
        self.kept.lock().unwrap().clone()
    }

    fn is_dead(&self) -> bool {
        self.done.lock().unwrap()[1] >= self.limits[1]
    }
}

impl Keep for Mortal {
    fn load(&self, run: &str) -> Result<Option<SavedRun>, Box<dyn StdError + Send + Sync>> {
        Ok(self.kept.lock().unwrap().get(run).cloned())
    }

    fn is_due(&self, _: &str, done: f64) -> bool {
        assert!((0.0..1.0).contains(&done), "{done}");
        let mut done = self.done.lock().unwrap();
        done[0] += 1;
        done[0].is_multiple_of(self.limits[0])
    }

    fn keep(&self, run: &str, standing: SavedRun) -> Result<(), Box<dyn StdError + Send + Sync>> {
        if !self.is_dead() {
            self.kept.lock().unwrap().insert(run.to_owned(), standing);
            self.done.lock().unwrap()[1] += 1;
        }
        if self.is_dead() { Err("killed".into()) } else { Ok(()) }
    }
}

/// A plate of steel that yields at a wall, with nine random parameters: two runs with derivatives. Centimetres, grams, microseconds.
#[derive(Debug)]
struct Yielding;

impl Experiment<1> for Yielding {
    fn simulation<S: Number>(&self, x: &[S]) -> Result<Simulation<S, 1>, Error> {
        let [sound_speed, s1, gruneisen, gruneisen_slope, a, b, n, c, m] = exactly(x)?;
        let constant = |_: &'static str, value| S::constant(value);
        let equation = library::steel_equation(Units::CM_G_US).map(constant);
        let equation =
            MieGruneisenParameters { sound_speed, s1, gruneisen, gruneisen_slope, ..equation };
        let strength = library::steel_strength(Units::CM_G_US).map(constant);
        let strength = JohnsonCookParameters { a, b, n, c, m, ..strength };
        let steel =
            Solid { equation: MieGruneisen::new(equation)?, strength: JohnsonCook::new(strength)? };
        let config =
            Config { boundaries: vec![wall(BoundaryKind::Symmetry)], ..Config::with_cell(0.1) };
        let fill = Fill::of([0.05], ([0.0], [3.0]), |_| true)?;
        Simulation::new(config, vec![Body::new(steel, &fill, [-0.05])?])
    }
}

fn inputs() -> RandomVector<9> {
    let equation = library::steel_equation(Units::CM_G_US);
    let strength = library::steel_strength(Units::CM_G_US);
    let mean = [
        equation.sound_speed,
        equation.s1,
        equation.gruneisen,
        equation.gruneisen_slope,
        strength.a,
        strength.b,
        strength.n,
        strength.c,
        strength.m,
    ];
    RandomVector::independent(mean, mean.map(|mean| 0.03 * mean)).unwrap()
}

fn at(time: f64) -> Window {
    Window::at(time)
}

fn over(from: f64, to: f64) -> Window {
    Window { from, to }
}

/// Instants and spans that overlap, the first at the start.
fn windows() -> Vec<Window> {
    vec![at(0.0), at(1.0), over(0.0, 2.0), over(1.0, 3.0), at(3.0)]
}

fn plan(windows: Vec<Window>) -> Plan<1> {
    let gauge = |name: &str, place| Gauge { name: name.to_owned(), body: 0, place };
    Plan {
        gauges: vec![
            gauge("near", Place::Nearest([0.4])),
            gauge("inside", Place::Region { from: [0.2], to: [1.5] }),
        ],
        quantities: vec![Quantity::Pressure, Quantity::FlowStress, Quantity::Velocity(0)],
        windows,
    }
}

type Method<'a, R> = &'a dyn Fn(&Study<'_, Yielding, 1>) -> Result<R, Error>;

fn run<R>(method: Method<'_, R>, windows: Vec<Window>, keep: &Mortal) -> Result<R, Error> {
    method(&Study::kept_by(&Yielding, inputs(), plan(windows), keep)?)
}

/// A method undisturbed, and in as many lives as it takes.
fn comes_to_the_same<R: PartialEq + std::fmt::Debug>(method: Method<'_, R>) {
    let undisturbed = method(&Study::new(&Yielding, inputs(), plan(windows())).unwrap()).unwrap();
    for (asks, life) in [(7, 1), (5, 3)] {
        let mut keep = Mortal::new(asks, life);
        let mut n_lives = 1;
        let result = loop {
            match run(method, windows(), &keep) {
                Ok(result) => break result,
                Err(error) => assert!(matches!(error, Error::NotKept { .. }), "{error}"),
            }
            assert!(keep.is_dead());
            n_lives += 1;
            keep.done = Mutex::default();
        };
        assert!(n_lives > 2, "{n_lives} lives");
        assert_eq!(result, undisturbed);
        // Everything is known now: nothing is run and nothing is kept.
        keep.limits = [usize::MAX, 0];
        assert_eq!(run(method, windows(), &keep).unwrap(), undisturbed);
    }
}

#[test]
fn a_study_that_is_killed_goes_on_to_the_same_bits_by_every_method() {
    comes_to_the_same(&|study| {
        let balance = study.balance().to_vec();
        // Zero, both ends of windows, in the order of time.
        assert_eq!(balance.iter().map(|at| at.time).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
        Ok((study.centre().to_vec(), study.schedule().clone(), balance))
    });
    comes_to_the_same(&|study| study.propagated());
    comes_to_the_same(&|study| study.finite_difference(0.1));
    comes_to_the_same(&|study| study.forward_difference(0.1));
    comes_to_the_same(&|study| study.sigma_points());
    comes_to_the_same(&|study| study.frozen(FrozenForm::Printed));
    comes_to_the_same(&|study| study.frozen(FrozenForm::Corrected));
}

#[test]
fn what_is_shown_of_a_run_in_several_lives_is_all_of_it() {
    let seen = Mutex::new(vec![]);
    let look = |time: f64, simulation: &Simulation<f64, 1>| {
        seen.lock().unwrap().push((time, simulation.bodies()[0].velocities().to_vec()));
    };
    let method = |study: &Study<'_, Yielding, 1>| study.run_seen(&[0.0; 9], look);
    method(&Study::new(&Yielding, inputs(), plan(windows())).unwrap()).unwrap();
    let whole = std::mem::take(&mut *seen.lock().unwrap());
    assert_eq!(whole.iter().map(|(time, _)| *time).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    let mut keep = Mortal::new(7, 1);
    while run(&method, windows(), &keep).is_err() {
        keep.done = Mutex::default();
    }
    // What came after the last standing of a life is shown again.
    let mut again = seen.into_inner().unwrap();
    again.dedup();
    assert_eq!(again, whole);
}

#[test]
fn a_longer_plan_goes_on_from_a_shorter_one_and_a_shorter_one_is_the_begin_of_a_longer_one() {
    let longer = || [windows(), vec![over(3.0, 4.0), at(3.5), at(4.0)]].concat();
    let methods: [Method<'_, _>; 2] =
        [&|study| Ok((study.propagated()?, study.schedule().clone())), &|study| {
            Ok((study.propagated_seen(|_, _| ())?, study.schedule().clone()))
        }];
    let keep = Mortal::immortal();
    let short = run(methods[0], windows(), &keep).unwrap();
    let of_short = keep.kept();
    let long = run(methods[0], longer(), &keep).unwrap();
    let of_long = keep.kept();
    assert!(of_short != of_long && of_short.len() == 3);
    assert_eq!(long, run(methods[0], longer(), &Mortal::immortal()).unwrap());
    assert_eq!(short, run(methods[1], windows(), &keep).unwrap());
    assert!(keep.kept() == of_long);
}

#[test]
fn standings_that_do_not_fit_are_refused_by_what_does_not() {
    let keep = Mortal::immortal();
    let centre: Method<'_, _> = &|study| Ok(study.centre().to_vec());
    run(centre, windows(), &keep).unwrap();
    for (others, value) in [
        // Another stop before the end, one that is missing, and a window that has begun.
        (vec![at(1.0), at(2.5), at(3.0)], 3),
        (vec![at(1.0), at(3.0)], 2),
        ([windows(), vec![over(2.0, 4.0)]].concat(), 4),
        ([windows(), vec![at(2.0)]].concat(), 3),
    ] {
        let error = run(centre, others, &keep).unwrap_err();
        assert_eq!(error, Error::OtherWindows { value, limit: 3 });
    }
    let mut fewer = plan(windows());
    fewer.gauges.pop();
    let error = Study::kept_by(&Yielding, inputs(), fewer, &keep).unwrap_err();
    let quantity = "numbers of a window";
    // Beside the responses a balance of fourteen numbers.
    assert_eq!(error, Error::ForeignSnapshot { quantity, found: 20, expected: 17 });
    // What one run has come to is not where another is.
    let mean_run = keep.kept().remove("reference run").unwrap();
    keep.kept.lock().unwrap().insert("run with derivatives 0".to_owned(), mean_run);
    let error = run(&|study| study.propagated(), windows(), &keep).unwrap_err();
    assert!(matches!(error, Error::ForeignSnapshot { .. }), "{error}");
}

/// Every number and every list of a standing that is under way, one after the other, made something else.
#[cfg(feature = "serde")]
#[test]
fn a_forged_standing_goes_on_or_is_refused() {
    use serde_json::{Value, json};

    fn paths(value: &Value, path: &str, found: &mut Vec<String>) {
        if path.starts_with("/snapshot/") {
            return;
        }
        found.push(path.to_owned());
        let members: Vec<(String, &Value)> = match value {
            Value::Object(object) => object.iter().map(|(key, of)| (key.clone(), of)).collect(),
            Value::Array(array) => {
                array.iter().enumerate().map(|(i, of)| (i.to_string(), of)).collect()
            }
            _ => vec![],
        };
        for (key, member) in members {
            paths(member, &format!("{path}/{key}"), found);
        }
    }

    let keep = Mortal::new(23, 1);
    let centre: Method<'_, _> = &|study| Ok(study.centre().to_vec());
    run(centre, windows(), &keep).unwrap_err();
    let standing = serde_json::to_value(&keep.kept()["reference run"]).unwrap();
    assert!(standing["steps"] != json!([]) && standing["taken"] != json!([]));
    let mut places = vec![];
    paths(&standing, "", &mut places);
    let (mut n_refused, mut n_accepted) = (0, 0);
    for place in &places {
        for forgery in
            [json!(1e300), json!(-1.0), json!(0.0), json!([]), json!([[1.0]]), json!([0.5])]
        {
            let mut forged = standing.clone();
            *forged.pointer_mut(place).unwrap() = forgery;
            let Ok(forged) = serde_json::from_value::<SavedRun>(forged) else { continue };
            let keep = Mortal::immortal();
            keep.kept.lock().unwrap().insert("reference run".to_owned(), forged);
            match run(centre, windows(), &keep) {
                Ok(_) => n_accepted += 1,
                Err(_) => n_refused += 1,
            }
        }
    }
    // A sum may be any number; lists, steps and windows may not.
    assert!(n_refused > 20 && n_accepted > 20, "{n_refused} {n_accepted}");
}

/// The first window ends before the first step, when nothing is random yet.
#[test]
fn a_window_that_has_ended_hears_of_no_later_step() {
    let study = Study::new(&Yielding, inputs(), plan(windows())).unwrap();
    let switches = study.propagated().unwrap().switches;
    let n_windows = windows().len();
    assert!(switches.len().is_multiple_of(n_windows));
    for of_quantity in switches.chunks(n_windows) {
        assert!(of_quantity[0].at_end.is_infinite() && of_quantity[0].so_far.is_infinite());
        for later in &of_quantity[1..] {
            assert!(later.so_far.is_finite() && later.so_far <= later.at_end, "{later:?}");
        }
    }
}
