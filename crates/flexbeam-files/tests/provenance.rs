//! The walk from a controller back to the recording.

use flexbeam_files::*;
use flexbeam_lti::{Mat, Signals, StateSpace, Time};
use std::fs;
use std::path::{Path, PathBuf};

fn provenance(command: &str, child: &Path, parents: &[&Path]) -> Option<Provenance> {
    let parents = parents.iter().map(|path| Parent::of(path, child).unwrap()).collect();
    Some(Provenance { tool: "flexbeam 0.1.0".into(), command: Some(command.into()), time: None, parents })
}

/// rig.toml <- data/recording.csv <- model.toml <- project controllers/second.toml (a model in the controller's place:
/// the walk reads provenance of any schema).
fn chain(folder: &Path) -> [PathBuf; 4] {
    let [rig, recording, model, last] =
        ["rig.toml", "data/recording.csv", "model.toml", "controllers/second.toml"].map(|name| folder.join(name));
    fs::create_dir(folder.join("data")).unwrap();
    fs::create_dir(folder.join("controllers")).unwrap();
    Rig::default().write(&rig, Overwrite::Refuse).unwrap();
    let data = Mat::from_fn(2, 5, |r, k| (r + k) as f64);
    let signals = Signals::new(vec!["u".into(), "y".into()], vec![String::new(); 2], 0.1, data).unwrap();
    write_signals(&signals, None, &recording, Overwrite::Refuse).unwrap();
    let note_path = Note::path_for(&recording);
    let origin = provenance("flexbeam record", &note_path, &[&rig]).unwrap();
    Note::new(&signals, &fs::read(&recording).unwrap(), origin).write(&note_path, Overwrite::Refuse).unwrap();
    let gain = StateSpace::static_gain(Mat::from_element(1, 1, 2.0), Time::Sampled { period_s: 0.1 }).unwrap();
    let mut file = Model::new(&gain, vec!["u".into()], vec!["y".into()]);
    file.provenance = provenance("flexbeam identify", &model, &[&recording]);
    file.write(&model, Overwrite::Refuse).unwrap();
    file.provenance = provenance("flexbeam design", &last, &[&model, &rig]);
    file.write(&last, Overwrite::Refuse).unwrap();
    [rig, recording, model, last]
}

fn states(steps: &[Step]) -> Vec<(usize, State)> {
    steps.iter().map(|step| (step.generation, step.state)).collect()
}

#[test]
fn a_walk_back_to_the_recording_and_its_rig() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, recording, model, last] = chain(folder.path());
    let steps = trace(&last).unwrap();
    use State::{Same, Start};
    assert_eq!(states(&steps), [(0, Start), (1, Same), (2, Same), (3, Same), (1, Same)]);
    let found: Vec<PathBuf> = steps.iter().map(|step| step.path.canonicalize().unwrap()).collect();
    assert_eq!(found, [&last, &model, &recording, &rig, &rig].map(|path| path.canonicalize().unwrap()));
    assert_eq!(steps[2].schema.as_deref(), Some("flexbeam.recording/1"));
    assert_eq!(steps[2].sha256_found.as_ref(), Some(&sha256_hex(&fs::read(&recording).unwrap())));
    assert_eq!(steps[1].command.as_deref(), Some("flexbeam identify"));
}

#[test]
fn a_changed_parent_and_a_missing_one() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, recording, _, last] = chain(folder.path());
    fs::write(&recording, "time_s,u,y\n0,1,2\n").unwrap();
    fs::remove_file(rig).unwrap();
    let steps = trace(&last).unwrap();
    use State::{Changed, Missing, Same, Start};
    // The note is about another recording, so the walk ends at the one that changed.
    assert_eq!(states(&steps), [(0, Start), (1, Same), (2, Changed), (1, Missing)]);
    assert_ne!(steps[2].sha256_found, steps[2].sha256_expected);
    assert_eq!(steps[3].schema.as_deref(), Some("flexbeam.rig/1"), "as its child states it");
}

#[test]
fn a_file_that_is_its_own_ancestor_ends_the_walk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("snake.toml");
    fs::write(
        &path,
        "schema = \"x/1\"\n[provenance]\ntool = \"t\"\n[[provenance.parents]]\npath = \"snake.toml\"\nsha256 = \"0\"\n",
    )
    .unwrap();
    assert_eq!(states(&trace(&path).unwrap()), [(0, State::Start), (1, State::Changed)]);
}

#[test]
fn a_walk_needs_a_start() {
    let error = trace(Path::new("no/such/controller.toml")).unwrap_err();
    assert_eq!(*error.fault, Fault::NoFile);
}

#[test]
fn any_version_is_walked_through() {
    let folder = tempfile::tempdir().unwrap();
    let [_, _, model, last] = chain(folder.path());
    let newer = fs::read_to_string(&model).unwrap().replace("flexbeam.model/1", "flexbeam.model/7");
    fs::write(&model, newer).unwrap();
    let steps = trace(&last).unwrap();
    assert_eq!((steps[1].schema.as_deref(), steps[1].state), (Some("flexbeam.model/7"), State::Changed));
    assert_eq!(steps[2].generation, 2);
}

#[test]
fn a_file_tells_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let [rig, recording, model, _] = chain(folder.path());
    assert_eq!(schema_of(&rig).unwrap().as_deref(), Some(Rig::SCHEMA));
    assert_eq!(schema_of(&model).unwrap().as_deref(), Some(Model::SCHEMA));
    assert_eq!(schema_of(&recording).unwrap(), None);
    fs::write(&rig, "schema = \"flexbeam.rig/1\"\nx = \n").unwrap();
    assert!(matches!(*schema_of(&rig).unwrap_err().fault, Fault::Syntax { .. }));
}
