use crate::tensor::{Matrix3, Sym3};

/// The principal stresses (Pa), largest first, and their axes as the columns of a matrix.
#[derive(Debug, Clone, Copy)]
pub(super) struct Principal {
    pub(super) values: [f64; 3],
    axes: Matrix3,
}

impl Principal {
    pub(super) fn of(stress: Sym3) -> Self {
        // Plane strain in x and y, and uniaxial strain: one rotation in the plane.
        let (values, axes) = match stress.yz == 0.0 && stress.zx == 0.0 {
            true => in_the_plane(stress),
            false => {
                let eigen = stress.to_matrix().symmetric_eigen();
                (eigen.eigenvalues.into(), eigen.eigenvectors)
            }
        };
        sorted(values, axes)
    }

    /// The stress with the same axes and other principal values (Pa).
    pub(super) fn with_values(&self, [a, b, c]: [f64; 3]) -> Sym3 {
        Sym3::diagonal(a, b, c).rotated(&self.axes)
    }
}

/// The eigenvalues and axes of a stress without yz and zx.
fn in_the_plane(stress: Sym3) -> ([f64; 3], Matrix3) {
    if stress.xy == 0.0 {
        return ([stress.xx, stress.yy, stress.zz], Matrix3::identity());
    }
    // Jacobi: the smaller root t = tan θ of t² + 2 κ t − 1 = 0 loses no digits.
    let kappa = (stress.yy - stress.xx) / (2.0 * stress.xy);
    let tan = 1.0_f64.copysign(kappa) / (kappa.abs() + (kappa * kappa + 1.0).sqrt());
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let sin = tan * cos;
    let values = [stress.xx - tan * stress.xy, stress.yy + tan * stress.xy, stress.zz];
    (values, Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0))
}

fn sorted(mut values: [f64; 3], mut axes: Matrix3) -> Principal {
    for (first, second) in [(0, 1), (1, 2), (0, 1)] {
        if values[first] < values[second] {
            values.swap(first, second);
            axes.swap_columns(first, second);
        }
    }
    Principal { values, axes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_axes_give_the_stress_back() {
        let space = Sym3 { xx: -3.0, yy: 1.0, zz: 2.0, xy: 0.7, yz: -0.4, zx: 1.1 };
        let plane = Sym3 { yz: 0.0, zx: 0.0, ..space };
        let nearly_isotropic = Sym3 { xx: -1.0, yy: -1.0, zz: -1.0, xy: 1e-13, yz: 0.0, zx: 0.0 };
        for stress in [space, plane, plane * -1.0, nearly_isotropic, Sym3::diagonal(1.0, 3.0, 2.0), Sym3::ZERO] {
            let principal = Principal::of(stress);
            let off = principal.with_values(principal.values) - stress;
            assert!(off.norm() < 1e-14, "{stress}");
            assert!(principal.values.is_sorted_by(|a, b| a >= b));
        }
    }
}
