//! Files that the shapes of a scene name.

use std::path::Path;
use std::sync::Arc;

use scene_runs::scene::{NamedFile, Objection};

use super::point_list::PointList;
use super::surface::Surface;
use crate::coordinates::point;
use crate::scene::{SmpmScene, SolidScene};

impl SmpmScene {
    /// Reads the files of all shapes from the folder of the scene.
    ///
    /// # Errors
    /// An [`Objection`] to a file that is missing, too large or of another format, and to a surface that is not closed.
    pub(crate) fn read_shapes(&mut self, folder: &Path) -> Result<(), Objection> {
        for (i, body) in self.bodies.iter_mut().enumerate() {
            body.shape.read(folder, self.dimension, &format!("bodies[{i}].shape"))?;
            for (k, cut) in body.except.iter_mut().enumerate() {
                cut.read(folder, self.dimension, &format!("bodies[{i}].except[{k}]"))?;
            }
        }
        Ok(())
    }

    /// The files of shapes that were read.
    pub(crate) fn shape_files(&self) -> Vec<NamedFile> {
        let shapes = self.bodies.iter().flat_map(|body| body.except.iter().chain([&body.shape]));
        let file = |shape: &SolidScene| match shape {
            SolidScene::Surface { read, .. } => read.as_ref().map(|it| it.file.clone()),
            SolidScene::Points { read, .. } => read.as_ref().map(|it| it.file.clone()),
            _ => None,
        };
        shapes.filter_map(file).collect()
    }
}

impl SolidScene {
    /// Reads the file of a shape that has one, in a dimension in which there is that shape.
    fn read(&mut self, folder: &Path, dimension: usize, path: &str) -> Result<(), Objection> {
        match self {
            Self::Surface { file, scale, shift, read } if dimension == 3 => {
                let path = format!("{path}.surface");
                positive("scale", *scale, &path)?;
                let shift = match shift.as_slice() {
                    [] => [0.0; 3],
                    given => point(given, &format!("{path}.shift"))?,
                };
                let of = |named, bytes| Surface::read(named, bytes, (*scale, shift));
                *read = Some(read_file((file, folder), &path, of)?);
            }
            Self::Points { file, spacing, read } if (1..=3).contains(&dimension) => {
                let path = format!("{path}.points");
                positive("spacing", *spacing, &path)?;
                let of =
                    |named, bytes: Vec<u8>| PointList::read(named, &bytes, (dimension, *spacing));
                *read = Some(read_file((file, folder), &path, of)?);
            }
            _ => {}
        }
        Ok(())
    }
}

/// The value of a key, above zero.
pub(super) fn positive(key: &str, value: f64, path: &str) -> Result<f64, Objection> {
    if value > 0.0 {
        return Ok(value);
    }
    let message = format!("the {key} is {value} and must be greater than 0");
    Err(Objection::new(format!("{path}.{key}"), message))
}

/// What `of` makes of the bytes of a file.
fn read_file<T>(
    (file, folder): (&str, &Path),
    path: &str,
    of: impl Fn(NamedFile, Vec<u8>) -> Result<T, String>,
) -> Result<Arc<T>, Objection> {
    let path = format!("{path}.file");
    let (named, bytes) = NamedFile::beside((file, folder), &path, "")?;
    let read =
        of(named, bytes).map_err(|message| Objection::new(path, format!("{file} {message}")));
    read.map(Arc::new)
}
