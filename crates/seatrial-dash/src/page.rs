//! The page, inside the program.

use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use include_dir::{Dir, include_dir};

use crate::refusal::Refusal;

static DIST: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/dist");

/// A file of the page.
pub async fn file(uri: Uri) -> Response {
    let path = uri.path().trim_start_matches('/');
    let path = if path.is_empty() { "index.html" } else { path };
    let found = DIST.get_file(path).filter(|_| !path.starts_with("api/"));
    let Some(file) = found else {
        return Refusal::not_found(format!("{}: there is nothing here", uri.path()))
            .into_response();
    };
    // The build gives every file but the first a name of its contents.
    let keep = if path.starts_with("assets/") { "max-age=31536000, immutable" } else { "no-cache" };
    let headers = [(CONTENT_TYPE, kind(path)), (CACHE_CONTROL, keep)];
    (StatusCode::OK, headers, file.contents()).into_response()
}

fn kind(path: &str) -> &'static str {
    match path.rsplit_once('.').map(|(_, suffix)| suffix) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("json" | "webmanifest") => "application/json",
        Some("png") => "image/png",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}
