//! Plain concrete in bending, with bonds that soften: beams and an L-shaped panel, followed event by event.

use peridyn_sde::law::Bilinear;
use peridyn_sde::{
    BondConfig, Bonds, Condition, EquilibriumConfig, Horizon, Influence, Loading, Network,
    NextBreakage, Nodes, Program, QuasiStatic, SurfaceCorrection, VolumeCorrection,
    critical_stretch,
};

use crate::case::CaseError;

/// Constants of a concrete (SI units).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Concrete {
    /// `E` (Pa).
    pub(crate) young_modulus: f64,
    /// `f_t` (Pa): bonds soften from the stretch `f_t/E` on.
    pub(crate) tensile_strength: f64,
    /// `G_f` (J/m^2), under the whole falling line.
    pub(crate) fracture_energy: f64,
}

/// A lattice of concrete, in plane stress.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lattice {
    /// `dx` (m).
    pub(crate) spacing: f64,
    /// Whole spacings in a horizon.
    pub(crate) shells: u32,
}

/// A point of a test.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// Of the loaded nodes along the load (m).
    pub(crate) displacement: f64,
    /// Opening of the mouth over 20 mm about the middle of the lower edge; of the panel the displacement (m).
    pub(crate) opening: f64,
    /// Load (N).
    pub(crate) load: f64,
}

/// A test that was followed.
#[derive(Debug)]
pub(crate) struct Tested {
    /// At each breakage, before it.
    pub(crate) points: Vec<Point>,
    /// The middle of the first bond that softened (m).
    pub(crate) first: [f64; 2],
}

impl Tested {
    /// The point of the largest load.
    pub(crate) fn peak(&self) -> Result<Point, CaseError> {
        let points = self.points.iter().copied();
        points.max_by(|a, b| a.load.total_cmp(&b.load)).ok_or_else(|| "no bond softened".into())
    }

    /// The load where the opening first comes to a value, on straight lines (N).
    #[must_use]
    pub(crate) fn load_at(&self, opening: f64) -> Option<f64> {
        let start = Point { displacement: 0.0, opening: 0.0, load: 0.0 };
        let before = std::iter::once(&start).chain(&self.points);
        let (a, b) = before.zip(&self.points).find(|(_, b)| b.opening >= opening)?;
        let part = (opening - a.opening) / (b.opening - a.opening);
        Some(a.load + part * (b.load - a.load))
    }
}

/// What is tested.
struct Specimen {
    nodes: Nodes<2>,
    loading: Loading<2>,
    loaded: Vec<usize>,
    /// Nodes whose bonds do not soften: about supports and load.
    sound: Vec<bool>,
    /// Left and right of the mouth.
    mouth: [Vec<usize>; 2],
    notch: Option<[[f64; 2]; 2]>,
    until: f64,
}

/// Bonds within 2 % of the most critical one soften together, in teeth of 5 %, to a residual of a millionth.
const CONFIG: EquilibriumConfig =
    EquilibriumConfig { batch: 0.02, tolerance: 1e-6, ..EquilibriumConfig::EVENT_BY_EVENT };

/// A stretch that no bond comes to.
const SOUND: f64 = 1e3;

fn chosen(nodes: &Nodes<2>, is: impl Fn(&[f64; 2]) -> bool) -> Vec<usize> {
    let places = nodes.positions().iter().enumerate();
    places.filter(|(_, x)| is(x)).map(|(node, _)| node).collect()
}

fn sound(nodes: &Nodes<2>, about: &[([f64; 2], f64)]) -> Vec<bool> {
    let near = |x: &[f64; 2]| {
        about.iter().any(|(centre, radius)| (x[0] - centre[0]).hypot(x[1] - centre[1]) < *radius)
    };
    nodes.positions().iter().map(near).collect()
}

/// A beam of Gregoire et al. 2013, 50 mm deep, in three-point bending, with a sharp notch from below or without one (m); to an
/// opening of its mouth.
pub(crate) fn beam(
    of: Concrete,
    on: Lattice,
    notch: Option<f64>,
    until: f64,
) -> Result<Tested, CaseError> {
    let dx = on.spacing;
    let condition = Condition::PlaneStress { thickness: 0.05 };
    let nodes = Nodes::lattice(dx, ([-0.0875, 0.0], [0.0875, 0.05]), condition, |_| true)?;
    let still = || Program::Constant(0.0);
    let supports = chosen(&nodes, |x| x[1] < dx && (x[0].abs() - 0.0625).abs() < 1.01 * dx);
    let loaded = chosen(&nodes, |x| x[1] > 0.05 - dx && x[0].abs() < dx);
    let loading = Loading::new(nodes.positions().len())
        .displace(&supports, [false, true], [0.0; 2], still())?
        .velocity(&loaded, [false, true], [0.0, -1.0])?
        .displace(&loaded, [true, false], [0.0; 2], still())?;
    let about = [([0.0, 0.05], 0.006), ([0.0625, 0.0], 0.01), ([-0.0625, 0.0], 0.01)];
    let side = |sign: f64| chosen(&nodes, |x| x[1] < dx && (x[0] * sign - 0.01).abs() < 0.75 * dx);
    let mouth = [side(-1.0), side(1.0)];
    let sound = sound(&nodes, &about);
    let notch = notch.map(|depth| [[0.0, -dx], [0.0, depth]]);
    tested(Specimen { nodes, loading, loaded, sound, mouth, notch, until }, of, on)
}

/// The L-shaped panel of Winkler 2001: limbs of 250 mm, fixed below, lifted 30 mm from the free end of its upper limb; to a
/// displacement (m). With a `cut` from outside to the corner, bonds that pass outside of it are cut.
pub(crate) fn panel(
    of: Concrete,
    on: Lattice,
    until: f64,
    cut: Option<[[f64; 2]; 2]>,
) -> Result<Tested, CaseError> {
    let dx = on.spacing;
    let condition = Condition::PlaneStress { thickness: 0.1 };
    let inside = |x: &[f64; 2]| x[0] < 0.25 || x[1] > 0.25;
    let nodes = Nodes::lattice(dx, ([0.0; 2], [0.5; 2]), condition, inside)?;
    let fixed = chosen(&nodes, |x| x[1] < dx);
    let loaded =
        chosen(&nodes, |x| x[1] > 0.25 && x[1] < 0.25 + dx && (x[0] - 0.47).abs() < 1.01 * dx);
    let loading = Loading::new(nodes.positions().len()).hold(&fixed)?.velocity(
        &loaded,
        [false, true],
        [0.0, 1.0],
    )?;
    let mut sound = sound(&nodes, &[([0.47, 0.25], 0.06)]);
    for (sound, x) in sound.iter_mut().zip(nodes.positions()) {
        *sound |= x[1] < 4.0 * dx;
    }
    let mouth = [Vec::new(), Vec::new()];
    tested(Specimen { nodes, loading, loaded, sound, mouth, notch: cut, until }, of, on)
}

fn tested(specimen: Specimen, of: Concrete, on: Lattice) -> Result<Tested, CaseError> {
    let Specimen { nodes, loading, loaded, sound, mouth, notch, until } = specimen;
    let (horizon, influence) = (Horizon::of_shells(on.shells, on.spacing)?, Influence::Constant);
    let bonds = Bonds::new(
        &nodes,
        &BondConfig {
            horizon,
            young_modulus: of.young_modulus,
            influence,
            volume_correction: VolumeCorrection::Ramp,
            surface_correction: SurfaceCorrection::None,
        },
    )?;
    if loaded.is_empty() {
        return Err("no node lies under the load".into());
    }
    // Bonds that broke at their strength would take the energy G; a line that falls to the multiple m of it takes m G.
    let strength = of.tensile_strength / of.young_modulus;
    let condition = nodes.condition();
    let of_unit = critical_stretch(1.0, of.young_modulus, horizon.radius(), influence, condition)?;
    let law = Bilinear::new(of.fracture_energy / (strength / of_unit).powi(2))?;
    let strengths = bonds.pairs().map(|(i, j)| if sound[i] || sound[j] { SOUND } else { strength });
    let mut body = Network::new(nodes.clone(), bonds.clone(), law, strengths.collect())?;
    if let Some([mouth, tip]) = notch {
        body.cut(&bonds.across_segment(&nodes, (mouth, tip))?)?;
    }
    let ends: Vec<(usize, usize)> = bonds.pairs().collect();
    let mut run = QuasiStatic::new(body, loading, CONFIG)?;
    let mut found = Tested { points: Vec::new(), first: [f64::NAN; 2] };
    while let NextBreakage::At(event) = run.next_breakage()? {
        if found.points.is_empty() {
            let (i, j) = ends[event.bonds[0]];
            let [a, b] = [i, j].map(|node| nodes.positions()[node]);
            found.first = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        }
        let u = run.displacements();
        let mean = |side: &[usize]| side.iter().map(|&i| u[i][0]).sum::<f64>() / side.len() as f64;
        let opening =
            if mouth[0].is_empty() { event.factor } else { mean(&mouth[1]) - mean(&mouth[0]) };
        // The load before the breakage, by its work; all loaded nodes move by the factor.
        let load = 2.0 * event.energy[0] / event.factor;
        found.points.push(Point { displacement: event.factor, opening, load });
        if opening > until {
            break;
        }
    }
    Ok(found)
}
