//! Every source that a page cites is an entry of the bibliography, with its year.

use std::path::Path;

use scenes::fpk::sources::{
    AU_BECK_2001, CANOR_2013, GIRSANOV_1960, MACKE_2003, ROBERTS_1990, SCHARFETTER_1969,
};
use scenes::peridyn::sources::{OHAGAN_2006, PARKS_2008, TIM_2019, VEHTARI_2021, WOOD_2010};
use scenes::smpm::sources::{CHEN_2019, JOE_KUO_2008, NEYER_1994, RECHT_IPSON_1963, SALTELLI_2010};

#[test]
fn every_source_is_an_entry_of_the_bibliography_with_its_year() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/references.bib");
    let bibliography = std::fs::read_to_string(path).unwrap();
    for source in [
        CANOR_2013,
        ROBERTS_1990,
        SCHARFETTER_1969,
        GIRSANOV_1960,
        MACKE_2003,
        AU_BECK_2001,
        CHEN_2019,
        JOE_KUO_2008,
        SALTELLI_2010,
        NEYER_1994,
        RECHT_IPSON_1963,
        PARKS_2008,
        TIM_2019,
        WOOD_2010,
        OHAGAN_2006,
        VEHTARI_2021,
    ] {
        let (_, entry) = bibliography.split_once(&format!("{{{},", source.key)).unwrap();
        let entry = &entry[..entry.find("\n}").unwrap()];
        let (_, year) = source.text.split_once('(').unwrap();
        let year = &year[..4];
        assert!(entry.contains(&format!("{{{year}}}")), "{} {year}", source.key);
    }
}
