//! What BlueOS asks of a service on the vehicle, and what a container may lack.

use seatrial_dev::{program, text};
use serde_json::json;

use super::server::Server;

/// Fields of `ServiceMetadata` in BlueOS's helper that have no default; all are text.
const NEEDED: [&str; 7] = ["name", "description", "icon", "company", "version", "webpage", "api"];

#[test]
fn cli_blueos_lists_the_dashboard_without_a_token() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &["--require-token"]);
    server.token = None;
    let (status, page) = server.ask_page("/").send();
    let title = "<title>seatrial</title>";
    assert!(status == 200 && page.as_str().unwrap().contains(title), "{page}");
    let (status, service) = server.ask_page("/register_service").send();
    assert_eq!(status, 200, "{service}");
    for field in NEEDED {
        let is_said = service[field].as_str().is_some_and(|text| !text.is_empty());
        assert!(is_said, "{field}: {service}");
    }
    assert_eq!(service["name"], "seatrial");
    assert_eq!(service["version"], env!("CARGO_PKG_VERSION"));
    // Our pages refuse to be framed, so BlueOS has to open a tab.
    assert_eq!(service["avoid_iframes"], true);
    // The interface itself stays closed.
    let (status, refused) = server.ask("GET", "/status").send();
    assert_eq!((status, &refused["code"]), (401, &json!("token_needed")));
}

#[test]
fn cli_a_folder_for_uploads_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let served = program()
        .args(["serve", "--listen", "127.0.0.1:0"])
        .current_dir(folder.path())
        .env("TMPDIR", "/nowhere")
        .output()
        .unwrap();
    let said = text(&served.stderr);
    assert_eq!(served.status.code(), Some(2), "{said}");
    assert!(said.contains("/nowhere") && said.contains("TMPDIR"), "{said}");
}
