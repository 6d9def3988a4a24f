//! The graph over DDS, as `rmw_fastrtps` and `rmw_cyclonedds` use it: no ROS installation is needed.

use std::future::ready;
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::Instant;

use futures::channel::oneshot;
use futures::executor::block_on;
use futures::future::select;
use futures::stream::{LocalBoxStream, StreamExt, select_all};
use ros2_client::dds::rustdds::policy::Durability as ReaderDurability;
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder, RTPSEntity};
use ros2_client::dds::{Client, Context, Node, Publisher, Server, ServiceMapping, Subscription};
use ros2_client::node_options::NodeOptions;
use ros2_client::qos::{History, QosProfile, WhenFull};
use ros2_client::{Message, MessageTypeName, Name, NodeName, ServiceTypeName};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::wire::{
    self, Answer, CommandMessage, Float64MultiArray, Kind, Request, SetBoolRequest, TriggerRequest,
};
use super::{DIAGNOSTICS_TOPIC, Listener, Source, failed, next_heard};
use crate::ros2_vehicle::{
    ABORT_SERVICE, Demand, Description, Diagnosis, ENABLE_SERVICE, ESTIMATE_TOPIC, EstimateTopic,
    Graph, GraphPeers, Heard, Middleware, MiddlewareError,
};

/// Messages of one topic that may wait to be read.
const WAITING: usize = 64;

/// A vehicle's topics and services over DDS.
pub struct Dds {
    description: Description,
    begin: Instant,
    participant: DomainParticipant,
    publishers: Vec<(String, Publisher<CommandMessage>)>,
    diagnostics: Publisher<wire::DiagnosticArray>,
    client: Option<Client<SetBoolRequest, Answer>>,
    heard: mpsc::Receiver<(Instant, Heard)>,
    /// Ends the thread that listens.
    hang_up: Option<oneshot::Sender<()>>,
    listening: Option<JoinHandle<()>>,
    // After everything that it has made.
    maker: Maker,
}

/// Gives what comes of one topic or service.
trait Ear: Send {
    fn stream(&self) -> LocalBoxStream<'_, Option<Heard>>;
}

/// A topic, and what its messages are for us.
struct TopicEar<M: 'static, F> {
    subscription: Subscription<M>,
    heard: F,
}

impl<M, F> Ear for TopicEar<M, F>
where
    M: DeserializeOwned + Send + 'static,
    F: Fn(M) -> Option<Heard> + Send,
{
    fn stream(&self) -> LocalBoxStream<'_, Option<Heard>> {
        let messages = self.subscription.async_stream();
        let heard = messages.map(|read| read.ok().and_then(|(message, _)| (self.heard)(message)));
        heard.boxed_local()
    }
}

fn qos(is_reliable: bool) -> QosProfile {
    let history = History::KeepLast { depth: WAITING };
    let profile = QosProfile::subscription_default().history(history);
    match is_reliable {
        true => profile.reliability_reliable(WhenFull::Fail),
        false => profile,
    }
}

/// Quality of service of commands: only the newest counts, and publishing never waits.
fn newest() -> QosProfile {
    qos(true).history(History::KeepLast { depth: 1 })
}

/// Makes topics, and with them what goes through them.
struct Maker {
    node: Node,
    mapping: ServiceMapping,
    ears: Vec<Box<dyn Ear>>,
}

impl Maker {
    fn enable_client(
        &mut self,
        service: &str,
    ) -> Result<Client<SetBoolRequest, Answer>, MiddlewareError> {
        let name = Name::parse(service).map_err(failed(service))?;
        let [package, kind] = wire::SET_BOOL;
        let kind = ServiceTypeName::new(package, kind);
        let (to, from) = (qos(true), qos(true));
        let client = self.node.create_client(self.mapping, &name, &kind, to, from);
        client.map_err(failed(service))
    }

    fn topic(
        &self,
        name: &str,
        [package, kind]: Kind,
        qos: &QosProfile,
    ) -> Result<ros2_client::dds::rustdds::Topic, MiddlewareError> {
        let parsed = Name::parse(name).map_err(failed(name))?;
        let kind = MessageTypeName::new(package, kind);
        let topic = self.node.create_topic(&parsed, kind, qos);
        topic.map_err(failed(name))
    }

    fn publisher<M: Serialize>(
        &mut self,
        name: &str,
        kind: Kind,
        qos: QosProfile,
    ) -> Result<Publisher<M>, MiddlewareError> {
        let topic = self.topic(name, kind, &qos)?;
        let publisher = self.node.create_publisher(&topic, Some(qos));
        publisher.map_err(failed(name))
    }

    fn server<R: Message + Clone + 'static>(
        &mut self,
        name: &str,
        [package, kind]: Kind,
    ) -> Result<Server<R, Answer>, MiddlewareError> {
        let parsed = Name::parse(name).map_err(failed(name))?;
        let kind = ServiceTypeName::new(package, kind);
        let server = self.node.create_server(self.mapping, &parsed, &kind, qos(true), qos(true));
        server.map_err(failed(name))
    }
}

impl Listener for Maker {
    fn hear<M: DeserializeOwned + Send + 'static>(
        &mut self,
        (name, kind, is_reliable): Source,
        heard: impl Fn(M) -> Option<Heard> + Send + Sync + 'static,
    ) -> Result<(), MiddlewareError> {
        let qos = qos(is_reliable);
        let topic = self.topic(name, kind, &qos)?;
        let subscription = self.node.create_subscription(&topic, Some(qos));
        self.ears
            .push(Box::new(TopicEar { subscription: subscription.map_err(failed(name))?, heard }));
        Ok(())
    }
}

impl Message for TriggerRequest {}
impl Message for SetBoolRequest {}
impl Message for Answer {}

impl Dds {
    /// Joins the domain of a description and makes what it names.
    pub fn open(description: Description) -> Result<Self, MiddlewareError> {
        description.check().map_err(|error| error.to_string())?;
        if !description.listens_on_all_addresses {
            return Err(format!(
                "the sockets of DDS take packets on every address of this machine (UDP ports {} to {}), though only {:?} is announced: keep strangers out with a firewall and say listens_on_all_addresses = true",
                7400 + 250 * u32::from(description.domain),
                7649 + 250 * u32::from(description.domain),
                description.addresses
            ).into());
        }
        let participant = DomainParticipantBuilder::new(description.domain)
            .with_only_networks(description.addresses.clone())
            .build()
            .map_err(failed("DDS"))?;
        let context =
            Context::from_domain_participant(participant.clone()).map_err(failed("DDS"))?;
        let namespace = match description.namespace.as_str() {
            "" => "/",
            namespace => namespace,
        };
        let name = NodeName::new(namespace, "seatrial").map_err(failed("node"))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(failed("node"))?;
        let mut maker = Maker {
            node,
            mapping: match description.services {
                Middleware::FastRtps => ServiceMapping::Enhanced,
                Middleware::CycloneDds => ServiceMapping::Cyclone,
            },
            ears: Vec::new(),
        };
        let mut publishers = Vec::new();
        for (topic, kind) in description.command_topics() {
            let kind = wire::kind_of_command(kind);
            let publisher = maker.publisher(&topic, kind, newest())?;
            publishers.push((topic, publisher));
        }
        let diagnostics = maker.publisher(DIAGNOSTICS_TOPIC, wire::DIAGNOSTIC_ARRAY, qos(true))?;
        let client = (description.enable.as_ref())
            .map(|enable| maker.enable_client(&enable.service))
            .transpose()?;
        maker.hear_all(&description)?;
        let abort =
            maker.server::<TriggerRequest>(&description.named(ABORT_SERVICE), wire::TRIGGER)?;
        let enable =
            maker.server::<SetBoolRequest>(&description.named(ENABLE_SERVICE), wire::SET_BOOL)?;
        let mut ears = std::mem::take(&mut maker.ears);
        ears.extend([Box::new(abort) as Box<dyn Ear>, Box::new(enable)]);
        let (sender, heard) = mpsc::channel();
        let (hang_up, until) = oneshot::channel();
        let listening = std::thread::Builder::new()
            .name("ros2".into())
            .spawn(move || listen(&ears, &sender, until))
            .map_err(failed("thread"))?;
        Ok(Self {
            description,
            begin: Instant::now(),
            participant,
            publishers,
            diagnostics,
            client,
            heard,
            hang_up: Some(hang_up),
            listening: Some(listening),
            maker,
        })
    }

    /// Shows rows of a trial as messages.
    pub fn estimates(&mut self) -> Result<EstimateTopic, MiddlewareError> {
        let topic = self.maker.publisher(
            &self.description.named(ESTIMATE_TOPIC),
            wire::FLOAT64_MULTI_ARRAY,
            qos(true),
        )?;
        Ok(EstimateTopic::new(move |estimate| {
            let numbers = Float64MultiArray::from(estimate);
            topic.publish(numbers).map_err(|error| MiddlewareError::from(error.to_string()))
        }))
    }

    fn is_ours(&self, guid: ros2_client::dds::rustdds::GUID) -> bool {
        guid.prefix == self.participant.guid().prefix
    }

    /// What the vehicle's own service has answered, if it has.
    fn answer(&self) -> Option<Heard> {
        let (_, answer) = self.client.as_ref()?.receive_response().ok()??;
        Some(Heard::Answered(answer.success))
    }
}

/// Calls of one of our services, which are answered.
impl<R: Request + Message + Clone + Send + 'static> Ear for Server<R, Answer> {
    fn stream(&self) -> LocalBoxStream<'_, Option<Heard>> {
        let calls = self.receive_request_stream().map(|read| {
            let (id, request) = read.ok()?;
            let (heard, answer) = request.obeyed();
            // One that cannot be answered is obeyed all the same.
            let _ = self.send_response(id, answer);
            Some(heard)
        });
        calls.boxed_local()
    }
}

/// Passes on what comes until the other end hangs up.
fn listen(
    ears: &[Box<dyn Ear>],
    sender: &mpsc::Sender<(Instant, Heard)>,
    until: oneshot::Receiver<()>,
) {
    let heard = select_all(ears.iter().map(|ear| ear.stream())).for_each(|heard| {
        if let Some(heard) = heard {
            // Nobody takes it once the trial is over.
            let _ = sender.send((Instant::now(), heard));
        }
        ready(())
    });
    block_on(select(heard, until));
}

impl Graph for Dds {
    fn now_s(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    fn receive(&mut self, until_s: f64) -> Option<(f64, Heard)> {
        if let Some(answer) = self.answer() {
            return Some((self.now_s(), answer));
        }
        next_heard(&self.heard, self.begin, until_s - self.now_s())
    }

    fn command(&mut self, demand: Demand) {
        for command in self.description.commands(demand) {
            let publisher = self.publishers.iter().find(|(topic, _)| *topic == command.topic);
            if let Some((_, publisher)) = publisher {
                // What cannot be published now is sent again soon.
                let _ = publisher.publish(command.into());
            }
        }
    }

    fn enable(&mut self, is_on: bool) {
        if let Some(client) = &self.client {
            // Asked again soon where it does not go out.
            let _ = client.send_request(SetBoolRequest { data: is_on });
        }
    }

    fn matched(&self) -> GraphPeers {
        let readers = self.participant.discovered_readers();
        let writers = self.participant.discovered_writers();
        let mut matched = GraphPeers::default();
        for (topic, kind) in self.description.command_topics() {
            let name = format!("rt{topic}");
            let [package, type_name] = wire::kind_of_command(kind);
            let type_name = format!("{package}::msg::dds_::{type_name}_");
            let is_heard = readers.iter().any(|reader| {
                let data = &reader.subscription_topic_data;
                let is_volatile = data
                    .qos()
                    .durability()
                    .is_none_or(|durability| durability == ReaderDurability::Volatile);
                data.topic_name() == &name && data.type_name() == &type_name && is_volatile
            });
            if !is_heard {
                matched.not_heard.push(topic.clone());
            }
            let is_shared = writers.iter().any(|writer| {
                *writer.publication_topic_data.topic_name() == name
                    && !self.is_ours(writer.writer_proxy.remote_writer_guid)
            });
            if is_shared {
                matched.shared.push(topic);
            }
        }
        matched.has_enable = self.description.enable.as_ref().is_some_and(|enable| {
            let name = format!("rq{}Request", enable.service);
            readers.iter().any(|reader| *reader.subscription_topic_data.topic_name() == name)
        });
        matched
    }

    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        // A diagnosis that cannot be published is followed by the next.
        let _ = self.diagnostics.publish(diagnosis.into());
    }
}

impl Drop for Dds {
    fn drop(&mut self) {
        // Tells others that we are gone; else they wait for a timeout.
        drop(self.hang_up.take());
        if let Some(listening) = self.listening.take() {
            let _ = listening.join();
        }
    }
}
