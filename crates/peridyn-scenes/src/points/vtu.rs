//! Points in VTK format: an `UnstructuredGrid` in XML with text, base64 or raw arrays, optionally compressed by zlib.
//!
//! Source: VTK file formats, XML formats (vtk.org); the layout of compressed arrays in `vtkXMLWriter`.

use std::io::Read;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use roxmltree::{Document, Node};

use super::table::{COLUMNS, MOST_POINTS, Table};

/// Tag at which appended data begin.
const APPENDED: &[u8] = b"<AppendedData";

/// Upper bound on the bytes of an array: a short compressed array can expand beyond the memory.
const MOST_BYTES: usize = 3 * 8 * MOST_POINTS + 1;

/// Error of a file of points.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum VtuError {
    #[error("it is no XML: {0}")]
    NotXml(String),
    #[error("it is empty")]
    Empty,
    #[error("it holds no points")]
    NoPoints,
    #[error("it holds {value} points; at most {MOST_POINTS} are read")]
    TooMany { value: usize },
    #[error("`{tag}` is missing")]
    Missing { tag: &'static str },
    #[error("there are {count} pieces; there must be one")]
    Pieces { count: usize },
    #[error("`{attribute}` is `{value}`, which is not read here")]
    Unread { attribute: &'static str, value: String },
    #[error("the array `{name}` is cut short, too long, or not of its type and format")]
    Array { name: String },
    #[error("the array `{name}` has {value} numbers; there must be {expected}")]
    Length { name: String, value: usize, expected: usize },
    #[error("point {point} is at z = {value}, point 0 at z = {first}: the body is plane")]
    NotPlane { point: usize, value: f64, first: f64 },
}

impl VtuError {
    /// Help for the error.
    pub(super) fn help(&self) -> Option<&'static str> {
        match self {
            Self::Unread { attribute: "compressor", .. } => {
                Some("write it with zlib or without compression")
            }
            Self::Unread { attribute: "type", .. } => Some("it must be an UnstructuredGrid"),
            Self::Unread { attribute: "byte_order", .. } => Some("it must be LittleEndian"),
            Self::Pieces { .. } => Some("ParaView's filter Merge Blocks makes one of them"),
            _ => None,
        }
    }
}

/// Layout of numbers.
struct Layout<'a> {
    /// Bytes of a number in a header.
    header: usize,
    compressed: bool,
    /// Appended data after the underscore, and whether they are in base64.
    appended: Option<(&'a [u8], bool)>,
}

/// Reads the points and their required arrays.
pub(super) fn read(bytes: &[u8]) -> Result<Table, VtuError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(VtuError::Empty);
    }
    let (head, appended) = split(bytes);
    let no_xml = |error: &dyn std::fmt::Display| VtuError::NotXml(error.to_string());
    let text = std::str::from_utf8(head).map_err(|error| no_xml(&error))?;
    let text = if appended.is_some() { format!("{text}</VTKFile>") } else { text.to_owned() };
    let document = Document::parse(&text).map_err(|error| no_xml(&error))?;
    let layout = Layout::of(document.root_element(), appended)?;
    let grid = child(document.root_element(), "UnstructuredGrid")?;
    let pieces: Vec<_> = grid.children().filter(|node| node.has_tag_name("Piece")).collect();
    let [piece] = pieces[..] else { return Err(VtuError::Pieces { count: pieces.len() }) };
    let n_points = piece.attribute("NumberOfPoints").and_then(|count| count.trim().parse().ok());
    let n_points: usize = n_points.ok_or(VtuError::Missing { tag: "NumberOfPoints" })?;
    if n_points == 0 {
        return Err(VtuError::NoPoints);
    }
    if n_points > MOST_POINTS {
        return Err(VtuError::TooMany { value: n_points });
    }
    let places = child(child(piece, "Points")?, "DataArray")?;
    let places = layout.array(places, "Points", 3 * n_points)?;
    check_plane(&places)?;
    let along = |k: usize| Some(places.chunks_exact(3).map(|x| x[k]).collect::<Vec<_>>());
    let mut table = Table {
        names: vec!["x".to_owned(), "y".to_owned()],
        columns: [along(0), along(1), None, None, None],
        lines: None,
    };
    let data = piece.children().find(|node| node.has_tag_name("PointData"));
    let arrays = data.iter().flat_map(Node::children);
    for array in arrays.filter(|node| node.has_tag_name("DataArray")) {
        let name = array.attribute("Name").unwrap_or_default();
        // Positions come from the points.
        let wanted = COLUMNS.iter().position(|&column| column == name).filter(|&k| k >= 2);
        if let Some(k) = wanted {
            table.columns[k] = Some(layout.array(array, name, n_points)?);
        }
        table.names.push(name.to_owned());
    }
    Ok(table)
}

/// Splits the file into its XML and the appended data from their tag on.
fn split(bytes: &[u8]) -> (&[u8], Option<&[u8]>) {
    match bytes.windows(APPENDED.len()).position(|window| window == APPENDED) {
        Some(at) => (&bytes[..at], Some(&bytes[at..])),
        None => (bytes, None),
    }
}

fn child<'a, 'input>(
    node: Node<'a, 'input>,
    tag: &'static str,
) -> Result<Node<'a, 'input>, VtuError> {
    node.children().find(|child| child.has_tag_name(tag)).ok_or(VtuError::Missing { tag })
}

fn check_plane(places: &[f64]) -> Result<(), VtuError> {
    let first = places[2];
    let largest = places.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
    let is_off = |x: &[f64]| (x[2] - first).abs() > 1e-9 * largest;
    match places.chunks_exact(3).position(is_off) {
        Some(point) => Err(VtuError::NotPlane { point, value: places[3 * point + 2], first }),
        None => Ok(()),
    }
}

impl<'a> Layout<'a> {
    fn of(root: Node<'_, '_>, appended: Option<&'a [u8]>) -> Result<Self, VtuError> {
        let is = |attribute: &'static str, default: &str, known: &[&str]| {
            let value = root.attribute(attribute).unwrap_or(default);
            known
                .iter()
                .position(|&known| known == value)
                .ok_or_else(|| VtuError::Unread { attribute, value: value.to_owned() })
        };
        is("type", "", &["UnstructuredGrid"])?;
        is("byte_order", "LittleEndian", &["LittleEndian"])?;
        let header = [4, 8][is("header_type", "UInt32", &["UInt32", "UInt64"])?];
        let compressed = is("compressor", "", &["", "vtkZLibDataCompressor"])? == 1;
        let appended = appended.map(appended_data).transpose()?;
        Ok(Self { header, compressed, appended })
    }

    /// The numbers of an array, with the expected count.
    fn array(&self, node: Node<'_, '_>, name: &str, expected: usize) -> Result<Vec<f64>, VtuError> {
        let broken = || VtuError::Array { name: name.to_owned() };
        let format = node.attribute("format").unwrap_or("ascii");
        let texts = node.children().filter(Node::is_text).filter_map(|text| text.text());
        let text: String = texts.collect();
        let values = match format {
            "ascii" => {
                let numbers = text.split_ascii_whitespace().map(str::parse);
                numbers.collect::<Result<Vec<f64>, _>>().map_err(|_| broken())?
            }
            "binary" => {
                let text: Vec<u8> =
                    text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
                let bytes = self.bytes(&Stream { bytes: &text, base64: true });
                numbers(&bytes.ok_or_else(broken)?, node).ok_or_else(broken)?
            }
            "appended" => {
                let offset = node.attribute("offset").and_then(|offset| offset.parse().ok());
                let data = self.appended.zip(offset);
                let stream = data.and_then(|((bytes, base64), offset): (_, usize)| {
                    Some(Stream { bytes: bytes.get(offset..)?, base64 })
                });
                let bytes = stream.and_then(|stream| self.bytes(&stream));
                numbers(&bytes.ok_or_else(broken)?, node).ok_or_else(broken)?
            }
            _ => return Err(VtuError::Unread { attribute: "format", value: format.to_owned() }),
        };
        if values.len() == expected {
            Ok(values)
        } else {
            let (name, value) = (name.to_owned(), values.len());
            Err(VtuError::Length { name, value, expected })
        }
    }

    /// The bytes of an array that begins at the start of the stream.
    fn bytes(&self, stream: &Stream<'_>) -> Option<Vec<u8>> {
        let count = |bytes: &[u8], k: usize| {
            let number = bytes.get(k * self.header..(k + 1) * self.header)?;
            let wide = number.iter().rev().fold(0_u64, |sum, &byte| sum << 8 | u64::from(byte));
            usize::try_from(wide).ok()
        };
        if !self.compressed {
            let length = count(&stream.take(0, self.header)?, 0)?;
            let mut all = stream.take(0, self.header.checked_add(length)?)?;
            return Some(all.split_off(self.header));
        }
        // Number of blocks, size of all but the last, size of the last or zero, and compressed size of each.
        let n_blocks = count(&stream.take(0, self.header)?, 0)?;
        let length = n_blocks.checked_add(3)?.checked_mul(self.header)?;
        let header = stream.take(0, length)?;
        let sizes: Vec<usize> =
            (3..n_blocks + 3).map(|k| count(&header, k)).collect::<Option<_>>()?;
        let total = sizes.iter().try_fold(0_usize, |sum, &size| sum.checked_add(size))?;
        let blocks = stream.take(stream.length_of(length)?, total)?;
        let (mut out, mut rest) = (Vec::new(), blocks.as_slice());
        for size in sizes {
            let (block, after) = rest.split_at_checked(size)?;
            let left = MOST_BYTES - out.len();
            let mut decoder = flate2::read::ZlibDecoder::new(block).take(left as u64);
            if decoder.read_to_end(&mut out).ok()? == left {
                return None;
            }
            rest = after;
        }
        Some(out)
    }
}

/// Raw or base64-encoded bytes.
struct Stream<'a> {
    bytes: &'a [u8],
    base64: bool,
}

impl Stream<'_> {
    /// Number of characters that encode a number of bytes together.
    fn length_of(&self, n_bytes: usize) -> Option<usize> {
        if self.base64 { n_bytes.div_ceil(3).checked_mul(4) } else { Some(n_bytes) }
    }

    /// The first bytes of a sequence that is encoded together from a character on.
    fn take(&self, from: usize, n_bytes: usize) -> Option<Vec<u8>> {
        let characters = self.length_of(n_bytes)?;
        let bytes = self.bytes.get(from..from.checked_add(characters)?)?;
        if !self.base64 {
            return Some(bytes.to_vec());
        }
        let mut bytes = BASE64_STANDARD.decode(bytes).ok()?;
        bytes.truncate(n_bytes);
        (bytes.len() == n_bytes).then_some(bytes)
    }
}

/// The data after the underscore, and whether they are in base64.
fn appended_data(bytes: &[u8]) -> Result<(&[u8], bool), VtuError> {
    let missing = || VtuError::Missing { tag: "AppendedData" };
    let end = bytes.iter().position(|&byte| byte == b'>').ok_or_else(missing)?;
    let tag = String::from_utf8_lossy(&bytes[..end]);
    let encoding = tag.split("encoding=").nth(1).map(|rest| rest.trim_matches(['"', '\'', ' ']));
    let base64 = match encoding {
        Some("base64") => true,
        Some("raw") => false,
        _ => {
            let value = encoding.unwrap_or_default().to_owned();
            return Err(VtuError::Unread { attribute: "encoding", value });
        }
    };
    let start = bytes[end..].iter().position(|&byte| byte == b'_').ok_or_else(missing)?;
    Ok((&bytes[end + start + 1..], base64))
}

/// Little-endian numbers of an array's type.
fn numbers(bytes: &[u8], array: Node<'_, '_>) -> Option<Vec<f64>> {
    fn each<const N: usize>(bytes: &[u8], of: impl Fn([u8; N]) -> f64) -> Option<Vec<f64>> {
        let (numbers, rest) = bytes.as_chunks::<N>();
        rest.is_empty().then(|| numbers.iter().map(|&number| of(number)).collect())
    }
    match array.attribute("type")? {
        "Float64" => each(bytes, f64::from_le_bytes),
        "Float32" => each(bytes, |number| f64::from(f32::from_le_bytes(number))),
        "Int32" => each(bytes, |number| f64::from(i32::from_le_bytes(number))),
        "UInt32" => each(bytes, |number| f64::from(u32::from_le_bytes(number))),
        "Int64" => each(bytes, |number| i64::from_le_bytes(number) as f64),
        "UInt64" => each(bytes, |number| u64::from_le_bytes(number) as f64),
        "Int16" => each(bytes, |number| f64::from(i16::from_le_bytes(number))),
        "UInt16" => each(bytes, |number| f64::from(u16::from_le_bytes(number))),
        "Int8" => each(bytes, |number| f64::from(i8::from_le_bytes(number))),
        "UInt8" => each(bytes, |number| f64::from(u8::from_le_bytes(number))),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
