//! Strengths of the weakest link: independent draws whose scale depends on the volume of each element.

use random_fields::field_stream;
use sde_integrators::Noise;

use crate::bodies::bonds::Bonds;
use crate::bodies::nodes::Nodes;
use crate::error::{Error, from_to, positive, same_length};

/// Weibull's moduli, from a scatter of 16 times the mean to one of a thousandth.
const MODULI: (f64, f64) = (0.2, 1000.0);

/// Most blocks of a body: their strengths take 128 MB.
const MOST_BLOCKS: f64 = (1_u32 << 24) as f64;

/// What has a strength of its own. In each case the volumes of all elements are together the volume of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StrengthElement {
    /// Each bond, with its share of the volumes of its ends: `V_i/n_i + V_j/n_j`, where `n` counts the bonds of a node.
    Bond,
    /// Each node, with its volume. A bond is as strong as the weaker of its ends.
    Node,
    /// Each box of a grid with a corner at the origin, with the volume of its nodes. A bond is as strong as the weaker of its ends.
    /// Boxes and the numbers that their strengths are drawn from are the same on every mesh of a body.
    Block {
        /// Edge of a box (length).
        size: f64,
    },
}

/// The law of the strengths of a body: Weibull's with two parameters, scaled by volume.
///
/// An element of volume `V` is stronger than the stretch `s` with the probability
///
/// $$ P(S > s) = \exp\left( -\frac{V}{V_0} \left( \frac{s}{s_0} \right)^m \right) , $$
///
/// so that its scale is $s_0 (V_0/V)^{1/m}$. Elements are independent. The weakest of all elements of a body of volume $V$ has the
/// same law with the volume of the body, whatever the mesh.
///
/// **What it does not say.** A specimen fails with its weakest element only where the failure of one element is that of a section:
/// in a chain of bonds, or where an element is as large as a horizon. A node has many bonds, and with finer elements the
/// neighbours of the weakest one are ever stronger: strengths by bond or node hold a crack the more the finer the mesh is.
/// Take [`StrengthElement::Block`] of a size of the material where cracks grow.
///
/// Source: Weibull 1939, A statistical theory of the strength of materials; Weibull 1951.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeibullByVolume {
    /// `s_0`: of bodies of the reference volume 63.2 % are weaker (a stretch).
    pub scale: f64,
    /// `m`, Weibull's modulus, from 0.2 to 1000.
    pub modulus: f64,
    /// `V_0` (length cubed).
    pub reference_volume: f64,
    /// What has a strength.
    pub element: StrengthElement,
}

impl WeibullByVolume {
    fn check(&self) -> Result<(), Error> {
        positive("scale of the strength", self.scale)?;
        positive("reference volume of the strength", self.reference_volume)?;
        if let StrengthElement::Block { size } = self.element {
            positive("size of the blocks of strength", size)?;
        }
        from_to("Weibull modulus of the strength", self.modulus, MODULI.0, MODULI.1)
    }
}

/// The strengths of the bonds of a body, drawn anew in each realisation by [`WeibullByVolume`].
///
/// ```
/// use peridyn_sde::{
///     BondConfig, Bonds, Condition, Horizon, Nodes, StrengthElement,
///     WeibullByVolume, WeibullStrength,
/// };
/// use sde_integrators::Noise;
///
/// // A fibre of 20 mm in 200 links; of fibres of 10 mm 63.2 % break before a strain of 1.4 %.
/// let area = 38.5e-12;
/// let fibre = Nodes::lattice(1e-4, ([0.0], [0.02]), Condition::Bar { area }, |_| true)?;
/// let config = BondConfig::uncorrected(Horizon::of_shells(1, 1e-4)?, 2.3e11);
/// let bonds = Bonds::new(&fibre, &config)?;
/// let element = StrengthElement::Bond;
/// let law = WeibullByVolume { scale: 0.014, modulus: 5.0, reference_volume: 0.01 * area, element };
/// let strength = WeibullStrength::new(&fibre, &bonds, law, 0)?;
/// // The weakest of 1,000 fibres: their median is that of the law of 20 mm, 0.014 (ln 2/2)^(1/5) = 0.01133.
/// let mut of_bonds = vec![0.0; bonds.len()];
/// let mut weakest: Vec<f64> = (0..1000)
///     .map(|fibre| {
///         strength.sample(&Noise::new(3), fibre, &mut of_bonds)?;
///         Ok(of_bonds.iter().copied().fold(f64::INFINITY, f64::min))
///     })
///     .collect::<Result<_, peridyn_sde::Error>>()?;
/// weakest.sort_unstable_by(f64::total_cmp);
/// assert!((weakest[500] - 0.01133).abs() < 4e-4);
/// # Ok::<(), peridyn_sde::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct WeibullStrength {
    law: WeibullByVolume,
    number: u32,
    /// Volume of each element.
    volumes: Vec<f64>,
    /// Scale of each element.
    scales: Vec<f64>,
    /// The elements of each bond, twice the same where it is one.
    of_bonds: Vec<[u32; 2]>,
    n_nodes: usize,
}

impl WeibullStrength {
    /// The strengths of the bonds of some nodes. They are field `number` of each realisation, as those of a
    /// [`DisorderField`](crate::DisorderField) are: fields with other numbers are independent of them.
    ///
    /// # Errors
    /// [`Error::Parameter`] for scale, volume, size or modulus, and for more than 2^24 blocks;
    /// [`Error::Length`] for bonds of another body; [`Error::TooMany`] for more bonds than an index of 32 bits holds.
    pub fn new<const D: usize>(
        nodes: &Nodes<D>,
        bonds: &Bonds,
        law: WeibullByVolume,
        number: u32,
    ) -> Result<Self, Error> {
        law.check()?;
        let n_nodes = nodes.positions().len();
        same_length("the bonds", bonds.n_nodes(), n_nodes)?;
        let (of_bonds, volumes) = match law.element {
            StrengthElement::Bond => by_bond(nodes, bonds)?,
            StrengthElement::Node => {
                let of = |(i, j): (usize, usize)| Ok([index(i)?, index(j)?]);
                (bonds.pairs().map(of).collect::<Result<_, Error>>()?, nodes.volumes().to_vec())
            }
            StrengthElement::Block { size } => by_block(nodes, bonds, size)?,
        };
        // A box without a node, as in a hole, has no bond that its strength is one of.
        let scale = |&volume: &f64| {
            let over = if volume > 0.0 { law.reference_volume / volume } else { 1.0 };
            law.scale * simd_lanes::power(over, law.modulus.recip())
        };
        let scales = volumes.iter().map(scale).collect();
        Ok(Self { law, number, volumes, scales, of_bonds, n_nodes })
    }

    /// The law.
    #[must_use]
    pub fn law(&self) -> WeibullByVolume {
        self.law
    }

    /// Volumes of the elements (length cubed).
    #[must_use]
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// The strengths of a realisation into `out`, one per bond in the order of [`Bonds::all`]: a function of seed, realisation and
    /// number of the element.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::StrengthOfElement`] for a strength beyond the range of numbers, as a small modulus may have.
    pub fn sample(&self, noise: &Noise, realisation: u64, out: &mut [f64]) -> Result<(), Error> {
        same_length("the strengths", out.len(), self.of_bonds.len())?;
        let mut stream = field_stream(*noise, realisation, self.number);
        let exponent = self.law.modulus.recip();
        let mut strengths = Vec::with_capacity(self.scales.len());
        for (element, scale) in self.scales.iter().enumerate() {
            // The probability to be stronger, in (0, 1) without its ends.
            let stronger = ((stream.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64;
            let strength = scale * simd_lanes::power(-simd_lanes::ln(stronger), exponent);
            if !(strength > 0.0 && strength.is_finite()) {
                return Err(Error::StrengthOfElement { element, realisation, value: strength });
            }
            strengths.push(strength);
        }
        for (out, [a, b]) in out.iter_mut().zip(&self.of_bonds) {
            *out = strengths[*a as usize].min(strengths[*b as usize]);
        }
        Ok(())
    }

    /// The weakest bond of each node.
    pub(crate) fn weakest_at_nodes(&self, bonds: &Bonds, strengths: &[f64]) -> Vec<f64> {
        let mut weakest = vec![f64::INFINITY; self.n_nodes];
        for ((i, j), &strength) in bonds.pairs().zip(strengths) {
            weakest[i] = weakest[i].min(strength);
            weakest[j] = weakest[j].min(strength);
        }
        weakest
    }
}

/// The elements of each bond, and the volume of each element.
type Elements = (Vec<[u32; 2]>, Vec<f64>);

fn index(value: usize) -> Result<u32, Error> {
    let limit = u32::MAX as usize;
    u32::try_from(value).map_err(|_| Error::TooMany { name: "nodes or bonds", value, limit })
}

fn by_bond<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds) -> Result<Elements, Error> {
    let mut counts = vec![0.0; bonds.n_nodes()];
    for (i, j) in bonds.pairs() {
        counts[i] += 1.0;
        counts[j] += 1.0;
    }
    let volumes = nodes.volumes();
    let of_bonds = (0..bonds.len()).map(|bond| Ok([index(bond)?; 2]));
    let share = |(i, j): (usize, usize)| volumes[i] / counts[i] + volumes[j] / counts[j];
    Ok((of_bonds.collect::<Result<_, Error>>()?, bonds.pairs().map(share).collect()))
}

fn by_block<const D: usize>(nodes: &Nodes<D>, bonds: &Bonds, size: f64) -> Result<Elements, Error> {
    let x = nodes.positions();
    let along = |x: &[f64; D], k: usize| (x[k] / size).floor();
    let first: [f64; D] =
        std::array::from_fn(|k| x.iter().fold(f64::INFINITY, |low, x| low.min(along(x, k))));
    let counts: [f64; D] = std::array::from_fn(|k| {
        1.0 + x.iter().fold(0.0, |most: f64, x| most.max(along(x, k) - first[k]))
    });
    from_to("number of blocks of strength", counts.iter().product(), 0.0, MOST_BLOCKS)?;
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and checked against the limit"
    )]
    let block = |x: &[f64; D]| {
        (0..D).rev().fold(0.0, |number, k| number * counts[k] + (along(x, k) - first[k])) as u32
    };
    let of_nodes: Vec<u32> = x.iter().map(block).collect();
    let n_blocks = of_nodes.iter().max().map_or(0, |&last| last as usize + 1);
    let mut volumes = vec![0.0; n_blocks];
    for (&block, volume) in of_nodes.iter().zip(nodes.volumes()) {
        volumes[block as usize] += volume;
    }
    let of_bonds = bonds.pairs().map(|(i, j)| [of_nodes[i], of_nodes[j]]).collect();
    Ok((of_bonds, volumes))
}
