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
use steps::{passes, side_by_side, skipped, succeeds};
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

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let passed = match arguments.as_slice() {
        ["test"] => test(fast),
        ["test", "--all"] => test(everything),
        ["beside"] => beside_the_tests(),
        ["house"] => in_order(false),
        ["house", "--list"] => in_order(true),
        ["embedded"] => on_microcontrollers(),
        ["python"] => in_python() && python_is_fast(),
        ["dash"] => in_dash(),
        ["ros2"] => on_ros2(),
        ["ros2-jazzy"] => on_ros2_itself(),
        ["miri"] => in_miri(),
        ["instructions"] => in_few_instructions(),
        ["web"] => in_browser(),
        ["page"] => without_a_server(),
        ["page", "--measure"] => beside_the_terminal(),
        ["docs"] => tests_have_python() && as_a_site(),
        ["extending"] => outside_the_workspace(),
        ["foxglove-loader"] => in_foxglove(),
        ["oldest"] => on_old_compilers(),
        ["packages"] => on_crates_io(false),
        ["packages", "--build"] => on_crates_io(true),
        ["wheel"] => in_a_wheel(None),
        ["wheel", target] => in_a_wheel(Some(target)),
        ["archive"] => in_an_archive(None),
        ["container"] => in_a_container(),
        ["windows"] => on_windows(),
        ["archive", target] => in_an_archive(Some(target)),
        ["same-answers", rest @ ..] => return same_answers::run(rest),
        _ => {
            eprintln!(
                "usage: cargo xtask test [--all]|house [--list]|embedded|python|dash|ros2|ros2-jazzy|miri|instructions|web|page [--measure]|docs|extending|foxglove-loader|oldest|packages [--build]|wheel [TARGET]|archive [TARGET]|container|windows|same-answers"
            );
            return ExitCode::from(2);
        }
    };
    match passed {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

fn test(checks: fn() -> bool) -> bool {
    let begin = Instant::now();
    let passed = in_order(false) && passes("the toolchain", toolchain::prepare) && checks();
    if passed {
        eprintln!("== all passed in {:.0} s", begin.elapsed().as_secs_f64());
    }
    passed
}

/// What every change needs.
fn fast() -> bool {
    with_cargo(&CHECKS, &[])
}

fn everything() -> bool {
    let beside = match Beside::begin() {
        Ok(beside) => beside,
        Err(message) => {
            eprintln!("xtask: {message}");
            return false;
        }
    };
    let passed = tests_have_python()
        && with_cargo(&CHECKS, &["--features", ROS2])
        && over_ros2()
        && side_by_side(&[
            &[in_python, in_dash],
            &[in_browser, without_a_server, as_a_site],
        ]);
    if !passed {
        beside.end();
        return false;
    }
    // What is measured is not disturbed.
    beside.passed() && python_is_fast()
}

/// What is built apart from the workspace's tests.
fn beside_the_tests() -> bool {
    beside::end_with_the_other();
    side_by_side(&[
        &[
            tools_are_there,
            in_few_instructions,
            on_microcontrollers,
            on_old_compilers,
            package_for_python,
        ],
        &[
            program_for_a_browser,
            outside_the_workspace,
            logs_in_foxglove,
        ],
    ])
}

/// Fetches what later checks need; one that cannot be had is told by the check that needs it.
fn tools_are_there() -> bool {
    passes("tools", || {
        python::prepare();
        dash::prepare();
        page::prepare();
        Ok(())
    })
}

/// Ends with the tests that were skipped for want of data or tools.
fn with_cargo(checks: &[(&str, &str)], ros2: &[&str]) -> bool {
    let skipped_tests = in_target("skipped-tests.txt");
    let _ = std::fs::remove_file(&skipped_tests);
    let passed = checks.iter().all(|(name, command)| {
        let arguments: Vec<&str> = command
            .split(' ')
            .flat_map(|word| {
                if word == "ROS2" {
                    ros2.to_vec()
                } else {
                    vec![word]
                }
            })
            .collect();
        passes(name, || {
            if *name == CORE && !toolchain::has_library(toolchain::CORTEX_M) {
                return skipped(CORE, &toolchain::no_library(toolchain::CORTEX_M));
            }
            let mut command_line = cargo_or_nextest(&arguments)?;
            command_line.env("RUSTDOCFLAGS", "-D warnings");
            command_line.env("SEATRIAL_SKIPPED", &skipped_tests);
            succeeds(&mut command_line)
                .then_some(())
                .ok_or(format!("cargo {}", arguments.join(" ")))
        })
    });
    if let Ok(list) = std::fs::read_to_string(&skipped_tests) {
        eprint!("{list}");
    }
    passed
}

fn tests_have_python() -> bool {
    passes("Python for the tests", python::prepare_tests)
}

fn on_microcontrollers() -> bool {
    passes("microcontrollers", || match embedded::check()? {
        Some(vectors) => c_library::check(&vectors),
        None => Ok(()),
    })
}

fn in_order(list: bool) -> bool {
    passes("the plan of the house", || house::check(list))
}

fn in_few_instructions() -> bool {
    passes("instructions", instructions::check)
}

fn in_python() -> bool {
    passes("Python", python::check)
}

fn python_is_fast() -> bool {
    passes("Python beside scipy", python::is_fast)
}

/// Whole trials on vehicles of other processes, from the tests that are built. They are played in real time, which they
/// mostly wait for: one that the machine holds up for long is a lost one, which is tried again.
fn over_ros2() -> bool {
    passes("vehicles over ROS 2", || {
        let command = [
            "nextest",
            "run",
            "--workspace",
            "--features",
            ROS2,
            "--test-threads",
            "3",
        ];
        let rest = ["--retries", "2", "-E", "test(/^ros2::/)"];
        let mut tests = cargo_or_nextest(&[&command[..], &rest].concat())?;
        succeeds(&mut tests)
            .then_some(())
            .ok_or("vehicles over DDS or zenoh".into())
    })
}

fn on_ros2() -> bool {
    let of_features = |verb: &[&str], features: &str, rest: &[&str]| {
        let arguments = [verb, &["--features", features], rest].concat();
        cargo_or_nextest(&arguments).is_ok_and(|mut command| succeeds(&mut command))
    };
    let lint = ["clippy", "-p", "seatrial-links", "-p", "seatrial-cli"];
    let strict = ["--", "-D", "warnings"];
    let test = ["nextest", "run", "--test-threads", "1"];
    passes("ROS 2", || {
        python::prepare_tests()?;
        let both = "ros2,ros2-zenoh";
        // One test at a time: the vehicles are played in real time, and one that the machine holds up for long is a lost one.
        let is_right = of_features(&[&lint[..], &["--all-targets"]].concat(), both, &strict)
            && of_features(&lint, "", &strict)
            && of_features(&lint, "ros2", &strict)
            && of_features(&lint, "ros2-zenoh", &strict)
            && of_features(
                &test,
                "ros2-zenoh",
                &["-p", "seatrial-links", "--lib", "ros2_vehicle"],
            )
            && of_features(&test, both, &["-p", "seatrial-cli", "-E", "test(/^ros2/)"]);
        is_right
            .then_some(())
            .ok_or("vehicles over DDS or zenoh".into())
    })
}

/// Whole trials on a vehicle that is a node of ROS 2 Jazzy; not part of `test --all`, for the size of ROS 2.
fn on_ros2_itself() -> bool {
    passes("ROS 2 Jazzy", || {
        let Some(python) = python::of_jazzy() else {
            return skipped(
                "ROS 2 Jazzy",
                "python3.12 with venv, or ROS 2 in its registry, is missing",
            );
        };
        let tests = [
            "nextest",
            "run",
            "-p",
            "seatrial-cli",
            "--features",
            "ros2",
            "--test-threads",
            "1",
        ];
        let which = [
            "--run-ignored",
            "only",
            "-E",
            "test(/^ros2::jazzy/)",
            "--no-capture",
        ];
        let mut tests = cargo_or_nextest(&[&tests[..], &which].concat())?;
        match succeeds(tests.env("SEATRIAL_PYTHON", python)) {
            true => Ok(()),
            false => Err("vehicles that are nodes of ROS 2".into()),
        }
    })
}

fn on_crates_io(builds: bool) -> bool {
    passes("packages", || {
        container::check()?;
        packages::check(builds)
    })
}

fn outside_the_workspace() -> bool {
    passes("a program outside the workspace", extending::check)
}

fn logs_in_foxglove() -> bool {
    passes("logs in Foxglove", foxglove_loader::check)
}

fn in_foxglove() -> bool {
    passes(
        "the data loader for Foxglove",
        foxglove_loader::check_and_build,
    )
}

fn on_old_compilers() -> bool {
    passes("old compilers", oldest::check)
}

fn in_a_wheel(target: Option<&str>) -> bool {
    passes("the wheel", || wheel::check(target))
}

fn in_an_archive(target: Option<&str>) -> bool {
    passes("archives", || archive::check(target))
}

fn in_a_container() -> bool {
    passes("the container", container::check_at_work)
}

fn on_windows() -> bool {
    passes("Windows", windows::check)
}

fn in_miri() -> bool {
    passes("Miri", miri::check)
}

fn in_browser() -> bool {
    passes("the page", page::check)
}

fn program_for_a_browser() -> bool {
    passes("the program of the page without a server", alone::compile)
}

fn without_a_server() -> bool {
    passes("the page without a server", alone::check)
}

fn beside_the_terminal() -> bool {
    passes("the page beside the terminal", alone::measure)
}

fn as_a_site() -> bool {
    passes("the docs as a site", book::check)
}

/// Last of what runs beside the tests: its build waits for theirs.
fn package_for_python() -> bool {
    passes("the package for Python", python::build)
}

fn in_dash() -> bool {
    passes("the dashboard's interface", dash::check)
}

fn cargo_or_nextest(arguments: &[&str]) -> Result<Command, String> {
    match arguments.split_first() {
        Some((&"nextest", rest)) => nextest::command(rest),
        _ => Ok(cargo(arguments)),
    }
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).env("CARGO_TARGET_DIR", target());
    command
}
