//! The source code of an FMU, compiled for this machine.

use std::env::consts::{ARCH, OS};
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// A shared library and its place in the FMU.
pub(super) struct Binary {
    pub(super) path: String,
    pub(super) bytes: Vec<u8>,
}

/// Why there is no binary.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoBinary {
    #[error("no binary is made on {OS} {ARCH}")]
    Platform,
    #[error("{folder}: {source}")]
    Folder { folder: String, source: std::io::Error },
    #[error("no C compiler, {compiler}: {source}")]
    NoCompiler { compiler: String, source: std::io::Error },
    #[error("{compiler}: {said}")]
    Compiler { compiler: String, said: String },
}

/// Compiles a unit, or says why it cannot.
pub(super) fn compiled(source: &str, model: &str) -> Result<Binary, NoBinary> {
    let (platform, suffix) = match (ARCH, OS) {
        ("x86_64" | "aarch64", "linux") => (format!("{ARCH}-linux"), "so"),
        ("x86_64" | "aarch64", "macos") => (format!("{ARCH}-darwin"), "dylib"),
        _ => return Err(NoBinary::Platform),
    };
    let folder = std::env::temp_dir().join(format!("seatrial-fmu-{}-{model}", std::process::id()));
    let bytes = library(source, &folder);
    // A folder that stays behind does no harm.
    let _ = std::fs::remove_dir_all(&folder);
    Ok(Binary { path: format!("binaries/{platform}/{model}.{suffix}"), bytes: bytes? })
}

fn library(source: &str, folder: &Path) -> Result<Vec<u8>, NoBinary> {
    let failed = |source| NoBinary::Folder { folder: folder.display().to_string(), source };
    std::fs::create_dir_all(folder).map_err(failed)?;
    std::fs::write(folder.join("vehicle.c"), source).map_err(failed)?;
    let compiler = std::env::var_os("CC").unwrap_or_else(|| OsString::from("cc"));
    let name = compiler.display().to_string();
    let output = Command::new(&compiler)
        .args("-std=c99 -O2 -shared -fPIC -fvisibility=hidden -o library vehicle.c -lm".split(' '))
        .current_dir(folder)
        .output()
        .map_err(|source| NoBinary::NoCompiler { compiler: name.clone(), source })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(NoBinary::Compiler {
            compiler: name,
            said: said.lines().next().unwrap_or("it failed").to_owned(),
        });
    }
    std::fs::read(folder.join("library")).map_err(failed)
}
