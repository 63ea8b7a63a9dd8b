//! Bodies in quasi-static equilibrium while bonds break.

use peridyn_sde::law::{Bilinear, CriticalStretch, Memory};
use peridyn_sde::{
    BondList, Bonds, Breakage, Condition, EquilibriumConfig, Error, LatticeBody, Loading, Network,
    NextBreakage, Nodes, Program, QuasiStatic, Strain, envelope,
};

use crate::fixtures::{PLATE, bonded};

const CONFIG: EquilibriumConfig = EquilibriumConfig::EVENT_BY_EVENT;

/// A chain of springs, held at its left end and moved at its right one by the load.
fn chain(n: usize) -> (Nodes<1>, Bonds, Loading<1>) {
    let (nodes, bonds) = bonded(n as f64, Condition::Bar { area: 1.0 }, 1);
    let loading = Loading::new(n).hold(&[0]).unwrap();
    let loading = loading.velocity(&[n - 1], [true], [1.0]).unwrap();
    (nodes, bonds, loading)
}

/// A plate whose strengths scatter by a fixed hash, pulled at its lower and upper rows.
fn plate(n: usize) -> (Nodes<2>, Bonds, Vec<f64>, Loading<2>) {
    let (nodes, bonds) = bonded(n as f64, PLATE, 3);
    let scatter = |bond: usize| ((bond as f64 * 12.9898).sin() * 43758.5453).rem_euclid(1.0);
    let strengths = (0..bonds.len()).map(|bond| 1e-3 * (0.7 + 0.6 * scatter(bond))).collect();
    let edge: Vec<usize> = (0..n * n).filter(|&i| i < 2 * n || i >= n * (n - 2)).collect();
    let gradient = [[0.0, 0.0], [0.0, 1.0]];
    let program = Program::Linear { rate: 1.0 };
    let loading =
        Loading::new(n * n).stretch(&nodes, &edge, [true, true], gradient, program).unwrap();
    (nodes, bonds, strengths, loading)
}

type Plate = QuasiStatic<2>;

fn notched(n: usize) -> Plate {
    let (nodes, bonds, strengths, loading) = plate(n);
    let (mouth, tip) = ([0.0, 0.5 * n as f64], [0.3 * n as f64, 0.5 * n as f64]);
    let notch = bonds.across_segment(&nodes, (mouth, tip)).unwrap();
    let mut body = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Linear, &strengths).unwrap();
    for bond in notch {
        peridyn_sde::Body::set_intact(&mut body, bond, 0);
    }
    QuasiStatic::new(body, loading, CONFIG).unwrap()
}

#[test]
fn a_chain_breaks_at_its_weakest_bond_at_the_exact_load() {
    let (nodes, bonds, loading) = chain(9);
    let strengths: Vec<f64> = (0..8).map(|bond| [5e-3, 3e-3][usize::from(bond == 5)]).collect();
    let stiffness = bonds.all()[0].stiffness;
    let body = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let mut run = QuasiStatic::new(body, loading, CONFIG).unwrap();
    let NextBreakage::At(breakage) = run.next_breakage().unwrap() else { panic!("no breakage") };
    // Eight bonds of one stiffness share the extension; the factor is the extension.
    assert_eq!(breakage.bonds, [5]);
    assert!((breakage.factor / (8.0 * 3e-3) - 1.0).abs() < 1e-7, "{}", breakage.factor);
    let stored = 8.0 * 0.5 * stiffness * 3e-3_f64.powi(2);
    assert!((breakage.energy[0] / stored - 1.0).abs() < 1e-7);
    // Nothing is left of it: the bar is in two.
    assert!(breakage.energy[1] < 1e-14 * stored && (breakage.released / stored - 1.0).abs() < 1e-7);
    assert_eq!(run.next_breakage().unwrap(), NextBreakage::Separated);
    assert_eq!(run.next_breakage().unwrap(), NextBreakage::Separated);
}

/// A crack through the plate, of 10 columns of 14 bonds or so, with snap-backs on the way.
#[test]
fn a_crack_grows_through_the_plate_and_snaps_back_on_its_way() {
    let mut run = notched(14);
    let mut events = Vec::new();
    while let NextBreakage::At(event) = run.next_breakage().unwrap() {
        events.push(event);
    }
    assert!(events.len() > 100, "{}", events.len());
    let outer = envelope(&events);
    assert!(!outer.is_empty() && outer.len() + 100 < events.len(), "{outer:?}");
    assert_eq!(run.next_breakage().unwrap(), NextBreakage::Separated);
}

#[test]
fn work_is_stored_or_released() {
    let n = 14;
    let mut run = notched(n);
    let (nodes, ..) = plate(n);
    let edge: Vec<usize> = (0..n * n).filter(|&i| i < 2 * n || i >= n * (n - 2)).collect();
    let (mut work, mut released, mut before, mut slope) = (0.0, 0.0, 0.0, None);
    for _ in 0..60 {
        let NextBreakage::At(event) = run.next_breakage().unwrap() else { panic!("no breakage") };
        // Between two breakages the load-displacement curve is a line through the origin.
        let line = slope.unwrap_or(2.0 * event.energy[0] / event.factor.powi(2));
        work += 0.5 * line * (event.factor.powi(2) - before * before);
        released += event.released;
        // By the stretches of the bonds; the work is that of the reactions at the edges.
        let stored = run.energy();
        assert!(((work - released) / stored - 1.0).abs() < 1e-6, "{work} {released} {stored}");
        assert!(event.released > 0.0);
        before = event.factor;
        let of = |&node: &usize| -run.pull_on(&[node])[1] * nodes.positions()[node][1];
        slope = Some(edge.iter().map(of).sum::<f64>() / before);
    }
    assert!(released > 0.1 * work, "{released} {work}");
}

/// The first breakages of a body with a notch.
fn events(
    mut body: impl peridyn_sde::Body<f64, 2, 1> + 'static,
    notch: &[usize],
    loading: Loading<2>,
) -> Vec<Breakage> {
    for &bond in notch {
        body.set_intact(bond, 0);
    }
    let mut run = QuasiStatic::new(body, loading, CONFIG).unwrap();
    let mut found = Vec::new();
    for _ in 0..25 {
        let NextBreakage::At(event) = run.next_breakage().unwrap() else { break };
        found.push(event);
    }
    found
}

#[test]
fn lists_lattices_and_networks_break_alike_on_any_number_of_threads() {
    let (nodes, bonds, _, loading) = plate(12);
    let notch = bonds.across_segment(&nodes, ([0.0, 6.0], [4.0, 6.0])).unwrap();
    let strengths = vec![1e-3; bonds.len()];
    let list = BondList::<f64, 2, 1>::new(nodes.clone(), bonds.clone(), Strain::Linear, &strengths);
    let lattice = LatticeBody::<f64, 2>::new(nodes.clone(), bonds.clone(), Strain::Linear, 1e-3);
    let network = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let (list, lattice) = (list.unwrap(), lattice.unwrap());
    let expected = events(list.clone(), &notch, loading.clone());
    assert_eq!(expected.len(), 25);
    let others =
        [events(lattice, &notch, loading.clone()), events(network, &notch, loading.clone())];
    for other in others {
        // Mirror images are equally critical: of the two, roundoff decides.
        let factors = expected.iter().zip(&other);
        for (a, b) in factors.take(3) {
            assert!((a.factor / b.factor - 1.0).abs() < 1e-6, "{} {}", a.factor, b.factor);
        }
    }
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| events(list.clone(), &notch, loading.clone()));
        assert_eq!(found, expected, "{threads}");
    }
}

#[test]
fn a_softening_bond_follows_its_law_and_releases_its_energy() {
    // One weak bond in a bar whose other bonds are stronger: its tension falls while the others unload.
    let (nodes, bonds, loading) = chain(5);
    let stiffness = bonds.all()[0].stiffness;
    let strengths = vec![2e-3, 1e-3, 2e-3, 2e-3];
    let ductility = 8.0;
    for tooth in [0.1, 0.05] {
        let law = Bilinear::new(ductility).unwrap();
        let body = Network::new(nodes.clone(), bonds.clone(), law, strengths.clone()).unwrap();
        let config = EquilibriumConfig { tooth, ..CONFIG };
        let mut run = QuasiStatic::new(body, loading.clone(), config).unwrap();
        let (mut released, mut first, mut teeth) = (0.0, None, 0);
        while let NextBreakage::At(event) = run.next_breakage().unwrap() {
            assert_eq!(event.bonds, [1]);
            let force = 2.0 * event.energy[0] / event.factor;
            let _ = first.get_or_insert(force);
            // The law at the largest stretch: within the tooth of it.
            let stretch = event.factor - 3.0 * force / stiffness;
            let on_law = stiffness * (8e-3 - stretch).max(0.0) / 7.0;
            assert!((force - on_law).abs() < 1.3 * tooth * stiffness * 1e-3, "{force} {on_law}");
            released += event.released;
            teeth += 1;
        }
        assert!((first.unwrap() / (stiffness * 1e-3) - 1.0).abs() < 1e-6);
        assert!(teeth > 10, "{teeth}");
        let energy = 0.5 * stiffness * 1e-3 * 8e-3;
        // A tooth drops at one extension, at which the other three bonds give (1 + 3 f)/(1 + 3 f') times what the law asks for, with
        // the secants f before and f' after: at most 1.5 teeth, and more than nothing.
        let excess = released / energy - 1.0;
        assert!(excess > 0.0 && excess < 1.5 * tooth, "{tooth}: {excess}");
    }
}

#[test]
fn a_loaded_part_that_comes_loose_ends_the_run_and_one_that_never_was_held_is_refused() {
    let (nodes, bonds, _) = chain(6);
    let strengths = vec![1e-3; bonds.len()];
    let body = Network::new(nodes, bonds, CriticalStretch, strengths).unwrap();
    let program = Program::Linear { rate: 1.0 };
    let held = Loading::new(6).hold(&[0]).unwrap();
    let hung = held.force(&[5], &[[1.0]], program).unwrap();
    let mut run = QuasiStatic::new(body.clone(), hung, CONFIG).unwrap();
    assert_eq!(run.next_breakage().unwrap(), NextBreakage::Separated);
    assert!((run.load() / (body.bonds().all()[0].stiffness * 1e-3) - 1.0).abs() < 1e-6);
    let free = Loading::new(6).force(&[5], &[[1.0]], program).unwrap();
    let mut run = QuasiStatic::new(body, free, CONFIG).unwrap();
    assert_eq!(run.next_breakage().unwrap_err(), Error::SingularStiffness);
}

#[test]
fn what_cannot_be_is_refused() {
    let (nodes, bonds, loading) = chain(6);
    let strengths = vec![1e-3; bonds.len()];
    let body =
        || Network::new(nodes.clone(), bonds.clone(), CriticalStretch, strengths.clone()).unwrap();
    let refused = |config| QuasiStatic::new(body(), loading.clone(), config).unwrap_err();
    let error = refused(EquilibriumConfig { batch: 1.0, ..CONFIG });
    assert_eq!(error.to_string(), "batch of bonds is 1; it must lie between 0 and 1");
    assert!(matches!(
        refused(EquilibriumConfig { tolerance: 0.0, ..CONFIG }),
        Error::Parameter { .. }
    ));
    assert!(matches!(
        refused(EquilibriumConfig { most_iterations: 0, ..CONFIG }),
        Error::TooFew { .. }
    ));
    assert!(matches!(
        refused(EquilibriumConfig { tooth: f64::NAN, ..CONFIG }),
        Error::Parameter { .. }
    ));
    let all: Vec<usize> = (0..6).collect();
    let fixed = Loading::new(6).hold(&all).unwrap();
    let error = QuasiStatic::new(body(), fixed, CONFIG).unwrap_err();
    assert_eq!(error, Error::NoFreeNode { n_nodes: 6 });
    let ramp = Program::Ramp { rate: 1.0, until: 2.0 };
    let ramped = Loading::new(6).hold(&[0]).unwrap().displace(&[5], [true], [1.0], ramp).unwrap();
    let error = QuasiStatic::new(body(), ramped, CONFIG).unwrap_err();
    assert_eq!(error, Error::NotProportional);
    let memory = Memory::new(1.0, 1.0, (1.0, 1.0), 0.5).unwrap();
    let wears = Network::new(nodes.clone(), bonds.clone(), memory, strengths.clone()).unwrap();
    let error = QuasiStatic::new(wears, loading.clone(), CONFIG).unwrap_err();
    assert_eq!(error, Error::NotPiecewiseLinear);
    let short = EquilibriumConfig { most_iterations: 1, tolerance: 1e-13, ..CONFIG };
    let (nodes, bonds, strengths, loading) = plate(20);
    let list = BondList::<f64, 2, 1>::new(nodes, bonds, Strain::Linear, &strengths).unwrap();
    let mut run = QuasiStatic::new(list, loading, short).unwrap();
    let error = run.next_breakage().unwrap_err();
    assert!(matches!(error, Error::NotInEquilibrium { iterations: 1, .. }), "{error}");
}
