//! The archive of the command for a release, and the Debian package: built, installed and used.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::c_library::LOOP_FOUND;
use crate::environment::NO_PYTHON;
use crate::steps::{run, skipped, succeeds};
use crate::target::{binary as built_for_tests, in_target};
use crate::toolchain::{CORTEX_M, has_library, no_library};
use crate::{run_cargo, wheel};

const OUT: &str = "archives";
/// Linked statically; built where the compiler has its standard library.
const STATIC: &str = "x86_64-unknown-linux-musl";
/// Otherwise for an old glibc.
const WITH_GLIBC: &str = "x86_64-unknown-linux-gnu";
/// A zip, built by mingw.
pub const WINDOWS: &str = "x86_64-pc-windows-gnu";
const HEADER: &str = "crates/seatrial-ffi/include/seatrial.h";
const LOOP: &str = "crates/seatrial-ffi/examples/loop_20hz.c";
/// From the archive to a report, s.
const GOAL_S: f64 = 20.0;
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Pages that go with the command.
const PAGES: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Builds both for a target, or for this machine, installs both and times the archive to a first report.
pub fn check(target: Option<&str>) -> Result<(), String> {
    if !wheel::has_tools() {
        return skipped("archives", NO_PYTHON);
    }
    let target = target.unwrap_or(if has_library(STATIC) {
        STATIC
    } else {
        WITH_GLIBC
    });
    let binary = wheel::command_for(target)?;
    let name = name_for(target);
    let folder = in_target(OUT).join(&name);
    let _ = std::fs::remove_dir_all(&folder);
    let machine = Machine::of(target);
    fill(&folder, &binary, machine)?;
    c_libraries(&folder, target)?;
    let archive = packed(&name)?;
    let package = debian_package(&folder, target)?;
    for file in [&archive, &package] {
        let bytes = std::fs::metadata(file).map_or(0, |file| file.len());
        eprintln!("== {} of {:.1} MB", file.display(), bytes as f64 / 1e6);
    }
    if machine == Machine::Absent {
        eprintln!("== {target} does not run here: built, not tried");
        return Ok(());
    }
    let seconds = first_report(&archive, &name, machine)?;
    if machine != Machine::Emulated {
        c_program_runs(&in_target(OUT).join("tried").join(&name), target)?;
    }
    eprintln!("== from the archive to a report in {seconds:.1} s, {machine}");
    installed_package_works(&package, machine)?;
    match machine == Machine::Emulated || seconds < GOAL_S {
        true => Ok(()),
        false => Err(format!(
            "a first report took {seconds:.1} s, more than {GOAL_S} s"
        )),
    }
}

/// What an archive is called, and the folder in it.
fn name_for(target: &str) -> String {
    format!("seatrial-{VERSION}-{target}")
}

/// A zip with what the archive holds, of a command that does not run here.
pub fn zipped(binary: &Path) -> Result<PathBuf, String> {
    let name = name_for(WINDOWS);
    let folder = in_target(OUT).join(&name);
    let _ = std::fs::remove_dir_all(&folder);
    fill(&folder, binary, Machine::Absent)?;
    c_libraries(&folder, WINDOWS)?;
    let zip = in_target(OUT).join(format!("{name}.zip"));
    let mut python = Command::new("python3");
    python.args(["-c", ZIP]).arg(in_target(OUT)).arg(&name);
    match succeeds(python.arg(&zip)) {
        true => Ok(zip),
        false => Err(format!("{} cannot be written", zip.display())),
    }
}

/// Files that do not differ make zips that do not differ.
const ZIP: &str = "
import sys, zipfile
from pathlib import Path
folder, name, out = sys.argv[1:]
files = sorted(path for path in (Path(folder) / name).rglob('*') if path.is_file())
with zipfile.ZipFile(out, 'w', zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
    for path in files:
        archive.writestr(zipfile.ZipInfo(str(path.relative_to(folder))), path.read_bytes(), zipfile.ZIP_DEFLATED)
";

/// What runs the command of a target here.
#[derive(Clone, Copy, PartialEq)]
enum Machine {
    /// This one, from a root in which there is nothing but the archive.
    EmptyRoot,
    /// This one, with an empty environment: it needs the C library, or a root of its own may not be had.
    Own,
    /// QEMU, whose time says nothing.
    Emulated,
    Absent,
}

/// QEMU for single programs, in the package qemu-user.
const EMULATOR: &str = "qemu-aarch64";

impl Machine {
    fn of(target: &str) -> Self {
        let is_own = target.starts_with(std::env::consts::ARCH);
        let has_roots = || quietly(Command::new("unshare").args(["--map-root-user", "true"]));
        let has_emulator = || quietly(Command::new(EMULATOR).arg("--version"));
        match is_own {
            true if target.ends_with("musl") && has_roots() => Self::EmptyRoot,
            true => Self::Own,
            false if target == "aarch64-unknown-linux-musl" && has_emulator() => Self::Emulated,
            false => Self::Absent,
        }
    }

    /// The command with nothing in its environment. `root` is the folder that it may take for the root, `at` where it is in there.
    fn command(self, root: &Path, at: &Path) -> Command {
        let program = root.join(at);
        let mut command = match self {
            Self::EmptyRoot => {
                let mut unshare = Command::new("/usr/bin/unshare");
                unshare
                    .args(["--map-root-user", "/usr/sbin/chroot"])
                    .arg(root);
                unshare.arg(Path::new("/").join(at));
                unshare
            }
            Self::Emulated => {
                let mut emulator = Command::new(Path::new("/usr/bin").join(EMULATOR));
                emulator.arg(program);
                emulator
            }
            Self::Own | Self::Absent => Command::new(program),
        };
        command.env_clear();
        command
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Self::EmptyRoot => "in a root that holds nothing else",
            Self::Own => "with an empty environment",
            Self::Emulated => "under QEMU",
            Self::Absent => "not tried",
        })
    }
}

fn quietly(command: &mut Command) -> bool {
    command.output().is_ok_and(|said| said.status.success())
}

/// The command as it runs here, which writes its own completions and pages for `man`.
fn of_any_machine(binary: &Path, machine: Machine) -> Result<Command, String> {
    if machine == Machine::Absent {
        run_cargo("build --quiet -p seatrial-cli")?;
        return Ok(Command::new(built_for_tests()));
    }
    let own = match machine {
        Machine::EmptyRoot => Machine::Own,
        other => other,
    };
    Ok(own.command(Path::new(""), binary))
}

fn fill(folder: &Path, binary: &Path, machine: Machine) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let completions = folder.join("completions");
    std::fs::create_dir_all(&completions).map_err(failed)?;
    let program = binary.file_name().unwrap_or_default();
    std::fs::copy(binary, folder.join(program)).map_err(failed)?;
    for page in PAGES {
        std::fs::copy(page, folder.join(page)).map_err(failed)?;
    }
    for (shell, file) in [
        ("bash", "seatrial.bash"),
        ("zsh", "_seatrial"),
        ("fish", "seatrial.fish"),
    ] {
        let mut command = of_any_machine(binary, machine)?;
        let said = command.args(["completions", shell]).output();
        let said = said.map_err(failed)?;
        if !said.status.success() {
            return Err(format!("seatrial completions {shell}"));
        }
        std::fs::write(completions.join(file), said.stdout).map_err(failed)?;
    }
    let mut man = of_any_machine(binary, machine)?;
    man.args(["completions", "--json", "--man"])
        .arg(folder.join("man"));
    match man.output().map_err(failed)?.status.success() {
        true => Ok(()),
        false => Err("seatrial completions --man".into()),
    }
}

/// Where the library for C of a target is in an archive.
fn c_library(folder: &Path, target: &str) -> PathBuf {
    folder.join("c").join(target).join("libseatrial_ffi.a")
}

/// Puts the library for C in, which needs no operating system: for the target in double, for a Cortex-M4F in single precision.
fn c_libraries(folder: &Path, target: &str) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    for (target, feature) in [(target, ""), (CORTEX_M, "single")] {
        if !has_library(target) {
            return skipped("the library for C", &no_library(target));
        }
        run_cargo(&format!(
            "rustc --quiet -p seatrial-ffi --profile embedded --no-default-features --features={feature} --target {target} --crate-type staticlib"
        ))?;
        let library = c_library(folder, target);
        std::fs::create_dir_all(library.parent().unwrap_or(folder)).map_err(failed)?;
        let built = in_target(target).join("embedded/libseatrial_ffi.a");
        std::fs::copy(built, library).map_err(failed)?;
    }
    std::fs::copy(HEADER, folder.join("c/seatrial.h"))
        .map(drop)
        .map_err(failed)
}

/// Compiles the example against the archive's library and runs it.
fn c_program_runs(folder: &Path, target: &str) -> Result<(), String> {
    let program = folder.join("loop_20hz");
    let mut compiler = Command::new("cc");
    compiler.arg("-std=c99").arg("-I").arg(folder.join("c"));
    compiler.arg(LOOP).arg(c_library(folder, target));
    compiler
        .args(["-Wl,--gc-sections", "-lm", "-o"])
        .arg(&program);
    if !succeeds(&mut compiler) {
        return Err(format!("{LOOP} does not compile against the archive"));
    }
    let said = Command::new(&program).output();
    let said = said.map_err(|error| error.to_string())?;
    match String::from_utf8_lossy(&said.stdout).contains(LOOP_FOUND) {
        true => Ok(()),
        false => Err(format!(
            "{LOOP} finds another vehicle with the archive's library"
        )),
    }
}

/// Files that do not differ make archives that do not differ.
fn packed(name: &str) -> Result<PathBuf, String> {
    let archive = in_target(OUT).join(format!("{name}.tar.gz"));
    let mut tar = Command::new("tar");
    tar.args("--sort=name --owner=0 --group=0 --numeric-owner --mtime=@0".split(' '))
        .args(["--use-compress-program=gzip -9n", "-cf"])
        .arg(&archive)
        .arg("-C")
        .arg(in_target(OUT))
        .arg(name);
    match succeeds(&mut tar) {
        true => Ok(archive),
        false => Err("tar".into()),
    }
}

/// Where files of the archive go.
const INSTALLED: [(&str, &str); 4] = [
    ("seatrial", "bin/seatrial"),
    (
        "completions/seatrial.bash",
        "share/bash-completion/completions/seatrial",
    ),
    (
        "completions/_seatrial",
        "share/zsh/vendor-completions/_seatrial",
    ),
    (
        "completions/seatrial.fish",
        "share/fish/vendor_completions.d/seatrial.fish",
    ),
];

fn debian_package(folder: &Path, target: &str) -> Result<PathBuf, String> {
    let architecture = match target.split('-').next() {
        Some("aarch64") => "arm64",
        _ => "amd64",
    };
    let root = in_target(OUT).join("debian");
    let _ = std::fs::remove_dir_all(&root);
    let failed = |error: std::io::Error| format!("{}: {error}", root.display());
    let put = |from: PathBuf, to: &str| {
        let to = root.join("usr").join(to);
        std::fs::create_dir_all(to.parent().unwrap_or(&root)).map_err(failed)?;
        std::fs::copy(&from, &to).map_err(failed)?;
        Ok::<PathBuf, String>(to)
    };
    for (from, to) in INSTALLED {
        put(folder.join(from), to)?;
    }
    put("packaging/copyright".into(), "share/doc/seatrial/copyright")?;
    let mut compressed = vec![put("CHANGELOG.md".into(), "share/doc/seatrial/changelog")?];
    for entry in std::fs::read_dir(folder.join("man")).map_err(failed)? {
        let page = entry.map_err(failed)?;
        let to = Path::new("share/man/man1").join(page.file_name());
        compressed.push(put(page.path(), &to.to_string_lossy())?);
    }
    run(Command::new("gzip").arg("-9n").args(&compressed), "gzip")?;
    std::fs::create_dir_all(root.join("DEBIAN")).map_err(failed)?;
    let control = control(architecture, target.ends_with("gnu"));
    std::fs::write(root.join("DEBIAN/control"), control).map_err(failed)?;
    let package = in_target(OUT).join(format!("seatrial_{VERSION}_{architecture}.deb"));
    let mut build = Command::new("dpkg-deb");
    build
        .args(["--root-owner-group", "-Zxz", "--build"])
        .arg(&root)
        .arg(&package);
    match succeeds(&mut build) {
        true => Ok(package),
        false => Err("dpkg-deb".into()),
    }
}

fn control(architecture: &str, needs_glibc: bool) -> String {
    let depends = if needs_glibc {
        "Depends: libc6 (>= 2.28)\n"
    } else {
        ""
    };
    format!(
        "Package: seatrial\nVersion: {VERSION}\nArchitecture: {architecture}\n{depends}Section: science\nPriority: optional\n\
         Maintainer: The seatrial developers <seatrial@users.noreply.github.com>\n\
         Homepage: https://github.com/seatrial/seatrial\n\
         Description: find out how a marine vehicle steers\n \
         From a short sea trial or a log: a steering model with honest bounds,\n controller gains and turning limits.\n"
    )
}

/// Unpacks the archive and makes a report of a rehearsed trial, s.
fn first_report(archive: &Path, name: &str, machine: Machine) -> Result<f64, String> {
    let folder = in_target(OUT).join("tried");
    let _ = std::fs::remove_dir_all(&folder);
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(failed)?;
    let begun = Instant::now();
    let mut tar = Command::new("tar");
    tar.arg("-xf").arg(archive).arg("-C").arg(&folder);
    run(&mut tar, "tar -xf")?;
    let mut trial = machine.command(&folder, &Path::new(name).join("seatrial"));
    trial.args(["trial", "--yes", "--report", "trial.html"]);
    let done = trial.current_dir(&folder).output().map_err(failed)?;
    let report = std::fs::read_to_string(folder.join("trial.html")).unwrap_or_default();
    match done.status.success() && report.contains("</html>") {
        true => Ok(begun.elapsed().as_secs_f64()),
        false => Err(String::from_utf8_lossy(&done.stderr).into_owned()),
    }
}

/// Installs the package into a root of its own, uses it there, and removes it.
fn installed_package_works(package: &Path, machine: Machine) -> Result<(), String> {
    let root = in_target(OUT).join("root");
    let _ = std::fs::remove_dir_all(&root);
    let admin = root.join("var/lib/dpkg");
    for folder in ["info", "updates", "triggers"] {
        std::fs::create_dir_all(admin.join(folder)).map_err(|error| error.to_string())?;
    }
    std::fs::write(admin.join("status"), "").map_err(|error| error.to_string())?;
    let dpkg = |what: &[&str]| {
        let mut command = Command::new("dpkg");
        command.arg(format!("--root={}", root.display()));
        // The root has no C library of its own.
        let forces = "--force-depends --force-architecture --force-not-root --log=/dev/null";
        command.args(forces.split(' ')).args(what);
        run(&mut command, format!("dpkg {}", what.join(" ")))
    };
    dpkg(&["--install", &package.display().to_string()])?;
    let mut installed = machine.command(&root, Path::new("usr/bin/seatrial"));
    let said = installed.arg("--version").output();
    let said = said.map_err(|error| error.to_string())?;
    if String::from_utf8_lossy(&said.stdout) != format!("seatrial {VERSION}\n") {
        return Err("the installed command does not say its version".into());
    }
    if !root
        .join("usr/share/man/man1/seatrial-identify.1.gz")
        .exists()
    {
        return Err("the package has no page for `man seatrial-identify`".into());
    }
    dpkg(&["--purge", "seatrial"])?;
    match root.join("usr/bin/seatrial").exists() {
        true => Err("the package leaves files behind".into()),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `cargo binstall` finds what is packed here, under its name.
    #[test]
    fn exact_the_archives_are_where_binstall_looks() {
        let metadata = crate::packages::metadata().unwrap();
        let packages = metadata["packages"].as_array().unwrap();
        let command = packages
            .iter()
            .find(|package| package["name"] == "seatrial-cli");
        let binstall = &command.unwrap()["metadata"]["binstall"];
        let windows = &binstall["overrides"]["x86_64-pc-windows-gnu"];
        let at = |place: &serde_json::Value, target: &str| {
            let place = place.as_str().unwrap().replace("{ version }", VERSION);
            place.replace("{ target }", target)
        };
        for (place, target, ending) in [(binstall, STATIC, "tar.gz"), (windows, WINDOWS, "zip")] {
            let name = name_for(target);
            assert!(at(&place["pkg-url"], target).ends_with(&format!("/{name}.{ending}")));
            let bin = at(&binstall["bin-dir"], target);
            assert_eq!(bin, format!("{name}/{{ bin }}{{ binary-ext }}"));
        }
        let msvc = &binstall["overrides"]["x86_64-pc-windows-msvc"];
        assert_eq!(at(&msvc["pkg-url"], ""), at(&windows["pkg-url"], WINDOWS));
        assert_eq!(at(&msvc["bin-dir"], ""), at(&binstall["bin-dir"], WINDOWS));
    }

    #[test]
    fn exact_only_a_program_with_glibc_depends_on_it() {
        assert!(control("amd64", true).contains("Depends: libc6 (>= 2.28)\n"));
        assert!(!control("arm64", false).contains("Depends"));
        assert!(control("arm64", false).contains("Architecture: arm64\n"));
    }
}
