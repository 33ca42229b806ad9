//! `flexbeam new` and `flexbeam run PROJECT`: the real program, from an empty folder to a run that comes back as it was saved.

mod support;
#[path = "../../flexbeam-runtime/tests/support/scope_viewer.rs"]
#[allow(dead_code, reason = "each test uses a part")]
mod viewer;

use flexbeam_files::{
    Document, Law, LiveSettings, Project, ProjectReference, RunRecording, RunShape, Screen, sha256_hex,
};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;
use support::{Answer, Bench, number};
use viewer::Viewer;

/// A folder with the project `beam`, made once and copied for each test.
fn bench() -> Bench {
    static MADE: OnceLock<Bench> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let bench = Bench::new();
        bench.done("new beam");
        bench
    });
    let bench = Bench::new();
    std::fs::create_dir(bench.path("beam")).unwrap();
    for name in names(&made.path("beam")) {
        bench.write(&format!("beam/{name}"), &made.read(&format!("beam/{name}")));
    }
    bench
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const FILES: [&str; 6] =
    ["controller.toml", "flexbeam.toml", "model.toml", "recording.csv", "recording.csv.toml", "rig.toml"];

/// Changes the project's file, in parts that stand there once.
fn edit(bench: &Bench, changes: &[(&str, &str)]) -> String {
    let text = changes.iter().fold(bench.read("beam/flexbeam.toml"), |text, (part, other)| {
        assert_eq!(text.matches(part).count(), 1, "{part} in {text}");
        text.replace(part, other)
    });
    bench.write("beam/flexbeam.toml", &text);
    text
}

/// Runs the project for a moment, and reads what was recorded.
fn recorded(bench: &Bench, options: &str) -> RunRecording {
    let answer = bench.json(&format!("run beam --duration 0.2 --hold 60 {options}"));
    RunRecording::read(&bench.path(answer["recording"].as_str().unwrap())).unwrap()
}

/// Runs `line`; it must refuse with all of `words`, and leave every file as it was.
fn refuses(bench: &Bench, line: &str, words: &[&str]) -> Answer {
    let all = |folder: &Path| {
        let files = names(folder).into_iter().map(|name| folder.join(name)).filter(|path| path.is_file());
        files.map(|path| (std::fs::read(&path).unwrap(), path)).collect::<Vec<_>>()
    };
    let state = || (bench.names(), names(&bench.path("beam")), all(&bench.path("beam")));
    let before = state();
    let answer = bench.run(line);
    assert_eq!(answer.status, 2, "flexbeam {line}\n{}{}", answer.out, answer.err);
    for word in words.iter().chain(&["hint: "]) {
        assert!(answer.err.contains(word), "{word:?} is not in the message of flexbeam {line}:\n{}", answer.err);
    }
    assert_eq!(state(), before, "flexbeam {line} touched a file");
    answer
}

#[test]
fn a_new_project_is_whole_and_knows_where_it_came_from() {
    let bench = Bench::new();
    let answer = bench.json("new beam");
    assert_eq!((answer["folder"].as_str(), answer["name"].as_str()), (Some("beam"), Some("beam")));
    assert_eq!(names(&bench.path("beam")), FILES);
    let mut listed: Vec<&str> = answer["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    listed.sort_unstable();
    assert_eq!(listed, FILES);
    assert_eq!(bench.names(), ["beam"]);
    let project = Project::open(&bench.path("beam")).unwrap();
    assert_eq!(project.screen(), Screen::usual(), "the file says what is shown where no project is");
    let history = bench.json("show beam/controller.toml")["history"].as_array().unwrap().clone();
    let states: Vec<&str> = history.iter().map(|step| step["state"].as_str().unwrap()).collect();
    assert_eq!(states, ["start", "same", "same", "same", "same"], "model, recording, its rig, the design's rig");
    assert_eq!(bench.json("verify beam --runs 2")["verified"], true);
    let settled = bench.json("simulate beam --step-deg 15 -o simulation");
    assert!(number(&settled, "stationary_error_rad").abs() < 0.01, "{settled}");
}

#[test]
fn a_name_and_a_rig_of_one_s_own() {
    let bench = Bench::new();
    let rig = "# mine\nschema = \"flexbeam.rig/1\"\nperiod_s = 0.002\n[physical]\nJ_link = 0.004\n";
    bench.write("my-rig.toml", rig);
    let words = ["new", "long-one", "--name", "the \"long\" one \\", "--rig", "my-rig.toml"];
    let answer = bench.run_words(&words);
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(answer.out.contains("flexbeam run long-one --scope"), "{}", answer.out);
    let project = Project::read(&bench.path("long-one/flexbeam.toml")).unwrap();
    assert_eq!(project.name.as_deref(), Some("the \"long\" one \\"));
    assert_eq!(bench.read("long-one/rig.toml"), rig);
    let run = bench.json("run long-one --duration 0.2 --hold 60");
    assert_eq!(number(&run, "period_s"), 0.002);
}

#[test]
fn an_empty_folder_is_taken_as_it_is() {
    use std::os::unix::fs::MetadataExt;
    let bench = Bench::new();
    std::fs::create_dir(bench.path("beam")).unwrap();
    let number_of = || std::fs::metadata(bench.path("beam")).unwrap().ino();
    let before = number_of();
    let here = Command::new(env!("CARGO_BIN_EXE_flexbeam")).args(["new", "."]).current_dir(bench.path("beam")).output();
    assert!(here.unwrap().status.success());
    assert_eq!((number_of(), names(&bench.path("beam"))), (before, FILES.map(String::from).to_vec()));
    assert_eq!(bench.names(), ["beam"]);
    assert_eq!(Project::read(&bench.path("beam/flexbeam.toml")).unwrap().name.as_deref(), Some("beam"));
}

#[test]
fn where_no_project_can_be_made_nothing_is() {
    let bench = bench();
    bench.write("file", "");
    bench.write("bad.toml", "schema = \"flexbeam.rig/1\"\nperiod = 1\n");
    // The exact beam has no tip mass: the design finds out, when recording and model are made.
    bench.write("tip.toml", "schema = \"flexbeam.rig/1\"\n[link]\ntip_mass_kg = 0.05\n");
    refuses(&bench, "new beam", &["cannot make the project beam", "in it, needed a folder that is empty"]);
    refuses(&bench, "new file", &["cannot make the project file", "found a file of that name"]);
    refuses(&bench, "new no/such/place", &["cannot make the project no/such/place", "the folder above it"]);
    refuses(&bench, "new other --rig no.toml", &["no.toml", "no file of that name"]);
    refuses(&bench, "new other --rig bad.toml", &["bad.toml:2:1", "an unknown key period"]);
    refuses(&bench, "new other --rig tip.toml", &["tip mass"]);
}

#[test]
fn a_new_project_that_is_broken_off_leaves_nothing() {
    let bench = Bench::new();
    let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
    let child = program.args(["new", "beam"]).current_dir(bench.path("")).stderr(Stdio::piped()).spawn().unwrap();
    // It listens to signals before it makes its folder.
    while bench.names().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let id = nix::unistd::Pid::from_raw(child.id() as i32);
    nix::sys::signal::kill(id, nix::sys::signal::Signal::SIGINT).unwrap();
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    assert_eq!(status.code(), Some(2));
    assert!(String::from_utf8_lossy(&stderr).contains("nothing was made"));
    assert_eq!(bench.names(), [] as [&str; 0]);
}

#[test]
fn a_run_takes_what_the_project_says_and_keeps_its_hash() {
    let bench = bench();
    let text = edit(
        &bench,
        &[
            ("amplitude_rad = 0.2618          #", "amplitude_rad = 0.125 # smaller than"),
            ("shape = \"square\" ", "shape = \"sine\" # rounder: "),
            ("period_s = 4.0\n", "period_s = 2 # faster\n"),
            ("# law = \"switched\" ", "eps_u_v = 0.015 # by hand\nlaw = \"switched\" "),
            ("deflection_rad = 0.5 ", "deflection_rad = 0.25 "),
            ("voltage_v = 10.0", "voltage_v = 6.5 # careful"),
            ("angle_rad = 3.1416 ", "angle_rad = 1.5 "),
        ],
    );
    let run = recorded(&bench, "");
    let LiveSettings { settings, reference, .. } = &run.settings[0];
    assert_eq!((reference.shape, reference.amplitude_rad, reference.period_s), (RunShape::Sine, 0.125, 2.0));
    assert_eq!((settings.law, settings.eps_u_v), (Some(Law::Switched), Some(0.015)));
    assert_eq!((settings.voltage_limit_v, settings.deflection_limit_rad), (Some(6.5), Some(0.25)));
    assert!((settings.theta_limit_rad.unwrap() - 1.5).abs() < 1e-12);
    let parents = &run.header.provenance.parents;
    let project = parents.iter().find(|parent| parent.path == "../flexbeam.toml").unwrap();
    assert_eq!(project.sha256, sha256_hex(text.as_bytes()));
    assert_eq!(
        parents.iter().map(|parent| parent.path.as_str()).collect::<Vec<_>>(),
        ["../controller.toml", "../rig.toml", "../flexbeam.toml"]
    );
    assert_eq!(bench.read("beam/flexbeam.toml"), text, "a run alone writes nothing into it");
    let again = recorded(&bench, "");
    assert_eq!(again.settings[0], run.settings[0]);
    assert_eq!(names(&bench.path("beam/runs")).len(), 2, "no run takes the place of another");
}

#[test]
fn the_command_line_wins_over_the_project_and_the_project_over_the_defaults() {
    let bench = bench();
    edit(
        &bench,
        &[
            ("# wait = true  ", "wait = true  "),
            ("# duration_s = 60.0", "duration_s = 0.1"),
            ("# law = \"switched\"", "law = \"switched\""),
        ],
    );
    let flags = "--wait=false --law none --amplitude-deg 10 --signal step --max-angle-deg 90 -o own.mcap";
    let run = recorded(&bench, flags);
    assert!(!bench.path("beam/runs").exists());
    assert_eq!(run.source, bench.path("own.mcap"));
    let LiveSettings { settings, reference, .. } = &run.settings[0];
    assert_eq!((settings.law, reference.shape), (Some(Law::None), RunShape::Step));
    assert_eq!((reference.amplitude_rad, reference.period_s), (10f64.to_radians(), 4.0));
    assert_eq!(settings.theta_limit_rad, Some(90f64.to_radians()));
    assert!(run.samples.samples() > 150, "0.2 s of the command line, not 0.1 s: {}", run.samples.samples());

    // What a file is multiplied by is not the amplitude of the project's square, nor the other way round.
    let rows: String = (0..300).map(|k| format!("{:.3},0.01\n", f64::from(k) / 1000.0)).collect();
    bench.write("beam/dance.csv", &format!("time_s,reference_rad\n{rows}"));
    let run = recorded(&bench, "--wait=false --signal file --signal-file beam/dance.csv");
    assert_eq!((run.settings[0].reference.shape, run.settings[0].reference.amplitude_rad), (RunShape::File, 1.0));
    edit(
        &bench,
        &[("shape = \"square\" ", "file = \"dance.csv\"\nshape = \"file\" "), ("rad = 0.2618 ", "rad = 2.0 ")],
    );
    let run = recorded(&bench, "--wait=false");
    assert_eq!(run.settings[0].reference.amplitude_rad, 2.0);
    assert_eq!(*run.samples.reference_rad.last().unwrap(), 0.02);
    let run = recorded(&bench, "--wait=false --signal step");
    assert_eq!(run.settings[0].reference.amplitude_rad, 30f64.to_radians());
}

#[test]
fn a_project_is_named_by_its_folder_its_file_or_by_standing_in_it() {
    let bench = bench();
    let here = |words: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        let output = program.args(words).current_dir(bench.path("beam")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let run = here(&["run", "--duration", "0.1", "--hold", "60", "--json"]);
    assert!(run["recording"].as_str().unwrap().starts_with("runs/20"), "{run}");
    let by_file = bench.json("run beam/flexbeam.toml --duration 0.1 --hold 60");
    assert!(by_file["recording"].as_str().unwrap().starts_with("beam/runs/20"), "{by_file}");
    let shown = bench.json("show beam");
    assert_eq!((shown["schema"].as_str(), &shown["content"]["name"]), (Some("flexbeam.project/1"), &json!("beam")));
    assert_eq!(here(&["show", ".", "--json"])["content"], shown["content"]);
    let text = bench.done("show beam");
    for word in ["controller.toml", "square", "Tip angle", "psi_rad", "Law", "limits.speed_rad_s       35.0"] {
        assert!(text.contains(word), "{word} in {text}");
    }
}

#[test]
fn a_project_that_cannot_run_says_where_and_why() {
    let cases: [(&str, &str, &[&str]); 9] = [
        ("project/1", "project/2", &["flexbeam.toml:3:10", "project/2", "another version"]),
        ("seed = 1 ", "sead = 1 ", &["flexbeam.toml:15:1", "an unknown key run.sead", "did you mean seed?"]),
        ("\"alpha_rad\"", "\"alfa_rad\"", &["scope(3).signals(1) = \"alfa_rad\"", "did you mean alpha_rad?"]),
        ("\"eps_e_rad\"", "\"eps_e\"", &["panel(2).settings(5) = \"eps_e\"", "did you mean eps_e_rad?"]),
        (
            "# law = \"switched\"",
            "voltage_limit_v = 12",
            &["settings.voltage_limit_v = 12", "at most 10, as limits.voltage_v says", "flexbeam.toml:"],
        ),
        ("port = \"simulated\"", "port = \"next door\"", &["use run.port at beam/flexbeam.toml:14:8", "next door"]),
        ("# scope = \"127.0.0.1:8787\"", "scope = \"here\"", &["use run.scope at beam/flexbeam.toml:18:9", "here"]),
        (
            "\"controller.toml\"",
            "\"best.toml\"",
            &["flexbeam.toml:10:14", "controller = \"best.toml\", where no file is"],
        ),
        ("controller = ", "# controller = ", &["flexbeam.toml", "no key controller"]),
    ];
    let bench = bench();
    let text = bench.read("beam/flexbeam.toml");
    for (part, other, words) in cases {
        edit(&bench, &[(part, other)]);
        refuses(&bench, "run beam --duration 0.1", words);
        bench.write("beam/flexbeam.toml", &text);
    }
    std::fs::remove_file(bench.path("beam/flexbeam.toml")).unwrap();
    for line in ["run beam", "run", "verify beam", "simulate beam"] {
        refuses(&bench, line, &["cannot open the project", "a folder without flexbeam.toml", "flexbeam new"]);
    }
}

#[test]
fn a_changed_filter_is_no_longer_what_the_certificate_speaks_of() {
    let bench = bench();
    edit(&bench, &[("# law = \"switched\"", "theta.low_pass = 0.9")]);
    refuses(&bench, "run beam --duration 0.1", &["certificate", "low_pass 0.9"]);
    let run = recorded(&bench, "--unverified test");
    assert_eq!(run.settings[0].settings.theta.as_ref().unwrap().low_pass, Some(0.9));
    assert_eq!(bench.run("verify beam --runs 0").status, 1);
}

/// A run of the project with a scope; it is ended with the value.
struct Run(Child, String, String);

impl Run {
    fn start(bench: &Bench, options: &str) -> Run {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flexbeam"));
        let line = format!("run beam --hold 60 --plain --json {options}");
        program.args(line.split_whitespace()).current_dir(bench.path(""));
        let mut child = program.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let said = BufReader::new(child.stderr.take().unwrap());
        let mut lines = said.lines().map(|line| line.expect("it speaks UTF-8"));
        let url = lines.find(|line| line.starts_with("scope: ")).expect("it serves the scope");
        let (address, token) = url.strip_prefix("scope: http://").unwrap().split_once("/#").unwrap();
        let run = Run(child, address.into(), token.into());
        std::thread::spawn(move || lines.count());
        run
    }

    fn viewer(&self) -> Viewer {
        let mut viewer = Viewer::enter(&self.1, json!({ "token": self.2, "name": "test", "key": "test" }));
        if viewer.hello["knobs"] == json!([]) {
            // It came before the run was armed, and is greeted again.
            viewer.hello = viewer.text("hello");
        }
        assert_eq!(viewer.take(), None);
        viewer
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn what_is_saved_from_the_scope_comes_back_with_the_next_run() {
    let bench = bench();
    let text = edit(&bench, &[("# scope = \"127.0.0.1:8787\" ", "scope = \"0\" ")]);
    let run = Run::start(&bench, "--offset-deg 5");
    let mut viewer = run.viewer();
    assert_eq!((&viewer.hello["run"]["project"], &viewer.hello["run"]["can_save"]), (&json!("beam"), &json!(true)));
    let mut screen = viewer.hello["screen"].clone();
    assert_eq!(screen["scope"].as_array().unwrap().len(), 3);
    screen["scope"].as_array_mut().unwrap().swap(0, 2);
    screen["scope"][1]["span_s"] = json!(4.0);
    assert_eq!(viewer.set(json!({ "reference.amplitude_rad": 0.375, "law": "none", "eps_e_rad": 0.004 })), None);
    assert_eq!(viewer.ask(json!({ "type": "save", "screen": screen })), None);
    let saved = bench.read("beam/flexbeam.toml");
    let comments = |text: &str| {
        let mut comments: Vec<String> = text.lines().filter_map(|l| Some(l.split_once('#')?.1.to_string())).collect();
        comments.sort();
        comments
    };
    assert_eq!(comments(&saved), comments(&text));
    assert!(saved.contains("amplitude_rad = 0.375          # 15 degrees"), "{saved}");

    // A screen that would not read back, and a file that does not read any more.
    let mut gone = screen.clone();
    gone["scope"][0]["signals"] = json!(["gone"]);
    let refused = viewer.ask(json!({ "type": "save", "screen": gone })).unwrap();
    assert!(refused.contains("scope(1).signals(1) = \"gone\""), "{refused}");
    bench.write("beam/flexbeam.toml", &saved.replace("[limits]", "[limits"));
    screen["scope"][1]["span_s"] = json!(5.0);
    let refused = viewer.ask(json!({ "type": "save", "screen": screen })).unwrap();
    assert!(refused.contains("cannot save into beam/flexbeam.toml:") && refused.contains("nothing was written"));
    assert_eq!(bench.read("beam/flexbeam.toml"), saved.replace("[limits]", "[limits"));
    bench.write("beam/flexbeam.toml", &saved);
    assert_eq!(viewer.ask(json!({ "type": "save", "screen": screen })), None);
    assert_eq!(viewer.act("stop"), None);
    viewer.text("over");
    drop(run);

    let again = Run::start(&bench, "--wait");
    let mut viewer = again.viewer();
    assert_eq!(viewer.hello["screen"], screen);
    let values = viewer.text("state")["values"].clone();
    assert_eq!((&values["reference.amplitude_rad"], &values["law"]), (&json!(0.375), &json!("none")));
    assert_eq!(values["reference.offset_rad"], json!(5f64.to_radians()), "the command line's word was saved, too");
    assert_eq!(values["eps_e_rad"], json!(0.004));
    assert_eq!(viewer.act("stop"), None);
    viewer.text("over");
    let project = Project::read(&bench.path("beam/flexbeam.toml")).unwrap();
    let reference = ProjectReference { offset_rad: Some(5f64.to_radians()), ..project.reference.clone() };
    assert_eq!(project.reference, reference);
    assert_eq!((project.settings.law, project.settings.eps_u_v), (Some(Law::None), None), "only what was changed");
}
