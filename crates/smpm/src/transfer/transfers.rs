//! The transfers between particles and grid: `f64` in lanes, numbers with derivatives one particle at a time.

use std::any::Any;

use simd_lanes::SimdLevel;

use crate::config::Config;
use crate::grid::background::Grid;
use crate::grid::node::Node;
use crate::number::CarriedNumber;
use crate::points::body::Body;
use crate::points::particles::Chunk;
use crate::transfer::grid_to_group::grid_to_groups;
use crate::transfer::group::LANES;
use crate::transfer::group_to_grid::groups_to_grid;
use crate::transfer::particle_motion::GridToParticle;
use crate::transfer::particle_terms::{Given, ParticleToGrid};
use crate::transfer::velocity_gradients::VelocityGradients;

/// Adds the particles of a body in a tile, by its slot, to the tile's blocks, which begin with a node number.
type ToGrid<S, const D: usize> =
    fn(SimdLevel, &ParticleToGrid<D>, (&Body<S, D>, usize), (usize, &mut [Node<S, D>], &mut [S]));

/// A pass over a chunk of particles; writes their velocity gradients.
type ToParticles<S, const D: usize> = fn(
    SimdLevel,
    &GridToParticle<D>,
    &Grid<S, D>,
    (&mut Chunk<'_, S, D>, &mut VelocityGradients<S>),
);

/// Transfers of particles in lanes.
struct InLanes<S: CarriedNumber, const D: usize> {
    to_grid: ToGrid<S, D>,
    to_particles: ToParticles<S, D>,
}

impl<const D: usize> InLanes<f64, D> {
    const HERE: Self = Self { to_grid: groups_to_grid::<D>, to_particles: grid_to_groups::<D> };
}

static IN_ONE: InLanes<f64, 1> = InLanes::HERE;
static IN_TWO: InLanes<f64, 2> = InLanes::HERE;
static IN_THREE: InLanes<f64, 3> = InLanes::HERE;

/// Sums what is `given` at the nodes of all blocks, under the gravity of the step.
pub(crate) fn particle_to_grid<S: CarriedNumber, const D: usize>(
    grid: &mut Grid<S, D>,
    bodies: &[Body<S, D>],
    (config, gravity): (&Config<D>, [f64; D]),
    given: Given,
) {
    let transfer = ParticleToGrid { gravity, ..ParticleToGrid::of(config, given) };
    let in_lanes = in_lanes::<S, D>();
    grid.sum_in_blocks(given != Given::Momentum, |slot, first, nodes, masses| {
        for body in bodies {
            if let Some(in_lanes) = in_lanes
                && body.n_particles() >= LANES
            {
                let level = SimdLevel::best();
                (in_lanes.to_grid)(level, &transfer, (body, slot), (first, nodes, masses));
            } else {
                transfer.one_by_one(body, slot, (first, nodes, masses));
            }
        }
    });
}

/// Updates all particles of a chunk as a pass requires; writes their velocity gradients.
pub(crate) fn grid_to_particle<S: CarriedNumber, const D: usize>(
    transfer: &GridToParticle<D>,
    grid: &Grid<S, D>,
    chunk: &mut Chunk<'_, S, D>,
    gradients: &mut VelocityGradients<S>,
) {
    if let Some(in_lanes) = in_lanes::<S, D>()
        && chunk.len() >= LANES
    {
        (in_lanes.to_particles)(SimdLevel::best(), transfer, grid, (chunk, gradients));
    } else {
        transfer.one_by_one(grid, chunk, gradients);
    }
}

/// The transfers in lanes, for `f64`.
fn in_lanes<S: CarriedNumber, const D: usize>() -> Option<&'static InLanes<S, D>> {
    let all: [&'static dyn Any; 3] = [&IN_ONE, &IN_TWO, &IN_THREE];
    all.into_iter().find_map(<dyn Any>::downcast_ref)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Geometry, Transfer};
    use crate::grid::tile_size::block_len;
    use crate::points::fill::Fill;
    use crate::points::particles::BATCH;
    use crate::transfer::particle_motion::Pass;
    use crate::transfer::shape::Shape;
    use constitutive_models::{LinearElasticParameters, LinearElasticSolid};

    /// Numbers from 0 to 1 (Steele, Lea & Flood 2014).
    struct Draws(u64);

    impl Draws {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// Particles of different states, about two in a cell, in the order of their cells except for some that have just moved, and
    /// their grid.
    fn scene<const D: usize>(n: usize, config: &Config<D>) -> (Body<f64, D>, Grid<f64, D>) {
        let mut draws = Draws(n as u64);
        // The places extend over several tiles.
        let width = 0.5 + (0.5 * n as f64).powf(1.0 / D as f64);
        let mut place = || std::array::from_fn(|_| 6.3 + width * draws.next());
        let fill = Fill { positions: (0..n).map(|_| place()).collect(), spacing: [0.5; D] };
        let elastic =
            LinearElasticParameters { density: 1.0, young_modulus: 7.0, poisson_ratio: 0.3 };
        let material = LinearElasticSolid::<f64>::linear_elastic(elastic).unwrap();
        let mut body = Body::new(material, &fill, [0.3; D]).unwrap();
        body.particles.prepare(config);
        let mut bodies = [body];
        let mut grid = Grid::new(config, vec![], &bodies).unwrap();
        for round in 0..2 {
            let body = &mut bodies[0];
            let shift = if round == 0 { 0.0 } else { 0.05 };
            for p in 0..n {
                assert!(body.visit_numbers(p, &mut |x| *x += shift * (draws.next() - 0.5)));
            }
            let (particles, binning) = (&body.particles, &mut body.binning);
            let bases = &mut binning.bases;
            grid.lattice.find_lowest_nodes(config.shape, &particles.position, bases);
            grid.allocate(&mut bodies).unwrap();
            if round == 0 {
                bodies[0].sort(&mut vec![]);
            }
        }
        for number in grid.blocks_mut().iter_mut().flat_map(Node::numbers_mut) {
            *number = draws.next() - 0.5;
        }
        let [body] = bodies;
        (body, grid)
    }

    const TRANSFERS: [Transfer; 2] = [Transfer::Flip, Transfer::Apic];
    const SHAPES: [Shape; 2] = [Shape::QuadraticBSpline, Shape::CubicBSpline];

    /// Every shape function and transfer, with and without gravity, axisymmetric or not, from four particles on.
    fn for_each_scene<const D: usize>(
        check: impl Fn(&str, &Config<D>, &dyn Fn() -> (Body<f64, D>, Grid<f64, D>)),
    ) {
        for (shape, transfer) in
            SHAPES.into_iter().flat_map(|shape| TRANSFERS.map(|transfer| (shape, transfer)))
        {
            for (gravity, geometry) in [
                (0.0, Geometry::Cartesian),
                (-9.0, Geometry::Cartesian),
                (0.0, Geometry::Axisymmetric),
            ] {
                if geometry == Geometry::Axisymmetric && D != 2 {
                    continue;
                }
                let plain = Config::with_cell(1.0);
                let config = Config { shape, transfer, geometry, gravity: [gravity; D], ..plain };
                for n in [LANES, LANES + 1, 7, 61] {
                    let name =
                        format!("{n} in {D}: {shape:?}, {transfer:?}, {gravity}, {geometry:?}");
                    check(&name, &config, &|| scene(n, &config));
                }
            }
        }
    }

    fn numbers<const D: usize>(nodes: &[Node<f64, D>], masses: &[f64]) -> Vec<f64> {
        nodes.iter().flat_map(Node::numbers).chain(masses).copied().collect()
    }

    /// Adds particles to the nodes and masses of a tile's blocks.
    type ToBlocks<'a, const D: usize> = dyn Fn(&mut [Node<f64, D>], &mut [f64]) + 'a;

    fn check_to_grid<const D: usize>() {
        for_each_scene::<D>(|name, config, scene| {
            let (body, grid) = scene();
            for given in [Given::Momentum, Given::MassMomentumAndForce] {
                let transfer = ParticleToGrid::of(config, given);
                for slot in 0..grid.n_tiles() {
                    let first = slot * block_len(D);
                    let with = |add: &ToBlocks<'_, D>| {
                        let mut nodes = vec![Node::zero(); block_len(D)];
                        let mut masses = vec![0.0; block_len(D)];
                        add(&mut nodes, &mut masses);
                        numbers(&nodes, &masses)
                    };
                    let alone = with(&|nodes, masses| {
                        transfer.one_by_one(&body, slot, (first, nodes, masses));
                    });
                    let to_grid = InLanes::<f64, D>::HERE.to_grid;
                    let mut bits = vec![];
                    for level in SimdLevel::available() {
                        let sums = with(&|nodes, masses| {
                            to_grid(level, &transfer, (&body, slot), (first, nodes, masses));
                        });
                        let largest = alone.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                        for (sum, alone) in sums.iter().zip(&alone) {
                            // Roundoff: the terms may cancel.
                            let error = (sum - alone).abs();
                            assert!(error <= 1e-15 * largest, "{name}, {given:?}: {error:e}");
                        }
                        bits.push(sums.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
                    }
                    assert!(bits.iter().all(|of| *of == bits[0]), "{name}, {given:?}");
                }
            }
        });
    }

    #[test]
    fn sums_of_groups_are_those_of_their_particles_with_the_same_bits_at_every_level() {
        check_to_grid::<1>();
        check_to_grid::<2>();
        check_to_grid::<3>();
    }

    /// All that a pass writes.
    fn written<const D: usize>(
        config: &Config<D>,
        pass: Pass,
        scene: (Body<f64, D>, Grid<f64, D>),
        work: impl Fn(
            &GridToParticle<D>,
            &Grid<f64, D>,
            &mut Chunk<'_, f64, D>,
            &mut VelocityGradients<f64>,
        ),
    ) -> Vec<f64> {
        let (mut body, grid) = scene;
        let mut gradients = vec![];
        let transfer = GridToParticle::of(grid.lattice, config, pass, 0.01).of_body(&body);
        let n = body.n_particles();
        for begin in (0..n).step_by(BATCH) {
            let batch = begin..n.min(begin + BATCH);
            let mut of_batch = VelocityGradients::zero();
            work(&transfer, &grid, &mut body.for_pass().0.part(batch.clone()), &mut of_batch);
            gradients.extend((0..batch.len()).map(|p| of_batch.get(p)));
        }
        let of = &body.particles;
        let vectors = [&of.position, &of.velocity, &of.displacement];
        let vectors = vectors.into_iter().flat_map(|column| column.as_flattened());
        let matrices = of.affine.as_flattened().as_flattened();
        let gradients = gradients.as_flattened().as_flattened();
        vectors.chain(matrices).chain(gradients).copied().collect()
    }

    fn check_to_particles<const D: usize>() {
        for_each_scene::<D>(|name, config, scene| {
            let to_particles = InLanes::<f64, D>::HERE.to_particles;
            for pass in [Pass::Velocity, Pass::StressAndMove] {
                let alone = written(config, pass, scene(), |transfer, grid, chunk, gradients| {
                    transfer.one_by_one(grid, chunk, gradients);
                });
                for level in SimdLevel::available() {
                    let together =
                        written(config, pass, scene(), |transfer, grid, chunk, gradients| {
                            to_particles(level, transfer, grid, (chunk, gradients));
                        });
                    assert!(alone == together, "{name}, {pass:?}, {level}");
                }
            }
        });
    }

    #[test]
    fn a_particle_in_a_group_has_the_motion_that_it_has_alone() {
        check_to_particles::<1>();
        check_to_particles::<2>();
        check_to_particles::<3>();
    }
}
