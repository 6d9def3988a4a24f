//! The library for C: the examples are compiled as strict C99 and run here and on a Cortex-M4F, against the parity vectors.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::embedded::{BOARDS, Checked, TARGET, root, run_on};
use crate::{cargo, succeeds};

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
const LOOP_FOUND: &str = "thrust 0.9: a22 -1.06";

/// Functions that a program with one kind of object calls, and the code that they may bring with them in f32 and f64, libm and
/// software floating point included: what was measured and 10 %.
const PROGRAMS: [(&str, &[&str], [u64; 2]); 3] = [
    (
        "fixed_rate",
        &["settings", "new", "settle", "update", "restart", "model"],
        [3500, 11_500],
    ),
    (
        "estimator",
        &[
            "settings",
            "new",
            "warm",
            "update",
            "excitation_ended",
            "restart",
            "estimate",
        ],
        [15_300, 27_200],
    ),
    (
        "trial",
        &["new", "step", "status", "take_result", "abort"],
        [52_500, 72_200],
    ),
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
    let host = build_library(&DOUBLE, "host", &["--crate-type", "staticlib,cdylib"])?;
    let folder = folder(&host)?;
    let rpath = format!("-Wl,-rpath,{}", folder.display());
    let shared = [
        rpath.as_ref(),
        "-L",
        &folder.to_string_lossy(),
        "-lseatrial_ffi",
    ]
    .map(String::from);
    let archive = [host.with_extension("a").to_string_lossy().into_owned()];
    for (kind, library) in [("static", &archive[..]), ("shared", &shared[..])] {
        let program = |example: &str| compile_for_host(example, kind, library);
        let (parity, trial) = (program("parity")?, program("loop_20hz")?);
        for (table, file) in of_precision(&tables, &DOUBLE) {
            report(kind, &output(Command::new(&parity).arg(table).arg(file))?);
        }
        found_its_vehicle(&output(&mut Command::new(&trial))?)?;
    }
    for (width, precision) in [&SINGLE, &DOUBLE].into_iter().enumerate() {
        let bare = [
            "--no-default-features",
            "--target",
            TARGET,
            "--crate-type",
            "staticlib",
        ];
        let library = build_library(precision, "cortex-m4f", &bare)?;
        for (object, functions, limits) in PROGRAMS {
            let bytes = code_bytes(object, functions, &library)?;
            eprintln!("C code, {}, {object}: {bytes} bytes", precision.name);
            if bytes > limits[width] {
                return Err(format!(
                    "{object}: {bytes} bytes of code, at most {}",
                    limits[width]
                ));
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

/// One file for every table and type: name of the table, name of the type, file.
fn write_tables(vectors: &str) -> Result<Vec<(String, String, PathBuf)>, String> {
    let folder = root().join("target/firmware/vectors");
    fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    let mut tables = Vec::new();
    for table in vectors.split("# ").filter(|table| !table.is_empty()) {
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

/// Builds the library; the path of it without the extension's meaning.
fn build_library(precision: &Precision, place: &str, options: &[&str]) -> Result<PathBuf, String> {
    let folder = root()
        .join("target/firmware")
        .join(format!("{place}-{}", precision.name));
    let mut command = cargo(&["rustc", "--quiet", "-p", "seatrial-ffi"]);
    command
        .args(["--profile", "embedded"])
        .args(precision.features);
    command.args(options).arg("--target-dir").arg(&folder);
    if !succeeds(&mut command) {
        return Err(format!(
            "seatrial-ffi does not build: {place}, {}",
            precision.name
        ));
    }
    let built = if options.contains(&TARGET) {
        folder.join(TARGET)
    } else {
        folder
    };
    Ok(built.join("embedded/libseatrial_ffi.a"))
}

fn folder(library: &Path) -> Result<PathBuf, String> {
    let folder = library.parent().ok_or("a library without a folder")?;
    folder.canonicalize().map_err(|error| error.to_string())
}

fn compile_for_host(example: &str, kind: &str, library: &[String]) -> Result<PathBuf, String> {
    let program = root().join(format!("target/firmware/{example}-{kind}"));
    let mut gcc = compiler("gcc", example, &program);
    gcc.args(library).args(HOST_LIBRARIES);
    compiled(gcc, program)
}

fn compile_for_m4f(
    example: &str,
    precision: &Precision,
    library: &Path,
) -> Result<PathBuf, String> {
    let program = root().join(format!("target/firmware/{example}-m4f-{}", precision.name));
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

/// What these functions bring into an image: everything that the linker does not throw away.
fn code_bytes(object: &str, functions: &[&str], library: &Path) -> Result<u64, String> {
    let image = root().join("target/firmware").join(object);
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(M4F).args(["-nostdlib", "-Wl,--gc-sections"]);
    gcc.arg(format!("-Wl,--entry=seatrial_{object}_new"));
    for function in functions {
        gcc.arg(format!("-Wl,--undefined=seatrial_{object}_{function}"));
    }
    if object == "trial" {
        gcc.arg("-Wl,--undefined=seatrial_plan");
    }
    gcc.arg(library).args(["-lgcc", "-o"]).arg(&image);
    let image = compiled(gcc, image)?;
    let table = output(Command::new("arm-none-eabi-size").arg(image))?;
    let bytes = table
        .lines()
        .nth(1)
        .and_then(|row| row.split_whitespace().next()?.parse().ok());
    bytes.ok_or_else(|| format!("arm-none-eabi-size: {table}"))
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
