//! `flexbeam identify`, the real program on real and simulated recordings.

mod support;

use serde_json::Value;
use support::{Bench, data, number, pairs, pseudorandom};

/// (18).
const K1: f64 = 1060.8;
const K2: f64 = 1465.2;
const C: f64 = 57.7;
const B: f64 = 107.39;

fn mean_fit(answer: &Value) -> f64 {
    let fits = answer["fit_percent"].as_object().expect("fits by output");
    fits.values().map(|fit| fit.as_f64().expect("a fit")).sum::<f64>() / fits.len() as f64
}

/// Columns, periods, i and n of shared/data/README.md; the best peer there less 0.3.
#[test]
fn real_recordings_reach_their_fits() {
    let Some(folder) = data() else { return };
    let bench = Bench::new();
    for (file, settings, outputs, needed) in [
        ("robot_arm", "--columns u,y --period 1 --inputs u --outputs y --block-rows 20 --order 4", 1, 96.1),
        (
            "CD_player_arm",
            "--columns u1,u2,y1,y2 --period 1 --inputs u1,u2 --outputs y1,y2 --block-rows 15 --order 8",
            2,
            74.61,
        ),
        ("dryer", "--columns u,y --period 0.08 --inputs u --outputs y --block-rows 15 --order 4", 1, 85.56),
        (
            "evaporator",
            "--columns u1,u2,u3,y1,y2,y3 --period 1 --inputs u1,u2,u3 --outputs y1,y2,y3 --block-rows 10 --order 4",
            3,
            52.81,
        ),
        ("heating_system", "--columns time,u,y --inputs u --outputs y --block-rows 15 --order 7", 1, 74.52),
    ] {
        let recording = folder.join(format!("{file}.dat"));
        let line = format!("identify {} {settings} --estimate 0.5 --remove-mean -o {file}.toml", recording.display());
        let answer = bench.json(&line);
        let fit = mean_fit(&answer);
        println!("{file:16} {fit:6.2} % (needed {needed} %), identified in {} s", number(&answer, "identify_s"));
        assert!(fit >= needed, "{file}: {fit:.2} %");
        assert_eq!(answer["fit_percent"].as_object().unwrap().len(), outputs);
        let poles = pairs(&answer, "poles");
        assert_eq!(poles.len(), number(&answer, "order") as usize);
        assert_eq!(
            bench.json(&format!("show {file}.toml"))["content"]["validation"]["fit_percent"],
            answer["fit_percent"]
        );
    }
}

/// Every nonzero entry of (18) through the files: record, identify, physical form.
#[test]
fn the_linear_rig_comes_back_from_its_recording() {
    let bench = Bench::new();
    bench.done("record --linear --duration 10 --period 0.001 -o linear.csv");
    let answer = bench.json("identify linear.csv --order 4 --estimate 1.0 -o model.toml");
    let close = |found: f64, needed: f64, what: &str| {
        assert!((found / needed - 1.0).abs() <= 1e-10, "{what}: {found} for {needed}");
    };
    for (key, needed) in [("k1", K1), ("k2", K2), ("c", C), ("b", B)] {
        close(number(&answer["physical"], key), needed, key);
        assert!(number(&answer["physical"], &format!("{key}_std")) < 1e-9 * needed);
    }
    let continuous = &bench.json("show model.toml")["content"]["continuous"];
    let entry = |M: &str, r: usize, c: usize| continuous[M][r][c].as_f64().expect("an entry");
    for (M, r, c, needed) in [
        ("A", 0, 2, 1.0),
        ("A", 1, 3, 1.0),
        ("A", 2, 1, K1),
        ("A", 3, 1, -K2),
        ("A", 2, 2, -C),
        ("A", 3, 2, C),
        ("B", 2, 0, B),
        ("B", 3, 0, -B),
        ("C", 0, 0, 1.0),
        ("C", 1, 1, 1.0),
    ] {
        close(entry(M, r, c), needed, &format!("{M}({r},{c})"));
    }
    assert!(answer["fit_percent"].as_object().unwrap().values().all(Value::is_null), "nothing was left to validate");
}

/// With friction, dead zone, encoder, noise and the modes of the distributed beam: the modes are found, and the lumped numbers
/// besides, whatever order the model has. The beam's poles are DESIGN section 3's; its lumped numbers are not quite (18)'s,
/// because a distributed beam is not a lumped one.
#[test]
fn the_default_rig_shows_its_modes_and_its_lumped_numbers() {
    let bench = Bench::new();
    bench.done("record");
    let answer = bench.json("identify recording.csv --block-rows 50");
    let poles = pairs(&answer, "continuous_poles");
    for (re, im, within) in [(-10.85, 23.42, 0.1), (-2.30, 129.5, 0.01), (-2.018, 354.3, 0.01)] {
        let distance = |pole: &[f64; 2]| (pole[0] - re).hypot(pole[1] - im) / f64::hypot(re, im);
        assert!(poles.iter().any(|pole| distance(pole) < within), "{re} + {im}j is not among {poles:?}");
    }
    let short = bench.run("identify recording.csv --order 4");
    assert!(short.err.contains("theta_rad") && short.err.contains("hint: more --block-rows"), "{}", short.err);
    for line in ["identify recording.csv --block-rows 50", "identify recording.csv --order 4"] {
        let physical = &bench.json(line)["physical"];
        for (key, needed) in [("k1", K1), ("k2", K2), ("c", C), ("b", B)] {
            let found = number(physical, key);
            assert!((found / needed - 1.0).abs() < 0.15, "{line}: {key} = {found}, in (18) {needed}");
            assert!(number(physical, &format!("{key}_std")) < 0.02 * found);
        }
    }
}

/// The deflection alone shows three states; the poles are the roots of s^3 + c s^2 + k2 s + c (k2 - k1).
#[test]
fn from_the_deflection_alone_the_order_is_three() {
    let bench = Bench::new();
    bench.done("record --linear -o linear.csv");
    let answer = bench.json("identify linear.csv --outputs alpha_rad -o model.toml");
    assert_eq!(number(&answer, "order"), 3.0);
    for (key, needed) in [("k1", K1), ("k2", K2), ("c", C), ("b", B)] {
        let found = number(&answer["physical"], key);
        assert!((found / needed - 1.0).abs() <= 1e-9, "{key}: {found} for {needed}");
    }
    for [re, im] in pairs(&answer, "continuous_poles") {
        let square = [re * re - im * im, 2.0 * re * im];
        let cube = [square[0] * re - square[1] * im, square[0] * im + square[1] * re];
        let value = [cube[0] + C * square[0] + K2 * re + C * (K2 - K1), cube[1] + C * square[1] + K2 * im];
        let slope = [3.0 * square[0] + 2.0 * C * re + K2, 3.0 * square[1] + 2.0 * C * im];
        // Newton's step from the pole to the root.
        let step = value[0].hypot(value[1]) / slope[0].hypot(slope[1]);
        assert!(step / re.hypot(im) <= 1e-9, "{re} + {im}j is off by {step}");
    }
}

/// y(k+1) = -y(k)/2 + u(k) swings from sample to sample as nothing continuous does.
#[test]
fn a_model_without_a_continuous_form_says_so() {
    let bench = Bench::new();
    let mut y = 0.0;
    let rows: String = pseudorandom(400)
        .into_iter()
        .map(|u| {
            let row = format!("{u:?} {y:?}\n");
            y = -0.5 * y + u;
            row
        })
        .collect();
    bench.write("swing.dat", &rows);
    let line = "identify swing.dat --columns u,y --period 0.1 --inputs u --outputs y --order 1 -o model.toml";
    let answer = bench.run(&format!("{line} --json"));
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(answer.err.contains("no continuous model") && answer.err.contains("negative real axis"), "{}", answer.err);
    let answer: Value = serde_json::from_str(&answer.out).expect("one object");
    assert!(answer["continuous_poles"].is_null());
    assert!((pairs(&answer, "poles")[0][0] + 0.5).abs() < 1e-10);
    let shown = bench.json("show model.toml");
    assert!(shown["content"]["continuous"].is_null());
    assert!(bench.done("show model.toml").contains("no continuous form"));
}

#[test]
fn the_answer_has_the_keys_that_scripts_rely_on() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1 -o linear.csv");
    let answer = bench.json("identify linear.csv --order 4 --block-rows 15");
    for key in [
        "order",
        "period_s",
        "block_rows",
        "singular_values",
        "poles",
        "continuous_poles",
        "fit_percent",
        "physical",
        "A",
        "B",
        "C",
        "D",
        "initial_state",
        "identify_s",
    ] {
        assert!(!answer[key].is_null(), "{key}");
    }
    assert_eq!(number(&answer, "block_rows"), 15.0);
    assert!(number(&answer, "identify_s") > 0.0);
    // From rest: the output map applied to the initial state is the first sample, which is zero.
    let x0 = answer["initial_state"].as_array().unwrap();
    for row in answer["C"].as_array().unwrap() {
        let y0: f64 =
            row.as_array().unwrap().iter().zip(x0).map(|(c, x)| c.as_f64().unwrap() * x.as_f64().unwrap()).sum();
        assert!(y0.abs() < 1e-9, "{y0}");
    }
    assert!(bench.path("model.toml").is_file(), "model.toml is the default");
}

/// The rule finds four states; a person may name another number.
#[test]
fn the_order_is_found_or_taken() {
    let bench = Bench::new();
    bench.done("record --linear -o linear.csv");
    let answer = bench.run("identify linear.csv --json");
    assert!(answer.err.contains("order 4 by the rule"), "{}", answer.err);
    assert_eq!(number(&serde_json::from_str(&answer.out).unwrap(), "order"), 4.0);
    assert_eq!(number(&bench.json("identify linear.csv --order 3"), "order"), 3.0);
    let refused = bench.run("identify linear.csv --order several");
    assert_eq!(refused.status, 2);
    assert!(refused.err.contains("several") && refused.err.contains("auto"), "{}", refused.err);
}

/// Degrees and millivolts at the face, SI inside.
#[test]
fn columns_in_degrees_are_read_as_radians() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1 -o linear.csv");
    let csv = bench.read("linear.csv");
    let rows = csv.lines().skip(1).map(|line| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        format!("{:?},{:?},{:?},{:?}\n", cells[0], cells[1], cells[2].to_degrees(), cells[3].to_degrees())
    });
    bench.write("degrees.csv", &("time_s,voltage_v,theta_deg,alpha_deg\n".to_string() + &rows.collect::<String>()));
    for line in ["identify degrees.csv --order 4", "identify degrees.csv --order 4 --outputs theta_deg,alpha_deg"] {
        let answer = bench.json(line);
        let k1 = number(&answer["physical"], "k1");
        assert!((k1 / K1 - 1.0).abs() < 1e-8, "{k1}");
        assert!(answer["fit_percent"]["theta_rad"].is_number());
    }
}

#[test]
fn plots_are_pictures() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1 -o linear.csv");
    bench.done("identify linear.csv --order 4 --plots plots");
    for name in ["singular_values", "outputs", "frequency_response"] {
        assert!(bench.read(&format!("plots/{name}.svg")).starts_with("<svg"));
        let png = std::fs::read(bench.path(&format!("plots/{name}.png"))).unwrap();
        assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    }
    assert!(bench.read("plots/singular_values.svg").contains("chosen order n = 4"));
}

/// An older model makes room for a newer one; what a person wrote does not.
#[test]
fn only_models_are_written_over() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1 -o linear.csv");
    bench.done("identify linear.csv --order 3 -o model.toml");
    bench.done("identify linear.csv --order 4 -o model.toml");
    assert_eq!(bench.json("show model.toml")["content"]["identification"]["order"], 4);
    bench.write("notes.toml", "milk = 2\n");
    let refused = bench.run("identify linear.csv --order 4 -o notes.toml");
    assert_eq!(refused.status, 2);
    assert!(refused.err.contains("notes.toml") && refused.err.contains("--force"), "{}", refused.err);
    assert_eq!(bench.read("notes.toml"), "milk = 2\n");
    bench.done("identify linear.csv --order 4 -o notes.toml --force");
    assert_eq!(bench.json("show notes.toml")["schema"], "flexbeam.model/1");
}

/// On the estimating half, where the refinement works, and through the files.
#[test]
fn a_refined_model_is_nearer_to_its_recording() {
    let bench = Bench::new();
    bench.done("record --duration 4 --period 0.002 -o beam.csv");
    let plain = bench.json("identify beam.csv --order 6 --estimate 1 -o plain.toml");
    assert!(plain["refined"].is_null());
    let before = bench.json("show plain.toml")["content"]["identification"]["refinement"].clone();
    assert!(before.is_null());
    let mut missed = Vec::new();
    for (flag, errors) in
        [("--refine", "simulated"), ("--refine=simulated", "simulated"), ("--refine=predicted", "predicted")]
    {
        let answer = bench.json(&format!("identify beam.csv --order 6 --estimate 1 {flag} -o {errors}.toml"));
        let refined = &answer["refined"];
        assert_eq!(refined["errors"], errors);
        assert!(number(refined, "missed_after") < 0.99 * number(refined, "missed_before"), "{refined}");
        assert!(number(refined, "iterations") > 0.0 && number(refined, "refine_s") > 0.0);
        assert_eq!(refined["K"].is_null(), errors == "simulated", "{refined}");
        // The gain of the model that was would not fit.
        assert!(answer["innovations"].is_null());
        let file = &bench.json(&format!("show {errors}.toml"))["content"]["identification"]["refinement"];
        assert_eq!(file["missed_after"], refined["missed_after"]);
        assert_ne!(answer["A"], plain["A"]);
        assert!(number(&answer["physical"], "k1") > 0.0);
        missed.push(number(refined, "missed_after"));
    }
    assert_eq!(missed[0], missed[1]);
    // A step ahead is easier to tell than the whole record.
    assert!(missed[2] < missed[0]);
    let refused = bench.run("identify beam.csv --refine=guess -o no.toml");
    assert_eq!(refused.status, 2);
    assert!(!bench.path("no.toml").exists());
}

/// The first Ctrl-C ends the descent, and the best model until then is written.
#[test]
fn ctrl_c_ends_a_refinement_with_what_it_has() {
    let bench = Bench::new();
    bench.done("record --duration 60 --period 0.001 -o long.csv");
    let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_flexbeam"));
    program
        .args("identify long.csv --outputs alpha_rad --order 12 --estimate 1 --refine --json -o long.toml".split(' '));
    let pipe = std::process::Stdio::piped;
    let mut child =
        program.current_dir(bench.path("")).stdout(pipe()).stderr(pipe()).spawn().expect("the program starts");
    // The handler is there once the kernel says so: bit 1 of the signals that the process catches.
    let status = format!("/proc/{}/status", child.id());
    let catches = || {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let mask = text
            .lines()
            .find_map(|line| line.strip_prefix("SigCgt:"))
            .and_then(|x| u64::from_str_radix(x.trim(), 16).ok());
        mask.is_some_and(|mask| mask & 0b10 != 0)
    };
    let start = std::time::Instant::now();
    while !catches() {
        assert!(start.elapsed().as_secs() < 60, "the refinement never began");
        assert!(child.try_wait().expect("its state").is_none(), "it ended before it refined");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let id = nix::unistd::Pid::from_raw(child.id() as i32);
    nix::sys::signal::kill(id, nix::sys::signal::Signal::SIGINT).expect("the signal is sent");
    let asked = std::time::Instant::now();
    let output = child.wait_with_output().expect("it ends");
    println!("ended {:.2} s after Ctrl-C", asked.elapsed().as_secs_f64());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).expect("an answer");
    assert_eq!(answer["refined"]["reason"], "asked");
    assert!(number(&answer["refined"], "missed_after") <= number(&answer["refined"], "missed_before"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("Ctrl-C"));
    assert_eq!(bench.json("show long.toml")["content"]["identification"]["refinement"]["reason"], "asked");
}

/// A rig with its modes and sensors, without friction; 250 Hz tells three modes and keeps this short.
const SMOOTH: &str = "schema = \"flexbeam.rig/1\"\nperiod_s = 0.004\n[friction]\ncoulomb_nm = 0.0\n\
                      [actuator]\ndead_zone_plus_v = 0.0\ndead_zone_minus_v = 0.0\n";

/// From the recording alone to a certificate, and `verify` finds by the exact distributed beam that alpha(s) covers it.
#[test]
fn the_bound_of_a_recording_serves_the_design_and_covers_the_exact_beam() {
    let bench = Bench::new();
    bench.write("rig.toml", SMOOTH);
    bench.done("record --rig rig.toml --rms 3 -o beam.csv");
    let found = bench.json("identify beam.csv --order 4 --stability-degree 1.5 -o model.toml")["uncertainty"].clone();
    assert_eq!((number(&found, "beta"), &found["origin"]["contradicted"]), (1.5, &Value::Bool(false)));
    assert_eq!(number(&found["origin"], "full_order"), 8.0);
    assert_eq!(bench.json("show model.toml")["content"]["uncertainty"], found);
    let design = bench.json("design model.toml --stability-degree 1.5 --uncertainty model -o controller.toml");
    assert_eq!(design["uncertainty"]["num"], found["num"]);
    let verified = bench.json("verify controller.toml --runs 0");
    let covered = number(&verified["distributed_beam"], "covered");
    println!("largest |dG/alpha| of the exact beam {covered:.3}");
    assert!((0.5..1.0).contains(&covered), "{covered}");

    for (line, status, words) in [
        ("design model.toml --stability-degree 1.4 --uncertainty model", 2, "made for beta = 1.5, needed 1.4"),
        (
            "design model.toml --stability-degree 1.5 --uncertainty model --nominal continuous",
            2,
            "is for psi of [physical], needed one for psi of [continuous]",
        ),
        ("identify beam.csv --stability-degree 2.6 -o no.toml", 1, "beta = 2.6 cannot hold"),
        ("identify beam.csv --stability-degree 0 -o no.toml", 2, "beta [1/s] is 0, needed a positive number"),
        ("identify beam.csv --outputs alpha_rad --stability-degree 1.5 -o no.toml", 2, "no output is named psi"),
    ] {
        let answer = bench.run(line);
        assert_eq!(answer.status, status, "{line}: {}", answer.err);
        assert!(answer.err.contains(words) && answer.err.contains("hint: "), "{line}: {}", answer.err);
    }
    bench.done("identify beam.csv --order 4 -o plain.toml");
    let missing = bench.run("design plain.toml --stability-degree 1.5 --uncertainty model -o no.toml");
    assert!(missing.status == 2 && missing.err.contains("no table [uncertainty]"), "{}", missing.err);
    assert!(!bench.path("no.toml").exists());
}

/// With friction no linear model explains the recording: the answer says that it rests on an assumption.
#[test]
fn a_bound_through_friction_says_what_it_rests_on() {
    let bench = Bench::new();
    bench.done("record --duration 20 --period 0.004 -o rough.csv");
    let answer = bench.run("identify rough.csv --block-rows 25 --stability-degree 1.5 --json -o rough.toml");
    assert_eq!(answer.status, 0, "{}", answer.err);
    let found: Value = serde_json::from_str(&answer.out).unwrap();
    assert_eq!(found["uncertainty"]["origin"]["contradicted"], Value::Bool(true));
    assert!(answer.err.contains("by assumption only"), "{}", answer.err);
}

/// The voltage repeats, so the figure has noise and distortion; a voltage that does not repeat has coherence.
#[test]
fn the_figure_of_a_periodic_recording_tells_noise_from_distortion() {
    let bench = Bench::new();
    bench.done("record --signal odd-multisine --periods 4 --duration 16 --period 0.004 --rms 3 -o periodic.csv");
    bench.done("identify periodic.csv --block-rows 25 --order 8 --plots periodic");
    let svg = bench.read("periodic/frequency_response.svg");
    assert!(svg.contains("odd harmonics not sent") && svg.contains("noise of the mean") && !svg.contains("Coherence"));
    bench.done("record --duration 4 --period 0.004 -o white.csv");
    bench.done("identify white.csv --order 8 --plots white");
    let svg = bench.read("white/frequency_response.svg");
    assert!(svg.contains("coherence of alpha_rad") && svg.contains("95 % of the measurement"));
}

/// Tip angle, two samples late, with white noise: known structure through options, answer and file.
#[test]
fn known_structure_goes_through_the_files() {
    let bench = Bench::new();
    bench.done("record --linear --duration 6 -o linear.csv");
    let noise = pseudorandom(6000);
    let mut text = String::from("time_s,voltage_v,psi_rad\n");
    let rows: Vec<Vec<f64>> = bench
        .read("linear.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    for (k, row) in rows.iter().enumerate() {
        let late = &rows[k.saturating_sub(40)];
        let psi = late[2] + late[3] + 1e-5 * noise[k];
        text += &format!("{},{},{psi}\n", row[0], row[1]);
    }
    bench.write("late.csv", &text);
    let line = "identify late.csv --outputs psi_rad --integrators 1 --delay 40 --stable --order 44 -o model.toml";
    let too_many = bench.run(line);
    assert_eq!(too_many.status, 2, "{}", too_many.err);
    let answer = bench.json("identify late.csv --outputs psi_rad --integrators 1 --delay 40 --order 4 --orders 6 --plots plots -o model.toml");
    assert_eq!((number(&answer, "order"), number(&answer, "integrators")), (44.0, 1.0));
    assert_eq!(answer["input_delay"], serde_json::json!([40]));
    assert!(pairs(&answer, "poles").contains(&[1.0, 0.0]));
    assert!(mean_fit(&answer) > 99.0, "{}", mean_fit(&answer));
    assert!(answer["continuous_poles"].is_null(), "poles at 0 are a delay");
    let orders = answer["orders"].as_array().unwrap();
    assert_eq!(orders.iter().map(|row| number(row, "order")).collect::<Vec<_>>(), [2.0, 3.0, 4.0, 5.0, 6.0]);
    assert!(orders.iter().all(|row| row["modes"].is_array() && row["criterion"].is_number()));
    for name in ["stabilisation", "orders"] {
        assert!(bench.read(&format!("plots/{name}.svg")).starts_with("<svg"));
    }
    let content = &bench.json("show model.toml")["content"];
    assert_eq!(content["identification"]["input_delay"], answer["input_delay"]);
    assert_eq!(content["innovations"], answer["innovations"]);
    assert_eq!(answer["innovations"]["K"].as_array().unwrap().len(), 44);
    let refused = bench.run("identify late.csv --outputs psi_rad --delay 40 --order 4 --refine -o none.toml");
    assert!(refused.status == 2 && refused.err.contains("an input delay of 40 samples"), "{}", refused.err);
    assert!(!bench.path("none.toml").exists());
    let free = bench.json("identify late.csv --outputs psi_rad --no-feedthrough --order 4 -o free.toml");
    assert_eq!(free["D"], serde_json::json!([[0.0]]));
}

/// A cut output is told with its share, and an integrator too many refused.
#[test]
fn doubts_are_told_and_structure_that_cannot_be_is_refused() {
    let bench = Bench::new();
    let u = pseudorandom(2000);
    let (mut text, mut y) = (String::from("u,y\n"), 0.0_f64);
    for u in &u {
        text += &format!("{u},{}\n", y.clamp(-0.4, 0.4));
        y = 0.98 * y + 0.2 * u;
    }
    bench.write("cut.csv", &text);
    let told = bench.run("identify cut.csv --period 0.1 --inputs u --outputs y --order 1 -o model.toml");
    assert_eq!(told.status, 0, "{}", told.err);
    assert!(told.err.contains("% of the samples: it looks cut off"), "{}", told.err);
    for options in
        ["--integrators 2", "--integrators 1 --order 1", "--method paper --stable", "--block-rows 20,1", "--delay 5000"]
    {
        let refused =
            bench.run(&format!("identify cut.csv --period 0.1 --inputs u --outputs y -o none.toml {options}"));
        assert_eq!(refused.status, 2, "{options}: {}", refused.err);
        assert!(refused.err.contains("hint:"), "{options}: {}", refused.err);
        assert!(!bench.path("none.toml").exists());
    }
}
