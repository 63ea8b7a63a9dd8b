//! Measured plates: crack paths point by point, and failure loads.

use std::path::Path;

use crack_inference::{Absent, Summaries};
use peridyn_sde::CrackPath;
use peridyn_sde::statistics::{CrackRecord, SummaryConfig};
use scene_runs::nearest::nearest;
use scene_runs::scene::{NamedFile, Objection};
use sde_integrators::Accumulator;
use serde::Serialize;

use super::scene::{InferenceScene, LoadScene};
use crate::points::csv::{Wrong, number, rows};

const PATHS: &str = "measured.paths";
const LOADS: &str = "measured.failure_loads";

/// A measured plate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredPlate {
    /// Its name in the files.
    #[serde(rename = "plate")]
    pub name: String,
    /// Points of its crack (m); none without a file of paths.
    #[serde(rename = "points")]
    pub path: Vec<[f64; 2]>,
    /// Its failure load (N), if it is given.
    pub failure_load: Option<f64>,
}

/// All measured plates with their files.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The plates, in the order in which the first file names them.
    pub plates: Vec<MeasuredPlate>,
    /// The files.
    pub files: Vec<NamedFile>,
}

impl Measured {
    /// Reads the files that a scene names, for a body of this width and height (m).
    ///
    /// # Errors
    /// An [`Objection`] to a file that is missing, lacks a column or has a wrong number, a point outside the body, a load that is not
    /// positive, a path of one point, and a plate without what is compared; it names file and line.
    pub fn read(scene: &InferenceScene, folder: &Path, size: [f64; 2]) -> Result<Self, Objection> {
        let mut all = Self { plates: Vec::new(), files: Vec::new() };
        if let Some(name) = &scene.measured.paths {
            let bytes = all.file(PATHS, name, folder)?;
            all.read_paths(name, &bytes, size)?;
        }
        let has_paths = !all.plates.is_empty();
        if let Some(name) = &scene.measured.failure_loads {
            let bytes = all.file(LOADS, name, folder)?;
            all.read_loads(name, &bytes, has_paths)?;
        }
        if scene.summaries.load != LoadScene::None
            && let Some(plate) = all.plates.iter().find(|plate| plate.failure_load.is_none())
        {
            let message = format!("the plate `{}` has a path and no failure load", plate.name);
            return Err(
                Objection::new(LOADS, message).with_help("both are compared by `summaries`")
            );
        }
        Ok(all)
    }

    fn file(&mut self, key: &str, name: &str, folder: &Path) -> Result<Vec<u8>, Objection> {
        let (file, bytes) = NamedFile::beside((name, folder), key, "")?;
        self.files.push(file);
        Ok(bytes)
    }

    fn read_paths(&mut self, file: &str, bytes: &[u8], size: [f64; 2]) -> Result<(), Objection> {
        let wrong = |wrong: Wrong| Objection::new(PATHS, wrong.of(file));
        let [width, height] = size;
        for Row { line, plate, numbers: [x, y] } in read(bytes, ["x", "y"]).map_err(wrong)? {
            if !((0.0..=width).contains(&x) && (0.0..=height).contains(&y)) {
                let what = format!(
                    "lies at [{x}, {y}], outside the body from 0 to {width} m by 0 to {height} m"
                );
                let objection = Objection::new(PATHS, Wrong::Line(line, what).of(file));
                return Err(objection.with_help("coordinates are those of the plate, in metres"));
            }
            match self.plates.iter_mut().find(|known| known.name == plate) {
                Some(known) => known.path.push([x, y]),
                None => self.plates.push(MeasuredPlate {
                    name: plate,
                    path: vec![[x, y]],
                    failure_load: None,
                }),
            }
        }
        for plate in &self.plates {
            CrackPath::from_points(plate.path.clone()).map_err(|error| {
                let message = format!("{file}: the path of the plate `{}`: {error}", plate.name);
                Objection::new(PATHS, message)
            })?;
        }
        Ok(())
    }

    fn read_loads(&mut self, file: &str, bytes: &[u8], has_paths: bool) -> Result<(), Objection> {
        let wrong =
            |line: u64, what: String| Objection::new(LOADS, Wrong::Line(line, what).of(file));
        let rows = read(bytes, ["failure_load"]);
        for row in rows.map_err(|wrong| Objection::new(LOADS, wrong.of(file)))? {
            let Row { line, plate: name, numbers: [load] } = row;
            if !(load.is_finite() && load > 0.0) {
                return Err(wrong(
                    line,
                    format!("has the failure load {load}; it must be positive"),
                ));
            }
            let known = self.plates.iter().position(|known| known.name == name);
            let Some(place) = known else {
                if has_paths {
                    let objection =
                        wrong(line, format!("has the plate `{name}`, which has no path"));
                    let names = self.plates.iter().map(|plate| plate.name.as_str());
                    return Err(match nearest(&name, names) {
                        Some(nearest) => objection.with_help(format!("did you mean `{nearest}`?")),
                        None => objection,
                    });
                }
                let failure_load = Some(load);
                self.plates.push(MeasuredPlate { name, path: Vec::new(), failure_load });
                continue;
            };
            if self.plates[place].failure_load.replace(load).is_some() {
                return Err(wrong(line, format!("has the plate `{name}` a second time")));
            }
        }
        Ok(())
    }

    /// The plates as records of cracks.
    ///
    /// # Errors
    /// None that can occur: the paths were checked when they were read.
    pub fn records(&self) -> Result<Vec<CrackRecord>, peridyn_sde::Error> {
        let record = |(number, plate): (u64, &MeasuredPlate)| {
            let path = match plate.path.as_slice() {
                [] => None,
                points => Some(CrackPath::from_points(points.to_vec())?),
            };
            Ok(CrackRecord::of_path(number, path.as_ref(), None, plate.failure_load))
        };
        (0..).zip(&self.plates).map(record).collect()
    }

    /// The summaries of the plates that have all of them.
    ///
    /// # Errors
    /// An [`Objection`] where no plate has them.
    pub fn summaries(&self, scene: &InferenceScene) -> Result<Summaries, Objection> {
        let records = self.records().map_err(SummaryError::from);
        records.and_then(|records| summaries(&scene.summary_config(), &records)).map_err(|error| {
            let message = format!("no plate has a crack at all abscissae: {error}");
            Objection::new("summaries.abscissae", message)
        })
    }
}

/// Why cracks have no summaries.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub enum SummaryError {
    /// A number of a crack or of a load.
    Crack(#[from] peridyn_sde::Error),
    /// The rows that they make.
    Rows(#[from] crack_inference::Error),
}

/// The summaries of cracks that have all of them.
///
/// # Errors
/// For a load that is not positive, and where no crack has them.
pub fn summaries(
    config: &SummaryConfig,
    records: &[CrackRecord],
) -> Result<Summaries, SummaryError> {
    let found = config.of_records(records)?;
    let absent = Absent { failed: found.failed, short: found.short, no_load: found.no_load };
    Ok(Summaries::new(&found.rows, absent)?)
}

/// Standard deviations of the errors of measurement, one for each summary.
#[must_use]
pub fn errors(scene: &InferenceScene, plates: &Summaries) -> Vec<f64> {
    let mut errors = vec![scene.measured.height_error; scene.summaries.abscissae.len()];
    match scene.summaries.load {
        LoadScene::None => {}
        LoadScene::LogFailureLoad => errors.push(scene.measured.load_error),
        LoadScene::FailureLoad => {
            let mut loads = Accumulator::default();
            plates.rows().filter_map(<[f64]>::last).for_each(|&load| loads.push(load));
            errors.push(scene.measured.load_error * loads.mean());
        }
    }
    errors
}

/// A row of a file: the name of its plate and its numbers.
struct Row<const N: usize> {
    line: u64,
    plate: String,
    numbers: [f64; N],
}

/// Reads the columns `plate` and those named.
fn read<const N: usize>(bytes: &[u8], columns: [&str; N]) -> Result<Vec<Row<N>>, Wrong> {
    let mut found = Vec::new();
    rows(bytes, "rows", |names, line, row| {
        let place = |column: &str| {
            let mut places = (0..names.len()).filter(|&place| names[place] == column);
            match (places.next(), places.next()) {
                (Some(place), None) => Ok(place),
                (Some(_), Some(_)) => Err(Wrong::File(format!("has the column `{column}` twice"))),
                (None, _) => Err(Wrong::File(format!(
                    "has no column `{column}`; its columns are {}",
                    names.join(", ")
                ))),
            }
        };
        let plate = row[place("plate")?].to_owned();
        if plate.is_empty() {
            return Err(Wrong::Line(line, "has no name of a plate".to_owned()));
        }
        let mut numbers = [0.0; N];
        for (value, column) in numbers.iter_mut().zip(columns) {
            let place = place(column)?;
            *value = number(&row[place], line, (place, column))?;
            if !value.is_finite() {
                let what =
                    format!("column {} (`{column}`) is {value}; it must be finite", place + 1);
                return Err(Wrong::Line(line, what));
            }
        }
        found.push(Row { line, plate, numbers });
        Ok(())
    })?;
    Ok(found)
}
