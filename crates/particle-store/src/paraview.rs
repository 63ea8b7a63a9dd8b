//! Files for ParaView and VTK.

use core::fmt::Write as _;
use std::io::{self, Write};

use crate::bytes::Bytes;
use crate::column::{Handle, Values};
use crate::error::Error;
use crate::store::{Attribute, ParticleStore};

/// Buffer size in bytes.
const BLOCK: usize = 1 << 16;

/// Type code of a vertex cell in VTK.
const VERTEX: u8 = 1;

impl<const D: usize> ParticleStore<D> {
    /// Writes the particles as a `.vtu` file: VTK's `UnstructuredGrid`, one vertex cell for each particle.
    ///
    /// Format: little endian, raw appended data, `UInt64` headers, no compression. The points are the column
    /// `positions`; every other column is a point array under its name, and the ids are the array `id`. Points and
    /// indices in fewer than three dimensions are padded with zeros. Attributes go to the field data under their
    /// names; a real attribute `time` becomes `TimeValue`, the time that ParaView shows.
    ///
    /// NaN and infinity in a column or an attribute are written as they are: ParaView colours them, and pictures of
    /// failed runs need them. In positions and in the time they are rejected, because bounds and animations depend on
    /// these.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyDimensions`] beyond three; [`Error::NotFinite`]; [`Error::NameNotXml`] for a name with a
    /// control character; [`Error::DuplicateName`] for a column `id`, or for an attribute `TimeValue` besides the
    /// time; for the handle those of [`get`](Self::get); [`Error::Io`] if the writer fails. All but the last occur
    /// before anything is written.
    pub fn write_vtu(&self, positions: Handle<[f64; D]>, out: impl Write) -> Result<(), Error> {
        self.write_vtu_with(positions, &[], out)
    }

    /// As [`write_vtu`](Self::write_vtu), with texts, each under its name, as comments at the head of the file: units of the columns,
    /// what numbers of bodies mean. Readers that know no arrays of strings, such as meshio, read the file too.
    ///
    /// ```
    /// use particle_store::ParticleStore;
    ///
    /// let mut store = ParticleStore::<2>::new(1);
    /// let places = store.add("position", vec![[0.0, 1.0]])?;
    /// let mut file = Vec::new();
    /// store.write_vtu_with(places, &[("unit of position", "m")], &mut file)?;
    /// let text = String::from_utf8_lossy(&file);
    /// assert!(text.contains("<!-- unit of position: m -->"));
    /// # Ok::<(), particle_store::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`write_vtu`](Self::write_vtu); [`Error::DuplicateName`] for two texts of one name; [`Error::NameNotXml`] for one with a
    /// control character.
    pub fn write_vtu_with(
        &self,
        positions: Handle<[f64; D]>,
        texts: &[(&str, &str)],
        mut out: impl Write,
    ) -> Result<(), Error> {
        let points = self.get(positions)?;
        if D > 3 {
            return Err(Error::TooManyDimensions { dimension: D });
        }
        if let Some(place) = points.iter().position(|x| !x.iter().all(|value| value.is_finite())) {
            let what = format!("position of particle {}", self.ids[place]);
            return Err(Error::NotFinite { what });
        }
        let n = self.len();
        let field = self.field_arrays()?;
        let comments = comments(texts)?;
        let point_data = self.point_arrays(positions)?;
        let points = [Array::new("Points", "Float64", 3, points.iter().map(padded))];
        let cells = [
            Array::new("connectivity", "Int64", 1, Counted(0..n as u64)),
            Array::new("offsets", "Int64", 1, Counted(1..n as u64 + 1)),
            Array::new("types", "UInt8", 1, core::iter::repeat_n(VERTEX, n)),
        ];

        let mut xml = Xml::default();
        xml.text.push_str("<?xml version=\"1.0\"?>\n");
        xml.text.push_str(&comments);
        xml.text.push_str(concat!(
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ",
            "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n"
        ));
        xml.section("FieldData", &field)?;
        xml.line(format_args!("<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{n}\">"));
        xml.section("PointData", &point_data)?;
        xml.section("Points", &points)?;
        xml.section("Cells", &cells)?;
        xml.text.push_str("</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");

        out.write_all(xml.text.as_bytes())?;
        for array in field.iter().chain(&point_data).chain(&points).chain(&cells) {
            out.write_all(&array.n_bytes.to_le_bytes())?;
            (array.write)(&mut out)?;
        }
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
        Ok(out.flush()?)
    }

    fn field_arrays(&self) -> Result<Vec<Array<'_>>, Error> {
        let mut arrays = Vec::new();
        for (name, value) in self.attributes() {
            arrays.push(match value {
                Attribute::Real(time) if name == "time" => {
                    if self.attribute("TimeValue").is_some() {
                        return Err(Error::DuplicateName { name: "TimeValue".to_owned() });
                    }
                    if !time.is_finite() {
                        return Err(Error::NotFinite { what: "time".to_owned() });
                    }
                    Array::new("TimeValue", "Float64", 1, core::iter::once(time))
                }
                Attribute::Real(value) => Array::new(name, "Float64", 1, core::iter::once(value)),
                Attribute::Count(value) => Array::new(name, "UInt64", 1, core::iter::once(value)),
            });
        }
        Ok(arrays)
    }

    fn point_arrays(&self, positions: Handle<[f64; D]>) -> Result<Vec<Array<'_>>, Error> {
        let mut arrays = vec![Array::new("id", "UInt64", 1, self.ids.iter().copied())];
        for (index, column) in self.columns.iter().enumerate() {
            let name = column.name.as_str();
            if name == "id" {
                return Err(Error::DuplicateName { name: name.to_owned() });
            }
            if index != positions.index {
                arrays.push(array_of(name, &column.values));
            }
        }
        Ok(arrays)
    }
}

/// Writes a `.pvd` file: the particle file of each time, in the given order.
///
/// The names are relative to the `.pvd` file.
///
/// ```
/// let mut series = Vec::new();
/// particle_store::write_pvd([(0.0, "run-0.vtu"), (0.25, "run-1.vtu")], &mut series)?;
/// let text = String::from_utf8_lossy(&series);
/// assert!(text.contains(r#"<DataSet timestep="0.25" part="0" file="run-1.vtu"/>"#));
/// # Ok::<(), particle_store::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::NotFinite`] for a time, [`Error::NameNotXml`] for a file name with a control character, [`Error::Io`] if
/// the writer fails. All but the last occur before anything is written.
pub fn write_pvd<'a>(
    frames: impl IntoIterator<Item = (f64, &'a str)>,
    mut out: impl Write,
) -> Result<(), Error> {
    let mut xml = Xml::default();
    xml.text.push_str(concat!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" ",
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<Collection>\n"
    ));
    for (time, file) in frames {
        if !time.is_finite() {
            return Err(Error::NotFinite { what: format!("time of {file:?}") });
        }
        let file = escaped(file)?;
        xml.line(format_args!("<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>"));
    }
    xml.text.push_str("</Collection>\n</VTKFile>\n");
    out.write_all(xml.text.as_bytes())?;
    Ok(out.flush()?)
}

/// Writes the values of an array.
type PutAll<'a> = dyn Fn(&mut dyn Write) -> io::Result<()> + 'a;

/// An array of the file: its tag, and a function that writes its bytes.
struct Array<'a> {
    name: &'a str,
    vtk_type: &'static str,
    n_components: usize,
    n_tuples: usize,
    n_bytes: u64,
    write: Box<PutAll<'a>>,
}

impl<'a> Array<'a> {
    fn new<T: Bytes>(
        name: &'a str,
        vtk_type: &'static str,
        n_components: usize,
        values: impl ExactSizeIterator<Item = T> + Clone + 'a,
    ) -> Self {
        let n_tuples = values.len();
        let write = move |out: &mut dyn Write| put_all(values.clone(), out);
        let n_bytes = n_tuples as u64 * T::SIZE as u64;
        Self { name, vtk_type, n_components, n_tuples, n_bytes, write: Box::new(write) }
    }
}

/// Texts under their names, each a comment; two hyphens would end one.
fn comments(texts: &[(&str, &str)]) -> Result<String, Error> {
    let mut all = String::new();
    for (i, &(name, text)) in texts.iter().enumerate() {
        if texts[..i].iter().any(|&(other, _)| other == name) {
            return Err(Error::DuplicateName { name: name.to_owned() });
        }
        let mut line = format!("{}: {}", escaped(name)?, escaped(text)?);
        while line.contains("--") {
            line = line.replace("--", "- -");
        }
        // Writing to a string cannot fail.
        let _ = writeln!(all, "<!-- {line} -->");
    }
    Ok(all)
}

fn array_of<'a, const D: usize>(name: &'a str, values: &'a Values<D>) -> Array<'a> {
    match values {
        Values::Scalar(values) => Array::new(name, "Float64", 1, values.iter().copied()),
        Values::Point(values) => Array::new(name, "Float64", 3, values.iter().map(padded)),
        Values::Integer(values) => Array::new(name, "Int64", 1, values.iter().copied()),
        Values::Index(values) => Array::new(name, "Int32", 3, values.iter().map(padded)),
        Values::Tensor(values) => Array::new(name, "Float64", 6, values.iter().copied()),
        Values::Flag(values) => Array::new(name, "UInt8", 1, values.iter().copied()),
        Values::Label(values) => Array::new(name, "UInt32", 1, values.iter().copied()),
    }
}

fn padded<T: Copy + Default, const D: usize>(vector: &[T; D]) -> [T; 3] {
    core::array::from_fn(|axis| vector.get(axis).copied().unwrap_or_default())
}

/// A range of `u64` with an exact length, which the standard range lacks for this type.
#[derive(Clone)]
struct Counted(core::ops::Range<u64>);

impl Iterator for Counted {
    type Item = u64;
    fn next(&mut self) -> Option<u64> {
        self.0.next()
    }
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.0.size_hint()
    }
}

impl ExactSizeIterator for Counted {}

fn put_all<T: Bytes>(values: impl Iterator<Item = T>, out: &mut dyn Write) -> io::Result<()> {
    let mut block = vec![0; BLOCK];
    let mut filled = 0;
    for value in values {
        if filled + T::SIZE > BLOCK {
            out.write_all(&block[..filled])?;
            filled = 0;
        }
        value.put(&mut block[filled..]);
        filled += T::SIZE;
    }
    out.write_all(&block[..filled])
}

/// Header of the file, and offset of the next array in the data after it.
#[derive(Default)]
struct Xml {
    text: String,
    offset: u64,
}

impl Xml {
    fn line(&mut self, line: core::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{line}");
    }

    fn section(&mut self, tag: &str, arrays: &[Array<'_>]) -> Result<(), Error> {
        self.line(format_args!("<{tag}>"));
        for array in arrays {
            let Array { vtk_type, n_components, n_tuples, .. } = array;
            let (name, offset) = (escaped(array.name)?, self.offset);
            let shape = match tag {
                "FieldData" => format!("NumberOfTuples=\"{n_tuples}\""),
                _ => format!("NumberOfComponents=\"{n_components}\""),
            };
            self.line(format_args!(
                "<DataArray type=\"{vtk_type}\" Name=\"{name}\" {shape} format=\"appended\" offset=\"{offset}\"/>"
            ));
            // Eight bytes of length precede the data.
            self.offset += 8 + array.n_bytes;
        }
        self.line(format_args!("</{tag}>"));
        Ok(())
    }
}

/// A text escaped for quotation marks.
fn escaped(text: &str) -> Result<String, Error> {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => return Err(Error::NameNotXml { name: text.to_owned() }),
            _ if character.is_control() => {
                return Err(Error::NameNotXml { name: text.to_owned() });
            }
            _ => out.push(character),
        }
    }
    Ok(out)
}
