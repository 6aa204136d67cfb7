//! Parameters are read from study files: every field explains itself, and a misspelt one is an error.

use schemars::{JsonSchema, schema_for};
use serde::de::DeserializeOwned;
use serde_json::{Value, from_value, json};
use tsutsumi_reference::bearing::StripFooting;
use tsutsumi_reference::column_collapse::ScalingLaw;
use tsutsumi_reference::consolidation::{Consolidation, Drainage, Layer, Ramp};
use tsutsumi_reference::dam_break::DamBreak;
use tsutsumi_reference::elastic_column::{BarEnds, ElasticColumn, VibratingBar};
use tsutsumi_reference::large_strain::{Before, LargeStrainLayer};
use tsutsumi_reference::seepage::RectangularDam;
use tsutsumi_reference::self_weight::{EndState, SelfWeight};
use tsutsumi_reference::sliding_block::{InfiniteSlope, SlidingBlock};
use tsutsumi_reference::telegraph::{Formulation, HalfSpace};

/// Every property has a description with its unit in round brackets, unless it is a choice or another struct, and a
/// field too many is refused by its name.
fn check<T: DeserializeOwned + JsonSchema>() {
    let name = T::schema_name();
    let schema = schema_for!(T).to_value();
    assert_eq!(schema["additionalProperties"], json!(false), "{name}");
    assert!(schema["properties"].is_object(), "{name} has no fields");
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let description = property["description"].as_str().unwrap_or_default();
        assert!(!description.is_empty(), "{name}.{key} explains nothing");
        let is_number = property["type"] == json!("number");
        assert!(!is_number || description.contains('('), "{name}.{key} has no unit: {description}");
    }
    let refused = from_value::<T>(json!({ "no such field": 1.0 })).err().map(|error| error.to_string());
    assert!(refused.is_some_and(|message| message.contains("no such field")), "{name} takes any field");
}

#[test]
fn every_field_explains_itself_and_no_other_is_taken() {
    check::<Layer>();
    check::<Ramp>();
    check::<Consolidation>();
    check::<SelfWeight>();
    check::<LargeStrainLayer>();
    check::<Before>();
    check::<HalfSpace>();
    check::<ElasticColumn>();
    check::<VibratingBar>();
    check::<SlidingBlock>();
    check::<InfiniteSlope>();
    check::<StripFooting>();
    check::<RectangularDam>();
    check::<DamBreak>();
}

#[test]
fn choices_have_names_that_users_type() {
    let read = |name: &str| Value::from(name);
    assert_eq!(from_value::<Drainage>(read("top-and-base")).unwrap(), Drainage::TopAndBase);
    assert_eq!(from_value::<EndState>(read("hydrostatic")).unwrap(), EndState::Hydrostatic);
    assert_eq!(
        from_value::<Formulation>(read("up-without-fluid-acceleration")).unwrap(),
        Formulation::UpWithoutFluidAcceleration
    );
    assert_eq!(from_value::<BarEnds>(read("fixed-free")).unwrap(), BarEnds::FixedFree);
    for (law, name) in ["lube-2005", "lajeunesse-2005", "lagree-2011", "staron-hinch-2005", "lube-2004"]
        .into_iter()
        .enumerate()
        .map(|(i, name)| (ScalingLaw::ALL[i], name))
    {
        assert_eq!(from_value::<ScalingLaw>(read(name)).unwrap(), law);
    }
}

#[test]
fn a_problem_is_read_with_its_defaults() {
    let problem: Consolidation = from_value(json!({
        "layer": {
            "height": 10.0, "modulus": 16.5e6, "conductivity": 5.52e-5, "unit_weight": 9810.0, "fluid_compressibility": 0.0
        },
        "ramp": { "load": 50e3, "duration": 1000.0 },
    }))
    .unwrap();
    assert_eq!(problem.drainage, Drainage::Top);
    // The settlement of the article's column at 1000 s, from another program.
    assert!((problem.settlement(1000.0) - 20.508e-3).abs() < 0.5e-6);
}
