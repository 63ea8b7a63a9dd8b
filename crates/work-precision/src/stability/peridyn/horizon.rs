//! Horizon in spacings: stiffness, anisotropy, and the effect of a horizon that passes through nodes.

use peridyn_sde::{
    BondConfig, Bonds, Condition, Error, Horizon, Nodes, NoteAsPrinted, VolumeCorrection,
};
use result_figures::{Drawing, Line, ReferencePoint, ReferencePoints, Scale, TimeSeries, Words};

use crate::draw::ChartKind;
use crate::stability::axes::linear;
use reference_problems::context::{CaseError, Context, Profile};

pub(crate) const MAP: ChartKind = ChartKind {
    name: "peridyn-horizon",
    title: "stiffness and anisotropy of a square lattice over the horizon, by volume correction",
    draw,
};

const PLATE: Condition = Condition::PlaneStress { thickness: 1.0 };
/// `E` of the lattices.
const MODULUS: f64 = 3.0;
/// `C11/E` of plane stress with `nu = 1/3`; `C12` is a third of it.
const C11: f64 = 9.0 / 8.0;

const CORRECTIONS: [(&str, VolumeCorrection); 3] = [
    ("none", VolumeCorrection::None),
    ("partial", VolumeCorrection::Partial),
    ("ramp", VolumeCorrection::Ramp),
];

/// `C11` and `C12` of a lattice over those of the elastic plate.
fn stiffness(m: f64, volume_correction: VolumeCorrection) -> Result<[f64; 2], CaseError> {
    let uncorrected = BondConfig::uncorrected(Horizon::new(m, 1.0)?, MODULUS);
    let config = BondConfig { volume_correction, ..uncorrected };
    let one = energy_of_middle(&config, |x| [x[0], 0.0])?;
    // 2 C11 + 2 C12.
    let both = energy_of_middle(&config, |x| *x)?;
    Ok([one / C11, (0.5 * both - one) / (C11 / 3.0)])
}

/// Around the node in the middle of a plate of spacing 1 that holds all that it sees: twice the energy density of its
/// bonds under a small strain, over `E`.
fn energy_of_middle(
    config: &BondConfig,
    strain: impl Fn(&[f64; 2]) -> [f64; 2],
) -> Result<f64, CaseError> {
    let reach = (config.horizon.radius() + 1.0).ceil() + 0.5;
    let nodes = Nodes::lattice(1.0, ([-reach; 2], [reach; 2]), PLATE, |_| true)?;
    // An odd number of nodes along each side.
    let middle = nodes.positions().len() / 2;
    let bonds = Bonds::new(&nodes, config)?;
    let mut energy = 0.0;
    for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
        if i != middle && j != middle {
            continue;
        }
        let (a, b) = (&nodes.positions()[i], &nodes.positions()[j]);
        let (ua, ub) = (strain(a), strain(b));
        let along: f64 = (0..2).map(|k| (b[k] - a[k]) * (ub[k] - ua[k])).sum();
        let stretch = along / (bond.length * bond.length);
        // Half of a bond's energy belongs to each of its nodes.
        energy += 0.25 * bond.stiffness * bond.length * stretch * stretch;
    }
    Ok(2.0 * energy / (nodes.volumes()[middle] * config.young_modulus))
}

/// Horizons slightly beside integer multiples, the multiples, and those of the crate.
fn horizons(is_quick: bool) -> Vec<f64> {
    let mut all = linear(if is_quick { 24 } else { 116 }, 1.613, 6.413);
    for m in 2..=6 {
        all.extend([-1e-3, 0.0, 1e-3, 0.015].map(|beyond| f64::from(m) + beyond));
    }
    all.sort_by(f64::total_cmp);
    all
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let all = horizons(context.profile == Profile::Quick);
    let (mut moduli, mut anisotropies) = (Chart::default(), Chart::default());
    let mut rows = Vec::new();
    for (name, volume) in CORRECTIONS {
        // A horizon that passes through nodes is rejected, and leaves no gap.
        let found: Vec<(f64, [f64; 2])> =
            all.iter().filter_map(|&m| Some((m, stiffness(m, volume).ok()?))).collect();
        let (mut line, mut farthest) = ([vec![], vec![]], 0.0_f64);
        for &(m, [c11, c12]) in &found {
            line[0].push((m, Some(c11)));
            line[1].push((m, Some(1.0 - c12 / c11)));
            farthest = if m > 3.0 { farthest.max((c11 - 1.0).abs()) } else { farthest };
        }
        let (mut row, mut marks) = (vec![format!("  {name:8}")], [vec![], vec![]]);
        for m in 2..=6 {
            let x = f64::from(m) + 0.015;
            let [c11, c12] = stiffness(x, volume)?;
            let anisotropy = 1.0 - c12 / c11;
            marks[0].push(ReferencePoint { x, y: c11, error: None });
            marks[1].push(ReferencePoint { x, y: anisotropy, error: None });
            row.push(format!("m = {m}.015: {c11:.3} {c12:.3} {anisotropy:+.3}"));
        }
        row.push(format!("C11 beyond m = 3 off by up to {:.1} %", 100.0 * farthest));
        rows.push(row.join(" | "));
        for ((chart, points), marks) in
            [&mut moduli, &mut anisotropies].into_iter().zip(line).zip(marks)
        {
            chart.lines.push(Line { name: name.into(), points });
            let name = format!("{name}, m.015 as the crate proposes");
            chart.references.push(ReferencePoints { name, points: marks });
        }
    }
    rows.insert(0, "  C11 and C12 over those of the elastic plate, anisotropy".into());
    let kept = kept_by_note()?;
    rows.push(format!(
        "  horizon of 3 dx as printed: of the bonds of that length {:.0} to {:.0} % are kept, by spacing",
        100.0 * kept.0, 100.0 * kept.1
    ));
    let refused = refusal()?;
    rows.push(format!("  {refused}"));
    let caption = format!(
        "A horizon that passes through nodes is rejected. As printed, with a horizon of 3 dx, roundoff keeps {:.0} to {:.0} % of the bonds of that length, by spacing (20 of them, 0.001 to 0.02).",
        100.0 * kept.0,
        100.0 * kept.1
    );
    let stiffness = moduli.picture(
        "From three spacings on a ramp of volumes keeps the stiffness within 4 %",
        "C11 over that of the elastic plate",
        ("elastic plate", 1.0),
        &caption,
    );
    let anisotropy = anisotropies.picture(
        "A horizon of two spacings is 43 % anisotropic; four with a ramp are within 1 %",
        "anisotropy, 1 - 3 C12/C11",
        ("isotropic", 0.0),
        &caption,
    );
    let drawing = Drawing::time_series("peridyn-horizon-stiffness", &stiffness)?;
    Ok(vec![
        Drawing { table: rows.join("\n"), ..drawing },
        Drawing::time_series("peridyn-horizon-anisotropy", &anisotropy)?,
    ])
}

/// Smallest and largest fraction of bonds of three spacings that a horizon of `3 dx` keeps by `<`, over some spacings.
fn kept_by_note() -> Result<(f64, f64), CaseError> {
    let (mut least, mut largest) = (1.0_f64, 0.0_f64);
    for k in 1..=20 {
        let dx = 1e-3 * f64::from(k);
        let nodes = Nodes::<2>::lattice(dx, ([0.0; 2], [20.0 * dx; 2]), PLATE, |_| true)?;
        let long = |factor: f64| -> Result<f64, CaseError> {
            let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: factor * dx, eta: 1.0 };
            let bonds = note.bonds(&nodes)?;
            Ok(bonds.all().iter().filter(|bond| bond.length > 2.9 * dx).count() as f64)
        };
        let share = long(3.0)? / long(3.01)?;
        (least, largest) = (least.min(share), largest.max(share));
    }
    Ok((least, largest))
}

/// Error text of the crate for a horizon of three spacings.
fn refusal() -> Result<String, CaseError> {
    match Horizon::new(3.0, 1.0) {
        Err(error @ Error::HorizonOnNodes { .. }) => Ok(error.to_string()),
        other => Err(format!("a horizon through nodes was not rejected: {other:?}").into()),
    }
}

/// What a picture shows.
#[derive(Default)]
struct Chart {
    lines: Vec<Line>,
    references: Vec<ReferencePoints>,
}

impl Chart {
    /// With a line at the level of the elastic body.
    fn picture(
        mut self,
        title: &str,
        y_label: &str,
        (name, level): (&str, f64),
        caption: &str,
    ) -> TimeSeries {
        let points = [1.613, 6.413].map(|m| (m, Some(level))).to_vec();
        self.lines.push(Line { name: name.into(), points });
        TimeSeries {
            words: Words {
                title: title.into(),
                subtitle: "square lattice in plane stress, constant influence, by what is done with volumes at the horizon".into(),
                x_label: "horizon over spacing, m".into(),
                y_label: y_label.into(),
                caption: vec![caption.to_owned()],
            },
            scale: Scale::Linear,
            lines: self.lines,
            bands: Vec::new(),
            references: self.references,
        }
    }
}
