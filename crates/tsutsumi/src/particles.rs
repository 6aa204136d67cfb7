//! The material points: a body Ω split into subdomains Ω_p, each carried by a particle.

mod order;
mod stresses;

pub use order::{AtPlaces, Moves, MovesWithin};
pub(crate) use order::{Follows, MOST, follow_all};
pub use stresses::{StressIter, Stresses, StressesMut};

use std::ops::Range;

use crate::grid::{Grid, Located, SideSet, vec_bytes};
use crate::parallel::{self, vectorized};
use crate::tensor::{Matrix, Sym3, Vector};

/// Particles that one thread locates at a time.
const GRAIN: usize = 8192;

/// The material points, structure of arrays: every field has one value per particle, in the same order, that of their *places*.
///
/// Places may change from step to step, [`Particles::number`] finds a particle again.
///
/// # Equation
///
/// ```text
/// ρ(x) = Σ_p M_p δ(x − X_p)          Eq. (4)
/// ```
///
/// The masses never change, so mass is conserved by construction.
#[doc(alias = "Eq. (4)")]
#[derive(Debug, Clone, Default)]
pub struct Particles<const D: usize> {
    /// Position X_p (m).
    pub position: Vec<Vector<D>>,
    /// Velocity V_p of the skeleton (m/s).
    pub velocity: Vec<Vector<D>>,
    /// Mass M_p of soil and water together (kg; kg per metre in 2-D, kg/m² in 1-D).
    pub mass: Vec<f64>,
    /// Volume Ω_p (m³; m² per metre in 2-D, m in 1-D).
    pub volume: Vec<f64>,
    /// Half the edge lengths of the box that the particle stands for (m). They stretch with the material along the axes.
    pub half_size: Vec<Vector<D>>,
    /// The same at the start (m).
    pub half_size_at_start: Vec<Vector<D>>,
    /// Effective stress σ' (Pa, positive in tension): σ = σ' + p I = σ' − p_w I, Eq. (2). Never specific, σ' = ρ σ'^s.
    #[doc(alias = "Eq. (2)")]
    pub stress: Stresses,
    /// Pore pressure p_w (Pa, positive in compression).
    pub pressure: Vec<f64>,
    /// Porosity n (–), which follows the volume; 0 in dry ground.
    pub porosity: Vec<f64>,
    /// Hydraulic conductivity k (m/s), which follows the porosity by the group's law.
    pub conductivity: Vec<f64>,
    /// The sides on which the particle drains where its cell ends the body.
    pub drained: Vec<SideSet>,
    /// The cell of the grid that holds the particle.
    pub cell: Vec<u32>,
    /// What the velocity update keeps of the motion around the particle, as its [`LocalMotion`] says; empty where it keeps nothing.
    pub local_motion: Vec<Matrix<D>>,
    /// The numbers of the particles; empty as long as they are those of the places.
    pub(crate) numbers: Vec<u32>,
}

/// What a velocity update keeps of the motion around each particle, and gives to the nodes in the next step besides the velocity V_p.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LocalMotion {
    /// Nothing: a particle moves as a point.
    #[default]
    Nothing,
    /// The first moments B_p of the velocity of the nodes (m²/s).
    ///
    /// # Equation
    ///
    /// ```text
    /// B_p = Σ_I N_I(X_p) v_I ⊗ (x_I − X_p)
    /// m_I v_I ← … + Σ_p M_p N_I(X_p) B_p D_p⁻¹ (x_I − X_p)      D_p = Σ_I N_I(X_p) (x_I − X_p) ⊗ (x_I − X_p)
    /// ```
    ///
    /// D_p is diagonal, since the shape functions are products over the axes that reproduce linear fields. Along an axis where
    /// a particle lies on a grid line, and linear shape functions leave it no nodes to both sides, it has no moment to give.
    Moments,
    /// The gradient of the velocity of the nodes (1/s), component ij = ∂v_i/∂x_j.
    ///
    /// # Equation
    ///
    /// ```text
    /// ∇v_p = Σ_I v_I ⊗ ∇N_I(X_p)
    /// m_I v_I ← … + Σ_p M_p N_I(X_p) ∇v_p (x_I − X_p)
    /// ```
    Gradient,
}

/// Where some particles are, and their boxes: what a shape function asks.
#[derive(Debug, Clone, Copy)]
pub struct Places<'a, const D: usize> {
    /// Positions X_p (m).
    pub position: &'a [Vector<D>],
    /// Half the edge lengths of the boxes (m).
    pub half_size: &'a [Vector<D>],
    /// The same at the start (m).
    pub half_size_at_start: &'a [Vector<D>],
}

impl<const D: usize> Places<'_, D> {
    /// Those of a range of these particles.
    #[must_use]
    pub fn part(self, range: Range<usize>) -> Self {
        Places {
            position: &self.position[range.clone()],
            half_size: &self.half_size[range.clone()],
            half_size_at_start: &self.half_size_at_start[range],
        }
    }
}

/// One material point, to be added to [`Particles`].
#[derive(Debug, Clone, PartialEq)]
pub struct Particle<const D: usize> {
    /// Position (m).
    pub position: Vector<D>,
    /// Half the edge lengths of its box (m).
    pub half_size: Vector<D>,
    /// Velocity (m/s).
    pub velocity: Vector<D>,
    /// Density of soil and water together (kg/m³).
    pub density: f64,
    /// Effective stress (Pa, positive in tension).
    pub stress: Sym3,
    /// Pore pressure (Pa, positive in compression).
    pub pressure: f64,
    /// Porosity (–); 0 in dry ground.
    pub porosity: f64,
    /// Hydraulic conductivity (m/s); 0 in dry ground.
    pub conductivity: f64,
}

/// A particle left the grid, or its position is not a number.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("particle {particle} is at {position:.4?} m, outside the grid ({from:?} to {to:?})")]
pub struct OutsideGrid {
    /// The number of the particle.
    pub particle: usize,
    /// Its position (m).
    pub position: Vec<f64>,
    /// The lowest corner of the grid (m).
    pub from: Vec<f64>,
    /// The highest corner of the grid (m).
    pub to: Vec<f64>,
}

impl<const D: usize> Particles<D> {
    /// The number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True when there is no particle.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Where the particles are, and their boxes.
    pub fn places(&self) -> Places<'_, D> {
        let Particles { position, half_size, half_size_at_start, .. } = self;
        Places { position, half_size, half_size_at_start }
    }

    /// The cells that hold the particles, for [`ActiveSet::update`](crate::grid::ActiveSet::update).
    pub fn located(&self) -> Located<'_> {
        Located { cells: &self.cell, numbers: &self.numbers }
    }

    /// Adds a particle.
    pub fn push(&mut self, particle: Particle<D>) {
        let volume = (particle.half_size * 2.0).product();
        self.position.push(particle.position);
        self.velocity.push(particle.velocity);
        self.mass.push(particle.density * volume);
        self.volume.push(volume);
        self.half_size.push(particle.half_size);
        self.half_size_at_start.push(particle.half_size);
        self.stress.push(particle.stress);
        self.pressure.push(particle.pressure);
        self.porosity.push(particle.porosity);
        self.conductivity.push(particle.conductivity);
        self.drained.push(SideSet::EMPTY);
        self.cell.push(u32::MAX);
        if !self.numbers.is_empty() {
            self.numbers.push(self.numbers.len() as u32);
        }
    }

    /// Gives a particle another volume (m³) than its box has; its mass follows, its density stays.
    pub fn set_volume(&mut self, particle: usize, volume: f64) {
        self.mass[particle] *= volume / self.volume[particle];
        self.volume[particle] = volume;
    }

    /// Sets the motion around the particles to zero, with room for it if a velocity update keeps any.
    pub fn keep(&mut self, local_motion: LocalMotion) {
        self.local_motion = match local_motion {
            LocalMotion::Nothing => Vec::new(),
            LocalMotion::Moments | LocalMotion::Gradient => vec![Matrix::zeros(); self.len()],
        };
    }

    /// Finds the cell of every particle. Returns how many have changed theirs.
    ///
    /// # Errors
    /// The first particle outside the grid, by number.
    pub fn locate(&mut self, grid: &Grid<D>) -> Result<usize, OutsideGrid> {
        let pieces = (&self.position[..], &mut self.cell[..]);
        let locate = |(positions, cells): (&[Vector<D>], &mut [u32])| {
            vectorized(
                #[inline(always)]
                || locate_piece(grid, positions, cells),
            )
        };
        let (moved, outside) = parallel::fold(pieces, GRAIN, &locate, &|before: (usize, bool), after| {
            (before.0 + after.0, before.1 || after.1)
        });
        let list = |v: Vector<D>| v.iter().copied().collect();
        let is_outside = |place: &usize| outside && grid.cell_at(&self.position[*place]).is_none();
        match (0..self.len()).filter(is_outside).min_by_key(|&place| self.number(place)) {
            Some(place) => Err(OutsideGrid {
                particle: self.number(place),
                position: list(self.position[place]),
                from: list(grid.origin()),
                to: list(grid.end()),
            }),
            None => Ok(moved),
        }
    }

    /// Momentum Σ M_p V_p (kg m/s).
    pub fn momentum(&self) -> Vector<D> {
        self.mass.iter().zip(&self.velocity).map(|(&m, v)| v * m).sum()
    }

    /// Kinetic energy Σ ½ M_p V_p² (J).
    pub fn kinetic_energy(&self) -> f64 {
        self.mass.iter().zip(&self.velocity).map(|(m, v)| 0.5 * m * v.norm_squared()).sum()
    }
}

/// Particles whose cells are found before any is written: most stay where they are, and cost no write.
const BLOCK: usize = 64;

/// Finds the cells of some particles. Returns how many changed theirs, and whether any is outside the grid: its block keeps its cells.
#[inline(always)]
fn locate_piece<const D: usize>(grid: &Grid<D>, positions: &[Vector<D>], cells: &mut [u32]) -> (usize, bool) {
    let (mut moved, mut outside) = (0, false);
    for (positions, cells) in positions.chunks(BLOCK).zip(cells.chunks_mut(BLOCK)) {
        let mut found = [0; BLOCK];
        let all_inside = grid.cells_at(positions, &mut found);
        let differences = cells.iter().zip(&found).fold(0, |bits, (old, new)| bits | (old ^ new));
        outside |= !all_inside;
        if all_inside && differences != 0 {
            moved += cells.iter().zip(&found).filter(|(old, new)| old != new).count();
            cells.copy_from_slice(&found[..cells.len()]);
        }
    }
    (moved, outside)
}

impl<const D: usize> Particles<D> {
    /// Sets memory aside for `additional` particles, and not more.
    pub fn reserve_exact(&mut self, additional: usize) {
        self.position.reserve_exact(additional);
        self.velocity.reserve_exact(additional);
        self.mass.reserve_exact(additional);
        self.volume.reserve_exact(additional);
        self.half_size.reserve_exact(additional);
        self.half_size_at_start.reserve_exact(additional);
        self.stress.reserve_exact(additional);
        self.pressure.reserve_exact(additional);
        self.porosity.reserve_exact(additional);
        self.conductivity.reserve_exact(additional);
        self.drained.reserve_exact(additional);
        self.cell.reserve_exact(additional);
    }

    /// The memory of all arrays (bytes). A new field cannot be forgotten here: it would not compile.
    pub fn bytes(&self) -> usize {
        let Particles {
            position,
            velocity,
            mass,
            volume,
            half_size,
            half_size_at_start,
            stress,
            pressure,
            porosity,
            conductivity,
            drained,
            cell,
            local_motion,
            numbers,
        } = self;
        let vectors = [position, velocity, half_size, half_size_at_start].map(vec_bytes);
        let scalars = [mass, volume, pressure, porosity, conductivity].map(vec_bytes);
        let places = [cell, numbers].map(vec_bytes);
        let others = [stress.bytes(), vec_bytes(drained), vec_bytes(local_motion)];
        vectors.iter().chain(&scalars).chain(&places).chain(&others).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particle<const D: usize>(position: Vector<D>) -> Particle<D> {
        Particle {
            position,
            half_size: Vector::repeat(0.1),
            velocity: Vector::zeros(),
            density: 1.0,
            stress: Sym3::ZERO,
            pressure: 0.0,
            porosity: 0.0,
            conductivity: 0.0,
        }
    }

    /// Inside of cells, on grid lines and their neighbours among the numbers, and at both ends of the grid: the cells of [`Grid::cell_at`].
    fn check_cells<const D: usize>(cells: [usize; D]) {
        let (origin, spacing) = (Vector::from_fn(|i, _| 0.1 * (i as f64 - 1.0)), Vector::repeat(0.3));
        let grid = Grid::new(origin, spacing, cells).unwrap();
        let on_axis = |axis: usize| {
            let line = move |i: usize| origin[axis] + 0.3 * i as f64;
            let places =
                (0..=cells[axis]).flat_map(move |i| [line(i).next_down(), line(i), line(i).next_up(), line(i) + 0.1]);
            places.collect::<Vec<f64>>()
        };
        let axes: [Vec<f64>; D] = std::array::from_fn(on_axis);
        let mut particles = Particles::default();
        for number in 0..axes.iter().map(Vec::len).product() {
            let mut rest = number;
            let position = Vector::from_fn(|axis, _| {
                let place = axes[axis][rest % axes[axis].len()];
                rest /= axes[axis].len();
                place
            });
            if grid.cell_at(&position).is_some() {
                particles.push(particle(position));
            }
        }
        assert_eq!(particles.locate(&grid).unwrap(), particles.len());
        let expected: Vec<u32> = particles.position.iter().map(|x| grid.cell_at(x).unwrap() as u32).collect();
        assert_eq!(particles.cell, expected);
        assert!((0..grid.num_cells() as u32).all(|cell| expected.contains(&cell)));
        assert_eq!(particles.locate(&grid).unwrap(), 0);
    }

    #[test]
    fn cells_are_those_of_the_grid_on_lines_and_at_the_ends_too() {
        check_cells([70]);
        check_cells([5, 7]);
        check_cells([3, 2, 4]);
    }

    #[test]
    fn the_first_particle_outside_is_named() {
        let grid = Grid::new(Vector::<2>::zeros(), Vector::repeat(1.0), [3, 2]).unwrap();
        let outside =
            [Vector::<2>::new(-0.0_f64.next_up(), 1.0), Vector::<2>::new(1.0, f64::NAN), Vector::<2>::new(3.5, 1.0)];
        for position in outside {
            let mut particles = Particles::default();
            (0..200).for_each(|_| particles.push(particle(Vector::<2>::new(2.9, 1.9))));
            assert_eq!(particles.locate(&grid).unwrap(), particles.len());
            (particles.position[130], particles.position[190]) = (position, position);
            particles.position[0].x = 0.5;
            assert_eq!(particles.locate(&grid).unwrap_err().particle, 130);
        }
    }
}
