//! The names of the variants: the one place where a word in a case file becomes a type.
//!
//! A new shape function, velocity update or stress order is one line here. A law from elsewhere is added with [`Registry::law`].

use std::collections::BTreeMap;
use std::ops::Range;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tsutsumi::law::{
    Bingham, ConductivityLaw, ConstantConductivity, ConstitutiveLaw, DruckerPrager, Group, Hencky, KozenyCarman,
    LawError, LinearElastic, MaterialGroup, ModifiedCamClay, MohrCoulomb, MuI, NeoHookean, Newtonian, OkaCyclic,
    Pm4Sand, PressureElastic, Sanisand, VonMises, XieLeo,
};
use tsutsumi::particles::Stresses;
use tsutsumi::pressure::{CellPressure, ParticlePressure, PressureGradient, PressureIncrement};
use tsutsumi::shape::{CpGimp, CubicBSpline, Gimp, Linear, QuadraticBSpline};
use tsutsumi::solver::{StressFirst, StressLast, StressModifiedLast, StressOrder};
use tsutsumi::transfer::Transfer;
use tsutsumi::velocity::{Apic, Flip, Fmpm, Mpm1, Mpm2, Tpic, VelocityUpdate, Xpic};

use crate::json_schema::{element_test_schema, one_line};
use crate::motions::motion_schemas;
use crate::schema::Method;
use crate::{CaseError, CaseSource, KeyPath, case_schema, did_you_mean};

/// The shape functions by name.
pub fn shapes<const D: usize>() -> Vec<(&'static str, Box<dyn Transfer<D>>)> {
    vec![
        ("linear", Box::new(Linear)),
        ("gimp", Box::new(Gimp)),
        ("cpgimp", Box::new(CpGimp)),
        ("bspline2", Box::new(QuadraticBSpline)),
        ("bspline3", Box::new(CubicBSpline)),
    ]
}

/// The velocity updates by name, with the parameters that a case gives them.
pub fn velocity_updates<const D: usize>(method: &Method) -> Vec<(&'static str, Box<dyn VelocityUpdate<D>>)> {
    vec![
        ("mpm1", Box::new(Mpm1)),
        ("mpm2", Box::new(Mpm2)),
        ("flip", Box::new(Flip { share: method.flip_share })),
        ("apic", Box::new(Apic)),
        ("tpic", Box::new(Tpic)),
        ("xpic", Box::new(Xpic::new(method.xpic_order))),
        ("fmpm", Box::new(Fmpm::new(method.fmpm_order))),
    ]
}

/// The orders of the stress update by name.
pub fn stress_orders() -> Vec<(&'static str, Box<dyn StressOrder>)> {
    vec![
        ("last", Box::new(StressLast)),
        ("first", Box::new(StressFirst)),
        ("modified-last", Box::new(StressModifiedLast)),
    ]
}

/// The ways of the cells' pressures back to the particles by name.
pub fn particle_pressures<const D: usize>() -> Vec<(&'static str, Box<dyn ParticlePressure<D>>)> {
    vec![
        ("cell", Box::new(CellPressure)),
        ("increment", Box::new(PressureIncrement)),
        ("gradient", Box::new(PressureGradient::default())),
    ]
}

/// The laws of the conductivity by name.
pub fn conductivity_laws() -> Vec<(&'static str, Box<dyn ConductivityLaw>)> {
    vec![
        ("constant", Box::new(ConstantConductivity)),
        ("xie-leo", Box::new(XieLeo)),
        ("kozeny-carman", Box::new(KozenyCarman)),
    ]
}

/// The constitutive laws by name.
pub struct Registry {
    laws: BTreeMap<String, Law>,
}

/// A law that a case file can name.
struct Law {
    schema: Value,
    make: Box<MakeGroup>,
}

type MakeGroup = dyn Fn(&MaterialRequest) -> Result<Box<dyn MaterialGroup>, CaseError> + Send + Sync;

/// What a law needs from a case to become the group of a body.
pub(crate) struct MaterialRequest<'a> {
    pub(crate) source: &'a CaseSource,
    /// Where the material stands in the file, and its name.
    pub(crate) place: KeyPath,
    pub(crate) name: &'a str,
    pub(crate) conductivity_law: &'a str,
    pub(crate) particles: Range<usize>,
    /// Those of all particles of the case.
    pub(crate) stresses: &'a Stresses,
    /// Where a history stands that the particles begin with; without it they begin with that of their stress.
    pub(crate) history: Option<KeyPath>,
}

impl Registry {
    /// The laws of the library.
    pub fn built_in() -> Self {
        Registry { laws: BTreeMap::new() }
            .law::<LinearElastic>("linear-elastic")
            .law::<NeoHookean>("neo-hookean")
            .law::<Hencky>("hencky")
            .law::<PressureElastic>("pressure-elastic")
            .law::<VonMises>("von-mises")
            .law::<DruckerPrager>("drucker-prager")
            .law::<MohrCoulomb>("mohr-coulomb")
            .law::<ModifiedCamClay>("modified-cam-clay")
            .law::<OkaCyclic>("oka-cyclic")
            .law::<MuI>("mu-i")
            .law::<Newtonian>("newtonian")
            .law::<Bingham>("bingham")
            .law::<Pm4Sand>("pm4sand")
            .law::<Sanisand>("sanisand")
    }

    /// Adds a law under a name. Its parameters are read from the case file by its own `Deserialize`, and described in
    /// the JSON schema by its own `JsonSchema`; what [`ConstitutiveLaw::validate`] refuses is shown where it stands in
    /// the file.
    #[must_use]
    pub fn law<L: ConstitutiveLaw + DeserializeOwned + JsonSchema>(mut self, name: &str) -> Self {
        let schema = schemars::schema_for!(L).to_value();
        let make = Box::new(make_group::<L>);
        self.laws.insert(name.to_owned(), Law { schema, make });
        self
    }

    /// The names of the laws, with the first line of each description.
    pub fn laws(&self) -> impl Iterator<Item = LawSummary<'_>> {
        self.laws.iter().map(|(name, law)| LawSummary { name, schema: &law.schema })
    }

    /// The JSON Schema of case files, with the parameters of every law.
    pub fn schema(&self) -> Value {
        let laws = self.law_schemas();
        let method = Method::default();
        let words = [
            ("Material", "conductivity_law", names(&conductivity_laws())),
            ("Method", "shape", names(&shapes::<1>())),
            ("Method", "velocity_update", names(&velocity_updates::<1>(&method))),
            ("Method", "stress_order", names(&stress_orders())),
            ("Method", "particle_pressure", names(&particle_pressures::<1>())),
        ];
        case_schema(&laws, &motion_schemas(), &words)
    }

    /// The JSON Schema of element tests, with the parameters of every law.
    pub fn element_test_schema(&self) -> Value {
        element_test_schema(&self.law_schemas())
    }

    fn law_schemas(&self) -> Vec<(&str, Value)> {
        self.laws.iter().map(|(name, law)| (name.as_str(), law.schema.clone())).collect()
    }

    /// The group of a body's particles, with the law that its material names.
    pub(crate) fn group(&self, law: &str, request: &MaterialRequest) -> Result<Box<dyn MaterialGroup>, CaseError> {
        let Some(found) = self.laws.get(law) else {
            let key = request.place.clone().key("law");
            let names = self.laws.keys().map(String::as_str);
            return Err(unknown_name(request.source, key, "law", law, names));
        };
        (found.make)(request)
    }
}

/// A law as `tsutsumi laws` shows it.
pub struct LawSummary<'a> {
    /// Its name in case files.
    pub name: &'a str,
    /// The JSON Schema of its parameters.
    pub schema: &'a Value,
}

impl LawSummary<'_> {
    /// What the law is, in one line: the first paragraph of its documentation.
    pub fn description(&self) -> String {
        one_line(self.schema["description"].as_str().and_then(|text| text.split("\n\n").next()))
    }

    /// The parameters and what each means, in one line.
    pub fn parameters(&self) -> impl Iterator<Item = (&str, String)> {
        let properties = self.schema.get("properties").and_then(Value::as_object);
        properties.into_iter().flatten().map(|(name, schema)| (name.as_str(), one_line(schema["description"].as_str())))
    }
}

fn make_group<L: ConstitutiveLaw + DeserializeOwned>(
    request: &MaterialRequest,
) -> Result<Box<dyn MaterialGroup>, CaseError> {
    let parameters = request.place.clone().key("parameters");
    let law: L = request.source.parse_at(&parameters)?;
    law.validate().map_err(|error| match error {
        LawError::Parameter { name, value, expected } => {
            let key = parameters.key(name);
            let message = format!("`{key}` must be {expected}, not {value}");
            request.source.invalid(key, message, "")
        }
        LawError::Setting { name, message } => {
            let key = parameters.key(name);
            let message = format!("`{key}`: {message}");
            request.source.invalid(key, message, "")
        }
        other => request.source.invalid(parameters, other.to_string(), ""),
    })?;
    let key = request.place.clone().key("conductivity_law");
    let (name, known) = (request.conductivity_law, conductivity_laws());
    let conductivity_law = choose(request.source, key, "law of the conductivity", name, known)?;
    let stresses = request.stresses.within(request.particles.clone());
    let group = Group::new(request.name, law, request.particles.clone(), stresses);
    let group = match &request.history {
        Some(place) => group.with_history(request.source.parse_at(place)?),
        None => group,
    };
    Ok(Box::new(group.with_conductivity_law(conductivity_law)))
}

fn names<T>(variants: &[(&'static str, T)]) -> Vec<&'static str> {
    variants.iter().map(|(name, _)| *name).collect()
}

/// Takes a variant out of a list by its name.
pub(crate) fn choose<T>(
    source: &CaseSource,
    key: KeyPath,
    what: &str,
    name: &str,
    variants: Vec<(&'static str, T)>,
) -> Result<T, CaseError> {
    let names: Vec<&str> = variants.iter().map(|(name, _)| *name).collect();
    match variants.into_iter().find(|(known, _)| *known == name) {
        Some((_, variant)) => Ok(variant),
        None => Err(unknown_name(source, key, what, name, names.into_iter())),
    }
}

fn unknown_name<'a>(
    source: &CaseSource,
    key: KeyPath,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> CaseError {
    let list = known.clone().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let help = match did_you_mean(name, known.clone()) {
        Some(near) if known.count() == 1 => format!("did you mean `{near}`?"),
        Some(near) => format!("did you mean `{near}`? known: {list}"),
        None => format!("known: {list}"),
    };
    source.invalid(key, format!("unknown {what} `{name}`"), help)
}
