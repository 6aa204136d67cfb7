//! Whether the numbers and names of a case make sense, alone and together.

use std::collections::BTreeMap;

use crate::error::{CaseError, Problem, did_you_mean, quoted};
use crate::key_path::KeyPath;
use crate::schema::*;
use crate::source::{CaseSource, list};

/// Most cells a grid may have.
const MAX_CELLS: f64 = 1.0e9;
/// Most material points a body may be filled with.
const MAX_PARTICLES: f64 = 1.0e9;
/// Most time steps of a fixed length.
const MAX_STEPS: f64 = 1.0e12;
/// How far a box may reach beyond the grid, as a fraction of a cell: round-off in the case file.
const SLACK: f64 = 1.0e-6;
/// Most problems that are collected.
const MAX_PROBLEMS: usize = 1000;

impl CaseSource {
    /// Checks everything that can be checked on plain data, and reports all that is wrong. The names of laws, shape
    /// functions and velocity updates, and the parameters of the laws, are the registry's to check.
    pub fn validate(&self, case: &Case) -> Result<(), CaseError> {
        let mut checks = Checks { source: self, case, has_grid: false, problems: Vec::new() };
        checks.run();
        match checks.problems.is_empty() {
            true => Ok(()),
            false => Err(CaseError::content(checks.problems)),
        }
    }
}

struct Checks<'a> {
    source: &'a CaseSource,
    case: &'a Case,
    /// Whether it makes sense to compare other things with the grid.
    has_grid: bool,
    problems: Vec<Problem>,
}

impl<'a> Checks<'a> {
    fn run(&mut self) {
        if !(1..=3).contains(&self.case.dimension) {
            let message = format!("`dimension` must be 1, 2 or 3, not {}", self.case.dimension);
            // All else depends on the dimension.
            return self.report("dimension", message, "");
        }
        self.gravity();
        self.grid();
        self.time();
        self.method();
        self.fluid();
        self.materials();
        self.bodies();
        self.supports();
        self.loads();
        self.drainage();
        self.ground_motion();
        self.exact_motion();
        self.probes();
        self.output();
    }

    fn report(&mut self, key: impl Into<KeyPath>, message: impl Into<String>, help: impl Into<String>) {
        if self.problems.len() < MAX_PROBLEMS {
            self.problems.push(self.source.invalid_problem(key.into(), message.into(), help.into()));
        }
    }

    fn finite(&mut self, key: impl Into<KeyPath>, value: f64) -> bool {
        let key = key.into();
        if !value.is_finite() {
            self.report(key.clone(), format!("`{key}` must be a finite number, not {}", number(value)), "");
        }
        value.is_finite()
    }

    fn positive(&mut self, key: impl Into<KeyPath>, value: f64) -> bool {
        let key = key.into();
        if !self.finite(key.clone(), value) {
            return false;
        }
        if value <= 0.0 {
            self.report(key.clone(), format!("`{key}` must be greater than 0, not {}", number(value)), "");
        }
        value > 0.0
    }

    fn dimensions(&self) -> String {
        let plural = if self.case.dimension == 1 { "" } else { "s" };
        format!("{} dimension{plural}", self.case.dimension)
    }

    /// One entry per axis.
    fn length(&mut self, key: &KeyPath, length: usize) -> bool {
        let dimension = self.case.dimension;
        if length != dimension {
            let axes = match dimension {
                1 => "x",
                2 => "x and y",
                _ => "x, y and z",
            };
            let numbers = if length == 1 { "1 number".to_owned() } else { format!("{length} numbers") };
            self.report(
                key.clone(),
                format!("`{key}` has {numbers}, but the case has {}", self.dimensions()),
                format!("give one number for each of the axes: {axes}"),
            );
        }
        length == dimension
    }

    /// One finite number per axis.
    fn vector(&mut self, key: impl Into<KeyPath>, vector: &[f64]) -> bool {
        let key = key.into();
        let has_length = self.length(&key, vector.len());
        let mut is_good = has_length;
        for (axis, &value) in vector.iter().enumerate() {
            is_good &= self.finite(key.clone().index(axis), value);
        }
        is_good
    }

    fn gravity(&mut self) {
        if let Some(gravity) = &self.case.gravity {
            self.vector("gravity", gravity);
        }
    }

    fn grid(&mut self) {
        let grid = &self.case.grid;
        let mut is_good = self.vector("grid.origin", &grid.origin);
        is_good &= self.length(&"grid.spacing".into(), grid.spacing.len());
        for (axis, &spacing) in grid.spacing.iter().enumerate() {
            is_good &= self.positive(format!("grid.spacing[{axis}]"), spacing);
        }
        is_good &= self.length(&"grid.cells".into(), grid.cells.len());
        for (axis, _) in grid.cells.iter().enumerate().filter(|(_, cells)| **cells == 0) {
            self.report(format!("grid.cells[{axis}]"), format!("`grid.cells[{axis}]` must be at least 1, not 0"), "");
            is_good = false;
        }
        self.has_grid = is_good & self.has_sane_count() && self.has_resolution();
    }

    fn has_sane_count(&mut self) -> bool {
        let count: f64 = self.case.grid.cells.iter().map(|&cells| cells as f64).product();
        if count > MAX_CELLS {
            let message = format!("the grid has {count:.1e} cells; at most {MAX_CELLS:.0e} are allowed");
            self.report("grid.cells", message, "take fewer cells and a wider `grid.spacing`");
        }
        count <= MAX_CELLS
    }

    /// Cells so small against the coordinates that floating point cannot tell them apart.
    fn has_resolution(&mut self) -> bool {
        let mut is_good = true;
        for axis in 0..self.case.dimension {
            let (lower, upper) = self.extent(axis);
            let spacing = self.case.grid.spacing[axis];
            let largest = lower.abs().max(upper.abs());
            if !largest.is_finite() || largest * f64::EPSILON > SLACK * spacing {
                let message = format!(
                    "`grid.spacing[{axis}]` = {} is too small beside coordinates as large as {}",
                    number(spacing),
                    number(largest)
                );
                self.report(format!("grid.spacing[{axis}]"), message, "move `grid.origin` nearer to 0");
                is_good = false;
            }
        }
        is_good
    }

    /// From where to where the grid reaches along an axis.
    fn extent(&self, axis: usize) -> (f64, f64) {
        let grid = &self.case.grid;
        let value = |values: &[f64]| values.get(axis).copied().unwrap_or(f64::NAN);
        let cells = grid.cells.get(axis).map_or(f64::NAN, |&cells| cells as f64);
        (value(&grid.origin), value(&grid.origin) + cells * value(&grid.spacing))
    }

    fn time(&mut self) {
        let time = &self.case.time;
        let has_end = self.positive("time.end", time.end);
        if let Step::Seconds(step) = time.step {
            let is_good = self.positive("time.step", step);
            if is_good && has_end {
                self.step_against_end(step, time.end);
            }
        }
        if !(time.safety > 0.0 && time.safety <= 1.0) {
            let message = format!("`time.safety` must be greater than 0 and at most 1, not {}", number(time.safety));
            self.report(
                "time.safety",
                message,
                "it is the fraction of the largest stable step that is taken; 0.9 is usual",
            );
        }
    }

    fn step_against_end(&mut self, step: f64, end: f64) {
        if step > end {
            let message =
                format!("`time.step` = {} is longer than the run, `time.end` = {}", number(step), number(end));
            self.report("time.step", message, "give the step in seconds, or \"auto\"");
        } else if end / step > MAX_STEPS {
            let message = format!("`time.step` = {} makes {:.1e} steps until `time.end`", number(step), end / step);
            self.report("time.step", message, "take a longer step, or \"auto\"");
        }
    }

    fn method(&mut self) {
        let Newmark { beta, gamma } = self.case.method.newmark;
        if !(0.0..=1.0).contains(&beta) {
            let message = format!("`method.newmark.beta` must be between 0 and 1, not {}", number(beta));
            self.report("method.newmark.beta", message, "the paper takes 0.5");
        }
        let share = self.case.method.flip_share;
        if !(0.0..=1.0).contains(&share) {
            let message = format!("`method.flip_share` must be between 0 and 1, not {}", number(share));
            self.report("method.flip_share", message, "1 is `mpm1`, 0 is `mpm2`");
        }
        self.pressure_stabilisation();
        self.damping();
        self.volumetric_strain();
        if self.case.method.solver == SolverKind::Fem {
            self.finite_elements(beta, gamma);
        } else if gamma != 1.0 {
            let message = format!("`method.newmark.gamma` must be 1, not {}", number(gamma));
            let help = "any other value needs the acceleration at the beginning of the step, which material points do not carry";
            self.report("method.newmark.gamma", message, help);
        }
    }

    fn pressure_stabilisation(&mut self) {
        let softening = self.case.method.pressure_stabilisation;
        let key = "method.pressure_stabilisation";
        if !(softening >= 0.0 && softening.is_finite()) {
            let message = format!("`{key}` must be a finite number, 0 or more, not {}", number(softening));
            self.report(key, message, "0 is none, 30 is recommended where the pressure shows a checkerboard");
        } else if softening > 0.0 && self.case.method.solver == SolverKind::Fem {
            let help = format!("take `{key}` out, or take `method.solver` = \"mpm\"");
            self.report(key, "finite elements have no stabilisation of the pressure", help);
        }
    }

    fn damping(&mut self) {
        let damping = self.case.method.damping;
        if !(0.0..1.0).contains(&damping.local) {
            let message =
                format!("`method.damping.local` must be at least 0 and less than 1, not {}", number(damping.local));
            self.report("method.damping.local", message, "it is a part of the force out of balance; 0.7 is usual");
        }
        if !(damping.mass >= 0.0 && damping.mass.is_finite()) {
            let message =
                format!("`method.damping.mass` must be a finite number, 0 or more, not {}", number(damping.mass));
            let help = "it is in 1/s: twice the slowest angular frequency stops the motion soonest";
            self.report("method.damping.mass", message, help);
        }
        if !(damping.stiffness >= 0.0 && damping.stiffness.is_finite()) {
            let message = format!(
                "`method.damping.stiffness` must be a finite number, 0 or more, not {}",
                number(damping.stiffness)
            );
            self.report("method.damping.stiffness", message, "it is in s: a fraction of the time step is usual");
        }
        if self.case.method.solver == SolverKind::Fem && damping != Damping::default() {
            let help = "take [method.damping] out, or take `method.solver` = \"mpm\"";
            self.report("method.damping", "finite elements have no damping", help);
        }
    }

    fn volumetric_strain(&mut self) {
        let averaged = self.case.method.volumetric_strain == VolumetricStrain::CellAveraged;
        if averaged && self.case.method.solver == SolverKind::Fem {
            let help = "take `method.volumetric_strain` out, or take `method.solver` = \"mpm\"";
            self.report("method.volumetric_strain", "finite elements have no mean volume change of a cell", help);
        }
    }

    fn finite_elements(&mut self, beta: f64, gamma: f64) {
        if !(0.5..=1.0).contains(&gamma) {
            let message = format!("`method.newmark.gamma` must be between 0.5 and 1, not {}", number(gamma));
            self.report("method.newmark.gamma", message, "the paper takes 1");
        } else if 2.0 * beta < gamma {
            let message =
                format!("`method.newmark.beta` = {} is unstable with gamma = {}", number(beta), number(gamma));
            self.report("method.newmark.beta", message, "finite elements need 2 beta >= gamma");
        }
    }

    fn fluid(&mut self) {
        if let Some(fluid) = &self.case.fluid {
            self.positive("fluid.density", fluid.density);
            self.positive("fluid.bulk_modulus", fluid.bulk_modulus);
            self.positive("fluid.unit_weight", fluid.unit_weight);
        }
    }

    /// What needs pore water cannot be had in dry ground.
    fn needs_fluid(&mut self, key: impl Into<KeyPath>, what: &str) {
        if self.case.fluid.is_none() {
            let message = format!("{what} needs pore water, but the case has no `[fluid]`");
            self.report(key, message, "add a [fluid] with density, bulk_modulus and unit_weight, or take this out");
        }
    }

    fn materials(&mut self) {
        if self.case.materials.is_empty() {
            self.report("materials", "the case has no material", "add one, such as [materials.soil]");
        }
        for (name, material) in &self.case.materials {
            self.material(&KeyPath::from("materials").key(name), material);
        }
    }

    fn material(&mut self, key: &KeyPath, material: &Material) {
        let at = |name: &str| key.clone().key(name);
        let has_density = self.positive(at("density"), material.density);
        let has_porosity = self.porosity(at("porosity"), material.porosity);
        if let Some(conductivity) = material.conductivity {
            self.positive(at("conductivity"), conductivity);
        }
        for (name, value) in &material.parameters {
            self.parameter(at("parameters").key(name), value);
        }
        let Some(fluid) = &self.case.fluid else { return };
        for (name, meaning, value) in [
            ("porosity", "the volume of the pores over the whole, such as 0.4", material.porosity),
            ("conductivity", "the hydraulic conductivity in m/s, such as 1.0e-5", material.conductivity),
        ] {
            if value.is_none() {
                let message = format!("missing key `{name}` in `{key}`: the case has a `[fluid]`");
                self.report(key.clone(), message, format!("`{name}` is {meaning}"));
            }
        }
        if let (true, true, Some(porosity)) = (has_density, has_porosity, material.porosity) {
            self.mixture(at("density"), material.density, porosity, fluid.density);
        }
    }

    fn porosity(&mut self, key: KeyPath, porosity: Option<f64>) -> bool {
        let Some(porosity) = porosity else { return false };
        let is_good = porosity > 0.0 && porosity < 1.0;
        if !is_good {
            let help = match (2.0..100.0).contains(&porosity) {
                true => format!(
                    "it is a fraction: {} percent is {}",
                    number(porosity),
                    number((porosity * 1.0e4).round() / 1.0e6)
                ),
                false => "it is the volume of the pores over the whole".to_owned(),
            };
            self.report(key.clone(), format!("`{key}` must be between 0 and 1, not {}", number(porosity)), help);
        }
        is_good
    }

    fn mixture(&mut self, key: KeyPath, density: f64, porosity: f64, fluid_density: f64) {
        let water = porosity * fluid_density;
        if density <= water {
            let message = format!(
                "`{key}` = {} is not more than the pore water alone weighs, {}",
                number(density),
                number(water)
            );
            self.report(key, message, "it is the density of the mixture: (1 − porosity) × density of the grains + porosity × density of the fluid");
        }
    }

    fn parameter(&mut self, key: KeyPath, value: &toml::Value) {
        match value {
            toml::Value::Float(value) => {
                self.finite(key, *value);
            }
            toml::Value::Array(values) => {
                values.iter().enumerate().for_each(|(index, value)| self.parameter(key.clone().index(index), value));
            }
            toml::Value::Table(table) => {
                table.iter().for_each(|(name, value)| self.parameter(key.clone().key(name), value));
            }
            _ => {}
        }
    }

    fn bodies(&mut self) {
        if self.case.bodies.is_empty() {
            self.report("bodies", "the case has no body", "add one with [[bodies]]");
        }
        let mut names = BTreeMap::new();
        for (index, body) in self.case.bodies.iter().enumerate() {
            let key = KeyPath::from("bodies").index(index);
            if let Some(first) = names.insert(body.name(), index) {
                let message = format!("`bodies[{first}]` and `{key}` are both called `{}`", quoted(body.name()));
                let place = if body.name.is_some() { key.clone().key("name") } else { key.clone() };
                self.report(place, message, "give each a `name` of its own; the default is that of the material");
            }
            self.body(&key, body);
        }
    }

    fn body(&mut self, key: &KeyPath, body: &Body) {
        if body.name.as_deref().is_some_and(|name| name.trim().is_empty()) {
            self.report(key.clone().key("name"), format!("`{key}.name` is empty"), "give it a word, or leave it out");
        }
        let materials: Vec<_> = self.case.materials.keys().map(String::as_str).collect();
        self.refers(key.clone().key("material"), "material", &body.material, &materials);
        let bounds = self.shape(&key.clone().key("shape"), &body.shape);
        let has_particles = self.particles_per_cell(&key.clone().key("particles_per_cell"), &body.particles_per_cell);
        if let (true, Some(bounds), true) = (self.has_grid, bounds, has_particles) {
            self.particle_count(key, &bounds, &body.particles_per_cell);
        }
        self.initial(&key.clone().key("initial"), &body.initial);
    }

    /// That a name is among those given elsewhere in the case.
    fn refers(&mut self, key: KeyPath, what: &str, name: &str, known: &[&str]) {
        if known.contains(&name) {
            return;
        }
        let help = match (did_you_mean(name, known.iter().copied()), known.is_empty()) {
            (Some(near), _) => format!("did you mean `{near}`?"),
            (None, true) => format!("the case has no {what}"),
            (None, false) => format!("known here: {}", list(known)),
        };
        self.report(
            key.clone(),
            format!("`{key}` names the {what} `{}`, which the case does not have", quoted(name)),
            help,
        );
    }

    fn body_box(&mut self, key: &KeyPath, shape: &BoxShape) -> bool {
        let mut is_good = self.corners(key, shape);
        for axis in 0..if is_good { self.case.dimension } else { 0 } {
            if shape.min[axis] >= shape.max[axis] {
                let message = format!(
                    "`{key}.min[{axis}]` = {} must be less than `max[{axis}]` = {}",
                    number(shape.min[axis]),
                    number(shape.max[axis])
                );
                self.report(key.clone().key("min").index(axis), message, "the lower corner comes first");
                is_good = false;
            }
            is_good &= self.in_grid(key.clone().key("min").index(axis), axis, shape.min[axis]);
            is_good &= self.in_grid(key.clone().key("max").index(axis), axis, shape.max[axis]);
        }
        is_good
    }

    /// A box that holds the shape, if it is a good one.
    fn shape(&mut self, key: &KeyPath, shape: &BodyShape) -> Option<BoxShape> {
        match shape {
            BodyShape::Box(shape) => self.body_box(&key.clone().key("box"), shape).then(|| shape.clone()),
            BodyShape::Sphere(shape) => self.sphere(&key.clone().key("sphere"), shape),
        }
    }

    fn sphere(&mut self, key: &KeyPath, shape: &SphereShape) -> Option<BoxShape> {
        if self.case.dimension == 1 {
            self.report(key.clone(), format!("`{key}` needs 2 or 3 dimensions"), "in one dimension, take a box");
            return None;
        }
        let has_center = self.vector(key.clone().key("center"), &shape.center);
        let has_radius = self.positive(key.clone().key("radius"), shape.radius);
        let within = key.clone().key("within");
        let has_within = shape.within.as_ref().is_none_or(|shape| self.body_box(&within, shape));
        if !(has_center && has_radius && has_within) {
            return None;
        }
        let mut bounds = BoxShape { min: Vec::new(), max: Vec::new() };
        for axis in 0..self.case.dimension {
            let (lower, upper) = match &shape.within {
                Some(within) => (within.min[axis], within.max[axis]),
                None if self.has_grid => self.extent(axis),
                None => return None,
            };
            let (from, to) = (shape.center[axis] - shape.radius, shape.center[axis] + shape.radius);
            if to <= lower || from >= upper {
                let what = if shape.within.is_some() { "its box" } else { "the grid" };
                let message = format!("`{key}` lies outside {what} along {}", Axis::ALL[axis].name());
                let help = format!(
                    "there the sphere reaches from {} to {}, {what} from {} to {}",
                    number(from),
                    number(to),
                    number(lower),
                    number(upper)
                );
                self.report(key.clone().key("center").index(axis), message, help);
                return None;
            }
            bounds.min.push(from.max(lower));
            bounds.max.push(to.min(upper));
        }
        Some(bounds)
    }

    fn corners(&mut self, key: &KeyPath, shape: &BoxShape) -> bool {
        let min = self.vector(key.clone().key("min"), &shape.min);
        let max = self.vector(key.clone().key("max"), &shape.max);
        min && max
    }

    fn in_grid(&mut self, key: KeyPath, axis: usize, coordinate: f64) -> bool {
        let (lower, upper) = self.extent(axis);
        let slack = SLACK * self.case.grid.spacing.get(axis).copied().unwrap_or(0.0);
        let is_outside = self.has_grid && (coordinate < lower - slack || coordinate > upper + slack);
        if is_outside {
            let message = format!("`{key}` = {} lies outside the grid", number(coordinate));
            let help = format!(
                "along {} the grid reaches from {} to {} (`grid.origin` + `grid.cells` × `grid.spacing`)",
                Axis::ALL[axis].name(),
                number(lower),
                number(upper)
            );
            self.report(key, message, help);
        }
        !is_outside
    }

    fn particles_per_cell(&mut self, key: &KeyPath, numbers: &[usize]) -> bool {
        let mut is_good = self.length(key, numbers.len());
        for (axis, _) in numbers.iter().enumerate().filter(|(_, count)| **count == 0) {
            let place = key.clone().index(axis);
            self.report(place.clone(), format!("`{place}` must be at least 1, not 0"), "2 is usual");
            is_good = false;
        }
        is_good
    }

    fn particle_count(&mut self, key: &KeyPath, shape: &BoxShape, per_cell: &[usize]) {
        let spacing = &self.case.grid.spacing;
        let along = |axis: usize| {
            (shape.max[axis] - shape.min[axis]) / spacing.get(axis).copied().unwrap_or(f64::NAN) * per_cell[axis] as f64
        };
        let count: f64 = (0..self.case.dimension).map(along).product();
        if count > MAX_PARTICLES {
            let message =
                format!("`{key}` would hold {count:.1e} material points; at most {MAX_PARTICLES:.0e} are allowed");
            self.report(key.clone().key("particles_per_cell"), message, "take fewer points per cell or larger cells");
        }
    }

    fn initial(&mut self, key: &KeyPath, initial: &Initial) {
        if let Some(velocity) = &initial.velocity {
            self.vector(key.clone().key("velocity"), velocity);
        }
        if let Some(level) = initial.water_table {
            let place = key.clone().key("water_table");
            self.finite(place.clone(), level);
            self.needs_fluid(place, "a water table");
        }
        if let Some(geostatic) = &initial.geostatic {
            self.geostatic(&key.clone().key("geostatic"), geostatic);
        }
    }

    fn geostatic(&mut self, key: &KeyPath, geostatic: &Geostatic) {
        self.finite(key.clone().key("surface"), geostatic.surface);
        let place = key.clone().key("k0");
        if self.finite(place.clone(), geostatic.k0) && geostatic.k0 < 0.0 {
            self.report(place, format!("`{key}.k0` must be 0 or more, not {}", number(geostatic.k0)), "0.5 is usual");
        }
        if self.case.gravity.is_none() {
            let message = format!("`{key}` needs gravity, but the case has none");
            self.report(key.clone(), message, "add `gravity`, such as [0.0, -9.81], at the top level");
        }
    }

    fn supports(&mut self) {
        for (index, support) in self.case.supports.iter().enumerate() {
            let key = KeyPath::from("supports").index(index);
            match (&support.face, &support.region) {
                (Some(_), Some(_)) => {
                    let message = format!("`{key}` has both a `face` and a `region`");
                    self.report(key.clone().key("region"), message, "write two [[supports]], one for each");
                }
                (None, None) => {
                    self.report(
                        key.clone(),
                        format!("`{key}` has neither a `face` nor a `region`"),
                        "add face = \"x-min\" or another",
                    );
                }
                _ => {}
            }
            if let Some(face) = support.face {
                self.face(key.clone().key("face"), face);
            }
            if let Some(region) = &support.region {
                self.region(&key.clone().key("region"), region);
            }
            self.held_axes(&key, support);
        }
    }

    fn held_axes(&mut self, key: &KeyPath, support: &Support) {
        if support.fix.is_empty() && support.together.is_empty() {
            let help = "name the axes: fix = [\"x\"], or together = [\"x\"] for a rigid plate";
            self.report(key.clone(), format!("`{key}` holds nothing"), help);
        }
        self.axes(&key.clone().key("fix"), &support.fix);
        self.axes(&key.clone().key("together"), &support.together);
        for (index, axis) in support.together.iter().enumerate().filter(|(_, axis)| support.fix.contains(axis)) {
            let place = key.clone().key("together").index(index);
            let message = format!("`{place}` is `{}`, which `{key}.fix` holds already", axis.name());
            self.report(place, message, "nodes that do not move along an axis need not move as one along it");
        }
    }

    fn face(&mut self, key: KeyPath, face: Face) {
        if face.axis().index() >= self.case.dimension {
            let known: Vec<_> = Face::ALL[..2 * self.case.dimension].iter().map(|face| face.name()).collect();
            let message = format!("`{key}` is `{}`, but the case has only {}", face.name(), self.dimensions());
            self.report(key, message, format!("the faces here are {}", list(&known)));
        }
    }

    fn axes(&mut self, key: &KeyPath, axes: &[Axis]) {
        for (index, axis) in axes.iter().enumerate().filter(|(_, axis)| axis.index() >= self.case.dimension) {
            let place = key.clone().index(index);
            let known: Vec<_> = Axis::ALL[..self.case.dimension].iter().map(|axis| axis.name()).collect();
            let message = format!("`{place}` is `{}`, but the case has only {}", axis.name(), self.dimensions());
            self.report(place, message, format!("the axes here are {}", list(&known)));
        }
    }

    /// The box of a region may be flat, and may reach beyond the grid as long as it holds some of it.
    fn region(&mut self, key: &KeyPath, region: &BoxShape) {
        if !self.corners(key, region) {
            return;
        }
        for axis in 0..self.case.dimension {
            let (min, max) = (region.min[axis], region.max[axis]);
            let (lower, upper) = self.extent(axis);
            if min > max {
                let message =
                    format!("`{key}.min[{axis}]` = {} must not exceed `max[{axis}]` = {}", number(min), number(max));
                self.report(key.clone().key("min").index(axis), message, "the lower corner comes first");
            } else if self.has_grid && (max < lower || min > upper) {
                let message =
                    format!("`{key}` holds no node: along {} it lies outside the grid", Axis::ALL[axis].name());
                let help = format!("there the grid reaches from {} to {}", number(lower), number(upper));
                self.report(key.clone().key("min").index(axis), message, help);
            }
        }
    }

    fn body_surface(&mut self, key: &KeyPath, on: &BodySurface) {
        let surface = key.clone().key("surface");
        if let Some(face) = on.surface.face() {
            self.face(surface.clone(), face);
            let is_sphere = |body: &Body| body.name() == on.of && matches!(body.shape, BodyShape::Sphere(_));
            if self.case.bodies.iter().any(is_sphere) {
                let message = format!("`{surface}` is `{}`, but `{}` is a sphere", face.name(), quoted(&on.of));
                self.report(surface, message, "a sphere has one surface: \"all\"");
            }
        }
        let bodies = self.body_names();
        self.refers(key.clone().key("of"), "body", &on.of, &bodies);
    }

    /// The names of the bodies. Where a body's material is misspelt, its name is anybody's guess.
    fn body_names(&self) -> Vec<&'a str> {
        let case = self.case;
        let is_misspelt = |body: &Body| body.name.is_none() && !case.materials.contains_key(&body.material);
        let guesses = case.materials.keys().filter(|_| case.bodies.iter().any(is_misspelt));
        case.bodies.iter().map(Body::name).chain(guesses.map(String::as_str)).collect()
    }

    fn loads(&mut self) {
        for (index, load) in self.case.loads.iter().enumerate() {
            let key = KeyPath::from("loads").index(index);
            self.body_surface(&key.clone().key("on"), &load.on);
            self.traction_or_pressure(&key, load);
            self.history(&key.clone().key("history"), &load.history);
        }
    }

    fn traction_or_pressure(&mut self, key: &KeyPath, load: &Load) {
        match (&load.traction, load.pressure) {
            (Some(_), Some(_)) => {
                let message = format!("`{key}` has both a `traction` and a `pressure`");
                self.report(key.clone().key("pressure"), message, "write two [[loads]], one for each");
            }
            (None, None) => {
                let message = format!("`{key}` has neither a `traction` nor a `pressure`");
                self.report(key.clone(), message, "add one, such as pressure = 10.0e3");
            }
            _ => {}
        }
        if let Some(traction) = &load.traction {
            self.vector(key.clone().key("traction"), traction);
            if load.on.surface == Surface::All {
                let place = key.clone().key("on").key("surface");
                let message = format!("`{place}` is `all`, but a traction points one way");
                self.report(place, message, "name a face, such as \"y-max\", or give a `pressure`");
            }
        }
        if let Some(pressure) = load.pressure {
            self.finite(key.clone().key("pressure"), pressure);
        }
    }

    fn history(&mut self, key: &KeyPath, history: &History) {
        match history {
            History::Points(points) => self.points(key, points),
            History::SmoothStep(step) => {
                self.positive(key.clone().key("smooth-step").key("duration"), step.duration);
            }
            History::Sine(sine) => {
                let key = key.clone().key("sine");
                self.positive(key.clone().key("angular_frequency"), sine.angular_frequency);
                let start = key.key("start");
                if self.finite(start.clone(), sine.start) && sine.start < 0.0 {
                    let message = format!("`{start}` must be 0 or more, not {}", number(sine.start));
                    self.report(start, message, "leave it out to start at once");
                }
            }
        }
    }

    fn points(&mut self, key: &KeyPath, history: &[[f64; 2]]) {
        if history.is_empty() {
            self.report(key.clone(), format!("`{key}` is empty"), "leave it out for the full load from the start");
        }
        for (index, point) in history.iter().enumerate() {
            for (part, &value) in point.iter().enumerate() {
                self.finite(key.clone().index(index).index(part), value);
            }
        }
        for (index, pair) in history.windows(2).enumerate() {
            if pair[1][0] <= pair[0][0] {
                let place = key.clone().index(index + 1).index(0);
                let message = format!(
                    "the times of `{key}` must increase: {} comes after {}",
                    number(pair[1][0]),
                    number(pair[0][0])
                );
                self.report(place, message, "each point is [time, factor]; for a jump, put two times close together");
            }
        }
    }

    fn drainage(&mut self) {
        for (index, drainage) in self.case.drainage.iter().enumerate() {
            let key = KeyPath::from("drainage").index(index);
            self.needs_fluid(key.clone(), "drainage");
            self.body_surface(&key.clone().key("on"), &drainage.on);
            let sides = key.key("sides");
            if drainage.sides.as_ref().is_some_and(Vec::is_empty) {
                self.report(
                    sides.clone(),
                    format!("`{sides}` is empty: nothing drains"),
                    "leave it out to drain the surface itself",
                );
            }
            if drainage.sides.is_some() && drainage.on.surface == Surface::All {
                let message = format!("`{sides}` cannot be given for the surface `all`");
                self.report(sides.clone(), message, "there every free side drains: leave it out");
            }
            for (side, &face) in drainage.sides.iter().flatten().enumerate() {
                self.face(sides.clone().index(side), face);
            }
        }
    }

    fn ground_motion(&mut self) {
        let Some(motion) = &self.case.ground_motion else { return };
        let key = KeyPath::from("ground_motion");
        self.vector(key.clone().key("acceleration"), &motion.acceleration);
        self.history(&key.clone().key("history"), &motion.history);
        if let Some(end) = motion.end {
            self.positive(key.clone().key("end"), end);
        }
        if self.case.method.solver == SolverKind::Fem {
            let help = "take `ground_motion` out, or take `method.solver` = \"mpm\"";
            self.report(key.clone(), "finite elements have no ground motion", help);
        }
        let along = motion.acceleration.iter().zip(&self.case.grid.cells);
        if self.case.fluid.is_some() && along.into_iter().any(|(part, &cells)| *part != 0.0 && cells != 1) {
            let help = "make the grid one cell wide along it, or take the [fluid] out";
            self.report(key, "the ground motion of saturated ground must be along an axis with one cell", help);
        }
    }

    fn exact_motion(&mut self) {
        if self.case.exact_motion.is_none() {
            return;
        }
        if self.case.method.solver == SolverKind::Fem {
            let help = "take `exact_motion` out, or take `method.solver` = \"mpm\"";
            self.report("exact_motion", "finite elements have no exact motion", help);
        }
        for (index, _) in self.case.bodies.iter().enumerate().filter(|(_, body)| body.initial.velocity.is_some()) {
            let key = KeyPath::from("bodies").index(index).key("initial").key("velocity");
            self.report(key, "the velocity at the start is that of `exact_motion`", "take one of the two out");
        }
    }

    fn probes(&mut self) {
        let mut names = BTreeMap::new();
        for (index, probe) in self.case.probes.iter().enumerate() {
            let key = KeyPath::from("probes").index(index);
            self.probe_name(key.clone().key("name"), &probe.name);
            if let Some(first) = names.insert(probe.name.as_str(), index) {
                let message = format!("`probes[{first}]` and `{key}` are both called `{}`", quoted(&probe.name));
                self.report(key.clone().key("name"), message, "their columns in history.csv need different names");
            }
            if probe.pressure_at.is_none() && probe.displacement_at.is_none() {
                self.report(
                    key.clone(),
                    format!("`{key}` probes nothing"),
                    "add `pressure_at` or `displacement_at`, or both",
                );
            }
            if let Some(point) = &probe.pressure_at {
                self.needs_fluid(key.clone().key("pressure_at"), "a pressure probe");
                self.point(key.clone().key("pressure_at"), point);
            }
            if let Some(point) = &probe.displacement_at {
                self.point(key.clone().key("displacement_at"), point);
            }
        }
    }

    fn probe_name(&mut self, key: KeyPath, name: &str) {
        let is_forbidden = |c: char| c.is_whitespace() || c.is_control() || matches!(c, '.' | ',' | '"');
        if name.is_empty() {
            self.report(key.clone(), format!("`{key}` is empty"), "it heads columns in history.csv: give it a word");
        } else if name.contains(is_forbidden) {
            let cure: Vec<_> = name.split(is_forbidden).filter(|word| !word.is_empty()).collect();
            let help = format!("it heads columns in history.csv; write \"{}\"", cure.join("-"));
            self.report(
                key.clone(),
                format!("`{key}` = \"{}\" must not hold dots, commas, quotes or blanks", quoted(name)),
                help,
            );
        }
    }

    fn point(&mut self, key: KeyPath, point: &[f64]) {
        if self.vector(key.clone(), point) {
            for (axis, &coordinate) in point.iter().enumerate() {
                self.in_grid(key.clone().index(axis), axis, coordinate);
            }
        }
    }

    fn output(&mut self) {
        let output = &self.case.output;
        // The first and the last state are written whatever these say: both may be longer than the run.
        self.positive("output.every", output.every);
        if let Some(interval) = output.fields_every {
            self.positive("output.fields_every", interval);
        }
    }
}

/// A number as short as it can be written.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude == 0.0 || (1.0e-3..1.0e6).contains(&magnitude) || !value.is_finite() {
        true => format!("{value}").to_lowercase(),
        false => format!("{value:e}"),
    }
}
