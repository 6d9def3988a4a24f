//! Operation for long: campaign after campaign under the eyes of viewers, who come, go, and do not read.

use serde_json::{Value, json};

use super::kind;
use super::server::Server;

const DAY_S: f64 = 24.0 * 3600.0;

/// What the server's process holds.
#[derive(Clone, Copy, Debug)]
struct ProcessUse {
    /// Vehicle time since the first campaign began, s.
    time_s: f64,
    /// Memory that no file stands behind, kB.
    memory_kb: f64,
    files: usize,
    threads: usize,
}

fn held(process: u32, time_s: f64) -> ProcessUse {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let number = |name: &str| -> f64 {
        let line = status.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let files = std::fs::read_dir(format!("/proc/{process}/fd")).unwrap();
    ProcessUse {
        time_s,
        memory_kb: number("RssAnon:"),
        files: files.count(),
        threads: number("Threads:") as usize,
    }
}

/// Campaigns back to back, as fast as the machine can, for so long by the vehicle's clock; what was held after each.
fn operate(
    server: &Server,
    plan: &Value,
    duration_s: f64,
    mut after_each: impl FnMut(usize, &ProcessUse),
) -> Vec<ProcessUse> {
    let lease = server.control("Anna");
    let mut viewer = server.viewer(&json!({"lease": lease}));
    let never_reads = server.viewer(&json!({}));
    let mut after = Vec::new();
    let mut time_s = 0.0;
    while time_s < duration_s {
        let campaign = after.len() + 1;
        let order = json!({"vehicle": "sim:starfish", "plan": plan, "seed": campaign});
        server.start_trial(&lease, &order);
        let mut passing = server.viewer(&json!({}));
        assert_eq!(kind(&passing.next()), "snapshot");
        drop(passing);
        viewer.until(|message| kind(message) == "trial_ended");
        let trial = server.wait_for_end();
        assert_eq!(trial["outcome"]["finished"], true, "{trial}");
        server.get(&format!("/campaigns/{campaign}"));
        let health = server.get("/status")["health"].clone();
        let samples = health["samples"].as_f64().unwrap();
        time_s += samples * health["expected_interval_s"].as_f64().unwrap();
        let now = held(server.child.id(), time_s);
        after_each(campaign, &now);
        after.push(now);
    }
    drop(never_reads);
    after
}

/// How the last third of the campaigns differs from the middle one: memory, kB, and files and threads at most.
fn is_bounded(after: &[ProcessUse], most_memory_kb: f64) {
    let third = after.len() / 3;
    let [middle, last] = [third..2 * third, 2 * third..after.len()].map(|range| &after[range]);
    let memory_kb =
        |of: &[ProcessUse]| of.iter().map(|held| held.memory_kb).sum::<f64>() / of.len() as f64;
    let grown_kb = memory_kb(last) - memory_kb(middle);
    println!("memory has grown by {grown_kb:.0} kB from the middle third to the last");
    assert!(grown_kb < most_memory_kb, "{grown_kb:.0} kB: {after:?}");
    let whats: [fn(&ProcessUse) -> usize; 2] = [|held| held.files, |held| held.threads];
    for what in whats {
        let most = |of: &[ProcessUse]| of.iter().map(what).max().unwrap();
        // One more may be just on its way out.
        assert!(most(last) <= most(middle) + 1, "{after:?}");
    }
}

/// Were the messages of each campaign kept, those of a third of them would be 9 MB. Caches and the ring of messages fill for 50 campaigns, and what
/// the allocator keeps varies: on busy cores the last third has held up to 2.5 MB more than the middle one.
#[test]
fn cli_campaigns_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut plan = server.get("/plans/default");
    plan["thrusts"] = json!([0.6]);
    let after = operate(&server, &plan, 90.0 * 45.0, |_, _| {});
    is_bounded(&after, 4500.0);
}

/// `cargo nextest run -p seatrial-cli --run-ignored all --no-capture -E 'test(val_a_day)'`
#[test]
#[ignore = "some 10 min, and 300 MB of disk"]
fn val_a_day_of_operation_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    // Between two manoeuvres two minutes of sailing on.
    let mut plan = server.get("/plans/default");
    plan["settle"]["at_least_s"] = json!(120.0);
    plan["settle"]["at_most_s"] = json!(150.0);
    plan["envelope"]["stage_time_limit_s"] = json!(200.0);
    println!("hours  campaigns  memory, MB  files  threads");
    let mut due_s = 0.0;
    let after = operate(&server, &plan, DAY_S, |campaign, held| {
        if held.time_s >= due_s {
            println!(
                "{:5.1}  {campaign:9}  {:10.1}  {:5}  {:7}",
                held.time_s / 3600.0,
                held.memory_kb / 1000.0,
                held.files,
                held.threads
            );
            due_s += 2.0 * 3600.0;
        }
    });
    // Samples of eight hours, were they kept, would be 50 MB.
    is_bounded(&after, 4000.0);
}
