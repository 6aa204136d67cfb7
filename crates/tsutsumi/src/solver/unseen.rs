use super::{Parts, Solver};
use crate::tensor::Vector;

impl<const D: usize> Solver<D> {
    /// The part of the particles' velocities that the grid cannot see (–): 0 where velocities are smooth, up to 1 where they
    /// change from particle to particle. 0 at rest.
    ///
    /// # Equation
    ///
    /// ```text
    /// √(Σ_p |V_p − (S S⁺ V)_p|² / Σ_p |V_p|²)        (S v)_p = Σ_I N_Ip v_I      (S⁺ V)_I = Σ_p M_p N_Ip V_p / m_I
    /// ```
    ///
    /// With the nodes as the particles are now, without supports. It allocates: for outputs, not for steps.
    pub fn unseen_velocity(&self) -> f64 {
        let Parts { grid, particles, shape, .. } = &self.parts;
        let mut nodes = vec![(0.0, Vector::<D>::zeros()); grid.num_nodes()];
        for p in 0..particles.len() {
            // Outside the grid there is nothing to see; the next step says so.
            if grid.cell_at(&particles.position[p]).is_none() {
                return f64::NAN;
            }
            shape.visit_weights(grid, particles, p, &mut |node, value, _| {
                let share = particles.mass[p] * value;
                nodes[node].0 += share;
                nodes[node].1 += particles.velocity[p] * share;
            });
        }
        let (mut unseen, mut all) = (0.0, 0.0);
        for (p, velocity) in particles.velocity.iter().enumerate() {
            let mut seen = Vector::zeros();
            shape.visit_weights(grid, particles, p, &mut |node, value, _| {
                let (mass, momentum) = nodes[node];
                if mass > 0.0 {
                    seen += momentum * (value / mass);
                }
            });
            unseen += (velocity - seen).norm_squared();
            all += velocity.norm_squared();
        }
        if all > 0.0 { (unseen / all).sqrt() } else { 0.0 }
    }
}
