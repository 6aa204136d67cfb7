// The one room with `unsafe`: a foreign routine is called through a pointer that a shared library gave.
#![allow(unsafe_code, reason = "a UMAT can only be called through a pointer from a shared library")]

use std::ffi::{c_char, c_int};
use std::path::Path;
use std::sync::Mutex;

use libloading::Library;
use tsutsumi::tensor::{Matrix3, Matrix6, Sym3};

use crate::state::{MAX_STATE_VARIABLES, UmatState};

/// `SUBROUTINE UMAT(STRESS, STATEV, DDSDDE, SSE, SPD, SCD, RPL, DDSDDT, DRPLDE, DRPLDT, STRAN, DSTRAN, TIME, DTIME, TEMP, DTEMP, PREDEF,
/// DPRED, CMNAME, NDI, NSHR, NTENS, NSTATV, PROPS, NPROPS, COORDS, DROT, PNEWDT, CELENT, DFGRD0, DFGRD1, NOEL, NPT, LAYER, KSPT, KSTEP,
/// KINC)`, and the hidden length of `CMNAME`.
type Umat = unsafe extern "C" fn(
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *mut f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const f64,
    *const c_char,
    *const c_int,
    *const c_int,
    *const c_int,
    *const c_int,
    *const f64,
    *const c_int,
    *const f64,
    *const f64,
    *mut f64,
    *const f64,
    *const f64,
    *const f64,
    *const c_int,
    *const c_int,
    *const c_int,
    *const c_int,
    *const c_int,
    *const c_int,
    usize,
);

/// A routine in a library that stays loaded as long as it lives.
pub(crate) struct Routine {
    entry: Umat,
    /// One call at a time: routines may keep values between them.
    turn: Mutex<()>,
    _library: Library,
}

impl std::fmt::Debug for Routine {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("Routine")
    }
}

/// What a routine is asked.
pub(crate) struct Question<'a> {
    /// At the start (Pa), turned.
    pub(crate) stress: Sym3,
    pub(crate) state: &'a UmatState,
    /// The increment (–).
    pub(crate) strain: Sym3,
    /// (s)
    pub(crate) duration: f64,
    pub(crate) properties: &'a [f64],
    pub(crate) state_variables: usize,
    pub(crate) material_name: &'a str,
}

/// What it answers.
pub(crate) struct Answer {
    /// At the end (Pa).
    pub(crate) stress: Sym3,
    pub(crate) state: UmatState,
    /// DDSDDE in Kelvin components (Pa).
    pub(crate) tangent: Matrix6,
    /// PNEWDT.
    pub(crate) shorter_step: f64,
}

impl Routine {
    pub(crate) fn load(library: &Path, routine: &str) -> Result<Self, String> {
        // SAFETY: loading runs the library's initialisers. The user named this library in order to run its code.
        let loaded = unsafe { Library::new(library) }.map_err(|error| format!("cannot load it: {error}"))?;
        // SAFETY: the symbol is taken for a UMAT because the user says that it is one; nothing in a library can be checked against that.
        let entry = unsafe { loaded.get::<Umat>(routine.as_bytes()) }
            .map(|symbol| *symbol)
            .map_err(|error| format!("it has no routine `{routine}`: {error}"))?;
        Ok(Routine { entry, turn: Mutex::new(()), _library: loaded })
    }

    pub(crate) fn call(&self, question: &Question) -> Answer {
        let mut stress = stress_to_foreign(question.stress);
        let mut variables = question.state.variables;
        let mut ddsdde = [0.0; 36];
        let (mut sse, mut spd, mut scd, mut rpl, mut drpldt) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut ddsddt, mut drplde) = ([0.0; 6], [0.0; 6]);
        let (stran, dstran) = (strain_to_foreign(question.state.strain), strain_to_foreign(question.strain));
        let time = [0.0; 2];
        let zero = 0.0;
        let mut name = [b' '; 80];
        name.iter_mut().zip(question.material_name.bytes()).for_each(|(to, from)| *to = from);
        let (three, six, one): (c_int, c_int, c_int) = (3, 6, 1);
        // Both are far below 2³¹: the first by `validate`, the second as a list in a file.
        let (num_states, num_properties) = (question.state_variables as c_int, question.properties.len() as c_int);
        let coordinates = [0.0; 3];
        let mut pnewdt = 1.0;
        let length = 1.0;
        let before = question.state.deformation;
        let after = (Matrix3::identity() + question.strain.to_matrix()) * question.state.turn * before;
        {
            // A routine cannot panic, so the lock cannot be poisoned; if it were, it would still be ours.
            let _turn = self.turn.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            // SAFETY: every pointer leads to as many values as the interface says, alive until the call returns: STATEV has `MAX_STATE_VARIABLES`, at least NSTATV;
            // matrices are by columns as in Fortran. That the routine keeps to its interface is the user's word.
            unsafe {
                (self.entry)(
                    stress.as_mut_ptr(),
                    variables.as_mut_ptr(),
                    ddsdde.as_mut_ptr(),
                    &mut sse,
                    &mut spd,
                    &mut scd,
                    &mut rpl,
                    ddsddt.as_mut_ptr(),
                    drplde.as_mut_ptr(),
                    &mut drpldt,
                    stran.as_ptr(),
                    dstran.as_ptr(),
                    time.as_ptr(),
                    &question.duration,
                    &zero,
                    &zero,
                    &zero,
                    &zero,
                    name.as_ptr().cast(),
                    &three,
                    &three,
                    &six,
                    &num_states,
                    question.properties.as_ptr(),
                    &num_properties,
                    coordinates.as_ptr(),
                    question.state.turn.as_ptr(),
                    &mut pnewdt,
                    &length,
                    before.as_ptr(),
                    after.as_ptr(),
                    &one,
                    &one,
                    &one,
                    &one,
                    &one,
                    &one,
                    name.len(),
                );
            }
        }
        variables[question.state_variables.min(MAX_STATE_VARIABLES)..].fill(0.0);
        let strain = question.state.strain + question.strain;
        let state = UmatState { variables, strain, turn: Matrix3::identity(), deformation: after };
        Answer {
            stress: stress_from_foreign(&stress),
            state,
            tangent: tangent_from_foreign(&ddsdde),
            shorter_step: pnewdt,
        }
    }
}

/// 11, 22, 33, 12, 13, 23.
fn stress_to_foreign(stress: Sym3) -> [f64; 6] {
    [stress.xx, stress.yy, stress.zz, stress.xy, stress.zx, stress.yz]
}

fn stress_from_foreign(&[xx, yy, zz, xy, zx, yz]: &[f64; 6]) -> Sym3 {
    Sym3 { xx, yy, zz, xy, yz, zx }
}

/// Engineering shear γ = 2 ε.
fn strain_to_foreign(strain: Sym3) -> [f64; 6] {
    [strain.xx, strain.yy, strain.zz, 2.0 * strain.xy, 2.0 * strain.zx, 2.0 * strain.yz]
}

/// dσ/dγ by columns into Kelvin components: √2 on the shear rows, and γ = √2 times the Kelvin strain on the shear columns.
fn tangent_from_foreign(ddsdde: &[f64; 36]) -> Matrix6 {
    const PLACE: [usize; 6] = [0, 1, 2, 3, 5, 4];
    let factor = |i: usize| if i < 3 { 1.0 } else { std::f64::consts::SQRT_2 };
    let mut tangent = Matrix6::zeros();
    for row in 0..6 {
        for column in 0..6 {
            tangent[(PLACE[row], PLACE[column])] = factor(row) * factor(column) * ddsdde[6 * column + row];
        }
    }
    tangent
}
