//! The note's bonds to the letter against those that are meant: where they are off, and by how much (`docs/errata.md`).

use peridyn_sde::{BondConfig, Bonds, Condition, Horizon, Nodes, NoteAsPrinted};

/// The stiffness of every bond as printed is one factor of that of the bond that is meant.
fn is_off_by<const D: usize>(condition: Condition, spacing: f64, factor: f64) {
    let horizon = Horizon::of_shells(3, spacing).unwrap();
    let nodes = Nodes::lattice(spacing, ([0.0; D], [8.0 * spacing; D]), condition, |_| true);
    let nodes = nodes.unwrap();
    let config = BondConfig::uncorrected(horizon, 3.0 * (1.0 - 2.0 * condition.poisson_ratio()));
    let meant = Bonds::new(&nodes, &config).unwrap();
    let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: horizon.radius(), eta: 1.0 };
    let printed = note.bonds(&nodes).unwrap();
    assert_eq!(printed.len(), meant.len());
    for (printed, meant) in printed.all().iter().zip(meant.all()) {
        let off = printed.stiffness / meant.stiffness / factor - 1.0;
        // A product of ten numbers.
        assert!(off.abs() < 1e-14, "{condition:?}, dx = {spacing}: {off:e}");
    }
}

/// `18 K/(pi delta^4)` is the constant of three dimensions, and eq 3 weighs a bond by the volume of one end. In a plate
/// `12 E/(pi delta^4)` is over `9 E/(pi delta^3 t)`, with `K = E/(3 (1 - 2 nu)) = E`.
#[test]
fn the_notes_stiffness_is_off_by_dimension_and_by_the_volume_of_an_end() {
    let thickness = 0.7;
    for spacing in [1.0_f64, 0.5] {
        let of_plate = 2.0 * thickness / (3.015 * spacing) / (thickness * spacing.powi(2));
        is_off_by::<2>(Condition::PlaneStress { thickness }, spacing, of_plate);
        is_off_by::<3>(Condition::Solid, spacing, spacing.powi(3).recip());
    }
}

/// With a horizon of three whole spacings and `<` none of that length is meant; with dx = 1 no product is rounded and none is there,
/// and roundoff keeps up to six of ten at other spacings.
#[test]
fn roundoff_decides_which_bonds_a_horizon_of_whole_spacings_has() {
    let mut shares = Vec::new();
    for spacing in [1.0, 0.1, 1.0 / 30.0, 1e-3] {
        let side = 40_u32;
        let corner = f64::from(side) * spacing;
        let plate = Condition::PlaneStress { thickness: 1.0 };
        let nodes = Nodes::lattice(spacing, ([0.0; 2], [corner; 2]), plate, |_| true).unwrap();
        let reach = 3.0 * spacing;
        let note = NoteAsPrinted { bulk_modulus: 1.0, horizon: reach, eta: 1.0 };
        let longest = |length: f64| length > 2.9 * spacing;
        let bonds = note.bonds(&nodes).unwrap();
        let found = bonds.all().iter().filter(|bond| longest(bond.length)).count();
        // The print, pair by pair, in the same arithmetic.
        let x = nodes.positions();
        let pairs = (0..x.len()).flat_map(|i| (i + 1..x.len()).map(move |j| (i, j)));
        let lengths =
            pairs.map(|(i, j)| ((x[j][0] - x[i][0]).powi(2) + (x[j][1] - x[i][1]).powi(2)).sqrt());
        let printed = lengths.filter(|&length| longest(length) && length < reach).count();
        assert_eq!(found, printed, "dx = {spacing}");
        shares.push(found as f64 / f64::from(2 * side * (side - 3)));
    }
    let most = shares.iter().copied().fold(0.0, f64::max);
    assert!(shares[0] <= 0.0 && (0.55..0.65).contains(&most), "{shares:?}");
}
