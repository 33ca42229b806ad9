//! MATLAB files laid out byte by byte: what is read, what is refused, and that no length in them is believed.

use flexbeam_files::{Error, Fault, Layout, MatFault, MatVariable, PERIOD_TOLERANCE, Recording, csv_text, mat_bytes};
use proptest::prelude::*;
use std::io::Write;
use std::path::Path;

fn parse(bytes: &[u8], layout: &Layout) -> Result<Recording, Error> {
    Recording::parse(bytes, Path::new("recording.mat"), layout)
}

fn refused(bytes: &[u8]) -> Fault {
    let error = parse(bytes, &Layout::default()).expect_err("a fault");
    assert!(error.to_string().starts_with("cannot read recording.mat"), "{error}");
    *error.fault
}

fn named(columns: &str) -> Layout {
    Layout { columns: Some(columns.split(',').map(String::from).collect()), ..Layout::default() }
}

/// Builds files in either byte order.
#[derive(Clone, Copy)]
struct Builder {
    big: bool,
}

const LITTLE: Builder = Builder { big: false };

impl Builder {
    fn u32(self, x: u32) -> [u8; 4] {
        if self.big { x.to_be_bytes() } else { x.to_le_bytes() }
    }

    fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        let mut bytes = [self.u32(kind), self.u32(data.len() as u32)].concat();
        bytes.extend_from_slice(data);
        if kind != 15 {
            bytes.resize(bytes.len().next_multiple_of(8), 0);
        }
        bytes
    }

    fn words(self, words: &[u32]) -> Vec<u8> {
        words.iter().flat_map(|word| self.u32(*word)).collect()
    }

    fn doubles(self, values: &[f64]) -> Vec<u8> {
        let bytes =
            values.iter().flat_map(|x| if self.big { x.to_be_bytes() } else { x.to_le_bytes() }).collect::<Vec<u8>>();
        self.element(9, &bytes)
    }

    /// Class, shape, name, contents.
    fn array(self, class: u32, shape: &[u32], name: &str, contents: &[u8]) -> Vec<u8> {
        let parts = [
            self.element(6, &self.words(&[class, 0])),
            self.element(5, &self.words(shape)),
            self.element(1, name.as_bytes()),
            contents.to_vec(),
        ];
        self.element(14, &parts.concat())
    }

    fn matrix(self, name: &str, rows: u32, values: &[f64]) -> Vec<u8> {
        self.array(6, &[rows, values.len() as u32 / rows], name, &self.doubles(values))
    }

    fn structure(self, name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let names: Vec<u8> = fields.iter().flat_map(|(field, _)| format!("{field:\0<16}").into_bytes()).collect();
        let values: Vec<u8> = fields.iter().flat_map(|(_, value)| value.clone()).collect();
        self.array(2, &[1, 1], name, &[self.element(5, &self.words(&[16])), self.element(1, &names), values].concat())
    }

    fn compressed(self, element: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(element).unwrap();
        self.element(15, &packer.finish().unwrap())
    }

    fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = format!("{:116}", "MATLAB 5.0 MAT-file, of a test").into_bytes();
        bytes.extend_from_slice(&[0; 8]);
        bytes.extend_from_slice(if self.big { b"\x01\x00MI" } else { b"\x00\x01IM" });
        variables.iter().for_each(|variable| bytes.extend_from_slice(variable));
        bytes
    }
}

const TIME: [f64; 4] = [0.0, 0.5, 1.0, 1.5];
const U: [f64; 4] = [1.0, -2.0, 3.0, f64::MIN_POSITIVE];
const Y: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 0.1, 0.2, 0.3, 0.4];

/// Names, and rows of data; the time axis is [`TIME`].
fn read(bytes: &[u8]) -> (String, Vec<Vec<f64>>) {
    let recording = parse(bytes, &Layout::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((recording.time_s.as_deref(), recording.signals.period_s), (Some(&TIME[..]), 0.5));
    let rows = recording.signals.data.row_iter().map(|row| row.iter().copied().collect()).collect();
    (recording.signals.names.join(" "), rows)
}

#[test]
fn either_byte_order_packed_or_not_rows_or_columns() {
    let across: Vec<f64> = (0..8).map(|k| Y[(k % 2) * 4 + k / 2]).collect();
    for big in [false, true] {
        let to = Builder { big };
        for (time_rows, y) in [(4, to.matrix("y", 4, &Y)), (1, to.matrix("y", 2, &across))] {
            let variables = [to.matrix("time", time_rows, &TIME), to.matrix("u", 1, &U), y];
            let packed: Vec<Vec<u8>> = variables.iter().map(|variable| to.compressed(variable)).collect();
            for file in [to.file(&variables), to.file(&packed)] {
                assert_eq!(read(&file), ("u y1 y2".into(), vec![U.into(), Y[..4].into(), Y[4..].into()]), "big: {big}");
            }
        }
    }
}

#[test]
fn small_numbers_of_every_type_are_read() {
    for (kind, class, bytes) in [
        (1u32, 8u32, vec![1u8, 2, 3, 0x80]),
        (2, 9, vec![1, 2, 3, 4]),
        (3, 10, [1i16, 2, 3, -4].map(i16::to_le_bytes).concat()),
        (4, 11, [1u16, 2, 3, 4].map(u16::to_le_bytes).concat()),
        (5, 12, [1i32, 2, 3, -4].map(i32::to_le_bytes).concat()),
        (6, 13, [1u32, 2, 3, 4].map(u32::to_le_bytes).concat()),
        (7, 7, [1f32, 2.0, 3.0, 0.5].map(f32::to_le_bytes).concat()),
        (12, 14, [1i64, 2, 3, -4].map(i64::to_le_bytes).concat()),
        (13, 15, [1u64, 2, 3, 4].map(u64::to_le_bytes).concat()),
        (2, 6, vec![1, 2, 3, 9]), // doubles that MATLAB stores as bytes
    ] {
        let last = match kind {
            1 => -128.0,
            3 | 5 | 12 => -4.0,
            7 => 0.5,
            _ if class == 6 => 9.0,
            _ => 4.0,
        };
        let u = LITTLE.array(class, &[4, 1], "u", &LITTLE.element(kind, &bytes));
        let file = LITTLE.file(&[LITTLE.matrix("t", 4, &TIME), u]);
        assert_eq!(read(&file).1, [[1.0, 2.0, 3.0, last]], "type {kind}");
    }
}

#[test]
fn structures_by_their_fields_and_simulink_s_by_its_labels() {
    let to = LITTLE;
    let data = to.structure("data", &[("time", to.matrix("", 4, &TIME)), ("u", to.matrix("", 4, &U))]);
    assert_eq!(read(&to.file(std::slice::from_ref(&data))), ("u".into(), vec![U.into()]));
    let both = to.file(&[data, to.matrix("u", 4, &U)]);
    assert_eq!(read(&both).0, "data.u u", "two of one name keep their structures'");
    let signal = |label: &str| {
        let label = to.array(4, &[1, label.len() as u32], "", &to.element(16, label.as_bytes()));
        to.structure("", &[("values", to.matrix("", 4, &Y)), ("label", label)])
    };
    let scope = to.structure("scope", &[("time", to.matrix("", 4, &TIME)), ("signals", signal("theta_rad"))]);
    assert_eq!(read(&to.file(&[scope])).0, "theta_rad1 theta_rad2");
    let nameless = to.structure("out", &[("time", to.matrix("", 4, &TIME)), ("signals", signal(""))]);
    assert_eq!(read(&to.file(&[nameless])).0, "signal1 signal2");
}

#[test]
fn a_matrix_with_names_from_the_command_line() {
    // As Simulink's block To File writes: time in the first row, channels across.
    let across: Vec<f64> = (0..4).flat_map(|k| [TIME[k], U[k], Y[k]]).collect();
    let file = LITTLE.file(&[LITTLE.matrix("ans", 3, &across)]);
    let recording = parse(&file, &named("t,u,_")).unwrap();
    assert_eq!((recording.signals.names.join(" "), recording.signals.period_s), ("u".into(), 0.5));
    assert_eq!(recording.signals.data.as_slice(), U);
    assert!(recording.notice.unwrap().contains("the rows of ans are channels"));
    let wrong = parse(&file, &named("t,u")).unwrap_err();
    assert_eq!(*wrong.fault, Fault::NamesAndColumns { names: 2, columns: 3 });
    assert_eq!(*parse(&file, &Layout::default()).unwrap_err().fault, Fault::NoPeriod);
}

#[test]
fn a_period_instead_of_a_time_axis() {
    let with = |name: &str, x: f64| LITTLE.file(&[LITTLE.matrix("u", 4, &U), LITTLE.matrix(name, 1, &[x])]);
    for (name, x) in [("Ts", 0.25), ("dt", 0.25), ("fs", 4.0), ("period_s", 0.25)] {
        let recording = parse(&with(name, x), &Layout::default()).unwrap();
        assert_eq!((recording.signals.period_s, recording.time_s), (0.25, None));
        assert!(recording.notice.unwrap().contains(&format!("{name} = {x}")));
    }
    let given = |period_s| Layout { period_s: Some(period_s), ..Layout::default() };
    let expected = Fault::PeriodsDiffer { in_file_s: 0.25, given_s: 0.5, tolerance: PERIOD_TOLERANCE };
    assert_eq!(*parse(&with("Ts", 0.25), &given(0.5)).unwrap_err().fault, expected);
    assert_eq!(refused(&with("Ts", -1.0)), Fault::Period { period_s: -1.0 });
    assert_eq!(parse(&with("gain", 7.0), &given(0.5)).unwrap().signals.period_s, 0.5);
}

#[test]
fn what_cannot_be_told_is_listed() {
    let to = LITTLE;
    let u = to.matrix("u", 4, &U);
    let longer = to.matrix("y", 5, &[0.0; 5]);
    let square = to.matrix("y", 4, &[0.0; 16]);
    let words = to.array(4, &[1, 2], "note", &to.element(16, b"hi"));
    for (variables, there) in [
        (vec![u.clone(), longer.clone(), words.clone()], "u (4 x 1), y (5 x 1), note (text)"),
        (vec![u.clone(), square], "u (4 x 1), y (4 x 4)"),
        (
            vec![to.matrix("t", 4, &TIME), to.matrix("time_s", 4, &TIME), u.clone()],
            "t (4 x 1), time_s (4 x 1), u (4 x 1)",
        ),
    ] {
        assert_eq!(refused(&to.file(&variables)), MatFault::Ambiguous { there: there.into() }.into());
    }
    let complex = to.array(6 | 0x800, &[4, 1], "z", &[to.doubles(&U), to.doubles(&U)].concat());
    let object = to.element(14, &[to.element(6, &to.words(&[17, 0])), to.element(1, b"ts")].concat());
    let there = "note (text), z (complex), ts (object)".to_string();
    assert_eq!(refused(&to.file(&[words, complex, object])), MatFault::NoSignals { there }.into());
    assert_eq!(refused(&to.file(&[])), MatFault::NoSignals { there: "it is empty".into() }.into());
    // With a time axis, arrays of another length are left out, and said to be.
    let recording = parse(&to.file(&[to.matrix("t", 1, &TIME), u, longer]), &Layout::default()).unwrap();
    assert_eq!(recording.signals.names, ["u"]);
    assert!(recording.notice.unwrap().ends_with("left out: y (5 x 1)"));
}

#[test]
fn samples_that_are_no_numbers_and_times_that_are_no_clock() {
    let u = LITTLE.matrix("u", 4, &[1.0, 2.0, f64::NAN, 4.0]);
    let error = parse(&LITTLE.file(&[LITTLE.matrix("t", 4, &TIME), u]), &Layout::default()).unwrap_err();
    assert_eq!((*error.fault, error.place.line), (Fault::NotFinite { name: "u".into(), text: "NaN".into() }, Some(3)));
    let late = LITTLE.file(&[LITTLE.matrix("t", 4, &[0.0, 0.5, 1.5, 2.0]), LITTLE.matrix("u", 4, &U)]);
    let error = parse(&late, &Layout::default()).unwrap_err();
    assert!(matches!((&*error.fault, error.place.line), (Fault::UnequalPeriods { .. }, Some(3))), "{error}");
}

#[test]
fn other_formats_are_refused_by_name() {
    let mut hdf5 = LITTLE.file(&[]);
    hdf5.resize(512, 0);
    hdf5.extend_from_slice(b"\x89HDF\r\n\x1a\n");
    for bytes in [hdf5, b"\x89HDF\r\n\x1a\n0000".to_vec(), b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec()] {
        assert_eq!(refused(&bytes), MatFault::Hdf5.into());
        assert!(parse(&bytes, &Layout::default()).unwrap_err().to_string().contains("save -v7 "));
    }
    assert_eq!(refused(b"# Created by Octave 7.3.0\n# name: u\n# type: matrix\n"), MatFault::OctaveText.into());
}

#[test]
fn lengths_that_lie_are_not_believed() {
    let to = LITTLE;
    let huge = |kind: u32| to.file(&[[to.u32(kind), to.u32(u32::MAX)].concat()]);
    let malformed = |fault: Fault| match fault {
        Fault::Mat(MatFault::Malformed { byte, .. }) => byte,
        other => panic!("{other:?}"),
    };
    assert_eq!((malformed(refused(&huge(14))), malformed(refused(&huge(15)))), (128, 128));
    // A shape of 2^62 numbers, a million structures without a byte for them, names of no length.
    let shape = to.array(6, &[1 << 31, 1 << 31], "u", &to.doubles(&U));
    assert!(malformed(refused(&to.file(&[shape]))) > 128);
    let names = |room: u32| [to.element(5, &to.words(&[room])), to.element(1, b"a\0\0\0b\0\0\0")].concat();
    for (rows, room) in [(u32::MAX, 4), (1, 0), (1, 3)] {
        malformed(refused(&to.file(&[to.array(2, &[rows, u32::MAX], "s", &names(room))])));
    }
    // Zeros pack a thousandfold: 400 MB of them in a small file.
    let zeros = to.array(6, &[1, 1], "u", &to.element(9, &vec![0; 400_000_000]));
    let bomb = to.file(&[to.compressed(&zeros)]);
    assert!(bomb.len() < 5_000_000);
    assert!(matches!(refused(&bomb), Fault::Mat(MatFault::Bomb { byte: 128, .. })));
    let file = to.file(&[to.compressed(&to.matrix("u", 4, &U))]);
    assert_eq!(malformed(refused(&[&file[..140], b"junk", &file[144..]].concat())), 128);
    // Structures in structures, deeper than the stack: the innermost are not looked into.
    let nested = (0..2000).fold(to.matrix("", 4, &U), |inner, _| to.structure("s", &[("a", inner)]));
    assert!(matches!(refused(&to.file(&[nested])), Fault::Mat(MatFault::NoSignals { .. })));
}

/// What `export --as mat` writes is read back to the last bit.
#[test]
fn our_own_files_come_back() {
    let text = "time_s,voltage_v,theta_rad\n0,0.1,1e-320\n0.001,0.30000000000000004,-0\n0.002,3,4\n";
    let recording = Recording::parse(text.as_bytes(), Path::new("r.csv"), &Layout::default()).unwrap();
    let mut variables = flexbeam_files::mat_variables(&recording.signals, recording.instants_s());
    variables.push(("tool".into(), MatVariable::Text("flexbeam".into())));
    let read = parse(&mat_bytes(&variables).unwrap(), &Layout::default()).unwrap();
    assert_eq!(csv_text(&read.signals, read.time_s.as_deref()), csv_text(&recording.signals, None));
    assert_eq!((read.signals.period_s, read.notice), (0.001, None));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, rng_seed: prop::test_runner::RngSeed::Fixed(3), ..Default::default() })]

    #[test]
    fn a_file_with_bytes_changed_or_cut_is_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
        end in any::<prop::sample::Index>(),
        cut in any::<bool>(),
        packed in any::<bool>(),
        big in any::<bool>(),
    ) {
        let to = Builder { big };
        let inner = to.structure("s", &[("time", to.matrix("", 4, &TIME)), ("u", to.matrix("", 4, &U)), ("y", to.matrix("", 4, &Y))]);
        let mut file = to.file(&[if packed { to.compressed(&inner) } else { inner }]);
        for (at, byte) in changes {
            // The head but for its version is talk.
            let at = 124 + at.index(file.len() - 124);
            file[at] = byte;
        }
        if cut {
            file.truncate(128 + end.index(file.len() - 128));
        }
        match parse(&file, &Layout::default()) {
            Ok(recording) => prop_assert!(recording.signals.data.iter().all(|x| x.is_finite()) && recording.signals.period_s > 0.0),
            Err(error) => prop_assert!(error.to_string().starts_with("cannot read recording.mat"), "{}", error),
        }
    }
}
