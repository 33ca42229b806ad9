//! Real recordings: DaISy's white-space columns, as the command line would name them.

use flexbeam_files::{Fault, Layout, Recording};
use std::path::PathBuf;

/// The folder of the recordings, which are not part of this project.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("FLEXBEAM_DATA").map_or_else(|| "../../../shared/data".into(), PathBuf::from);
    let there = folder.join("heating_system.dat").exists();
    if !there {
        eprintln!("LEFT OUT: no recordings in {} (set FLEXBEAM_DATA)", folder.display());
    }
    there.then_some(folder)
}

fn layout(columns: &str, period_s: Option<f64>) -> Layout {
    Layout { columns: Some(columns.split(',').map(String::from).collect()), period_s, ..Layout::default() }
}

#[test]
fn recordings_of_other_people() {
    let Some(folder) = data() else { return };
    for (file, columns, given, samples, period_s) in [
        ("robot_arm.dat", "u,y", Some(1.0), 1024, 1.0),
        ("CD_player_arm.dat", "u1,u2,y1,y2", Some(1.0), 2048, 1.0),
        ("dryer.dat", "u,y", Some(0.08), 1000, 0.08),
        ("evaporator.dat", "u1,u2,u3,y1,y2,y3", Some(1.0), 6305, 1.0),
        ("heating_system.dat", "time,u,y", None, 801, 2.0),
    ] {
        let recording = Recording::read(&folder.join(file), &layout(columns, given)).unwrap();
        let channels = columns.split(',').filter(|name| *name != "time").count();
        let found = (recording.signals.channels(), recording.signals.samples(), recording.signals.period_s);
        assert_eq!(found, (channels, samples, period_s), "{file}");
    }
    let error = Recording::read(&folder.join("dryer.dat"), &layout("u,y", None)).unwrap_err();
    assert_eq!(*error.fault, Fault::NoPeriod);
    let error = Recording::read(&folder.join("dryer.dat"), &layout("u,y1,y2", Some(0.08))).unwrap_err();
    assert_eq!(*error.fault, Fault::NamesAndColumns { names: 3, columns: 2 });
}
