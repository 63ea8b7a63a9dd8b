//! Monomials in several variables, in graded order, and the tables that a least-squares fit over them needs.

/// Unknowns of a polynomial of the given degree in `dimension` variables: `C(dimension + degree, degree)`.
pub(crate) const fn unknowns(dimension: usize, degree: usize) -> usize {
    choose(dimension + degree, degree)
}

/// Room for the unknowns: a quartic in three variables and a cubic in four have 35.
pub(crate) const MOST_UNKNOWNS: usize = 35;

/// Room for the moments of a cubic in four variables, and of a quadratic in six.
pub(crate) const MOST_MOMENTS: usize = unknowns(4, 6);

const fn choose(n: usize, k: usize) -> usize {
    let (mut value, mut i) = (1, 0);
    while i < k {
        value = value * (n - i) / (i + 1);
        i += 1;
    }
    value
}

/// The monomials `u^a` of degree 0, 1, 2, .. in some variables, by degree and then with the exponents of the first axes
/// largest first: `1; x, y; x^2, xy, y^2; ..`. Not generic in the number of variables, so that a fit is compiled once.
#[derive(Debug)]
pub(crate) struct Monomials {
    /// Monomials of degree at most `degree`: the unknowns.
    pub(crate) n_unknowns: usize,
    /// Monomials of degree at most `2 degree`: the entries of the normal matrix.
    pub(crate) n_moments: usize,
    /// Monomial `m > 0` is monomial `parent[m]` times component `axis[m]`.
    pub(crate) parent: [u16; MOST_MOMENTS],
    /// See [`Self::parent`].
    pub(crate) axis: [u8; MOST_MOMENTS],
    /// The moment at row `i`, column `j <= i` of the normal matrix, at `i (i + 1) / 2 + j`.
    pub(crate) product: [u16; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
}

impl Monomials {
    /// The tables of a polynomial of degree 1 to 4 in `D` variables; none where it has more unknowns than there is room for.
    pub(crate) const fn of_degree<const D: usize>(degree: usize) -> Option<&'static Self> {
        let fits = unknowns(D, degree) <= MOST_UNKNOWNS && unknowns(D, 2 * degree) <= MOST_MOMENTS;
        match degree {
            1 if fits => Some(Tables::<D>::LINEAR),
            2 if fits => Some(Tables::<D>::QUADRATIC),
            3 if fits => Some(Tables::<D>::CUBIC),
            4 if fits => Some(Tables::<D>::QUARTIC),
            _ => None,
        }
    }

    /// The highest of the degrees up to the given one whose unknowns `count` points carry: so many points
    /// per unknown.
    pub(crate) fn carried_by<const D: usize>(
        count: usize,
        degree: usize,
        points_per_unknown: f64,
    ) -> Option<&'static Self> {
        (1..=degree).rev().find_map(|degree| {
            Self::of_degree::<D>(degree)
                .filter(|tables| count as f64 >= points_per_unknown * tables.n_unknowns as f64)
        })
    }
}

/// The tables in `D` variables.
struct Tables<const D: usize>;

impl<const D: usize> Tables<D> {
    const LINEAR: &'static Monomials = &Self::of_degree(1);
    const QUADRATIC: &'static Monomials = &Self::of_degree(2);
    const CUBIC: &'static Monomials = &Self::of_degree(3);
    const QUARTIC: &'static Monomials = &Self::of_degree(4);

    #[allow(
        clippy::cast_possible_truncation,
        reason = "no table has more than 210 entries, no state more than 6 axes"
    )]
    const fn of_degree(degree: usize) -> Monomials {
        let mut tables = Monomials {
            n_unknowns: unknowns(D, degree),
            n_moments: unknowns(D, 2 * degree),
            parent: [0; MOST_MOMENTS],
            axis: [0; MOST_MOMENTS],
            product: [0; MOST_UNKNOWNS * (MOST_UNKNOWNS + 1) / 2],
        };
        if tables.n_unknowns > MOST_UNKNOWNS || tables.n_moments > MOST_MOMENTS {
            return tables;
        }
        let mut exponents = [[0_usize; D]; MOST_MOMENTS];
        let mut m = 1;
        while m < tables.n_moments {
            exponents[m] = following(exponents[m - 1]);
            let mut axis = D - 1;
            while exponents[m][axis] == 0 {
                axis -= 1;
            }
            let mut parent = exponents[m];
            parent[axis] -= 1;
            tables.parent[m] = index_of(parent) as u16;
            tables.axis[m] = axis as u8;
            m += 1;
        }
        let (mut entry, mut i) = (0, 0);
        while i < tables.n_unknowns {
            let mut j = 0;
            while j <= i {
                let (mut sum, mut k) = (exponents[i], 0);
                while k < D {
                    sum[k] += exponents[j][k];
                    k += 1;
                }
                tables.product[entry] = index_of(sum) as u16;
                entry += 1;
                j += 1;
            }
            i += 1;
        }
        tables
    }
}

/// The exponents that follow in the order of [`Monomials`].
const fn following<const D: usize>(exponents: [usize; D]) -> [usize; D] {
    let mut next = exponents;
    // The exponent of the last axis moves behind the last other axis that can give one.
    let last = next[D - 1];
    next[D - 1] = 0;
    let mut axis = D - 1;
    while axis > 0 {
        axis -= 1;
        if next[axis] > 0 {
            next[axis] -= 1;
            next[axis + 1] = last + 1;
            return next;
        }
    }
    next[0] = last + 1;
    next
}

/// Index of exponents in the order of [`Monomials`].
pub(crate) const fn index_of<const D: usize>(exponents: [usize; D]) -> usize {
    let (mut degree, mut k) = (0, 0);
    while k < D {
        degree += exponents[k];
        k += 1;
    }
    if degree == 0 {
        return 0;
    }
    let mut index = unknowns(D, degree - 1);
    let (mut rest, mut axis) = (degree, 0);
    while axis + 1 < D {
        let mut larger = exponents[axis] + 1;
        while larger <= rest {
            // Ways to spread what is left over the later axes.
            index += choose(rest - larger + D - axis - 2, D - axis - 2);
            larger += 1;
        }
        rest -= exponents[axis];
        axis += 1;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_graded_and_every_index_is_its_own() {
        let mut exponents = [0_usize; 3];
        for m in 0..unknowns(3, 8) {
            assert_eq!(index_of(exponents), m, "{exponents:?}");
            exponents = following(exponents);
        }
        let plane: Vec<[usize; 2]> =
            std::iter::successors(Some([0, 0]), |&e| Some(following(e))).take(6).collect();
        assert_eq!(plane, [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
    }

    #[test]
    fn products_are_found_at_the_sum_of_their_exponents() {
        let tables = Monomials::of_degree::<3>(3).unwrap();
        let u = [0.3_f64, -0.7, 1.1];
        let mut values = vec![1.0; tables.n_moments];
        for m in 1..tables.n_moments {
            values[m] = values[tables.parent[m] as usize] * u[tables.axis[m] as usize];
        }
        let mut entry = 0;
        for i in 0..tables.n_unknowns {
            for j in 0..=i {
                let expected = values[i] * values[j];
                let found = values[tables.product[entry] as usize];
                assert!((found - expected).abs() < 1e-15, "{i} {j}");
                entry += 1;
            }
        }
    }
}
