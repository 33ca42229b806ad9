//! A run in real time with a scope, and viewers of it.

#[path = "scope_viewer.rs"]
mod viewer;

use flexbeam_files::{CertificateSummary, LiveSettings, RunHeader, Screen};
use flexbeam_runtime::scope::{About, Save, ScopeServer, Token};
use flexbeam_runtime::{Latest, Outcome, Session, Setup, SimulatedBackEnd, Sink, Steering};
use serde_json::{Value, json};
use std::sync::{Arc, Mutex};

use super::scripted::{Ear, open_loop, simulated};
#[allow(unused_imports, reason = "each test uses a part")]
pub use viewer::{Frame, Said, Viewer, handshake, read};

pub const START_UNIX_NS: u64 = 1_764_000_000_123_456_789;

pub fn header(period_s: f64) -> RunHeader {
    RunHeader {
        period_s,
        start_unix_ns: START_UNIX_NS,
        port: "simulated".into(),
        provenance: Default::default(),
        controller: None,
        excitation: None,
    }
}

pub fn about(save: Option<Save>) -> About {
    About {
        controller: "controller.toml".into(),
        project: save.as_ref().map(|_| "beam".into()),
        port: "simulated".into(),
        period_s: 1e-3,
        recording: Some("run.mcap".into()),
        certificate: Some(CertificateSummary { holds: true, note: String::new(), figures: vec![] }),
        screen: Screen::default(),
        save,
        asked: Arc::default(),
    }
}

pub fn server(about: About) -> ScopeServer {
    ScopeServer::open(&"0".parse().unwrap(), Token::new().unwrap(), about).unwrap()
}

pub fn token(server: &ScopeServer) -> String {
    server.url().split_once('#').unwrap().1.into()
}

pub fn enter(server: &ScopeServer, keys: Value) -> Viewer {
    Viewer::enter(&server.address().to_string(), keys)
}

/// What was saved.
pub type Saved = Arc<Mutex<Vec<(Screen, LiveSettings)>>>;

/// A run of the simulated rig, armed at 0 V.
pub struct Run {
    pub session: Session,
    pub server: ScopeServer,
    pub ear: Ear,
    pub saved: Saved,
}

impl Run {
    pub fn armed() -> Run {
        Run::with(|sinks| sinks)
    }

    pub fn with(sinks: impl FnOnce(Vec<Box<dyn Sink>>) -> Vec<Box<dyn Sink>>) -> Run {
        let saved = Saved::default();
        let keep = saved.clone();
        let save: Save = Box::new(move |screen, settings| {
            if screen.scopes.iter().any(|scope| scope.title == "unwritable") {
                return Err("cannot write flexbeam.toml: found no space, needed some\nhint: make room".into());
            }
            keep.lock().unwrap().push((screen.clone(), settings.clone()));
            Ok(())
        });
        let (server, ear, latest) = (server(about(Some(save))), Ear::default(), Latest::default());
        let own: Vec<Box<dyn Sink>> =
            vec![Box::new(ear.clone()), Box::new(latest.clone()), Box::new(server.sink(&header(1e-3)))];
        // No stall of this machine is to end the run.
        let setup = Setup { hold_s: 60.0, autostart: false, ..open_loop(0.5) };
        let rig = SimulatedBackEnd::new(simulated(1)).unwrap();
        let session = Session::arm(Box::new(rig), setup, sinks(own)).unwrap();
        let (controls, live) = (session.controls.clone(), session.live.clone());
        server.steer(Steering { controls, live, latest, period_s: 1e-3 }, session.notes());
        Run { session, server, ear, saved }
    }

    pub fn viewer(&self, name: &str) -> Viewer {
        enter(&self.server, json!({ "token": token(&self.server), "name": name, "key": name }))
    }

    pub fn onlooker(&self) -> Viewer {
        enter(&self.server, json!({}))
    }

    /// To its end; the events of a kind.
    pub fn end(self, kind: &str) -> Vec<String> {
        let (_, ear) = self.finish();
        let heard = ear.0.lock().unwrap();
        heard.events.iter().filter(|event| event.kind.name() == kind).map(|event| event.text.clone()).collect()
    }

    pub fn finish(self) -> (Outcome, Ear) {
        self.session.controls.stop();
        (self.session.finish(), self.ear)
    }
}
