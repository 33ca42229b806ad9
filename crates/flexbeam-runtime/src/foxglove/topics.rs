//! The topics that viewers subscribe to, and the sink that fills them.

use super::parameters::Parameters;
use crate::cause::RunFault;
use crate::lifecycle::Phase;
use crate::live::Live;
use crate::recording::{Calibration, run_event, run_sample, run_settings};
use crate::sample::Sample;
use crate::sink::{RunEvent, Sink, SinkError};
use ::foxglove::websocket::{ChannelView, Client, ServerListener};
use ::foxglove::{Context, FoxgloveError, PartialMetadata, RawChannel, Schema};
use flexbeam_files::{RunHeader, RunTopic};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Events that are kept for viewers who come later: the newest.
const MOST_EVENTS: usize = 256;

/// The three topics, and what a viewer is told of them when it subscribes in the middle of a run.
pub(super) struct Topics {
    /// The topics live as long as it does.
    _context: Arc<Context>,
    signals: Arc<RawChannel>,
    settings: Arc<RawChannel>,
    events: Arc<RawChannel>,
    told: Mutex<Told>,
}

#[derive(Default)]
struct Told {
    settings: Option<Message>,
    events: VecDeque<Message>,
}

struct Message {
    /// Since 1970-01-01 UTC.
    log_time_ns: u64,
    bytes: Vec<u8>,
}

impl Topics {
    pub(super) fn new(context: &Arc<Context>) -> Result<Topics, FoxgloveError> {
        Ok(Topics {
            _context: context.clone(),
            signals: channel(context, &RunTopic::SIGNALS)?,
            settings: channel(context, &RunTopic::SETTINGS)?,
            events: channel(context, &RunTopic::EVENTS)?,
            told: Mutex::default(),
        })
    }

    fn sample(&self, bytes: &[u8], log_time_ns: u64) {
        self.signals.log_with_meta(bytes, PartialMetadata::with_log_time(log_time_ns));
    }

    fn settings(&self, message: Message) {
        let mut told = self.told();
        message.send(&self.settings);
        told.settings = Some(message);
    }

    fn event(&self, message: Message) {
        let mut told = self.told();
        message.send(&self.events);
        told.events.push_back(message);
        if told.events.len() > MOST_EVENTS {
            told.events.pop_front();
        }
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn channel(context: &Arc<Context>, topic: &RunTopic) -> Result<Arc<RawChannel>, FoxgloveError> {
    let schema = Schema::new(topic.schema_name, topic.schema_encoding, topic.schema.as_bytes());
    context.channel_builder(topic.topic).message_encoding(topic.message_encoding).schema(schema).build_raw()
}

impl Message {
    fn send(&self, channel: &RawChannel) {
        channel.log_with_meta(&self.bytes, PartialMetadata::with_log_time(self.log_time_ns));
    }

    fn send_to(&self, channel: &RawChannel, client: &Client) {
        // Without a number of its own the message would go to everybody.
        if let Some(sink) = client.sink_id() {
            let time = PartialMetadata::with_log_time(self.log_time_ns);
            channel.log_with_meta_to_sink(&self.bytes, time, Some(sink));
        }
    }
}

/// Who subscribes late hears which settings are in force and what has happened. What happens at that very moment may come twice.
impl ServerListener for Topics {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        let told = self.told();
        if channel.id() == self.settings.id() {
            told.settings.iter().for_each(|message| message.send_to(&self.settings, &client));
        } else if channel.id() == self.events.id() {
            told.events.iter().for_each(|message| message.send_to(&self.events, &client));
        }
    }
}

/// Which samples go out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decimation {
    every: u64,
    due: u64,
    last: (Phase, Option<RunFault>),
}

impl Decimation {
    pub(super) fn new(period_s: f64, most_per_s: f64) -> Decimation {
        /// Rounding of 1/(0.001 s * 1000/s).
        const ROUNDING: f64 = 1e-9;
        let every = (1.0 / (period_s * most_per_s) - ROUNDING).ceil().max(1.0) as u64;
        Decimation { every, due: 0, last: (Phase::Configured, None) }
    }

    /// Every so many periods, whatever was missed in between; and always where the run changes its phase or ends.
    fn takes(&mut self, sample: &Sample) -> bool {
        let now = (sample.phase, sample.fault);
        let takes = sample.instant >= self.due || now != self.last;
        if sample.instant >= self.due {
            self.due = (sample.instant / self.every + 1) * self.every;
        }
        self.last = now;
        takes
    }
}

/// Brings viewers a run.
pub struct ViewerSink {
    topics: Arc<Topics>,
    parameters: Arc<Parameters>,
    header: RunHeader,
    decimation: Decimation,
    calibration: Calibration,
}

impl ViewerSink {
    pub(super) fn new(
        topics: Arc<Topics>,
        parameters: Arc<Parameters>,
        header: &RunHeader,
        decimation: Decimation,
    ) -> ViewerSink {
        ViewerSink { topics, parameters, header: header.clone(), decimation, calibration: Calibration::default() }
    }
}

impl Sink for ViewerSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.decimation.takes(sample) && self.topics.signals.has_sinks() {
            self.topics
                .sample(&run_sample(sample, &self.calibration).to_cdr(), self.header.log_time_ns(sample.instant));
        }
        Ok(())
    }

    fn settings(&mut self, instant: u64, live: &Live) -> Result<(), SinkError> {
        self.calibration = Calibration::of(live);
        let settings = run_settings(instant, live);
        let log_time_ns = self.header.log_time_ns(instant);
        self.topics.settings(Message { log_time_ns, bytes: settings.to_json() });
        self.parameters.publish(&settings.by_key());
        Ok(())
    }

    fn event(&mut self, event: &RunEvent) -> Result<(), SinkError> {
        let bytes = run_event(event, self.header.period_s).to_json();
        self.topics.event(Message { log_time_ns: self.header.log_time_ns(event.instant), bytes });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(period_s: f64, most_per_s: f64, instants: &[u64]) -> Vec<u64> {
        let mut decimation = Decimation::new(period_s, most_per_s);
        let sample = |instant| Sample { instant, phase: Phase::Configured, ..Sample::default() };
        instants.iter().copied().filter(|k| decimation.takes(&sample(*k))).collect()
    }

    #[test]
    fn no_more_samples_than_asked_for_go_out() {
        let ticks: Vec<u64> = (0..8).collect();
        assert_eq!(taken(1e-3, 1000.0, &ticks), ticks, "1 kHz goes out whole");
        assert_eq!(taken(1e-4, 1000.0, &(0..31).collect::<Vec<_>>()), [0, 10, 20, 30]);
        assert_eq!(taken(1e-3, 400.0, &ticks), [0, 3, 6], "rather fewer than more");
        assert_eq!(taken(1e-3, 1e9, &ticks), ticks);
    }

    #[test]
    fn missed_ticks_do_not_silence_it() {
        assert_eq!(taken(1e-4, 1000.0, &[0, 9, 11, 12, 29, 31, 40]), [0, 11, 29, 31, 40], "30 and 20 were missed");
    }

    #[test]
    fn a_run_s_turns_always_go_out() {
        let mut decimation = Decimation::new(1e-3, 1.0);
        let turns =
            [(0, Phase::Armed), (1, Phase::Armed), (2, Phase::Running), (3, Phase::Running), (4, Phase::Stopped)];
        let went = turns.map(|(instant, phase)| decimation.takes(&Sample { instant, phase, ..Sample::default() }));
        assert_eq!(went, [true, false, true, false, true]);
        let fault = Some(RunFault::Emergency);
        assert!(decimation.takes(&Sample { instant: 5, phase: Phase::Stopped, fault, ..Sample::default() }));
    }
}
