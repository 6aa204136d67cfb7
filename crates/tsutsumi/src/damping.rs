//! Damping of the nodes' motion, for problems of which only the state of rest is wanted.

use crate::grid::{ActiveSet, NodeFields};

/// Three resistances that vanish at rest: they change the way to equilibrium, not the equilibrium.
///
/// # Equation
///
/// ```text
/// f_I ← f_I − α_l |r_I| sgn(v_I) − α_m m_I v_I − β dF^int_I/dt        r_I = f_I + K_v p_w*,  along each axis
/// ```
///
/// `r` is the force out of balance, m_I a_I of the step without damping: effective stress, gravity and loads *with* the pore pressure
/// p_w* of that step, which carries a large part of them in saturated ground. The pressures are solved for once more with the
/// resistance, so that the balance of the water stays exact. Nodes that move as one have one `r`, the sum over them.
///
/// - `local` turns a part of the force out of balance against the motion. It has no frequency: all modes come to rest in a few
///   periods of their own, an oscillator loses √((1−α)/(1+α)) of its amplitude in half a period. The weight of a body that
///   falls freely is out of balance too: it falls with (1−α) g. For dynamics it is wrong.
/// - `mass` is a viscous resistance, the first part of Rayleigh's: a mode of angular frequency ω has the damping ratio
///   α/2ω. Slow modes are damped most; 2ω of the slowest stops it soonest.
///
/// - `stiffness` is a viscous skeleton, the second part of Rayleigh's: the nodes feel σ' + β Δσ'/Δt with the law's last increment. A
///   mode of angular frequency ω has the damping ratio β ω/2: fast modes, noise and hourglasses are damped most. In yielding ground
///   the tangent resists, which is less. It shortens the step: β of the size of the step itself costs a factor 2.4.
///
/// # Reference
///
/// `local`: Cundall (1987), Distinct element models of rock and soil structure, in Brown (ed.), Analytical and computational
/// methods in engineering rock mechanics, ch. 4; `mass` and `stiffness`: any textbook of structural dynamics (all cited from memory).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Damping {
    /// Part α_l of the force out of balance that resists the motion (–), 0 ≤ α_l < 1.
    pub local: f64,
    /// Viscous resistance α_m per mass (1/s), not negative.
    pub mass: f64,
    /// Time β (s) by which the skeleton's stress runs ahead, not negative.
    pub stiffness: f64,
}

impl Damping {
    /// True when nothing is damped.
    pub fn is_off(&self) -> bool {
        self.local == 0.0 && self.mass == 0.0 && self.stiffness == 0.0
    }

    /// True when the resistance depends on the force out of balance.
    pub(crate) fn needs_force_out_of_balance(&self) -> bool {
        self.local > 0.0
    }

    /// Adds the resistance to the nodes' forces. The force out of balance (N) stands in `acceleration`, which is used up.
    pub(crate) fn resist<const D: usize>(&self, active: &ActiveSet, nodes: &mut NodeFields<D>) {
        let NodeFields { mass, velocity_old, acceleration, force, ties, .. } = nodes;
        for tie in &*ties {
            tie.gather(acceleration);
            // The first node of a tie resists for all.
            for &node in tie.nodes().iter().skip(1) {
                acceleration[node as usize][tie.axis()] = 0.0;
            }
        }
        for &node in active.nodes() {
            let node = node as usize;
            for axis in 0..D {
                let velocity = velocity_old[node][axis];
                // At rest there is no direction to resist: f64::signum would give one.
                let direction = if velocity == 0.0 { 0.0 } else { velocity.signum() };
                force[node][axis] -=
                    self.local * acceleration[node][axis].abs() * direction + self.mass * mass[node] * velocity;
            }
        }
    }

    /// The longest stable step (s) of consolidation that is stable up to `undamped` (s) without damping; see
    /// [`Coupled`](crate::pressure::Coupled)'s limit. `rate` is r (1/s), `tau` τ (s), `inertia` T = k ρ/γ_w (s).
    pub(crate) fn shorten_consolidation(&self, undamped: f64, rate: f64, tau: f64, inertia: f64) -> f64 {
        let resisted = |dt: f64| self.local * inertia / (tau + dt);
        let stable = |dt: f64| {
            let left = tau - dt * (inertia * self.mass + resisted(dt));
            rate * dt * (dt + 2.0 * self.stiffness) * (1.0 + resisted(dt)) <= 2.0 * (tau + dt) + 2.0 * left.min(0.0)
        };
        if self.is_off() || stable(undamped) {
            return undamped;
        }
        // Bisection to the last bits: short steps are stable.
        let (mut lower, mut upper) = (0.0, undamped);
        for _ in 0..60 {
            let middle = 0.5 * (lower + upper);
            if stable(middle) {
                lower = middle;
            } else {
                upper = middle;
            }
        }
        lower
    }

    /// The longest stable step (s) of what is stable up to `undamped` (s) without damping.
    ///
    /// # Equation
    ///
    /// ```text
    /// ω² (1 + α_l) (Δt² + 2 β Δt) ≤ 4 − 2 α_m Δt,  ω = 2/Δt_undamped
    /// ```
    ///
    /// A shortest wave that turns round in every step has its force along the resistance: both add.
    pub(crate) fn shorten(&self, undamped: f64) -> f64 {
        let stiff = undamped / (1.0 + self.local).sqrt();
        if self.mass == 0.0 && self.stiffness == 0.0 {
            return stiff;
        }
        // Of the two roots the form without cancellation. Without a shortest wave it is 2/α_m, for a motion that nothing else
        // resists.
        let slow = 0.25 * self.mass + self.stiffness / (stiff * stiff);
        1.0 / (slow + (1.0 / (stiff * stiff) + slow * slow).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_damping_the_step_is_as_long_as_before() {
        assert_eq!(Damping::default().shorten(0.00123), 0.00123);
        assert_eq!(Damping::default().shorten(f64::INFINITY), f64::INFINITY);
        assert_eq!(Damping { mass: 4.0, ..Damping::default() }.shorten(f64::INFINITY), 0.5);
    }

    /// ω² (1 + α_l) (Δt² + 2 β Δt) = 4 − 2 α_m Δt at the limit, to round-off.
    #[test]
    fn the_limit_solves_its_equation() {
        let damping = Damping { local: 0.7, mass: 300.0, stiffness: 0.002 };
        let step = damping.shorten(0.01);
        let stiffness = (2.0 / 0.01_f64).powi(2) * 1.7;
        assert!((stiffness * step * (step + 0.004) + 2.0 * 300.0 * step - 4.0).abs() < 1e-14);
    }
}
