//! One command of a chore: run under a heading, timed, and shown again when it fails.

use std::fmt;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Why a chore ended early.
#[derive(Debug, PartialEq, Eq)]
pub struct Stop {
    /// Exit status: 1, something does not hold; 2, usage or something missing.
    pub status: u8,
    /// For the terminal.
    pub message: String,
}

impl Stop {
    /// Something that must hold does not.
    pub fn failed(message: impl Into<String>) -> Self {
        Self { status: 1, message: message.into() }
    }

    /// The chore was not understood, or lacks something that a person has to provide.
    pub fn usage(message: impl Into<String>) -> Self {
        Self { status: 2, message: message.into() }
    }
}

/// A command with its heading and the environment it needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    title: String,
    program: String,
    arguments: Vec<String>,
    environment: Vec<(String, String)>,
}

impl Step {
    /// `program arguments..`, with the words of `arguments` parted by spaces.
    pub fn new(title: &str, program: &str, arguments: &str) -> Self {
        Self {
            title: title.to_owned(),
            program: program.to_owned(),
            arguments: arguments.split_whitespace().map(str::to_owned).collect(),
            environment: Vec::new(),
        }
    }

    /// A cargo command, by the cargo that runs this chore.
    pub fn cargo(title: &str, arguments: &str) -> Self {
        Self::new(title, "cargo", arguments)
    }

    /// With a variable set.
    pub fn env(mut self, name: &str, value: impl Into<String>) -> Self {
        self.environment.push((name.to_owned(), value.into()));
        self
    }

    /// With one more argument, spaces and all.
    pub fn arg(mut self, argument: impl Into<String>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    /// Runs in `directory`; what the command prints goes straight to the terminal.
    pub fn run(&self, directory: &Path) -> Result<(), Stop> {
        eprintln!("\n=== {} : {self}", self.title);
        let start = Instant::now();
        let status = Command::new(self.executable())
            .args(&self.arguments)
            .envs(self.environment.iter().map(|(name, value)| (name, value)))
            .current_dir(directory)
            .status()
            .map_err(|e| Stop::failed(format!("xtask: `{self}` did not start: {e}")))?;
        if !status.success() {
            return Err(Stop::failed(format!("\nxtask: {} failed ({status}). To repeat it:\n  {self}", self.title)));
        }
        eprintln!("--- {} : {:.1} s", self.title, start.elapsed().as_secs_f64());
        Ok(())
    }

    fn executable(&self) -> String {
        let own_cargo = std::env::var("CARGO").ok().filter(|_| self.program == "cargo");
        own_cargo.unwrap_or_else(|| self.program.clone())
    }
}

/// As a person would type it.
impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in &self.environment {
            write!(f, "{name}={} ", quoted(value))?;
        }
        write!(f, "{}", quoted(&self.program))?;
        self.arguments.iter().try_for_each(|argument| write!(f, " {}", quoted(argument)))
    }
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:+,@%^".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_command_is_repeated_as_one_would_type_it() {
        let step = Step::new("nothing", "false", "-a b").env("X", "it's").arg("two words");
        let stop = step.run(Path::new(".")).unwrap_err();
        assert_eq!(stop.status, 1);
        assert!(stop.message.ends_with(r"X='it'\''s' false -a b 'two words'"), "{}", stop.message);
    }

    #[test]
    fn the_environment_arrives() {
        Step::new("environment", "sh", "-c").arg("test \"$X\" = 'a b'").env("X", "a b").run(Path::new(".")).unwrap();
    }

    #[test]
    fn a_command_that_does_not_exist_is_named() {
        let stop = Step::new("absent", "flexbeam-no-such-program", "").run(Path::new(".")).unwrap_err();
        assert!(stop.message.contains("flexbeam-no-such-program"));
    }
}
