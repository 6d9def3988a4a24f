//! The graph over zenoh, as `rmw_zenoh` uses it: no ROS installation is needed.
//!
//! zenoh's own interface is used, not that of ros2-client, whose publishers and services have no hash for most types and so are
//! not heard by ROS 2.

mod names;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use ::zenoh::liveliness::LivelinessToken;
use ::zenoh::pubsub::{Publisher, Subscriber};
use ::zenoh::query::{ConsolidationMode, Query, QueryTarget, Queryable};
use ::zenoh::sample::SampleKind;
use ::zenoh::{Config, Session, Wait};
use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::wire::{
    self, Answer, CommandMessage, DiagnosticArray, Float64MultiArray, Request, SetBoolRequest,
    TriggerRequest,
};
use super::{DIAGNOSTICS_TOPIC, Listener, Source, failed, next_heard};
use crate::ros2_vehicle::{
    ABORT_SERVICE, Demand, Description, Diagnosis, ENABLE_SERVICE, ESTIMATE_TOPIC, EstimateTopic,
    Graph, GraphPeers, Heard, MiddlewareError, Zenoh, ZenohMode,
};
use names::{Announcement, Entity, Role};

/// Messages that are said to be kept; what comes is taken at once.
const WAITING: usize = 64;
/// Longest wait for the endpoint, ms.
const CONNECT_MS: u32 = 3000;
/// Longest wait for the answer of the vehicle's own service.
const ANSWER: Duration = Duration::from_secs(2);
/// Plain encoding of messages, the low byte first: what stands before each.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

type Sender = mpsc::Sender<(Instant, Heard)>;

/// A vehicle's topics and services over zenoh.
pub struct OverZenoh {
    description: Description,
    begin: Instant,
    commands: Vec<(Entity, Outlet)>,
    diagnostics: Outlet,
    client: Option<Client>,
    heard: mpsc::Receiver<(Instant, Heard)>,
    /// Tokens of all who are there.
    present: Arc<Mutex<BTreeSet<String>>>,
    _presence: Subscriber<()>,
    maker: Maker,
}

fn encoded(message: &impl Serialize) -> Result<Vec<u8>, MiddlewareError> {
    let body = cdr_encoding::to_vec::<_, LittleEndian>(message);
    let mut bytes = LITTLE_ENDIAN.to_vec();
    bytes.extend(body.map_err(|error| MiddlewareError::from(error.to_string()))?);
    Ok(bytes)
}

/// `None`: it is no such message.
fn decoded<M: DeserializeOwned>(bytes: &[u8]) -> Option<M> {
    let (head, body) = bytes.split_at_checked(LITTLE_ENDIAN.len())?;
    let read = match head {
        [0, 1, ..] => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        [0, 0, ..] => cdr_encoding::from_bytes::<M, BigEndian>(body),
        _ => return None,
    };
    read.ok().map(|(message, _)| message)
}

/// Identifies a publisher or client, as `rmw_zenoh` attaches it to each message.
struct Origin {
    _token: LivelinessToken,
    who: [u8; 16],
    number: i64,
}

impl Origin {
    /// The attachment of the next message: its number, the time and the sender.
    fn attachment(&mut self) -> Vec<u8> {
        self.number += 1;
        let mut bytes = self.number.to_le_bytes().to_vec();
        bytes.extend(now_ns());
        bytes.push(16);
        bytes.extend(self.who);
        bytes
    }
}

fn now_ns() -> [u8; 8] {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now_ns = i64::try_from(now.unwrap_or_default().as_nanos());
    now_ns.unwrap_or(i64::MAX).to_le_bytes()
}

/// An answer has what its question had attached, and a time of its own.
fn returned(attachment: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = attachment.to_vec();
    bytes.get_mut(8..16)?.copy_from_slice(&now_ns());
    Some(bytes)
}

/// Where messages go out.
struct Outlet {
    publisher: Publisher<'static>,
    origin: Origin,
}

impl Outlet {
    fn put(&mut self, message: &impl Serialize) -> Result<(), MiddlewareError> {
        let message = self.publisher.put(encoded(message)?);
        let put = message.attachment(self.origin.attachment()).wait();
        put.map_err(|error| MiddlewareError::from(error.to_string()))
    }
}

/// Calls the vehicle's own service.
struct Client {
    entity: Entity,
    origin: Origin,
    /// What was asked for last.
    asked: Arc<AtomicBool>,
}

/// Makes what goes through topics and services.
struct Maker {
    session: Session,
    domain: u16,
    has_hashes: bool,
    sender: Sender,
    made: usize,
    subscribers: Vec<(Subscriber<()>, Origin)>,
    servers: Vec<(Queryable<()>, Origin)>,
    _node: LivelinessToken,
}

impl Maker {
    fn new(
        session: Session,
        domain: u16,
        has_hashes: bool,
        sender: Sender,
    ) -> Result<Self, MiddlewareError> {
        let token = names::node_token(domain, &session.zid().to_string());
        let node = session.liveliness().declare_token(token).wait();
        Ok(Self {
            _node: node.map_err(failed("node"))?,
            session,
            domain,
            has_hashes,
            sender,
            made: 0,
            subscribers: Vec::new(),
            servers: Vec::new(),
        })
    }

    /// Tells everybody that we have a role; who we are in it.
    fn announced(
        &mut self,
        role: Role,
        entity: &Entity,
        is_reliable: bool,
        depth: usize,
    ) -> Result<Origin, MiddlewareError> {
        self.made += 1;
        let session = self.session.zid().to_string();
        let quality = (is_reliable, depth);
        let token = names::token(self.domain, &session, self.made, role, entity, quality);
        let mut who = [0; 16];
        who.copy_from_slice(&Sha256::digest(&token)[..16]);
        let token = self.session.liveliness().declare_token(token).wait();
        Ok(Origin { _token: token.map_err(failed(&entity.name))?, who, number: 0 })
    }

    fn outlet(&mut self, entity: &Entity, depth: usize) -> Result<Outlet, MiddlewareError> {
        let key = entity.key(self.domain);
        // Not kept back to be sent with others; dropped rather than waited for where a link is congested.
        let publisher = self.session.declare_publisher(key).express(true).wait();
        Ok(Outlet {
            publisher: publisher.map_err(failed(&entity.name))?,
            origin: self.announced(Role::Publisher, entity, true, depth)?,
        })
    }

    fn topic(&self, name: &str, kind: wire::Kind) -> Entity {
        Entity::topic(name, kind, self.has_hashes)
    }

    fn serve<R: Request + DeserializeOwned>(
        &mut self,
        name: &str,
        kind: wire::Kind,
    ) -> Result<(), MiddlewareError> {
        let entity = Entity::service(name, kind, self.has_hashes);
        let sender = self.sender.clone();
        let queryable =
            self.session.declare_queryable(entity.key(self.domain)).complete(true).callback(
                move |query| {
                    if let Some(heard) = obeyed::<R>(&query) {
                        let _ = sender.send((Instant::now(), heard));
                    }
                },
            );
        let queryable = queryable.wait().map_err(failed(name))?;
        let origin = self.announced(Role::Server, &entity, true, WAITING)?;
        self.servers.push((queryable, origin));
        Ok(())
    }
}

impl Listener for Maker {
    fn hear<M: DeserializeOwned + Send + 'static>(
        &mut self,
        (name, kind, is_reliable): Source,
        heard: impl Fn(M) -> Option<Heard> + Send + Sync + 'static,
    ) -> Result<(), MiddlewareError> {
        let entity = self.topic(name, kind);
        let sender = self.sender.clone();
        let subscriber =
            self.session.declare_subscriber(entity.key(self.domain)).callback(move |sample| {
                let message = decoded(&sample.payload().to_bytes());
                if let Some(heard) = message.and_then(&heard) {
                    // Nobody takes it once the trial is over.
                    let _ = sender.send((Instant::now(), heard));
                }
            });
        let subscriber = subscriber.wait().map_err(failed(name))?;
        let origin = self.announced(Role::Subscriber, &entity, is_reliable, WAITING)?;
        self.subscribers.push((subscriber, origin));
        Ok(())
    }
}

/// Answers a call of one of our services; what it is for us.
fn obeyed<R: Request + DeserializeOwned>(query: &Query) -> Option<Heard> {
    let request: R = decoded(&query.payload()?.to_bytes())?;
    let (heard, answer) = request.obeyed();
    let attachment = query.attachment();
    let attachment = attachment.and_then(|bytes| returned(&bytes.to_bytes()));
    // One that cannot be answered is obeyed all the same.
    if let Ok(answer) = encoded(&answer) {
        let reply = query.reply(query.key_expr().clone(), answer);
        let _ = reply.attachment(attachment).wait();
    }
    Some(heard)
}

/// Links are called only, and none is looked for.
fn config(zenoh: &Zenoh) -> Result<Config, MiddlewareError> {
    let (mode, asks_others) = match zenoh.mode {
        ZenohMode::Client => ("client", false),
        ZenohMode::Peer => ("peer", true),
    };
    let mut config = Config::default();
    for (key, value) in [
        ("mode", format!("{mode:?}")),
        ("connect/endpoints", format!("[{:?}]", zenoh.endpoint)),
        ("connect/timeout_ms", CONNECT_MS.to_string()),
        ("connect/exit_on_failure", true.to_string()),
        ("listen/endpoints", "[]".into()),
        ("scouting/multicast/enabled", false.to_string()),
        ("scouting/gossip/enabled", asks_others.to_string()),
    ] {
        config.insert_json5(key, &value).map_err(failed(key))?;
    }
    Ok(config)
}

impl OverZenoh {
    /// Connects to what a description says and makes what it names.
    pub fn open(description: Description, zenoh: &Zenoh) -> Result<Self, MiddlewareError> {
        description.check().map_err(|error| error.to_string())?;
        let endpoint = zenoh.endpoint.as_str();
        let session = ::zenoh::open(config(zenoh)?).wait().map_err(|error| {
            format!("nobody answers at {endpoint}: start the router there, or correct zenoh.endpoint ({error})")
        })?;
        let present: Arc<Mutex<BTreeSet<String>>> = Arc::default();
        let seen = Arc::clone(&present);
        let presence = session
            .liveliness()
            .declare_subscriber(names::tokens(description.domain))
            .history(true)
            .callback(move |sample| {
                let token = sample.key_expr().as_str();
                let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
                match sample.kind() {
                    SampleKind::Put => seen.insert(token.into()),
                    SampleKind::Delete => seen.remove(token),
                };
            });
        let presence = presence.wait().map_err(failed("presence"))?;
        let (sender, heard) = mpsc::channel();
        let mut maker = Maker::new(session, description.domain, zenoh.type_hashes, sender)?;
        maker.hear_all(&description)?;
        maker.serve::<TriggerRequest>(&description.named(ABORT_SERVICE), wire::TRIGGER)?;
        maker.serve::<SetBoolRequest>(&description.named(ENABLE_SERVICE), wire::SET_BOOL)?;
        let mut commands = Vec::new();
        for (topic, kind) in description.command_topics() {
            let entity = maker.topic(&topic, wire::kind_of_command(kind));
            let outlet = maker.outlet(&entity, 1)?;
            commands.push((entity, outlet));
        }
        let diagnostics = maker.topic(DIAGNOSTICS_TOPIC, wire::DIAGNOSTIC_ARRAY);
        let diagnostics = maker.outlet(&diagnostics, WAITING)?;
        let client = match &description.enable {
            Some(enable) => {
                let entity = Entity::service(&enable.service, wire::SET_BOOL, zenoh.type_hashes);
                Some(Client {
                    origin: maker.announced(Role::Client, &entity, true, WAITING)?,
                    entity,
                    asked: Arc::default(),
                })
            }
            None => None,
        };
        Ok(Self {
            description,
            begin: Instant::now(),
            commands,
            diagnostics,
            client,
            heard,
            present,
            _presence: presence,
            maker,
        })
    }

    /// Shows rows of a trial as messages.
    pub fn estimates(&mut self) -> Result<EstimateTopic, MiddlewareError> {
        let name = self.description.named(ESTIMATE_TOPIC);
        let entity = self.maker.topic(&name, wire::FLOAT64_MULTI_ARRAY);
        let mut outlet = self.maker.outlet(&entity, WAITING)?;
        Ok(EstimateTopic::new(move |estimate| outlet.put(&Float64MultiArray::from(estimate))))
    }
}

impl Graph for OverZenoh {
    fn now_s(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)> {
        next_heard(&self.heard, self.begin, until_s - self.now_s())
    }

    fn command(&mut self, demand: Demand) {
        for command in self.description.commands(demand) {
            let outlet = self.commands.iter_mut().find(|(entity, _)| entity.name == command.topic);
            if let Some((_, outlet)) = outlet {
                // What cannot be published now is sent again soon.
                let _ = outlet.put(&CommandMessage::from(command));
            }
        }
    }

    fn enable(&mut self, is_on: bool) {
        let Some(client) = &mut self.client else {
            return;
        };
        client.asked.store(is_on, Ordering::Relaxed);
        let asked = Arc::clone(&client.asked);
        let sender = self.maker.sender.clone();
        // Asked again soon where it does not go out.
        let Ok(request) = encoded(&SetBoolRequest { data: is_on }) else {
            return;
        };
        let _ = self
            .maker
            .session
            .get(client.entity.key(self.description.domain))
            .payload(request)
            .attachment(client.origin.attachment())
            .target(QueryTarget::AllComplete)
            .consolidation(ConsolidationMode::None)
            .timeout(ANSWER)
            .callback(move |reply| {
                let sample = reply.result().ok();
                let answer = sample.and_then(|sample| decoded(&sample.payload().to_bytes()));
                // A late answer to another question is none.
                if let Some(Answer { success, .. }) = answer
                    && asked.load(Ordering::Relaxed) == is_on
                {
                    let _ = sender.send((Instant::now(), Heard::Answered(success)));
                }
            })
            .wait();
    }

    fn matched(&self) -> GraphPeers {
        let present = self.present.lock().unwrap_or_else(PoisonError::into_inner);
        let announced: Vec<_> =
            present.iter().filter_map(|token| Announcement::parse(token)).collect();
        let us = self.maker.session.zid().to_string();
        let mut matched = GraphPeers::default();
        for (entity, _) in &self.commands {
            let is_heard = announced.iter().any(|other| other.uses(Role::Subscriber, entity));
            if !is_heard {
                matched.not_heard.push(entity.name.clone());
            }
            let is_shared = announced
                .iter()
                .any(|other| other.session != us && other.is_on(Role::Publisher, &entity.name));
            if is_shared {
                matched.shared.push(entity.name.clone());
            }
        }
        matched.has_enable = self.client.as_ref().is_some_and(|client| {
            let is_there = |other: &Announcement<'_>| other.uses(Role::Server, &client.entity);
            announced.iter().any(is_there)
        });
        matched
    }

    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        // A diagnosis that cannot be published is followed by the next.
        let _ = self.diagnostics.put(&DiagnosticArray::from(diagnosis));
    }
}

impl Drop for OverZenoh {
    fn drop(&mut self) {
        // Tells others that we are gone; else they wait for a timeout.
        let _ = self.maker.session.close().wait();
    }
}
