//! `seatrial mcp` as an assistant's program uses it: twenty tasks, damaged messages, tools that move a vehicle.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use seatrial_dev::{Damage, damaged_copies, program_path, run_in};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Answers to these lines, by a server with these options.
fn served(folder: &Path, options: &[&str], lines: &[u8]) -> Vec<Value> {
    let mut server = Command::new(program_path())
        .arg("mcp")
        .args(options)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = server.stdin.take().unwrap();
    let lines = lines.to_vec();
    let writer = std::thread::spawn(move || {
        // A server that ended early is found by its status.
        let _ = input.write_all(&lines);
    });
    let done = server.wait_with_output().unwrap();
    writer.join().unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    let answers = String::from_utf8(done.stdout).unwrap();
    let answers = answers.lines().map(serde_json::from_str);
    answers.collect::<Result<_, _>>().unwrap()
}

fn call(id: usize, tool: &str, arguments: &Value) -> Value {
    json!({"jsonrpc": "2.0", "id": id, "method": "tools/call", "params": {"name": tool, "arguments": arguments}})
}

/// The answers to calls of tools, in their order.
fn called(folder: &Path, options: &[&str], calls: &[(&str, Value)]) -> Vec<Value> {
    let mut lines = Vec::new();
    for (id, (tool, arguments)) in calls.iter().enumerate() {
        writeln!(lines, "{}", call(id, tool, arguments)).unwrap();
    }
    let answers = served(folder, options, &lines);
    assert_eq!(answers.len(), calls.len());
    for (id, answer) in answers.iter().enumerate() {
        assert_eq!(answer["id"], json!(id));
    }
    answers
}

/// A folder with logs: a whole one, and some that lie or are damaged.
fn logs() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (seed, name) in [("1", "run.csv"), ("2", "second.csv")] {
        let made = run_in(
            folder.path(),
            &["sim", "log", "--seed", seed, "--thrust", "0.8", "--out", name],
        );
        assert!(made.status.success());
    }
    let text = std::fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|title| *title == name).unwrap();
    let (heading, rudder) = (column("heading_rad"), column("rudder_rad"));
    let write = |name: &str, change: &dyn Fn(usize, &mut Vec<String>)| {
        let mut lines = Vec::new();
        for (row, cells) in rows.iter().enumerate() {
            let mut cells: Vec<String> = cells.iter().map(ToString::to_string).collect();
            if row > 0 {
                change(row, &mut cells);
            }
            lines.push(cells.join(","));
        }
        std::fs::write(folder.path().join(name), lines.join("\n")).unwrap();
    };
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    write("still_rudder.csv", &|_, cells| cells[rudder] = "0".into());
    write("still_heading.csv", &|_, cells| cells[heading] = "1".into());
    write("degrees.csv", &|_, cells| {
        cells[heading] = number(&cells[heading]).to_degrees().to_string();
    });
    write("reversed.csv", &|_, cells| {
        cells[rudder] = (-number(&cells[rudder])).to_string();
    });
    write("noise.csv", &|row, cells| {
        cells[heading] = ((row * 7919 % 1000) as f64 / 300.0).to_string();
    });
    write("holes.csv", &|row, cells| {
        if row % 50 == 0 {
            cells[heading] = "nan".into();
        }
    });
    std::fs::write(folder.path().join("empty.csv"), "").unwrap();
    std::fs::write(folder.path().join("binary.bin"), [0xff, 0x00, 0x7f].repeat(999)).unwrap();
    folder
}

/// a22 and b2 of the simulated vehicle at 80 % thrust.
const TRUTH: [f64; 2] = [-1.07, 1.08];

/// A model that is told as usable is the vehicle's; one that is not has no numbers.
fn is_honest(answer: &Value) {
    for speed in answer["speeds"].as_array().unwrap() {
        let usable = speed["verdict"]["may_be_used"].as_bool().unwrap();
        if speed["verdict"]["outcome"] == "do_not_use" {
            assert!(speed["model"].is_null(), "{speed}");
            assert!(!usable);
        }
        if usable {
            let found = |name: &str| speed["model"][name].as_f64().unwrap();
            let [a22, b2] = [found("a22_per_s"), found("b2_per_s2")];
            assert!((a22 / TRUTH[0] - 1.0).abs() < 0.12, "a22 {a22}");
            assert!((b2 / TRUTH[1] - 1.0).abs() < 0.12, "b2 {b2}");
        }
    }
}

#[test]
fn cli_twenty_tasks_tell_no_wrong_model_as_right() {
    let folder = logs();
    let log = |name: &str| json!({"log": name});
    let windows = json!({"log": "run.csv", "from_s": 12, "to_s": 28.5, "validate_from_s": 28.5, "validate_to_s": 45});
    // What is asked, and what the answer says: of a tool that has no result its text.
    let tasks: [(&str, Value, &str); 20] = [
        ("inspect", log("run.csv"), "A model may be identified"),
        ("inspect", log("still_rudder.csv"), "No model can be identified"),
        ("inspect", log("no_such.csv"), "no_such.csv"),
        ("identify", log("run.csv"), "The model may be used:"),
        ("identify", windows, "The model may be used:"),
        (
            "identify",
            json!({"log": "run.csv", "validate_on": "second.csv"}),
            "The model may be used",
        ),
        ("identify", log("still_rudder.csv"), "There is no model to use"),
        ("identify", log("still_heading.csv"), "There is no model to use"),
        ("identify", log("degrees.csv"), "There is no model to use"),
        ("identify", log("reversed.csv"), "The model may be used"),
        ("identify", log("noise.csv"), "There is no model to use"),
        ("identify", log("holes.csv"), "holes.csv"),
        ("identify", log("empty.csv"), "empty.csv"),
        ("identify", log("binary.bin"), "binary.bin"),
        ("compare", log("run.csv"), "none of them is a verdict. The model may be used:"),
        ("health", json!({"reference": "run.csv@0..28", "now": "second.csv@0..28"}), ""),
        ("plan", json!({"thrusts": [0.6, 0.8]}), "the plan will do"),
        ("plan", json!({"amplitude_deg": 80}), "amplitude"),
        ("explain_verdict", json!({"code": "constant", "of": "rudder"}), "the rudder hardly moved"),
        (
            "simulate",
            json!({"thrusts": [0.8], "seed": 3}),
            "A rehearsal on sim:starfish, of no real vehicle. The model may be used",
        ),
    ];
    let calls: Vec<(&str, Value)> = tasks.iter().map(|(t, a, _)| (*t, a.clone())).collect();
    let answers = called(folder.path(), &[], &calls);
    for ((tool, arguments, expected), answer) in tasks.iter().zip(&answers) {
        let result = &answer["result"];
        let said = result["content"][0]["text"].as_str().unwrap();
        assert!(said.contains(expected), "{tool} {arguments}: {said}");
        let has_model = ["identify", "simulate"].contains(tool) && result["isError"] == false;
        if has_model && *arguments != log("reversed.csv") {
            is_honest(&result["structuredContent"]);
        }
    }
    // The rudder that goes the other way is told as it is in the log.
    let reversed = &answers[9]["result"]["structuredContent"];
    let b2 = reversed["speeds"][0]["model"]["b2_per_s2"].as_f64().unwrap();
    assert!((b2 / -TRUTH[1] - 1.0).abs() < 0.12, "{reversed}");
    assert!(reversed["verdict"].to_string().contains("sign_reversed"), "{reversed}");
    let change = &answers[15]["result"]["structuredContent"];
    assert_ne!(change["finding"], "changed", "{change}");
}

#[test]
fn io_the_protocol_is_that_of_its_specification() {
    let folder = tempfile::tempdir().unwrap();
    let lines = [
        r#"{"jsonrpc":"2.0","id":"a","method":"initialize","params":{"protocolVersion":"2025-03-26","capabilities":{},"clientInfo":{"name":"t","version":"1"}}}"#,
        r#"{"jsonrpc":"2.0","method":"notifications/initialized"}"#,
        r#"{"jsonrpc":"2.0","id":2,"method":"ping"}"#,
        r#"{"jsonrpc":"2.0","id":3,"method":"tools/list"}"#,
        r#"{"jsonrpc":"2.0","id":4,"method":"initialize","params":{"protocolVersion":"1999-01-01"}}"#,
        "",
    ];
    let answers = served(folder.path(), &[], lines.join("\n").as_bytes());
    assert_eq!(answers.len(), 4);
    let begun = &answers[0]["result"];
    assert_eq!((&answers[0]["id"], &begun["protocolVersion"]), (&json!("a"), &json!("2025-03-26")));
    assert_eq!(begun["serverInfo"]["name"], "seatrial");
    assert_eq!(answers[1]["result"], json!({}));
    assert_eq!(answers[3]["result"]["protocolVersion"], "2025-06-18");
    let tools = answers[2]["result"]["tools"].as_array().unwrap();
    let names: Vec<&str> = tools.iter().map(|tool| tool["name"].as_str().unwrap()).collect();
    for name in ["inspect", "identify", "compare", "plan", "explain_verdict", "simulate"] {
        assert!(names.contains(&name), "{names:?}");
    }
    for tool in tools {
        assert_eq!(tool["inputSchema"]["type"], "object");
        let moves = tool["description"].as_str().unwrap().starts_with("MOVES");
        assert_eq!(tool["annotations"]["destructiveHint"], json!(moves));
        for required in tool["inputSchema"]["required"].as_array().unwrap() {
            assert!(tool["inputSchema"]["properties"][required.as_str().unwrap()].is_object());
        }
    }
}

#[test]
fn io_messages_that_are_none_are_errors_of_json_rpc() {
    let folder = tempfile::tempdir().unwrap();
    let long = format!("{{\"a\":\"{}\"}}", "x".repeat(2 << 20));
    let deep = "[".repeat(100_000);
    let messages: [(&str, i64); 16] = [
        ("no json", -32700),
        ("{\"jsonrpc\":", -32700),
        (&deep, -32700),
        ("\u{0}", -32700),
        ("[]", -32600),
        ("3", -32600),
        (&long, -32600),
        (r#"{"id":1,"method":"ping"}"#, -32600),
        (r#"{"jsonrpc":"2.0","id":1}"#, -32600),
        (r#"{"jsonrpc":"2.0","id":{},"method":"ping"}"#, -32600),
        (r#"{"jsonrpc":"2.0","id":1,"method":"ping","params":[1]}"#, -32600),
        (r#"{"jsonrpc":"2.0","id":1,"method":"resources/list"}"#, -32601),
        (r#"{"jsonrpc":"2.0","id":1,"method":"tools/call"}"#, -32602),
        (r#"{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"rm"}}"#, -32602),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"inspect","arguments":{"log":7}}}"#,
            -32602,
        ),
        (
            r#"{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"inspect","arguments":{"log":"a","shell":"b"}}}"#,
            -32602,
        ),
    ];
    let mut lines: Vec<u8> = Vec::new();
    for (message, _) in messages {
        writeln!(lines, "{message}").unwrap();
    }
    // After all of them it still answers.
    writeln!(lines, "{}", json!({"jsonrpc": "2.0", "id": 9, "method": "ping"})).unwrap();
    let answers = served(folder.path(), &[], &lines);
    assert_eq!(answers.len(), messages.len() + 1);
    for ((message, code), answer) in messages.iter().zip(&answers) {
        let start: String = message.chars().take(80).collect();
        assert_eq!(answer["error"]["code"], json!(code), "{start}: {answer}");
    }
    assert_eq!(answers[messages.len()]["result"], json!({}));
}

#[test]
fn prop_damaged_messages_never_end_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let whole = call(1, "plan", &json!({"thrusts": [0.8], "target": "a22:10%"})).to_string();
    let mut damage = Damage::new(24);
    let mut lines = Vec::new();
    for _ in 0..damaged_copies(200) {
        let mut line = damage.of(whole.as_bytes());
        line.retain(|byte| *byte != b'\n');
        lines.extend(line);
        lines.push(b'\n');
    }
    writeln!(lines, "{}", json!({"jsonrpc": "2.0", "id": "last", "method": "ping"})).unwrap();
    let answers = served(folder.path(), &[], &lines);
    assert_eq!(answers.last().unwrap()["id"], "last");
}

#[test]
fn cli_what_moves_a_vehicle_is_locked_and_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let asked = json!({"vehicle": "sim:starfish", "logbook": "sea.db"});
    let calls = [("trial", asked.clone()), ("commission", asked.clone())];
    for answer in called(folder.path(), &[], &calls) {
        assert_eq!(answer["result"]["isError"], true);
        let said = answer["result"]["content"][0]["text"].as_str().unwrap();
        assert!(said.starts_with("locked:"), "{said}");
    }
    assert!(!folder.path().join("sea.db").exists());
    // Unlocked, at a terminal that `script` plays: no, then yes.
    std::fs::write(
        folder.path().join("calls.json"),
        format!("{}\n{}\n", call(0, "trial", &asked), call(1, "trial", &asked)),
    )
    .unwrap();
    let program = program_path();
    let mut terminal = Command::new("script")
        .args([
            "-qec",
            &format!("{} mcp --allow-vehicle < calls.json > answers.json", program.display()),
            "/dev/null",
        ])
        .current_dir(folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut typed = terminal.stdin.take().unwrap();
    typed.write_all(b"no\n").unwrap();
    let answers =
        || std::fs::read_to_string(folder.path().join("answers.json")).unwrap_or_default();
    let begun = std::time::Instant::now();
    while answers().lines().count() < 1 && begun.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    typed.write_all(b"yes\n").unwrap();
    assert!(terminal.wait().unwrap().success());
    let answers = answers();
    let answers: Vec<Value> =
        answers.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(answers[0]["result"]["content"][0]["text"], "refused at the terminal");
    let trial = &answers[1]["result"]["structuredContent"];
    assert_eq!(trial["verdict"]["outcome"], "use", "{}", answers[1]);
    assert!(folder.path().join("sea.db").exists());
}

#[test]
fn io_a_file_that_is_no_log_is_not_told_to_an_assistant() {
    let folder = tempfile::tempdir().unwrap();
    let secret = "root_user_of_this_machine,x,0,0\n`1`,2,3,4\n";
    std::fs::write(folder.path().join("passwd"), secret).unwrap();
    std::fs::write(folder.path().join("a`b.csv"), "time_s,heading_deg,rudder_deg\n0,1,2\n1,2,3\n")
        .unwrap();
    let log = |name: &str| json!({"log": name});
    let calls = [
        ("inspect", log("passwd")),
        ("identify", log("passwd")),
        ("compare", log("passwd")),
        ("plan", json!({"file": "passwd"})),
        ("health", json!({"reference": "passwd", "now": "passwd"})),
        ("inspect", json!({"log": "passwd", "channels_file": "passwd"})),
        ("inspect", log("a`b.csv")),
        ("simulate", json!({"vehicle": "sim:passwd"})),
        ("simulate", json!({"vehicle": "sim:secret.toml"})),
        ("plan", json!({"vehicle": "sim:secret.toml"})),
        ("plan", json!({"file": "secret.toml"})),
        ("plan", json!({"model": "secret.json"})),
        ("simulate", json!({"vehicle": "sim:secret.json"})),
        ("inspect", json!({"log": "a`b.csv", "channels_file": "secret.toml"})),
        ("inspect", log("/dev/zero")),
        ("plan", json!({"file": "/dev/zero"})),
        ("simulate", json!({"vehicle": "sim:/dev/zero"})),
    ];
    let secret = folder.path().join("secret.toml");
    std::fs::write(secret, "root_user_name = \"root_user\"\n").unwrap();
    let secret = folder.path().join("secret.json");
    std::fs::write(secret, "{\"root_user\": \"root_user\"}").unwrap();
    for answer in called(folder.path(), &[], &calls) {
        assert!(!answer.to_string().contains("root_user"), "{answer}");
        // An error of the protocol has no content.
        for content in answer["result"]["content"].as_array().into_iter().flatten() {
            let text = content["text"].as_str().unwrap();
            assert!(!text.contains('`'), "{text}");
        }
    }
}
