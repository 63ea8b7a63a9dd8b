//! Orthonormal Hermite polynomials of several variables.

/// Largest total degree.
pub(crate) const MOST_DEGREE: usize = 3;

/// Largest number of terms: their normal equations are solved in a tenth of a second.
const MOST_TERMS: usize = 600;

/// Products of orthonormal Hermite polynomials of independent standard normals up to a total degree, by degree.
#[derive(Debug)]
pub(crate) struct Hermite {
    dimension: usize,
    /// Powers of each term, row by row.
    exponents: Vec<u8>,
    /// Number of terms up to each degree.
    n_up_to: Vec<usize>,
}

impl Hermite {
    /// Number of terms; none where they are too many.
    pub(crate) fn n_terms(dimension: usize, degree: usize) -> Option<usize> {
        let mut n = 1_usize;
        for k in 1..=degree {
            // A binomial coefficient: each quotient is whole.
            n = n.checked_mul(dimension.checked_add(k)?)? / k;
        }
        (n <= MOST_TERMS).then_some(n)
    }

    pub(crate) fn new(dimension: usize, degree: usize) -> Self {
        let (mut exponents, mut n_up_to) = (vec![0; dimension], vec![1]);
        let (mut last, mut n) = (vec![vec![0_u8; dimension]], 1);
        for _ in 0..degree {
            let mut next = Vec::new();
            for term in &last {
                // Raised at its last variable or behind: each term of the next degree once.
                let from = term.iter().rposition(|&power| power > 0).unwrap_or(0);
                for k in from..dimension {
                    let mut raised = term.clone();
                    raised[k] += 1;
                    next.push(raised);
                }
            }
            n += next.len();
            exponents.extend(next.iter().flatten());
            n_up_to.push(n);
            last = next;
        }
        Self { dimension, exponents, n_up_to }
    }

    pub(crate) const fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of terms.
    pub(crate) fn len(&self) -> usize {
        self.n_up_to.last().copied().unwrap_or(0)
    }

    /// Number of terms up to a degree.
    pub(crate) fn len_to(&self, degree: usize) -> usize {
        self.n_up_to[degree]
    }

    /// Powers of the variables in a term.
    pub(crate) fn exponents(&self, term: usize) -> &[u8] {
        &self.exponents[term * self.dimension..][..self.dimension]
    }

    /// Writes every term at a point.
    pub(crate) fn at(&self, z: &[f64], out: &mut [f64]) {
        for (term, out) in self.exponents.chunks_exact(self.dimension).zip(out) {
            *out = term.iter().zip(z).map(|(&power, &z)| one(power, z)).product();
        }
    }
}

/// `He_n(z)/sqrt(n!)` up to degree three.
fn one(power: u8, z: f64) -> f64 {
    match power {
        0 => 1.0,
        1 => z,
        2 => (z * z - 1.0) / 2_f64.sqrt(),
        _ => z * (z * z - 3.0) / 6_f64.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_term_is_there_once() {
        let basis = Hermite::new(5, 3);
        assert_eq!([0, 1, 2, 3].map(|degree| basis.len_to(degree)), [1, 6, 21, 56]);
        let mut terms: Vec<&[u8]> = (0..56).map(|term| basis.exponents(term)).collect();
        terms.sort_unstable();
        terms.dedup();
        assert_eq!(terms.len(), 56);
        assert_eq!(Hermite::n_terms(5, 3), Some(56));
        assert_eq!(Hermite::n_terms(100, 3), None);
    }
}
