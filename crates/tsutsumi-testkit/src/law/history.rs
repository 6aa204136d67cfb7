//! The history: written and read, and shown.

use tsutsumi::law::ConstitutiveLaw;
use tsutsumi::tensor::Sym3;

use super::{LawPath, LawViolation, Point};

impl LawPath {
    /// A history that was written and read back answers the next increment as if it had not been.
    pub(super) fn history_survives_writing<L: ConstitutiveLaw>(
        &self,
        law: &L,
        increment: usize,
        point: &Point<L::State>,
        strain: Sym3,
    ) -> Result<(), LawViolation> {
        let state = serde_json::to_string(&point.state)
            .and_then(|text| serde_json::from_str(&text))
            .map_err(|source| LawViolation::Serialization { increment, source })?;
        let restored = Point { state, ..*point };
        let off =
            (restored.update(law, increment, strain)?.stress - point.update(law, increment, strain)?.stress).norm();
        match off <= 1e-12 * self.scale(law, point) {
            true => Ok(()),
            false => Err(LawViolation::HistoryLost { increment, off }),
        }
    }
}

pub(super) fn outputs_are_written<L: ConstitutiveLaw>(
    law: &L,
    increment: usize,
    point: &Point<L::State>,
) -> Result<(), LawViolation> {
    let names = law.outputs();
    let mut values = vec![f64::NAN; names.len()];
    law.write_outputs(point.stress, &point.state, &mut values);
    match names.iter().zip(&values).find(|(_, value)| !value.is_finite()) {
        Some((name, _)) => Err(LawViolation::Output { increment, name }),
        None => Ok(()),
    }
}
