//! `.vtu` files of the crate vtkio, written and read.

use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, Piece, UnstructuredGridPiece,
    Version, VertexNumbers, Vtk,
};

use crate::bare::Columns;

/// The same arrays as `ParticleStore::write_vtu`.
///
/// vtkio consumes the model it writes, so the model is rebuilt each time.
pub(crate) fn write(columns: &Columns, out: &mut Vec<u8>) {
    let n = columns.ids.len();
    let padded = |vectors: &[[f64; 2]]| {
        IOBuffer::F64(vectors.iter().flat_map(|&[x, y]| [x, y, 0.0]).collect())
    };
    let scalar = |name: &str, values: &[f64]| {
        Attribute::generic(name, 1).with_data(IOBuffer::F64(values.to_vec()))
    };
    let [position, velocity] = &columns.vectors;
    let [mass, density, smoothing_length] = &columns.scalars;
    let piece = UnstructuredGridPiece {
        points: padded(position),
        cells: Cells {
            cell_verts: VertexNumbers::XML {
                connectivity: (0..n as u64).collect(),
                offsets: (1..=n as u64).collect(),
            },
            types: vec![CellType::Vertex; n],
        },
        data: Attributes {
            point: vec![
                Attribute::generic("id", 1).with_data(IOBuffer::U64(columns.ids.clone())),
                Attribute::generic("velocity", 3).with_data(padded(velocity)),
                scalar("mass", mass),
                scalar("density", density),
                scalar("smoothing_length", smoothing_length),
            ],
            cell: Vec::new(),
        },
    };
    let vtk = Vtk {
        version: Version::new_xml(1, 0),
        title: String::new(),
        byte_order: ByteOrder::LittleEndian,
        data: DataSet::inline(piece),
        file_path: None,
    };
    vtk.write_xml(out).unwrap();
}

/// Asserts that the raw data after the header of our file are the arrays that vtkio reads from its own, in order.
///
/// vtkio cannot read our raw file.
pub(crate) fn assert_same(ours: &[u8], its: &[u8]) {
    let mark = b"encoding=\"raw\">\n_";
    let head = ours.windows(mark.len()).position(|window| window == mark).unwrap();
    let mut rest = &ours[head + mark.len()..];
    for array in arrays(its) {
        let (size, after) = rest.split_first_chunk::<8>().unwrap();
        let (block, after) = after.split_at(usize::try_from(u64::from_le_bytes(*size)).unwrap());
        assert!(block == bytes(&array), "an array of {} values", array.len());
        rest = after;
    }
}

/// Every point array of a file, the points themselves last.
fn arrays(file: &[u8]) -> Vec<IOBuffer> {
    let DataSet::UnstructuredGrid { pieces, .. } = Vtk::parse_xml(file).unwrap().data else {
        unreachable!("it was an unstructured grid")
    };
    let Some(Piece::Inline(piece)) = pieces.into_iter().next() else {
        unreachable!("it was one piece")
    };
    let data = piece.data.point.into_iter().map(|attribute| match attribute {
        Attribute::DataArray(array) => array.data,
        Attribute::Field { .. } => unreachable!("it had arrays only"),
    });
    data.chain([piece.points]).collect()
}

fn bytes(array: &IOBuffer) -> Vec<u8> {
    match array {
        IOBuffer::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        IOBuffer::U64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        other => unreachable!("an array of {:?}", other.scalar_type()),
    }
}
