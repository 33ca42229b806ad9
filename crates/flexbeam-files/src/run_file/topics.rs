//! The topics of a run, as a recording declares them and as viewers are told of them.

use super::sample::RunSample;

/// A topic: what its messages are called, and how they are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunTopic {
    /// Name of the topic.
    pub topic: &'static str,
    /// Name of the schema.
    pub schema_name: &'static str,
    /// `ros2msg` or `jsonschema`.
    pub schema_encoding: &'static str,
    /// The schema itself, in the part of its language that viewers understand.
    pub schema: &'static str,
    /// `cdr` or `json`.
    pub message_encoding: &'static str,
}

impl RunTopic {
    /// A [`RunSample`] a tick.
    pub const SIGNALS: RunTopic = RunTopic {
        topic: "/signals",
        schema_name: "flexbeam_msgs/msg/Signals",
        schema_encoding: "ros2msg",
        schema: RunSample::DEFINITION,
        message_encoding: "cdr",
    };

    /// [`LiveSettings`](super::LiveSettings), at the start and at each change.
    pub const SETTINGS: RunTopic = json("/settings", "flexbeam.LiveSettings", SETTINGS);

    /// A [`RunEvent`](super::RunEvent).
    pub const EVENTS: RunTopic = json("/events", "flexbeam.RunEvent", EVENTS);

    /// One object at the end.
    pub const REPORT: RunTopic = json("/report", "flexbeam.RunReport", r#"{"type":"object","properties":{}}"#);
}

const fn json(topic: &'static str, schema_name: &'static str, schema: &'static str) -> RunTopic {
    RunTopic { topic, schema_name, schema_encoding: "jsonschema", schema, message_encoding: "json" }
}

const SETTINGS: &str = r#"{"type":"object","properties":{
"revision":{"type":"integer"},
"tick":{"type":"integer","description":"first period under these settings"},
"settings":{"type":"object","description":"by the names of the controller file","properties":{
"law":{"type":"string"},
"u_p_plus_v":{"type":"number"},"u_p_minus_v":{"type":"number"},
"eps_u_v":{"type":"number"},"eps_e_rad":{"type":"number"},
"hysteresis_u":{"type":"number"},"hysteresis_e":{"type":"number"},
"breakaway_plus_v":{"type":"number"},"breakaway_minus_v":{"type":"number"},
"voltage_limit_v":{"type":"number"},"deflection_limit_rad":{"type":"number"},
"theta_limit_rad":{"type":"number"},"theta_step_limit_rad":{"type":"number"},
"smooth_ticks":{"type":"number"},"smooth_step_rad":{"type":"number"},
"theta":{"type":"object","properties":{
"scale":{"type":"number"},"offset_rad":{"type":"number"},"low_pass":{"type":"number"}}},
"alpha":{"type":"object","properties":{
"scale":{"type":"number"},"offset_rad":{"type":"number"},"low_pass":{"type":"number"}}}}},
"reference":{"type":"object","properties":{
"shape":{"type":"string"},"amplitude_rad":{"type":"number"},"period_s":{"type":"number"},"offset_rad":{"type":"number"}}}}}"#;

const EVENTS: &str = r#"{"type":"object","properties":{
"tick":{"type":"integer"},"time_s":{"type":"number"},"kind":{"type":"string"},"text":{"type":"string"}}}"#;
