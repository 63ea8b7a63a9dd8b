//! What bonds on a lattice of the spacing one amount to: the energy of a node, the energy of a crack.

use peridyn_sde::{
    BondConfig, Bonds, Condition, Horizon, Influence, Nodes, SurfaceCorrection, VolumeCorrection,
    critical_stretch,
};

use reference_problems::context::CaseError;

/// `E` of all lattices here.
pub const MODULUS: f64 = 3.0;

/// Without a correction of surfaces.
#[must_use]
pub fn config(
    horizon: Horizon,
    influence: Influence,
    volume_correction: VolumeCorrection,
) -> BondConfig {
    BondConfig {
        horizon,
        young_modulus: MODULUS,
        influence,
        volume_correction,
        surface_correction: SurfaceCorrection::None,
    }
}

/// Around the node in the middle of a body that holds all that it sees: twice the energy density of its bonds under a small
/// uniform strain, over `E`.
///
/// # Errors
/// Those of the body.
pub fn energy_of_middle<const D: usize>(
    condition: Condition,
    config: &BondConfig,
    strain: impl Fn(&[f64; D]) -> [f64; D],
) -> Result<f64, CaseError> {
    energy_of_node(condition, config, strain, |_| true)
}

/// The same of the node nearest to the middle, of a body of which a part is not there.
///
/// # Errors
/// Those of the body.
pub fn energy_of_node<const D: usize>(
    condition: Condition,
    config: &BondConfig,
    strain: impl Fn(&[f64; D]) -> [f64; D],
    inside: impl Fn(&[f64; D]) -> bool,
) -> Result<f64, CaseError> {
    let reach = (config.horizon.radius() + 1.0).ceil() + 0.5;
    let nodes = Nodes::lattice(1.0, ([-reach; D], [reach; D]), condition, inside)?;
    let from_middle = |x: &[f64; D]| x.iter().map(|c| c * c).sum::<f64>();
    let places = nodes.positions().iter().map(from_middle).enumerate();
    let nearest = places.min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no node")?;
    let middle = nearest.0;
    let bonds = Bonds::new(&nodes, config)?;
    let mut energy = 0.0;
    for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
        if i != middle && j != middle {
            continue;
        }
        let (a, b) = (&nodes.positions()[i], &nodes.positions()[j]);
        let (ua, ub) = (strain(a), strain(b));
        let along: f64 = (0..D).map(|k| (b[k] - a[k]) * (ub[k] - ua[k])).sum();
        let stretch = along / (bond.length * bond.length);
        // Half of a bond's energy belongs to each of its nodes.
        energy += 0.25 * bond.stiffness * bond.length * stretch * stretch;
    }
    Ok(2.0 * energy / (nodes.volumes()[middle] * config.young_modulus))
}

/// The energy of all bonds across the plane in the middle at the critical stretch, over its area and `G0`.
///
/// # Errors
/// Those of the body.
pub fn energy_of_crack<const D: usize>(
    condition: Condition,
    shells: u32,
    influence: Influence,
) -> Result<f64, CaseError> {
    let horizon = Horizon::of_shells(shells, 1.0)?;
    let release = 0.02;
    let strength = critical_stretch(release, MODULUS, horizon.radius(), influence, condition)?;
    let reach = f64::from(shells) + 1.0;
    // The plane is at zero, between two layers of nodes; to its sides the body goes on for two horizons.
    let side =
        |sign: f64| std::array::from_fn(|k| sign * if k == 0 { reach } else { 2.0 * reach + 0.5 });
    let nodes = Nodes::<D>::lattice(1.0, (side(-1.0), side(1.0)), condition, |_| true)?;
    let bonds = Bonds::new(&nodes, &config(horizon, influence, VolumeCorrection::Ramp))?;
    let across = |x: &[f64; D]| x[1..].iter().all(|c| c.abs() < 0.5);
    let mut energy = 0.0;
    for (bond, (i, j)) in bonds.all().iter().zip(bonds.pairs()) {
        let (a, b) = (&nodes.positions()[i], &nodes.positions()[j]);
        // Each bond of the column of nodes in the middle, once from each of its ends within the column.
        if a[0] * b[0] < 0.0 {
            let ends = f64::from(u8::from(across(a)) + u8::from(across(b)));
            energy += 0.25 * ends * bond.stiffness * bond.length * strength * strength;
        }
    }
    Ok(energy / condition.across() / release)
}
