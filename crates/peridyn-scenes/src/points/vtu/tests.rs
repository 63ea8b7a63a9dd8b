//! Every array format compared with the same numbers, and invalid files.

use std::io::Write;

use particle_store::ParticleStore;

use super::*;

const POINTS: [[f64; 2]; 3] = [[0.25, 0.1], [0.5, -2.0], [1e-3, 0.3]];
const VOLUMES: [f64; 3] = [1.5, 2.5, 0.1];

/// A file with a header number type, two arrays with a format and their contents.
fn file(header: &str, arrays: [&str; 2], appended: &str) -> Vec<u8> {
    let [points, volumes] = arrays;
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" {header}><UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"3\" NumberOfCells=\"0\">\n<PointData>\n\
         <DataArray type=\"Float64\" Name=\"volume\" {volumes}</DataArray></PointData>\n\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" {points}</DataArray></Points>\n\
         </Piece></UnstructuredGrid>{appended}</VTKFile>\n"
    )
    .into_bytes()
}

fn bytes() -> [Vec<u8>; 2] {
    let flat = POINTS.iter().flat_map(|&[x, y]| [x, y, 0.0]);
    let points = flat.flat_map(f64::to_le_bytes).collect();
    [points, VOLUMES.iter().flat_map(|volume| volume.to_le_bytes()).collect()]
}

/// Compresses blocks by zlib, with the header encoded separately.
fn compressed(bytes: &[u8], length: usize) -> String {
    let deflate = |block: &[u8]| {
        let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        out.write_all(block).unwrap();
        out.finish().unwrap()
    };
    let blocks: Vec<Vec<u8>> = bytes.chunks(length).map(deflate).collect();
    let counts = [blocks.len(), length, bytes.len() % length].into_iter();
    let counts = counts.chain(blocks.iter().map(Vec::len));
    let header: Vec<u8> = counts.flat_map(|n| u32::try_from(n).unwrap().to_le_bytes()).collect();
    BASE64_STANDARD.encode(header) + &BASE64_STANDARD.encode(blocks.concat())
}

fn check(table: &Table) {
    assert_eq!(table.names, ["x", "y", "volume"]);
    for k in 0..2 {
        assert_eq!(table.columns[k], Some(POINTS.map(|x| x[k]).to_vec()));
    }
    assert_eq!(table.columns[2], Some(VOLUMES.to_vec()));
    assert_eq!((&table.columns[3], &table.lines), (&None, &None));
}

#[test]
fn text_base64_and_compressed_arrays_are_the_same_numbers() {
    let text =
        file("", ["format=\"ascii\"> 0.25 0.1 0 0.5 -2 0\n1e-3 0.3 0 ", ">1.5 2.5\n0.1"], "");
    check(&read(&text).unwrap());
    let wide = |bytes: &Vec<u8>| {
        let length = (bytes.len() as u64).to_le_bytes();
        BASE64_STANDARD.encode([length.as_slice(), bytes].concat())
    };
    let [points, volumes] = bytes().map(|bytes| format!("format=\"binary\">\n {}\n", wide(&bytes)));
    check(&read(&file("header_type=\"UInt64\"", [&points, &volumes], "")).unwrap());

    let [points, volumes] = bytes().map(|bytes| compressed(&bytes, 32));
    let second = format!("format=\"appended\" offset=\"{}\">", points.len());
    let appended =
        format!("\n<AppendedData encoding=\"base64\">\n_{points}{volumes}\n</AppendedData>");
    let zlib = "compressor=\"vtkZLibDataCompressor\"";
    let arrays = ["format=\"appended\" offset=\"0\">", &second];
    check(&read(&file(zlib, arrays, &appended)).unwrap());
}

#[test]
fn a_file_of_this_workspace_is_read_as_it_was_written() {
    let mut store = ParticleStore::<2>::new(3);
    let places = store.add("position", POINTS.to_vec()).unwrap();
    store.add("volume", VOLUMES.to_vec()).unwrap();
    let mut out = Vec::new();
    store.write_vtu(places, &mut out).unwrap();
    let mut table = read(&out).unwrap();
    assert_eq!(table.names.remove(2), "id");
    check(&table);
    for length in 0..out.len() {
        // A file truncated anywhere before the end of the volumes is rejected.
        if let Ok(mut table) = read(&out[..length]) {
            table.names.retain(|name| name != "id");
            check(&table);
        }
    }
}

#[test]
fn files_that_are_no_points_of_a_plane_are_refused_in_words() {
    let plain = ["format=\"ascii\">0 0 0 1 0 0 2 0 0", ">1 1 1"];
    let refused = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(read(&file("", plain, "")).is_ok());
    assert_eq!(refused(b" \n"), "it is empty");
    assert!(refused(b"x,y\n1,2\n").starts_with("it is no XML: "));
    assert_eq!(refused(b"<VTKFile/>"), "`type` is ``, which is not read here");
    let big = refused(&file("byte_order=\"BigEndian\"", plain, ""));
    assert_eq!(big, "`byte_order` is `BigEndian`, which is not read here");
    let lz4 = read(&file("compressor=\"vtkLZ4DataCompressor\"", plain, "")).unwrap_err();
    assert_eq!(lz4.help(), Some("write it with zlib or without compression"));
    let short = ["format=\"ascii\">0 0 0 1 0 0 2 0 0", ">1 1"];
    let expected = "the array `volume` has 2 numbers; there must be 3";
    assert_eq!(refused(&file("", short, "")), expected);
    let word = ["format=\"ascii\">0 0 0 1 0 0 2 0 0", ">1 one 1"];
    let expected = "the array `volume` is cut short, too long, or not of its type and format";
    assert_eq!(refused(&file("", word, "")), expected);
    let behind = ["format=\"appended\" offset=\"0\">", ">1 1 1"];
    let expected = "the array `Points` is cut short, too long, or not of its type and format";
    assert_eq!(refused(&file("", behind, "")), expected);
    let high = ["format=\"ascii\">0 0 0 1 0 0.5 2 0 0", ">1 1 1"];
    let expected = "point 1 is at z = 0.5, point 0 at z = 0: the body is plane";
    assert_eq!(refused(&file("", high, "")), expected);
    let none = String::from_utf8(file("", plain, "")).unwrap();
    let none = none.replace("NumberOfPoints=\"3\"", "NumberOfPoints=\"0\"");
    assert_eq!(refused(none.as_bytes()), "it holds no points");
    let two = none.replace("<Piece ", "<Piece/><Piece ");
    assert_eq!(refused(two.as_bytes()), "there are 2 pieces; there must be one");
}

/// A third of a megabyte that expands to 240 MB, and a count of points without data.
#[test]
fn more_than_can_be_read_is_refused_before_it_is_there() {
    let zeros = compressed(&vec![0; MOST_BYTES], MOST_BYTES);
    assert!(zeros.len() < 1 << 20);
    let points = format!("format=\"binary\">{zeros}");
    let bomb = file("compressor=\"vtkZLibDataCompressor\"", [&points, ">1 1 1"], "");
    assert_eq!(read(&bomb), Err(VtuError::Array { name: "Points".to_owned() }));
    let plain = ["format=\"ascii\">0 0 0 1 0 0 2 0 0", ">1 1 1"];
    let many = String::from_utf8(file("", plain, "")).unwrap();
    let many = many.replace("NumberOfPoints=\"3\"", "NumberOfPoints=\"10000001\"");
    assert_eq!(read(many.as_bytes()), Err(VtuError::TooMany { value: 10_000_001 }));
}
