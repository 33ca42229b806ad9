//! Projects: read with places, saved in place.

use flexbeam_files::{
    AmplitudeAxis, Document, Edge, Error, Fault, FrequencyAxis, Law, LiveSettings, Overwrite, Panel, Project,
    ProjectFile, RunReference, RunSample, RunShape, Scope, ScopeKind, Screen, Settings, Tried, Trigger, TriggerMode,
    Written,
};
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Written by a person who explains everything.
const BY_HAND: &str = r##"# My beam.
# Second floor, on the left.

schema = "flexbeam.project/1" # this version
name = "beam" # its name

# The files.
controller = 'controller.toml'   # with law
rig="rig.toml"

# ---- How it runs ----

[run]   # real time
hold_s = 0.05 # a slow machine
seed = 0x7 # lucky

[reference]
# Not more than this.
amplitude_rad = 0.5 # 29 degrees
period_s = 4 # seconds
shape = "square"

[settings]
# Measured in November.
eps_u_v = 0.011
theta.low_pass = 0.6 # 150 Hz

[limits] # of the room
angle_rad = 2 # the wall

# ---- What is watched ----

# The one to look at.
[[scope]] # first
title = "Tip angle" # above it
# What is drawn.
signals = [
  "reference_rad", # asked for
  # the model
  "y_model_rad",
  "psi_rad", # measured
  # and no more
]
span_s = 10 # seconds
range = [-1, 1] # radians

# Stands still.
[scope.trigger] # of the first
signal = "reference_rad" # watched
level = 0.25 # half way

# Volts.
[[scope]] # second
title = "Voltage"
signals = ["voltage_v", "u_v"] # sent and wanted
trigger = { signal = "u_v", level = 1.0 } # on one line

# ---- What is turned ----

# Everything about the law.
[[panel]] # only one
title = "Law" # short
settings = ["law", "eps_u_v"] # two
ranges = { eps_u_v = [0.0, 0.05] } # narrow

# The end.
"##;

fn parse(text: &str) -> Result<Project, Error> {
    Project::parse(text, Path::new("flexbeam.toml"))
}

/// A project's file in a folder, and a run that begins as it says.
struct Bench {
    folder: tempfile::TempDir,
    file: ProjectFile,
}

/// What the controller file says, before the project.
fn of_controller() -> Settings {
    Settings { law: Some(Law::Inverse), eps_u_v: Some(0.02), eps_e_rad: Some(0.003), ..Settings::default() }
}

fn live_of(project: &Project) -> LiveSettings {
    let said = &project.reference;
    LiveSettings {
        revision: 0,
        tick: 0,
        settings: of_controller().with(&project.settings),
        reference: RunReference {
            shape: said.shape.unwrap_or(RunShape::Step),
            amplitude_rad: said.amplitude_rad.unwrap_or(0.1),
            period_s: said.period_s.unwrap_or(4.0),
            offset_rad: said.offset_rad.unwrap_or(0.0),
        },
    }
}

impl Bench {
    fn new(text: &str) -> Bench {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(Project::FILE);
        std::fs::write(&path, text).unwrap();
        let file = ProjectFile::open(&path, &live_of(&parse(text).unwrap()), &[], None).unwrap();
        Bench { folder, file }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join(Project::FILE)
    }

    fn text(&self) -> String {
        std::fs::read_to_string(self.path()).unwrap()
    }

    fn project(&self) -> Project {
        Project::read(&self.path()).unwrap()
    }

    fn saved(&self, screen: &Screen, live: &LiveSettings) -> String {
        self.file.save(screen, live).unwrap();
        let text = self.text();
        assert_eq!(self.file.save(screen, live).unwrap(), Written::Unchanged);
        text
    }
}

/// The hand-written text with changes, each of a part that stands there once.
fn with(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(BY_HAND.to_string(), |text, (part, other)| {
        assert_eq!(text.matches(part).count(), 1, "{part}");
        text.replace(part, other)
    })
}

#[test]
fn what_is_written_by_hand_is_read() {
    let project = parse(BY_HAND).unwrap();
    assert_eq!((project.run.hold_s, project.run.seed), (Some(0.05), Some(7)));
    assert_eq!((project.reference.shape, project.reference.period_s), (Some(RunShape::Square), Some(4.0)));
    assert_eq!(project.settings.theta.unwrap().low_pass, Some(0.6));
    assert_eq!(project.limits.angle_rad, Some(2.0));
    assert_eq!(project.scopes[0].signals, ["reference_rad", "y_model_rad", "psi_rad"]);
    assert_eq!(project.scopes[0].trigger.as_ref().unwrap().before, 0.1);
    assert_eq!(project.panels[0].ranges["eps_u_v"], [0.0, 0.05]);
}

#[test]
fn what_makes_no_sense_is_named_with_its_place() {
    let range = |key: &str, found: f64, needed: &'static str| Fault::Range { key: key.into(), found, needed };
    let schema = Fault::Schema { found: "flexbeam.project/2".into(), needed: "flexbeam.project/1" };
    let beyond =
        Fault::Beyond { key: "settings.theta_limit_rad".into(), found: 2.5, most: 2.0, limit: "limits.angle_rad" };
    let cases = [
        ("project/1", "project/2", 4, 10, schema),
        ("hold_s = 0.05", "hold_s = 0", 14, 10, range("run.hold_s", 0.0, "a positive number")),
        ("period_s = 4", "period_s = -4", 20, 12, range("reference.period_s", -4.0, "a positive number")),
        ("\"square\"", "\"file\"", 17, 1, Fault::MissingKey { key: "reference.file".into() }),
        ("eps_u_v = 0.011", "eps_u_v = -1", 25, 11, range("settings.eps_u_v", -1.0, "zero or a positive number")),
        ("eps_u_v = 0.011", "theta_limit_rad = 2.5", 25, 19, beyond),
        ("angle_rad = 2", "angle_rad = 0", 29, 13, range("limits.angle_rad", 0.0, "a positive number")),
        ("span_s = 10", "span_s = 0", 44, 10, range("scope(1).span_s", 0.0, "a positive number")),
    ];
    for (part, other, line, column, fault) in cases {
        let error = parse(&with(&[(part, other)])).unwrap_err();
        assert_eq!(*error.fault, fault, "{error}");
        assert_eq!((error.place.line, error.place.column), (Some(line), Some(column)), "{error}");
    }
}

#[test]
fn a_signal_or_a_setting_that_is_gone_is_named_with_the_nearest_one() {
    let cases = [
        ("\"psi_rad\", # measured", "\"psy_rad\",", "scope(1).signals(3) = \"psy_rad\"", ":41:3", "psi_rad"),
        ("signal = \"u_v\"", "signal = \"uv\"", "scope(2).trigger.signal = \"uv\"", ":56:22", "u_v"),
        ("\"law\", \"eps_u_v\"", "\"law\", \"eps_v\"", "panel(1).settings(2) = \"eps_v\"", ":63:20", "eps_u_v"),
        ("{ eps_u_v =", "{ law =", "an unknown key panel(1).ranges.law", ":64:10", ""),
        ("hold_s", "holds", "an unknown key run.holds", ":14:1", "hold_s"),
        ("span_s = 10", "kind = \"xyz\"", "scope(1).kind = \"xyz\"", ":44:8", "xy"),
    ];
    for (part, other, found, place, nearest) in cases {
        let message = parse(&with(&[(part, other)])).unwrap_err().to_string();
        assert!(message.contains(found) && message.contains(place), "{message}");
        assert!(message.contains("needed one of ") && message.contains(nearest), "{message}");
        assert!(nearest.is_empty() || message.ends_with(&format!("did you mean {nearest}?")), "{message}");
    }
    let tick = parse(&with(&[("\"y_model_rad\"", "\"tick\"")])).unwrap_err();
    assert!(matches!(&*tick.fault, Fault::Choice { choices, .. } if choices == RunSample::SIGNALS), "{tick}");
}

#[test]
fn files_that_a_run_needs_are_looked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(Project::FILE);
    std::fs::write(&file, BY_HAND).unwrap();
    let missing = |name: &str| {
        let error = Project::open(folder.path()).unwrap_err();
        assert_eq!(*error.fault, Fault::NoSuchFile { key: name.into(), path: format!("{name}.toml") });
        (error.place.line, error.place.column)
    };
    assert_eq!(missing("rig"), (Some(9), Some(5)));
    std::fs::write(folder.path().join("rig.toml"), "").unwrap();
    assert_eq!(missing("controller"), (Some(8), Some(14)));
    std::fs::write(folder.path().join("controller.toml"), "").unwrap();
    assert_eq!(Project::open(folder.path()).unwrap().rig, Some(folder.path().join("rig.toml")));
}

#[test]
fn a_save_without_a_change_touches_nothing() {
    for text in [BY_HAND.to_string(), BY_HAND.replace('\n', "\r\n"), "schema = \"flexbeam.project/1\"".to_string()] {
        let bench = Bench::new(&text);
        let project = bench.project();
        assert_eq!(bench.file.save(&project.screen(), &live_of(&project)).unwrap(), Written::Unchanged);
        assert_eq!(bench.text(), text);
    }
}

#[test]
fn changed_numbers_and_words_keep_their_comments() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let mut screen = project.screen();
    screen.scopes[0].span_s = 2.5;
    screen.scopes[0].range = Some([-1.0, 1.5]);
    screen.scopes[0].trigger.as_mut().unwrap().level = -0.5;
    screen.scopes[0].trigger.as_mut().unwrap().edge = Edge::Falling;
    screen.scopes[1].trigger.as_mut().unwrap().level = 2.0;
    screen.panels[0].ranges.insert("eps_u_v".into(), [0.0, 0.1]);
    let mut live = live_of(&project);
    live.reference.amplitude_rad = 0.25;
    live.reference.offset_rad = 0.1;
    live.settings.eps_u_v = Some(0.012);
    live.settings.eps_e_rad = Some(0.004);
    live.settings.theta.as_mut().unwrap().low_pass = Some(0.7);
    let expected = with(&[
        ("span_s = 10", "span_s = 2.5"),
        ("range = [-1, 1]", "range = [-1, 1.5]"),
        ("level = 0.25 # half way\n", "level = -0.5 # half way\nedge = \"falling\"\n"),
        ("level = 1.0", "level = 2.0"),
        ("[0.0, 0.05]", "[0.0, 0.1]"),
        ("0.5 # 29", "0.25 # 29"),
        ("\"square\"\n", "\"square\"\noffset_rad = 0.1\n"),
        ("eps_u_v = 0.011", "eps_u_v = 0.012"),
        ("low_pass = 0.6 # 150 Hz\n", "low_pass = 0.7 # 150 Hz\neps_e_rad = 0.004\n"),
    ]);
    assert_eq!(bench.saved(&screen, &live), expected);
    // Back again: what was there before is there as it was written, what was not says the same by its value.
    bench.saved(&project.screen(), &live_of(&project));
    let back = bench.project();
    assert_eq!((back.screen(), live_of(&back)), (project.screen(), live_of(&project)));
}

#[test]
fn scopes_come_go_and_change_places() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let mut screen = project.screen();
    screen.scopes.swap(0, 1);
    let plain = |title: &str, signals: &[&str]| Scope {
        title: title.into(),
        kind: ScopeKind::Spectrum,
        signals: signals.iter().map(|name| (*name).into()).collect(),
        span_s: 1.0,
        range: None,
        amplitude: AmplitudeAxis::Linear,
        frequency: FrequencyAxis::Logarithmic,
        trigger: None,
    };
    screen.scopes.insert(1, plain("New", &["alpha_rad"]));
    let text = bench.saved(&screen, &live_of(&project));
    let (first, rest) = BY_HAND.split_once("# The one to look at.\n").unwrap();
    let (tip, rest) = rest.split_once("# Volts.\n").unwrap();
    let (volts, rest) = rest.split_once("# ---- What is turned ----\n").unwrap();
    let new = "[[scope]]\ntitle = \"New\"\nkind = \"spectrum\"\nsignals = [\"alpha_rad\"]\nspan_s = 1.0\n";
    let expected =
        format!("{first}# Volts.\n{volts}{new}\n# The one to look at.\n{tip}# ---- What is turned ----\n{rest}");
    assert_eq!(text, expected);

    screen.scopes.clear();
    let text = bench.saved(&screen, &live_of(&project));
    assert_eq!(text, format!("{first}# ---- What is turned ----\n{rest}"), "the headings of the place stay");
    screen.panels.clear();
    let text = bench.saved(&screen, &live_of(&project));
    assert!(text.ends_with("# ---- What is watched ----\n\n# ---- What is turned ----\n\n# The end.\n"), "{text}");
    screen.scopes = project.scopes.clone();
    screen.panels = project.panels.clone();
    bench.saved(&screen, &live_of(&project));
    assert_eq!(bench.project().screen(), project.screen());
}

#[test]
fn signals_come_and_go_with_their_comments() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let mut screen = project.screen();
    screen.scopes[0].signals = ["psi_rad", "u_v", "reference_rad"].map(String::from).to_vec();
    screen.scopes[1].signals.push("commanded_v".into());
    let expected = with(&[
        (
            "  \"reference_rad\", # asked for\n  # the model\n  \"y_model_rad\",\n  \"psi_rad\", # measured\n",
            "  \"psi_rad\", # measured\n  \"u_v\",\n  \"reference_rad\", # asked for\n",
        ),
        ("[\"voltage_v\", \"u_v\"]", "[\"voltage_v\", \"u_v\", \"commanded_v\"]"),
    ]);
    assert_eq!(bench.saved(&screen, &live_of(&project)), expected);
}

#[test]
fn a_project_without_a_screen_gets_one_behind_the_rest() {
    let text = "schema = \"flexbeam.project/1\"\n\n[run]\nseed = 2\n# The end.\n";
    let bench = Bench::new(text);
    let screen = parse(BY_HAND).unwrap().screen();
    let mut live = live_of(&bench.project());
    live.settings.law = Some(Law::Switched);
    let saved = bench.saved(&screen, &live);
    assert_eq!(bench.project().screen(), screen);
    assert!(saved.starts_with("schema = \"flexbeam.project/1\"\n\n[run]\nseed = 2\n"), "{saved}");
    assert!(saved.ends_with("# The end.\n"), "{saved}");
    assert!(saved.contains("\n\n[settings]\nlaw = \"switched\"\n"), "{saved}");
    let tight = [" \n", "\n\n\n", "[[scope]]\n\n", "\"law\" ]"];
    assert!(tight.iter().all(|blank| !saved.contains(blank)), "{saved}");
}

#[test]
fn edits_made_during_the_run_stay() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let edited =
        with(&[("eps_u_v = 0.011", "eps_u_v = 0.5"), ("Stands still", "Stood"), ("span_s = 10", "span_s = 11")]);
    std::fs::write(bench.path(), &edited).unwrap();
    let mut live = live_of(&project);
    live.reference.amplitude_rad = 0.75;
    let text = bench.saved(&project.screen(), &live);
    assert_eq!(text, edited.replace("0.5 # 29", "0.75 # 29"), "what the run did not change is the person's");
}

#[test]
fn an_edit_that_does_not_read_is_refused_and_stays() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let (mut screen, live) = (project.screen(), live_of(&project));
    screen.scopes.remove(0);
    for (part, other, found) in [
        ("[limits]", "[limits", ":28:"),
        ("hold_s", "holds", "an unknown key run.holds"),
        ("project/1", "project/2", "schema \"flexbeam.project/2\""),
    ] {
        let edited = with(&[(part, other)]);
        std::fs::write(bench.path(), &edited).unwrap();
        let error = bench.file.save(&screen, &live).unwrap_err();
        assert_eq!(error.tried, Tried::Save);
        let message = error.to_string();
        assert!(message.starts_with("cannot save into ") && message.contains(found), "{message}");
        assert!(message.ends_with("; nothing was written"), "{message}");
        assert_eq!(bench.text(), edited);
    }
    std::fs::write(bench.path(), BY_HAND).unwrap();
    bench.file.save(&screen, &live).unwrap();
    assert_eq!(bench.project().screen(), screen, "once it reads again, nothing is lost");
    std::fs::remove_file(bench.path()).unwrap();
    assert_eq!(*bench.file.save(&screen, &live).unwrap_err().fault, Fault::NoFile);
}

#[test]
fn what_would_not_read_back_is_not_written() {
    let bench = Bench::new(BY_HAND);
    let project = bench.project();
    let live = live_of(&project);
    let mut screen = project.screen();
    screen.scopes[1].signals = vec!["gone".into()];
    let error = bench.file.save(&screen, &live).unwrap_err();
    assert!(error.to_string().contains("scope(2).signals(1) = \"gone\""), "{error}");
    let loose = Settings { theta_limit_rad: Some(3.0), ..live.settings.clone() };
    let error = bench.file.save(&project.screen(), &LiveSettings { settings: loose, ..live }).unwrap_err();
    assert!(matches!(&*error.fault, Fault::Beyond { limit: "limits.angle_rad", .. }), "{error}");
    assert_eq!(bench.text(), BY_HAND);
}

#[test]
fn a_reference_file_of_this_run_is_named_as_seen_from_the_project() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(Project::FILE);
    std::fs::write(&path, BY_HAND).unwrap();
    let project = parse(BY_HAND).unwrap();
    let reference = folder.path().join("signals/dance.csv");
    let file = ProjectFile::open(&path, &live_of(&project), &[], Some(&reference)).unwrap();
    let mut live = live_of(&project);
    live.reference.shape = RunShape::File;
    live.reference.amplitude_rad = 1.0;
    file.save(&project.screen(), &live).unwrap();
    let saved = Project::read(&path).unwrap().reference;
    assert_eq!((saved.file, saved.amplitude_rad), (Some(PathBuf::from("signals/dance.csv")), Some(1.0)));
}

#[test]
fn what_the_command_line_said_is_saved_and_what_a_rig_did_to_the_settings_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(Project::FILE);
    std::fs::write(&path, BY_HAND).unwrap();
    let project = parse(BY_HAND).unwrap();
    let mut begun = live_of(&project);
    begun.settings.law = Some(Law::None);
    begun.settings.voltage_limit_v = Some(9.75);
    begun.settings.theta.as_mut().unwrap().offset_rad = Some(0.2);
    begun.reference.amplitude_rad = 0.125;
    let file = ProjectFile::open(&path, &begun, &["law", "reference.amplitude_rad", "reference.shape"], None).unwrap();
    file.save(&project.screen(), &begun).unwrap();
    let expected =
        with(&[("0.5 # 29", "0.125 # 29"), ("low_pass = 0.6 # 150 Hz\n", "low_pass = 0.6 # 150 Hz\nlaw = \"none\"\n")]);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
}

#[test]
fn the_usual_screen_reads_back() {
    let bench = Bench::new("schema = \"flexbeam.project/1\"\n");
    bench.saved(&Screen::usual(), &live_of(&bench.project()));
    assert_eq!(bench.project().screen(), Screen::usual());
}

#[test]
fn a_project_of_our_own_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let project = parse(BY_HAND).unwrap();
    let path = folder.path().join(Project::FILE);
    project.write(&path, Overwrite::Refuse).unwrap();
    assert_eq!(Project::read(&path).unwrap(), project);
}

/// The same screen as inline tables, with comments between them.
const INLINE: &str = r##"schema = "flexbeam.project/1" #! 0
#! 1
scope = [ # all
  #! 2

  { title = "Tip angle", signals = ["psi_rad"] }, # the tip
  { title = "Voltage", signals = ["voltage_v"], span_s = 2 }, # volts
] #! 3
panel = [{ title = "Law", settings = ["law"] }] #! 4
[limits] #! 5
angle_rad = 3 #! 6
"##;

fn screens() -> impl Strategy<Value = Screen> {
    let number = || prop_oneof![Just(0.0), Just(-0.0), -1e3..1e3, prop::num::f64::NORMAL];
    let ends = || (-1e3..1e3, 1e-3..1e3).prop_map(|(low, width): (f64, f64)| [low, low + width]);
    let title = || {
        prop_oneof![
            Just("Tip angle".to_string()),
            Just("Voltage".into()),
            Just("Law".into()),
            "[ -~\u{e9}\"\\\\\n]{0,8}"
        ]
    };
    let signals = || prop::collection::vec(prop::sample::select(RunSample::SIGNALS), 0..4);
    let signal = || prop::sample::select(RunSample::SIGNALS);
    let trigger =
        (signal(), number(), 0.0..=1.0, prop::sample::select(&[Edge::Rising, Edge::Falling, Edge::Either][..]))
            .prop_map(|(signal, level, before, edge): (_, f64, f64, _)| {
                let mode = if before > 0.5 { TriggerMode::Single } else { TriggerMode::Auto };
                Trigger { signal: signal.into(), edge, level, mode, before }
            });
    let axes = (any::<bool>(), any::<bool>());
    let scope = (title(), 0..3usize, signals(), 1e-3..1e3, prop::option::of(ends()), prop::option::of(trigger), axes)
        .prop_map(|(title, kind, signals, span_s, range, trigger, (decibels, linear))| Scope {
            amplitude: if decibels { AmplitudeAxis::Decibels } else { AmplitudeAxis::Linear },
            frequency: if linear { FrequencyAxis::Linear } else { FrequencyAxis::Logarithmic },
            title,
            kind: [ScopeKind::Time, ScopeKind::Xy, ScopeKind::Spectrum][kind],
            signals: signals.into_iter().map(String::from).collect(),
            span_s,
            range,
            trigger,
        });
    let numbers: Vec<&str> = LiveSettings::KEYS.iter().copied().filter(|k| !LiveSettings::WORDS.contains(k)).collect();
    let ranges = prop::collection::btree_map(prop::sample::select(numbers).prop_map(String::from), ends(), 0..3);
    let settings = prop::collection::vec(prop::sample::select(LiveSettings::KEYS).prop_map(String::from), 0..4);
    let panel = (title(), settings, ranges).prop_map(|(title, settings, ranges): (_, _, BTreeMap<_, _>)| Panel {
        title,
        settings,
        ranges,
    });
    (prop::collection::vec(scope, 0..5), prop::collection::vec(panel, 0..4))
        .prop_map(|(scopes, panels)| Screen { scopes, panels })
}

/// Parts of the hand-written screen, mixed with new ones in any order.
fn screens_with_old_parts() -> impl Strategy<Value = Screen> {
    (screens(), prop::collection::vec((0..2usize, 0..5usize), 0..3), any::<bool>()).prop_map(
        |(mut screen, old, panel)| {
            let by_hand = parse(BY_HAND).unwrap();
            for (which, at) in old {
                screen.scopes.insert(at.min(screen.scopes.len()), by_hand.scopes[which].clone());
            }
            if panel {
                screen.panels.insert(0, by_hand.panels[0].clone());
            }
            screen
        },
    )
}

/// Comments that no scope, panel or value of them owns.
fn of_the_place(text: &str) -> Vec<&str> {
    let lines = text.lines().filter_map(|line| line.rfind('#').map(|at| &line[at..]));
    lines.filter(|comment| comment.starts_with("#!") || comment.contains("----")).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, rng_seed: prop::test_runner::RngSeed::Fixed(5), ..Default::default() })]

    #[test]
    fn what_is_saved_is_read(
        screens in prop::collection::vec(screens_with_old_parts(), 1..4),
        base in 0..4usize,
        numbers in (0.0..1.0, 0.1..9.0, prop::sample::select(&[Law::None, Law::Switched, Law::Inverse][..])),
    ) {
        let crlf = BY_HAND.replace('\n', "\r\n");
        let text = [BY_HAND, INLINE, &crlf, "schema = \"flexbeam.project/1\"\n"][base];
        let bench = Bench::new(text);
        let mut live = live_of(&bench.project());
        let mut stays = true;
        let outside = |text: &str| text.split("[[scope]]").next().unwrap().lines().take(12).map(String::from).collect::<Vec<_>>();
        for screen in screens {
            (live.settings.eps_u_v, live.reference.period_s, live.settings.law) = (Some(numbers.0), numbers.1, Some(numbers.2));
            prop_assert!(bench.file.save(&screen, &live).is_ok());
            let saved = bench.text();
            let project = bench.project();
            prop_assert_eq!(project.screen(), screen.clone());
            prop_assert_eq!(live_of(&project), live.clone());
            prop_assert_eq!(bench.file.save(&screen, &live).unwrap(), Written::Unchanged);
            prop_assert_eq!(of_the_place(&saved), of_the_place(text));
            if base != 1 && base != 3 {
                prop_assert_eq!(outside(&saved), outside(text));
            }
            let is_kept = |title: &str| screen.scopes.iter().filter(|scope| scope.title == title).count() == 1;
            stays &= is_kept("Voltage");
            if base == 0 && stays {
                prop_assert!(saved.contains("# Volts.\n[[scope]] # second\n"), "{}", saved);
            }
            prop_assert_eq!(saved.matches("\r\n").count(), if base == 2 { saved.matches('\n').count() } else { 0 });
        }
    }
}

/// The same things said in other spellings of TOML.
const SPELLINGS: &[&str] = &[
    "schema = \"flexbeam.project/1\"\nsettings.eps_u_v = 0.011 # dotted\nreference.shape = \"square\"\nsettings.theta.low_pass = 0.6\n",
    "schema = \"flexbeam.project/1\"\n[settings]\ntheta.low_pass = 0.6 # dotted\nalpha.low_pass = 0.6\neps_u_v = 0.011",
    "schema = \"flexbeam.project/1\"\n[settings.theta] # below\nlow_pass = 0.6\n[reference]\n# last words",
    "schema = \"flexbeam.project/1\"\nsettings = { eps_u_v = 0.011, theta = { low_pass = 0.6 } } # inline\nreference = {}\n",
    "schema = \"flexbeam.project/1\"\n[[scope]]\ntitle = \"Voltage\"\nsignals = [\"voltage_v\"]\n[scope.trigger] # below\nsignal = \"u_v\"\nlevel = 1\n[[panel]]\ntitle = \"Law\"\nsettings = []\n[panel.ranges]\neps_u_v = [0, 1]\n[[scope]]\ntitle = \"Tip angle\"\nsignals = []\ntrigger.signal = \"u_v\"\ntrigger.level = 0\n[settings]\neps_u_v = 0.011\n",
    "schema = \"flexbeam.project/1\"\nscope = []\npanel = [ # none\n]\n[ \"reference\" ]\n\"shape\" = 'square'\n['settings'.'theta']\n\"low_pass\" = 0.6\n",
    "\u{feff}schema = \"flexbeam.project/1\"\n[reference]\nshape = \"square\"\n",
    "schema = \"flexbeam.project/1\"\n[[panel]]\ntitle = \"\"\"Law\"\"\"\nsettings = [\"law\", # one\n]\nranges.\"reference.amplitude_rad\" = [-1, 1]\nranges.eps_u_v = [0, 1] # two\n[reference]\r\nshape = \"square\"\r\n",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, rng_seed: prop::test_runner::RngSeed::Fixed(6), ..Default::default() })]

    #[test]
    fn whatever_the_spelling_what_is_saved_is_read(
        screens in prop::collection::vec(screens(), 1..4),
        base in 0..SPELLINGS.len(),
        numbers in (0.0..1.0, 0.1..9.0, prop::sample::select(&[Law::None, Law::Switched, Law::Inverse][..])),
    ) {
        let bench = Bench::new(SPELLINGS[base]);
        let mut live = live_of(&bench.project());
        for screen in screens {
            (live.settings.eps_u_v, live.reference.period_s, live.settings.law) = (Some(numbers.0), numbers.1, Some(numbers.2));
            let saved = bench.file.save(&screen, &live);
            prop_assert!(saved.is_ok(), "{}", saved.unwrap_err());
            let project = bench.project();
            prop_assert_eq!(project.screen(), screen.clone(), "{}", bench.text());
            prop_assert_eq!(live_of(&project), live.clone(), "{}", bench.text());
            prop_assert_eq!(bench.file.save(&screen, &live).unwrap(), Written::Unchanged);
        }
    }
}

/// The hub's limit goes through degrees, by which it may grow by its last bit: what nobody said is not to be saved.
#[test]
fn a_limit_that_is_as_at_the_beginning_again_is_not_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(Project::FILE);
    let text = "schema = \"flexbeam.project/1\"\n[limits]\nangle_rad = 0.2\n";
    std::fs::write(&path, text).unwrap();
    let project = parse(text).unwrap();
    let mut begun = live_of(&project);
    begun.settings.theta_limit_rad = Some(0.2f64.to_degrees().to_radians());
    let file = ProjectFile::open(&path, &begun, &[], None).unwrap();
    let mut tightened = begun.clone();
    tightened.settings.theta_limit_rad = Some(0.1);
    file.save(&project.screen(), &tightened).unwrap();
    assert_eq!(Project::read(&path).unwrap().settings.theta_limit_rad, Some(0.1));
    file.save(&project.screen(), &begun).unwrap();
    assert_eq!(Project::read(&path).unwrap(), project);
}
