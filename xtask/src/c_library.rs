//! The library for C: the examples are compiled as strict C99 and run here and on a Cortex-M4F, against the parity vectors.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::embedded::{BOARDS, Board, PLAIN, run_on};
use crate::shell::{Run, command, empty_folder, has, shell};
use crate::steps::missing;
use crate::toolchain::CORTEX_M;
use crate::workspace::{in_target, root};

/// Words for compilers: of code that warns of nothing; of an image for a Cortex-M4F, and of its linker.
const STRICT: &str = "-std=c99 -Wall -Wextra -Werror -pedantic -O2";
const M4F: &str = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16";
const M4F_LINKER: &str = "firmware/c/startup.c --specs=rdimon.specs -Wl,--gc-sections -Wl,--no-warn-execstack -lm -T firmware/c/mps2.ld";
const HOST_LINKER: &str = "-lpthread -ldl -lm";
/// Every access to memory and every undefined operation of the C code is checked.
const SANITIZERS: &str = "-g -fsanitize=address,undefined -fno-sanitize-recover=all";
const LIBRARY: &str = "crates/seatrial-ffi";

/// Printed by the loop once its trial has found the vehicle, a22 = -1.07 1/s; its plant takes 50 plain steps an interval.
pub const LOOP_FOUND: &str = "thrust 0.9: a22 -1.06";

/// What programs with one kind of object, or with everything, bring into an image, in f32 and f64, libm and software floating point
/// included: what was measured and 10 %.
const PROGRAMS: [(&str, &[&str], [u64; 2]); 4] = [
    ("the lean estimator", &["seatrial_fixed_rate_"], [4700, 14_700]),
    ("the guarded estimator", &["seatrial_estimator_"], [16_200, 25_900]),
    ("the trial", &["seatrial_trial_", "seatrial_plan"], [46_000, 58_200]),
    ("everything", &["seatrial_"], [51_700, 72_900]),
];

/// The width of SeatrialNumber, and what asks the library and the compiler of C for it.
struct Precision {
    name: &'static str,
    feature: &'static str,
    define: Option<&'static str>,
}

const DOUBLE: Precision = Precision { name: "f64", feature: "", define: None };
const SINGLE: Precision =
    Precision { name: "f32", feature: "single", define: Some("-DSEATRIAL_SINGLE") };

/// A table of parity vectors that C computes: its name, its type, its file.
type Table = (String, String, PathBuf);

/// Compiles and runs the examples everywhere; `vectors` is what the generator prints.
pub fn check(vectors: &str) -> Result<()> {
    let tables = write_tables(vectors)?;
    command!("cargo build --quiet --release -p seatrial-ffi").run()?;
    let folder = in_target("release");
    let library = folder.join("libseatrial_ffi.a").display().to_string();
    let [rpath, from] = ["-Wl,-rpath,", "-L"].map(|option| format!("{option}{}", folder.display()));
    let shared = [rpath.as_str(), &from, "-lseatrial_ffi"];
    for (kind, words, library) in [
        ("static", "", &[library.as_str()][..]),
        ("shared", "", &shared),
        ("sanitized", SANITIZERS, &[&library]),
    ] {
        let options = words.split_whitespace().chain(library.iter().copied());
        let options: Vec<&str> = options.chain(HOST_LINKER.split(' ')).collect();
        examples(&tables, &DOUBLE, (kind, None), &options)?;
    }
    does_not_link_for_other_numbers(&library)?;
    for (width, precision) in [&SINGLE, &DOUBLE].into_iter().enumerate() {
        let library = build_for_m4f(precision)?.display().to_string();
        for (program, prefixes, limits) in PROGRAMS {
            let (bytes, limit) = (code_bytes(prefixes, &library)?, limits[width]);
            eprintln!("C code, {}, {program}: {bytes} bytes", precision.name);
            ensure!(bytes <= limit, "{program}: more than {limit} bytes of code");
        }
        let options = M4F.split(' ').chain([library.as_str()]).chain(M4F_LINKER.split(' '));
        let options: Vec<&str> = options.chain(precision.define).collect();
        let board = &BOARDS[0];
        examples(&tables, precision, (board.name, Some(board)), &options)?;
    }
    is_found_when_installed(&folder)
}

/// Compiles both examples and runs them here or on a board: `parity` on every table of a precision, and the loop, which finds its vehicle.
fn examples(
    tables: &[Table],
    precision: &Precision,
    (place, board): (&str, Option<&Board>),
    options: &[&str],
) -> Result<()> {
    let gcc = board.map_or("gcc", |_| "arm-none-eabi-gcc");
    let (width, folder) = (precision.name, in_target("firmware"));
    let [parity, trial] =
        ["parity", "loop_20hz"].map(|example| folder.join(format!("{example}-{place}-{width}")));
    compiler(gcc, "parity", &parity).args(options).run()?;
    compiler(gcc, "loop_20hz", &trial).args(options).run()?;
    let run = |program: &Path, words: &[&str]| match board {
        Some(board) => {
            let words = words.iter().map(|word| format!(",arg={word}"));
            run_on(board, program, &format!("{PLAIN}{}", words.collect::<String>()), &[])
        }
        None => Command::new(program).args(words.iter().skip(1)).read(),
    };
    for (table, _, file) in tables.iter().filter(|(_, of, _)| of == width) {
        let said = run(&parity, &["parity", table, &file.to_string_lossy()])?;
        eprintln!("C ({place}, {width}): {}", said.trim_end());
    }
    finds_its_vehicle(&run(&trial, &[])?)
}

/// Fails where the loop says that it has found another vehicle.
pub fn finds_its_vehicle(said: &str) -> Result<()> {
    ensure!(said.contains(LOOP_FOUND), "loop_20hz.c did not find its vehicle:\n{said}");
    Ok(())
}

/// A project of CMake that finds the installed library.
const PROJECT: &str = "\
cmake_minimum_required(VERSION 3.16)
project(loop LANGUAGES C)
find_package(seatrial ${VERSION} REQUIRED)
add_executable(loop ${EXAMPLE})
target_link_libraries(loop PRIVATE seatrial::seatrial)
";

/// The library, installed by CMake, is found by CMake and by pkg-config; `built` is the folder of the one that is there.
fn is_found_when_installed(built: &Path) -> Result<()> {
    for tool in ["cmake", "pkg-config"] {
        if !has(tool) {
            return missing(format!(
                "{tool} is missing, with which the library for C is installed"
            ));
        }
    }
    let folder = in_target("firmware/cmake");
    empty_folder(&folder)?;
    let [build, prefix, project, own] =
        ["build", "prefix", "project", "own"].map(|part| folder.join(part));
    shell().write_file(project.join("CMakeLists.txt"), PROJECT)?;
    let (cargo_folder, version) = (built.parent().unwrap_or(built), env!("CARGO_PKG_VERSION"));
    let example = root().join(LIBRARY).join("examples/loop_20hz.c");
    command!("cmake -S {LIBRARY} -B {build} -DSEATRIAL_CARGO_FOLDER={cargo_folder} -DCMAKE_INSTALL_PREFIX={prefix} -DCMAKE_INSTALL_LIBDIR=lib").read()?;
    command!("cmake --build {build}").read()?;
    command!("cmake --install {build}").read()?;
    command!("cmake -S {project} -B {own} -DCMAKE_PREFIX_PATH={prefix} -DVERSION={version} -DEXAMPLE={example}").read()?;
    command!("cmake --build {own}").read()?;
    finds_its_vehicle(&Command::new(own.join("loop")).read()?)?;

    let mut package = command!("pkg-config --cflags --libs seatrial");
    let said = package.env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")).read()?;
    let (program, words) = (folder.join("loop"), said.split_whitespace());
    let strict = STRICT.split(' ');
    command!("gcc {strict...} {example} {words...} -o {program}").run()?;
    finds_its_vehicle(&Command::new(program).read()?)?;
    eprintln!("C: the installed library is found by CMake and by pkg-config");
    Ok(())
}

/// A program that was compiled for `float` must not link with the library of `double`: its structures are of other sizes.
fn does_not_link_for_other_numbers(double: &str) -> Result<()> {
    let mut gcc = compiler("gcc", "loop_20hz", &in_target("firmware/loop_20hz-mixed"));
    let output = gcc.args(SINGLE.define).arg(double).args(HOST_LINKER.split(' ')).outcome()?;
    let printed = String::from_utf8_lossy(&output.stderr);
    let is_told = printed.contains("seatrial_trial_new_abi1_single");
    ensure!(
        !output.status.success() && is_told,
        "a program for float links with the library of double, or fails for another reason:\n{printed}"
    );
    eprintln!("C: a program for float does not link with the library of double");
    Ok(())
}

/// One file for every table and type that C computes.
fn write_tables(vectors: &str) -> Result<Vec<Table>> {
    let of_c = |table: &&str| !table.is_empty() && !table.starts_with("refined");
    let tables = vectors.split("# ").filter(of_c).map(|table| {
        let (title, rows) = table.split_once('\n').context("a table without rows")?;
        let (name, precision) = title.split_once(' ').context("a table without a type")?;
        let file = in_target(format!("firmware/vectors/{name}.{precision}.csv"));
        shell().write_file(&file, rows)?;
        Ok((name.to_owned(), precision.to_owned(), file))
    });
    tables.collect()
}

/// The static library.
fn build_for_m4f(precision: &Precision) -> Result<PathBuf> {
    let folder = in_target("firmware").join(precision.name);
    let feature = precision.feature;
    command!("cargo rustc --quiet -p seatrial-ffi --profile embedded --no-default-features --features={feature} --crate-type staticlib --target {CORTEX_M} --target-dir {folder}").run()?;
    Ok(folder.join(CORTEX_M).join("embedded/libseatrial_ffi.a"))
}

/// What the functions of the header with these prefixes bring into an image: all that the linker does not throw away. With a panic path among
/// it there is no image.
fn code_bytes(prefixes: &[&str], library: &str) -> Result<u64> {
    let header = shell().read_file(format!("{LIBRARY}/include/seatrial.h"))?;
    let declared = header.lines().filter_map(|line| {
        let name = line.split_once('(')?.0.rsplit([' ', '*']).next()?;
        let wanted = prefixes.iter().any(|prefix| name.starts_with(prefix));
        wanted.then(|| format!("-Wl,--undefined={name}"))
    });
    let image = in_target("firmware/code");
    let m4f = M4F.split(' ');
    command!("arm-none-eabi-gcc {m4f...} -nostdlib -Wl,--gc-sections -Wl,--entry=seatrial_status_text {declared...} {library} -lgcc -o {image}").run()?;
    let table = command!("arm-none-eabi-size {image}").read()?;
    let row = table.lines().nth(1).and_then(|row| row.split_whitespace().next());
    Ok(row.context("arm-none-eabi-size prints no row")?.parse()?)
}

/// A compiler that makes a program of an example.
fn compiler(name: &str, example: &str, program: &Path) -> Command {
    let strict = STRICT.split(' ');
    command!("{name} {strict...} -I {LIBRARY}/include {LIBRARY}/examples/{example}.c -o {program}")
}
