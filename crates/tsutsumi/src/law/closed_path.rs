use std::fmt;

/// What a law promises of the work ∮ σ' : dε on closed paths of strain, in steps without a duration and from any stress that the law allows.
///
/// On a closed path the strain comes back to where it began; for laws of finite strain the deformation gradient does. The stress need not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClosedPathWork {
    /// Nothing: a closed path may take work or give it back. Stiffness that follows the stress without an energy behind it, and flow that is not
    /// along the normal of the yield surface, are of this kind.
    Any,
    /// No closed path gives work back (Ilyushin's postulate): associated plasticity about an elastic solid with an energy.
    NotNegative,
    /// No closed path takes work or gives it back: the stress is the derivative of an energy.
    Zero,
}

impl fmt::Display for ClosedPathWork {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            ClosedPathWork::Any => "nothing",
            ClosedPathWork::NotNegative => "never to give work back",
            ClosedPathWork::Zero => "neither to take nor to give work",
        })
    }
}
