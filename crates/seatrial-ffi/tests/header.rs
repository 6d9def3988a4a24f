//! The committed header is the one of the source.

use std::path::Path;

use seatrial_ffi::{
    SEATRIAL_ABI, SEATRIAL_VERSION_MAJOR, SEATRIAL_VERSION_MINOR, SEATRIAL_VERSION_PATCH,
};

#[test]
fn parity_header_matches_its_source() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::generate_with_config(folder, config).unwrap();
    let mut generated = Vec::new();
    bindings.write(&mut generated);
    let generated = String::from_utf8(generated).unwrap();

    let path = folder.join("include/seatrial.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &generated).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == generated,
        "include/seatrial.h is out of date: UPDATE_HEADER=1 cargo test -p seatrial-ffi --test suite header::"
    );
}

/// A program cannot enter the library but by functions whose names say its ABI and the size of its numbers.
#[test]
fn parity_every_way_into_the_library_says_which_library() {
    let header = include_str!("../include/seatrial.h");
    assert!(!header.contains("panic_path"), "of no use to a program");
    let version =
        format!("{SEATRIAL_VERSION_MAJOR}.{SEATRIAL_VERSION_MINOR}.{SEATRIAL_VERSION_PATCH}");
    assert_eq!(version, env!("CARGO_PKG_VERSION"));
    let entry_points = include_str!("../src/entry_points.rs");
    let without_numbers = ["seatrial_status_text", "seatrial_check_abi"];
    let mut renamed = 0;
    let is_of_c = |line: &&str| !line.starts_with('#');
    let declarations: Vec<&str> = header.lines().filter(is_of_c).collect();
    for declaration in declarations
        .join("\n")
        .split(';')
        .filter(|text| text.contains("seatrial_") && text.contains('('))
    {
        let Some((before, arguments)) =
            declaration.rsplit_once("seatrial_").and_then(|(_, name)| name.split_once('('))
        else {
            continue;
        };
        let name = format!("seatrial_{before}");
        // Their first argument is an object that one of the others made.
        let of_an_object =
            ["struct SeatrialTrial *", "struct SeatrialEstimator *", "struct SeatrialFixedRate *"]
                .iter()
                .any(|object| arguments.starts_with(object));
        if of_an_object || without_numbers.contains(&&*name) {
            continue;
        }
        renamed += 1;
        assert!(
            header.contains(&format!("#define {name} SEATRIAL_OF_THIS_LIBRARY({name})")),
            "{name}"
        );
        for numbers in ["single", "double"] {
            assert!(
                entry_points.contains(&format!("{name}_abi{SEATRIAL_ABI}_{numbers}")),
                "{name}"
            );
        }
    }
    assert_eq!(renamed, 11);
}
