//! Standard Gaussian fields with a correlation, on any points and on lattices.

use sde_integrators::{LowRankFactor, Noise, NoiseFactor, Purpose, Stream};

use crate::correlations::spatial_correlation::{SpatialCorrelation, bounds};
use crate::error::{Error, between, positive, same_length};
use crate::lattice_field::LatticeField;
use crate::pivoted_cholesky::{Enough, pivoted_cholesky};

/// Largest distance of a node from its lattice point, in spacings.
const OFF_LATTICE: f64 = 1e-6;

/// Words of 32 bits that are set aside for one field of a realisation, as a power of two.
const WORDS_OF_FIELD: u32 = 36;

/// The random numbers of field `number` of a realisation, `2^36` words of 32 bits: for values at elements of a body that are no
/// [`GaussianField`], yet independent of all fields with other numbers.
#[must_use]
pub fn field_stream(noise: Noise, realisation: u64, number: u32) -> Stream {
    normals_of(noise, realisation, number)
}

/// The normals of field `number` of a realisation: `2^35` of them.
pub(crate) fn normals_of(noise: Noise, realisation: u64, number: u32) -> Stream {
    let mut stream = noise.stream(Purpose::Field, realisation);
    stream.seek(u128::from(number) << WORDS_OF_FIELD);
    stream
}

/// A Gaussian field of mean zero, variance one and a given correlation, at given points alone, such as the nodes of a body.
///
/// For a field that is the same function on every mesh take a [`RandomField`](crate::RandomField).
///
/// | made by | where | cost of a sample |
/// |---|---|---|
/// | [`by_pivoted_cholesky`](Self::by_pivoted_cholesky) | any points, up to some thousands | `n k`, with `k` columns |
/// | [`by_circulant_embedding`](Self::by_circulant_embedding) | nodes of a lattice | `N log N`, with `N` points of a period |
///
/// Both have unit variance at every node. The covariance of the first is correct within its tolerance, that of the second
/// within roundoff. A field is a pure function of the seed, the realisation and its number: the normals are those of
/// [`Purpose::Field`], `2^35` of them for each number. The two ways draw different fields of the same distribution. The
/// bits of the first are the same everywhere; those of the second are the same for one mathematics library of the platform.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianField {
    sampler: Sampler,
    n_nodes: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Sampler {
    Factor(LowRankFactor),
    Lattice { field: LatticeField, places: Vec<usize> },
}

impl GaussianField {
    /// At any points (lengths), by a pivoted Cholesky factor that leaves less than `tolerance` of the variance anywhere. Rows
    /// are then brought to unit variance. No entry of the covariance is wrong by more than about twice the tolerance.
    ///
    /// # Errors
    /// Those of [`SpatialCorrelation::check`], [`Error::LengthBeyondBody`], [`Error::OutOfRange`] for a tolerance not between 0
    /// and 1, [`Error::Point`] for a coordinate, [`Error::NoPoints`], [`Error::TooManyColumns`] where too many are needed.
    pub fn by_pivoted_cholesky<const D: usize>(
        positions: &[[f64; D]],
        correlation: impl Into<SpatialCorrelation<D>>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let correlation = checked(positions, correlation.into())?;
        between("tolerance of the field", tolerance, 0.0, 1.0)?;
        let n_nodes = positions.len();
        let entry = |i: usize, j: usize| correlation.between(&positions[i], &positions[j]);
        let mut columns = pivoted_cholesky(n_nodes, entry, Enough::Largest(tolerance))?.columns;
        let mut squares = vec![0.0; n_nodes];
        for column in columns.chunks_exact(n_nodes) {
            for (square, u) in squares.iter_mut().zip(column) {
                *square += u * u;
            }
        }
        for column in columns.chunks_exact_mut(n_nodes) {
            for (u, square) in column.iter_mut().zip(&squares) {
                *u /= square.sqrt();
            }
        }
        let sampler = Sampler::Factor(LowRankFactor::new(n_nodes, columns)?);
        Ok(Self { sampler, n_nodes })
    }

    /// At nodes of a lattice of the given spacing (lengths), of which some may be missing, by circulant embedding. It serves
    /// lattices up to 4 million points in two dimensions and 128 points a side in three, fewer where the correlation length
    /// is a large part of the lattice.
    ///
    /// # Errors
    /// As [`GaussianField::by_pivoted_cholesky`]; [`Error::Point`] for a node off the lattice; [`Error::TooManyPoints`];
    /// [`Error::NoEmbedding`] where no period up to 16 million points is long enough. Wendland's function has one from twice
    /// three lengths on; of 64 points a side in three dimensions, the exponential and Matern's have none at 16 spacings.
    pub fn by_circulant_embedding<const D: usize>(
        positions: &[[f64; D]],
        spacing: f64,
        correlation: impl Into<SpatialCorrelation<D>>,
    ) -> Result<Self, Error> {
        let correlation = checked(positions, correlation.into())?;
        positive("spacing of the nodes", spacing)?;
        let indices = lattice_indices(positions, spacing)?;
        let counts = indices.iter().fold([1; 3], |most: [usize; 3], index| {
            std::array::from_fn(|k| most[k].max(index[k].saturating_add(1)))
        });
        let field = LatticeField::new(counts, spacing, &correlation)?;
        let places = indices.iter().map(|&index| field.place(index)).collect();
        Ok(Self { sampler: Sampler::Lattice { field, places }, n_nodes: positions.len() })
    }

    /// How many nodes it has.
    #[must_use]
    pub fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// Field `number` of a realisation into `out`, a value per node. Fields of other numbers and of other realisations are
    /// independent.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn sample(
        &self,
        noise: &Noise,
        realisation: u64,
        number: u32,
        out: &mut [f64],
    ) -> Result<(), Error> {
        same_length("the field", out.len(), self.n_nodes)?;
        let mut stream = normals_of(*noise, realisation, number);
        match &self.sampler {
            Sampler::Factor(factor) => {
                let mut normals = vec![0.0; factor.n_motions()];
                stream.fill_normal(&mut normals);
                factor.apply(&normals, out);
            }
            Sampler::Lattice { field, places } => field.sample(&mut stream, places, out),
        }
        Ok(())
    }
}

fn checked<const D: usize>(
    positions: &[[f64; D]],
    correlation: SpatialCorrelation<D>,
) -> Result<SpatialCorrelation<D>, Error> {
    let [low, high] = bounds(positions)?;
    correlation.check_within(&low, &high)?;
    Ok(correlation)
}

/// Lattice indices of the nodes, from the lowest coordinate along each axis.
fn lattice_indices<const D: usize>(
    positions: &[[f64; D]],
    spacing: f64,
) -> Result<Vec<[usize; 3]>, Error> {
    let low = positions
        .iter()
        .fold([f64::INFINITY; D], |low: [f64; D], x| std::array::from_fn(|k| low[k].min(x[k])));
    let mut indices = vec![[0; 3]; positions.len()];
    for (point, (x, index)) in positions.iter().zip(&mut indices).enumerate() {
        for k in 0..D {
            let along = (x[k] - low[k]) / spacing;
            let whole = along.round();
            let off = (along - whole).abs();
            if off.is_nan() || off > OFF_LATTICE {
                let must = "a whole number of spacings from the lowest";
                return Err(Error::Point { name: "a coordinate", point, value: x[k], must });
            }
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not below zero; one too large saturates, and is refused with its lattice"
            )]
            let whole = whole as usize;
            index[k] = whole;
        }
    }
    Ok(indices)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test ends by it")]

    use super::*;
    use crate::correlations::correlation::{Correlation, CorrelationFunction};

    const CORRELATION: Correlation =
        Correlation { function: CorrelationFunction::Matern32, length: 2.0 };

    fn line(n: usize) -> Vec<[f64; 1]> {
        (0..n).map(|k| [k as f64]).collect()
    }

    #[test]
    fn factor_has_unit_rows_and_the_correlation_to_its_tolerance() {
        let positions = line(40).into_iter().map(|[x]| [0.25 * x]).collect::<Vec<_>>();
        let field = GaussianField::by_pivoted_cholesky(&positions, CORRELATION, 1e-2).unwrap();
        let Sampler::Factor(factor) = field.sampler else { unreachable!("it is a factor") };
        assert!(factor.n_motions() < 40, "{}", factor.n_motions());
        for i in 0..40 {
            for j in 0..40 {
                let found: f64 = factor.columns().map(|u| u[i] * u[j]).sum();
                let error = (found - CORRELATION.between(&positions[i], &positions[j])).abs();
                let limit = if i == j { 1e-14 } else { 2e-2 };
                assert!(error < limit, "({i}, {j}): {error:e}");
            }
        }
    }

    #[test]
    fn same_seed_gives_the_same_bits_and_every_other_address_another_field() {
        let positions = line(30);
        for field in [
            GaussianField::by_pivoted_cholesky(&positions, CORRELATION, 1e-6).unwrap(),
            GaussianField::by_circulant_embedding(&positions, 1.0, CORRELATION).unwrap(),
        ] {
            let sample = |seed, realisation, number| {
                let mut out = vec![0.0; 30];
                field.sample(&Noise::new(seed), realisation, number, &mut out).unwrap();
                out.into_iter().map(f64::to_bits).collect::<Vec<_>>()
            };
            assert_eq!(sample(1, 2, 3), sample(1, 2, 3));
            for other in [sample(2, 2, 3), sample(1, 3, 3), sample(1, 2, 4)] {
                assert!(other.iter().zip(&sample(1, 2, 3)).all(|(a, b)| a != b));
            }
        }
    }

    #[test]
    fn lattice_may_lack_nodes_and_stand_anywhere() {
        let whole: Vec<[f64; 2]> =
            (0..20).map(|k| [0.3 * f64::from(k % 5) - 7.0, 0.3 * f64::from(k / 5)]).collect();
        let some: Vec<usize> = vec![19, 0, 3, 4, 12];
        let sample = |positions: &[[f64; 2]]| {
            let field = GaussianField::by_circulant_embedding(positions, 0.3, CORRELATION).unwrap();
            let mut out = vec![0.0; positions.len()];
            field.sample(&Noise::new(5), 0, 0, &mut out).unwrap();
            out
        };
        let (all, part) =
            (sample(&whole), sample(&some.iter().map(|&k| whole[k]).collect::<Vec<_>>()));
        assert_eq!(part, some.iter().map(|&k| all[k]).collect::<Vec<_>>());
    }

    #[test]
    fn node_off_the_lattice_is_refused_by_its_number() {
        let refused =
            GaussianField::by_circulant_embedding(&[[0.0], [1.0], [2.4]], 1.0, CORRELATION);
        assert!(matches!(refused, Err(Error::Point { point: 2, .. })), "{refused:?}");
    }

    #[test]
    fn column_of_another_length_is_refused() {
        let field = GaussianField::by_pivoted_cholesky(&line(3), CORRELATION, 1e-6).unwrap();
        let refused = field.sample(&Noise::new(1), 0, 0, &mut [0.0; 4]);
        assert!(matches!(refused, Err(Error::Length { value: 4, expected: 3, .. })));
    }

    #[test]
    fn points_and_tolerances_that_cannot_be_are_refused() {
        let none = GaussianField::by_pivoted_cholesky::<2>(&[], CORRELATION, 1e-6);
        assert!(matches!(none, Err(Error::NoPoints)));
        let nowhere = GaussianField::by_pivoted_cholesky(&[[f64::NAN]], CORRELATION, 1e-6);
        assert!(matches!(nowhere, Err(Error::Point { point: 0, .. })));
        let all = GaussianField::by_pivoted_cholesky(&line(3), CORRELATION, 1.0);
        assert!(matches!(all, Err(Error::OutOfRange { .. })));
    }
}
