//! MATLAB files as scipy and Octave write them, and what the program says of them.

mod support;

use std::path::Path;
use std::process::Command;

use flexbeam_files::{Layout, Recording};
use support::{Bench, number, pseudorandom, python};

fn run(program: impl AsRef<Path>, arguments: &[&str], folder: &Path) {
    let program = program.as_ref();
    let output = Command::new(program).args(arguments).current_dir(folder).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}; cargo xtask test has it", program.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A second-order system's recording, which both programs are to write: time, u, y.
fn table(bench: &Bench) -> Recording {
    let (mut y1, mut y2) = (0.0, 0.0);
    let rows = pseudorandom(400).into_iter().enumerate().map(|(k, u)| {
        let y = 1.6 * y1 - 0.8 * y2 + 0.1 * u;
        (y2, y1) = (y1, y);
        format!("{:?},{u:?},{y:?}\n", k as f64 / 64.0)
    });
    bench.write("r.csv", &("time_s,u,y\n".to_string() + &rows.collect::<String>()));
    Recording::read(&bench.path("r.csv"), &Layout::default()).unwrap()
}

/// Every file holds the table's numbers to the last bit.
fn same(bench: &Bench, file: &str, wanted: &Recording) {
    let path = bench.path(file);
    let read = Recording::read(&path, &Layout::default()).unwrap_or_else(|error| panic!("{error}"));
    let signals = read.select(&["u", "y"]).unwrap_or_else(|error| panic!("{error}"));
    let bits = |data: &flexbeam_lti::Mat| data.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&signals.data), bits(&wanted.signals.data), "{file}");
    assert_eq!(signals.period_s, wanted.signals.period_s, "{file}");
}

const SCIPY: &str = "
import numpy as n, scipy.io as s
t, u, y = n.loadtxt('r.csv', delimiter=',', skiprows=1).T
for packed in (False, True):
    for how in ('row', 'column'):
        s.savemat(f'{how}{packed:d}.mat', dict(time=t, u=u, y=y), do_compression=packed, oned_as=how)
    s.savemat(f'struct{packed:d}.mat', dict(data=dict(time=t, u=u, y=y), note='room 3', A=n.eye(3)), do_compression=packed)
    s.savemat(f'rate{packed:d}.mat', dict(u=u, y=y, fs=64), do_compression=packed)
    s.savemat(f'integers{packed:d}.mat', dict(t=t, u=n.arange(400, dtype=n.int16), y=n.float32(n.arange(400))), do_compression=packed)
";

#[test]
fn files_of_scipy() {
    let Some(python) = python() else { return };
    let bench = Bench::new();
    let wanted = table(&bench);
    run(&python, &["-c", SCIPY], &bench.path(""));
    for packed in 0..2 {
        for kind in ["row", "column", "struct", "rate"] {
            same(&bench, &format!("{kind}{packed}.mat"), &wanted);
        }
        let counted = Recording::read(&bench.path(&format!("integers{packed}.mat")), &Layout::default()).unwrap();
        assert!(
            counted.signals.data.column_iter().enumerate().all(|(k, column)| column.iter().all(|x| *x == k as f64))
        );
    }
}

const OCTAVE: &str = "
d = dlmread('r.csv', ',', 1, 0); time = d(:, 1); u = d(:, 2)'; y = d(:, 3);
data.time = time; data.u = u; data.y = y;
out.time = time;
out.signals(1).values = d(:, 2); out.signals(1).label = 'u';
out.signals(2).values = reshape(d(:, 3), 1, 1, []); out.signals(2).label = 'y';
Ts = 1 / 64;
for v = {'-v6', '-v7'}
  save(v{1}, ['plain' v{1} '.mat'], 'time', 'u', 'y');
  save(v{1}, ['struct' v{1} '.mat'], 'data');
  save(v{1}, ['simulink' v{1} '.mat'], 'out');
  save(v{1}, ['period' v{1} '.mat'], 'u', 'y', 'Ts');
end
save('text.mat', 'u');
save('-hdf5', 'hdf5.mat', 'u');
";

#[test]
fn files_of_octave() {
    let bench = Bench::new();
    let wanted = table(&bench);
    run("octave-cli", &["--norc", "--no-history", "--eval", OCTAVE], &bench.path(""));
    for version in ["-v6", "-v7"] {
        for kind in ["plain", "struct", "simulink", "period"] {
            same(&bench, &format!("{kind}{version}.mat"), &wanted);
        }
    }
    for (file, words) in [("text.mat", "Octave's own text format"), ("hdf5.mat", "version 7.3, which is HDF5")] {
        let answer = bench.run(&format!("identify {file} --inputs u --outputs y"));
        assert_eq!(answer.status, 2, "{}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("save -v7 "), "{}", answer.err);
    }
    let line = "--inputs u --outputs y --order 2";
    let of_table = bench.json(&format!("identify r.csv {line}"));
    let of_mat = bench.json(&format!("identify simulink-v7.mat {line}"));
    assert_eq!(of_mat["poles"], of_table["poles"]);
    let shown = bench.json("show struct-v7.mat");
    assert_eq!(number(&shown["content"], "samples"), 400.0);
    bench.done("export plain-v6.mat --as csv -o back.csv");
    assert_eq!(bench.read("back.csv"), bench.read("r.csv"));
}
