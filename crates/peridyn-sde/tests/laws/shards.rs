//! Parts of an ensemble that run apart.

use peridyn_sde::statistics::DamageMap;
use peridyn_sde::{CrackShard, Error, Stiffness, Strength, merge_shards};
use sde_integrators::Noise;

use crate::given::{N_NODES, Plate, STRETCH, THRESHOLD};

/// Not a multiple of the lanes, nor of the shards.
const N: u64 = 11;

fn shard(plate: &Plate, place: (u64, u64)) -> Result<CrackShard, Error> {
    let study = plate.study(Strength::Uniform(STRETCH), Stiffness::Uniform);
    study.shard::<f64, 8>(N, place, &[0, 9])
}

#[test]
fn shards_in_any_order_are_one_run() {
    let plate = Plate::lattice();
    let study = plate.study(Strength::Uniform(STRETCH), Stiffness::Uniform);
    let whole = study.run::<f64, 8>(0..N, &[0, 9]).unwrap();
    assert!(whole.broken.iter().all(|&broken| broken > 0), "{:?}", whole.broken);
    for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        let shards = order.map(|k| shard(&plate, (k, 3)).unwrap());
        assert_eq!(merge_shards(shards.to_vec()).unwrap(), whole, "{order:?}");
    }
}

#[test]
fn shards_that_are_missing_doubled_or_foreign_are_refused() {
    let mut plate = Plate::lattice();
    let [first, second, third] = [0, 1, 2].map(|k| shard(&plate, (k, 3)).unwrap());
    let refused = |shards: &[&CrackShard]| {
        merge_shards(shards.iter().copied().cloned().collect()).unwrap_err()
    };
    assert!(matches!(refused(&[]), Error::TooFew { name: "shards", value: 0, limit: 1 }));
    // 4, 4 and 3 of them.
    let missing = |realisation| Error::Missing { realisation, n_realisations: N };
    assert_eq!(refused(&[&second, &third]), missing(0));
    assert_eq!(refused(&[&first, &third]), missing(4));
    assert_eq!(refused(&[&first, &second]), missing(8));
    let doubled = refused(&[&first, &second, &third, &third]);
    assert_eq!(doubled, Error::Doubled { realisation: 8 });
    // Realisations that have failed are in no map of damage.
    let mut failed = third.clone();
    failed.run.damage = DamageMap::new(N_NODES, THRESHOLD).unwrap();
    let doubled = refused(&[&first, &second, &third, &failed]);
    assert_eq!(doubled, Error::Doubled { realisation: 8 });
    for (number, record) in (N..).zip(&mut failed.run.records) {
        record.realisation = number;
    }
    let beyond = refused(&[&first, &second, &third, &failed]);
    assert_eq!(beyond, Error::NoSuchRealisation { realisation: N, limit: N });
    let no_such = shard(&plate, (3, 3)).unwrap_err();
    assert_eq!(no_such, Error::NoSuchShard { shard: 3, n_shards: 3 });
    plate.simulation.noise = Noise::new(12);
    let foreign = shard(&plate, (1, 3)).unwrap();
    assert_eq!(refused(&[&first, &foreign, &third]), Error::ForeignShard { shard: 1 });
}
