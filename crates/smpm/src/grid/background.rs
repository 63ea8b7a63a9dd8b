//! The background grid: nodes in tiles, allocated where particles are.

#![allow(
    clippy::inline_always,
    reason = "what is not inlined into the dispatched closure is not compiled for its registers"
)]

use simd_lanes::dispatch_narrow;

use crate::config::{Config, Contact};
use crate::error::Error;
use crate::grid::blocks::{BlockSums, Fields, fill, fill_images, place};
use crate::grid::boundary::Plane;
use crate::grid::contact::{Friction, Surface};
use crate::grid::lattice::Lattice;
use crate::grid::node::Node;
use crate::grid::tile_size::{block_edge, block_len, corner_of, tile_edge, tile_len};
use crate::grid::tiles::{Tile, Tiles};
use crate::number::CarriedNumber;
use crate::parallel::{for_each_chunk, for_each_pair_of_chunks};
use crate::points::body::Body;

/// The nodes of all tiles.
///
/// Particles of a tile write into the tile's own block, which has a halo; nodes then collect from the blocks that hold a copy
/// of them, always in the same order. No two threads write the same entry, and no bit depends on how many there are.
#[derive(Debug)]
pub(crate) struct Grid<S, const D: usize> {
    pub(crate) lattice: Lattice<D>,
    planes: Vec<Plane>,
    tiles: Tiles<D>,
    /// A block for each tile, with its halo.
    blocks: Vec<Node<S, D>>,
    /// The masses of their nodes.
    block_masses: Vec<S>,
    /// The nodes themselves: a set for each tile, no halo.
    nodes: Vec<Node<S, D>>,
    /// Their masses.
    masses: Vec<S>,
    /// Fields of nodes: one that all bodies share, or one for each. Blocks and sets of a tile are adjacent.
    n_fields: usize,
    /// Coulomb's coefficient where bodies have their own fields.
    friction: Option<f64>,
    /// The field and the velocity of a rigid body.
    rigid: Option<(usize, [f64; D])>,
    /// Like the blocks, the surfaces of the bodies; empty where they share a field.
    surfaces: Vec<Surface<S, D>>,
    /// By tile the impulse of each plane in a step.
    impulses: Vec<[f64; D]>,
}

/// What the nodes do with what particle-to-grid has summed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solve {
    /// The step; zero where velocities alone are asked for.
    pub(crate) dt: f64,
    /// Whether particles take the nodal velocity (APIC), not its change.
    pub(crate) affine: bool,
    /// Nodes lighter than this do not move: their acceleration would be a quotient of roundoff.
    pub(crate) smallest_mass: f64,
    /// Local damping (no unit).
    pub(crate) damping: f64,
    /// Whether masses were summed too; else they are those of the last time.
    pub(crate) with_mass: bool,
}

impl<S: CarriedNumber, const D: usize> Grid<S, D> {
    pub(crate) fn new(
        config: &Config<D>,
        planes: Vec<Plane>,
        bodies: &[Body<S, D>],
    ) -> Result<Self, Error> {
        let (n_fields, friction) = match config.contact {
            Contact::Friction { coefficient } if bodies.len() > 1 => {
                (bodies.len(), Some(coefficient))
            }
            _ => (1, None),
        };
        let velocities = bodies.iter().map(Body::velocity_if_rigid).enumerate();
        let mut rigid = velocities.filter_map(|(field, velocity)| Some((field, velocity?)));
        let (rigid, another) = (rigid.next(), rigid.next());
        if rigid.is_some() && (friction.is_none() || another.is_some()) {
            return Err(Error::RigidAlone);
        }
        if rigid.is_some_and(|(body, _)| bodies[body].is_loaded()) {
            return Err(Error::RigidLoaded);
        }
        Ok(Self {
            lattice: Lattice::of(config),
            planes,
            tiles: Tiles::none(),
            blocks: vec![],
            block_masses: vec![],
            nodes: vec![],
            masses: vec![],
            n_fields,
            friction,
            rigid,
            surfaces: vec![],
            impulses: vec![],
        })
    }

    /// The body that is rigid, and its velocity.
    pub(crate) fn rigid(&self) -> Option<(usize, [f64; D])> {
        self.rigid
    }

    /// Whether bodies have fields of their own.
    pub(crate) fn has_contact(&self) -> bool {
        self.friction.is_some()
    }

    /// Allocates the tiles that the particles see, and sorts the particles of every body by tile.
    pub(crate) fn allocate(&mut self, bodies: &mut [Body<S, D>]) -> Result<(), Error> {
        for body in &mut *bodies {
            body.binning.find_runs();
        }
        self.tiles.allocate(bodies.iter().map(|body| &body.binning), &self.planes)?;
        for (number, body) in bodies.iter_mut().enumerate() {
            let (Tiles { directory, all, .. }, n_fields) = (&self.tiles, self.n_fields);
            let field = number.min(n_fields - 1);
            let block_of = |slot| slot * n_fields + field;
            body.binning.bin(all.len(), |tile| directory.number(tile), block_of);
        }
        let n_sets = self.tiles.all.len() * self.n_fields;
        let zero = S::constant(0.0);
        self.blocks.resize(n_sets * block_len(D), Node::zero());
        self.block_masses.resize(n_sets * block_len(D), zero);
        self.nodes.resize(n_sets * tile_len(D), Node::zero());
        self.masses.resize(n_sets * tile_len(D), zero);
        self.impulses.resize(self.tiles.all.len() * self.planes.len(), [0.0; D]);
        if self.has_contact() {
            self.surfaces.resize(n_sets * block_len(D), Surface::none());
        }
        Ok(())
    }

    /// The nodes from one on.
    #[inline(always)]
    pub(crate) fn from(&self, node: usize) -> &[Node<S, D>] {
        &self.blocks[node..]
    }

    /// All of them, to be written.
    #[cfg(test)]
    pub(crate) fn blocks_mut(&mut self) -> &mut [Node<S, D>] {
        &mut self.blocks
    }

    /// Clears every tile's blocks, one for each field, and lets its particles add to them: `add(slot, first, blocks, masses)`
    /// with the number of their first node. Masses are cleared where they are summed too.
    pub(crate) fn sum_in_blocks(
        &mut self,
        with_mass: bool,
        add: impl Fn(usize, usize, &mut [Node<S, D>], &mut [S]) + Sync,
    ) {
        let (tiles, n_nodes) = (&self.tiles.all, self.n_fields * block_len(D));
        let both = (&mut self.blocks[..], &mut self.block_masses[..]);
        for_each_pair_of_chunks(both, n_nodes, &|slot, blocks, masses| {
            if tiles[slot].occupied {
                // Row by row: so short that plain stores do it.
                for row in blocks.chunks_mut(block_edge(D)) {
                    row.fill(Node::zero());
                }
                if with_mass {
                    masses.fill(S::constant(0.0));
                }
                add(slot, slot * n_nodes, blocks, masses);
            }
        });
    }

    /// The same for the surfaces of bodies.
    pub(crate) fn sum_surfaces_in_blocks(
        &mut self,
        add: impl Fn(usize, usize, &mut [Surface<S, D>]) + Sync,
    ) {
        let (tiles, n_nodes) = (&self.tiles.all, self.n_fields * block_len(D));
        for_each_chunk(&mut self.surfaces, n_nodes, &|slot, blocks| {
            if tiles[slot].occupied {
                blocks.fill(Surface::none());
                add(slot, slot * n_nodes, blocks);
            }
        });
    }

    /// Nodes collect what the blocks hold of them: mass, momentum, force, with the images at planes; then the velocity, its
    /// change over the step by the force and by contact, and what the planes make of them; then the blocks are filled with
    /// them again.
    ///
    /// Where masses are summed, the impulse that each plane has given in the step is added to `reactions`.
    pub(crate) fn solve(&mut self, solve: Solve, reactions: &mut [[f64; D]]) {
        self.solve_at_nodes(solve);
        if solve.with_mass && !self.planes.is_empty() {
            self.find_impulses((solve.dt, solve.affine));
            let tiles = self.tiles.all.iter().zip(self.impulses.chunks(self.planes.len()));
            for (_, impulses) in tiles.filter(|(tile, _)| !tile.plain) {
                let sums = reactions.as_flattened_mut().iter_mut();
                sums.zip(impulses.as_flattened()).for_each(|(sum, impulse)| *sum += impulse);
            }
        }
        self.fill_blocks();
    }

    /// Finds by tile what the planes have given, while the blocks hold what particles have.
    fn find_impulses(&mut self, step: (f64, bool)) {
        let Self { planes, tiles, n_fields, blocks, block_masses, nodes, rigid, .. } = self;
        let rigid = rigid.map(|(field, _)| field);
        let Tiles { directory, all: tiles, .. } = tiles;
        let (surfaces, nodes) = (&self.surfaces[..], &nodes[..]);
        let (n_fields, masses) = (*n_fields, &block_masses[..]);
        let sums =
            BlockSums { directory, tiles, planes, n_fields, blocks, masses, surfaces, rigid };
        for_each_chunk(&mut self.impulses, sums.planes.len(), &|slot, impulses| {
            let tile = &sums.tiles[slot];
            if !tile.plain {
                impulses.fill([0.0; D]);
                sums.add_reactions(tile, nodes, step, impulses);
            }
        });
    }

    fn solve_at_nodes(&mut self, solve: Solve) {
        let Tiles { directory, all: tiles, .. } = &self.tiles;
        let n_fields = self.n_fields;
        let sums = BlockSums {
            directory,
            tiles,
            planes: &self.planes,
            n_fields,
            blocks: &self.blocks,
            masses: &self.block_masses,
            surfaces: &self.surfaces,
            rigid: self.rigid.map(|(field, _)| field),
        };
        let rigid = self.rigid;
        let (friction, cell) = (self.friction, self.lattice.cell);
        let both = (&mut self.nodes[..], &mut self.masses[..]);
        for_each_pair_of_chunks(both, n_fields * tile_len(D), &|slot, owned, masses| {
            dispatch_narrow(
                #[inline(always)]
                || {
                    let acts = |plane: &Plane| {
                        plane.range_beyond(&corner_of(&tiles[slot].at), tile_edge(D)).1 >= 0
                    };
                    let is_constrained = !tiles[slot].plain && sums.planes.iter().any(acts);
                    let is_damped = solve.damping > 0.0 && solve.dt > 0.0;
                    let until = match friction {
                        None if !is_constrained && !is_damped => Until::EndOfStep,
                        _ => Until::Start,
                    };
                    for field in 0..n_fields {
                        let range = field * tile_len(D)..(field + 1) * tile_len(D);
                        let (owned, masses) = (&mut owned[range.clone()], &mut masses[range]);
                        sums.solve(&tiles[slot], (owned, masses), field, (solve, until));
                        if is_damped {
                            damp(owned, solve.damping);
                        }
                    }
                    let of_rigid = |field: usize| field * tile_len(D)..(field + 1) * tile_len(D);
                    if let Some((field, velocity)) = rigid {
                        hold(&mut owned[of_rigid(field)], &masses[of_rigid(field)], velocity);
                    }
                    if let Some(coefficient) = friction {
                        sums.let_meet(
                            &tiles[slot],
                            owned,
                            masses,
                            Friction { coefficient, affine: solve.affine },
                        );
                    }
                    if is_constrained {
                        constrain(&tiles[slot], owned, sums.planes, (solve.dt, cell));
                    } else if until == Until::Start {
                        add_changes(owned);
                    }
                    if let Some((field, velocity)) = rigid {
                        hold(&mut owned[of_rigid(field)], &masses[of_rigid(field)], velocity);
                    }
                },
            );
        });
    }

    fn fill_blocks(&mut self) {
        let Self { planes, tiles: Tiles { directory, all: tiles, .. }, nodes, n_fields, .. } = self;
        let (planes, nodes, n_fields) = (&*planes, &*nodes, *n_fields);
        for_each_chunk(&mut self.blocks, block_len(D), &|set, block| {
            let tile = &tiles[set / n_fields];
            if !tile.occupied {
                return;
            }
            let fields = Fields { n_fields, field: set % n_fields };
            fill(tile, nodes, block, fields);
            if !tile.plain {
                fill_images(planes, (directory, tile), nodes, block, fields);
            }
        });
    }

    /// Tiles that exist.
    pub(crate) fn n_tiles(&self) -> usize {
        self.tiles.all.len()
    }
}

impl<S: CarriedNumber, const D: usize> BlockSums<'_, S, D> {
    /// Nodes of a tile in one field collect what is theirs, and find their velocities.
    #[inline(always)]
    fn solve(
        &self,
        tile: &Tile<D>,
        (owned, masses): (&mut [Node<S, D>], &mut [S]),
        field: usize,
        (solve, until): (Solve, Until),
    ) {
        self.collect(tile, owned, solve.with_mass.then_some(&mut *masses), field);
        if !tile.plain {
            self.add_images(tile, owned, solve.with_mass.then_some(&mut *masses), field);
        }
        find_velocities(owned, masses, (solve, until));
    }
}

/// When the velocities of nodes are those of the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Until {
    /// At its start: contact and planes are still to come.
    Start,
    EndOfStep,
}

/// Momenta and forces become velocities and their changes: `v_i = (m v)_i / m_i`, `dt f_i / m_i`.
#[inline(always)]
fn find_velocities<S: CarriedNumber, const D: usize>(
    nodes: &mut [Node<S, D>],
    masses: &mut [S],
    (solve, until): (Solve, Until),
) {
    for (node, mass) in nodes.iter_mut().zip(masses) {
        if mass.value() <= solve.smallest_mass {
            (*node, *mass) = (Node::zero(), S::constant(0.0));
            continue;
        }
        let inverse = mass.recip();
        let by_step = inverse * solve.dt;
        for k in 0..D {
            let (velocity, change) = (node.momentum()[k] * inverse, node.force()[k] * by_step);
            let at_end = until == Until::EndOfStep;
            node.velocity_mut()[k] = if at_end { velocity + change } else { velocity };
            node.velocity_change_mut()[k] = change;
        }
    }
}

/// Local damping: a share of the change by forces, against the velocity, along each axis.
fn damp<S: CarriedNumber, const D: usize>(nodes: &mut [Node<S, D>], damping: f64) {
    for node in nodes {
        for k in 0..D {
            let (velocity, change) = (node.velocity()[k].value(), node.velocity_change()[k]);
            // Where force and velocity have one sign the force is less, else it is more.
            let along = velocity * change.value();
            let sign = if along == 0.0 { 0.0 } else { along.signum() };
            node.velocity_change_mut()[k] = change * (1.0 - damping * sign);
        }
    }
}

/// Nodes of a rigid body have its velocity, and no force changes it.
fn hold<S: CarriedNumber, const D: usize>(
    nodes: &mut [Node<S, D>],
    masses: &[S],
    velocity: [f64; D],
) {
    for (node, _) in nodes.iter_mut().zip(masses).filter(|(_, mass)| mass.value() > 0.0) {
        *node.velocity_mut() = velocity.map(S::constant);
        *node.velocity_change_mut() = [S::constant(0.0); D];
    }
}

/// Velocities at the end of the step after contact, where no plane acts.
#[inline(always)]
fn add_changes<S: CarriedNumber, const D: usize>(nodes: &mut [Node<S, D>]) {
    for node in nodes {
        for k in 0..D {
            node.velocity_mut()[k] = node.velocity()[k] + node.velocity_change()[k];
        }
    }
}

/// Sets velocities where planes act.
fn constrain<S: CarriedNumber, const D: usize>(
    tile: &Tile<D>,
    owned: &mut [Node<S, D>],
    planes: &[Plane],
    (dt, cell): (f64, f64),
) {
    for (index, node) in owned.iter_mut().enumerate() {
        let place = place::<D>(&tile.at, index % tile_len(D), tile_edge(D));
        if planes.iter().all(|plane| plane.beyond(place[plane.axis]) < 0) {
            let change = *node.velocity_change();
            for k in 0..D {
                node.velocity_mut()[k] = node.velocity()[k] + change[k];
            }
            continue;
        }
        // Mirrors hold before the step too: what the image takes from the momentum is no change.
        let mut before: [S; D] = *node.velocity();
        for plane in planes.iter().filter(|plane| plane.mirrors()) {
            plane.constrain(place[plane.axis], (dt, cell), &mut before);
        }
        let mut after: [S; D] = std::array::from_fn(|k| before[k] + node.velocity_change()[k]);
        for plane in planes {
            plane.constrain(place[plane.axis], (dt, cell), &mut after);
        }
        for k in 0..D {
            node.velocity_change_mut()[k] = after[k] - before[k];
        }
        *node.velocity_mut() = after;
    }
}
