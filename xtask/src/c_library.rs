//! The library for C: the examples are compiled as strict C99 and run here and on a Cortex-M4F, against the parity vectors.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cargo;
use crate::embedded::{BOARDS, Checked, run_on};
use crate::steps::{run, skipped, succeeds};
use crate::target::{in_target, root};
use crate::toolchain::CORTEX_M;

const STRICT: [&str; 6] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-pedantic",
    "-O2",
];
const HOST_LIBRARIES: [&str; 3] = ["-lpthread", "-ldl", "-lm"];
const M4F: [&str; 4] = [
    "-mcpu=cortex-m4",
    "-mthumb",
    "-mfloat-abi=hard",
    "-mfpu=fpv4-sp-d16",
];

/// Printed by the loop once its trial has found the vehicle, a22 = -1.07 1/s; its plant takes 50 plain steps an interval.
pub const LOOP_FOUND: &str = "thrust 0.9: a22 -1.06";

/// What programs with one kind of object, or with everything, bring into an image, in f32 and f64, libm and software floating point
/// included: what was measured and 10 %.
const PROGRAMS: [(&str, &[&str], [u64; 2]); 4] = [
    (
        "the lean estimator",
        &["seatrial_fixed_rate_"],
        [4700, 14_700],
    ),
    (
        "the guarded estimator",
        &["seatrial_estimator_"],
        [16_200, 25_900],
    ),
    (
        "the trial",
        &["seatrial_trial_", "seatrial_plan"],
        [46_000, 58_200],
    ),
    ("everything", &["seatrial_"], [51_700, 72_900]),
];

/// The width of SeatrialNumber.
struct Precision {
    name: &'static str,
    features: &'static [&'static str],
    defines: &'static [&'static str],
}

const DOUBLE: Precision = Precision {
    name: "f64",
    features: &[],
    defines: &[],
};
const SINGLE: Precision = Precision {
    name: "f32",
    features: &["--features", "single"],
    defines: &["-DSEATRIAL_SINGLE"],
};

/// Compiles and runs the examples everywhere; `vectors` is what the generator prints.
pub fn check(vectors: &str) -> Checked {
    let tables = write_tables(vectors)?;
    let folder = build_for_host()?;
    let rpath = format!("-Wl,-rpath,{}", folder.display());
    let shared = [
        rpath.as_ref(),
        "-L",
        &folder.to_string_lossy(),
        "-lseatrial_ffi",
    ]
    .map(String::from);
    let archive = [folder
        .join("libseatrial_ffi.a")
        .to_string_lossy()
        .into_owned()];
    for (kind, library) in [("static", &archive[..]), ("shared", &shared[..])] {
        let program = |example: &str| compile_for_host(example, kind, library);
        let (parity, trial) = (program("parity")?, program("loop_20hz")?);
        for (table, file) in of_precision(&tables, &DOUBLE) {
            report(kind, &output(Command::new(&parity).arg(table).arg(file))?);
        }
        found_its_vehicle(&output(&mut Command::new(&trial))?)?;
    }
    installed(&folder)?;
    does_not_link_for_other_numbers(&archive)?;
    sanitized(&tables, &archive)?;
    for (width, precision) in [&SINGLE, &DOUBLE].into_iter().enumerate() {
        let library = build_for_m4f(precision)?;
        for (program, prefixes, limits) in PROGRAMS {
            let bytes = code_bytes(prefixes, &library)?;
            eprintln!("C code, {}, {program}: {bytes} bytes", precision.name);
            let limit = limits[width];
            if bytes > limit {
                return Err(format!("{program}: {bytes} bytes of code, at most {limit}"));
            }
        }
        let parity = compile_for_m4f("parity", precision, &library)?;
        for (table, file) in of_precision(&tables, precision) {
            let arguments = format!(
                "enable=on,target=native,arg=parity,arg={table},arg={}",
                file.display()
            );
            let text = run_on(&BOARDS[0], &parity, &["-semihosting-config", &arguments])?;
            report(&format!("{}, {}", BOARDS[0].name, precision.name), &text);
        }
        let trial = compile_for_m4f("loop_20hz", precision, &library)?;
        let plain = ["-semihosting-config", "enable=on,target=native"];
        found_its_vehicle(&run_on(&BOARDS[0], &trial, &plain)?)?;
    }
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
fn installed(built: &Path) -> Checked {
    for tool in ["cmake", "pkg-config"] {
        if Command::new(tool).arg("--version").output().is_err() {
            return skipped("the installed library for C", &format!("{tool} is missing"));
        }
    }
    let folder = in_target("firmware/cmake");
    let _ = fs::remove_dir_all(&folder);
    let [build, prefix, project] = ["build", "prefix", "project"].map(|part| folder.join(part));
    fs::create_dir_all(&project).map_err(|error| error.to_string())?;
    fs::write(project.join("CMakeLists.txt"), PROJECT).map_err(|error| error.to_string())?;
    let library = root().join("crates/seatrial-ffi");
    let example = library.join("examples/loop_20hz.c");
    let cmake = |arguments: &[String]| output(Command::new("cmake").args(arguments)).map(drop);
    let option = |name: &str, path: &Path| format!("-D{name}={}", path.display());
    let [from, into] = ["-S", "-B"].map(String::from);
    let text = |path: &Path| path.display().to_string();
    let cargo_folder = option("SEATRIAL_CARGO_FOLDER", built.parent().unwrap_or(built));
    let place = option("CMAKE_INSTALL_PREFIX", &prefix);
    cmake(&[
        from.clone(),
        text(&library),
        into.clone(),
        text(&build),
        cargo_folder,
        place,
        "-DCMAKE_INSTALL_LIBDIR=lib".into(),
    ])?;
    cmake(&["--build".into(), text(&build)])?;
    cmake(&["--install".into(), text(&build)])?;
    let own = project.join("build");
    let found = option("CMAKE_PREFIX_PATH", &prefix);
    let version = format!("-DVERSION={}", env!("CARGO_PKG_VERSION"));
    cmake(&[
        from,
        text(&project),
        into,
        text(&own),
        found,
        version,
        option("EXAMPLE", &example),
    ])?;
    cmake(&["--build".into(), text(&own)])?;
    found_its_vehicle(&output(&mut Command::new(own.join("loop")))?)?;

    let folders = prefix.join("lib/pkgconfig");
    let mut said = Command::new("pkg-config");
    said.args(["--cflags", "--libs", "seatrial"])
        .env("PKG_CONFIG_PATH", folders);
    let said = output(&mut said)?;
    let program = in_target("firmware/loop_20hz-pkg-config");
    let mut gcc = Command::new("gcc");
    gcc.args(STRICT).arg(&example).args(said.split_whitespace());
    gcc.arg("-o").arg(&program);
    let program = compiled(gcc, program)?;
    found_its_vehicle(&output(&mut Command::new(&program))?)?;
    eprintln!("C: the installed library is found by CMake and by pkg-config");
    Ok(())
}

/// A program that was compiled for `float` must not link with the library of `double`: its structures are of other sizes.
fn does_not_link_for_other_numbers(double: &[String]) -> Checked {
    let program = in_target("firmware/loop_20hz-mixed");
    let mut gcc = compiler("gcc", "loop_20hz", &program);
    gcc.args(SINGLE.defines).args(double).args(HOST_LIBRARIES);
    let output = gcc.output().map_err(|error| error.to_string())?;
    let printed = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() && printed.contains("seatrial_trial_new_abi1_single") {
        eprintln!("C: a program for float does not link with the library of double");
        return Ok(());
    }
    Err(format!(
        "a program for float links with the library of double, or fails for another reason:\n{printed}"
    ))
}

/// The examples once more, with every access to memory and every undefined operation of the C code checked.
fn sanitized(tables: &[(String, String, PathBuf)], archive: &[String]) -> Checked {
    let program = |example: &str| {
        let program = in_target(format!("firmware/{example}-sanitized"));
        let mut gcc = compiler("gcc", example, &program);
        gcc.args([
            "-g",
            "-fsanitize=address,undefined",
            "-fno-sanitize-recover=all",
        ]);
        gcc.args(archive).args(HOST_LIBRARIES);
        compiled(gcc, program)
    };
    let (parity, trial) = (program("parity")?, program("loop_20hz")?);
    for (table, file) in of_precision(tables, &DOUBLE) {
        report(
            "sanitized",
            &output(Command::new(&parity).arg(table).arg(file))?,
        );
    }
    found_its_vehicle(&output(&mut Command::new(&trial))?)
}

/// One file for every table and type that C computes: name of the table, name of the type, file.
fn write_tables(vectors: &str) -> Result<Vec<(String, String, PathBuf)>, String> {
    let folder = in_target("firmware/vectors");
    fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let mut tables = Vec::new();
    let of_c = |table: &&str| !table.is_empty() && !table.starts_with("refined");
    for table in vectors.split("# ").filter(of_c) {
        let (title, rows) = table.split_once('\n').ok_or("a table without rows")?;
        let (name, precision) = title.split_once(' ').ok_or("a table without a type")?;
        let file = folder.join(format!("{name}.{precision}.csv"));
        fs::write(&file, rows).map_err(|error| format!("{}: {error}", file.display()))?;
        tables.push((name.to_owned(), precision.to_owned(), file));
    }
    Ok(tables)
}

fn of_precision<'a>(
    tables: &'a [(String, String, PathBuf)],
    precision: &Precision,
) -> impl Iterator<Item = (&'a str, &'a Path)> {
    tables
        .iter()
        .filter(|(_, of, _)| of == precision.name)
        .map(|(name, _, file)| (name.as_str(), file.as_path()))
}

/// The folder with the static and the shared library.
fn build_for_host() -> Result<PathBuf, String> {
    run(
        &mut cargo(&["build", "--quiet", "--release", "-p", "seatrial-ffi"]),
        "seatrial-ffi does not build for this machine",
    )?;
    let folder = in_target("release");
    folder.canonicalize().map_err(|error| error.to_string())
}

/// The static library.
fn build_for_m4f(precision: &Precision) -> Result<PathBuf, String> {
    let folder = in_target("firmware").join(precision.name);
    let mut command = cargo(&["rustc", "--quiet", "-p", "seatrial-ffi"]);
    command.args(["--profile", "embedded", "--no-default-features"]);
    command.args(precision.features);
    command.args(["--crate-type", "staticlib", "--target", CORTEX_M]);
    command.arg("--target-dir").arg(&folder);
    if succeeds(&mut command) {
        Ok(folder.join(CORTEX_M).join("embedded/libseatrial_ffi.a"))
    } else {
        Err(format!(
            "seatrial-ffi does not build for {CORTEX_M}, {}",
            precision.name
        ))
    }
}

fn compile_for_host(example: &str, kind: &str, library: &[String]) -> Result<PathBuf, String> {
    let program = in_target(format!("firmware/{example}-{kind}"));
    let mut gcc = compiler("gcc", example, &program);
    gcc.args(library).args(HOST_LIBRARIES);
    compiled(gcc, program)
}

fn compile_for_m4f(
    example: &str,
    precision: &Precision,
    library: &Path,
) -> Result<PathBuf, String> {
    let program = in_target(format!("firmware/{example}-m4f-{}", precision.name));
    let startup = root().join("firmware/c");
    let mut gcc = compiler("arm-none-eabi-gcc", example, &program);
    gcc.args(M4F).args(precision.defines);
    gcc.arg(startup.join("startup.c")).arg(library);
    gcc.args([
        "--specs=rdimon.specs",
        "-Wl,--gc-sections",
        "-Wl,--no-warn-execstack",
        "-lm",
    ]);
    gcc.arg("-T").arg(startup.join("mps2.ld"));
    compiled(gcc, program)
}

/// What the functions of the header with these prefixes bring into an image: all that the linker does not throw away. With a panic path among
/// it there is no image.
fn code_bytes(prefixes: &[&str], library: &Path) -> Result<u64, String> {
    let header = root().join("crates/seatrial-ffi/include/seatrial.h");
    let header = fs::read_to_string(&header).map_err(|error| format!("seatrial.h: {error}"))?;
    let declared = header.lines().filter_map(|line| {
        let name = line.split_once('(')?.0.rsplit([' ', '*']).next()?;
        let wanted = prefixes.iter().any(|prefix| name.starts_with(prefix));
        wanted.then(|| format!("-Wl,--undefined={name}"))
    });
    let image = in_target("firmware/code");
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(M4F).args([
        "-nostdlib",
        "-Wl,--gc-sections",
        "-Wl,--entry=seatrial_status_text",
    ]);
    gcc.args(declared)
        .arg(library)
        .args(["-lgcc", "-o"])
        .arg(&image);
    let image = compiled(gcc, image)?;
    let table = output(Command::new("arm-none-eabi-size").arg(image))?;
    let row = table
        .lines()
        .nth(1)
        .and_then(|row| row.split_whitespace().next());
    row.and_then(|text| text.parse().ok())
        .ok_or_else(|| format!("arm-none-eabi-size: {table}"))
}

fn compiler(name: &str, example: &str, program: &Path) -> Command {
    let library = root().join("crates/seatrial-ffi");
    let mut gcc = Command::new(name);
    gcc.args(STRICT).arg("-I").arg(library.join("include"));
    gcc.arg(library.join("examples").join(example).with_extension("c"));
    gcc.arg("-o").arg(program);
    gcc
}

fn compiled(mut gcc: Command, program: PathBuf) -> Result<PathBuf, String> {
    if succeeds(&mut gcc) {
        Ok(program)
    } else {
        Err(format!("{} does not compile", program.display()))
    }
}

fn output(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("{command:?}: {}\n{text}", output.status))
    }
}

fn report(place: &str, text: &str) {
    eprintln!("C ({place}): {}", text.trim_end());
}

fn found_its_vehicle(text: &str) -> Checked {
    if text.contains(LOOP_FOUND) {
        Ok(())
    } else {
        Err(format!("loop_20hz.c did not find its vehicle:\n{text}"))
    }
}
