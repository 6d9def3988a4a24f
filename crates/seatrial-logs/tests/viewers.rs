//! The layout for Foxglove and the views for Rerun show what recordings have.

use std::collections::BTreeSet;
use std::path::Path;

use seatrial_core::{Sample, Stage, YawModel};
use seatrial_logs::{Estimate, Row, write_mcap};
use serde_json::Value;

fn example(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/examples");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn layout() -> Value {
    serde_json::from_str(&example("foxglove-layout.json")).unwrap()
}

/// Topics and types of a recording in which every column has a value.
fn recorded() -> Vec<(String, String)> {
    let row = Row {
        sample: Sample {
            surge_speed_m_s: Some(1.0),
            depth_m: Some(2.0),
            altitude_m: Some(3.0),
            roll_rad: Some(0.1),
            pitch_rad: Some(0.1),
            yaw_rate_rad_s: Some(0.1),
            north_m: Some(4.0),
            east_m: Some(5.0),
            thrust: Some(0.6),
            ..Sample::default()
        },
        stage: Some(Stage::Train),
        estimate: Some(Estimate {
            model: YawModel::default(),
            half_widths: Some([0.1; 3]),
            step_norm: 0.01,
        }),
    };
    let mut file = std::io::Cursor::new(Vec::new());
    write_mcap(&mut file, &[row]).unwrap();
    let messages = mcap::MessageStream::new(file.get_ref()).unwrap();
    let channels = messages.map(|message| message.unwrap().channel);
    channels
        .map(|channel| {
            let schema = channel.schema.as_ref().unwrap();
            (channel.topic.clone(), schema.name.clone())
        })
        .collect()
}

fn recorded_topics() -> BTreeSet<String> {
    recorded().into_iter().map(|(topic, _)| topic).collect()
}

/// Everything under this key, wherever it stands.
fn all<'a>(value: &'a Value, key: &str) -> Vec<&'a Value> {
    let below = |value: &'a Value| all(value, key);
    match value {
        Value::Object(map) => {
            let own = map.get(key).into_iter();
            own.chain(map.values().flat_map(below)).collect()
        }
        Value::Array(list) => list.iter().flat_map(below).collect(),
        _ => Vec::new(),
    }
}

#[test]
fn io_foxglove_shows_every_topic_and_no_other() {
    assert!(recorded().iter().all(|(_, kind)| kind == "std_msgs/msg/Float64"));
    let layout = layout();
    let paths = all(&layout["configById"], "value");
    let shown: BTreeSet<String> = paths
        .iter()
        .map(|path| path.as_str().unwrap())
        // A number is a line across the plot.
        .filter(|path| path.parse::<f64>().is_err())
        .map(|path| {
            let (topic, field) = path.split_once('.').unwrap();
            assert!(["data", "data.@rad2deg"].contains(&field), "{path}");
            topic.to_owned()
        })
        .collect();
    assert_eq!(shown, recorded_topics());
}

#[test]
fn io_the_layout_has_the_parts_that_foxglove_reads() {
    let layout = layout();
    let keys: Vec<&String> = layout.as_object().unwrap().keys().collect();
    let expected = ["configById", "globalVariables", "layout", "playbackConfig", "userNodes"];
    assert_eq!(keys, expected);
    let mut placed = Vec::new();
    placed_below(&layout["layout"], &mut placed);
    placed.sort();
    let panels: Vec<&String> = layout["configById"].as_object().unwrap().keys().collect();
    assert!(placed.iter().eq(panels.iter().copied()), "{placed:?}");
    for panel in panels {
        let kind = panel.split_once('!').unwrap().0;
        assert!(["Plot", "StateTransitions"].contains(&kind), "{panel}");
        let paths = layout["configById"][panel]["paths"].as_array().unwrap();
        assert!(!paths.is_empty(), "{panel}");
        for path in paths {
            assert_eq!(path["enabled"], true);
            assert_eq!(path["timestampMethod"], "receiveTime");
        }
    }
    let track = &layout["configById"]["Plot!track"];
    assert_eq!(track["xAxisVal"], "custom");
    assert_eq!(track["xAxisPath"]["value"], "/east_m.data");
    assert_eq!(track["paths"][0]["value"], "/north_m.data");
}

/// The panels of a tree of splits.
fn placed_below(node: &Value, placed: &mut Vec<String>) {
    if let Some(panel) = node.as_str() {
        placed.push(panel.to_owned());
        return;
    }
    assert!(["row", "column"].contains(&node["direction"].as_str().unwrap()), "{node}");
    let percent = node["splitPercentage"].as_f64().unwrap();
    assert!(percent > 0.0 && percent < 100.0, "{node}");
    for side in ["first", "second"] {
        placed_below(&node[side], placed);
    }
}

/// What Rerun makes of it is tried in `validation/2026-11-25-viewers`.
#[test]
fn io_rerun_shows_every_topic_and_no_other() {
    let script = example("rerun_trial.py");
    let views = script.split("COLUMNS = [").nth(1).unwrap();
    let views = views.split("\n]").next().unwrap();
    let quoted = views.split('"').skip(1).step_by(2);
    let shown: BTreeSet<String> = quoted
        .filter(|word| word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'))
        .map(|topic| format!("/{topic}"))
        .collect();
    assert_eq!(shown, recorded_topics());
    assert!(script.contains("source_component=\"std_msgs.msg.Float64:message\""));
}
