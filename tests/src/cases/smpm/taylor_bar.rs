//! Cylinders that run end on into a rigid wall: recovered bars of copper and steel, and a benchmark of finite elements.

mod bar;
mod reference;

use scenes::smpm::material_scene::{EquationScene, MaterialScene, ParameterScene, StrengthScene};

use self::bar::{Specimen, axisymmetric, quarter};
use self::reference::{Benchmark, Recovered, TaylorTests};
use crate::cases::prelude::*;

const SOURCE: &str = "recovered bars of Johnson and Holmquist 1988, Wilkins and Guinan 1973, House et al. 1995 and Zelepugin et al. 2022, second-hand; constants of MPM3D-F90 and of Johnson and Cook 1983";

pub(crate) const AXISYMMETRIC: Case = Case {
    id: "smpm/taylor-bar/axisymmetric",
    title: "Taylor bar of copper at 190 m/s, axisymmetric: length, foot, bulge",
    source: SOURCE,
    cost: Profile::Quick,
    run: Together(run_axisymmetric),
};

pub(crate) const QUARTER: Case = Case {
    id: "smpm/taylor-bar/quarter",
    title: "The same as a quarter in three dimensions",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(run_quarter),
};

pub(crate) const BENCHMARK: Case = Case {
    id: "smpm/taylor-bar/benchmark",
    title: "Copper bar at 227 m/s with linear hardening, against converged finite elements",
    source: "Foulk et al. 2021, Simo 1992, Zienkiewicz et al. 1998, as collected by Cthonios/Carina.jl",
    cost: Profile::Default,
    run: Together(run_benchmark),
};

pub(crate) const PREDICTED: Case = Case {
    id: "smpm/taylor-bar/predicted",
    title: "Recovered bars of copper and 4340 steel, predicted with constants from elsewhere",
    source: SOURCE,
    cost: Profile::Default,
    run: Together(run_predicted),
};

const SIZES: [(&str, &str); 3] = [
    ("length", "length"),
    ("foot", "diameter of the foot"),
    ("bulge", "diameter a fifth of the first length above the wall"),
];

/// The bar of the scene (mm, km/s, us).
const fn of_scene(cells: u32) -> Specimen {
    Specimen { length: 25.4, radius: 3.8, speed: 0.19, end: 80.0, cells }
}

fn method(cells: u32) -> String {
    format!("quadratic B-splines, FLIP, MUSL, {cells} cells to the radius; wall without friction")
}

const FINE: u32 = 8;

/// The recovered bar of the scene.
fn recovered(tests: &TaylorTests) -> CaseResult<[f64; 3]> {
    let bar = tests.tests.iter().find(|test| test.name == "johnson-cook-190");
    let sizes = bar.and_then(|bar| Some([bar.final_length, bar.foot?, bar.bulge?]));
    Ok(sizes.ok_or("no recovered bar of 190 m/s")?)
}

fn run_axisymmetric(context: &Context<'_>) -> CaseResult {
    let recovered = recovered(&TaylorTests::read()?)?;
    context.progress("8 and 12 cells to the radius");
    let (bar, finer) = (axisymmetric(&of_scene(FINE), None)?, axisymmetric(&of_scene(12), None)?);
    let lines = |method: String| context.lines("", method);
    let mut claims = Vec::new();
    for (k, tolerance) in [0.005, 0.04, 0.03].into_iter().enumerate() {
        let quantity = format!("{} at 80 us", SIZES[k].1);
        let reason =
            "constants of MPM3D-F90; read second-hand to 1 % of a length and 2 % of a diameter";
        let subject = lines(method(FINE)).of(SIZES[k].0, quantity).unit("mm");
        claims.push(subject.relative(bar.sizes[k], recovered[k]).within(tolerance).because(reason));
    }
    let mut change = Worst::of_errors();
    for (k, (_, size)) in SIZES.into_iter().enumerate() {
        change.take(finer.sizes[k] / bar.sizes[k] - 1.0, size);
    }
    let quantity = "relative change of a size";
    let subject = lines(change.method("12 cells to the radius over 8")).of("refined", quantity);
    let claim = subject.bounded(change.value(), 0.015);
    claims.push(claim.because("the rim of the foot is thin, a cell or two"));
    let reason = "FLIP over one to two thousand steps with a free surface";
    let subject = lines(method(FINE)).of("energy", "energy over that of the start");
    claims.push(subject.relative(bar.energy, 1.0).within(2.5e-3).because(reason));
    let quantity = "velocity of the centre of mass at 80 us, over that of impact";
    let reason = "it has come to rest but for elastic waves: the wall does not let go";
    claims.push(lines(method(FINE)).of("rest", quantity).bounded(bar.rest, 0.05).because(reason));
    Ok(claims)
}

fn run_quarter(context: &Context<'_>) -> CaseResult {
    let recovered = recovered(&TaylorTests::read()?)?;
    let resolutions: &[u32] = if context.profile == Profile::Full { &[5, 8] } else { &[5] };
    let mut claims = Vec::new();
    for &cells in resolutions {
        context.progress(&format!("{cells} cells to the radius"));
        let (solid, flat) = (quarter(&of_scene(cells))?, axisymmetric(&of_scene(cells), None)?);
        let (mut apart, mut off) = (Worst::of_errors(), Worst::of_errors());
        for (k, (_, size)) in SIZES.into_iter().enumerate() {
            apart.take(solid.sizes[k] / flat.sizes[k] - 1.0, size);
            off.take(solid.sizes[k] / recovered[k] - 1.0, size);
        }
        let lines = |method: String| context.lines(format!("cells{cells}"), method);
        let quantity = "relative distance of a size from the axisymmetric one";
        let subject = lines(apart.method(&method(cells))).of("axisymmetric", quantity);
        let claim = subject.bounded(apart.value(), 8e-3);
        claims.push(claim.because("here the circle is one of boxes"));
        let quantity = "relative error of a size of the recovered bar";
        let subject = lines(off.method(&method(cells))).of("recovered", quantity);
        let claim = subject.bounded(off.value(), 0.05);
        claims.push(claim.because("five cells to the radius, and constants of MPM3D-F90"));
        let reason = "FLIP over one to two thousand steps with a free surface";
        let subject = lines(method(cells)).of("energy", "energy over that of the start");
        claims.push(subject.relative(solid.energy, 1.0).within(4e-3).because(reason));
    }
    Ok(claims)
}

fn run_benchmark(context: &Context<'_>) -> CaseResult {
    let of = TaylorTests::read()?.benchmark;
    let mut claims = Vec::new();
    for (cells, of_length) in [(8, 5e-3), (12, 4e-3)] {
        context.progress(&format!("{cells} cells to the radius"));
        let bar = axisymmetric(&of.specimen(cells), Some(material_of_benchmark(&of)))?;
        let lines = context.lines(format!("cells{cells}"), method(cells));
        let reason = "published radii are 7.11 to 7.23 mm, lengths 21.42 to 21.48 mm; the rim of the foot is a cell or two thin";
        let subject = lines.of("length", "length at 80 us").unit("mm");
        let compared = subject.relative(bar.sizes[0], of.final_length);
        claims.push(compared.within(of_length).because(reason));
        let subject = lines.of("radius", "radius of the foot at 80 us").unit("mm");
        let compared = subject.relative(0.5 * bar.sizes[1], of.final_radius);
        claims.push(compared.within(0.02).because(reason));
    }
    Ok(claims)
}

/// Whose bars, by which constants, and how far their lengths, feet and bulges are off.
struct Prediction {
    make: &'static str,
    law: Law,
    expected: [Option<Expected>; 3],
}

/// What is expected of the worst of the relative errors.
#[derive(Clone, Copy)]
enum Expected {
    /// The constants predict it this well.
    Within(f64),
    /// They do not: where it was seen.
    Seen(f64, f64),
}

use Expected::{Seen, Within};

const fn predicts(make: &'static str, law: Law, expected: [Option<Expected>; 3]) -> Prediction {
    Prediction { make, law, expected }
}

const GOOD: Option<Expected> = Some(Within(0.1));

const PREDICTIONS: [Prediction; 9] = [
    predicts("johnson-cook", Law::Linear, [Some(Within(0.03)), Some(Seen(0.09, 0.14)), GOOD]),
    predicts(
        "wilkins-guinan",
        Law::Linear,
        [Some(Seen(-0.11, -0.07)), Some(Seen(-0.18, -0.12)), GOOD],
    ),
    predicts("house", Law::Linear, [Some(Seen(-0.19, -0.14)), GOOD, None]),
    predicts("zelepugin", Law::Linear, [Some(Seen(-0.17, -0.11)), GOOD, None]),
    predicts("johnson-cook", Law::JohnsonCook, [GOOD, Some(Seen(0.1, 0.15)), GOOD]),
    predicts("wilkins-guinan", Law::JohnsonCook, [Some(Within(0.05)), GOOD, GOOD]),
    predicts("house", Law::JohnsonCook, [Some(Seen(-0.13, -0.09)), GOOD, None]),
    predicts("zelepugin", Law::JohnsonCook, [GOOD, GOOD, None]),
    predicts("johnson-cook", Law::Steel, [GOOD, GOOD, Some(Within(0.05))]),
];

/// Longer bars of House are left to the full profile: what they say is the same (mm).
const LONGEST: f64 = 40.0;

fn run_predicted(context: &Context<'_>) -> CaseResult {
    let tests = TaylorTests::read()?.tests;
    let mut claims = Vec::new();
    for prediction in &PREDICTIONS {
        let steel = prediction.law == Law::Steel;
        let of = |test: &&Recovered| {
            test.make == prediction.make
                && (test.material == "steel") == steel
                && (test.length < LONGEST || context.profile == Profile::Full)
        };
        claims.extend(predicted(context, prediction, tests.iter().filter(of))?);
    }
    Ok(claims)
}

fn predicted<'a>(
    context: &Context<'_>,
    prediction: &Prediction,
    tests: impl Iterator<Item = &'a Recovered>,
) -> CaseResult {
    let mut worst: [Worst; 3] = std::array::from_fn(|_| Worst::of_errors());
    for test in tests {
        context.progress(&format!("{} by {}", test.name, prediction.law.name()));
        // The longer, the longer it takes; faster ones, too, have come to rest by then.
        let specimen = test.specimen(FINE, 100.0 * test.length / 25.4);
        let bar = axisymmetric(&specimen, Some(prediction.law.material(test.density)))?;
        let sizes = [Some(test.final_length), test.foot, test.bulge];
        for (k, size) in sizes.into_iter().enumerate() {
            if let Some(size) = size {
                worst[k].take(bar.sizes[k] / size - 1.0, &test.name);
            }
        }
    }
    let id = format!("{}/{}", prediction.make, prediction.law.name());
    let claim = |k: usize, expected: Expected| {
        let lines = context.lines(&id, worst[k].method(&method(FINE)));
        let subject = lines.of(SIZES[k].0, format!("relative error of the {}", SIZES[k].1));
        let (compared, reason) = (subject.absolute(worst[k].value(), 0.0), prediction.law.reason());
        match expected {
            Within(tolerance) => compared.within(tolerance).because(reason),
            Seen(from, to) => compared.as_measured(from, to).because(reason),
        }
    };
    let expected = prediction.expected.into_iter().enumerate();
    Ok(expected.filter_map(|(k, expected)| Some(claim(k, expected?))).collect())
}

/// Where the constants of a strength come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Law {
    /// Copper of MPM3D-F90: 157 MPa + 425 MPa times the plastic strain.
    Linear,
    /// Copper of Johnson and Cook 1983.
    JohnsonCook,
    /// 4340 of Johnson and Cook 1983.
    Steel,
}

impl Law {
    const fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear-hardening",
            Self::JohnsonCook => "johnson-cook-1983",
            Self::Steel => "johnson-cook-1983-4340",
        }
    }

    const fn reason(self) -> &'static str {
        match self {
            Self::Linear => {
                "no rate, no heat: one curve for all bars, of a copper that need not be theirs; read to 1 % of a length and 2 % of a diameter"
            }
            Self::JohnsonCook => {
                "constants of tension and torsion tests, not of these bars; read to 1 % of a length and 2 % of a diameter"
            }
            Self::Steel => {
                "constants of tension and torsion tests of a steel of Rockwell C 30; read to 1 % of a length and 2 % of a diameter"
            }
        }
    }

    /// At the density of a bar (kg/m³), which is that of heat, too.
    fn material(self, density: f64) -> MaterialScene {
        let of = |library: &str, names: &[&str]| ParameterScene {
            library: Some(library.to_owned()),
            set: names.iter().map(|&name| (name.to_owned(), 1e-3 * density)).collect(),
        };
        let (metal, strength) = match self {
            Self::Linear => ("copper", StrengthScene::VonMises(of("copper", &[]))),
            Self::JohnsonCook => ("copper", StrengthScene::JohnsonCook(of("copper", &["density"]))),
            Self::Steel => ("steel", StrengthScene::JohnsonCook(of("steel", &["density"]))),
        };
        solid(EquationScene::MieGruneisen(of(metal, &["density"])), strength)
    }
}

fn solid(equation: EquationScene, strength: StrengthScene) -> MaterialScene {
    let strength = Some(strength);
    let (damage, tension_limit, keyword_file, detonation) = (None, None, None, None);
    MaterialScene { equation, strength, damage, tension_limit, keyword_file, detonation }
}

/// The material of the benchmark: its pressure is linear in the volume, `K (1 - J)`.
fn material_of_benchmark(of: &Benchmark) -> MaterialScene {
    let bulk = of.young_modulus / (3.0 * (1.0 - 2.0 * of.poisson_ratio));
    let density = 1e-3 * of.density;
    let parameters = |numbers: &[(&str, f64)]| ParameterScene {
        library: None,
        set: numbers.iter().map(|&(name, value)| (name.to_owned(), value)).collect(),
    };
    let none = ["s1", "s2", "s3", "gruneisen", "gruneisen_slope"].map(|name| (name, 0.0));
    let mut equation = vec![("density", density), ("sound_speed", (bulk / density).sqrt())];
    equation.extend(none);
    solid(
        EquationScene::MieGruneisen(parameters(&equation)),
        StrengthScene::VonMises(parameters(&[
            ("shear_modulus", of.young_modulus / (2.0 * (1.0 + of.poisson_ratio))),
            ("yield_stress", 1e-3 * of.yield_stress),
            ("hardening_modulus", 1e-3 * of.hardening_modulus),
        ])),
    )
}
