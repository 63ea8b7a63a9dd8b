//! The plate of a crack scene: nodes from a lattice or a file, and their bonds.

use peridyn_sde::law::Bilinear;
use peridyn_sde::{
    BondConfig, BondOrder, BondValue, Bonds, Breaking, Condition, DisorderField, Error, Horizon,
    LatticeBody, Nodes, SolidBonds, Stiffness, Strain, Strength, StudyLaw, WeibullStrength,
    critical_stretch, critical_stretch_of_solid,
};
use random_fields::{Correlation, GaussianField};
use scene_runs::scene::Objection;

use super::points::Cloud;
use super::positive::positive;
use super::scene::CrackScene;
use super::scene_body::{BodyScene, LawScene, ToughnessScene};
use super::scene_field::{FieldScene, VariationScene};

/// Largest variance that a field on irregular points may omit at a point before it is rescaled to one.
const LEFT_OUT: f64 = 1e-2;

/// The initial plate.
#[derive(Debug)]
pub(super) struct Plate {
    pub(super) nodes: Nodes<2>,
    pub(super) bonds: Bonds,
    pub(super) law: PlateLaw,
    pub(super) strain: Strain,
    /// Horizon (m).
    pub(super) horizon: f64,
    /// Critical stretch `s0`.
    pub(super) stretch: f64,
    pub(super) cut_bonds: usize,
    /// File of the nodes.
    pub(super) cloud: Option<Cloud>,
}

/// How its bonds pull.
#[derive(Debug)]
pub(super) enum PlateLaw {
    /// Bonds have a pair potential, up to their strength.
    BondBased,
    /// Bonds have a pair potential, and soften from their strength on.
    Softening(Bilinear),
    /// The body is a linear peridynamic solid.
    LinearSolid(SolidBonds),
}

impl PlateLaw {
    /// The law in the form that a study borrows.
    pub(super) const fn of_study(&self) -> StudyLaw<'_> {
        match self {
            Self::BondBased => StudyLaw::BondBased,
            Self::Softening(law) => StudyLaw::Softening(*law),
            Self::LinearSolid(solid) => StudyLaw::LinearSolid(solid),
        }
    }
}

/// Strength or stiffness at the nodes, in the form that a study borrows.
#[derive(Debug)]
pub(super) enum Variation {
    /// Uniform.
    Uniform,
    /// Random in each realisation.
    Field(DisorderField, BondValue),
    /// Factors from the file of points.
    Given(Vec<f64>, BondValue),
    /// Independent, by volume.
    Weibull(WeibullStrength),
}

impl Variation {
    /// The critical stretches of the bonds, given that of the material.
    pub(super) fn strength(&self, of_material: f64) -> Strength<'_> {
        match self {
            Self::Uniform => Strength::Uniform(of_material),
            Self::Field(field, value) => Strength::Field { field, value: *value },
            Self::Given(values, value) => Strength::Given { values, value: *value },
            Self::Weibull(weibull) => Strength::Weibull(weibull),
        }
    }

    /// The factors of the stiffness of the bonds.
    pub(super) fn stiffness(&self) -> Stiffness<'_> {
        match self {
            // `Plate::stiffness` refuses the last.
            Self::Uniform | Self::Weibull(_) => Stiffness::Uniform,
            Self::Field(field, value) => Stiffness::Field { field, value: *value },
            Self::Given(values, value) => Stiffness::Given { values, value: *value },
        }
    }
}

impl Plate {
    pub(super) fn new(scene: &CrackScene, cloud: Option<Cloud>) -> Result<Self, Objection> {
        let (spacing, condition) = (scene.body.spacing, Condition::from(scene.body.condition));
        let horizon = scene.bonds.horizon.of(spacing)?;
        let nodes = match &cloud {
            Some(cloud) => cloud.nodes(&scene.body)?,
            None => lattice(&scene.body)?,
        };
        let config = bond_config(scene, horizon);
        let refused = |error: Error| of_bonds(&error, cloud.as_ref());
        let (bonds, mut law) = match scene.material.law {
            LawScene::BondBased => {
                (Bonds::new(&nodes, &config).map_err(refused)?, PlateLaw::BondBased)
            }
            LawScene::LinearSolid { poisson_ratio } => {
                let solid = SolidBonds::new(&nodes, &config, poisson_ratio).map_err(refused)?;
                (solid.bonds().clone(), PlateLaw::LinearSolid(solid))
            }
        };
        connected(&bonds, scene)?;
        let stretch = stretch_of(scene, &config, condition)?;
        if let ToughnessScene::Softening { fracture_energy, .. } = scene.material.toughness {
            law = PlateLaw::Softening(softening(&config, condition, stretch, fracture_energy)?);
        }
        let cut_bonds = notched(scene, &nodes, &bonds)?;
        let strain = Strain::from(scene.bonds.strain);
        let horizon = horizon.radius();
        Ok(Self { nodes, bonds, law, strain, horizon, stretch, cut_bonds, cloud })
    }

    /// Value of the key `strength`.
    pub(super) fn strength(&self, scene: &CrackScene) -> Result<Variation, Objection> {
        self.variation(&scene.strength, (self.stretch, 0), "strength")
    }

    /// Value of the key `stiffness`.
    pub(super) fn stiffness(&self, scene: &CrackScene) -> Result<Variation, Objection> {
        if let VariationScene::WeibullByVolume(_) = scene.stiffness {
            let message = "a stiffness is no weakest link, and does not scale with volume";
            let help = "`strength` has this key; a random stiffness is a `field`";
            return Err(Objection::new("stiffness.weibull_by_volume", message).with_help(help));
        }
        self.variation(&scene.stiffness, (1.0, 1), "stiffness")
    }

    /// A variation around a mean, with the random stream of its field.
    fn variation(
        &self,
        scene: &VariationScene,
        (mean, number): (f64, u32),
        key: &str,
    ) -> Result<Variation, Objection> {
        match scene {
            VariationScene::Uniform => Ok(Variation::Uniform),
            VariationScene::Field(scene) => {
                let field = field(scene, &self.nodes, (mean, number), &format!("{key}.field"))?;
                Ok(Variation::Field(field, scene.between_nodes.into()))
            }
            VariationScene::Column(scene) => {
                let path = format!("{key}.column");
                let Some(cloud) = &self.cloud else {
                    let message = "it is a column of the file of points, and the body has none";
                    let help = "the file is named by `body.points`";
                    return Err(Objection::new(path, message).with_help(help));
                };
                let factors = cloud.required(&format!("{key}_factor"), &path)?;
                let values = factors.iter().map(|factor| factor * mean).collect();
                Ok(Variation::Given(values, scene.between_nodes.into()))
            }
            VariationScene::WeibullByVolume(scene) => {
                let weibull =
                    WeibullStrength::new(&self.nodes, &self.bonds, scene.of(mean), number);
                let weibull = weibull.map_err(|error| {
                    Objection::new(format!("{key}.weibull_by_volume"), error.to_string())
                })?;
                Ok(Variation::Weibull(weibull))
            }
        }
    }
}

/// How the bonds of a plate are visited: along the rows of a lattice where the plate allows it and that is faster.
///
/// In time random realisations are in a list: side by side in a register they are as fast there. The order is a property of the scene,
/// not of the number of realisations, so that a realisation is the same in any ensemble. The bridge test is made for lists.
pub(super) fn order(
    scene: &CrackScene,
    plate: &Plate,
    temperature: f64,
    (strength, stiffness, protected): (&Variation, &Variation, &[usize]),
) -> BondOrder {
    let is_random = temperature > 0.0 || !matches!(strength, Variation::Uniform);
    let has_bridge =
        scene.time.as_ref().is_some_and(|time| Breaking::from(time.breaking) == Breaking::Bridge);
    if !scene.is_quasi_static() && (is_random || has_bridge) {
        return BondOrder::List;
    }
    let (nodes, strain, stretch) = (plate.nodes.clone(), plate.strain, plate.stretch);
    let is_lattice = match (&plate.law, stiffness) {
        (PlateLaw::BondBased, Variation::Uniform) => {
            LatticeBody::<f64, 2>::new(nodes, plate.bonds.clone(), strain, stretch).is_ok()
        }
        (PlateLaw::LinearSolid(solid), Variation::Uniform) => {
            let is_uniform = matches!(strength, Variation::Uniform) && protected.is_empty();
            is_uniform
                && LatticeBody::<f64, 2>::of_solid(nodes, solid.clone(), strain, stretch).is_ok()
        }
        _ => false,
    };
    if is_lattice { BondOrder::Lattice } else { BondOrder::List }
}

/// An objection of the solver to the value of a key.
pub(super) fn at(path: &'static str) -> impl Fn(Error) -> Objection {
    move |error| Objection::new(path, error.to_string())
}

/// Nodes of a lattice outside the holes.
fn lattice(body: &BodyScene) -> Result<Nodes<2>, Objection> {
    let outside = |x: &[f64; 2]| !body.holes.iter().any(|hole| hole.contains(x));
    let corners = ([0.0; 2], body.size);
    let all = Nodes::lattice(body.spacing, corners, body.condition.into(), |_| true);
    let all = all.map_err(at("body"))?;
    for (i, hole) in body.holes.iter().enumerate() {
        if !all.positions().iter().any(|x| hole.contains(x)) {
            let message = "the hole holds no node: it lies outside the body, or is too small";
            return Err(Objection::new(format!("body.holes[{i}]"), message));
        }
    }
    Nodes::lattice(body.spacing, corners, body.condition.into(), outside).map_err(at("body"))
}

/// Refuses a body in parts that no bond connects: a load on one of them never comes to the other.
fn connected(bonds: &Bonds, scene: &CrackScene) -> Result<(), Objection> {
    let mut part: Vec<usize> = (0..bonds.n_nodes()).collect();
    let root = |part: &mut [usize], mut node: usize| {
        while part[node] != node {
            part[node] = part[part[node]];
            node = part[node];
        }
        node
    };
    for (i, j) in bonds.pairs() {
        let [a, b] = [root(&mut part, i), root(&mut part, j)];
        part[a.max(b)] = a.min(b);
    }
    let n = (0..part.len()).filter(|&node| part[node] == node).count();
    if n <= 1 {
        return Ok(());
    }
    let of_first = (0..part.len()).filter(|&node| root(&mut part, node) == 0).count();
    let message = format!(
        "the body is in {n} parts that no bond connects; the first has {of_first} of {} nodes",
        bonds.n_nodes()
    );
    let (path, help) = match (&scene.body.points, scene.body.holes.is_empty()) {
        (Some(_), _) => ("body.points", "take a longer horizon, or the points of one part"),
        (None, false) => ("body.holes", "a hole cuts the body: make it shorter, or run one part"),
        (None, true) => ("body", "take a longer horizon"),
    };
    Err(Objection::new(path, message).with_help(help))
}

fn of_bonds(error: &Error, cloud: Option<&Cloud>) -> Objection {
    match (error, cloud) {
        (Error::LooseNode { node, horizon }, Some(cloud)) => {
            let row = cloud.row(*node);
            let message = format!("{row}: no other point lies within the horizon, {horizon} m");
            Objection::new("body.points", message)
        }
        (Error::Parameter { name: "Poisson's ratio", .. }, _) => {
            Objection::new("material.law.linear_solid.poisson_ratio", error.to_string())
        }
        _ => Objection::new("bonds", error.to_string()),
    }
}

fn bond_config(scene: &CrackScene, horizon: Horizon) -> BondConfig {
    BondConfig {
        horizon,
        young_modulus: scene.material.young_modulus,
        influence: scene.bonds.influence.into(),
        volume_correction: scene.bonds.volume_correction.into(),
        surface_correction: scene.bonds.surface_correction.into(),
    }
}

fn stretch_of(
    scene: &CrackScene,
    config: &BondConfig,
    condition: Condition,
) -> Result<f64, Objection> {
    match scene.material.toughness {
        ToughnessScene::CriticalStretch(stretch) => {
            let path = "material.toughness.critical_stretch";
            positive(path, "the critical stretch", stretch)?;
            Ok(stretch)
        }
        ToughnessScene::EnergyReleaseRate(rate) => {
            let BondConfig { horizon, young_modulus, influence, .. } = *config;
            let stretch = match scene.material.law {
                LawScene::BondBased => {
                    critical_stretch(rate, young_modulus, horizon.radius(), influence, condition)
                }
                LawScene::LinearSolid { poisson_ratio } => {
                    let moduli = (young_modulus, poisson_ratio);
                    critical_stretch_of_solid(rate, moduli, horizon, influence, condition)
                }
            };
            stretch.map_err(at("material.toughness.energy_release_rate"))
        }
        ToughnessScene::Softening { tensile_strength, .. } => {
            let path = "material.toughness.softening.tensile_strength";
            positive(path, "the tensile strength", tensile_strength)?;
            Ok(tensile_strength / config.young_modulus)
        }
    }
}

/// The law of bonds that soften from a stretch on, so that a crack takes an energy.
///
/// Bonds that break at once at the stretch `s_0` take `(s_0/s_1)^2`, with `s_1` that of the unit of energy; under a line that falls
/// from there to `m s_0` is `m` times as much.
fn softening(
    config: &BondConfig,
    condition: Condition,
    stretch: f64,
    energy: f64,
) -> Result<Bilinear, Objection> {
    let path = "material.toughness.softening.fracture_energy";
    positive(path, "the fracture energy", energy)?;
    let BondConfig { horizon, young_modulus, influence, .. } = *config;
    let of_unit = critical_stretch(1.0, young_modulus, horizon.radius(), influence, condition)
        .map_err(at(path))?;
    let at_once = (stretch / of_unit).powi(2);
    Bilinear::new(energy / at_once).map_err(|_| {
        let message = format!(
            "the fracture energy is {energy} J/m^2; bonds of this strength and horizon that break at once take {at_once:.4} J/m^2"
        );
        let help = "use a shorter horizon, or `energy_release_rate`: bonds then break at once";
        Objection::new(path, message).with_help(help)
    })
}

/// Number of bonds that the notch cuts; its tip must be inside the body.
fn notched(scene: &CrackScene, nodes: &Nodes<2>, bonds: &Bonds) -> Result<usize, Objection> {
    let ([width, height], [x, y]) = (scene.body.size, scene.notch.tip);
    let spans = format!("the body spans 0 to {width} m by 0 to {height} m");
    let ends = (scene.notch.mouth, scene.notch.tip);
    let cut = bonds
        .across_segment(nodes, ends)
        .map_err(|error| Objection::new("notch", error.to_string()).with_help(spans.clone()))?;
    if !(x > 0.0 && x < width && y > 0.0 && y < height) {
        let message = format!("the tip of the notch, [{x}, {y}], lies outside the body");
        return Err(Objection::new("notch.tip", message).with_help(spans));
    }
    Ok(cut.len())
}

/// A random field of a key, with a mean and its random stream.
fn field(
    scene: &FieldScene,
    nodes: &Nodes<2>,
    (mean, number): (f64, u32),
    path: &str,
) -> Result<DisorderField, Objection> {
    let FieldScene { marginal, correlation, .. } = *scene;
    let law = marginal.of(mean);
    let of_law = |error: Error| {
        let path = format!("{path}.marginal.{}", marginal.key());
        Objection::new(path, error.to_string())
    };
    law.check_positive().map_err(|error| of_law(error.into()))?;
    let gaussian = gaussian(nodes, correlation.into())
        .map_err(|error| Objection::new(format!("{path}.correlation.length"), error.to_string()))?;
    DisorderField::new(gaussian, law, number).map_err(of_law)
}

/// Circulant embedding on a lattice, also with missing nodes; a pivoted Cholesky factor on other points.
fn gaussian(
    nodes: &Nodes<2>,
    correlation: Correlation,
) -> Result<GaussianField, random_fields::Error> {
    let positions = nodes.positions();
    match GaussianField::by_circulant_embedding(positions, nodes.spacing(), correlation) {
        Err(random_fields::Error::Point { .. }) => {
            GaussianField::by_pivoted_cholesky(positions, correlation, LEFT_OUT)
        }
        made => made,
    }
}
