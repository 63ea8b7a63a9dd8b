//! Mean and standard deviation of a response over a plate under an explosion: fields from one run with jets. They show
//! what figures 4 and 8 of Chen et al. 2019 show, the bodies at the end, with the response of each example over them.

use perturbation_moments::{Jet, Scalar};
use result_figures::{Drawing, Field, Region, Words};
use scenes::machine::Machine;
use smpm::uncertainty::Study;
use smpm::{Body, Quantity, Simulation};

use crate::draw::ChartKind;
use reference_problems::context::{CaseError, Context, Profile};
use reference_problems::smpm::problems::{Problem, experiment};

pub(crate) const CHART: ChartKind = ChartKind {
    name: "smpm-fields",
    title: "mean and standard deviation over plates under an explosion, as pictures: pressure in a thick one, flow stress in a thin one",
    draw,
};

/// Time (us).
const TIME: f64 = 10.0;
/// Coefficient of variation of every parameter.
const COEFFICIENT_OF_VARIATION: f64 = 0.05;
/// Megapascals per megabar.
const MPA: f64 = 1e5;
/// Corners of the picture (cm).
const FROM: [f64; 2] = [-6.0, 0.0];
const TO: [f64; 2] = [14.0, 12.5];
/// Bodies of the scenes, in order.
const BODIES: [&str; 3] = ["products of TNT", "steel", "water"];
const STEEL: usize = 1;

/// An example of the paper and the response that it looks at.
struct Example {
    problem: Problem,
    figure: u32,
    quantity: Quantity,
    /// Name in a file and in words.
    id: &'static str,
    name: &'static str,
    subtitle: &'static str,
}

const THICK: Example = Example {
    problem: Problem::ThickPlate,
    figure: 4,
    quantity: Quantity::Pressure,
    id: "pressure",
    name: "pressure in steel",
    subtitle: "charge of TNT in water on a thick plate of 4340 steel; S1, Grüneisen's constant and its slope normal, coefficient of variation 0.05",
};
const THIN: Example = Example {
    problem: Problem::ContactExplosion,
    figure: 8,
    quantity: Quantity::FlowStress,
    id: "flow-stress",
    name: "flow stress of steel",
    subtitle: "charge of TNT in water on a plate of 4340 steel; A, B, n, C, m normal, coefficient of variation 0.05",
};

/// A particle: position, body, mean and deviation of the response (MPa).
struct Seen {
    place: [f64; 2],
    body: usize,
    moments: [f64; 2],
}

fn draw(context: &Context<'_>) -> Result<Vec<Drawing>, CaseError> {
    let mut drawings = fields(context, &THICK)?;
    drawings.extend(fields(context, &THIN)?);
    Ok(drawings)
}

/// Both moments of an example.
fn fields(context: &Context<'_>, example: &Example) -> Result<Vec<Drawing>, CaseError> {
    let cell = if context.profile == Profile::Quick { 0.5 } else { 0.25 };
    let mut scene = example.problem.scene_with(COEFFICIENT_OF_VARIATION, &[TIME])?;
    scene.grid.cell = cell;
    context.progress(&format!("{}: run with derivatives", example.id));
    let experiment = experiment::<2>(&scene)?;
    let study = Study::new(&experiment, scene.inputs()?, scene.plan::<2>()?)?;
    let mut seen = Vec::new();
    let _ = study
        .propagated_seen(|_, run| seen = particles(run, example.quantity, scene.random.len()))?;
    let grid = Grid::new(cell, &seen);
    let draw = |k: usize, id: &str, word: &str| {
        let chart = Field {
            words: Words {
                title: format!("{word} of the {}, {TIME} us after ignition", example.name),
                subtitle: example.subtitle.into(),
                x_label: "x (cm)".into(),
                y_label: "y (cm); y = 0 is a plane of symmetry".into(),
                caption: vec![
                    format!(
                        "Figure {} of Chen et al. 2019 shows these bodies at an end time that it does not state.",
                        example.figure
                    ),
                    format!(
                        "One run with jets, {} particles, cells of {} mm; each cell of the picture shows the mean over its particles.",
                        seen.len(),
                        10.0 * cell
                    ),
                    Machine::read().caption(),
                ],
            },
            unit: format!("{word} (MPa)"),
            x: grid.edges(0),
            y: grid.edges(1),
            values: grid.values(&seen, k),
            regions: [2, 0].map(|body| grid.region(body)).into(),
        };
        Drawing::field(&format!("smpm-field-{}-{id}", example.id), &chart)
    };
    Ok(vec![draw(0, "mean", "Mean")?, draw(1, "deviation", "Standard deviation")?])
}

/// All particles of a run, with second-order mean and first-order deviation by the first `n` derivatives.
fn particles(run: &Simulation<Jet, 2>, quantity: Quantity, n: usize) -> Vec<Seen> {
    let of = |(number, body): (usize, &Body<Jet, 2>)| -> Vec<Seen> {
        let one = |particle: usize| {
            let response = quantity.of(body, particle).unwrap_or(Jet::constant(0.0));
            let curvature: f64 = response.second.iter().take(n).sum();
            let squares: f64 = response.first.iter().take(n).map(|slope| slope * slope).sum();
            let mean = response.value + 0.5 * curvature;
            Seen {
                place: body.position(particle).map(Scalar::value),
                body: number,
                moments: [MPA * mean, MPA * squares.sqrt()],
            }
        };
        (0..body.n_particles()).map(one).collect()
    };
    run.bodies().iter().enumerate().flat_map(of).collect()
}

/// Cells of a picture and the particles in them.
struct Grid {
    cell: f64,
    count: [usize; 2],
    /// Number of particles of each body, row by row from the bottom.
    held: Vec<Vec<[usize; 3]>>,
}

impl Grid {
    fn new(cell: f64, seen: &[Seen]) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "tens")]
        let count: [usize; 2] =
            std::array::from_fn(|k| ((TO[k] - FROM[k]) / cell).round().max(1.0) as usize);
        let mut grid = Self { cell, count, held: vec![vec![[0; 3]; count[0]]; count[1]] };
        for particle in seen {
            if let Some([column, row]) = grid.place(particle) {
                grid.held[row][column][particle.body] += 1;
            }
        }
        grid
    }

    fn place(&self, particle: &Seen) -> Option<[usize; 2]> {
        let place: [f64; 2] =
            std::array::from_fn(|k| ((particle.place[k] - FROM[k]) / self.cell).floor());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
        let inside = (0..2).all(|k| (0.0..self.count[k] as f64).contains(&place[k]));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked")]
        inside.then(|| place.map(|entry| entry as usize))
    }

    fn edges(&self, axis: usize) -> Vec<f64> {
        (0..=self.count[axis]).map(|k| FROM[axis] + self.cell * k as f64).collect()
    }

    /// The body with the most particles in a cell.
    fn owner(held: [usize; 3]) -> Option<usize> {
        (0..3).max_by_key(|&body| held[body]).filter(|&body| held[body] > 0)
    }

    /// Mean of a moment over the steel particles in each cell that belongs to steel.
    fn values(&self, seen: &[Seen], moment: usize) -> Vec<Vec<Option<f64>>> {
        let mut sums = vec![vec![0.0; self.count[0]]; self.count[1]];
        for particle in seen.iter().filter(|particle| particle.body == STEEL) {
            if let Some([column, row]) = self.place(particle) {
                sums[row][column] += particle.moments[moment];
            }
        }
        let value = |(&sum, &held): (&f64, &[usize; 3])| {
            (Self::owner(held) == Some(STEEL)).then(|| sum / held[STEEL] as f64)
        };
        sums.iter().zip(&self.held).map(|(s, h)| s.iter().zip(h).map(value).collect()).collect()
    }

    fn region(&self, body: usize) -> Region {
        let row = |held: &Vec<[usize; 3]>| {
            held.iter().map(|&held| Self::owner(held) == Some(body)).collect()
        };
        Region { name: BODIES[body].into(), cells: self.held.iter().map(row).collect() }
    }
}
