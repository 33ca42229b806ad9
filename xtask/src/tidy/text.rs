//! Rules about the files themselves: length, leftovers, recordings, toolchain, who derives serde.

/// A file of the repository.
#[derive(Debug, Clone)]
pub struct File {
    /// From the root, with slashes.
    pub path: String,
    /// What it holds.
    pub bytes: Vec<u8>,
}

/// Lines without tests (STYLE: below about 400).
const LONGEST: usize = 400;

/// Files that may be longer, each with its reason.
const LONG_FILES: [(&str, &str); 0] = [];

/// Written in two pieces, so that this file does not find itself.
const LEFTOVERS: [&str; 4] =
    [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("todo", "!("), concat!("unimplemented", "!(")];

/// The public recordings have their own terms; they are read from outside, never copied in.
const RECORDINGS: [&str; 5] = ["CD_player_arm", "dryer", "evaporator", "heating_system", "robot_arm"];
const DATA_ENDINGS: [&str; 6] = ["dat", "csv", "txt", "mat", "mcap", "gz"];

/// One sentence for each broken rule; `recordings` are contents that must not be found.
pub fn broken(files: &[File], recordings: &[Vec<u8>]) -> Vec<String> {
    let of_file = |file: &File| {
        let rules = [
            too_long(file),
            leftover(file),
            recording(file, recordings),
            toolchain(file),
            derives_serde(file),
            lints(file),
        ];
        rules.into_iter().flatten().collect::<Vec<_>>()
    };
    files.iter().flat_map(of_file).chain(stale_allowances(files)).collect()
}

fn too_long(file: &File) -> Option<String> {
    let allowed = LONG_FILES.iter().any(|(path, _)| *path == file.path);
    if !is_source(file) || is_test(file) || allowed {
        return None;
    }
    let lines = lines_without_tests(&file.text());
    (lines > LONGEST).then(|| format!("{}: {lines} lines without tests, more than {LONGEST}", file.path))
}

fn stale_allowances(files: &[File]) -> impl Iterator<Item = String> {
    let needed = |path: &str| files.iter().any(|file| file.path == path && lines_without_tests(&file.text()) > LONGEST);
    LONG_FILES
        .iter()
        .filter(move |(path, _)| !needed(path))
        .map(|(path, _)| format!("{path}: needs no allowance any more"))
}

/// Lines outside `#[cfg(test)] mod .. { .. }` as rustfmt lays it out: it ends with a brace in the first column.
fn lines_without_tests(text: &str) -> usize {
    let lines: Vec<&str> = text.lines().collect();
    let starts = |k: usize| {
        lines[k] == "#[cfg(test)]" && lines.get(k + 1).is_some_and(|l| l.starts_with("mod ") && l.ends_with('{'))
    };
    let (mut count, mut inside) = (0, false);
    for (k, line) in lines.iter().enumerate() {
        inside = inside || starts(k);
        count += usize::from(!inside);
        inside = inside && *line != "}";
    }
    count
}

fn leftover(file: &File) -> Option<String> {
    let text = file.text();
    let place = |(k, line): (usize, &str)| {
        let word = LEFTOVERS.iter().find(|word| has_word(line, word))?;
        Some(format!("{}:{}: {word}", file.path, k + 1))
    };
    text.lines().enumerate().find_map(place)
}

/// `word` in `line`, not as a part of a longer word.
fn has_word(line: &str, word: &str) -> bool {
    let part_of_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    line.match_indices(word).any(|(at, _)| {
        let after = line[at + word.len()..].chars().next();
        !part_of_word(line[..at].chars().next_back()) && (word.ends_with('(') || !part_of_word(after))
    })
}

fn recording(file: &File, recordings: &[Vec<u8>]) -> Option<String> {
    let name = file.path.rsplit('/').next().unwrap_or_default();
    let (stem, endings) = name.split_once('.').unwrap_or((name, ""));
    let named = RECORDINGS.iter().any(|r| r.eq_ignore_ascii_case(stem))
        && endings.split('.').any(|e| DATA_ENDINGS.contains(&e));
    let copied = recordings.contains(&file.bytes);
    (named || copied).then(|| format!("{}: a shared recording, which must not be committed", file.path))
}

fn toolchain(file: &File) -> Option<String> {
    let named = file.path == "rust-toolchain.toml" || file.path == "rust-toolchain";
    named.then(|| format!("{}: names a toolchain that people may lack", file.path))
}

/// `derive(..)` lists, over as many lines as they take.
fn derives_serde(file: &File) -> Option<String> {
    if !is_source(file) || file.path.starts_with("crates/flexbeam-files/") {
        return None;
    }
    let text = file.text();
    let lists = text.split("derive(").skip(1).map(|rest| rest.split(')').next().unwrap_or_default());
    let names = lists.flat_map(|list| list.split(',')).map(|name| name.rsplit("::").next().unwrap_or_default().trim());
    let found = names.into_iter().any(|name| name == "Serialize" || name == "Deserialize");
    found.then(|| format!("{}: derives serde; only flexbeam-files does", file.path))
}

/// Members take the lints of the workspace.
fn lints(file: &File) -> Option<String> {
    let parts: Vec<&str> = file.path.split('/').collect();
    let member = matches!(parts.as_slice(), ["crates", _, "Cargo.toml"] | ["xtask", "Cargo.toml"]);
    let taken = file.text().contains("[lints]\nworkspace = true");
    (member && !taken).then(|| format!("{}: lacks `[lints] workspace = true`", file.path))
}

fn is_source(file: &File) -> bool {
    [".rs", ".js", ".css"].iter().any(|ending| file.path.ends_with(ending))
}

fn is_test(file: &File) -> bool {
    file.path.split('/').any(|part| part == "tests" || part == "tests.rs")
}

impl File {
    /// Without what is no text.
    fn text(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str, text: impl Into<String>) -> File {
        File { path: path.to_owned(), bytes: text.into().into_bytes() }
    }

    fn planted(path: &str, text: impl Into<String>) -> Vec<String> {
        broken(&[file(path, text)], &[b"1.0 2.0\n".to_vec()])
    }

    #[test]
    fn long_files_are_found_and_tests_do_not_count() {
        let body = "const X: u8 = 0;\n".repeat(LONGEST);
        let tests = format!("\n#[cfg(test)]\nmod tests {{\n{}}}\n", "    // line\n".repeat(300));
        assert_eq!(planted("crates/a/src/x.rs", body.clone() + "//\n").len(), 1);
        assert_eq!(planted("crates/a/src/x.rs", body[18..].to_owned() + &tests), [""; 0]);
        assert_eq!(planted("crates/a/src/x.rs", body.clone() + &tests + "// after the tests\n").len(), 1);
        assert_eq!(planted("crates/a/page/x.js", body.clone() + "//\n").len(), 1);
        assert_eq!(planted("crates/a/tests/x.rs", body.repeat(2)), [""; 0]);
        assert_eq!(planted("book/src/x.md", body.repeat(2)), [""; 0]);
    }

    #[test]
    fn leftovers_are_found_with_their_line() {
        for word in LEFTOVERS {
            let found = planted("crates/a/src/x.rs", format!("//\n// {word} later\n"));
            assert_eq!(found, [format!("crates/a/src/x.rs:2: {word}")]);
            assert_eq!(planted("book/src/x.md", format!("{word}: later\n")).len(), 1);
            assert_eq!(planted("crates/a/src/x.rs", format!("MAS{word}N\n")), [""; 0]);
        }
    }

    #[test]
    fn recordings_are_found_by_name_and_by_content() {
        assert_eq!(planted("cases/robot_arm.dat", "").len(), 1);
        assert_eq!(planted("cases/Dryer.dat.gz", "").len(), 1);
        assert_eq!(planted("cases/innocent.txt", "1.0 2.0\n").len(), 1);
        assert_eq!(planted("cases/robot_arm.toml", ""), [""; 0]);
    }

    #[test]
    fn a_member_without_the_lints_of_the_workspace_is_found() {
        let package = "[package]\nname = \"a\"\n";
        assert_eq!(planted("crates/a/Cargo.toml", package).len(), 1);
        assert_eq!(planted("xtask/Cargo.toml", package).len(), 1);
        assert_eq!(planted("crates/a/Cargo.toml", package.to_owned() + "[lints]\nworkspace = true\n"), [""; 0]);
        assert_eq!(planted("crates/a/tests/link/Cargo.toml", package), [""; 0]);
    }

    #[test]
    fn a_toolchain_file_is_found() {
        assert_eq!(planted("rust-toolchain.toml", "[toolchain]\n").len(), 1);
        assert_eq!(planted("rust-toolchain", "1.95\n").len(), 1);
    }

    #[test]
    fn serde_is_derived_in_one_room() {
        let text = concat!("#[der", "ive(\n    Debug,\n    serde::Serialize,\n)]\nstruct X;\n");
        assert_eq!(planted("crates/flexbeam-rig/src/x.rs", text).len(), 1);
        assert_eq!(
            planted("crates/flexbeam-rig/tests/x.rs", concat!("#[der", "ive(Deserialize)]\nstruct X;\n")).len(),
            1
        );
        assert_eq!(planted("crates/flexbeam-files/src/x.rs", text), [""; 0]);
        assert_eq!(planted("crates/flexbeam-rig/src/x.rs", "#[derive(Debug)]\nstruct Serialize;\n"), [""; 0]);
    }
}
