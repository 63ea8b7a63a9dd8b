//! Symmetric tensors.

/// A symmetric 3 x 3 tensor, in any dimension of the particles: `[xx, yy, zz, xy, yz, xz]`, the order of VTK.
///
/// It is a separate type, because six numbers are also a point in six dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(transparent)]
pub struct SymmetricTensor(pub [f64; 6]);

impl SymmetricTensor {
    /// A tensor from its matrix, of which the upper triangle is read.
    ///
    /// ```
    /// use particle_store::SymmetricTensor;
    ///
    /// let matrix = [[1.0, 4.0, 6.0], [4.0, 2.0, 5.0], [6.0, 5.0, 3.0]];
    /// assert_eq!(SymmetricTensor::from_matrix(matrix).0, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    /// assert_eq!(SymmetricTensor::from_matrix(matrix).to_matrix(), matrix);
    /// ```
    #[must_use]
    pub const fn from_matrix(m: [[f64; 3]; 3]) -> Self {
        Self([m[0][0], m[1][1], m[2][2], m[0][1], m[1][2], m[0][2]])
    }

    /// The full matrix.
    #[must_use]
    pub const fn to_matrix(self) -> [[f64; 3]; 3] {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
}
