//! Points of a body from a file, with their properties.
//!
//! | column | meaning |
//! |---|---|
//! | `x`, `y` | position (m), inside the body |
//! | `volume` | area times thickness (m^3); default: the square of the spacing times the thickness |
//! | `strength_factor` | critical stretch over that of the material |
//! | `stiffness_factor` | stiffness over that of the material |
//!
//! A `.csv` file has a header with these names, in any order. A `.vtu` file has `x` and `y` in its points and the
//! others as point arrays. Other columns are ignored.

pub(crate) mod csv;
mod table;
mod vtu;

use std::collections::BTreeMap;
use std::path::Path;

use peridyn_sde::{Condition, Nodes};
use scene_runs::nearest::nearest;
use scene_runs::scene::{NamedFile, Objection};

use self::table::{COLUMNS, Table};
use super::scene_body::BodyScene;

/// Key that names a file of points.
const KEY: &str = "body.points";

/// Distance (spacings) below which two points coincide.
const AT_ONE_PLACE: f64 = 1e-6;

/// Points of a body and their file.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    file: NamedFile,
    table: Table,
}

impl Cloud {
    /// Reads the points that a body names, if any, from the folder of its scene.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn of_body(body: &BodyScene, folder: &Path) -> Result<Option<Self>, Objection> {
        body.points.as_deref().map(|file| Self::read(file, folder)).transpose()
    }

    /// Reads the file that a body names, from the folder of its scene.
    ///
    /// # Errors
    /// An [`Objection`] to a file that is missing, is neither `.csv` nor `.vtu`, has no points or more than
    /// 10,000,000, lacks a column, or has an invalid number; it names row and column.
    pub fn read(file: &str, folder: &Path) -> Result<Self, Objection> {
        let (_, bytes) = NamedFile::beside((file, folder), KEY, "the points ")?;
        Self::of(file, &bytes)
    }

    /// The points in a file with these bytes.
    ///
    /// # Errors
    /// Those of [`read`](Self::read), for an existing file.
    pub fn of(file: &str, bytes: &[u8]) -> Result<Self, Objection> {
        let extension = Path::new(file).extension().and_then(|extension| extension.to_str());
        let table = match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => csv::read(bytes).map_err(|wrong| Objection::new(KEY, wrong.of(file)))?,
            Some("vtu") => vtu::read(bytes).map_err(|error| {
                let objection = Objection::new(KEY, format!("{file}: {error}"));
                match error.help() {
                    Some(help) => objection.with_help(help),
                    None => objection,
                }
            })?,
            _ => {
                let message = format!("{file} is neither a .csv nor a .vtu file");
                return Err(Objection::new(KEY, message));
            }
        };
        let cloud = Self { file: NamedFile::of(file, bytes), table };
        cloud.check_names()?;
        for (k, name) in COLUMNS.into_iter().enumerate() {
            cloud.check_numbers(name, k < 2)?;
        }
        Ok(cloud)
    }

    /// The file.
    #[must_use]
    pub const fn file(&self) -> &NamedFile {
        &self.file
    }

    /// The nodes of a body.
    ///
    /// # Errors
    /// An [`Objection`] to a point outside the body, two coincident points, and input rejected by [`Nodes::new`].
    pub fn nodes(&self, body: &BodyScene) -> Result<Nodes<2>, Objection> {
        let (x, y) = (self.required("x", KEY)?, self.required("y", KEY)?);
        let places: Vec<[f64; 2]> = x.iter().zip(y).map(|(&x, &y)| [x, y]).collect();
        let [width, height] = body.size;
        let is_inside = |&[x, y]: &[f64; 2]| x >= 0.0 && x <= width && y >= 0.0 && y <= height;
        if let Some(row) = places.iter().position(|place| !is_inside(place)) {
            let message = format!("{}: {:?} lies outside the body", self.row(row), places[row]);
            let help = format!("the body extends from 0 to {width} m by 0 to {height} m");
            return Err(Objection::new(KEY, message).with_help(help));
        }
        self.check_apart(&places, AT_ONE_PLACE * body.spacing)?;
        let condition = Condition::from(body.condition);
        let volumes = match self.column("volume") {
            Some(volumes) => volumes.to_vec(),
            None => vec![condition.across() * body.spacing * body.spacing; places.len()],
        };
        Nodes::new(places, volumes, body.spacing, condition)
            .map_err(|error| Objection::new(KEY, format!("{}: {error}", self.file.path)))
    }

    /// The column required by a key.
    ///
    /// # Errors
    /// An [`Objection`] if the file has no such column.
    pub fn required(&self, name: &str, key: &str) -> Result<&[f64], Objection> {
        self.column(name).ok_or_else(|| {
            let message = format!("{} has no column `{name}`", self.file.path);
            Objection::new(key, message)
                .with_help(format!("it has {}", self.table.names.join(", ")))
        })
    }

    /// Location of a row, e.g. `points.csv line 7`.
    #[must_use]
    pub fn row(&self, row: usize) -> String {
        self.table.place(&self.file.path, row)
    }

    fn column(&self, name: &str) -> Option<&[f64]> {
        let k = COLUMNS.iter().position(|&column| column == name)?;
        self.table.columns[k].as_deref()
    }

    /// Detects misspelt names, which would otherwise count as missing columns.
    fn check_names(&self) -> Result<(), Objection> {
        for (k, name) in self.table.names.iter().enumerate() {
            if self.table.names[..k].contains(name) {
                let message = format!("{} has the column `{name}` twice", self.file.path);
                return Err(Objection::new(KEY, message));
            }
            let is_known = COLUMNS.contains(&name.as_str());
            if let Some(meant) = nearest(name, COLUMNS).filter(|_| !is_known) {
                let message =
                    format!("{} has a column `{name}`, which is not known", self.file.path);
                return Err(
                    Objection::new(KEY, message).with_help(format!("did you mean `{meant}`?"))
                );
            }
        }
        Ok(())
    }

    fn check_numbers(&self, name: &str, any_sign: bool) -> Result<(), Objection> {
        let values = self.column(name).unwrap_or(&[]);
        let is_right = |value: f64| value.is_finite() && (any_sign || value > 0.0);
        let Some(row) = values.iter().position(|&value| !is_right(value)) else { return Ok(()) };
        let column = self.table.names.iter().position(|known| known == name);
        let column = match (&self.table.lines, column) {
            (Some(_), Some(column)) => format!("column {} (`{name}`)", column + 1),
            _ => format!("`{name}`"),
        };
        let must = if any_sign { "finite" } else { "greater than 0 and finite" };
        let message = format!("{} {column} is {}; it must be {must}", self.row(row), values[row]);
        Err(Objection::new(KEY, message))
    }

    /// Sorts points into boxes of a grid and compares each with those of neighbouring boxes.
    fn check_apart(&self, places: &[[f64; 2]], least: f64) -> Result<(), Objection> {
        let mut boxes: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for (row, place) in places.iter().enumerate() {
            #[allow(clippy::cast_possible_truncation, reason = "one too large saturates")]
            let [i, j] = place.map(|x| (x / least).floor() as i64);
            let around = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| [di, dj]));
            let near = around
                .filter_map(|[di, dj]| boxes.get(&[i.saturating_add(di), j.saturating_add(dj)]))
                .flatten()
                .find(|&&other| {
                    let [dx, dy] = [0, 1].map(|k| place[k] - places[other][k]);
                    dx.hypot(dy) <= least
                });
            if let Some(&other) = near {
                let (first, second) = (self.row(other), self.row(row));
                let message = format!("{first} and {second} are points at one place, {place:?}");
                return Err(Objection::new(KEY, message));
            }
            boxes.entry([i, j]).or_default().push(row);
        }
        Ok(())
    }
}
