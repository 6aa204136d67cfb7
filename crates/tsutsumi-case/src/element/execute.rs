//! The stages of a test, one after the other.

use std::ops::ControlFlow;

use serde::Serialize;
use tsutsumi::element::{Course, Criterion, Cycles, ElementError, ExcessPressure, Specimen};
use tsutsumi::law::Increment;

use super::motion::{Motion, held_total};
use super::record::{Place, Record, Recorder};
use super::schema::{DrainageKind, ElementTestFile, Stage, StageKind};
use crate::Outcome;

/// What became of a stage.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageReport {
    /// How the specimen was held.
    pub kind: StageKind,
    /// Increments made.
    pub increments: usize,
    /// Cycles made (–), in a cyclic stage.
    pub cycles: Option<f64>,
    /// Which limit has ended a cyclic stage, by its key.
    pub ended_by: Option<&'static str>,
}

/// What is left of a test.
pub(crate) struct Executed {
    pub(crate) record: Record,
    pub(crate) stages: Vec<StageReport>,
    pub(crate) outcome: Outcome,
}

/// Takes a specimen through all stages of a file.
pub(crate) fn execute(file: &ElementTestFile, mut specimen: Specimen, stop: &dyn Fn() -> bool) -> Executed {
    let recorder = Recorder::new(file, &specimen);
    let mut test = Test { every: file.output.every, recorder, stop, water: None, place: Place::default() };
    let (mut stages, mut outcome) = (Vec::new(), Outcome::Finished);
    for (index, stage) in file.stages.iter().enumerate() {
        test.place = Place { stage: index + 1, increment: 0, cycle: 0.0 };
        let ended = test.stage(stage, &mut specimen);
        // The last state is kept, however the stage has ended.
        test.recorder.write(test.place, &specimen, test.water);
        let is_cyclic = stage.amplitude.is_some();
        let ended_by = ended.as_ref().ok().and_then(|end| end.criterion).map(key_of);
        stages.push(StageReport {
            kind: stage.kind,
            increments: test.place.increment,
            cycles: is_cyclic.then_some(test.place.cycle),
            ended_by,
        });
        match ended {
            Ok(End { interrupted: false, .. }) => {}
            Ok(_) => outcome = Outcome::Interrupted,
            Err(error) => {
                let at = test.place.increment + 1;
                outcome =
                    Outcome::Failed(format!("stage {} ({}), increment {at}: {error}", index + 1, stage.kind.name()));
            }
        }
        if outcome != Outcome::Finished {
            break;
        }
    }
    Executed { record: test.recorder.record, stages, outcome }
}

/// How a stage has ended.
struct End {
    interrupted: bool,
    criterion: Option<Criterion>,
}

struct Test<'a> {
    every: usize,
    recorder: Recorder,
    stop: &'a dyn Fn() -> bool,
    water: Option<ExcessPressure>,
    place: Place,
}

impl Test<'_> {
    fn stage(&mut self, stage: &Stage, specimen: &mut Specimen) -> Result<End, String> {
        if stage.zero_strain {
            self.recorder.zero_strain(specimen);
        }
        self.open_or_close_drain(stage, specimen);
        self.recorder.write(self.place, specimen, self.water);
        let ended = match Motion::of(stage, specimen, self.water)? {
            Motion::Monotonic { loading, to, increments, duration } => {
                let course = Course::begin(*loading, specimen).with_duration(duration);
                self.monotonic(specimen, course, to, increments)
            }
            Motion::Cyclic(cycles) => self.cyclic(specimen, &cycles),
            Motion::Once(increment) => self.once(specimen, &increment),
        };
        ended.map_err(|error| error.to_string())
    }

    /// A drain that stays closed from one undrained stage to the next keeps the pore pressure.
    fn open_or_close_drain(&mut self, stage: &Stage, specimen: &Specimen) {
        let direction = held_total(stage.kind);
        self.water = match (stage.drainage, self.water) {
            (Some(DrainageKind::Undrained), Some(water)) if water.direction == direction => Some(water),
            (Some(DrainageKind::Undrained), _) => Some(ExcessPressure::begin(direction, specimen)),
            _ => None,
        };
    }

    fn monotonic(
        &mut self,
        specimen: &mut Specimen,
        mut course: Course,
        to: f64,
        increments: usize,
    ) -> Result<End, ElementError> {
        for increment in 1..=increments {
            if (self.stop)() {
                return Ok(End { interrupted: true, criterion: None });
            }
            let target = to * increment as f64 / increments as f64;
            course.advance(specimen, target - course.parameter())?;
            self.place.increment = increment;
            if increment.is_multiple_of(self.every) {
                self.recorder.write(self.place, specimen, self.water);
            }
        }
        Ok(End { interrupted: false, criterion: None })
    }

    fn once(&mut self, specimen: &mut Specimen, increment: &Increment) -> Result<End, ElementError> {
        specimen.undergo(increment)?;
        self.place.increment = 1;
        Ok(End { interrupted: false, criterion: None })
    }

    fn cyclic(&mut self, specimen: &mut Specimen, cycles: &Cycles) -> Result<End, ElementError> {
        let criterion = cycles.run(specimen, |specimen, progress| {
            self.place = Place { increment: progress.increment, cycle: progress.cycle, ..self.place };
            if progress.turns || progress.increment.is_multiple_of(self.every) {
                self.recorder.write(self.place, specimen, self.water);
            }
            if (self.stop)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        Ok(End { interrupted: criterion.is_none(), criterion })
    }
}

fn key_of(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::Cycles => "cycles",
        Criterion::SingleStrain => "single_strain",
        Criterion::DoubleStrain => "double_strain",
        Criterion::PorePressureRatio => "pore_pressure_ratio",
    }
}
