use std::ops::Range;

use super::{PressureError, PressureReport, PressureScheme, StepView};
use crate::grid::{CellFields, NodeFields};
use crate::particles::Particles;

/// No pore water: the momentum balance alone.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dry;

impl<const D: usize> PressureScheme<D> for Dry {
    fn particles_to_cells(&mut self, _at: &StepView<D>, _particles: &Particles<D>, _cells: &mut CellFields) {}

    fn solve(
        &mut self,
        at: &StepView<D>,
        _particles: &Particles<D>,
        _cells: &mut CellFields,
        nodes: &mut NodeFields<D>,
    ) -> Result<PressureReport, PressureError> {
        if !at.damping.is_off() {
            nodes.put_forces_for_accelerations(at.active);
            at.damping.resist(at.active, nodes);
        }
        nodes.accelerate(at.active);
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
