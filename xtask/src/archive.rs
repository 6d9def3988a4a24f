//! The archive of the command for a release, and the Debian package: built, installed and used.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Result, ensure};

use crate::c_library::finds_its_vehicle;
use crate::shell::{Run, command, empty_folder, files, has, in_time, put, shell, tell_size};
use crate::toolchain::{CORTEX_M, needs_library};
use crate::wheel;
use crate::workspace::{binary as built_for_tests, in_target};

/// Linked statically; built where the compiler has its standard library.
const STATIC: &str = "x86_64-unknown-linux-musl";
/// Otherwise for an old glibc.
const WITH_GLIBC: &str = "x86_64-unknown-linux-gnu";
/// A zip, built by mingw.
pub const WINDOWS: &str = "x86_64-pc-windows-gnu";
/// QEMU for single programs, in the package qemu-user. Its time says nothing.
const EMULATOR: &str = "/usr/bin/qemu-aarch64";
/// From the archive to a report, s.
const GOAL_S: f64 = 20.0;
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Shells, the files of their completions in an archive, and where a package puts these.
const SHELLS: [(&str, &str, &str); 3] = [
    ("bash", "seatrial.bash", "bash-completion/completions/seatrial"),
    ("zsh", "_seatrial", "zsh/vendor-completions/_seatrial"),
    ("fish", "seatrial.fish", "fish/vendor_completions.d/seatrial.fish"),
];
/// Pages that go with the command.
const PAGES: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Builds both for a target, or for this machine, installs both and times the archive to a first report.
pub fn check(target: Option<&str>) -> Result<()> {
    let own = if needs_library(STATIC).is_ok() { STATIC } else { WITH_GLIBC };
    let target = target.unwrap_or(own);
    let runner = runner(target);
    let name = name_for(target);
    fill(&name, &wheel::command_for(target)?, target, runner)?;
    let archive = packed(&name)?;
    let package = debian_package(&name, target)?;
    tell_size(&archive)?;
    tell_size(&package)?;
    let Some(runner) = runner else {
        eprintln!("== {target} does not run here: built, not tried");
        return Ok(());
    };
    let seconds = first_report(&archive, &name, runner)?;
    installed_package_works(&package, runner)?;
    if runner.is_empty() {
        c_program_runs(&folder("tried").join(name), target)?;
        in_time("from the archive to a report", seconds, GOAL_S)?;
    }
    Ok(())
}

/// A zip with what the archive holds, of a command that does not run here.
pub fn zipped(binary: &Path) -> Result<PathBuf> {
    let name = name_for(WINDOWS);
    fill(&name, binary, WINDOWS, None)?;
    let (archives, zip) = (folder(""), folder(&format!("{name}.zip")));
    command!("python3 -c {ZIP} {archives} {name} {zip}").run()?;
    Ok(zip)
}

/// What an archive is called, and the folder in it.
fn name_for(target: &str) -> String {
    format!("seatrial-{VERSION}-{target}")
}

/// A file or folder where archives are built.
fn folder(name: &str) -> PathBuf {
    in_target("archives").join(name)
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

/// What a command of another machine needs before it, or nothing.
type Runner = &'static [&'static str];

/// `None` where nothing runs the commands of a target.
fn runner(target: &str) -> Option<Runner> {
    match target {
        WINDOWS => None,
        own if own.starts_with(std::env::consts::ARCH) => Some(&[]),
        "aarch64-unknown-linux-musl" if has(EMULATOR) => Some(&[EMULATOR]),
        _ => None,
    }
}

/// A command with nothing in its environment.
fn alone(runner: Runner, program: &Path) -> Command {
    command!("env -i {runner...} {program}")
}

/// The folder of an archive. The command writes its own completions and pages for `man`: one that does not run here has those of the
/// command that does.
fn fill(name: &str, binary: &Path, target: &str, runner: Option<Runner>) -> Result<()> {
    let folder = folder(name);
    empty_folder(&folder)?;
    shell().copy_file(binary, &folder)?;
    for page in PAGES {
        shell().copy_file(page, &folder)?;
    }
    if runner.is_none() {
        command!("cargo build --quiet -p seatrial-cli").run()?;
    }
    let seatrial = || match runner {
        Some(runner) => alone(runner, binary),
        None => Command::new(built_for_tests()),
    };
    for (name, file, _) in SHELLS {
        let said = seatrial().args(["completions", name]).read()?;
        shell().write_file(folder.join("completions").join(file), said)?;
    }
    seatrial().args(["completions", "--json", "--man"]).arg(folder.join("man")).read()?;
    c_libraries(&folder, target)
}

/// Where the library for C of a target is in an archive.
fn c_library(folder: &Path, target: &str) -> PathBuf {
    folder.join("c").join(target).join("libseatrial_ffi.a")
}

/// Puts the library for C in, which needs no operating system: for the target in double, for a Cortex-M4F in single precision.
fn c_libraries(folder: &Path, target: &str) -> Result<()> {
    for (target, feature) in [(target, ""), (CORTEX_M, "single")] {
        needs_library(target)?;
        command!("cargo rustc --quiet -p seatrial-ffi --profile embedded --no-default-features --features={feature} --target {target} --crate-type staticlib").run()?;
        put(in_target(target).join("embedded/libseatrial_ffi.a"), c_library(folder, target))?;
    }
    put("crates/seatrial-ffi/include/seatrial.h", folder.join("c/seatrial.h"))
}

/// Compiles the example against the archive's library and runs it.
fn c_program_runs(folder: &Path, target: &str) -> Result<()> {
    let (program, library) = (folder.join("loop_20hz"), c_library(folder, target));
    command!("cc -std=c99 -I {folder}/c crates/seatrial-ffi/examples/loop_20hz.c {library} -Wl,--gc-sections -lm -o {program}").run()?;
    finds_its_vehicle(&Command::new(program).read()?)
}

/// Files that do not differ make archives that do not differ.
fn packed(name: &str) -> Result<PathBuf> {
    let (archive, archives) = (folder(&format!("{name}.tar.gz")), folder(""));
    command!("tar --sort=name --owner=0 --group=0 --numeric-owner --mtime=@0 '--use-compress-program=gzip -9n' -cf {archive} -C {archives} {name}").run()?;
    Ok(archive)
}

fn debian_package(name: &str, target: &str) -> Result<PathBuf> {
    let architecture = if target.starts_with("aarch64") { "arm64" } else { "amd64" };
    let root = folder("debian");
    empty_folder(&root)?;
    put(folder(name).join("seatrial"), root.join("usr/bin/seatrial"))?;
    for (_, file, place) in SHELLS {
        put(folder(name).join("completions").join(file), root.join("usr/share").join(place))?;
    }
    let [texts, manual] =
        ["usr/share/doc/seatrial", "usr/share/man/man1"].map(|place| root.join(place));
    put("packaging/copyright", texts.join("copyright"))?;
    put("CHANGELOG.md", texts.join("changelog"))?;
    for page in files(&folder(name).join("man"), "")? {
        put(&page, manual.join(page.file_name().unwrap_or_default()))?;
    }
    let pages = files(&manual, "")?;
    command!("gzip -9n {texts}/changelog {pages...}").run()?;
    shell()
        .write_file(root.join("DEBIAN/control"), control(architecture, target.ends_with("gnu")))?;
    let package = folder(&format!("seatrial_{VERSION}_{architecture}.deb"));
    command!("dpkg-deb --root-owner-group -Zxz --build {root} {package}").run()?;
    Ok(package)
}

fn control(architecture: &str, needs_glibc: bool) -> String {
    let depends = if needs_glibc { "Depends: libc6 (>= 2.28)\n" } else { "" };
    format!(
        "Package: seatrial\nVersion: {VERSION}\nArchitecture: {architecture}\n{depends}Section: science\nPriority: optional\n\
         Maintainer: The seatrial developers <seatrial@users.noreply.github.com>\n\
         Homepage: https://github.com/seatrial/seatrial\n\
         Description: find out how a marine vehicle steers\n \
         From a short sea trial or a log: a steering model with honest bounds,\n controller gains and turning limits.\n"
    )
}

/// Unpacks the archive and makes a report of a rehearsed trial, s.
fn first_report(archive: &Path, name: &str, runner: Runner) -> Result<f64> {
    let folder = folder("tried");
    empty_folder(&folder)?;
    let begun = Instant::now();
    command!("tar -xf {archive} -C {folder}").run()?;
    let mut trial = alone(runner, &folder.join(name).join("seatrial"));
    trial.args(["trial", "--yes", "--report", "trial.html"]);
    trial.current_dir(&folder).read()?;
    let report = shell().read_file(folder.join("trial.html"))?;
    ensure!(report.contains("</html>"), "the report has no end");
    Ok(begun.elapsed().as_secs_f64())
}

/// Installs the package into a root of its own, uses it there, and removes it.
fn installed_package_works(package: &Path, runner: Runner) -> Result<()> {
    let root = folder("root");
    empty_folder(&root)?;
    for name in ["info", "updates", "triggers"] {
        shell().create_dir(root.join("var/lib/dpkg").join(name))?;
    }
    shell().write_file(root.join("var/lib/dpkg/status"), "")?;
    // The root has no C library of its own.
    let dpkg = || {
        command!(
            "dpkg --root={root} --force-depends --force-architecture --force-not-root --log=/dev/null"
        )
    };
    dpkg().arg("--install").arg(package).run()?;
    let seatrial = root.join("usr/bin/seatrial");
    let said = alone(runner, &seatrial).arg("--version").read()?;
    ensure!(said == format!("seatrial {VERSION}\n"), "the installed command says {said}");
    let page = root.join("usr/share/man/man1/seatrial-identify.1.gz");
    ensure!(page.exists(), "the package has no page for `man seatrial-identify`");
    dpkg().args(["--purge", "seatrial"]).run()?;
    ensure!(!seatrial.exists(), "the package leaves files behind");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `cargo binstall` finds what is packed here, under its name.
    #[test]
    fn exact_the_archives_are_where_binstall_looks() {
        let metadata = crate::workspace::metadata().unwrap();
        let packages = metadata["packages"].as_array().unwrap();
        let command = packages.iter().find(|package| package["name"] == "seatrial-cli");
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
