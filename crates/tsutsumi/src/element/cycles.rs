use std::ops::ControlFlow;

use super::{Condition, Course, ElementError, ExcessPressure, Loading, Specimen, SpecimenState};
use crate::tensor::Sym3;

/// A load that goes back and forth until something happens.
///
/// The loading parameter grows until the watched quantity is one amplitude above its value at the start, falls until it is one amplitude
/// below, and so on. Where the watched quantity is a stress and the driven one a strain, liquefied ground can be followed as well.
///
/// Cycles are counted in parts: ¼ at the first turn, ½ more at each of the others, in between by how far the watched quantity has come
/// on its way from turn to turn. One cycle ends where the quantity is back at its value at the start, on its way up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycles {
    /// How the specimen is held and driven; the watched quantity must grow with its parameter.
    pub loading: Loading,
    /// The quantity at whose values the load turns.
    pub watched: Condition,
    /// The amplitude of the watched quantity, in its unit.
    pub amplitude: f64,
    /// The change of the loading parameter in one increment, positive.
    pub increment: f64,
    /// How long an increment takes (s); infinite where time plays no part.
    pub duration: f64,
    /// The strain that tells how far the test has gone.
    pub strain: Condition,
    /// The pore pressure, if the test is undrained.
    pub water: Option<ExcessPressure>,
    /// When the test ends.
    pub limits: CycleLimits,
}

/// When a cyclic test ends: at the first of these.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleLimits {
    /// After so many cycles (–).
    pub cycles: f64,
    /// When the strain is so far from that at the start (–): single amplitude.
    pub single_strain: Option<f64>,
    /// When the strain is so far from that at the last turn (–): double amplitude.
    pub double_strain: Option<f64>,
    /// When the pore pressure ratio is this large (–).
    pub pore_pressure_ratio: Option<f64>,
    /// The strain in one direction after which the amplitude counts as out of reach (–).
    pub give_up_strain: f64,
}

/// Which of the limits has ended a cyclic test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// The number of cycles.
    Cycles,
    /// The single amplitude of the strain.
    SingleStrain,
    /// The double amplitude of the strain.
    DoubleStrain,
    /// The pore pressure ratio.
    PorePressureRatio,
}

/// How far a cyclic test is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleProgress {
    /// Increments made.
    pub increment: usize,
    /// Cycles made (–).
    pub cycle: f64,
    /// Whether the load turns here.
    pub turns: bool,
    /// Why the test ends here, if it does.
    pub end: Option<Criterion>,
}

/// A way from turn to turn.
struct Leg {
    sign: f64,
    /// The watched quantity where it began, and where the load turns.
    from: f64,
    to: f64,
    /// Cycles where it began, and how much of one it is.
    cycle: f64,
    span: f64,
    /// The strain where it began (–).
    strain: f64,
}

impl Leg {
    /// Cycles made, at a value of the watched quantity.
    fn cycle_at(&self, value: f64) -> f64 {
        self.cycle + self.span * ((value - self.from) / (self.to - self.from)).clamp(0.0, 1.0)
    }
}

impl Cycles {
    /// Loads a specimen until one of the limits is reached or `observe`, called after every increment, says [`ControlFlow::Break`].
    /// Which limit it was; nothing after a break.
    ///
    /// # Errors
    /// Those of [`Course::advance`], and [`ElementError::OutOfReach`].
    pub fn run(
        &self,
        specimen: &mut Specimen,
        mut observe: impl FnMut(&Specimen, &CycleProgress) -> ControlFlow<()>,
    ) -> Result<Option<Criterion>, ElementError> {
        let mut course = Course::begin(self.loading, specimen).with_duration(self.duration);
        let centre = self.watched.of(specimen);
        let start_strain = self.strain.of(specimen);
        let to = centre + self.amplitude;
        let mut leg = Leg { sign: 1.0, from: centre, to, cycle: 0.0, span: 0.25, strain: start_strain };
        let mut increment = 0;
        loop {
            // The last leg may end before its turn.
            let share = ((self.limits.cycles - leg.cycle) / leg.span).min(1.0);
            let target = leg.from + share * (leg.to - leg.from);
            let turns = course.advance_until(specimen, leg.sign * self.increment, &self.watched, target)?;
            increment += 1;
            let cycle = match turns {
                true => leg.cycle + share * leg.span,
                false => leg.cycle_at(self.watched.of(specimen)),
            };
            let end = self.end(specimen, start_strain, leg.strain, turns && share < 1.0 || cycle >= self.limits.cycles);
            let progress = CycleProgress { increment, cycle, turns, end };
            if observe(specimen, &progress).is_break() {
                return Ok(None);
            }
            if end.is_some() {
                return Ok(end);
            }
            if turns {
                leg = self.next_leg(&leg, specimen, centre);
            } else if (self.strain.of(specimen) - leg.strain).abs() > self.limits.give_up_strain {
                return Err(self.out_of_reach(specimen, target));
            }
        }
    }

    fn next_leg(&self, leg: &Leg, specimen: &Specimen, centre: f64) -> Leg {
        let sign = -leg.sign;
        Leg {
            sign,
            from: leg.to,
            to: centre + sign * self.amplitude,
            cycle: leg.cycle + leg.span,
            span: 0.5,
            strain: self.strain.of(specimen),
        }
    }

    fn end(&self, specimen: &Specimen, start_strain: f64, turn_strain: f64, all_cycles: bool) -> Option<Criterion> {
        let strain = self.strain.of(specimen);
        let reaches = |limit: Option<f64>, value: f64| limit.is_some_and(|limit| value >= limit);
        let ratio = self.water.map_or(f64::NAN, |water| water.ratio(specimen));
        let limits = &self.limits;
        let ends = [
            (reaches(limits.single_strain, (strain - start_strain).abs()), Criterion::SingleStrain),
            (reaches(limits.double_strain, (strain - turn_strain).abs()), Criterion::DoubleStrain),
            (reaches(limits.pore_pressure_ratio, ratio), Criterion::PorePressureRatio),
            (all_cycles, Criterion::Cycles),
        ];
        ends.into_iter().find_map(|(is_reached, criterion)| is_reached.then_some(criterion))
    }

    fn out_of_reach(&self, specimen: &Specimen, target: f64) -> ElementError {
        let state = SpecimenState::of(specimen, Sym3::ZERO);
        let (value, limit) = (self.watched.of(specimen), self.limits.give_up_strain);
        ElementError::OutOfReach { value, target, limit, state }
    }
}
