//! The OpenAPI document that the server sends is that of its types.

use std::path::Path;

/// `UPDATE_OPENAPI=1` writes it anew.
#[test]
fn regress_openapi_document_is_committed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi.json");
    let document = seatrial_dash::openapi_of_types();
    if std::env::var_os("UPDATE_OPENAPI").is_some() {
        std::fs::write(&path, &document).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == document,
        "crates/seatrial-dash/openapi.json is not that of the types; write it anew with UPDATE_OPENAPI=1 cargo nextest run -p seatrial-dash"
    );
}
