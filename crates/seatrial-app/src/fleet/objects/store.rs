//! The stores themselves, through the crate `object_store`.

use std::collections::HashMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek, Write};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::Duration;

use futures_util::{StreamExt, TryStreamExt, stream};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path as Key;
use object_store::{
    ClientConfigKey, ClientOptions, Error, ObjectMeta, ObjectStore, ObjectStoreExt, RetryConfig,
    WriteMultipart,
};
use tokio::runtime::Runtime;

use super::{Address, DISK, ObjectError};
use crate::fleet::Source;

/// A request that fails is tried again so often, after waits that double from 0.1 s: an outage of some 20 s loses nothing.
const MAX_RETRIES: usize = 8;
/// A connection that gives nothing for so long is cut, and the rest asked for on another.
const READ_TIMEOUT: &str = "30 s";
/// Longest download of one log.
const REQUEST_TIMEOUT: &str = "12 h";
/// A part of a table on its way to a store; some are in memory.
const PART_BYTES: usize = 8 << 20;
const PARTS_AT_ONCE: usize = 4;
/// Objects of a list that are looked at side by side.
const LOOKS_AT_ONCE: usize = 32;

static RUNTIME: LazyLock<std::io::Result<Runtime>> = LazyLock::new(|| {
    tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()
});

/// By bucket or server, as each has its own connections.
static STORES: LazyLock<Mutex<HashMap<String, Arc<dyn ObjectStore>>>> =
    LazyLock::new(Mutex::default);

fn wait<T>(
    address: Address,
    task: impl Future<Output = Result<T, ObjectError>>,
) -> Result<T, ObjectError> {
    match &*RUNTIME {
        Ok(runtime) => runtime.block_on(task),
        Err(error) => Err(address.error(error, "the system gives no thread for it")),
    }
}

/// The store of an address, and the key in it.
fn resolved(address: Address) -> Result<(Arc<dyn ObjectStore>, Key), ObjectError> {
    let is_web = address.scheme.starts_with("http");
    let key = match is_web {
        true if address.key.contains(['?', '#']) || address.base.contains('@') => {
            return Err(address.error(
                "the address has a query or a password",
                "expected a plain address: what is secret would stand in the table; read a bucket by s3:// or gs://",
            ));
        }
        true => Key::from_url_path(address.key),
        false => Key::parse(address.key.trim_end_matches('/')),
    };
    let key = key.map_err(|error| address.error(error, "expected an address of an object"))?;
    let mut stores = STORES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(store) = stores.get(address.base) {
        return Ok((Arc::clone(store), key));
    }
    let store = connected(address).map_err(|error| explained(address, &error))?;
    stores.insert(address.base.to_owned(), Arc::clone(&store));
    Ok((store, key))
}

/// A store as the environment configures it: `AWS_...` and `GOOGLE_...`.
fn connected(address: Address) -> Result<Arc<dyn ObjectStore>, Error> {
    // `reqwest` is built without the cryptography that it would bring itself; what is installed already serves, too.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let retry = RetryConfig {
        max_retries: MAX_RETRIES,
        retry_timeout: Duration::from_secs(180),
        ..RetryConfig::default()
    };
    let timeouts =
        [(ClientConfigKey::Timeout, REQUEST_TIMEOUT), (ClientConfigKey::ReadTimeout, READ_TIMEOUT)];
    Ok(match address.scheme {
        "s3" => {
            let mut builder = AmazonS3Builder::from_env().with_url(address.base).with_retry(retry);
            for (key, value) in timeouts {
                builder = builder.with_config(AmazonS3ConfigKey::Client(key), value);
            }
            Arc::new(builder.build()?)
        }
        "gs" => {
            let mut builder =
                GoogleCloudStorageBuilder::from_env().with_url(address.base).with_retry(retry);
            for (key, value) in timeouts {
                builder = builder.with_config(GoogleConfigKey::Client(key), value);
            }
            Arc::new(builder.build()?)
        }
        _ => {
            let mut options = ClientOptions::new().with_allow_http(is_loopback(address.base));
            for (key, value) in timeouts {
                options = options.with_config(key, value);
            }
            let builder = HttpBuilder::new().with_url(address.base).with_retry(retry);
            Arc::new(builder.with_client_options(options).build()?)
        }
    })
}

/// Only what does not leave this machine needs no encryption.
fn is_loopback(base: &str) -> bool {
    let server = base.strip_prefix("http://").unwrap_or_default();
    let ends = |rest: &str| rest.is_empty() || rest.starts_with(':');
    ["127.0.0.1", "localhost", "[::1]"]
        .iter()
        .any(|name| server.strip_prefix(name).is_some_and(ends))
}

/// What is there; `None` where nothing is.
pub fn look(address: Address) -> Result<Option<Source>, ObjectError> {
    let (store, key) = resolved(address)?;
    wait(address, async {
        match store.head(&key).await {
            Ok(about) => Ok(Some(source(address.text, &about))),
            Err(Error::NotFound { .. }) => Ok(None),
            Err(error) => Err(explained(address, &error)),
        }
    })
}

/// What is there at each; one that is not found has no length.
pub fn look_at_all(addresses: &[Address]) -> Result<Vec<Source>, ObjectError> {
    let Some(&first) = addresses.first() else {
        return Ok(Vec::new());
    };
    let tasks = addresses.iter().map(|&address| async move {
        let (store, key) = resolved(address)?;
        Ok(match store.head(&key).await {
            Ok(about) => source(address.text, &about),
            Err(_) => Source { path: address.text.into(), ..Source::default() },
        })
    });
    wait(first, stream::iter(tasks).buffered(LOOKS_AT_ONCE).try_collect())
}

/// Everything below a prefix, in the order of the store.
pub fn list(address: Address, prefix: &str) -> Result<Vec<Source>, ObjectError> {
    let (store, _) = resolved(address)?;
    let place = |error| address.error(error, "expected the prefix of objects");
    let prefix = Key::parse(prefix.trim_end_matches('/')).map_err(place)?;
    wait(address, async {
        let mut cuts = 0;
        loop {
            let listed = store.list(Some(&prefix)).map_ok(|about| {
                let path = format!("{}/{}", address.base, about.location);
                source(&path, &about)
            });
            let listed: Result<Vec<Source>, Error> = listed.try_collect().await;
            match listed {
                Ok(sources) => return Ok(sources),
                Err(error) if is_cut(&error) && cuts < MAX_RETRIES => cuts += 1,
                Err(error) => return Err(explained(address, &error)),
            }
        }
    })
}

/// Was a connection cut in the middle of an answer? The library itself tries requests and objects again, not answers that list objects.
fn is_cut(error: &Error) -> bool {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(found) = cause {
        if let Some(error) = found.downcast_ref::<std::io::Error>() {
            return matches!(
                error.kind(),
                ErrorKind::BrokenPipe
                    | ErrorKind::ConnectionAborted
                    | ErrorKind::ConnectionReset
                    | ErrorKind::TimedOut
                    | ErrorKind::UnexpectedEof
            );
        }
        cause = found.source();
    }
    false
}

fn source(path: &str, about: &ObjectMeta) -> Source {
    Source {
        path: path.into(),
        bytes: about.size,
        modified_ns: about.last_modified.timestamp_nanos_opt().unwrap_or(0),
        etag: about.e_tag.clone(),
    }
}

/// Writes an object into a file, piece by piece.
pub fn download(
    address: Address,
    expected: Option<&Source>,
    file: &mut File,
) -> Result<(), ObjectError> {
    let (store, key) = resolved(address)?;
    wait(address, async {
        let told = |error: Error| explained(address, &error);
        let got = store.get(&key).await.map_err(told)?;
        let now = source(address.text, &got.meta);
        if expected.is_some_and(|then| (then.bytes, &then.etag) != (now.bytes, &now.etag)) {
            return Err(address.error("it was changed while the job ran", "run the job again"));
        }
        let mut pieces = got.into_stream();
        let mut bytes = 0;
        while let Some(piece) = pieces.try_next().await.map_err(told)? {
            bytes += piece.len() as u64;
            file.write_all(&piece).map_err(|error| address.error(error, DISK))?;
        }
        match bytes == now.bytes {
            true => Ok(()),
            false => {
                Err(address
                    .error(format!("{bytes} of {} bytes came", now.bytes), "run the job again"))
            }
        }
    })
}

/// Stores a file, a large one in parts; a server of HTTP takes it whole.
pub fn upload(address: Address, file: &mut File) -> Result<(), ObjectError> {
    let (store, key) = resolved(address)?;
    let reading = |error: std::io::Error| address.error(error, DISK);
    let told = |error: Error| explained(address, &error);
    let length = file.metadata().map_err(reading)?.len();
    file.rewind().map_err(reading)?;
    let mut part = |most: u64| {
        let mut bytes = Vec::new();
        let read = Read::take(&mut *file, most).read_to_end(&mut bytes);
        read.map(|_| bytes).map_err(reading)
    };
    wait(address, async {
        if length <= PART_BYTES as u64 || address.scheme.starts_with("http") {
            let whole = part(length)?;
            return store.put(&key, whole.into()).await.map(drop).map_err(told);
        }
        let parts = store.put_multipart(&key).await.map_err(told)?;
        let mut parts = WriteMultipart::new_with_chunk_size(parts, PART_BYTES);
        loop {
            let bytes = part(PART_BYTES as u64)?;
            if bytes.is_empty() {
                return parts.finish().await.map(drop).map_err(told);
            }
            parts.wait_for_capacity(PARTS_AT_ONCE).await.map_err(told)?;
            parts.put(bytes.into());
        }
    })
}

/// Says what failed at the bottom, and what to do.
fn explained(address: Address, error: &Error) -> ObjectError {
    let advice = match (error, address.scheme) {
        (Error::NotFound { .. }, _) => "nothing is stored there; look at the name",
        (Error::NotImplemented { .. }, _) => "this server does not do that",
        (_, "s3") => {
            "look at AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION and AWS_ENDPOINT_URL; a public bucket needs AWS_SKIP_SIGNATURE=true"
        }
        (_, "gs") => {
            "look at GOOGLE_APPLICATION_CREDENTIALS; a public bucket needs GOOGLE_SKIP_SIGNATURE=true"
        }
        _ => {
            "look at the address; plain http is for this machine alone, and a server without WebDAV lists no folder: name its logs, or a list of them by @LIST"
        }
    };
    let mut cause: &dyn std::error::Error = error;
    while let Some(deeper) = cause.source() {
        cause = deeper;
    }
    address.error(cause, advice)
}
