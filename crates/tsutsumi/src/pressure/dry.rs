use std::ops::Range;

use super::{PressureError, PressureReport, PressureScheme, StepView};
use crate::grid::{CellFields, NodeFields};
use crate::particles::Particles;

/// No pore water: the momentum balance alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dry;

impl<const D: usize> NodeFields<D> {
    /// Puts the forces (N) where the accelerations will stand.
    fn acceleration_from_forces(&mut self, at: &StepView<D>) {
        let force = &self.force;
        at.active
            .change_runs(&mut self.acceleration, |nodes, accelerations| accelerations.copy_from_slice(&force[nodes]));
    }
}

impl<const D: usize> PressureScheme<D> for Dry {
    fn particles_to_cells(&mut self, _at: &StepView<D>, _particles: &Particles<D>, _cells: &mut CellFields) {}

    fn solve(
        &mut self,
        at: &StepView<D>,
        _particles: &Particles<D>,
        _cells: &mut CellFields,
        nodes: &mut NodeFields<D>,
    ) -> Result<PressureReport, PressureError> {
        nodes.acceleration_from_forces(at);
        if !at.damping.is_off() {
            at.damping.resist(at.active, nodes);
            nodes.acceleration_from_forces(at);
        }
        nodes.forces_to_accelerations(at.active);
        Ok(PressureReport::default())
    }

    fn cells_to_particles(&mut self, _at: &StepView<D>, _cells: &CellFields, _particles: &mut Particles<D>) {}

    fn consolidation_limit(
        &self,
        _at: &StepView<D>,
        _particles: &Particles<D>,
        _group: Range<usize>,
        _modulus: f64,
    ) -> Option<f64> {
        None
    }
}
