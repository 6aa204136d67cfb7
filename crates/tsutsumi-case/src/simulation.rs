//! A case in motion: the model, and what is read off it.

use std::sync::Arc;

use tsutsumi::grid::Grid;
use tsutsumi::tensor::Vector;

use crate::fill::bounds;
use crate::motions::Motion;
use crate::{Body, BodyShape, Case, Model};

/// A model with the readings that a case asks for.
pub struct Simulation<const D: usize> {
    model: Box<dyn Model<D>>,
    probes: Vec<ProbeAt<D>>,
    /// The numbers of the particles whose fall is the settlement.
    top: Vec<usize>,
    /// Where the particles started (m), by number.
    position: Vec<Vector<D>>,
    /// Half heights of the top particles at the start (m).
    top_half_height: Vec<f64>,
    volume: f64,
    water_stored: f64,
    bulk_modulus: Option<f64>,
    gravity: Vector<D>,
    /// The motion that is known.
    motion: Option<Arc<dyn Motion<D>>>,
}

/// Where a probe reads.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProbeAt<const D: usize> {
    pub(crate) name: String,
    /// A fixed point (m).
    pub(crate) pressure_at: Option<Vector<D>>,
    /// The number of a particle that is followed.
    pub(crate) particle: Option<usize>,
}

/// The water and mass that a run must not lose.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Balances {
    /// Mass of all particles (kg; per metre in 2-D, per m² in 1-D).
    pub mass: f64,
    /// Volume that the ground has lost since the start (m³).
    pub volume_lost: f64,
    /// Volume of water drained since the start (m³).
    pub outflow: f64,
    /// Volume by which the pore water has been compressed since the start (m³).
    pub water_compressed: f64,
    /// What is missing: volume lost less outflow and compression (m³).
    pub water_error: f64,
}

impl<const D: usize> Simulation<D> {
    pub(crate) fn new(
        model: Box<dyn Model<D>>,
        probes: Vec<ProbeAt<D>>,
        top: Vec<usize>,
        motion: Option<Arc<dyn Motion<D>>>,
        case: &Case,
    ) -> Self {
        let particles = model.particles();
        let position = particles.position.clone();
        let top_half_height = top.iter().map(|&p| particles.half_size[p][D - 1]).collect();
        let volume = particles.volume.iter().sum();
        let bulk_modulus = case.fluid.as_ref().map(|fluid| fluid.bulk_modulus);
        // Without gravity, or an axis of it, there is none.
        let component = |axis: usize| case.gravity.as_ref().and_then(|gravity| gravity.get(axis)).copied();
        let gravity = Vector::from_fn(|axis, _| component(axis).unwrap_or(0.0));
        let mut simulation = Simulation {
            model,
            probes,
            top,
            position,
            top_half_height,
            volume,
            water_stored: 0.0,
            bulk_modulus,
            gravity,
            motion,
        };
        simulation.water_stored = simulation.water_compressed_by_pressure();
        simulation
    }

    /// The model.
    pub fn model(&self) -> &dyn Model<D> {
        &*self.model
    }

    /// The model, to advance it.
    pub fn model_mut(&mut self) -> &mut dyn Model<D> {
        &mut *self.model
    }

    /// The displacement of the particle at a place since the start (m).
    pub fn displacement(&self, place: usize) -> Vector<D> {
        let particles = self.model.particles();
        particles.position[place] - self.position[particles.number(place)]
    }

    /// The names of the readings, in the order of [`Simulation::readings`].
    pub fn reading_names(&self) -> Vec<String> {
        let axes = &["x", "y", "z"][..D];
        let mut names = vec!["time".to_owned(), "step".to_owned()];
        for probe in &self.probes {
            if probe.pressure_at.is_some() {
                names.push(format!("{}.pressure", probe.name));
            }
            if probe.particle.is_some() {
                names.extend(axes.iter().map(|axis| format!("{}.displacement.{axis}", probe.name)));
                names.extend(axes.iter().map(|axis| format!("{}.velocity.{axis}", probe.name)));
            }
        }
        names.extend(
            ["settlement.particles", "settlement.surface", "energy.kinetic", "energy.strain", "outflow"]
                .map(str::to_owned),
        );
        names.extend(["energy.potential", "energy.total", "noise.velocity"].map(str::to_owned));
        let axes_of_rotation = &["z", "x", "y"][..D * (D - 1) / 2];
        names.extend(axes_of_rotation.iter().map(|axis| format!("angular_momentum.{axis}")));
        if let Some(motion) = &self.motion {
            let scales = motion.scales();
            names.push("error.displacement".to_owned());
            names.extend(scales.velocity.map(|_| "error.velocity".to_owned()));
            names.extend(scales.energy.map(|_| "error.energy".to_owned()));
        }
        names
    }

    /// The readings now, in SI units. A pressure where there is no ground any more is NaN.
    pub fn readings(&self) -> Vec<f64> {
        let particles = self.model.particles();
        let mut row = vec![self.model.time(), self.model.steps() as f64];
        for probe in &self.probes {
            row.extend(probe.pressure_at.map(|point| self.pressure_at(&point)));
            if let Some(p) = probe.particle.map(|number| particles.place_of(number)) {
                row.extend(self.displacement(p).iter());
                row.extend(particles.velocity[p].iter());
            }
        }
        row.push(self.settlement_of_particles());
        row.push(self.settlement_of_surface());
        row.push(particles.kinetic_energy());
        row.push(self.model.strain_energy());
        row.push(self.model.outflow());
        row.extend([self.potential_energy(), self.total_energy(), self.model.unseen_velocity()]);
        row.extend(&self.angular_momentum()[..D * (D - 1) / 2]);
        if let Some(motion) = &self.motion {
            row.extend(self.errors(&**motion));
        }
        row
    }

    /// The pressure of the cell that holds a point (Pa): that of the cell's centre.
    pub fn pressure_at(&self, point: &Vector<D>) -> f64 {
        let cell = self.model.grid().cell_at(point);
        let active = cell.filter(|&cell| self.model.active().slot(cell).is_some());
        active.map_or(f64::NAN, |cell| self.model.cells().pressure[cell])
    }

    /// The largest pressure of an active cell (Pa); 0 in dry ground.
    pub fn largest_pressure(&self) -> f64 {
        let pressure = &self.model.cells().pressure;
        self.model.active().cells().iter().map(|&cell| pressure[cell as usize]).fold(0.0, f64::max)
    }

    /// The mean fall of the top particles (m): the paper's displacement of a mass.
    pub fn settlement_of_particles(&self) -> f64 {
        let rise: f64 = self.top_places().map(|p| self.displacement(p)[D - 1]).sum();
        0.0 - rise / self.top.len() as f64
    }

    /// The mean fall of the top particles' upper faces (m): the settlement of the true surface.
    pub fn settlement_of_surface(&self) -> f64 {
        let half_size = &self.model.particles().half_size;
        let thinned: f64 = self.top_places().zip(&self.top_half_height).map(|(p, old)| old - half_size[p][D - 1]).sum();
        self.settlement_of_particles() + thinned / self.top.len() as f64
    }

    /// The places of the top particles now.
    fn top_places(&self) -> impl Iterator<Item = usize> {
        self.top.iter().copied().map(self.model.particles().finder())
    }

    /// What gravity has gained or lost on the particles since the start, −Σ M_p g·u_p (J).
    pub fn potential_energy(&self) -> f64 {
        let mass = &self.model.particles().mass;
        0.0 - mass.iter().enumerate().map(|(p, mass)| mass * self.gravity.dot(&self.displacement(p))).sum::<f64>()
    }

    /// Kinetic, strain and potential energy together (J).
    pub fn total_energy(&self) -> f64 {
        self.model.particles().kinetic_energy() + self.model.strain_energy() + self.potential_energy()
    }

    /// Angular momentum Σ M_p X_p × V_p about the origin (kg m²/s): about z, x and y; z alone in 2-D.
    ///
    /// What particles carry besides their velocities, as with APIC, is not in it.
    pub fn angular_momentum(&self) -> [f64; 3] {
        let particles = self.model.particles();
        let about = |first: usize, second: usize| -> f64 {
            let of_particle = |p: usize| {
                let (x, v) = (&particles.position[p], &particles.velocity[p]);
                particles.mass[p] * (x[first] * v[second] - x[second] * v[first])
            };
            if first.max(second) < D { (0..particles.len()).map(of_particle).sum() } else { 0.0 }
        };
        [about(0, 1), about(1, 2), about(2, 0)]
    }

    /// How far the particles are from an exact motion: root mean squares of displacement and velocity over all particles, and
    /// the energy, each over the motion's own size (–), as far as it has them.
    fn errors(&self, motion: &dyn Motion<D>) -> impl Iterator<Item = f64> {
        let (time, particles, scales) = (self.model.time(), self.model.particles(), motion.scales());
        let rms = |error: &dyn Fn(usize, &Vector<D>) -> Vector<D>| {
            let starts = particles.places_by_number().zip(&self.position);
            let squares = starts.map(|(p, start)| error(p, start).norm_squared());
            (squares.sum::<f64>() / particles.len() as f64).sqrt()
        };
        let displacement = rms(&|p, start| self.displacement(p) - motion.displacement(start, time));
        let velocity =
            scales.velocity.map(|scale| rms(&|p, start| particles.velocity[p] - motion.velocity(start, time)) / scale);
        let energy = scales.energy.map(|scale| (self.total_energy() - motion.energy(time)) / scale);
        std::iter::once(displacement / scales.displacement).chain(velocity).chain(energy)
    }

    /// What must balance.
    pub fn balances(&self) -> Balances {
        let particles = self.model.particles();
        let volume_lost = self.volume - particles.volume.iter().sum::<f64>();
        let outflow = self.model.outflow();
        let water_compressed = self.water_compressed_by_pressure() - self.water_stored;
        let mass = particles.mass.iter().sum();
        Balances { mass, volume_lost, outflow, water_compressed, water_error: volume_lost - outflow - water_compressed }
    }

    /// Σ n V p_w / K^f (m³).
    fn water_compressed_by_pressure(&self) -> f64 {
        let particles = self.model.particles();
        let Some(bulk_modulus) = self.bulk_modulus else {
            return 0.0;
        };
        let compressed = |p: usize| particles.porosity[p] * particles.volume[p] * particles.pressure[p];
        (0..particles.len()).map(compressed).sum::<f64>() / bulk_modulus
    }
}

/// The edges of the bodies at the start, seen along the axes `across` and `up` (m).
pub(crate) fn outlines<const D: usize>(
    bodies: &[Body],
    grid: &Grid<D>,
    across: usize,
    up: usize,
) -> Vec<[[f64; 2]; 2]> {
    let edges = |body: &Body| {
        let corners = outline(&body.shape, grid, across, up);
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&from, &to)| [from, to]).collect::<Vec<_>>()
    };
    bodies.iter().flat_map(edges).collect()
}

/// The corners of the edge of a shape, one after the other.
fn outline<const D: usize>(shape: &BodyShape, grid: &Grid<D>, across: usize, up: usize) -> Vec<[f64; 2]> {
    let (lower, upper) = bounds(shape, grid);
    match shape {
        BodyShape::Box(_) => {
            let (x, y) = ([lower[across], upper[across]], [lower[up], upper[up]]);
            vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
        }
        // A circle of 96 corners, pressed into the box that cuts it.
        BodyShape::Sphere(sphere) => (0..96)
            .map(|corner| {
                let angle = f64::from(corner) / 96.0 * std::f64::consts::TAU;
                let x = sphere.center[across] + sphere.radius * angle.cos();
                let y = sphere.center[up] + sphere.radius * angle.sin();
                [x.max(lower[across]).min(upper[across]), y.max(lower[up]).min(upper[up])]
            })
            .collect(),
    }
}
