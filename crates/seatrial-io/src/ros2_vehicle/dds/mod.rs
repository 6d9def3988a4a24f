//! The graph over DDS, as `rmw_fastrtps` and `rmw_cyclonedds` use it: no ROS installation is needed.

mod wire;

use std::future::ready;
use std::io;
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use futures::channel::oneshot;
use futures::executor::block_on;
use futures::future::select;
use futures::stream::{LocalBoxStream, StreamExt, select_all};
use ros2_client::dds::rustdds::policy::Durability as ReaderDurability;
use ros2_client::dds::rustdds::{DomainParticipant, DomainParticipantBuilder, RTPSEntity};
use ros2_client::dds::{Client, Context, Node, Publisher, Server, ServiceMapping, Subscription};
use ros2_client::node_options::NodeOptions;
use ros2_client::qos::{History, QosProfile, WhenFull};
use ros2_client::{MessageTypeName, Name, NodeName, ServiceTypeName};
use serde::Serialize;

use super::{
    ABORT_SERVICE, CommandType, Demand, Description, Diagnosis, ENABLE_SERVICE, FeedbackType,
    Graph, Heard, Matched, Middleware,
};
use crate::{Row, RowWriter};
use wire::{Answer, SetBoolRequest, TriggerRequest};

/// The topic of estimates and what its numbers are.
const ESTIMATE_TOPIC: &str = "/seatrial/estimate";
const ESTIMATE_LABEL: &str = "time_s,a22_per_s,b2_per_s2,c0_rad_per_s2,half_width_a22_per_s,half_width_b2_per_s2,half_width_c0_rad_per_s2,step_norm";
/// Messages of one topic that may wait to be read.
const WAITING: usize = 64;

/// A publisher of commands.
enum CommandPublisher {
    Float64(Publisher<wire::Float64>),
    Float32(Publisher<wire::Float32>),
    Float64MultiArray(Publisher<wire::Float64MultiArray>),
    Twist(Publisher<wire::Twist>),
    TwistStamped(Publisher<wire::TwistStamped>),
}

/// A vehicle's topics and services over DDS.
pub struct Dds {
    description: Description,
    begin: Instant,
    participant: DomainParticipant,
    publishers: Vec<(String, CommandPublisher)>,
    diagnostics: Publisher<wire::DiagnosticArray>,
    client: Option<Client<SetBoolRequest, Answer>>,
    heard: mpsc::Receiver<(Instant, Heard)>,
    /// Ends the thread that listens.
    hang_up: Option<oneshot::Sender<()>>,
    listening: Option<JoinHandle<()>>,
    // After everything that it has made.
    node: Node,
}

/// What is listened to.
struct Ears {
    imu: Option<Subscription<wire::Imu>>,
    odometry: Option<Subscription<wire::Odometry>>,
    joints: Option<(Subscription<wire::JointState>, String)>,
    float64: Option<Subscription<wire::Float64>>,
    float32: Option<Subscription<wire::Float32>>,
    abort: Server<TriggerRequest, Answer>,
    enable: Server<SetBoolRequest, Answer>,
}

/// Says what could not be made.
fn failed<E: std::fmt::Display>(what: &str) -> impl FnOnce(E) -> String + '_ {
    move |error| format!("{what}: {error}")
}

fn qos(is_reliable: bool) -> QosProfile {
    let history = History::KeepLast { depth: WAITING };
    let profile = QosProfile::subscription_default().history(history);
    match is_reliable {
        true => profile.reliability_reliable(WhenFull::Fail),
        false => profile,
    }
}

/// Of commands: the newest counts, and publishing never waits.
fn newest() -> QosProfile {
    qos(true).history(History::KeepLast { depth: 1 })
}

/// Makes topics, and with them what goes through them.
struct Maker {
    node: Node,
    mapping: ServiceMapping,
}

impl Maker {
    fn topic(
        &self,
        name: &str,
        [package, kind]: [&str; 2],
        qos: &QosProfile,
    ) -> Result<ros2_client::dds::rustdds::Topic, String> {
        let parsed = Name::parse(name).map_err(failed(name))?;
        let kind = MessageTypeName::new(package, kind);
        let topic = self.node.create_topic(&parsed, kind, qos);
        topic.map_err(failed(name))
    }

    fn publisher<M: Serialize>(
        &mut self,
        name: &str,
        kind: [&str; 2],
        qos: QosProfile,
    ) -> Result<Publisher<M>, String> {
        let topic = self.topic(name, kind, &qos)?;
        let publisher = self.node.create_publisher(&topic, Some(qos));
        publisher.map_err(failed(name))
    }

    fn subscription<M: 'static>(
        &mut self,
        name: &str,
        kind: [&str; 2],
        is_reliable: bool,
    ) -> Result<Subscription<M>, String> {
        let qos = qos(is_reliable);
        let topic = self.topic(name, kind, &qos)?;
        let subscription = self.node.create_subscription(&topic, Some(qos));
        subscription.map_err(failed(name))
    }

    fn server<R: ros2_client::Message + Clone + 'static>(
        &mut self,
        name: &str,
        kind: &str,
    ) -> Result<Server<R, Answer>, String> {
        let parsed = Name::parse(name).map_err(failed(name))?;
        let kind = ServiceTypeName::new("std_srvs", kind);
        let server = self
            .node
            .create_server(self.mapping, &parsed, &kind, qos(true), qos(true));
        server.map_err(failed(name))
    }

    fn command(&mut self, name: &str, kind: CommandType) -> Result<CommandPublisher, String> {
        let type_name = type_name(kind);
        Ok(match kind {
            CommandType::Float64 => {
                CommandPublisher::Float64(self.publisher(name, type_name, newest())?)
            }
            CommandType::Float32 => {
                CommandPublisher::Float32(self.publisher(name, type_name, newest())?)
            }
            CommandType::Float64MultiArray => {
                CommandPublisher::Float64MultiArray(self.publisher(name, type_name, newest())?)
            }
            CommandType::Twist => {
                CommandPublisher::Twist(self.publisher(name, type_name, newest())?)
            }
            CommandType::TwistStamped => {
                CommandPublisher::TwistStamped(self.publisher(name, type_name, newest())?)
            }
        })
    }

    fn ears(&mut self, description: &Description) -> Result<Ears, String> {
        let mut ears = Ears {
            imu: None,
            odometry: None,
            joints: None,
            float64: None,
            float32: None,
            abort: self.server(ABORT_SERVICE, "Trigger")?,
            enable: self.server(ENABLE_SERVICE, "SetBool")?,
        };
        if let Some(imu) = &description.imu {
            let kind = ["sensor_msgs", "Imu"];
            ears.imu = Some(self.subscription(&imu.topic, kind, imu.reliable)?);
        }
        if let Some(odometry) = &description.odometry {
            let kind = ["nav_msgs", "Odometry"];
            ears.odometry = Some(self.subscription(&odometry.topic, kind, odometry.reliable)?);
        }
        if let Some(feedback) = &description.feedback {
            let (topic, is_reliable) = (&feedback.topic, feedback.reliable);
            match feedback.kind {
                FeedbackType::JointState => {
                    let kind = ["sensor_msgs", "JointState"];
                    let joint = feedback.joint.clone().unwrap_or_default();
                    ears.joints = Some((self.subscription(topic, kind, is_reliable)?, joint));
                }
                FeedbackType::Float64 => {
                    let kind = ["std_msgs", "Float64"];
                    ears.float64 = Some(self.subscription(topic, kind, is_reliable)?);
                }
                FeedbackType::Float32 => {
                    let kind = ["std_msgs", "Float32"];
                    ears.float32 = Some(self.subscription(topic, kind, is_reliable)?);
                }
            }
        }
        Ok(ears)
    }
}

/// Package and name of a type.
fn type_name(kind: CommandType) -> [&'static str; 2] {
    match kind {
        CommandType::Float64 => ["std_msgs", "Float64"],
        CommandType::Float32 => ["std_msgs", "Float32"],
        CommandType::Float64MultiArray => ["std_msgs", "Float64MultiArray"],
        CommandType::Twist => ["geometry_msgs", "Twist"],
        CommandType::TwistStamped => ["geometry_msgs", "TwistStamped"],
    }
}

impl Dds {
    /// Joins the domain of a description and makes what it names.
    pub fn open(description: Description) -> Result<Self, String> {
        description.check()?;
        if !description.listens_on_all_addresses {
            return Err(format!(
                "the sockets of DDS take packets on every address of this machine (UDP ports {} to {}), though only {:?} is announced: keep strangers out with a firewall and say listens_on_all_addresses = true",
                7400 + 250 * u32::from(description.domain),
                7649 + 250 * u32::from(description.domain),
                description.addresses
            ));
        }
        let participant = DomainParticipantBuilder::new(description.domain)
            .with_only_networks(description.addresses.clone())
            .build()
            .map_err(failed("DDS"))?;
        let context =
            Context::from_domain_participant(participant.clone()).map_err(failed("DDS"))?;
        let name = NodeName::new("/", "seatrial").map_err(failed("node"))?;
        let options = NodeOptions::new()
            .enable_rosout(false)
            .start_parameter_services(false);
        let node = context.new_node(name, options).map_err(failed("node"))?;
        let mut maker = Maker {
            node,
            mapping: match description.services {
                Middleware::FastRtps => ServiceMapping::Enhanced,
                Middleware::CycloneDds => ServiceMapping::Cyclone,
            },
        };
        let mut publishers = Vec::new();
        for (topic, kind) in description.command_topics() {
            publishers.push((topic.to_string(), maker.command(topic, kind)?));
        }
        let kind = ["diagnostic_msgs", "DiagnosticArray"];
        let diagnostics = maker.publisher("/diagnostics", kind, qos(true))?;
        let client = match &description.enable {
            Some(enable) => {
                let name = Name::parse(&enable.service).map_err(failed(&enable.service))?;
                let kind = ServiceTypeName::new("std_srvs", "SetBool");
                let client =
                    maker
                        .node
                        .create_client(maker.mapping, &name, &kind, qos(true), qos(true));
                Some(client.map_err(failed(&enable.service))?)
            }
            None => None,
        };
        let ears = maker.ears(&description)?;
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
            node: maker.node,
        })
    }

    /// Shows rows of a trial as messages.
    pub fn estimates(&mut self) -> Result<EstimateTopic, String> {
        let parsed = Name::parse(ESTIMATE_TOPIC).map_err(failed(ESTIMATE_TOPIC))?;
        let kind = MessageTypeName::new("std_msgs", "Float64MultiArray");
        let topic = self
            .node
            .create_topic(&parsed, kind, &qos(true))
            .map_err(failed(ESTIMATE_TOPIC))?;
        let publisher = self.node.create_publisher(&topic, Some(qos(true)));
        Ok(EstimateTopic(publisher.map_err(failed(ESTIMATE_TOPIC))?))
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

/// Hands on what comes until the other end hangs up.
fn listen(ears: &Ears, sender: &mpsc::Sender<(Instant, Heard)>, until: oneshot::Receiver<()>) {
    let mut streams: Vec<LocalBoxStream<'_, Option<Heard>>> = Vec::new();
    if let Some(imu) = &ears.imu {
        let stream = imu.async_stream();
        streams.push(
            stream
                .map(|read| read.ok().map(|(imu, _)| Heard::Imu(imu.motion())))
                .boxed_local(),
        );
    }
    if let Some(odometry) = &ears.odometry {
        let stream = odometry.async_stream();
        streams.push(
            stream
                .map(|read| read.ok().map(|(odom, _)| Heard::Odometry(odom.motion())))
                .boxed_local(),
        );
    }
    if let Some((joints, joint)) = &ears.joints {
        let heard = move |state: wire::JointState| {
            let (stamp_s, units) = state.position(joint)?;
            Some(Heard::Rudder {
                stamp_s: Some(stamp_s),
                units,
            })
        };
        let stream = joints.async_stream();
        streams.push(
            stream
                .map(move |read| read.ok().and_then(|(state, _)| heard(state)))
                .boxed_local(),
        );
    }
    let unstamped = |units: f64| Heard::Rudder {
        stamp_s: None,
        units,
    };
    if let Some(float64) = &ears.float64 {
        let stream = float64.async_stream();
        streams.push(
            stream
                .map(move |read| read.ok().map(|(number, _)| unstamped(number.data)))
                .boxed_local(),
        );
    }
    if let Some(float32) = &ears.float32 {
        let stream = float32.async_stream();
        streams.push(
            stream
                .map(move |read| read.ok().map(|(number, _)| unstamped(number.data.into())))
                .boxed_local(),
        );
    }
    let answer = |text: &str| Answer {
        success: true,
        message: text.into(),
    };
    let aborts = ears.abort.receive_request_stream().map(|read| {
        let (id, _) = read.ok()?;
        // One that cannot be answered is obeyed all the same.
        let _ = ears.abort.send_response(id, answer("the trial ends"));
        Some(Heard::Abort)
    });
    streams.push(aborts.boxed_local());
    let enables = ears.enable.receive_request_stream().map(|read| {
        let (id, request) = read.ok()?;
        let text = match request.data {
            true => "the trial may take the vehicle",
            false => "the trial gives the vehicle back",
        };
        let _ = ears.enable.send_response(id, answer(text));
        Some(Heard::Enable(request.data))
    });
    streams.push(enables.boxed_local());
    let heard = select_all(streams).for_each(|heard| {
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
        let wait_s = until_s - self.now_s();
        let received = match Duration::try_from_secs_f64(wait_s) {
            Ok(wait) => self.heard.recv_timeout(wait).ok(),
            Err(_) => self.heard.try_recv().ok(),
        };
        let (came, heard) = received?;
        let came_s = came.saturating_duration_since(self.begin).as_secs_f64();
        Some((came_s, heard))
    }

    fn command(&mut self, demand: Demand) {
        for command in self.description.commands(demand) {
            let publisher = self
                .publishers
                .iter()
                .find(|(topic, _)| topic == command.topic);
            let Some((_, publisher)) = publisher else {
                continue;
            };
            let first = command.numbers.first().copied().unwrap_or(0.0);
            // What cannot be published now is sent again soon.
            match publisher {
                CommandPublisher::Float64(publisher) => {
                    let _ = publisher.publish(wire::Float64 { data: first });
                }
                CommandPublisher::Float32(publisher) => {
                    let data = first as f32;
                    let _ = publisher.publish(wire::Float32 { data });
                }
                CommandPublisher::Float64MultiArray(publisher) => {
                    let _ = publisher.publish(array("", command.numbers));
                }
                CommandPublisher::Twist(publisher) => {
                    let _ = publisher.publish(wire::Twist::of(&command.numbers));
                }
                CommandPublisher::TwistStamped(publisher) => {
                    let _ = publisher.publish(wire::TwistStamped {
                        header: header(),
                        twist: wire::Twist::of(&command.numbers),
                    });
                }
            }
        }
    }

    fn enable(&mut self, is_on: bool) {
        if let Some(client) = &self.client {
            // Asked again soon where it does not go out.
            let _ = client.send_request(SetBoolRequest { data: is_on });
        }
    }

    fn matched(&self) -> Matched {
        let readers = self.participant.discovered_readers();
        let writers = self.participant.discovered_writers();
        let mut matched = Matched::default();
        for (topic, kind) in self.description.command_topics() {
            let name = format!("rt{topic}");
            let [package, type_name] = type_name(kind);
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
                matched.not_heard.push(topic.into());
            }
            let is_shared = writers.iter().any(|writer| {
                *writer.publication_topic_data.topic_name() == name
                    && !self.is_ours(writer.writer_proxy.remote_writer_guid)
            });
            if is_shared {
                matched.shared.push(topic.into());
            }
        }
        matched.has_enable = self.description.enable.as_ref().is_some_and(|enable| {
            let name = format!("rq{}Request", enable.service);
            readers
                .iter()
                .any(|reader| *reader.subscription_topic_data.topic_name() == name)
        });
        matched
    }

    fn diagnose(&mut self, diagnosis: &Diagnosis) {
        let values = diagnosis.values.iter().map(|(key, value)| wire::KeyValue {
            key: (*key).into(),
            value: value.clone(),
        });
        // A diagnosis that cannot be published is followed by the next.
        let _ = self.diagnostics.publish(wire::DiagnosticArray {
            header: header(),
            status: vec![wire::DiagnosticStatus {
                level: if diagnosis.is_error { 2 } else { 0 },
                name: "seatrial".into(),
                message: diagnosis.message.clone(),
                hardware_id: String::new(),
                values: values.collect(),
            }],
        });
    }
}

impl Drop for Dds {
    fn drop(&mut self) {
        // So that others are told that we are gone, and need not wait until we are forgotten.
        drop(self.hang_up.take());
        if let Some(listening) = self.listening.take() {
            let _ = listening.join();
        }
    }
}

fn header() -> wire::Header {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now = now.unwrap_or_default();
    wire::Header {
        stamp: wire::Stamp {
            sec: i32::try_from(now.as_secs()).unwrap_or(i32::MAX),
            nanosec: now.subsec_nanos(),
        },
        frame_id: String::new(),
    }
}

fn array(label: &str, data: Vec<f64>) -> wire::Float64MultiArray {
    let size = u32::try_from(data.len()).unwrap_or(u32::MAX);
    wire::Float64MultiArray {
        dim: vec![wire::Dimension {
            label: label.into(),
            size,
            stride: size,
        }],
        data_offset: 0,
        data,
    }
}

/// Estimates as messages of `std_msgs/Float64MultiArray`; what is missing is no number.
pub struct EstimateTopic(Publisher<wire::Float64MultiArray>);

impl RowWriter for EstimateTopic {
    fn write(&mut self, row: &Row) -> io::Result<()> {
        let Some(estimate) = row.estimate else {
            return Ok(());
        };
        let mut data = vec![row.sample.time_s];
        data.extend(estimate.model.theta());
        data.extend(estimate.half_widths.unwrap_or([f64::NAN; 3]));
        data.push(estimate.step_norm);
        let published = self.0.publish(array(ESTIMATE_LABEL, data));
        published.map_err(|error| io::Error::other(format!("{ESTIMATE_TOPIC}: {error}")))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(())
    }
}
