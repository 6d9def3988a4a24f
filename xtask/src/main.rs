//! The project's own commands: `cargo xtask --help`.

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
mod shell;
mod steps;
mod toolchain;
mod wheel;
mod windows;
mod workspace;

use std::process::{Command, ExitCode};
use std::time::Instant;

use anyhow::Result;
use clap::{Args, Parser};

use beside::beside;
use shell::{Run, command};
use steps::{Step, in_order, passes, side_by_side};
use workspace::{in_target, root};

/// The features of the terminal that no build has by default.
const ROS2: &str = "seatrial-cli/ros2,seatrial-cli/ros2-zenoh";

/// The project's own commands. What needs a tool that is missing is skipped, which is said; with CI=true it fails
#[derive(Parser)]
#[command(bin_name = "cargo xtask")]
enum Asked {
    /// What every change needs, in the order in which it fails fastest; adds what is missing of the pinned toolchain
    Test {
        /// Every check: also vehicles over ROS 2, the dashboard, the pages, the docs, the Python package, and what has a build of its own
        #[arg(long)]
        all: bool,
    },
    /// What `test --all` runs beside the tests; it ends with its standard input
    #[command(hide = true)]
    Beside,
    /// The code against its plan
    House {
        /// Print the long functions that it still allows
        #[arg(long)]
        list: bool,
    },
    /// The core on microcontrollers, and the library for C
    Embedded,
    /// The Python package, and its speed beside scipy
    Python,
    /// The dashboard's programming interface
    Dash,
    /// The dashboard's page in a browser
    Web,
    /// The page without a server
    Page {
        /// Hold it against the terminal on long logs
        #[arg(long)]
        measure: bool,
    },
    /// The docs as a site
    Docs,
    /// The features ros2 and ros2-zenoh, each alone and neither
    Ros2,
    /// Trials on a node of ROS 2 Jazzy, which it installs (248 MB)
    Ros2Jazzy,
    /// The library for C and the core under Miri
    Miri,
    /// How many instructions the kernels take
    Instructions,
    /// The program that extends seatrial
    Extending,
    /// The data loader for Foxglove
    FoxgloveLoader,
    /// Crates that promise an older compiler, built with it
    Oldest,
    /// What is published on crates.io
    Packages {
        /// Build each crate from what would be uploaded
        #[arg(long)]
        build: bool,
    },
    /// The Python wheel, built and installed
    Wheel(Target),
    /// The archive and the Debian package of a release, built, installed and used
    Archive(Target),
    /// The command of the container file in a root of its own
    Container,
    /// The zip for Windows, and its command under Wine
    Windows,
    SameAnswers(same_answers::Options),
}

#[derive(Args)]
struct Target {
    /// The target of the compiler [default: this machine's]
    target: Option<String>,
}

/// Names, and the cargo commands that run in the order in which they fail fastest; `ROS2` stands for its features, where they are wanted.
const CHECKS: [(&str, &str); 6] = [
    ("format", "fmt --all --check"),
    ("lints", "clippy --workspace --all-targets ROS2 -- -D warnings"),
    ("core on Cortex-M", "build -p seatrial-core --target thumbv7em-none-eabihf"),
    (
        "tests",
        "nextest run --workspace ROS2 --no-fail-fast --test-threads 6 -E not(test(/^ros2::/))",
    ),
    ("doc tests", "test --workspace ROS2 --doc --quiet"),
    ("documentation", "doc --workspace ROS2 --no-deps --quiet"),
];

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
const MICROCONTROLLERS: Step = ("microcontrollers", || c_library::check(&embedded::check()?));

fn main() -> ExitCode {
    let asked = Asked::parse();
    if let Err(error) = std::env::set_current_dir(root()) {
        eprintln!("{}: {error}", root().display());
        return ExitCode::FAILURE;
    }
    let passed = match asked {
        Asked::Test { all: false } => test(|| with_cargo("")),
        Asked::Test { all: true } => test(everything),
        Asked::Beside => beside_the_tests(),
        Asked::House { list } => passes(HOUSE.0, || house::check(list)),
        Asked::Embedded => in_order(&[MICROCONTROLLERS]),
        Asked::Python => in_order(&[PYTHON, PYTHON_SPEED]),
        Asked::Dash => in_order(&[DASHBOARD]),
        Asked::Web => in_order(&[PAGE]),
        Asked::Page { measure: false } => in_order(&[PAGE_ALONE]),
        Asked::Page { measure: true } => passes("the page beside the terminal", alone::measure),
        Asked::Docs => in_order(&[PYTHON_FOR_TESTS, SITE]),
        Asked::Ros2 => passes("ROS 2", on_ros2),
        Asked::Ros2Jazzy => passes("ROS 2 Jazzy", on_ros2_itself),
        Asked::Miri => passes("Miri", miri::check),
        Asked::Instructions => in_order(&[INSTRUCTIONS]),
        Asked::Extending => in_order(&[EXTENDING]),
        Asked::FoxgloveLoader => passes("the data loader for Foxglove", extending::build_loader),
        Asked::Oldest => in_order(&[OLDEST]),
        Asked::Packages { build } => passes("packages", || packages::check(build)),
        Asked::Wheel(Target { target }) => passes("the wheel", || wheel::check(target.as_deref())),
        Asked::Archive(Target { target }) => {
            passes("archives", || archive::check(target.as_deref()))
        }
        Asked::Container => passes("the container", container::check_at_work),
        Asked::Windows => passes("Windows", windows::check),
        Asked::SameAnswers(options) => match same_answers::run(&options) {
            Ok(same) => return ExitCode::from(if same { 0 } else { 4 }),
            Err(error) => passes("the same answers", || Err(error)),
        },
    };
    ExitCode::from(u8::from(!passed))
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
    let with_the_tests = || {
        in_order(&[PYTHON_FOR_TESTS])
            && with_cargo(&format!("--features {ROS2}"))
            && in_order(&[("vehicles over ROS 2", over_ros2)])
            && side_by_side(&[&[PYTHON, DASHBOARD], &[PAGE, PAGE_ALONE, SITE]])
    };
    // What is measured is not disturbed.
    beside(with_the_tests) && in_order(&[PYTHON_SPEED])
}

/// What is built apart from the workspace's tests.
fn beside_the_tests() -> bool {
    beside::end_with_the_other();
    let browser = "the program of the page without a server";
    side_by_side(&[
        &[("tools", prepare_tools), INSTRUCTIONS, MICROCONTROLLERS, OLDEST, PYTHON_PACKAGE],
        &[(browser, alone::compile), EXTENDING, ("logs in Foxglove", extending::check_loader)],
    ])
}

/// Fetches what later checks need; one that cannot be had is told by the check that needs it.
fn prepare_tools() -> Result<()> {
    let _ = dash::ENVIRONMENT.program("schemathesis");
    let _ = page::prepare();
    Ok(())
}

/// Ends with the tests that were skipped for want of data or tools.
fn with_cargo(ros2: &str) -> bool {
    let skipped_tests = in_target("skipped-tests.txt");
    let _ = std::fs::remove_file(&skipped_tests);
    let passed = CHECKS.iter().all(|(name, words)| {
        passes(name, || {
            if words.contains(toolchain::CORTEX_M) {
                toolchain::needs_library(toolchain::CORTEX_M)?;
            }
            let mut cargo = cargo(&words.replace("ROS2", ros2))?;
            cargo.env("RUSTDOCFLAGS", "-D warnings");
            cargo.env("SEATRIAL_SKIPPED", &skipped_tests).run()
        })
    });
    eprint!("{}", std::fs::read_to_string(&skipped_tests).unwrap_or_default());
    passed
}

/// Whole trials on vehicles of other processes, from the tests that are built. They are played in real time, which they
/// mostly wait for: one that the machine holds up for long is a lost one, which is tried again.
fn over_ros2() -> Result<()> {
    let tests =
        "nextest run --workspace --test-threads 3 --retries 2 -E test(/^ros2::/) --features";
    cargo(&format!("{tests} {ROS2}"))?.run()
}

/// One test at a time: the vehicles are played in real time, and one that the machine holds up for long is a lost one.
fn on_ros2() -> Result<()> {
    python::prepare_tests()?;
    for command in [
        "clippy -p seatrial-links -p seatrial-cli --all-targets --features ros2,ros2-zenoh -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli --features ros2 -- -D warnings",
        "clippy -p seatrial-links -p seatrial-cli --features ros2-zenoh -- -D warnings",
        "nextest run --test-threads 1 --features ros2-zenoh -p seatrial-links --lib ros2_vehicle",
        "nextest run --test-threads 1 --features ros2,ros2-zenoh -p seatrial-cli -E test(/^ros2/)",
    ] {
        cargo(command)?.run()?;
    }
    Ok(())
}

/// Whole trials on a vehicle that is a node of ROS 2 Jazzy; not part of `test --all`, for the size of ROS 2.
fn on_ros2_itself() -> Result<()> {
    let python = python::OF_JAZZY.program("python")?;
    let tests = "nextest run -p seatrial-cli --features ros2 --test-threads 1 --run-ignored only -E test(/^ros2::jazzy/) --no-capture";
    cargo(tests)?.env("SEATRIAL_PYTHON", python).run()
}

/// Cargo or cargo-nextest with the words of a command, between blanks.
fn cargo(words: &str) -> Result<Command> {
    let (mut command, words) = match words.strip_prefix("nextest ") {
        Some(rest) => (nextest::nextest()?, rest),
        None => (command!("cargo"), words),
    };
    command.args(words.split_whitespace());
    Ok(command)
}
