//! Concrete in bending against experiments: constants from a notched beam, prediction of one without a notch; an L-shaped panel
//! from its given constants.

use serde::Deserialize;

use crate::cases::prelude::*;
use crate::peridyn::concrete::{Concrete, Lattice, Tested, beam, panel};

pub(crate) const CASE: Case = Case {
    id: "peridyn-sde/concrete",
    title: "Three-point bending of concrete beams and an L-shaped panel, bonds that soften, event by event: against experiments",
    source: "Gregoire, Rojas-Solano & Pijaudier-Cabot 2013; Winkler 2001",
    cost: Profile::Default,
    run: Together(run),
};

/// Three shells of 2.5 mm: 20 nodes over the depth of a beam.
const BEAM: Lattice = Lattice { spacing: 0.0025, shells: 3 };
/// The same horizon, half the spacing.
const FINER: Lattice = Lattice { spacing: 0.001_25, shells: 6 };
/// 20 nodes over a limb.
const PANEL: Lattice = Lattice { spacing: 0.0125, shells: 3 };
/// Of the 50 mm beam.
const NOTCH: f64 = 0.025;
/// Openings that are compared (mm): below, the columns are coarser than their error; above, cracks are through.
const OPENINGS: [f64; 2] = [0.004, 0.1];

/// `E` as published, strength and energy fitted to the notched beam alone: of `f_t` from 2 to 3.2 MPa in steps of 0.6 and `G_f` of 30,
/// 45 and 60 J/m^2 the pair with the least deviation from the middle of the envelope.
const FITTED: Concrete =
    Concrete { young_modulus: 37e9, tensile_strength: 2.6e6, fracture_energy: 45.0 };

#[derive(Deserialize)]
struct Beams {
    unnotched: Envelope,
    half_notched: Envelope,
}

#[derive(Deserialize)]
struct Envelope {
    #[serde(rename = "mean_peak_kN")]
    mean_peak: Option<f64>,
    #[serde(rename = "peak_kN")]
    peak: [f64; 2],
    /// Opening (mm), least and largest load (kN).
    curve: Vec<[f64; 3]>,
}

#[derive(Deserialize)]
struct Panel {
    material: Material,
    peak: Peak,
    #[serde(rename = "initial_stiffness_N_per_mm")]
    stiffness: f64,
}

#[derive(Deserialize)]
struct Material {
    #[serde(rename = "E_GPa")]
    young_modulus: f64,
    #[serde(rename = "ft_MPa")]
    tensile_strength: f64,
    #[serde(rename = "Gf_N_per_m")]
    fracture_energies: [f64; 2],
}

#[derive(Deserialize)]
struct Peak {
    #[serde(rename = "load_N")]
    load: f64,
    #[serde(rename = "at_mm")]
    at: f64,
}

fn run(context: &Context<'_>) -> CaseResult {
    let beams: Beams = serde_json::from_str(include_str!(
        "../../../reference/published/peridyn/concrete_beams.json"
    ))?;
    let of_panel: Panel =
        serde_json::from_str(include_str!("../../../reference/published/peridyn/l_panel.json"))?;
    let mut claims = notched(context, &beams.half_notched)?;
    claims.extend(unnotched(context, &beams.unnotched)?);
    for energy in of_panel.material.fracture_energies {
        claims.extend(l_panel(context, &of_panel, energy)?);
    }
    Ok(claims)
}

/// How a curve lies to an envelope between the openings that are compared.
struct Compared {
    /// Root of the mean square distance from its middle, over the middle of its peaks.
    deviation: f64,
    /// Share of its points.
    inside: f64,
}

fn compared(tested: &Tested, envelope: &Envelope) -> CaseResult<Compared> {
    let [from, to] = OPENINGS;
    let (mut squares, mut inside, mut count) = (0.0, 0.0, 0.0);
    for &[opening, low, high] in envelope.curve.iter().filter(|row| row[0] > from && row[0] < to) {
        let load =
            tested.load_at(1e-3 * opening).ok_or("the test ended before its openings")? * 1e-3;
        squares += (load - 0.5 * (low + high)).powi(2);
        inside += f64::from(u8::from(load >= low && load <= high));
        count += 1.0;
    }
    if count < 10.0 {
        return Err(format!("{count} openings are compared; at least 10 are needed").into());
    }
    let peak = 0.5 * (envelope.peak[0] + envelope.peak[1]);
    Ok(Compared { deviation: (squares / count).sqrt() / peak, inside: inside / count })
}

fn words(of: Concrete, on: Lattice) -> String {
    format!(
        "bilinear bonds, f_t = {} MPa, G_f = {} J/m^2, E = {} GPa, plane stress, dx = {} mm, horizon of {} shells; batch 0.02, teeth of 5 %",
        1e-6 * of.tensile_strength,
        of.fracture_energy,
        1e-9 * of.young_modulus,
        1e3 * on.spacing,
        on.shells
    )
}

fn notched(context: &Context<'_>, measured: &Envelope) -> CaseResult {
    context.progress("half-notched beam");
    let tested = beam(FITTED, BEAM, Some(NOTCH), 1.05e-3 * OPENINGS[1])?;
    let lines = context.lines("half-notched", words(FITTED, BEAM));
    let [low, high] = measured.peak;
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let peak = tested.peak()?;
    let Compared { deviation, inside } = compared(&tested, measured)?;
    let mut claims = vec![
        lines
            .of("peak", "largest load, against the middle of the envelope of peaks")
            .unit("kN")
            .relative(1e-3 * peak.load, middle)
            .within(half / middle)
            .because("the envelope of the tests; strength and energy are fitted to this beam, so that this is no prediction"),
        lines
            .of("deviation", "root mean square distance to the middle of the envelope, over its peak")
            .measured(deviation, (0.05, 0.1))
            .because("a fit of two constants: a falling line in place of the long tail of concrete"),
        lines
            .of("inside", "share of the envelope's points at which the load lies in it")
            .measured(inside, (0.6, 1.0))
            .because("as the deviation: above the envelope shortly after the peak"),
    ];
    if context.profile == Profile::Full {
        context.progress("half-notched beam, half the spacing");
        let finer = beam(FITTED, FINER, Some(NOTCH), 4e-5)?.peak()?;
        let quantity = "largest load, against that at half the spacing and the same horizon";
        let reason = "bonds about the tip of the notch are counted by a lattice: of first order in the spacing over the horizon";
        let subject = lines.of("peak/half-spacing", quantity).unit("N");
        claims.push(subject.relative(peak.load, finer.load).within(0.05).because(reason));
    } else {
        context.skip("the notched beam at half the spacing");
    }
    Ok(claims)
}

fn unnotched(context: &Context<'_>, measured: &Envelope) -> CaseResult {
    context.progress("beam without a notch");
    let tested = beam(FITTED, BEAM, None, 3.5e-5)?;
    let lines = context.lines("unnotched", words(FITTED, BEAM));
    let mean = measured.mean_peak.ok_or("the mean peak of the beam without a notch is missing")?;
    let mut claims = vec![
        lines
            .of("peak", "predicted largest load, against the mean of the tests")
            .unit("kN")
            .relative(1e-3 * tested.peak()?.load, mean)
            .within(1.0 - measured.peak[0] / mean)
            .because("from the mean to the lower envelope of the tests; strength and energy are those of the notched beam"),
    ];
    for (name, opening, range) in [("rise", 0.005, (0.85, 1.25)), ("fall", 0.02, (-0.2, -0.06))] {
        let row = measured
            .curve
            .iter()
            .min_by(|a, b| (a[0] - opening).abs().total_cmp(&(b[0] - opening).abs()));
        let &[at, low, high] = row.ok_or("the curve of the beam without a notch is missing")?;
        let load = tested.load_at(1e-3 * at).ok_or("the test ended before its openings")?;
        let quantity = "predicted load at an opening, against the middle of the envelope";
        let reason = "the gauge of this beam is not known: its elastic opening is four times that of 20 mm of the lower edge by beam theory, so that the measured curve lies at larger openings";
        let subject = lines.of(format!("load/{name}"), quantity).unit("kN");
        let compared = subject.relative(1e-3 * load, 0.5 * (low + high));
        claims.push(compared.as_measured(range.0, range.1).because(reason));
    }
    Ok(claims)
}

fn l_panel(context: &Context<'_>, measured: &Panel, energy: f64) -> CaseResult {
    context.progress(&format!("L-shaped panel, {energy} J/m^2"));
    let Material { young_modulus, tensile_strength, .. } = measured.material;
    let of = Concrete {
        young_modulus: 1e9 * young_modulus,
        tensile_strength: 1e6 * tensile_strength,
        fracture_energy: energy,
    };
    let tested = panel(of, PANEL, 3e-4, None)?;
    let lines = context.lines(format!("l-panel/g-{energy}"), words(of, PANEL));
    let horizon = PANEL.spacing * (f64::from(PANEL.shells) + 0.5);
    let start = (tested.first[0] - 0.25).hypot(tested.first[1] - 0.25) / horizon;
    let (peak, first) = (tested.peak()?, tested.points[0]);
    Ok(vec![
        lines
            .of(
                "start",
                "distance of the first bond that softens from the re-entrant corner, in horizons",
            )
            .bounded(start, 0.5)
            .because("a bond whose middle is half its length from the corner crosses it"),
        lines
            .of("peak", "largest load, against the experiment")
            .unit("N")
            .relative(peak.load, measured.peak.load)
            .as_measured(0.15, 0.45)
            .because("not reached: the panel is too stiff, and a line of softening at the given strength holds more than the tests; published simulations have 6.5 to 9.3 kN"),
        lines
            .of("peak/displacement", "displacement at the largest load, against the experiment")
            .unit("mm")
            .relative(1e3 * peak.displacement, measured.peak.at)
            .as_measured(-0.25, 0.05)
            .because("less opening before the peak at the smaller energy"),
        lines
            .of("stiffness", "load over displacement before the first bond softens, against the experiment")
            .unit("N/mm")
            .relative(1e-3 * first.load / first.displacement, measured.stiffness)
            .as_measured(0.3, 0.5)
            .because("not reached: a support without compliance, and E from compression tests; the micromodulus is exact to a few per cent"),
    ])
}
