//! Vectors and matrices of space, and the symmetric three-dimensional tensor of stress and strain.
//!
//! Space has `D` dimensions; stress and strain always have three. [`embed`] and [`Sym3::dot`] are the only bridge: a
//! two-dimensional body is in plane strain, a one-dimensional one in uniaxial strain.

use std::fmt;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use serde::{Deserialize, Serialize};

/// A vector of space.
pub type Vector<const D: usize> = nalgebra::SVector<f64, D>;
/// A `D × D` matrix of space.
pub type Matrix<const D: usize> = nalgebra::SMatrix<f64, D, D>;
/// A 3 × 3 matrix.
pub type Matrix3 = nalgebra::Matrix3<f64>;
/// A 6 × 6 matrix that maps strain to stress in Kelvin components, see [`Sym3::to_kelvin`].
pub type Matrix6 = nalgebra::Matrix6<f64>;

/// A symmetric tensor in three dimensions: plain tensor components, never engineering shear.
///
/// Stress (Pa) and strain (–) are positive in tension.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Sym3 {
    /// Component xx.
    pub xx: f64,
    /// Component yy.
    pub yy: f64,
    /// Component zz.
    pub zz: f64,
    /// Component xy.
    pub xy: f64,
    /// Component yz.
    pub yz: f64,
    /// Component zx.
    pub zx: f64,
}

impl Sym3 {
    /// The zero tensor.
    pub const ZERO: Sym3 = Sym3::diagonal(0.0, 0.0, 0.0);
    /// The unit tensor I.
    pub const IDENTITY: Sym3 = Sym3::diagonal(1.0, 1.0, 1.0);

    /// A tensor with these diagonal components and no shear.
    #[inline]
    pub const fn diagonal(xx: f64, yy: f64, zz: f64) -> Self {
        Sym3 { xx, yy, zz, xy: 0.0, yz: 0.0, zx: 0.0 }
    }

    /// The symmetric part of a matrix.
    #[inline(always)]
    pub fn symmetric_part(matrix: &Matrix3) -> Self {
        Sym3 {
            xx: matrix[(0, 0)],
            yy: matrix[(1, 1)],
            zz: matrix[(2, 2)],
            xy: 0.5 * (matrix[(0, 1)] + matrix[(1, 0)]),
            yz: 0.5 * (matrix[(1, 2)] + matrix[(2, 1)]),
            zx: 0.5 * (matrix[(2, 0)] + matrix[(0, 2)]),
        }
    }

    /// The tensor as a full matrix.
    #[inline]
    pub fn to_matrix(self) -> Matrix3 {
        Matrix3::new(self.xx, self.xy, self.zx, self.xy, self.yy, self.yz, self.zx, self.yz, self.zz)
    }

    /// The trace: three times the mean stress, or the volumetric strain.
    #[inline]
    pub fn trace(self) -> f64 {
        self.xx + self.yy + self.zz
    }

    /// The mean pressure −⅓ tr σ (Pa), positive in compression.
    #[inline(always)]
    pub fn pressure(self) -> f64 {
        -self.trace() / 3.0
    }

    /// The deviator s = σ − ⅓ tr σ I.
    #[inline]
    pub fn deviator(self) -> Self {
        let mean = self.trace() / 3.0;
        Sym3 { xx: self.xx - mean, yy: self.yy - mean, zz: self.zz - mean, ..self }
    }

    /// The double contraction a : b.
    #[inline]
    pub fn double_dot(self, other: Self) -> f64 {
        self.xx * other.xx
            + self.yy * other.yy
            + self.zz * other.zz
            + 2.0 * (self.xy * other.xy + self.yz * other.yz + self.zx * other.zx)
    }

    /// The Euclidean norm √(a : a).
    #[inline(always)]
    pub fn norm(self) -> f64 {
        self.double_dot(self).sqrt()
    }

    /// The deviatoric stress q = √(3/2 s : s) of a stress (Pa): in triaxial tests the size of the difference of the principal stresses.
    #[inline]
    pub fn deviatoric_stress(self) -> f64 {
        let deviator = self.deviator();
        (1.5 * deviator.double_dot(deviator)).sqrt()
    }

    /// The deviatoric strain ε_q = √(2/3 e : e) of a strain (–): in triaxial tests ⅔ |ε_zz − ε_xx|.
    #[inline]
    pub fn deviatoric_strain(self) -> f64 {
        let deviator = self.deviator();
        (2.0 / 3.0 * deviator.double_dot(deviator)).sqrt()
    }

    /// The tensor turned by a rotation R: R a Rᵀ.
    #[inline(always)]
    pub fn rotated(self, rotation: &Matrix3) -> Self {
        let half = rotation * self.to_matrix();
        let component = |i: usize, j: usize| {
            half[(i, 0)] * rotation[(j, 0)] + half[(i, 1)] * rotation[(j, 1)] + half[(i, 2)] * rotation[(j, 2)]
        };
        Sym3 {
            xx: component(0, 0),
            yy: component(1, 1),
            zz: component(2, 2),
            xy: component(0, 1),
            yz: component(1, 2),
            zx: component(2, 0),
        }
    }

    /// The tensor with the same axes whose principal values are those of a function: Σ f(a_i) n_i ⊗ n_i.
    pub fn map_eigenvalues(self, function: impl Fn(f64) -> f64) -> Self {
        let eigen = self.to_matrix().symmetric_eigen();
        let axes = eigen.eigenvectors;
        let [a, b, c] = [0, 1, 2].map(|i| function(eigen.eigenvalues[i]));
        Sym3::diagonal(a, b, c).rotated(&axes)
    }

    /// The tensor turned by a rotation about z, with the cosine and the sine of the angle: bit by bit what [`Sym3::rotated`] gives.
    #[inline(always)]
    pub fn rotated_about_z(self, cosine: f64, sine: f64) -> Self {
        let half = [
            [cosine * self.xx - sine * self.xy, cosine * self.xy - sine * self.yy],
            [sine * self.xx + cosine * self.xy, sine * self.xy + cosine * self.yy],
        ];
        Sym3 {
            xx: half[0][0] * cosine - half[0][1] * sine,
            yy: half[1][0] * sine + half[1][1] * cosine,
            zz: self.zz,
            xy: half[0][0] * sine + half[0][1] * cosine,
            yz: sine * self.zx + cosine * self.yz,
            zx: cosine * self.zx - sine * self.yz,
        }
    }

    /// The first `D` components of a · g, for a vector g of space (zero out of the plane).
    #[inline(always)]
    pub fn dot<const D: usize>(self, vector: &Vector<D>) -> Vector<D> {
        let rows = [[self.xx, self.xy, self.zx], [self.xy, self.yy, self.yz], [self.zx, self.yz, self.zz]];
        Vector::from_fn(|i, _| {
            let mut sum = 0.0;
            for j in 0..D {
                sum += rows[i][j] * vector[j];
            }
            sum
        })
    }

    /// Components xx, yy, zz, √2 xy, √2 yz, √2 zx, in which a : b is a plain scalar product.
    #[inline]
    pub fn to_kelvin(self) -> nalgebra::Vector6<f64> {
        let root = std::f64::consts::SQRT_2;
        nalgebra::Vector6::new(self.xx, self.yy, self.zz, root * self.xy, root * self.yz, root * self.zx)
    }

    /// The inverse of [`Sym3::to_kelvin`].
    #[inline]
    pub fn from_kelvin(kelvin: &nalgebra::Vector6<f64>) -> Self {
        let root = std::f64::consts::FRAC_1_SQRT_2;
        Sym3 {
            xx: kelvin[0],
            yy: kelvin[1],
            zz: kelvin[2],
            xy: root * kelvin[3],
            yz: root * kelvin[4],
            zx: root * kelvin[5],
        }
    }

    /// True when every component is a number, neither infinite nor NaN.
    #[inline]
    pub fn is_finite(self) -> bool {
        // One infinite or NaN component makes this sum infinite or NaN.
        (self.xx.abs() + self.yy.abs() + self.zz.abs() + self.xy.abs() + self.yz.abs() + self.zx.abs()).is_finite()
    }
}

/// The components by name, to four digits.
impl fmt::Display for Sym3 {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Sym3 { xx, yy, zz, xy, yz, zx } = self;
        write!(formatter, "xx {xx:.3e}, yy {yy:.3e}, zz {zz:.3e}, xy {xy:.3e}, yz {yz:.3e}, zx {zx:.3e}")
    }
}

impl Add for Sym3 {
    type Output = Sym3;
    #[inline]
    fn add(self, other: Sym3) -> Sym3 {
        Sym3 {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            yz: self.yz + other.yz,
            zx: self.zx + other.zx,
        }
    }
}

impl AddAssign for Sym3 {
    #[inline]
    fn add_assign(&mut self, other: Sym3) {
        *self = *self + other;
    }
}

impl Neg for Sym3 {
    type Output = Sym3;
    #[inline]
    fn neg(self) -> Sym3 {
        self * -1.0
    }
}

impl Sub for Sym3 {
    type Output = Sym3;
    #[inline]
    fn sub(self, other: Sym3) -> Sym3 {
        self + -other
    }
}

impl Mul<f64> for Sym3 {
    type Output = Sym3;
    #[inline]
    fn mul(self, factor: f64) -> Sym3 {
        Sym3 {
            xx: self.xx * factor,
            yy: self.yy * factor,
            zz: self.zz * factor,
            xy: self.xy * factor,
            yz: self.yz * factor,
            zx: self.zx * factor,
        }
    }
}

/// A matrix of space inside a 3 × 3 matrix, zeros elsewhere.
#[inline(always)]
pub fn embed<const D: usize>(matrix: &Matrix<D>) -> Matrix3 {
    let mut inside = Matrix3::zeros();
    for i in 0..D {
        for j in 0..D {
            inside[(i, j)] = matrix[(i, j)];
        }
    }
    inside
}

/// The volume ratio of the map x → x + u(x) with displacement gradient ∇u: det(I + ∇u).
#[inline(always)]
pub fn volume_ratio<const D: usize>(displacement_gradient: &Matrix<D>) -> f64 {
    let g = displacement_gradient;
    match D {
        1 => 1.0 + g[(0, 0)],
        2 => (1.0 + g[(0, 0)]) * (1.0 + g[(1, 1)]) - g[(0, 1)] * g[(1, 0)],
        _ => (Matrix3::identity() + embed(g)).determinant(),
    }
}

/// The axial vector w of the antisymmetric part of a displacement gradient: the part turns a vector x into w × x.
#[inline(always)]
pub fn spin<const D: usize>(displacement_gradient: &Matrix<D>) -> Vector<3> {
    let g = embed(displacement_gradient);
    Vector::<3>::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]) * 0.5
}

/// The rotation about the axis w by the angle |w| (rad), meant for the small angles of one step.
///
/// # Equation
///
/// ```text
/// R = I + 2 (H + H²) / (1 + h²),   H x = h × x,   h = w tan(|w|/2)/|w| ≈ w/2 (1 + w²/12)
/// ```
///
/// R is orthogonal whatever the angle (Cayley); the angle itself is right to |w|⁵/120: to 1e-12 at |w| = 0.01.
#[inline(always)]
pub fn rotation(axial: &Vector<3>) -> Matrix3 {
    let h = axial * (0.5 + axial.norm_squared() * ONE_24TH);
    let factor = 2.0 / (1.0 + h.norm_squared());
    // H² = h hᵀ − h² I, without the products with the zeros of H.
    let [x, y, z] = [h.x, h.y, h.z];
    let diagonal = |a: f64, b: f64| 1.0 - (a * a + b * b) * factor;
    Matrix3::new(
        diagonal(y, z),
        (x * y - z) * factor,
        (z * x + y) * factor,
        (x * y + z) * factor,
        diagonal(z, x),
        (y * z - x) * factor,
        (z * x - y) * factor,
        (y * z + x) * factor,
        diagonal(x, y),
    )
}

/// A product costs less than a division.
const ONE_24TH: f64 = 1.0 / 24.0;

/// The cosine and the sine of [`rotation`] about the axis z by `angle` (rad): bit by bit its components.
#[inline(always)]
pub(crate) fn rotation_about_z(angle: f64) -> (f64, f64) {
    let h = angle * (0.5 + angle * angle * ONE_24TH);
    let factor = 2.0 / (1.0 + h * h);
    (1.0 - h * h * factor, h * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Sym3 {
        Sym3 { xx: 1.0, yy: -2.0, zz: 4.0, xy: 0.5, yz: -0.25, zx: 3.0 }
    }

    #[test]
    fn kelvin_components_keep_the_double_contraction() {
        let (a, b) = (sample(), Sym3 { xx: -0.3, xy: 2.0, yz: 1.5, ..sample() });
        let kelvin = a.to_kelvin().dot(&b.to_kelvin());
        assert!((kelvin - a.double_dot(b)).abs() < 1e-14 * kelvin.abs());
        assert!((Sym3::from_kelvin(&a.to_kelvin()) - a).double_dot(Sym3::IDENTITY).abs() < 1e-15);
    }

    #[test]
    fn a_rotation_about_z_is_the_same_in_every_bit() {
        let turn = rotation(&Vector::<3>::new(0.0, 0.0, 0.3));
        assert_eq!(rotation_about_z(0.3), (turn[(0, 0)], turn[(1, 0)]));
        assert_eq!(sample().rotated_about_z(turn[(0, 0)], turn[(1, 0)]), sample().rotated(&turn));
    }

    #[test]
    fn a_function_of_a_tensor_has_its_axes() {
        let square = sample().map_eigenvalues(|a| a * a);
        let expected = Sym3::symmetric_part(&(sample().to_matrix() * sample().to_matrix()));
        assert!((square - expected).norm() < 1e-13);
    }

    #[test]
    fn a_quarter_turn_about_z_swaps_x_and_y() {
        let step = rotation(&Vector::<3>::new(0.0, 0.0, std::f64::consts::FRAC_PI_2 / 1000.0));
        let turned = (0..1000).fold(sample(), |stress, _| stress.rotated(&step));
        let expected = Sym3 { xx: -2.0, yy: 1.0, zz: 4.0, xy: -0.5, yz: 3.0, zx: 0.25 };
        let difference = turned - expected;
        // 1000 steps of 1.6e-3 rad, each right to 8e-17 rad and rounded once or twice.
        assert!(difference.norm() < 1e-12);
    }

    #[test]
    fn spin_of_a_rotation_rate_is_its_axis() {
        let axis = Vector::<3>::new(0.1, -0.2, 0.3);
        let gradient = axis.cross_matrix();
        assert!((spin::<3>(&gradient) - axis).norm() < 1e-16);
    }

    #[test]
    fn volume_ratio_is_the_same_determinant_in_every_dimension() {
        let plane = Matrix::<2>::new(0.1, 0.2, -0.3, 0.05);
        let space = embed(&plane);
        assert!((volume_ratio(&plane) - volume_ratio::<3>(&space)).abs() < 1e-15);
        assert_eq!(volume_ratio(&Matrix::<1>::new(-0.25)), 0.75);
    }
}
