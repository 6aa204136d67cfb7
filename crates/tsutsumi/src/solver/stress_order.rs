/// When in a step the effective stresses follow the strains.
///
/// # Equation
///
/// ```text
/// last             forces → v_I^L → Δε from v_I^L → σ', V_p                  the paper
/// first            v_I → Δε from v_I → σ' → forces → v_I^L → V_p
/// modified last    forces → v_I^L → V_p → v_I again from V_p, Eq. (10) → Δε from it → σ'
/// ```
///
/// An order is a list of passes over the particles, before and after the nodes have moved; the step is the same for all. What the stress
/// sees is what volume, box and pores see: they change in the same pass. Particles always move with v_I^L.
///
/// # Reference
///
/// Update stress first and last: S. G. Bardenhagen (2002), J. Comput. Phys. 180, 383–403; modified update stress last: D. Sulsky, S.-J.
/// Zhou and H. L. Schreyer (1995), Comput. Phys. Commun. 87, 236–252 (both cited from memory).
pub trait StressOrder: Send + Sync {
    /// The passes between steps 3 and 4, from which the forces are summed again; by default none.
    fn before_forces(&self) -> &'static [Pass] {
        &[]
    }

    /// The passes after step 7.
    fn after_motion(&self) -> &'static [Pass];
}

/// What one pass over the particles does: any of steps 8 to 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pass {
    /// Steps 8 and 9: strains from this velocity of the nodes, then stresses, volumes and pores.
    pub stress: Option<NodalVelocity>,
    /// Step 10: the velocities of the particles.
    pub velocity: bool,
    /// Step 10: their positions.
    pub position: bool,
}

/// A velocity field of the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NodalVelocity {
    /// v_I at the start of the step, Eq. (10).
    Old,
    /// v_I^L, after the step.
    New,
    /// v_I from the new velocities of the particles in their old places.
    Mapped,
}

// ANCHOR: orders
/// Update stress last: what the paper does. One pass.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StressLast;

impl StressOrder for StressLast {
    fn after_motion(&self) -> &'static [Pass] {
        &[Pass { stress: Some(NodalVelocity::New), velocity: true, position: true }]
    }
}

/// Update stress first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StressFirst;

impl StressOrder for StressFirst {
    fn before_forces(&self) -> &'static [Pass] {
        &[Pass { stress: Some(NodalVelocity::Old), velocity: false, position: false }]
    }

    fn after_motion(&self) -> &'static [Pass] {
        &[Pass { stress: None, velocity: true, position: true }]
    }
}

/// Modified update stress last (MUSL).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StressModifiedLast;

impl StressOrder for StressModifiedLast {
    fn after_motion(&self) -> &'static [Pass] {
        &[
            Pass { stress: None, velocity: true, position: false },
            Pass { stress: Some(NodalVelocity::Mapped), velocity: false, position: true },
        ]
    }
}
// ANCHOR_END: orders
