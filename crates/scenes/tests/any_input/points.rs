//! Files of points with changed bytes: as CSV, and as VTK in text, in compressed base64, and raw.

use std::sync::LazyLock;

use peridyn_sde::Nodes;
use proptest::prelude::*;
use scenes::peridyn::points::Cloud;
use scenes::peridyn::scene_body::BodyScene;
use scenes::scene::Objection;

use super::changes::changes;

pub(crate) const CSV: &str = "name, y, x, volume, strength_factor\n# three points\n\
    a, 0.1, 0.25, 1.5e-9, 1\n\n\"b, c\", 0.75, 0.5, 2.5e-9, 0.9\nd, 0.3, 1e-3, 1e-10, 1.1\n";

const TEXT: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="0">
<PointData><DataArray type="Float64" Name="volume" format="ascii">1.5 2.5 0.1</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0.25 0.1 0 0.5 0.75 0 1e-3 0.3 0</DataArray></Points>
</Piece></UnstructuredGrid></VTKFile>
"#;

pub(crate) const COMPRESSED: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece NumberOfPoints="3">
<PointData><DataArray type="Float64" Name="volume" format="appended" offset="120"/></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="appended" offset="0"/></Points>
</Piece></UnstructuredGrid><AppendedData encoding="base64">
_AwAAACAAAAAIAAAAGQAAAB4AAAALAAAAeAFjYACBC/azZoLATnswF048sAcAe8gGvngBY2AAgRf2YApI/Fn58ZJvUoC9MRhctgcAZPcIEngBY2CAAAAACAABAQAAACAAAAAYAAAAGAAAAA==eAFjYACBH/ZgioHFYdZMENhpDwAtkQYL
</AppendedData></VTKFile>
"#;

/// The same points as raw appended data.
static RAW: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let head = r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="3">
<PointData><DataArray type="Float64" Name="volume" format="appended" offset="76"/></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="appended" offset="0"/></Points>
</Piece></UnstructuredGrid><AppendedData encoding="raw">
_"#;
    let places = [0.25, 0.1, 0.0, 0.5, 0.75, 0.0, 1e-3, 0.3, 0.0_f64];
    let volumes = [1.5, 2.5, 0.1_f64];
    let mut bytes = head.as_bytes().to_vec();
    for numbers in [places.as_slice(), &volumes] {
        bytes.extend(u32::try_from(8 * numbers.len()).unwrap().to_le_bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
    bytes.extend_from_slice(b"\n</AppendedData></VTKFile>\n");
    bytes
});

static BODY: LazyLock<BodyScene> = LazyLock::new(|| {
    let text = r#"{ "size": [1, 1], "spacing": 0.1, "condition": { "plane_stress": { "thickness": 1e-3 } } }"#;
    serde_json::from_str(text).unwrap()
});

/// The nodes of these bytes.
fn nodes(file: &str, bytes: &[u8]) -> Result<Nodes<2>, Objection> {
    Cloud::of(file, bytes)?.nodes(&BODY)
}

/// The bytes are read to points in the body, or rejected with an error.
fn is_read_or_refused(file: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    if let Ok(nodes) = nodes(file, bytes) {
        prop_assert!(!nodes.positions().is_empty());
        prop_assert!(nodes.positions().iter().flatten().all(|x| (0.0..=1.0).contains(x)));
    }
    Ok(())
}

pub(crate) fn lines(bytes: &[u8]) -> Result<(), TestCaseError> {
    is_read_or_refused("points.csv", bytes)
}

pub(crate) fn grid(bytes: &[u8]) -> Result<(), TestCaseError> {
    is_read_or_refused("points.vtu", bytes)
}

#[test]
fn points_that_nobody_changed_are_read() {
    let count = |file, bytes| nodes(file, bytes).unwrap().positions().len();
    assert_eq!(count("points.csv", CSV.as_bytes()), 3);
    for bytes in [TEXT.as_bytes(), COMPRESSED.as_bytes(), &RAW] {
        assert_eq!(count("points.vtu", bytes), 3);
    }
}

#[test]
fn tags_within_tags_do_not_end_the_program() {
    for depth in [1_000, 100_000, 1_000_000] {
        let text = "<VTKFile>".repeat(depth) + &"</VTKFile>".repeat(depth);
        assert!(nodes("points.vtu", text.as_bytes()).is_err());
    }
}

proptest! {
    #[test]
    fn points_with_other_bytes_are_read_or_refused(changes in changes()) {
        lines(&changes.of(CSV.as_bytes()))?;
        for bytes in [TEXT.as_bytes(), COMPRESSED.as_bytes(), &RAW] {
            grid(&changes.of(bytes))?;
        }
    }
}
