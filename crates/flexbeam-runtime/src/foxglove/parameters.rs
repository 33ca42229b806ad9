//! Live settings as parameters: by the keys that `flexbeam tell` changes them with.

use super::ViewersMay;
use super::refusal::NotSet;
use crate::control_socket::Steering;
use crate::printable::fit_to_print;
use crate::recording::run_settings;
use crate::session::Notes;
use crate::sink::EventKind;
use ::foxglove::WebSocketServerHandle;
use ::foxglove::websocket::{
    AnyClient, GetParametersResponder, Parameter, ParameterHandler, ParameterValue, SetParametersResponder,
};
use flexbeam_files::{SettingValue, request_of_changes};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// Refused changes that go into the recording; a viewer that is refused for ever must not fill it.
const MOST_NOTED: usize = 100;

/// The settings of a run, for viewers.
pub(super) struct Parameters {
    may: ViewersMay,
    /// None before the run is armed.
    run: OnceLock<(Steering, Notes)>,
    /// Until it is closed.
    server: Mutex<Option<WebSocketServerHandle>>,
    noted: AtomicUsize,
}

impl Parameters {
    pub(super) fn new(may: ViewersMay) -> Parameters {
        Parameters { may, run: OnceLock::new(), server: Mutex::default(), noted: AtomicUsize::new(0) }
    }

    pub(super) fn serve(&self, server: WebSocketServerHandle) {
        *self.server() = Some(server);
    }

    pub(super) fn close(&self) -> Option<WebSocketServerHandle> {
        self.server().take()
    }

    pub(super) fn steer(&self, steering: Steering, notes: Notes) {
        // The first run stays: its sink and its settings belong together.
        let _ = self.run.set((steering, notes));
        self.publish(&self.current());
    }

    /// To every viewer that subscribed to them.
    pub(super) fn publish(&self, settings: &[(String, SettingValue)]) {
        if let Some(server) = self.server().as_ref() {
            server.publish_parameter_values(settings.iter().map(parameter).collect());
        }
    }

    fn server(&self) -> MutexGuard<'_, Option<WebSocketServerHandle>> {
        self.server.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn current(&self) -> Vec<(String, SettingValue)> {
        self.run.get().map(|(steering, _)| run_settings(0, &steering.live.current()).by_key()).unwrap_or_default()
    }

    fn named(&self, names: &[String]) -> Vec<(String, SettingValue)> {
        self.current().into_iter().filter(|(key, _)| names.contains(key)).collect()
    }

    /// All of the changes, or none.
    fn change(&self, parameters: &[Parameter]) -> Result<(), NotSet> {
        let names = || parameters.iter().map(|parameter| parameter.name.clone()).collect();
        if self.may == ViewersMay::Look {
            return Err(NotSet::ReadOnly(names()));
        }
        let (steering, _) = self.run.get().ok_or_else(|| NotSet::NotArmed(names()))?;
        let changes = parameters.iter().map(change).collect::<Result<Vec<_>, _>>()?;
        let request = request_of_changes(&changes).map_err(|reason| NotSet::NoSetting { names: names(), reason })?;
        let reply = steering.obey(&request);
        reply.error.map_or(Ok(()), |error| Err(NotSet::Refused(error)))
    }

    fn note(&self, refused: &str) {
        let first = refused.lines().next().unwrap_or_default();
        let so_far = self.noted.fetch_add(1, Ordering::Relaxed);
        let Some((_, notes)) = self.run.get().filter(|_| so_far < MOST_NOTED) else { return };
        let last = if so_far + 1 == MOST_NOTED { "; further ones are not noted" } else { "" };
        notes.note(EventKind::Warning, format!("a viewer's change was refused: {first}{last}"));
    }
}

impl ParameterHandler for Parameters {
    fn get(&self, _client: AnyClient, names: Vec<String>, _request: Option<String>, responder: GetParametersResponder) {
        let found = if names.is_empty() { self.current() } else { self.named(&names) };
        responder.respond(found.iter().map(parameter).collect());
    }

    /// A viewer that was refused shows the old value again. Of a change that was made all subscribers hear when it is in force.
    fn set(
        &self,
        client: AnyClient,
        parameters: Vec<Parameter>,
        _request: Option<String>,
        responder: SetParametersResponder,
    ) {
        let changed = self.change(&parameters);
        let names: Vec<String> = parameters.into_iter().map(|parameter| parameter.name).collect();
        let found = self.named(&names);
        responder.respond(found.iter().map(parameter).collect());
        if let Err(refused) = changed {
            let refused = fit_to_print(&refused.to_string());
            self.publish(&found);
            self.note(&refused);
            client.send_warning(refused);
        }
    }
}

fn parameter((key, value): &(String, SettingValue)) -> Parameter {
    match value {
        SettingValue::Number(number) => Parameter::float64(key, *number),
        SettingValue::Word(word) => Parameter::string(key, word),
    }
}

/// As `flexbeam tell` would be given it: KEY=VALUE.
fn change(parameter: &Parameter) -> Result<String, NotSet> {
    let name = &parameter.name;
    if !name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_' || byte == b'.') {
        return Err(NotSet::NoSetting { names: vec![name.clone()], reason: "a name of other letters".into() });
    }
    match &parameter.value {
        Some(ParameterValue::Float64(number)) => Ok(format!("{name}={number:?}")),
        Some(ParameterValue::Integer(number)) => Ok(format!("{name}={number}")),
        Some(ParameterValue::String(word)) => Ok(format!("{name}={word}")),
        _ => Err(NotSet::Value(name.clone())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_what_tell_would_be_given() {
        let texts = [
            Parameter::float64("eps_u_v", 1e-7),
            Parameter::integer("reference.period_s", 2),
            Parameter::string("law", "switched"),
        ]
        .map(|parameter| change(&parameter).unwrap());
        assert_eq!(texts, ["eps_u_v=1e-7", "reference.period_s=2", "law=switched"]);
        assert!(request_of_changes(&texts).is_ok());
    }

    #[test]
    fn what_cannot_be_a_setting_is_refused_before_it_is_read() {
        for refused in [
            Parameter::float64("law=none", 1.0),
            Parameter::float64("\u{1b}[2J", 1.0),
            Parameter::bool("law", true),
            Parameter::float64_array("eps_u_v", [1.0]),
            Parameter::empty("eps_u_v"),
        ] {
            assert!(change(&refused).is_err(), "{refused:?}");
        }
    }
}
