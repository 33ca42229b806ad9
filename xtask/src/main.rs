//! The project's own chores: `cargo xtask test | tidy | bench | book`.

mod bench;
mod book;
mod metadata;
mod needs;
mod python;
mod step;
mod test;
mod tidy;

use metadata::Workspace;
use std::process::ExitCode;
use step::Stop;

const USAGE: &str = "\
usage: cargo xtask CHORE

  test              everything that must hold before a change goes in
  tidy              the house rules alone: storeys, file lengths, leftovers
  bench [ARGS..]    all benches; ARGS go to criterion, not to the page's
  book              the user's book into target/book (fetches mdBook when it is missing)
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(stop) => {
            eprintln!("{}", stop.message.trim_end());
            ExitCode::from(stop.status)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), Stop> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["test"] => test::run(&Workspace::read()?),
        ["tidy"] => tidy::run(&Workspace::read()?),
        ["bench", criterion @ ..] => bench::run(&Workspace::read()?, criterion),
        ["book"] => book::run(&Workspace::read()?),
        _ => Err(Stop::usage(USAGE)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_chore_or_with_an_unknown_one_the_usage_comes_with_status_2() {
        for words in [&[][..], &["tset"], &["test", "quickly"]] {
            let arguments: Vec<String> = words.iter().map(|w| (*w).to_owned()).collect();
            let stop = run(&arguments).unwrap_err();
            assert_eq!((stop.status, stop.message.as_str()), (2, USAGE));
        }
    }
}
