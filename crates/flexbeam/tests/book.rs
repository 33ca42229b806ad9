//! The user's book holds what it says: its examples run, its links lead somewhere, its tables list what the program has.
//!
//! A block tagged `console` is a session: lines that begin with `$ ` are run in order, those of one page in one folder that is
//! empty at first. A block tagged `LANGUAGE file=NAME` is written there as NAME before the lines below it run. A line ends well
//! with exit status 0, or with N where it ends with `# status N`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_flexbeam");

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A chapter, or the README.
struct Page {
    path: PathBuf,
    text: String,
}

impl Page {
    fn read(path: PathBuf) -> Page {
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Page { path, text }
    }

    fn name(&self) -> String {
        let root = root();
        self.path.strip_prefix(&root).unwrap_or(&self.path).display().to_string()
    }
}

fn chapters() -> Vec<Page> {
    let mut paths = Vec::new();
    markdown_below(&root().join("book/src"), &mut paths);
    assert!(paths.len() > 10, "the book's folder has moved");
    paths.into_iter().map(Page::read).collect()
}

fn markdown_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            markdown_below(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
}

fn pages_with_examples() -> Vec<Page> {
    let readme = root().join("README.md");
    chapters().into_iter().chain(readme.exists().then(|| Page::read(readme))).collect()
}

/// What a page asks to be done, in order.
enum Act<'a> {
    Run { line: usize, command: &'a str },
    Write { name: &'a str, text: String },
}

/// Every fenced block: line of its first line, info string, lines.
fn blocks(text: &str) -> Vec<(usize, &str, Vec<&str>)> {
    let mut blocks = Vec::new();
    let mut open: Option<(usize, &str, Vec<&str>)> = None;
    for (k, line) in text.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => open = Some((k + 2, info.trim(), Vec::new())),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some((_, _, lines)), None) => lines.push(line),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is left open");
    blocks
}

fn acts(text: &str) -> Vec<Act<'_>> {
    let mut acts = Vec::new();
    for (first, info, lines) in blocks(text) {
        if let Some(name) = info.split(' ').find_map(|word| word.strip_prefix("file=")) {
            acts.push(Act::Write { name, text: lines.join("\n") + "\n" });
        } else if info == "console" {
            let numbered = lines.iter().enumerate();
            acts.extend(
                numbered.filter_map(|(k, line)| Some(Act::Run { line: first + k, command: line.strip_prefix("$ ")? })),
            );
        }
    }
    acts
}

/// The words behind `flexbeam`, and the exit status that the line announces.
fn parsed(command: &str) -> Result<(Vec<&str>, i32), String> {
    let (words, status) = match command.split_once("# status ") {
        Some((words, status)) => (words, status.trim().parse().map_err(|_| format!("no status: {status}"))?),
        None => (command, 0),
    };
    let mut words = words.split_whitespace();
    match words.next() {
        Some("flexbeam") => Ok((words.collect(), status)),
        other => Err(format!("console blocks run flexbeam only, found {other:?}; tag the block `text`")),
    }
}

fn flexbeam(words: &[&str], folder: &Path) -> Output {
    Command::new(PROGRAM).args(words).current_dir(folder).output().expect("the program starts")
}

/// Errors: a sentence for what does not run as the page says.
fn run(page: &Page) -> Result<usize, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut runs = 0;
    for act in acts(&page.text) {
        match act {
            Act::Write { name, text } => std::fs::write(folder.path().join(name), text).expect("written"),
            Act::Run { line, command } => {
                let place = format!("{}:{line}: {command}", page.name());
                let (words, needed) = parsed(command).map_err(|wrong| format!("{place}: {wrong}"))?;
                let output = flexbeam(&words, folder.path());
                let said = String::from_utf8_lossy(&output.stderr);
                if output.status.code() != Some(needed) {
                    return Err(format!("{place}: {}, needed status {needed}\n{said}", output.status));
                }
                runs += 1;
            }
        }
    }
    Ok(runs)
}

#[test]
fn every_example_runs() {
    let pages = pages_with_examples();
    // Two pages at a time: the pages do not know of one another.
    let (left, right) = pages.split_at(pages.len() / 2);
    let all = |pages: &[Page]| pages.iter().map(run).collect::<Vec<_>>();
    let results = std::thread::scope(|scope| {
        let left = scope.spawn(|| all(left));
        let mut results = all(right);
        results.extend(left.join().expect("running pages does not panic"));
        results
    });
    let wrong: Vec<&String> = results.iter().filter_map(|result| result.as_ref().err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.iter().map(|w| w.as_str()).collect::<Vec<_>>().join("\n\n"));
    let runs: usize = results.iter().flatten().sum();
    assert!(runs > 15, "only {runs} examples were found");
}

/// The targets of `[text](target)` outside of code.
fn links(text: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut fenced = false;
    for line in text.lines() {
        fenced ^= line.starts_with("```");
        let outside_of_code = line.split('`').step_by(2);
        prose.extend(outside_of_code.filter(|_| !fenced).chain(["\n"]));
    }
    let starts = prose.match_indices("](").map(|(at, found)| at + found.len());
    starts.filter_map(|at| Some(prose[at..].split_once(')')?.0.to_string())).collect()
}

/// The anchors that mdBook gives a page's headings.
fn anchors(page: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(page).expect("a page of text");
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let kept = |c: char| (c.is_alphanumeric() || matches!(c, ' ' | '-' | '_')).then(|| c.to_ascii_lowercase());
    headings.map(|heading| heading.chars().filter_map(kept).collect::<String>().replace(' ', "-")).collect()
}

#[test]
fn every_relative_link_leads_somewhere() {
    let mut broken = Vec::new();
    for page in pages_with_examples() {
        let folder = page.path.parent().expect("a page lies in a folder");
        for link in links(&page.text) {
            let (target, anchor) = link.split_once('#').unwrap_or((link.as_str(), ""));
            let target = if target.is_empty() { page.path.clone() } else { folder.join(target) };
            let leads = target.exists() && (anchor.is_empty() || anchors(&target).contains(anchor));
            if !link.contains("://") && !leads {
                broken.push(format!("{}: {link}", page.name()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_page_stands_in_the_summary() {
    let summary = Page::read(root().join("book/src/SUMMARY.md"));
    let folder = root().join("book/src");
    let listed: BTreeSet<PathBuf> = links(&summary.text).iter().map(|link| folder.join(link)).collect();
    let written = chapters().into_iter().map(|page| page.path).filter(|path| *path != summary.path);
    assert_eq!(listed, written.collect());
}

/// Commands that have a section of their own, as words.
const COMMANDS: [&str; 13] = [
    "reproduce",
    "new",
    "record",
    "identify",
    "design",
    "verify",
    "simulate",
    "run",
    "tell",
    "rig",
    "rig test",
    "export",
    "show",
];

/// The part of the page under `## flexbeam COMMAND`.
fn section(page: &Page, command: &str) -> String {
    let heading = format!("## flexbeam {command}");
    let mut lines = page.text.lines().skip_while(|line| *line != heading);
    assert!(lines.next().is_some(), "{} has no section {heading:?}", page.name());
    lines.take_while(|line| !line.starts_with("## ")).collect::<Vec<_>>().join("\n")
}

/// Each `--option` in a text.
fn options(text: &str) -> BTreeSet<String> {
    let named = text.match_indices("--").map(|(at, _)| {
        let name = text[at + 2..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '-');
        format!("--{}", name.collect::<String>())
    });
    named.filter(|option| option.chars().any(char::is_alphabetic)).collect()
}

/// What `--help` lists at the start of its lines.
fn options_of(command: &str) -> BTreeSet<String> {
    let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
    let output = flexbeam(&words, Path::new("."));
    let help = String::from_utf8(output.stdout).expect("text");
    let listed = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let first = listed.filter_map(|line| options(line.split("  ").next()?).into_iter().next());
    first.filter(|option| option != "--help").collect()
}

#[test]
fn the_command_line_chapter_has_the_program_s_options() {
    let page = Page::read(root().join("book/src/command-line.md"));
    for command in COMMANDS {
        let mut documented = options(&section(&page, command));
        documented.extend(of_features(command));
        assert_eq!(documented, options_of(command), "left: the book; right: {command} --help");
    }
}

/// Options of a command that this build has by a feature, from the page of that feature.
fn of_features(command: &str) -> BTreeSet<String> {
    if cfg!(feature = "foxglove") && command == "run" { foxglove_options() } else { BTreeSet::new() }
}

fn foxglove_options() -> BTreeSet<String> {
    let page = Page::read(root().join("book/src/foxglove.md"));
    let rows = page.text.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    rows.flat_map(options).collect()
}

/// The page of the feature lists what the feature adds, which begins with its name, and a plain program has none of it.
#[test]
fn the_foxglove_chapter_has_the_options_of_its_feature() {
    let listed = foxglove_options();
    assert!(!listed.is_empty());
    let added: BTreeSet<String> = options_of("run").into_iter().filter(|o| o.starts_with("--foxglove")).collect();
    assert_eq!(added, if cfg!(feature = "foxglove") { listed } else { BTreeSet::new() });
}

/// Backquoted first cells of the table under `### JSON keys`.
fn documented_keys(section: &str) -> BTreeSet<String> {
    let table = section.lines().skip_while(|line| !line.starts_with("### JSON keys")).skip(1);
    let rows = table.take_while(|line| !line.starts_with('#')).filter(|line| line.starts_with("| `"));
    let first_cells = rows.filter_map(|row| row.split('|').nth(1));
    first_cells.flat_map(|cell| cell.split('`').skip(1).step_by(2).map(String::from).collect::<Vec<_>>()).collect()
}

/// Command lines that together give every key of every answer.
const ANSWERS: [(&str, &str); 16] = [
    ("reproduce", "reproduce --out reproduce"),
    ("new", "new beam"),
    ("record", "record --linear --duration 2 --out recording.csv"),
    ("identify", "identify recording.csv --out model.toml"),
    ("design", "design model.toml --stability-degree 1.5 --uncertainty beam --out controller.toml"),
    ("design", "design model.toml --stability-degree 12 --uncertainty 0.06 --robust-only"),
    ("rig test", "rig test --friction --rest 10"),
    ("simulate", "simulate controller.toml --duration 1"),
    ("verify", "verify controller.toml --runs 4"),
    ("export", "export recording.csv --as mat --out recording.mat"),
    ("export", "export controller.toml --as mat --out beam.mat"),
    ("export", "export controller.toml --as c --precision f32 --out source"),
    ("export", "export controller.toml --as fmu --sources-only --out unit.fmu"),
    ("run", "run controller.toml --duration 0.5 --hold 5"),
    ("rig", "rig --listen pty --duration 0.3"),
    ("show", "show controller.toml"),
];

#[test]
fn the_command_line_chapter_has_the_program_s_json_keys() {
    let page = Page::read(root().join("book/src/command-line.md"));
    let folder = tempfile::tempdir().expect("a folder");
    let mut found: Vec<(&str, BTreeSet<String>)> = Vec::new();
    for (command, line) in ANSWERS {
        let words: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        let output = flexbeam(&words, folder.path());
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
        let keys = answer.as_object().expect("one JSON object").keys().cloned();
        match found.last_mut() {
            Some((last, all)) if *last == command => all.extend(keys),
            _ => found.push((command, keys.collect())),
        }
    }
    found.push(("tell", keys_of_tell(folder.path())));
    for (command, keys) in found {
        assert_eq!(documented_keys(&section(&page, command)), keys, "left: the book; right: {command} --json");
    }
}

/// Keys of all replies of a run: it is asked how it stands, told something senseless, and stopped.
fn keys_of_tell(folder: &Path) -> BTreeSet<String> {
    let line = "run controller.toml --wait --hold 20 --control socket --out told.mcap --json";
    let mut program = Command::new(PROGRAM);
    let mut run = program.args(line.split(' ')).current_dir(folder).stdout(Stdio::null()).spawn().expect("it starts");
    let mut keys = BTreeSet::new();
    let mut told = |words: &[&str]| {
        let output = flexbeam(&[&["tell", "socket"], words, &["--json"]].concat(), folder);
        let reply: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        keys.extend(reply.as_object().into_iter().flat_map(|reply| reply.keys().cloned()));
        reply
    };
    let late = Instant::now() + Duration::from_secs(60);
    while told(&["status"])["last"].is_null() && Instant::now() < late {
        std::thread::sleep(Duration::from_millis(20));
    }
    told(&["set", "eps_u_v=-1"]);
    told(&["stop"]);
    assert!(run.wait().expect("it can be waited for").success(), "{line}");
    keys
}

/// Every Rust source of the crates, tests left out, as one text per file; escapes of string literals undone.
fn sources() -> Vec<String> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(root().join("crates")).unwrap().map(|e| e.unwrap().path().join("src")).collect();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(plain(&std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    found
}

/// A source with its continued lines joined and its quotes bare: what a person reads.
fn plain(source: &str) -> String {
    let mut joined = String::new();
    for part in source.split("\\\n") {
        let next = if joined.is_empty() { part } else { part.trim_start() };
        joined.push_str(next);
    }
    joined.replace("\\\"", "\u{1}")
}

/// The literal parts of a message's first line between its placeholders, without its hint.
fn fixed_parts(message: &str) -> Vec<String> {
    let text = message.split("\\n").next().unwrap_or_default();
    let text = text.split("; hint").next().unwrap_or_default();
    let mut parts = vec![String::new()];
    let mut inside = false;
    for c in text.chars() {
        match c {
            '{' => inside = true,
            '}' => {
                inside = false;
                parts.push(String::new());
            }
            c if !inside => parts.last_mut().expect("there is one").push(c),
            _ => {}
        }
    }
    parts.into_iter().map(|part| part.replace('\u{1}', "\"")).collect()
}

/// The messages of `#[error("..")]`.
fn error_messages(source: &str) -> Vec<String> {
    let attributes = source.split("#[error(").skip(1);
    let literals = attributes.filter_map(|rest| rest.trim_start().strip_prefix('"')?.split('"').next());
    literals.map(String::from).collect()
}

/// The text literals of `Fault::found`.
fn fault_messages(source: &str) -> Vec<String> {
    let Some((_, rest)) = source.split_once("pub fn found(&self)") else { return Vec::new() };
    let body = rest.split("pub fn needed(&self)").next().unwrap_or_default();
    body.split('"').skip(1).step_by(2).map(String::from).collect()
}

#[test]
fn the_error_index_has_every_message() {
    let page = Page::read(root().join("book/src/errors.md")).text.replace("\\|", "|");
    let mut missing = BTreeSet::new();
    for source in sources() {
        for message in error_messages(&source).into_iter().chain(fault_messages(&source)) {
            let longest = fixed_parts(&message).into_iter().max_by_key(String::len).unwrap_or_default();
            let words = longest.trim_matches([' ', ',', ';', ':', '(', ')', '/', '-']);
            if words.len() > 3 && !page.contains(words) {
                missing.insert(words.to_string());
            }
        }
    }
    assert!(missing.is_empty(), "not in book/src/errors.md: {missing:#?}");
}

/// First cells of the index's tables, as code: the messages that it lists.
fn listed_messages(page: &str) -> Vec<String> {
    let unescaped = page.replace("\\|", "\u{2}");
    let rows = unescaped.lines().filter(|line| line.starts_with("| `"));
    let cells = rows.filter_map(|row| row.split('|').nth(1));
    cells
        .flat_map(|cell| cell.split('`').skip(1).step_by(2).map(|m| m.replace('\u{2}', "|")).collect::<Vec<_>>())
        .collect()
}

#[test]
fn the_error_index_lists_nothing_else() {
    let page = Page::read(root().join("book/src/errors.md"));
    let units = ["fmi2.c", "fmi3.c"].map(|name| root().join("crates/flexbeam-codegen/templates/fmu").join(name));
    let units = units.map(|path| std::fs::read_to_string(path).expect("the text of a unit")).concat();
    let everything = sources().concat().replace('\u{1}', "\"") + &units;
    let listed = listed_messages(&page.text);
    assert!(listed.len() > 80, "only {} messages were found in the index", listed.len());
    let parts = listed.iter().flat_map(|message| message.split('…'));
    let words = parts.map(|part| part.trim_matches([' ', ',', ';', ':', '(', ')', '"', '-']));
    let unknown: BTreeSet<&str> = words.filter(|part| part.len() > 3 && !everything.contains(part)).collect();
    assert!(unknown.is_empty(), "no message of the program has these words: {unknown:#?}");
}
