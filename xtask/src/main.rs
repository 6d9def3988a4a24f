//! The project's own commands.
//!
//! `cargo xtask test` runs what every change needs, in the order in which it fails fastest. `cargo xtask test --all` runs every check: the
//! same steps with the vehicles over ROS 2, the dashboard, the pages, the docs and the Python package, and beside them what has a build of
//! its own (`cargo xtask beside`, which ends with its standard input); everything is built once, for tests. Both add what is missing of the
//! pinned toolchain, and the first step that fails ends them. `cargo xtask embedded` is the one
//! on microcontrollers alone, `cargo xtask python` that of the Python package, `cargo xtask instructions` that of the kernels'
//! speed, `cargo xtask dash` that of the dashboard's interface, `cargo xtask web` that of its page, `cargo xtask page` that of the page
//! without a server, `cargo xtask page --measure` holds it against the terminal on long logs, `cargo xtask docs` builds the docs as a site, `cargo xtask extending` builds and tests the program that extends seatrial, `cargo xtask foxglove-loader` the data loader for Foxglove. `cargo xtask ros2` checks
//! the features `ros2` and `ros2-zenoh` each alone and neither, `cargo xtask ros2-jazzy` tries trials on a node of ROS 2 Jazzy, which it installs (248 MB), `cargo xtask miri` runs the library for C and the core under Miri. `cargo xtask packages` packs what
//! is published on crates.io, `cargo xtask oldest` builds the crates that promise an older compiler with it, `cargo xtask wheel` builds and installs the Python wheel, `cargo xtask archive` the archive and the Debian package of a release, `cargo xtask container` runs the command of the container file in a root of its own, `cargo xtask windows` builds the zip for Windows and tries its command under Wine. `cargo xtask same-answers` compares every answer with that of another binary. `cargo xtask house` holds the code against its plan.

mod alone;
mod archive;
mod beside;
mod book;
mod c_library;
mod container;
mod dash;
mod embedded;
mod environment;
mod extending;
mod foxglove_loader;
mod house;
mod http;
mod instructions;
mod long_log;
mod miri;
mod nextest;
mod oldest;
mod packages;
mod page;
mod python;
mod same_answers;
mod steps;
mod target;
mod toolchain;
mod wheel;
mod windows;

use std::process::{Command, ExitCode};
use std::time::Instant;

use beside::Beside;
use steps::{Step, in_order, passes, run, side_by_side, skipped};
use target::{in_target, target};

/// The features of the terminal that no build has by default.
const ROS2: &str = "seatrial-cli/ros2,seatrial-cli/ros2-zenoh";

/// Names, and the cargo commands that run in the order in which they fail fastest; `ROS2` stands for its features, where they are wanted.
const CHECKS: [(&str, &str); 6] = [
    ("format", "fmt --all --check"),
    (
        "lints",
        "clippy --workspace --all-targets ROS2 -- -D warnings",
    ),
    (
        CORE,
        "build -p seatrial-core --target thumbv7em-none-eabihf",
    ),
    (
        "tests",
        "nextest run --workspace ROS2 --no-fail-fast --test-threads 6 -E not(test(/^ros2::/))",
    ),
    ("doc tests", "test --workspace ROS2 --doc --quiet"),
    ("documentation", "doc --workspace ROS2 --no-deps --quiet"),
];
const CORE: &str = "core on Cortex-M";

const HOUSE: Step = ("the plan of the house", || house::check(false));
const PYTHON_FOR_TESTS: Step = ("Python for the tests", python::prepare_tests);
const PYTHON: Step = ("Python", python::check);
const PYTHON_SPEED: Step = ("Python beside scipy", python::is_fast);
/// Last of what runs beside the tests: its build waits for theirs.
const PYTHON_PACKAGE: Step = ("the package for Python", python::build);
const DASHBOARD: Step = ("the dashboard's interface", dash::check);
const PAGE: Step = ("the page", page::check);
const PAGE_ALONE: Step = ("the page without a server", alone::check);
const SITE: Step = ("the docs as a site", book::check);
const INSTRUCTIONS: Step = ("instructions", instructions::check);
const EXTENDING: Step = ("a program outside the workspace", extending::check);
const OLDEST: Step = ("old compilers", oldest::check);
const MICROCONTROLLERS: Step = ("microcontrollers", || match embedded::check()? {
    Some(vectors) => c_library::check(&vectors),
    None => Ok(()),
});

/// What each command runs, by its words.
const COMMANDS: [(&str, &[Step]); 22] = [
    ("house", &[HOUSE]),
    (
        "house --list",
        &[("the plan of the house", || house::check(true))],
    ),
    ("embedded", &[MICROCONTROLLERS]),
    ("python", &[PYTHON, PYTHON_SPEED]),
    ("dash", &[DASHBOARD]),
    ("ros2", &[("ROS 2", on_ros2)]),
    ("ros2-jazzy", &[("ROS 2 Jazzy", on_ros2_itself)]),
    ("miri", &[("Miri", miri::check)]),
    ("instructions", &[INSTRUCTIONS]),
    ("web", &[PAGE]),
    ("page", &[PAGE_ALONE]),
    (
        "page --measure",
        &[("the page beside the terminal", alone::measure)],
    ),
    ("docs", &[PYTHON_FOR_TESTS, SITE]),
    ("extending", &[EXTENDING]),
    (
        "foxglove-loader",
        &[(
            "the data loader for Foxglove",
            foxglove_loader::check_and_build,
        )],
    ),
    ("oldest", &[OLDEST]),
    ("packages", &[("packages", || on_crates_io(false))]),
    ("packages --build", &[("packages", || on_crates_io(true))]),
    ("wheel", &[("the wheel", || wheel::check(None))]),
    ("archive", &[("archives", || archive::check(None))]),
    ("container", &[("the container", container::check_at_work)]),
    ("windows", &[("Windows", windows::check)]),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let command = arguments.join(" ");
    let steps = COMMANDS.iter().find(|(name, _)| *name == command);
    let passed = match arguments.as_slice() {
        ["test"] => test(|| with_cargo(&CHECKS, &[])),
        ["test", "--all"] => test(everything),
        ["beside"] => beside_the_tests(),
        ["wheel", target] => passes("the wheel", || wheel::check(Some(target))),
        ["archive", target] => passes("archives", || archive::check(Some(target))),
        ["same-answers", rest @ ..] => return same_answers::run(rest),
        _ => match steps {
            Some((_, steps)) => in_order(steps),
            None => {
                let names = COMMANDS.map(|(name, _)| name).join("|");
                eprintln!(
                    "usage: cargo xtask test [--all]|wheel TARGET|archive TARGET|same-answers|{names}"
                );
                return ExitCode::from(2);
            }
        },
    };
    match passed {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

fn test(checks: fn() -> bool) -> bool {
    let begin = Instant::now();
    let passed = in_order(&[HOUSE, ("the toolchain", toolchain::prepare)]) && checks();
    if passed {
        eprintln!("== all passed in {:.0} s", begin.elapsed().as_secs_f64());
    }
    passed
}

fn everything() -> bool {
    let beside = match Beside::begin() {
        Ok(beside) => beside,
        Err(message) => {
            eprintln!("xtask: {message}");
            return false;
        }
    };
    let passed = in_order(&[PYTHON_FOR_TESTS])
        && with_cargo(&CHECKS, &["--features", ROS2])
        && in_order(&[("vehicles over ROS 2", over_ros2)])
        && side_by_side(&[&[PYTHON, DASHBOARD], &[PAGE, PAGE_ALONE, SITE]]);
    if !passed {
        beside.end();
        return false;
    }
    // What is measured is not disturbed.
    beside.passed() && in_order(&[PYTHON_SPEED])
}

/// What is built apart from the workspace's tests.
fn beside_the_tests() -> bool {
    beside::end_with_the_other();
    let browser = "the program of the page without a server";
    side_by_side(&[
        &[
            ("tools", prepare_tools),
            INSTRUCTIONS,
            MICROCONTROLLERS,
            OLDEST,
            PYTHON_PACKAGE,
        ],
        &[
            (browser, alone::compile),
            EXTENDING,
            ("logs in Foxglove", foxglove_loader::check),
        ],
    ])
}

/// Fetches what later checks need; one that cannot be had is told by the check that needs it.
fn prepare_tools() -> Result<(), String> {
    python::prepare();
    dash::prepare();
    page::prepare();
    Ok(())
}

/// Ends with the tests that were skipped for want of data or tools.
fn with_cargo(checks: &[(&str, &str)], ros2: &[&str]) -> bool {
    let skipped_tests = in_target("skipped-tests.txt");
    let _ = std::fs::remove_file(&skipped_tests);
    let passed = checks.iter().all(|(name, command)| {
        passes(name, || {
            if *name == CORE && !toolchain::has_library(toolchain::CORTEX_M) {
                return skipped(CORE, &toolchain::no_library(toolchain::CORTEX_M));
            }
            let command = command.replace("ROS2", &ros2.join(" "));
            let mut cargo = cargo_or_nextest(&command)?;
            cargo.env("RUSTDOCFLAGS", "-D warnings");
            cargo.env("SEATRIAL_SKIPPED", &skipped_tests);
            run(&mut cargo, format!("cargo {command}"))
        })
    });
    if let Ok(list) = std::fs::read_to_string(&skipped_tests) {
        eprint!("{list}");
    }
    passed
}

/// Whole trials on vehicles of other processes, from the tests that are built. They are played in real time, which they
/// mostly wait for: one that the machine holds up for long is a lost one, which is tried again.
fn over_ros2() -> Result<(), String> {
    let tests =
        "nextest run --workspace --test-threads 3 --retries 2 -E test(/^ros2::/) --features";
    let mut tests = cargo_or_nextest(&format!("{tests} {ROS2}"))?;
    run(&mut tests, "vehicles over DDS or zenoh")
}

/// One test at a time: the vehicles are played in real time, and one that the machine holds up for long is a lost one.
fn on_ros2() -> Result<(), String> {
    python::prepare_tests()?;
    for command in [
        "clippy -p seatrial-links -p seatrial-cli --all-targets --features ros2,ros2-zenoh -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli --features ros2 -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli --features ros2-zenoh -- -D warnings",
        "nextest run --test-threads 1 --features ros2-zenoh -p seatrial-links --lib ros2_vehicle",
        "nextest run --test-threads 1 --features ros2,ros2-zenoh -p seatrial-cli -E test(/^ros2/)",
    ] {
        run(&mut cargo_or_nextest(command)?, command)?;
    }
    Ok(())
}

/// Whole trials on a vehicle that is a node of ROS 2 Jazzy; not part of `test --all`, for the size of ROS 2.
fn on_ros2_itself() -> Result<(), String> {
    let Some(python) = python::of_jazzy() else {
        let missing = "python3.12 with venv, or ROS 2 in its registry, is missing";
        return skipped("ROS 2 Jazzy", missing);
    };
    let mut tests = cargo_or_nextest(
        "nextest run -p seatrial-cli --features ros2 --test-threads 1 --run-ignored only -E test(/^ros2::jazzy/) --no-capture",
    )?;
    let failed = "vehicles that are nodes of ROS 2";
    run(tests.env("SEATRIAL_PYTHON", python), failed)
}

fn on_crates_io(builds: bool) -> Result<(), String> {
    container::check()?;
    packages::check(builds)
}

/// The words of a command, between blanks.
fn cargo_or_nextest(command: &str) -> Result<Command, String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    match words.split_first() {
        Some((&"nextest", rest)) => nextest::command(rest),
        _ => Ok(cargo(&words)),
    }
}

/// Runs cargo with the words of a command, between blanks.
fn run_cargo(words: &str) -> Result<(), String> {
    let arguments: Vec<&str> = words.split_whitespace().collect();
    run(&mut cargo(&arguments), format!("cargo {words}"))
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).env("CARGO_TARGET_DIR", target());
    command
}
