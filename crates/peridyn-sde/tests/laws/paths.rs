//! Paths of cracks that are known: bonds across a line are broken, and more at random.

use peridyn_sde::{
    BondConfig, Bonds, Condition, CrackPath, Error, Fractured, Horizon, Nodes, Notch, PathConfig,
    crack_path,
};
use sde_integrators::{Noise, Purpose};

/// A plate of the height 1 and the length 1.5, whose notch ends at (0.3, 0.5), with a crack.
#[derive(Clone)]
struct Plate {
    nodes: Nodes<2>,
    bonds: Bonds,
    broken: Vec<bool>,
    cut: Vec<usize>,
}

const TIP: [f64; 2] = [0.3, 0.5];
const NOTCH: Notch = Notch { mouth: [-0.1, 0.5], tip: TIP };

impl Plate {
    /// With nodes moved at random by up to `shaken` spacings along each axis.
    fn shaken(rows: usize, shells: u32, shaken: f64) -> Self {
        let dx = 1.0 / rows as f64;
        let condition = Condition::PlaneStress { thickness: 1.0 };
        let lattice = Nodes::lattice(dx, ([0.0; 2], [1.5, 1.0]), condition, |_| true).unwrap();
        let mut stream = Noise::new(5).stream(Purpose::Field, 1);
        let places = lattice.positions().iter();
        let places = places
            .map(|x| x.map(|c| c + dx * shaken * (2.0 * stream.next_uniform() - 1.0)))
            .collect();
        let nodes = Nodes::new(places, lattice.volumes().to_vec(), dx, condition).unwrap();
        let config = BondConfig::uncorrected(Horizon::of_shells(shells, dx).unwrap(), 1.0);
        let bonds = Bonds::new(&nodes, &config).unwrap();
        let cut = bonds.across_segment(&nodes, (NOTCH.mouth, NOTCH.tip)).unwrap();
        let mut broken = vec![false; bonds.len()];
        for &bond in &cut {
            broken[bond] = true;
        }
        Self { nodes, bonds, broken, cut }
    }

    fn new(rows: usize, shells: u32) -> Self {
        Self::shaken(rows, shells, 0.0)
    }

    fn crack(mut self, line: &[[f64; 2]]) -> Self {
        for pair in line.windows(2) {
            match self.bonds.across_segment(&self.nodes, (pair[0], pair[1])) {
                Ok(cut) => cut.into_iter().for_each(|bond| self.broken[bond] = true),
                // A short piece may lie between bonds.
                Err(error) => assert_eq!(error, Error::NotchOutsideBody),
            }
        }
        self
    }

    /// A share of all bonds is broken, anywhere.
    fn background(mut self, share: f64, seed: u64) -> Self {
        let mut stream = Noise::new(seed).stream(Purpose::Field, 0);
        for broken in &mut self.broken {
            *broken |= stream.next_uniform() < share;
        }
        self
    }

    fn path(&self) -> Option<CrackPath> {
        let Self { nodes, bonds, broken, cut } = self;
        let horizon = bonds.all().iter().fold(0.0, |most, bond| f64::max(most, bond.length));
        let body = Fractured { nodes, bonds, broken, cut };
        crack_path(&body, &NOTCH, &PathConfig::of_horizon(horizon)).unwrap()
    }

    fn dx(&self) -> f64 {
        self.nodes.spacing()
    }
}

fn ray(angle: f64, length: f64) -> [f64; 2] {
    [TIP[0] + length * angle.cos(), TIP[1] + length * angle.sin()]
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A straight crack along the lattice: its middle coincides with the middle between two rows, where the notch is.
#[test]
fn a_straight_crack_is_a_straight_line() {
    for shells in 2..=5 {
        let plate = Plate::new(40, shells).crack(&[TIP, [1.0, 0.5]]);
        let (path, dx) = (plate.path().unwrap(), plate.dx());
        // The second fit starts from the first, which near the tip looks at a window a little askew: 8e-4 spacings.
        assert!(path.points().iter().all(|x| (x[1] - 0.5).abs() < 0.01 * dx), "{shells}");
        assert!(path.height_at(0.7).is_some_and(|y| (y - 0.5).abs() < 0.01 * dx));
        // Damage ends up to two spacings before the last broken bond.
        assert!((path.tip()[0] - 1.0).abs() < 2.0 * dx && path.height_at(1.1).is_none());
        assert!((path.length() - 0.7).abs() < 2.0 * dx && path.branches().is_empty());
    }
}

/// Cracks of 25 spacings, at 13 angles to the lattice, with 2 % of all bonds broken besides. Measured over these: angles of the
/// fit within 0.7 degrees, points within 0.75 spacings, tips within 1.1.
#[test]
fn the_angle_of_an_oblique_crack_is_found_within_a_degree() {
    for shells in [2, 3, 4] {
        let body = Plate::new(64, shells).background(0.02, 3);
        for sixth in -6..=6 {
            let angle = f64::from(sixth) * 14.0_f64.to_radians();
            let mut plate = body.clone();
            let dx = plate.dx();
            plate = plate.crack(&[TIP, ray(angle, 25.0 * dx)]);
            let path = plate.path().unwrap();
            let fit = path.angle_of_fit(NOTCH.direction().unwrap()).unwrap();
            let label = format!("{shells} shells, {angle}");
            assert!((fit - angle).abs() < 1_f64.to_radians(), "{label}: {fit}");
            assert!(apart(path.tip(), ray(angle, 25.0 * dx)) < 2.0 * dx, "{label}");
            assert!(path.branches().is_empty(), "{label}");
            for point in path.points() {
                let off = (point[0] - TIP[0]) * angle.sin() - (point[1] - TIP[1]) * angle.cos();
                assert!(off.abs() < dx, "{label}: {point:?}");
            }
        }
    }
}

/// Half a spacing: the points are means over windows of some 4 spacings. Measured: 0.3 at most, 0.15 in the mean square.
#[test]
fn a_wavy_crack_is_followed() {
    for shells in [2, 3, 4] {
        let plate = Plate::new(64, shells).background(0.02, 4);
        let dx = plate.dx();
        let height =
            |x: f64| 0.5 + 5.0 * dx * (std::f64::consts::TAU * (x - TIP[0]) / (35.0 * dx)).sin();
        let at = |step: u32| {
            let x = TIP[0] + f64::from(step) * 0.005;
            [x, height(x)]
        };
        let plate = plate.crack(&(0..=240).map(at).collect::<Vec<_>>());
        let path = plate.path().unwrap();
        for step in 0..100 {
            let x = TIP[0] + 0.0115 * f64::from(step);
            let off = path.height_at(x).unwrap() - height(x);
            assert!(off.abs() < 0.5 * dx, "{shells} shells at {x}: {} spacings", off / dx);
        }
        // It leaves the plate, as far as there are nodes.
        assert!(path.tip()[0] > 1.5 - 2.0 * dx && path.branches().is_empty());
    }
}

/// Two arms that enclose 40 to 120 degrees, symmetric to the lattice and turned against it.
#[test]
fn a_branch_is_found_with_its_tip_and_where_it_begins() {
    for shells in [2, 3, 4] {
        let body = Plate::new(64, shells).background(0.02, 5);
        let dx = body.dx();
        for (half, turn) in [(20.0_f64, 0.0_f64), (30.0, 13.0), (40.0, 0.0), (60.0, 13.0)] {
            let (half, turn) = (half.to_radians(), turn.to_radians());
            let fork = ray(turn, 20.3 * dx);
            let arm = |angle: f64, length: f64| {
                [fork[0] + length * dx * angle.cos(), fork[1] + length * dx * angle.sin()]
            };
            let ends = [arm(turn + half, 24.0), arm(turn - half, 20.0)];
            let plate = body.clone().crack(&[TIP, fork, ends[0]]).crack(&[fork, ends[1]]);
            let path = plate.path().unwrap();
            let label = format!("{shells} shells, {half} {turn}");
            assert_eq!(path.tips().len(), 2, "{label}");
            for (tip, end) in path.tips().into_iter().zip(ends) {
                assert!(apart(tip, end) < 2.0 * dx, "{label}: {tip:?} {end:?}");
            }
            let start = path.branches()[0].start();
            assert!(apart(start, fork) < 2.0 * dx, "{label}: {start:?} {fork:?}");
        }
    }
}

/// Of 200 seeds none gives a crack with 3 and 4 shells at 5 and 8 %, or with 2 shells at 2 %; with 2 shells, where a node has 12
/// bonds, 4 do at 5 %.
#[test]
fn bonds_broken_at_random_are_no_crack() {
    for (shells, share) in [(2, 0.02), (3, 0.05)] {
        let body = Plate::new(40, shells);
        assert_eq!(body.path(), None, "the notch alone");
        for seed in 0..20 {
            assert_eq!(body.clone().background(share, seed).path(), None, "{shells} {seed}");
        }
    }
}

#[test]
fn broken_grips_and_other_cracks_do_not_touch_the_path() {
    let plain = Plate::new(64, 3).crack(&[TIP, [1.2, 0.6]]).path().unwrap();
    let plate = Plate::new(64, 3)
        .crack(&[TIP, [1.2, 0.6]])
        .crack(&[[-0.1, 0.05], [1.6, 0.05]])
        .crack(&[[-0.1, 0.95], [1.6, 0.95]])
        .crack(&[[1.6, 0.8], [0.9, 0.7]]);
    assert_eq!(plate.path().unwrap(), plain);
}

/// Nodes moved by up to 0.3 spacings along each axis.
#[test]
fn scattered_nodes_show_the_crack_as_a_lattice_does() {
    for shells in [3, 4] {
        let plate = Plate::shaken(64, shells, 0.3).crack(&[TIP, ray(0.3, 0.5)]).background(0.02, 1);
        let path = plate.path().unwrap();
        assert!((path.angle_of_fit([1.0, 0.0]).unwrap() - 0.3).abs() < 1_f64.to_radians());
        assert!(apart(path.tip(), ray(0.3, 0.5)) < 2.0 * plate.dx());
    }
}

#[test]
fn flags_and_limits_that_cannot_be_are_refused() {
    let plate = Plate::new(20, 2);
    let Plate { nodes, bonds, broken, cut } = &plate;
    let body = Fractured { nodes, bonds, broken, cut };
    let config = PathConfig::of_horizon(0.1);
    let short = Fractured { broken: &broken[1..], ..body };
    let error = crack_path(&short, &NOTCH, &config).unwrap_err();
    assert!(matches!(error, Error::Length { name: "flags of broken bonds", .. }));
    let strange = Fractured { cut: &[bonds.len()], ..body };
    assert!(matches!(crack_path(&strange, &NOTCH, &config), Err(Error::Length { .. })));
    let all = PathConfig { damage: 1.0, ..config };
    assert!(matches!(crack_path(&body, &NOTCH, &all), Err(Error::Parameter { .. })));
    let none = PathConfig { least_length: 0.0, ..config };
    assert!(matches!(crack_path(&body, &NOTCH, &none), Err(Error::Parameter { .. })));
    let point = Notch { mouth: TIP, tip: TIP };
    assert!(matches!(crack_path(&body, &point, &config), Err(Error::Parameter { .. })));
}
