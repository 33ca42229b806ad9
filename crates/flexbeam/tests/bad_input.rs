//! Bad input to the real program: exit status 2; a message with place, cause and hint; no output file touched.

mod support;

use support::Bench;

/// A rig's recording of `rows` rows, changed line by line; line 1 is the header.
fn recording(rows: usize, change: impl Fn(usize, String) -> String) -> String {
    let voltage = support::pseudorandom(rows);
    let mut theta = 0.0;
    let lines = voltage.iter().enumerate().map(|(k, v)| {
        let line = format!("{:.3},{v:?},{theta:?},{:?}", k as f64 / 1000.0, 0.5 * v * theta);
        // A voltage turns the hub from then on; angles that gave it away at once would look like a controller's.
        theta += 0.01 * v;
        line
    });
    let header = std::iter::once("time_s,voltage_v,theta_rad,alpha_rad".to_string());
    header.chain(lines).enumerate().map(|(k, line)| change(k + 1, line) + "\n").collect()
}

/// Runs `line`; it must refuse with all of `words`, and leave the folder as it was.
fn refuses(bench: &Bench, line: &str, words: &[&str]) {
    let files = || bench.names().into_iter().map(|name| (bench.read(&name), name)).collect::<Vec<_>>();
    let before = files();
    let answer = bench.run(line);
    assert_eq!(answer.status, 2, "flexbeam {line}\n{}{}", answer.out, answer.err);
    assert_eq!(answer.out, "", "an answer to a question that could not be answered");
    for word in words.iter().chain(&["hint: "]) {
        assert!(answer.err.contains(word), "{word:?} is not in the message of flexbeam {line}:\n{}", answer.err);
    }
    assert_eq!(files(), before, "flexbeam {line} touched a file");
}

/// The same for a recording, with a model from before at the place of the output, and with none.
fn recording_refused(text: &str, options: &str, words: &[&str]) {
    let bench = Bench::new();
    bench.write("bad.csv", text);
    refuses(&bench, &format!("identify bad.csv {options} -o model.toml"), words);
    assert_eq!(bench.names(), ["bad.csv"]);
    bench.write("model.toml", "schema = \"flexbeam.model/1\"\n# of yesterday\n");
    refuses(&bench, &format!("identify bad.csv {options} -o model.toml --plots plots"), words);
    refuses(&bench, &format!("identify bad.csv {options} -o model.toml --force --json"), words);
}

#[test]
fn a_sound_recording_is_taken() {
    let bench = Bench::new();
    bench.write("good.csv", &recording(400, |_, line| line));
    bench.done("identify good.csv --order 2");
}

#[test]
fn a_missing_value() {
    let text = recording(400, |k, line| {
        let cells: Vec<&str> = line.split(',').collect();
        if k == 17 { format!("{},{},,{}", cells[0], cells[1], cells[3]) } else { line }
    });
    let column = text.lines().nth(16).unwrap().find(",,").unwrap() + 2;
    recording_refused(&text, "", &[&format!("bad.csv:17:{column}"), "empty cell", "theta_rad", "number"]);
}

#[test]
fn a_text_cell() {
    let text = recording(400, |k, line| if k == 23 { line.replacen(',', ",broken", 1) } else { line });
    recording_refused(&text, "", &["bad.csv:23:7", "\"broken", "voltage_v", "needed a number"]);
}

#[test]
fn not_a_number_and_infinity() {
    for word in ["NaN", "inf"] {
        let text = recording(400, |k, line| if k == 9 { format!("0.007,{word},0.1,0.1") } else { line });
        recording_refused(&text, "", &["bad.csv:9:7", "voltage_v", word, "finite"]);
    }
}

#[test]
fn a_row_that_is_short() {
    let text = recording(400, |k, line| if k == 31 { line.rsplit_once(',').unwrap().0.into() } else { line });
    recording_refused(&text, "", &["bad.csv:31", "found 3 values", "needed 4"]);
}

#[test]
fn a_channel_that_is_one_row_short() {
    let text =
        recording(400, |k, line| if k == 401 { line.rsplit_once(',').unwrap().0.to_string() + "," } else { line });
    recording_refused(&text, "", &["bad.csv:401", "alpha_rad", "empty cell"]);
}

#[test]
fn settings_out_of_their_range() {
    let text = recording(400, |_, line| line);
    recording_refused(&text, "--estimate 1.5", &["bad.csv", "estimate is 1.5", "at most 1"]);
    recording_refused(&text, "--block-rows 1", &["bad.csv", "block_rows is 1", "at least 2"]);
    recording_refused(&text, "--order 77", &["bad.csv", "order 77", "at most"]);
}

#[test]
fn two_rows() {
    recording_refused(&recording(2, |_, line| line), "", &["bad.csv", "2 rows", "at least"]);
}

#[test]
fn too_few_rows_for_the_block_rows() {
    recording_refused(&recording(60, |_, line| line), "", &["bad.csv", "30", "20 block rows"]);
}

#[test]
fn no_rows_at_all() {
    recording_refused("", "", &["bad.csv", "no rows"]);
}

#[test]
fn a_constant_input_excites_nothing() {
    let text = recording(400, |k, line| {
        let cells: Vec<&str> = line.split(',').collect();
        if k > 1 { format!("{},1.5,{},{}", cells[0], cells[2], cells[3]) } else { line }
    });
    recording_refused(&text, "", &["bad.csv", "not exciting", "rank 1", "needed 40"]);
    recording_refused(&text, "--remove-mean", &["bad.csv", "not exciting", "rank 0", "needed 40"]);
}

#[test]
fn unequal_sample_periods() {
    let text = recording(400, |k, line| if k == 200 { format!("0.1985{}", &line[5..]) } else { line });
    recording_refused(&text, "", &["bad.csv:200", "unequal sample periods", "0.001 s"]);
    let gap = recording(400, |k, line| if k == 200 { "#".into() } else { line });
    recording_refused(&gap, "", &["bad.csv:201", "0.002 s", "0.001 s"]);
}

#[test]
fn a_period_that_the_time_column_denies() {
    recording_refused(&recording(400, |_, line| line), "--period 0.002", &["bad.csv", "0.001", "0.002"]);
}

#[test]
fn more_outputs_than_columns() {
    let words = ["bad.csv", "no column beta_rad", "theta_rad"];
    recording_refused(&recording(400, |_, line| line), "--outputs theta_rad,alpha_rad,beta_rad", &words);
    let rows = recording(400, |_, line| line).lines().skip(1).map(|l| l.replace(',', " ") + "\n").collect::<String>();
    let named = "--columns time_s,u,y1,y2,y3 --inputs u --outputs y1,y2,y3";
    recording_refused(&rows, named, &["bad.csv:1", "5 names", "4 columns"]);
}

#[test]
fn an_unknown_column() {
    recording_refused(
        &recording(400, |_, line| line),
        "--inputs voltag_v",
        &["bad.csv", "no column voltag_v", "did you mean voltage_v?"],
    );
}

#[test]
fn a_column_named_twice() {
    let twice = "--inputs voltage_v --outputs voltage_v,theta_rad";
    recording_refused(&recording(400, |_, line| line), twice, &["bad.csv", "voltage_v", "twice"]);
}

#[test]
fn columns_without_names_or_without_a_period() {
    let rows: String = (0..100).map(|k| format!("{k} {}\n", k * k % 17)).collect();
    recording_refused(&rows, "", &["bad.csv:1", "2 columns without a name", "--columns"]);
    let named = "--columns u,y --inputs u --outputs y";
    recording_refused(&rows, named, &["bad.csv", "period", "--period"]);
    recording_refused(&rows, &format!("{named} --period=-1"), &["bad.csv", "-1 s", "positive"]);
}

#[test]
fn a_file_that_is_not_there() {
    let bench = Bench::new();
    for line in ["identify none.csv", "show none.toml", "record --rig none.toml", "rig test --apply-to none.toml"] {
        refuses(&bench, line, &["none.", "no file"]);
    }
}

#[test]
fn a_model_with_nan() {
    let bench = Bench::new();
    bench.done("record --linear --duration 1 -o linear.csv");
    bench.done("identify linear.csv --order 4 -o model.toml");
    let text = bench.read("model.toml");
    let line = text.lines().position(|line| line == "A = [").expect("matrix A") + 2;
    let broken: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(k, row)| match row.split_once(',') {
            Some((_, rest)) if k + 1 == line => format!("  [nan,{rest}"),
            _ => row.to_string(),
        })
        .collect();
    let broken = broken.join("\n");
    bench.write("model.toml", &broken);
    refuses(&bench, "show model.toml", &[&format!("model.toml:{line}:"), "nan", "finite"]);
    refuses(&bench, "show model.toml --json", &["A"]);
}

#[test]
fn a_file_of_another_kind_or_of_none() {
    let bench = Bench::new();
    bench.write("strange.toml", "schema = \"kitchen.recipe/1\"\n");
    refuses(&bench, "show strange.toml", &["strange.toml", "kitchen.recipe/1", "flexbeam.model/1"]);
    refuses(&bench, "record --rig strange.toml", &["strange.toml:1", "kitchen.recipe/1", "flexbeam.rig/1"]);
    bench.write("broken.toml", "schema = \"flexbeam.model/1\"\nA = [[1, 2]\n");
    refuses(&bench, "show broken.toml", &["broken.toml:", "TOML"]);
}

#[test]
fn a_rig_that_cannot_be() {
    let bench = Bench::new();
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\n[physical]\nJ_base = -0.002\n");
    refuses(&bench, "record --rig rig.toml", &["rig.toml", "J_base", "-0.002", "positive"]);
    bench.write("rig.toml", "schema = \"flexbeam.rig/1\"\n[physical]\nJ_bass = 0.002\n");
    refuses(&bench, "rig test --rig rig.toml", &["rig.toml:3", "J_bass", "did you mean J_base?"]);
}

#[test]
fn settings_that_make_no_recording() {
    let bench = Bench::new();
    for (option, words) in [
        ("--rms=-1", ["rms", "-1 V"]),
        ("--rms=nan", ["rms", "NaN"]),
        ("--duration=0", ["duration", "0 s"]),
        ("--duration=1e300", ["duration", "samples"]),
        ("--period=0", ["period", "0 s"]),
    ] {
        refuses(&bench, &format!("record {option}"), &words);
    }
}

#[test]
fn a_ramp_that_moves_nothing() {
    let bench = Bench::new();
    refuses(&bench, "rig test --highest 0.2", &["never moved forward", "0.2 V"]);
    refuses(&bench, "rig test --slope=0", &["slope", "positive"]);
}

#[test]
fn a_recording_does_not_replace_what_a_person_wrote() {
    let bench = Bench::new();
    bench.write("notes.csv", "milk,2\n");
    refuses(&bench, "record -o notes.csv", &["notes.csv", "--force"]);
    bench.write("new.csv.toml", "milk = 2\n");
    refuses(&bench, "record -o new.csv", &["new.csv.toml", "--force"]);
    refuses(&bench, "record -o no/such/folder.csv", &["folder"]);
}

#[test]
fn a_clock_that_jitters() {
    let late = recording(400, |k, line| if k == 200 { format!("0.1982{}", &line[5..]) } else { line });
    let words = ["bad.csv:20", "2 of 399 steps are off", "20.00 %", "% rms", "--resample 0.001"];
    recording_refused(&late, "", &words);
    recording_refused(&late, "--resample 0.003", &["a period of 0.003 s to resample to", "filter"]);
    recording_refused(&late, "--period 0.001 --resample nan", &["NaN s", "positive"]);
    let gap = recording(400, |k, line| if k == 200 { "#".into() } else { line });
    recording_refused(&gap, "--resample 0.001", &["bad.csv:201", "unequal sample periods"]);
    let bench = Bench::new();
    bench.write("late.csv", &late);
    let answer = bench.run("identify late.csv --resample 0.001 --order 2");
    assert_eq!(answer.status, 0, "{}", answer.err);
    assert!(answer.err.contains("resampled to 400 samples") && answer.err.contains("theta_rad"), "{}", answer.err);
}

/// Decimal commas between separating commas, MATLAB's HDF5, a table with both decimal signs.
#[test]
fn files_that_can_be_read_in_two_ways_or_in_none() {
    let commas: String = recording(40, |_, line| line).replace('.', ",");
    recording_refused(&commas, "", &["bad.csv:2", "as in the first row", "hint: "]);
    let mixed = recording(400, |k, line| {
        let line = line.replace(',', ";");
        if k < 300 { line } else { line.replace('.', ",") }
    });
    recording_refused(&mixed, "", &["bad.csv:300", "the other decimal sign"]);
    recording_refused("MATLAB 7.3 MAT-file, Platform: GLNXA64\n", "", &["HDF5", "save -v7 "]);
}
