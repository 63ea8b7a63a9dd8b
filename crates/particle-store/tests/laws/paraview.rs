//! Files for ParaView are byte-for-byte those that VTK's own reader has read.
//!
//! `checks/read_with_vtk.py` reads the golden files back with VTK and compares every value; VTK 9.7.2 passed it. After
//! an intended change run the tests with `PARTICLE_STORE_BLESS=1`, and then that script.

use std::path::Path;

use particle_store::{Attribute, Error, Handle, ParticleStore, SymmetricTensor, write_pvd};

/// Three particles with a column of each kind; the last density is NaN.
fn store() -> (ParticleStore<2>, Handle<[f64; 2]>) {
    let mut store = ParticleStore::new(3);
    store.add("density", vec![1.5, -2.0, f64::NAN]).unwrap();
    let position = store.add("position", vec![[0.0, 1.0], [2.0, 3.0], [4.0, 5.5]]).unwrap();
    store.add("velocity", vec![[0.25, -1.0], [1e-300, 7.0], [0.0, 8.0]]).unwrap();
    let stress = |first: f64| SymmetricTensor(core::array::from_fn(|k| first + k as f64));
    store.add("stress", vec![stress(0.0), stress(10.0), stress(20.0)]).unwrap();
    store.add("age", vec![-1_i64, i64::MAX, 0]).unwrap();
    store.add("cell", vec![[1_i32, -1], [2, -2], [3, i32::MIN]]).unwrap();
    store.add("phase <α & \"β\">", vec![0_u8, 1, 255]).unwrap();
    store.add("body", vec![0_u32, 1, u32::MAX]).unwrap();
    store.set_attribute("time", Attribute::Real(0.5));
    store.set_attribute("step", Attribute::Count(7));
    store.permute(&[2, 0, 1]).unwrap();
    (store, position)
}

fn vtu<const D: usize>(store: &ParticleStore<D>, position: Handle<[f64; D]>) -> Vec<u8> {
    let mut bytes = Vec::new();
    store.write_vtu(position, &mut bytes).unwrap();
    bytes
}

fn is_golden(name: &str, bytes: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("PARTICLE_STORE_BLESS").is_some() {
        std::fs::write(&path, bytes).unwrap();
    }
    assert!(bytes == std::fs::read(&path).unwrap(), "{name} is not the golden file");
}

#[test]
fn files_are_the_golden_ones() {
    let (store, position) = store();
    is_golden("three.vtu", &vtu(&store, position));
    let empty = &mut ParticleStore::<3>::new(0);
    let nowhere = empty.add("position", Vec::new()).unwrap();
    is_golden("empty.vtu", &vtu(empty, nowhere));
    let mut with_texts = Vec::new();
    let texts = [("unit of density", "kg/m³"), ("body 0", "plate <1>---")];
    store.write_vtu_with(position, &texts, &mut with_texts).unwrap();
    is_golden("texts.vtu", &with_texts);
    let mut series = Vec::new();
    write_pvd([(0.0, "empty.vtu"), (0.5, "three.vtu")], &mut series).unwrap();
    is_golden("series.pvd", &series);
}

/// The lengths before the arrays lead from the first array to the end of the data.
#[test]
fn lengths_lead_through_the_data() {
    let (store, position) = store();
    let bytes = vtu(&store, position);
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let start = bytes.windows(marker.len()).position(|window| window == marker).unwrap();
    let mut rest = &bytes[start + marker.len()..];
    let head = std::str::from_utf8(&bytes[..start]).unwrap();
    let data_length = rest.len();
    for line in head.lines().filter(|line| line.starts_with("<DataArray")) {
        let offset = data_length - rest.len();
        assert!(line.ends_with(&format!("offset=\"{offset}\"/>")), "{line} is at {offset}");
        let (length, after) = rest.split_first_chunk::<8>().unwrap();
        rest = &after[usize::try_from(u64::from_le_bytes(*length)).unwrap()..];
    }
    assert_eq!(rest, b"\n</AppendedData>\n</VTKFile>\n");
}

/// More than a block of the writer; the output must not depend on block boundaries.
#[test]
fn many_particles_are_written_whole() {
    let mut store = ParticleStore::<3>::new(20_000);
    let points: Vec<[f64; 3]> = (0..20_000).map(|k| [f64::from(k), 0.5, -1.0]).collect();
    let position = store.add("position", points.clone()).unwrap();
    let bytes = vtu(&store, position);
    let mut expected = (24 * points.len() as u64).to_le_bytes().to_vec();
    expected.extend(points.iter().flatten().flat_map(|value| value.to_le_bytes()));
    assert!(bytes.windows(expected.len()).any(|window| window == expected));
}

fn refused<const D: usize>(store: &ParticleStore<D>, position: Handle<[f64; D]>) -> Error {
    let mut bytes = Vec::new();
    let error = store.write_vtu(position, &mut bytes).unwrap_err();
    assert!(bytes.is_empty(), "something was written before {error}");
    error
}

#[test]
fn what_cannot_be_drawn_is_refused_before_anything_is_written() {
    for wrong in [f64::NAN, f64::INFINITY] {
        let (mut store, position) = store();
        store.get_mut(position).unwrap()[0][1] = wrong;
        let error = refused(&store, position);
        assert_eq!(error.to_string(), "position of particle 2 is not finite");
        let (mut store, position) = self::store();
        store.set_attribute("time", Attribute::Real(wrong));
        assert!(matches!(refused(&store, position), Error::NotFinite { what } if what == "time"));
        let series = write_pvd([(wrong, "a.vtu")], Vec::new());
        assert!(matches!(series, Err(Error::NotFinite { .. })));
    }
    let mut four = ParticleStore::<4>::new(1);
    let position = four.add("position", vec![[0.0; 4]]).unwrap();
    assert!(matches!(refused(&four, position), Error::TooManyDimensions { dimension: 4 }));
}

#[test]
fn names_that_clash_or_are_no_xml_are_refused() {
    let (mut with_id, position) = store();
    with_id.add("id", vec![0_u8; 3]).unwrap();
    assert!(matches!(refused(&with_id, position), Error::DuplicateName { name } if name == "id"));
    let (mut with_time, position) = store();
    with_time.set_attribute("TimeValue", Attribute::Count(1));
    assert!(matches!(refused(&with_time, position), Error::DuplicateName { .. }));
    let (mut with_bell, position) = store();
    with_bell.add("\u{7}", vec![0_u8; 3]).unwrap();
    assert!(matches!(refused(&with_bell, position), Error::NameNotXml { .. }));
    assert!(matches!(write_pvd([(0.0, "a\nb")], Vec::new()), Err(Error::NameNotXml { .. })));
}

#[test]
fn texts_of_one_name_and_with_control_characters_are_refused() {
    let (store, position) = store();
    let refused =
        |texts: &[(&str, &str)]| store.write_vtu_with(position, texts, Vec::new()).unwrap_err();
    let twice = [("unit", "m"), ("unit", "s")];
    assert!(matches!(refused(&twice), Error::DuplicateName { name } if name == "unit"));
    assert!(matches!(refused(&[("unit", "m\0s")]), Error::NameNotXml { .. }));
}
