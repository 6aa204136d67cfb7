//! Every way to get a case file wrong that we could think of, and the message for it.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use serde::Deserialize;
use serde_json::json;

use crate::*;

/// The spine of architecture.md.
const COLUMN: &str = include_str!("case_tests/column.toml");

/// Law parameters as a crate outside would write them.
#[derive(Debug, PartialEq, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct LinearElastic {
    /// Young's modulus (Pa).
    young: f64,
    /// Poisson's ratio.
    poisson: f64,
}

fn source(text: &str) -> CaseSource {
    CaseSource::from_text("case.toml", text)
}

/// What the case crate does with a source, less the registry.
fn read(source: &CaseSource) -> Result<Case, CaseError> {
    let case = source.parse()?;
    let laws = case.materials.keys().map(|name| {
        let path = KeyPath::from("materials").key(name).key("parameters");
        source.parse_at::<LinearElastic>(&path).err()
    });
    CaseError::all(source.validate(&case).err().into_iter().chain(laws.flatten()))?;
    Ok(case)
}

fn edited(edits: &[(&str, &str)]) -> String {
    edits.iter().fold(COLUMN.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "the sample does not hold {from:?}");
        text.replacen(from, to, 1)
    })
}

fn gallery(messages: impl IntoIterator<Item = (String, String)>) -> String {
    messages.into_iter().map(|(name, message)| format!("## {name}\n{message}\n\n")).collect()
}

fn snapshot(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

type Edits<'a> = &'a [(&'a str, &'a str)];

const BAD_CASES: &[(&str, Edits)] = &[
    // Syntax.
    ("no quotes around a word", &[("\"linear\"", "linear")]),
    ("no value", &[("end = 2000.0", "end =")]),
    ("decimal comma", &[("density = 1500.0", "density = 1500,0")]),
    ("number without a digit before the point", &[("porosity = 0.4", "porosity = .4")]),
    ("unit behind a number", &[("end = 2000.0", "end = 2000 s")]),
    ("key twice", &[("end = 2000.0", "end = 2000.0\nend = 3000.0")]),
    ("table twice", &[("[fluid]", "[time]")]),
    ("single brackets twice", &[("[[loads]]", "[drainage]"), ("[[drainage]]", "[drainage]")]),
    ("array not closed", &[("cells = [1, 12]", "cells = [1, 12")]),
    ("string not closed", &[("face = \"x-min\"", "face = \"x-min")]),
    ("no equals sign", &[("dimension = 2", "dimension 2")]),
    ("True", &[("every = 10.0", "every = 10.0\nfigures = True")]),
    (
        "nested too deeply",
        &[(
            "parameters = {",
            "parameters = { a = [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
        )],
    ),
    // Keys.
    ("unknown key", &[("porosity = 0.4", "porosty = 0.4")]),
    ("unknown required key", &[("density = 1500.0", "densty = 1500.0")]),
    ("several unknown keys", &[("end = 2000.0", "end = 2000.0\nstop = 3\nsaftey = 0.5"), ("face =", "faec =")]),
    ("unknown key like nothing", &[("every = 10.0", "every = 10.0\ncolour = \"red\"")]),
    ("top-level key in a table", &[("dimension = 2\n", ""), ("end = 2000.0", "end = 2000.0\ndimension = 2")]),
    ("key in the wrong table", &[("density = 1500.0", "density = 1500.0\nparticles_per_cell = [2, 2]")]),
    ("missing key", &[("end = 2000.0", "")]),
    ("missing key at the top", &[("title = \"Saturated poroelastic column\"", "")]),
    ("missing table", &[("[output]\nevery = 10.0", "")]),
    ("missing key of an inline table", &[("max = [1.0, 10.0]", "")]),
    ("missing key of a law", &[("poisson = 0.45", "")]),
    ("unknown key of a law", &[("young =", "yuong =")]),
    ("parameters missing altogether", &[("parameters = { young = 4.35e6, poisson = 0.45 }", "")]),
    // Types.
    ("quoted number", &[("density = 1500.0", "density = \"1500.0\"")]),
    ("word for a number", &[("young = 4.35e6", "young = \"stiff\"")]),
    ("float for a count", &[("dimension = 2", "dimension = 2.0")]),
    ("negative count", &[("cells = [1, 12]", "cells = [1, -12]")]),
    ("number for a vector", &[("spacing = [1.0, 1.0]", "spacing = 1.0")]),
    ("table for a list", &[("[[bodies]]", "[bodies]")]),
    ("list for a table", &[("[time]", "[[time]]")]),
    ("bad step", &[("step = 5.0e-4", "step = \"fast\"")]),
    ("date for a step", &[("step = 5.0e-4", "step = 2026-11-22")]),
    ("number beyond 64 bits", &[("end = 2000.0", "end = 1e999")]),
    ("three numbers in a history point", &[("[1000.0, 1.0]]", "[1000.0, 1.0, 2.0]]")]),
    ("one number in a history point", &[("[1000.0, 1.0]]", "[1000.0]]")]),
    // Names.
    ("unknown face", &[("face = \"x-min\"", "face = \"left\"")]),
    ("nearly a face", &[("face = \"x-min\"", "face = \"xmin\"")]),
    ("unknown axis", &[("fix = [\"x\"]", "fix = [\"X\"]")]),
    ("unknown quadrature", &[("\"cell\"", "\"material_points\"")]),
    ("unknown shape", &[("{ box =", "{ boks =")]),
    ("shape without content", &[("{ box = { min = [0.0, 0.0], max = [1.0, 10.0] } }", "\"box\"")]),
    ("two shapes", &[("{ box =", "{ sphere = 1, box =")]),
    (
        "sphere of nothing",
        &[("box = { min = [0.0, 0.0], max = [1.0, 10.0] }", "sphere = { center = [0.0], radius = -1.0 }")],
    ),
    (
        "sphere outside the grid",
        &[("box = { min = [0.0, 0.0], max = [1.0, 10.0] }", "sphere = { center = [2.5, 5.0], radius = 1.5 }")],
    ),
    (
        "sphere outside its box, and a face of it",
        &[(
            "box = { min = [0.0, 0.0], max = [1.0, 10.0] }",
            "sphere = { center = [0.5, 5.0], radius = 0.5, within = { min = [0.0, 6.0], max = [1.0, 7.0] } }",
        )],
    ),
    (
        "sphere in one dimension",
        &[
            ("dimension = 2", "dimension = 1"),
            ("box = { min = [0.0, 0.0], max = [1.0, 10.0] }", "sphere = { center = [0.0], radius = 1.0 }"),
        ],
    ),
    ("traction all round", &[("surface = \"y-max\"", "surface = \"all\"")]),
    ("load of nothing", &[("traction = [0.0, -50.0e3]", "")]),
    ("load of two", &[("traction = [0.0, -50.0e3]", "traction = [0.0, -50.0e3]\npressure = inf")]),
    (
        "sides of a surface all round",
        &[(
            "[[drainage]]\non = { surface = \"y-max\", of = \"soil\" }",
            "[[drainage]]\non = { surface = \"all\", of = \"soil\" }\nsides = [\"y-max\"]",
        )],
    ),
    ("word with content", &[("applied_to = \"particles\"", "applied_to = { particles = 1 }")]),
    // Sense.
    ("dimension 4", &[("dimension = 2", "dimension = 4")]),
    ("three numbers in two dimensions", &[("origin = [0.0, 0.0]", "origin = [0.0, 0.0, 0.0]")]),
    ("one dimension, vectors of two", &[("dimension = 2", "dimension = 1")]),
    ("not a number", &[("origin = [0.0, 0.0]", "origin = [0.0, nan]"), ("poisson = 0.45", "poisson = -inf")]),
    ("no spacing", &[("spacing = [1.0, 1.0]", "spacing = [1.0, 0.0]")]),
    ("too many cells", &[("cells = [1, 12]", "cells = [9000000000000000000, 9000000000000000000]")]),
    ("no cells", &[("cells = [1, 12]", "cells = [0, 12]")]),
    ("coordinates too large", &[("origin = [0.0, 0.0]", "origin = [0.0, 1.0e15]")]),
    ("step longer than the run", &[("end = 2000.0", "end = 1.0e-4"), ("every = 10.0", "every = 1.0e-4")]),
    ("safety above 1", &[("end = 2000.0", "end = 2000.0\nsafety = 90.0")]),
    ("gamma and beta", &[("beta = 0.5, gamma = 1.0", "beta = 1.6, gamma = 0.5")]),
    ("share of FLIP above 1", &[("velocity_update = \"mpm1\"", "velocity_update = \"flip\"\nflip_share = 95.0")]),
    ("order zero of XPIC", &[("velocity_update = \"mpm1\"", "velocity_update = \"xpic\"\nxpic_order = 0")]),
    ("negative order of FMPM", &[("velocity_update = \"mpm1\"", "velocity_update = \"fmpm\"\nfmpm_order = -4")]),
    ("porosity in percent", &[("porosity = 0.4", "porosity = 40")]),
    ("porosity and conductivity missing", &[("porosity = 0.4", ""), ("conductivity = 5.52e-5", "")]),
    ("mixture lighter than its water", &[("density = 1500.0", "density = 300.0")]),
    ("negative conductivity", &[("conductivity = 5.52e-5", "conductivity = -5.52e-5")]),
    (
        "dry ground with drainage",
        &[("[fluid]", ""), ("density = 1000.0", ""), ("bulk_modulus = 2.2e9", ""), ("unit_weight = 9800.0", "")],
    ),
    ("unknown material", &[("material = \"soil\"", "material = \"sol\"")]),
    (
        "unknown body",
        &[(
            "[[drainage]]\non = { surface = \"y-max\", of = \"soil\" }",
            "[[drainage]]\non = { surface = \"y-max\", of = \"column\" }",
        )],
    ),
    ("box outside the grid", &[("max = [1.0, 10.0]", "max = [1.0, 13.0]")]),
    ("box upside down", &[("max = [1.0, 10.0]", "max = [1.0, -0.0]")]),
    (
        "two bodies of one name",
        &[(
            "[[supports]]",
            "[[bodies]]\nmaterial = \"soil\"\nshape.box = { min = [0, 0], max = [1, 1] }\nparticles_per_cell = [2, 0]\n\n[[supports]]",
        )],
    ),
    ("z in two dimensions", &[("face = \"x-min\"", "face = \"z-max\""), ("fix = [\"x\"]", "fix = [\"x\", \"z\"]")]),
    ("support of nothing", &[("face = \"x-min\"\n", "")]),
    ("support of two", &[("face = \"x-min\"", "face = \"x-min\"\nregion = { min = [20, 0], max = [30, 1] }")]),
    ("nothing fixed", &[("fix = [\"x\"]", "fix = []")]),
    ("neither fixed nor together", &[("fix = [\"x\"]", "")]),
    ("together what is fixed", &[("fix = [\"x\"]", "fix = [\"x\"]\ntogether = [\"y\", \"x\"]")]),
    ("together along z in two dimensions", &[("fix = [\"x\"]", "together = [\"z\"]")]),
    ("history goes back", &[("[1000.0, 1.0]]", "[0.0, 1.0], [-1.0, 1.0]]")]),
    ("word for a history", &[("[[0.0, 0.0], [1000.0, 1.0]]", "\"ramp\"")]),
    ("unknown course", &[("[[0.0, 0.0], [1000.0, 1.0]]", "{ cosine = { angular_frequency = 1.0 } }")]),
    ("no course", &[("[[0.0, 0.0], [1000.0, 1.0]]", "{}")]),
    (
        "two courses",
        &[("[[0.0, 0.0], [1000.0, 1.0]]", "{ smooth-step = { duration = 1 }, sine = { angular_frequency = 1 } }")],
    ),
    ("smooth step at once", &[("[[0.0, 0.0], [1000.0, 1.0]]", "{ smooth-step = { duration = 0.0 } }")]),
    (
        "sine that starts before it starts",
        &[("[[0.0, 0.0], [1000.0, 1.0]]", "{ sine = { angular_frequency = -1, start = -1.0 } }")],
    ),
    ("sine without a frequency", &[("[[0.0, 0.0], [1000.0, 1.0]]", "{ sine = { frequency = 1.0 } }")]),
    ("no sides", &[("[[probes]]", "sides = []\n[[probes]]")]),
    ("probe name with a dot", &[("name = \"base\"", "name = \"base no. 1\"")]),
    (
        "probe outside, probe of nothing, same name",
        &[("pressure_at = [0.5, 0.5]", "pressure_at = [0.5, -0.5]\n[[probes]]\nname = \"base\"")],
    ),
    ("fields every zero seconds", &[("every = 10.0", "every = 1.0e4\nfields_every = 0")]),
    (
        "geostatic without gravity",
        &[("[[supports]]", "initial = { geostatic = { surface = 10.0, k0 = -0.5 } }\n[[supports]]")],
    ),
    (
        "no materials, no bodies",
        &[(
            "[[bodies]]\nmaterial",
            "[[supports]]\nregion = { min = [0, 0], max = [1, 0] }\nfix = [\"y\"]\n[other]\nmaterial",
        )],
    ),
    // Finite elements.
    (
        "finite elements unstable and between grid lines",
        &[("beta = 0.5, gamma = 1.0 }", "beta = 0.25, gamma = 0.6 }\nsolver = \"fem\"")],
    ),
    // Text.
    ("escape sequences in a name", &[("porosity", "\"po\\u001b[31mrosity\"")]),
    (
        "other scripts",
        &[("porosity = 0.4", "\"間隙率\" = 0.4 # 日本語"), ("conductivity = 5.52e-5", "conductivity = \"é😀\"")],
    ),
    ("tabs", &[("porosity = 0.4", "\tporosty\t=\t0.4\t# tabs")]),
];

#[test]
fn the_sample_of_the_architecture_is_read() {
    let case = read(&source(COLUMN)).unwrap_or_else(|error| panic!("{}", error.render(false)));
    assert_eq!(case.dimension, 2);
    assert_eq!(case.time.step, Step::Seconds(5.0e-4));
    assert_eq!(case.method, Method::default());
    assert_eq!(case.loads[0].history, History::Points(vec![[0.0, 0.0], [1000.0, 1.0]]));
    assert_eq!(case.bodies[0].name(), "soil");
    assert_eq!(case.materials["soil"].parameters["poisson"].as_float(), Some(0.45));
    assert_eq!(case.supports[0].fix, [Axis::X]);
}

#[test]
fn a_case_survives_being_written() {
    let case = source(COLUMN).parse().unwrap();
    let text = toml::to_string(&case).unwrap();
    assert_eq!(source(&text).parse().unwrap(), case, "{text}");
}

#[test]
fn courses_of_loads_survive_being_written() {
    for course in ["{ smooth-step = { duration = 0.1 } }", "{ sine = { angular_frequency = 10, start = 0.5 } }"] {
        let case = read(&source(&edited(&[("[[0.0, 0.0], [1000.0, 1.0]]", course)]))).unwrap();
        let text = toml::to_string(&case).unwrap();
        assert_eq!(source(&text).parse().unwrap(), case, "{text}");
    }
}

#[test]
fn line_ends_and_marks_of_windows_are_read() {
    let text = format!("\u{feff}{}", COLUMN.replace('\n', "\r\n"));
    read(&source(&text)).unwrap();
    let error = read(&source(&text.replace("2000.0", "-1"))).unwrap_err();
    let location = &error.problems()[0].location;
    assert_eq!(location.line_and_column(), Some((10, 7)));
    let first = read(&source("\u{feff}titel = 1\r\n")).unwrap_err();
    assert_eq!(first.problems()[0].location.line_and_column(), Some((1, 1)));
    assert!(first.render(false).contains("1 | titel = 1\n"), "{}", first.render(false));
}

#[test]
fn bad_cases_are_explained() {
    let messages = BAD_CASES.iter().map(|(name, edits)| {
        let error = read(&source(&edited(edits))).expect_err(name);
        ((*name).to_owned(), error.render(false))
    });
    snapshot("bad_cases", &gallery(messages));
}

#[test]
fn every_problem_is_where_its_key_is() {
    let text = edited(&[("max = [1.0, 10.0]", "max = [1.0, 13.0]")]);
    let error = read(&source(&text)).unwrap_err();
    let [problem] = error.problems() else { panic!("{error}") };
    assert_eq!(problem.key, KeyPath::from("bodies[0].shape.box.max[1]"));
    assert_eq!(problem.location.text.get(problem.location.span.clone().unwrap()), Some("13.0"));
}

#[test]
fn long_lines_are_cut() {
    let long = "x".repeat(3_000_000);
    let cases = [
        ("long value", format!("dimension = \"{long}\"")),
        (
            "long line before and behind",
            format!("a = {{ {} porosty = \"é\", {} }}", "b = 1, ".repeat(9000).replace("b", "q"), ""),
        ),
        ("long key", format!("{long} = 1")),
        ("long array", format!("dimension = [{}nan]", "1, ".repeat(9000))),
        ("far to the right", format!("title = \"{}\" porosty", "é".repeat(9000))),
        ("nothing but zeros", "\0".repeat(100_000)),
    ];
    let messages = cases.map(|(name, text)| {
        let message = read(&source(&text)).unwrap_err().render(false);
        assert!(message.lines().all(|line| line.chars().count() < 300), "{name}");
        (name.to_owned(), message)
    });
    snapshot("long_lines", &gallery(messages));
}

#[test]
fn many_problems_are_counted() {
    let many = "face = \"x-min\"\nfix = [\"z\"]\n[[supports]]\n".repeat(2000) + "face = \"x-min\"";
    let error = read(&source(&edited(&[("face = \"x-min\"", &many)]))).unwrap_err();
    let message = error.render(false);
    assert!(message.ends_with("1000 problems in `case.toml`, of which 980 are not shown"), "{message}");
}

#[test]
fn overrides_reach_everything() {
    let overrides = [
        "time.step=auto",
        "materials.soil.parameters.young=1e7",
        "loads.0.applied_to=surface",
        "loads[0].traction.1=-1.0e3",
        "bodies.0.shape.box.max=[1.0, 8.0]",
        "gravity=[0, -9.81]",
        "bodies.0.initial.geostatic={ surface = 8.0, k0 = 0.5 }",
        "method.newmark.beta=0.25",
        "fluid={ density = 1025.0, bulk_modulus = 2.2e9, unit_weight = 10000 }",
        "title=\"a = b\"",
        "probes.0={ name = \"top\", displacement_at = [0.5, 7.0] }",
        "probes.0.pressure_at=[0.5, 0.5]",
        " output.figures = false ",
        "drainage=[]",
    ];
    let source = overrides.iter().fold(source(COLUMN), |source, text| match source.with_override(text) {
        Ok(source) => source,
        Err(error) => panic!("{}", error.render(false)),
    });
    let case = read(&source).unwrap_or_else(|error| panic!("{}\n{}", source.text(), error.render(false)));
    assert_eq!(case.time.step, Step::Auto);
    assert_eq!(case.loads[0].traction.as_deref(), Some(&[0.0, -1.0e3][..]));
    assert_eq!(case.probes[0].name, "top");
    assert_eq!(case.title, "a = b");
    assert!(source.text().contains("# or \"auto\", with `safety`"), "comments are kept");
    assert_eq!(source.original_text(), COLUMN);
    assert_eq!(source.overrides().collect::<Vec<_>>(), overrides);
    snapshot("effective_text", source.text());
}

#[test]
fn damping_is_off_unless_asked_for() {
    assert_eq!(read(&source(COLUMN)).unwrap().method.damping, Damping::default());
    assert_eq!(Damping::default(), Damping { local: 0.0, mass: 0.0, stiffness: 0.0 });
    let damped = source(COLUMN).with_override("method.damping.local=0.7").unwrap();
    assert_eq!(read(&damped).unwrap().method.damping, Damping { local: 0.7, ..Damping::default() });
}

#[test]
fn bad_overrides_are_explained() {
    let cases: &[&[&str]] = &[
        &["time.step"],
        &["=3"],
        &["time..step=3"],
        &["time.step="],
        &["time.step=1,5"],
        &["time.step=.5"],
        &["loads.0.traction=[1, 2"],
        &["title=Saturated column"],
        &["loads.1.applied_to=surface"],
        &["loads.applied_to=surface"],
        &["gravity.0=1"],
        &["title.x=1"],
        &["bodies.0=3"],
        &["materials.soil.porosty=0.3"],
        &["materials.soil.porosity=1.3"],
        &["time.step=fast"],
        &["time.step=-1", "time.end=100"],
        &["materials.clay={ law = \"linear-elastic\", densty = 3, porosity = 2.0 }"],
        &["materials.clay.density=3"],
        &["loads.0.on.of=clay"],
        &["dimension=3"],
        &["grid={ origin = [0, 0], spacing = [1, 1] }"],
        &["materials.soil.parameters.young=\"stiff\""],
        &["method.pressure_stabilisation=-1"],
        &["method.solver=fem", "method.pressure_stabilisation=30"],
        &["method.damping.local=1"],
        &["method.damping={ local = -0.1, mass = -2.0, stiffness = -1e-3 }"],
        &["method.solver=fem", "method.damping.local=0.7"],
        &["method.damping.lokal=0.7"],
        &["method.volumetric_strain=averaged"],
        &["method.solver=fem", "method.volumetric_strain=cell-averaged"],
    ];
    let messages = cases.iter().map(|overrides| {
        let start = Ok(source(COLUMN));
        let overridden = overrides.iter().try_fold(source(COLUMN), |source, text| source.with_override(text));
        let error = start.and(overridden).and_then(|source| read(&source).map(|_| ())).expect_err(overrides[0]);
        (overrides.join("  "), error.render(false))
    });
    snapshot("bad_overrides", &gallery(messages));
}

#[test]
fn line_numbers_are_those_of_the_file_whatever_was_overridden() {
    let text = edited(&[("pressure_at = [0.5, 0.5]", "pressure_at = [0.5, 99.0]")]);
    let plain = read(&source(&text)).unwrap_err();
    let overridden = source(&text).with_override("gravity=[0.0, -9.81]").unwrap();
    let shifted = read(&overridden).unwrap_err();
    assert_eq!(plain.problems(), shifted.problems());
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let folder = std::env::temp_dir().join(format!("tsutsumi-case-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let huge = folder.join("huge.toml");
    fs::File::create(&huge).unwrap().set_len(1 << 30).unwrap();
    let paths = [
        folder.join("none.toml"),
        folder.clone(),
        Path::new("/dev/zero").to_owned(),
        huge,
        write("latin.toml", b"title = \"a\"\ndimension = 2 # d\xe9"),
        write("utf16.toml", b"\xff\xfet\0i\0"),
        write("empty.toml", b" \n"),
        write("mark.toml", "\u{feff}".as_bytes()),
    ];
    let messages = paths.map(|path| {
        let message = CaseSource::read(&path).unwrap_err().render(false);
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name.replace(&std::process::id().to_string(), "N"), message.replace(&*folder.to_string_lossy(), "FOLDER"))
    });
    snapshot("refused_files", &gallery(messages));
    assert!(CaseSource::read(write("good.toml", COLUMN.as_bytes())).unwrap().parse().is_ok());
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn colour_changes_nothing_but_colour() {
    let error = read(&source(&edited(&[("porosity", "porosty")]))).unwrap_err();
    let colored = error.render(true);
    assert!(colored.contains('\u{1b}'));
    assert!(!error.render(false).contains('\u{1b}'));
}

#[test]
fn errors_are_one_line_as_text() {
    let error = read(&source(&edited(&[("porosity", "porosty"), ("end", "edn")]))).unwrap_err();
    assert_eq!(error.to_string(), "unknown key `edn` in `time` (case.toml:10:1) (and 1 more)");
}

#[test]
fn near_names_are_found() {
    let known = ["young", "poisson", "friction_angle_deg"];
    assert_eq!(did_you_mean("yuong", known), Some("young"));
    assert_eq!(did_you_mean("young_modulus", known), Some("young"));
    assert_eq!(did_you_mean("Friction-Angle", known), Some("friction_angle_deg"));
    assert_eq!(did_you_mean("colour", known), None);
    assert_eq!(did_you_mean("", known), None);
}

fn full_schema() -> serde_json::Value {
    let law = schemars::schema_for!(LinearElastic).to_value();
    let words = [
        ("Method", "shape", vec!["linear", "gimp"]),
        ("Method", "velocity_update", vec!["mpm1", "mpm2"]),
        ("Material", "conductivity_law", vec!["constant", "xie-leo"]),
    ];
    case_schema(&[("linear-elastic", law)], &[], &words)
}

#[test]
fn the_schema_accepts_good_cases_and_refuses_bad_ones() {
    let schema = full_schema();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let as_json = |text: &str| serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    let sample = as_json(COLUMN);
    let complaints: Vec<_> = validator.iter_errors(&sample).map(|error| error.to_string()).collect();
    assert_eq!(complaints, Vec::<String>::new());
    assert!(validator.is_valid(&as_json(&edited(&[("5.0e-4", "\"auto\"")]))));
    let bad = [
        ("5.0e-4", "\"fast\""),
        ("dimension = 2", "dimension = 4"),
        ("porosity", "porosty"),
        ("\"linear-elastic\"", "\"linear-plastic\""),
        ("young =", "yuong ="),
        ("parameters = { young = 4.35e6, poisson = 0.45 }", ""),
        ("\"linear\"", "\"cubic\""),
        ("\"mpm1\"", "\"mpm7\""),
        ("gamma = 1.0", "gamma = 0.4"),
        ("porosity = 0.4", "porosity = 0.4\nconductivity_law = \"cubic\""),
        ("face = \"x-min\"", ""),
        ("pressure_at = [0.5, 0.5]", ""),
        ("name = \"base\"", "name = \"a.b\""),
        ("{ box =", "{ boks ="),
        ("spacing = [1.0, 1.0]", "spacing = [1.0, 0.0]"),
    ];
    for edit in bad {
        assert!(!validator.is_valid(&as_json(&edited(&[edit]))), "{edit:?}");
    }
}

const BAR: &str = include_str!("study/tests/bar.toml");

/// What is wrong with an exact motion is told where it stands.
#[test]
fn exact_motions_that_make_no_sense_are_refused() {
    let complaint = |edit: (&str, &str)| {
        assert!(BAR.contains(edit.0), "{edit:?}");
        let source = CaseSource::from_text("bar.toml", BAR.replace(edit.0, edit.1));
        let case = crate::read_case(&source).map_err(|error| error.render(false));
        let built = case.and_then(|case| {
            crate::build::build::<1>(&source, &case, &Registry::built_in()).map_err(|error| error.render(false))
        });
        built.err().unwrap_or_else(|| panic!("{edit:?} was accepted"))
    };
    for (edit, expected) in [
        (("solution = \"vibrating-bar\"", "solution = \"vibrating-bars\""), "unknown exact motion `vibrating-bars`"),
        (("mode = 1", "mode = 0"), "`exact_motion.parameters.bar` must have positive numbers"),
        (("mode = 1", "modes = 1"), "unknown key `modes`"),
        (("ends = \"fixed-fixed\" }", "ends = \"fixed-fixed\" }, carried = 1.0"), "must be 0 for a bar that is held"),
        (("ends = \"fixed-fixed\" }", "ends = \"fixed-fixed\" }, along = \"y\""), "must be an axis of the 1 dimension"),
        (("[2]", "[2]\ninitial = { velocity = [1.0] }"), "the velocity at the start is that of `exact_motion`"),
        (("[materials.bar]", "[method]\nsolver = \"fem\"\n[materials.bar]"), "finite elements have no exact motion"),
    ] {
        let told = complaint(edit);
        assert!(told.contains(expected), "{told}");
    }
}

/// Saturated ground one cell wide may shake along that cell, and nothing else may.
#[test]
fn ground_motions_that_make_no_sense_are_refused() {
    let told = |motion: &str| {
        let text = edited(&[("[output]", &format!("[ground_motion]\n{motion}\n[output]"))]);
        read(&source(&text)).err().map(|error| error.render(false))
    };
    assert_eq!(told("acceleration = [1.5, 0.0]\nend = 5.0"), None);
    for (motion, expected) in [
        ("acceleration = [1.5, 0.1]", "must be along an axis with one cell"),
        ("acceleration = [1.5]", "`ground_motion.acceleration`"),
        ("acceleration = [1.5, 0.0]\nend = 0.0", "`ground_motion.end`"),
        ("acceleration = [1.5, 0.0]\nhistory = []", "`ground_motion.history` is empty"),
    ] {
        let told = told(motion).unwrap_or_else(|| panic!("{motion} was accepted"));
        assert!(told.contains(expected), "{told}");
    }
}

/// Only the parameters of the motion that is named are accepted.
#[test]
fn the_schema_knows_the_exact_motions() {
    let validator = jsonschema::validator_for(&Registry::built_in().schema()).unwrap();
    let is_valid =
        |text: &str| validator.is_valid(&serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap());
    assert!(is_valid(BAR));
    assert!(!is_valid(&BAR.replace("vibrating-bar", "vortex")));
    assert!(!is_valid(&BAR.replace("mode = 1", "modes = 1")));
}

#[test]
fn definitions_of_laws_do_not_meet() {
    let law = json!({ "properties": { "a": { "$ref": "#/$defs/Grid" } }, "$defs": { "Grid": { "type": "string" } } });
    let schema = case_schema(&[("my law", law)], &[], &[]);
    assert_eq!(schema["$defs"]["law:my-law:Grid"]["type"], "string");
    assert_eq!(schema["$defs"]["Grid"]["type"], "object");
    assert_eq!(
        schema["$defs"]["Material"]["allOf"][0]["then"]["properties"]["parameters"]["properties"]["a"]["$ref"],
        "#/$defs/law:my-law:Grid"
    );
}

#[test]
fn every_key_is_documented() {
    let page: String = key_documentation()
        .iter()
        .map(|key| {
            assert!(!key.description.is_empty(), "{}.{}", key.table, key.name);
            let needed = if key.is_required { "required" } else { "optional" };
            let default = key.default.as_ref().map(|default| format!(", default {default}")).unwrap_or_default();
            let words: Vec<_> = key.words.iter().map(|(word, meaning)| format!("  {word}: {meaning}\n")).collect();
            let (kind, words) = (&key.kind, words.concat());
            format!("{} | {} ({kind}, {needed}{default}): {}\n{words}", key.table, key.name, key.description)
        })
        .collect();
    snapshot("key_documentation", &page);
}

#[test]
fn large_files_are_read_or_refused_soon() {
    let texts = [
        "x = 1\n".repeat(150_000),
        (0..75_000).map(|index| format!("k{index} = 1\n")).collect(),
        "[[bodies]]\n".repeat(90_000),
        format!("dimension = [{}]", "nan,".repeat(225_000)),
        format!("{}dimension = 1", "a.".repeat(475_000)),
        "[".repeat(1_000_000),
        edited(&[("history = [[0.0, 0.0],", &format!("history = [[0.0, 0.0], {}", "[nan, 1.0],".repeat(75_000)))]),
        edited(&[("[[supports]]", &format!("[materials.\"{}\"]\n[[supports]]", "é".repeat(1_500_000)))]),
    ];
    for text in texts {
        let start = std::time::Instant::now();
        survives(&text);
        assert!(start.elapsed().as_secs() < 60, "{} took {:?}", &text[..40], start.elapsed());
    }
}

/// Reads, validates and renders; the outcome does not matter as long as there is one.
fn survives(text: &str) {
    if let Err(error) = read(&source(text)) {
        assert!(error.render(false).starts_with("error: "));
        error.render(true);
        assert!(!error.to_string().is_empty());
    }
}

fn token() -> impl Strategy<Value = String> {
    let words = [
        "nan",
        "-inf",
        "inf",
        "1e999",
        "-0.0",
        "0",
        "-1",
        "9223372036854775807",
        "99999999999999999999",
        "0x7f",
        "1e-320",
        "true",
        "\"\"",
        "''",
        "\"\"\"",
        "[",
        "]",
        "{",
        "}",
        "[[",
        "]]",
        "=",
        ",",
        ".",
        "\n",
        "\r",
        "\t",
        "\0",
        "\u{feff}",
        "\u{1b}[31m",
        "\u{202e}",
        "é",
        "日本語",
        "👩‍👩‍👧",
        "e\u{301}",
        "#",
        "\"auto\"",
        "1979-05-27",
        "[]",
        "{}",
        "[[0]]",
        "\"box\"",
        "{ box = 1 }",
        "\"z-max\"",
        "[[bodies]]",
        "[grid]",
        "[materials.\"a.b\"]",
        "dimension = 3",
        "dimension = 1",
    ];
    prop_oneof![4 => prop::sample::select(words.to_vec()).prop_map(str::to_owned), 1 => any::<f64>().prop_map(|number| format!("{number:?}")), 1 => "\\PC{0,8}"]
}

/// Replaces, deletes, repeats and swaps pieces of a text, cut between words and signs.
fn mutated(text: &str, mutations: &[(usize, usize, u8, String)]) -> String {
    let mut pieces: Vec<String> = Vec::new();
    for character in text.chars() {
        let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '"');
        match pieces.last_mut() {
            Some(last) if is_word(character) && last.ends_with(is_word) => last.push(character),
            _ => pieces.push(character.to_string()),
        }
    }
    for (first, second, kind, token) in mutations {
        let (first, second) = (first % pieces.len(), second % pieces.len());
        match kind % 5 {
            0 => pieces[first].clone_from(token),
            1 => pieces[first].clear(),
            2 => pieces.swap(first, second),
            3 => pieces[first] = pieces[second].clone(),
            _ => pieces[first].push_str(token),
        }
    }
    pieces.concat()
}

fn mutations() -> impl Strategy<Value = Vec<(usize, usize, u8, String)>> {
    prop::collection::vec((any::<usize>(), any::<usize>(), any::<u8>(), token()), 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_mutation_of_a_case_panics(mutations in mutations()) {
        survives(&mutated(COLUMN, &mutations));
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,200}", bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        survives(&text);
        survives(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_override_panics(
        key in prop_oneof![
            prop::sample::select(vec!["time.step", "loads.0", "loads[0].on", "bodies.0.shape.box", "grid", "materials.soil.parameters", "fluid"]).prop_map(str::to_owned),
            "[a-z.\\[\\]0-9\"']{0,12}", "\\PC{0,8}",
        ],
        value in prop_oneof![token(), "\\PC{0,20}"],
        second in token(),
    ) {
        let mut case = source(COLUMN);
        for text in [format!("{key}={value}"), format!("{key}.x={second}"), format!("time.end={second}")] {
            case = match case.clone().with_override(&text) {
                Ok(case) => case,
                Err(error) => {
                    assert!(error.render(false).contains("error: "));
                    case
                }
            };
        }
        survives(case.text());
        if let Err(error) = read(&case) {
            error.render(false);
        }
    }
}
