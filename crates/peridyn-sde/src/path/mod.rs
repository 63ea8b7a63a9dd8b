//! Cracks: connected damage that reaches from a notch, as polylines.

mod centre;
mod cluster;
mod fractured;
mod measure;

pub use fractured::Fractured;
pub(crate) use measure::height_at;
pub use measure::{Branch, CrackPath};

use crate::error::{Error, between, finite, positive};
use centre::Middles;
use cluster::{Cluster, Tree};

/// A notch in a plane: from its mouth to the tip that a crack is followed from. For a notch inside the body, which has two tips,
/// each is asked after on its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Notch {
    /// Where it begins (length).
    pub mouth: [f64; 2],
    /// Where it ends (length).
    pub tip: [f64; 2],
}

impl Notch {
    /// Its direction, of length one.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a notch without length.
    pub fn direction(&self) -> Result<[f64; 2], Error> {
        for value in self.mouth.into_iter().chain(self.tip) {
            finite("an end of the notch", value)?;
        }
        let along = [self.tip[0] - self.mouth[0], self.tip[1] - self.mouth[1]];
        let length = along[0].hypot(along[1]);
        positive("length of the notch", length)?;
        Ok(along.map(|c| c / length))
    }
}

/// What counts as a crack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathConfig {
    /// The damage from which a node is of a crack, between 0 and 1.
    pub damage: f64,
    /// A crack this short is none (length).
    pub least_length: f64,
    /// How far from the crack, along the damage, that is a branch of it which reaches there (length). Below two horizons the width
    /// of a zone of damage is taken for a branch.
    pub least_branch: f64,
}

impl PathConfig {
    /// What the tests of this crate hold against cracks that are known: damage 0.3, lengths of one and two horizons.
    #[must_use]
    pub fn of_horizon(horizon: f64) -> Self {
        Self { damage: 0.3, least_length: horizon, least_branch: 2.0 * horizon }
    }

    fn check(&self) -> Result<(), Error> {
        between("damage of a crack", self.damage, 0.0, 1.0)?;
        positive("least length of a crack", self.least_length)?;
        positive("least length of a branch", self.least_branch)
    }
}

/// The crack that has grown from the tip of a notch, with its branches; `None` where none has, which is no error. It must have a
/// node within a horizon, the longest bond, of the tip.
///
/// A broken bond alone is no crack: noise breaks some anywhere, and many break at prescribed edges. What counts is where nodes have lost a
/// large part of their bonds, and that such nodes connect to the tip of the notch:
///
/// 1. The damage of each node is the part of the stiffness of its bonds that is lost. A node is of a crack where it has lost more
///    than a threshold, and half of that not to the notch. A node next to a straight crack has lost 0.33 to 0.44 of its bonds,
///    for horizons of two to five spacings. Bonds broken at random and one by one do not reach 0.3 together and connect to the
///    tip: of 200 bodies with 8 % of them broken none has a crack with horizons of three and four spacings; with two, where a
///    node has 12 bonds, none at 2 %, 4 at 5 % and 25 at 8 %.
/// 2. Such nodes nearer than 1.75 spacings are linked: on a lattice, those beside each other or across a diagonal.
/// 3. From the tip, the shortest way along links to the node farthest along them is the crack; shortest ways have no
///    preferred direction, so that a crack may turn. What is farther than a length from it, along links, is a branch,
///    from where its shortest way leaves; and so on.
/// 4. Nodes are next to the crack, not on it. Bonds it broke have their middles on both sides of it alike, so points every
///    spacing along the way are moved across it onto the line fitted to the middles of broken bonds around them.
///
/// The path begins at the tip of the notch and ends where damage does, which is up to two spacings before the last broken bond.
/// A crack that reaches other damage, such as a broken prescribed edge, continues along it.
///
/// ```
/// use peridyn_sde::{
///     BondConfig, Bonds, Condition, Fractured, Horizon, Nodes, Notch, PathConfig, crack_path,
/// };
///
/// let plate = Condition::PlaneStress { thickness: 1.0 };
/// let nodes = Nodes::lattice(1.0, ([0.0; 2], [60.0, 40.0]), plate, |_| true)?;
/// let config = BondConfig::uncorrected(Horizon::of_shells(3, 1.0)?, 1.0);
/// let bonds = Bonds::new(&nodes, &config)?;
/// let notch = Notch { mouth: [0.0, 20.0], tip: [15.0, 20.0] };
/// let cut = bonds.across_segment(&nodes, (notch.mouth, notch.tip))?;
/// // A run would break these: a crack that rises by one in four.
/// let mut broken = vec![false; bonds.len()];
/// for bond in bonds.across_segment(&nodes, (notch.tip, [55.0, 30.0]))? {
///     broken[bond] = true;
/// }
/// let body = Fractured { nodes: &nodes, bonds: &bonds, broken: &broken, cut: &cut };
/// let path = crack_path(&body, &notch, &PathConfig::of_horizon(config.horizon.radius()))?;
/// let angle = path.map(|path| path.angle_of_fit(notch.direction()?)).transpose()?;
/// assert!(angle.is_some_and(|angle| (angle - 0.25_f64.atan()).abs() < 0.01));
/// # Ok::<(), peridyn_sde::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] for flags and bonds of another body; [`Error::Parameter`] for the configuration or the notch.
pub fn crack_path(
    body: &Fractured<'_>,
    notch: &Notch,
    config: &PathConfig,
) -> Result<Option<CrackPath>, Error> {
    body.check()?;
    config.check()?;
    let _ = notch.direction()?;
    let cluster = Cluster::new(body, config.damage)?;
    let mut tree = Tree::from_tip(&cluster, &notch.tip);
    let Some(way) = tree.longest(config.least_length) else {
        return Ok(None);
    };
    let reached = (0..cluster.nodes.len()).filter(|&member| tree.reaches(member));
    let of_crack: Vec<usize> = reached.map(|member| cluster.nodes[member]).collect();
    let middles = Middles::new(body, &of_crack, cluster.horizon);
    let places = |way: &[usize]| -> Vec<[f64; 2]> {
        way.iter().map(|&member| cluster.positions[member]).collect()
    };
    let points: Vec<_> = std::iter::once(notch.tip).chain(places(&way)).collect();
    tree.restart(&way);
    let mut arms = vec![];
    while let Some(way) = tree.longest(config.least_branch) {
        arms.push(middles.centred(&places(&way)));
        tree.plant(&way);
    }
    Ok(Some(measure::joined(middles.centred(&points), arms, cluster.horizon)))
}
