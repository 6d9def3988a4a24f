//! Who may do what: tokens, hosts and origins, rates, control.

use std::collections::HashMap;
use std::fs::Metadata;
use std::io::{self, Write};
use std::net::IpAddr;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::http::HeaderMap;
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;
use tempfile::NamedTempFile;

use crate::api::{Control, Role};
use crate::convert::now;

/// A lease lapses after this time without a sign of life.
pub const LEASE: Duration = Duration::from_secs(60);
/// Viewers see within this time that a lease lapsed.
const LAPSE_SEEN_WITHIN: Duration = Duration::from_secs(1);
/// At most so many addresses have a bucket of requests.
const MOST_ADDRESSES: usize = 4096;

/// A secret of 256 bits, in hexadecimal.
pub fn secret() -> io::Result<String> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(hex(&bytes))
}

/// Letters and digits of a code: none that is taken for another (Crockford's base 32).
const CODE_LETTERS: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";

/// A code of 40 bits that a person types, `7K3M-Q0XV`. A wrong one costs as much as a wrong token: an address tries two a second, so
/// that the code is not guessed while its server runs.
pub fn code() -> io::Result<String> {
    let mut bytes = [0; 8];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    let letters: String =
        bytes.iter().map(|byte| char::from(CODE_LETTERS[usize::from(byte % 32)])).collect();
    let (first, last) = letters.split_at(4);
    Ok(format!("{first}-{last}"))
}

/// A code as it was typed, without what people put between its letters.
fn typed_code(text: &str) -> String {
    let letters = text.chars().filter(|c| c.is_ascii_alphanumeric());
    letters.map(|c| c.to_ascii_uppercase()).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a secret: one of 256 random bits needs no salt and no slow hash.
fn hash(secret: &str) -> [u8; 32] {
    Sha256::digest(secret).into()
}

/// Tokens just made; they are shown once and not kept.
#[derive(Clone, Debug)]
pub struct NewTokens {
    /// For those who command.
    pub operator: String,
    /// For those who only watch.
    pub viewer: String,
}

/// Hashes of the tokens, in hexadecimal as they are in their file.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tokens {
    operator_sha256: String,
    viewer_sha256: String,
    /// That of the code of this server, which is in no file.
    #[serde(skip)]
    code_sha256: Option<String>,
}

impl Tokens {
    /// With a code that stands for the operator's token until this server ends.
    pub fn with_code(mut self, code: &str) -> Self {
        self.code_sha256 = Some(hex(&hash(&typed_code(code))));
        self
    }

    /// Reads the tokens of a file of ours that nobody else may write; makes new ones, in a file of their own, where there is none or
    /// where new ones are wanted.
    pub fn of_file(path: &Path, wants_new: bool) -> io::Result<(Self, Option<NewTokens>)> {
        if let Ok(about) = std::fs::symlink_metadata(path)
            && !wants_new
        {
            refuse_planted(&about)?;
            let text = std::fs::read_to_string(path)?;
            let tokens = serde_json::from_str(&text).map_err(io::Error::other)?;
            return Ok((tokens, None));
        }
        let new = NewTokens { operator: secret()?, viewer: secret()? };
        let tokens = Self {
            operator_sha256: hex(&hash(&new.operator)),
            viewer_sha256: hex(&hash(&new.viewer)),
            code_sha256: None,
        };
        let text = serde_json::to_string_pretty(&tokens).map_err(io::Error::other)?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        // Made for the owner alone under a name of its own, then put in the place of whatever is there: no link is followed.
        let mut file = NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
        file.write_all(text.as_bytes())?;
        file.persist(path)?;
        Ok((tokens, Some(new)))
    }

    /// What the bearer may do.
    pub fn role(&self, token: &str) -> Option<Role> {
        let given = hex(&hash(token));
        let is = |kept: &str| bool::from(given.as_bytes().ct_eq(kept.as_bytes()));
        let typed = hex(&hash(&typed_code(token)));
        let kept = self.code_sha256.as_deref().unwrap_or_default();
        let is_code = bool::from(typed.as_bytes().ct_eq(kept.as_bytes()));
        let (operator, viewer) = (is(&self.operator_sha256), is(&self.viewer_sha256));
        match (operator || is_code, viewer) {
            (true, _) => Some(Role::Operator),
            (false, true) => Some(Role::Viewer),
            (false, false) => None,
        }
    }
}

/// Refuses a file of tokens that somebody else may have put there or changed.
fn refuse_planted(about: &Metadata) -> io::Result<()> {
    let refuse = |what: &str| Err(io::Error::new(io::ErrorKind::PermissionDenied, what));
    if !about.is_file() {
        return refuse("it is a link or no file: its tokens are not trusted");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        if about.mode() & 0o022 != 0 {
            return refuse("others may write it: its tokens are not trusted");
        }
        let ours = rustix::process::geteuid().as_raw();
        if about.uid() != ours && about.uid() != 0 {
            return refuse("it belongs to another user: its tokens are not trusted");
        }
    }
    Ok(())
}

/// The token of a bearer header.
pub fn bearer(headers: &HeaderMap) -> Option<&str> {
    headers.get(AUTHORIZATION)?.to_str().ok()?.strip_prefix("Bearer ")
}

/// The host that a request names, where the server goes by that name: another one is that of a page that had its name
/// resolve to us.
pub fn own_host<'a>(
    headers: &'a HeaderMap,
    is_loopback: bool,
    names: &[String],
) -> Option<&'a str> {
    let host = headers.get(HOST)?.to_str().ok()?;
    let name = match host.strip_prefix('[') {
        Some(v6) => v6.split_once(']')?.0,
        None => host.split_once(':').map_or(host, |(name, _)| name),
    };
    let is_own = match name.parse::<IpAddr>() {
        Ok(address) => !is_loopback || address.is_loopback(),
        Err(_) => {
            name.eq_ignore_ascii_case("localhost")
                || names.iter().any(|own| name.eq_ignore_ascii_case(own))
        }
    };
    is_own.then_some(host)
}

/// Does a request come from our own page, or from no page?
pub fn is_own_origin(headers: &HeaderMap, host: &str) -> bool {
    let Some(origin) = headers.get(ORIGIN) else {
        return true;
    };
    let origin = origin.to_str().unwrap_or_default();
    let of_page = origin.strip_prefix("http://").or(origin.strip_prefix("https://"));
    of_page.is_some_and(|of_page| of_page.eq_ignore_ascii_case(host))
}

/// A bucket of requests for each network address.
#[derive(Debug)]
pub struct Rates {
    per_s: f64,
    buckets: Mutex<HashMap<IpAddr, (f64, Instant)>>,
}

impl Rates {
    /// Allows so many requests a second, and four times as many at once.
    pub fn new(per_s: f64) -> Self {
        Self { per_s, buckets: Mutex::default() }
    }

    /// Takes what a request costs, counted in requests, out of the bucket of an address. `false`: not even one request is
    /// left. What it costs beyond what is left is paid before the address is let through again.
    pub fn allows(&self, address: IpAddr, cost: f64) -> bool {
        self.with_bucket(address, |left| {
            let allows = *left >= 1.0;
            if allows {
                *left -= cost;
            }
            allows
        })
    }

    fn most(&self) -> f64 {
        4.0 * self.per_s
    }

    /// Changes the bucket of an address as it is now; `false` where there are too many buckets for another.
    fn with_bucket(&self, address: IpAddr, change: impl FnOnce(&mut f64) -> bool) -> bool {
        let most = self.most();
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        if buckets.len() >= MOST_ADDRESSES && !buckets.contains_key(&address) {
            // A full bucket is as good as none.
            buckets.retain(|_, (left, at)| *left + at.elapsed().as_secs_f64() * self.per_s < most);
            if buckets.len() >= MOST_ADDRESSES {
                return false;
            }
        }
        let (left, at) = buckets.entry(address).or_insert((most, Instant::now()));
        *left = (*left + at.elapsed().as_secs_f64() * self.per_s).min(most);
        *at = Instant::now();
        change(left)
    }
}

/// The lease of control over the vehicle.
#[derive(Debug, Default)]
pub struct Leases {
    held: Mutex<Option<Holder>>,
}

#[derive(Debug)]
struct Holder {
    name: String,
    lease: String,
    since: String,
    seen: Instant,
}

/// The answer to asking for control, or to using a lease.
#[derive(Debug, PartialEq)]
pub enum Claim {
    /// Control is the asker's, under this name, by this lease.
    Yours {
        /// The name.
        name: String,
        /// The secret.
        lease: String,
    },
    /// Somebody has it.
    Taken {
        /// Who.
        by: String,
        /// Since when, UTC.
        since: String,
    },
    /// Nobody has control.
    Free,
}

impl Leases {
    /// Gives control to a name where it is free, or where this lease has it already.
    pub fn take(&self, name: &str, lease: Option<&str>) -> io::Result<Claim> {
        match self.claim(lease) {
            Claim::Free => {
                let lease = secret()?;
                *self.lock() = Some(Holder {
                    name: name.into(),
                    lease: lease.clone(),
                    since: now(),
                    seen: Instant::now(),
                });
                Ok(Claim::Yours { name: name.into(), lease })
            }
            claim => Ok(claim),
        }
    }

    /// Answers the bearer of a lease who has control, and renews a lease that holds.
    pub fn claim(&self, lease: Option<&str>) -> Claim {
        let mut held = self.lock();
        let Some(holder) = held.as_mut() else {
            return Claim::Free;
        };
        let is_holder =
            lease.is_some_and(|given| given.as_bytes().ct_eq(holder.lease.as_bytes()).into());
        if is_holder {
            holder.seen = Instant::now();
            return Claim::Yours { name: holder.name.clone(), lease: holder.lease.clone() };
        }
        Claim::Taken { by: holder.name.clone(), since: holder.since.clone() }
    }

    /// Gives control back.
    pub fn release(&self) {
        *self.lock() = None;
    }

    /// Who has control, without anything that is secret.
    pub fn control(&self, lease: Option<&str>) -> Control {
        let is_you = matches!(self.claim(lease), Claim::Yours { .. });
        let held = self.lock();
        Control {
            holder: held.as_ref().map(|held| held.name.clone()),
            since: held.as_ref().map(|held| held.since.clone()),
            silent_for_s: held.as_ref().map(|held| held.seen.elapsed().as_secs_f64()),
            is_you,
        }
    }

    /// Tells viewers of a lease that lapsed.
    pub async fn watch(&self, mut tell: impl FnMut(Control)) {
        let mut was_held = false;
        loop {
            let control = self.control(None);
            let is_held = control.holder.is_some();
            if was_held && !is_held {
                tell(control);
            }
            was_held = is_held;
            tokio::time::sleep(LAPSE_SEEN_WITHIN).await;
        }
    }

    /// The holder, unless that one was not heard for too long.
    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Holder>> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if held.as_ref().is_some_and(|held| held.seen.elapsed() > LEASE) {
            *held = None;
        }
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: axum::http::HeaderName, value: &str) -> HeaderMap {
        HeaderMap::from_iter([(name, value.parse().unwrap())])
    }

    #[test]
    fn exact_only_our_own_names_are_ours() {
        let names = ["boat.local".to_owned()];
        for (host, is_loopback, is_own) in [
            ("127.0.0.1:8042", true, true),
            ("localhost:8042", true, true),
            ("[::1]:8042", true, true),
            ("boat.local:8042", true, true),
            ("192.168.1.5:8042", false, true),
            ("192.168.1.5:8042", true, false),
            ("evil.example:8042", true, false),
            ("evil.example", false, false),
            ("127.0.0.1.evil.example", true, false),
            ("[::1", true, false),
        ] {
            let found = own_host(&headers(HOST, host), is_loopback, &names).is_some();
            assert_eq!(found, is_own, "{host}");
        }
        assert_eq!(own_host(&HeaderMap::new(), false, &names), None);
    }

    #[test]
    fn exact_a_foreign_origin_is_not_ours() {
        let host = "127.0.0.1:8042";
        for (origin, is_own) in [
            ("http://127.0.0.1:8042", true),
            ("https://127.0.0.1:8042", true),
            ("http://127.0.0.1:8043", false),
            ("http://evil.example", false),
            ("null", false),
        ] {
            assert_eq!(is_own_origin(&headers(ORIGIN, origin), host), is_own, "{origin}");
        }
        assert!(is_own_origin(&HeaderMap::new(), host));
    }

    #[test]
    fn exact_a_code_stands_for_the_operators_token() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.json");
        let (tokens, _) = Tokens::of_file(&path, false).unwrap();
        let made = code().unwrap();
        assert_eq!(made.len(), 9);
        assert_eq!(tokens.role(&made), None);
        assert_eq!(tokens.role(""), None);
        let tokens = tokens.with_code(&made);
        let sloppy = made.to_lowercase().replace('-', " ");
        assert_eq!(tokens.role(&made), Some(Role::Operator));
        assert_eq!(tokens.role(&sloppy), Some(Role::Operator));
        assert_eq!(tokens.role(""), None);
        assert_eq!(tokens.role(&made[1..]), None);
        // The next server has another one, and no file tells this one.
        let kept = std::fs::read_to_string(&path).unwrap();
        assert!(!kept.contains("code"), "{kept}");
        assert_ne!(code().unwrap(), made);
    }

    #[test]
    fn exact_tokens_are_kept_as_hashes_and_shown_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.json");
        let (_, new) = Tokens::of_file(&path, false).unwrap();
        let new = new.unwrap();
        let kept = std::fs::read_to_string(&path).unwrap();
        assert!(!kept.contains(&new.operator) && !kept.contains(&new.viewer));
        let (tokens, again) = Tokens::of_file(&path, false).unwrap();
        assert!(again.is_none());
        assert_eq!(tokens.role(&new.operator), Some(Role::Operator));
        assert_eq!(tokens.role(&new.viewer), Some(Role::Viewer));
        assert_eq!(tokens.role(""), None);
        assert_eq!(tokens.role(&tokens.operator_sha256), None);
    }

    /// Whoever may write into the folder plants a file, or a link to one of ours.
    #[cfg(unix)]
    #[test]
    fn exact_planted_tokens_are_not_trusted_and_no_link_is_followed() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tokens.json");
        Tokens::of_file(&path, false).unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&path), 0o600);
        for open in [0o666, 0o620, 0o602] {
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(open)).unwrap();
            let refused = Tokens::of_file(&path, false).unwrap_err();
            assert!(refused.to_string().contains("others may write"), "{refused}");
        }
        Tokens::of_file(&path, true).unwrap();
        assert_eq!(mode(&path), 0o600, "new tokens do not take the old file's mode");
        let (precious, link) = (folder.path().join("precious"), folder.path().join("link.json"));
        std::fs::write(&precious, "precious").unwrap();
        symlink(&precious, &link).unwrap();
        assert!(Tokens::of_file(&link, false).is_err());
        Tokens::of_file(&link, true).unwrap();
        assert_eq!(std::fs::read_to_string(&precious).unwrap(), "precious");
        assert!(std::fs::symlink_metadata(&link).unwrap().is_file());
    }

    #[test]
    fn exact_a_bucket_of_four_seconds() {
        let rates = Rates::new(0.5);
        let address = IpAddr::from([127, 0, 0, 1]);
        assert!(rates.allows(address, 1.0) && rates.allows(address, 1.0));
        assert!(!rates.allows(address, 1.0));
        assert!(rates.allows(IpAddr::from([127, 0, 0, 2]), 1.0));
    }

    /// What a request costs beyond what is left is paid before the next one.
    #[test]
    fn exact_a_cost_is_paid_where_less_is_left() {
        let rates = Rates::new(100.0);
        let address = IpAddr::from([127, 0, 0, 1]);
        assert!(rates.allows(address, 390.0));
        assert!(rates.allows(address, 50.0));
        assert!(!rates.allows(address, 1.0));
        let buckets = rates.buckets.lock().unwrap();
        // The bucket fills while the test runs.
        assert!((-40.0..0.0).contains(&buckets[&address].0), "{buckets:?}");
    }

    #[tokio::test]
    async fn exact_viewers_are_told_that_a_lease_lapsed() {
        let leases = Leases::default();
        leases.take("Ann", None).unwrap();
        let mut told = Vec::new();
        let watch = leases.watch(|control| told.push(control.holder));
        let lapse = async {
            tokio::time::sleep(LAPSE_SEEN_WITHIN / 2).await;
            let held = &mut *leases.lock();
            held.as_mut().unwrap().seen = Instant::now().checked_sub(2 * LEASE).unwrap();
        };
        let _ = tokio::join!(tokio::time::timeout(3 * LAPSE_SEEN_WITHIN, watch), lapse);
        assert_eq!(told, [None]);
    }

    #[test]
    fn exact_control_is_one_persons() {
        let leases = Leases::default();
        let Ok(Claim::Yours { lease, .. }) = leases.take("Anna", None) else {
            panic!("control was free");
        };
        assert!(matches!(leases.take("Ben", None), Ok(Claim::Taken { by, .. }) if by == "Anna"));
        assert!(matches!(leases.take("Anna", Some(&lease)), Ok(Claim::Yours { .. })));
        assert!(!leases.control(None).is_you && leases.control(Some(&lease)).is_you);
        leases.release();
        assert_eq!(leases.claim(Some(&lease)), Claim::Free);
    }
}
