//! Arrangements of lattice neighbours around a point, which reflections and permutations of the axes bring together.

use std::cmp::Reverse;

/// Turns an arrangement into that of its class: axis `l` of the class is `sign[l]` times axis `axis[l]` of the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn<const D: usize> {
    pub(crate) axis: [usize; D],
    /// 1 or -1.
    pub(crate) sign: [f64; D],
}

impl<const D: usize> Turn<D> {
    /// The order of the axes and their signs in which the first moments of the offsets do not increase and are not
    /// negative; among equal ones the second moments do not increase. Arrangements that a turn brings together have the
    /// same after it, unless moments of different axes are equal: such arrangements may have several classes.
    pub(crate) fn of(offsets: &[[i32; D]]) -> Self {
        let mut moments = [[0_i64; 3]; D];
        for offset in offsets {
            for (moments, o) in moments.iter_mut().zip(offset.map(i64::from)) {
                moments[0] += o;
                moments[1] += o * o;
                moments[2] += o * o * o;
            }
        }
        let mut axis: [usize; D] = std::array::from_fn(|k| k);
        axis.sort_by_key(|&k| Reverse((moments[k][0].abs(), moments[k][1])));
        let is_negative = |k: usize| (moments[k][0], moments[k][2]) < (0, 0);
        Self { axis, sign: axis.map(|k| if is_negative(k) { -1.0 } else { 1.0 }) }
    }

    /// An offset along the axes of the class.
    pub(crate) fn offset(&self, offset: &[i32; D]) -> [i32; D] {
        std::array::from_fn(|l| {
            let along = offset[self.axis[l]];
            if self.sign[l] < 0.0 { -along } else { along }
        })
    }

    /// A vector along the axes of the lattice, from its components along those of the class.
    #[allow(clippy::inline_always, reason = "used in dispatched functions")]
    #[inline(always)]
    pub(crate) fn back(&self, of_class: &[f64; D]) -> [f64; D] {
        let mut vector = [0.0; D];
        for l in 0..D {
            vector[self.axis[l]] = self.sign[l] * of_class[l];
        }
        vector
    }

    /// A matrix along the axes of the lattice, from its entries along those of the class.
    pub(crate) fn back_matrix(&self, of_class: &[[f64; D]; D]) -> [[f64; D]; D] {
        let mut matrix = [[0.0; D]; D];
        for k in 0..D {
            for l in 0..D {
                matrix[self.axis[k]][self.axis[l]] = self.sign[k] * self.sign[l] * of_class[k][l];
            }
        }
        matrix
    }
}

/// Members of a point in the order of its class, and their offsets along the axes of the class.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Turned<const D: usize> {
    pub(crate) turn: Turn<D>,
    /// Places of the members in the row that was turned.
    pub(crate) order: Vec<u32>,
    /// In ascending order, the last axis first: offsets of opposite members are at opposite places.
    pub(crate) offsets: Vec<[i32; D]>,
}

impl<const D: usize> Turned<D> {
    /// The arrangement of the given offsets.
    pub(crate) fn of(offsets: &[[i32; D]]) -> Self {
        let turn = Turn::of(offsets);
        let mut members: Vec<_> = offsets.iter().map(|o| turn.offset(o)).zip(0_u32..).collect();
        members.sort_unstable_by_key(|(offset, _)| last_axis_first(offset));
        let (offsets, order) = members.into_iter().unzip();
        Self { turn, order, offsets }
    }
}

/// The place of an offset among those of a [`Turned`] arrangement; none where it is missing.
pub(crate) fn place_of<const D: usize>(offsets: &[[i32; D]], offset: &[i32; D]) -> Option<usize> {
    offsets.binary_search_by_key(&last_axis_first(offset), last_axis_first).ok()
}

fn last_axis_first<const D: usize>(offset: &[i32; D]) -> [i32; D] {
    let mut key = *offset;
    key.reverse();
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An arrangement without a symmetry, all of whose moments differ.
    const OFFSETS: [[i32; 3]; 5] = [[0, 0, 0], [1, 0, 0], [-1, 2, 0], [0, 2, -1], [1, 1, -2]];

    #[test]
    fn all_48_images_of_an_arrangement_have_one_class() {
        let expected = Turned::of(&OFFSETS).offsets;
        let mut n_turns = 0;
        for axis in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for signs in 0..8 {
                let sign = std::array::from_fn(|k| if signs >> k & 1 == 0 { 1.0 } else { -1.0 });
                let image = OFFSETS.map(|offset| Turn { axis, sign }.offset(&offset));
                let turned = Turned::of(&image);
                assert_eq!(turned.offsets, expected, "{axis:?} {sign:?}");
                for (&place, offset) in turned.order.iter().zip(&turned.offsets) {
                    let place = place as usize;
                    assert_eq!(turned.turn.offset(&image[place]), *offset);
                    // Back on the lattice it is the member's offset again.
                    let back = turned.turn.back(&offset.map(f64::from));
                    let gap = |k: usize| (back[k] - f64::from(image[place][k])).abs();
                    assert!((0..3).all(|k| gap(k) < f64::MIN_POSITIVE), "{back:?}");
                }
                n_turns += 1;
            }
        }
        assert_eq!(n_turns, 48);
    }

    #[test]
    fn a_matrix_turns_as_the_product_of_its_vectors() {
        let turn = Turn { axis: [2, 0, 1], sign: [1.0, -1.0, -1.0] };
        let (a, b) = ([1.0, 2.0, -3.0], [0.5, 4.0, 1.0]);
        let product = |a: [f64; 3], b: [f64; 3]| a.map(|a| b.map(|b| a * b));
        let (found, expected) =
            (turn.back_matrix(&product(a, b)), product(turn.back(&a), turn.back(&b)));
        // Products of small whole numbers and halves are exact.
        assert_eq!(
            found.map(|row| row.map(f64::to_bits)),
            expected.map(|row| row.map(f64::to_bits))
        );
    }

    #[test]
    fn the_place_of_an_offset_is_found_or_missing() {
        let offsets = Turned::of(&OFFSETS).offsets;
        for (place, offset) in offsets.iter().enumerate() {
            assert_eq!(place_of(&offsets, offset), Some(place));
        }
        assert_eq!(place_of(&offsets, &[2, 2, 2]), None);
    }
}
