//! A small law compiled to a shared library gives what the built-in one gives.
//!
//! In Fortran where there is a compiler for it, in C in any case (Rust needs a C compiler to link). `TSUTSUMI_FORTRAN=1` demands Fortran.

#![allow(clippy::unwrap_used, reason = "a test reports by panicking")]

use std::path::{Path, PathBuf};
use std::process::Command;

use tsutsumi::boundary::History;
use tsutsumi::law::{ConstitutiveLaw, LawError, LinearElastic};
use tsutsumi::tensor::{Matrix3, Sym3, Vector, rotation};
use tsutsumi_testkit::body::{Body, down};
use tsutsumi_testkit::compare::assert_all_close;
use tsutsumi_testkit::law::check_law;
use tsutsumi_testkit::noise::Noise;
use tsutsumi_testkit::reading::{cell_pressures, run, top};
use tsutsumi_umat::Umat;

const SOIL: LinearElastic = LinearElastic { young: 4.35e6, poisson: 0.45 };

/// Compiles a source of this folder into a shared library; `None` without the compiler.
fn library(folder: &Path, compiler: &str, source: &str) -> Option<PathBuf> {
    let library = folder.join(format!("lib{}.so", source.replace('.', "_")));
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(source);
    let status =
        Command::new(compiler).args(["-O2", "-shared", "-fPIC", "-o"]).arg(&library).arg(&source).status().ok()?;
    assert!(status.success(), "{compiler} {source:?}");
    Some(library)
}

/// The laws from all compilers that there are.
fn laws(folder: &Path) -> Vec<Umat> {
    let fortran = library(folder, "gfortran", "elastic.f");
    assert!(fortran.is_some() || std::env::var_os("TSUTSUMI_FORTRAN").is_none(), "gfortran is not installed");
    let c = library(folder, "cc", "elastic.c").unwrap();
    let law = |library: PathBuf| {
        let mut law = Umat::new(library, vec![SOIL.young, SOIL.poisson]);
        law.state_variables = 4;
        law
    };
    fortran.into_iter().chain([c]).map(law).collect()
}

#[test]
fn a_compiled_law_gives_the_answers_of_the_built_in_one() {
    let folder = tempfile::tempdir().unwrap();
    for law in laws(folder.path()) {
        law.validate().unwrap();
        let mut noise = Noise::new(7);
        let (mut foreign, mut state) = (Sym3::ZERO, law.initial_state(Sym3::ZERO));
        let mut own = Sym3::ZERO;
        for _ in 0..100 {
            let strain = (noise.tensor() - Sym3::IDENTITY * 0.5) * 1e-3;
            (foreign, state) = law.update(foreign, state, strain).unwrap();
            (own, ()) = SOIL.update(own, (), strain).unwrap();
            // The same sums in another order.
            assert!((foreign - own).norm() < 1e-12 * own.norm(), "{foreign} {own}");
        }
        assert_eq!(state.variables()[0], 100.0);
        let tangent = law.tangent(foreign, state, Sym3::ZERO).unwrap() - SOIL.tangent(own, (), Sym3::ZERO).unwrap();
        assert!(tangent.norm() < 1e-12 * SOIL.oedometric_modulus());
        assert!((law.p_wave_modulus(foreign, &state) / SOIL.oedometric_modulus() - 1.0).abs() < 1e-12);
        assert!((law.s_wave_modulus(foreign, &state) / SOIL.shear_modulus() - 1.0).abs() < 1e-12);
        check_law(&law).unwrap();
    }
}

/// A whole run, the paper's column in 2-D with noise in its velocities so that it shears and turns.
#[test]
fn a_body_moves_as_with_the_built_in_law() {
    fn pressures(body: Body<2, impl ConstitutiveLaw>) -> Vec<f64> {
        let noise = std::cell::RefCell::new(Noise::new(2));
        let ramp = History::new(vec![[0.0, 0.0], [0.1, 1.0]]);
        let body = body.drained(top::<2>()).load_on_surface(top::<2>(), down(50e3), ramp);
        let mut solver = body.velocity(move |_| noise.borrow_mut().vector() * 0.01).build();
        run(&mut solver, 1e-3, 200).unwrap();
        cell_pressures(&solver)
    }
    let folder = tempfile::tempdir().unwrap();
    for law in laws(folder.path()) {
        let own = pressures(Body::<2>::layer(4.0, 1.0, 2));
        // The last bits of 200 steps.
        assert_all_close("pressure", &pressures(Body::<2>::layer(4.0, 1.0, 2).law(law)), &own, 1e-12 * 50e3);
    }
}

/// DROT by columns, and the routine's own direction turned by it.
#[test]
fn the_routine_is_told_how_the_material_turned() {
    let folder = tempfile::tempdir().unwrap();
    for mut law in laws(folder.path()) {
        law.initial_state = vec![0.0, 1.0, 0.0, 0.0];
        let turn = rotation(&Vector::<3>::new(0.0, 0.0, std::f64::consts::FRAC_PI_2 / 100.0));
        let mut state = law.initial_state(Sym3::ZERO);
        for _ in 0..100 {
            let turned = law.rotate_state(state, &turn);
            (_, state) = law.update(Sym3::ZERO, turned, Sym3::ZERO).unwrap();
        }
        let direction = &state.variables()[1..4];
        assert!(
            (direction[0]).abs() < 1e-9 && (direction[1] - 1.0).abs() < 1e-9 && direction[2] == 0.0,
            "{direction:?}"
        );
        let still = law.rotate_state(state, &Matrix3::identity());
        assert_eq!(law.update(Sym3::ZERO, still, Sym3::ZERO).unwrap().1.variables()[1..4], *direction);
    }
}

#[test]
fn what_is_wrong_with_a_library_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let missing = Umat::new("./no-such-library.so", Vec::new()).validate().unwrap_err();
    assert!(
        matches!(&missing, LawError::Setting { name: "library", message } if message.contains("cannot load it")),
        "{missing}"
    );
    for law in laws(folder.path()) {
        let library = law.library.clone();
        let mut unknown = Umat::new(&library, Vec::new());
        unknown.routine = "umat_of_another".into();
        assert!(unknown.validate().unwrap_err().to_string().contains("no routine `umat_of_another`"));
        let mut many = Umat::new(&library, Vec::new());
        many.state_variables = 1000;
        assert!(matches!(many.validate(), Err(LawError::Setting { name: "state_variables", .. })));
        let mut short = Umat::new(&library, vec![SOIL.young, SOIL.poisson]);
        short.material_name = "SHORT".into();
        let refused = short.update(Sym3::ZERO, short.initial_state(Sym3::ZERO), Sym3::ZERO).unwrap_err();
        assert!(refused.to_string().contains("PNEWDT"), "{refused}");
    }
}
