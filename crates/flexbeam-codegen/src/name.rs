//! The name of what is written: a prefix of types and functions, a file, a crate.

use crate::Error;

/// A name that C, Rust, make and CMake take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name(String);

impl Name {
    /// Most characters.
    pub const LONGEST: usize = 40;

    /// Errors: [`Error::Name`].
    pub fn new(found: &str) -> Result<Name, Error> {
        let refused = |why| Err(Error::Name { found: found.to_owned(), why });
        let lower = found.to_ascii_lowercase();
        let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !found.starts_with(|c: char| c.is_ascii_alphabetic()) || !found.chars().all(word) {
            return refused("is no identifier in C");
        }
        if found.len() > Name::LONGEST {
            return refused("is too long");
        }
        if C_KEYWORDS.contains(&found) || RUST_KEYWORDS.contains(&found) {
            return refused("is a keyword of C or Rust");
        }
        if HEADERS.contains(&lower.as_str()) {
            return refused("is a header of C's library");
        }
        if RESERVED.contains(&lower.as_str()) {
            return refused("is taken by the files, targets and macros around it");
        }
        Ok(Name(found.to_owned()))
    }

    /// As the name of a crate.
    ///
    /// Errors: [`Error::Name`] for capital letters.
    pub(crate) fn of_crate(&self) -> Result<&str, Error> {
        let why = "has capital letters, which a crate of Rust must not have";
        let small = !self.0.contains(|c: char| c.is_ascii_uppercase());
        if small { Ok(&self.0) } else { Err(Error::Name { found: self.0.clone(), why }) }
    }

    /// As it was given.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// A template with the name in it.
    pub(crate) fn inserted(&self, template: &str) -> String {
        template.replace("NAME", &self.0).replace("UPPER", &self.upper())
    }

    /// In capital letters, for macros.
    pub(crate) fn upper(&self) -> String {
        self.0.to_ascii_uppercase()
    }
}

/// C99, and the names by which C++ and headers know its later ones.
const C_KEYWORDS: [&str; 42] = [
    "asm",
    "auto",
    "bool",
    "break",
    "case",
    "char",
    "class",
    "const",
    "continue",
    "default",
    "do",
    "double",
    "else",
    "enum",
    "extern",
    "float",
    "for",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "namespace",
    "new",
    "private",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "template",
    "this",
    "typedef",
    "union",
    "unsigned",
    "void",
    "volatile",
    "while",
];

/// Edition 2024.
const RUST_KEYWORDS: [&str; 37] = [
    "abstract", "as", "async", "await", "become", "box", "crate", "dyn", "false", "final", "fn", "gen", "impl", "in",
    "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "self", "super", "trait",
    "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where",
];

/// C99, section 7.1.2.
const HEADERS: [&str; 24] = [
    "assert", "complex", "ctype", "errno", "fenv", "float", "inttypes", "iso646", "limits", "locale", "math", "setjmp",
    "signal", "stdarg", "stdbool", "stddef", "stdint", "stdio", "stdlib", "string", "tgmath", "time", "wchar",
    "wctype",
];

/// Files of ours, targets of make and CMake, crates of Rust's own, devices of Windows, and `byte`, whose BYTE_ORDER is a macro of
/// many systems.
const RESERVED: [&str; 30] = [
    "all",
    "alloc",
    "aux",
    "byte",
    "clean",
    "con",
    "core",
    "flexbeam",
    "flexbeam_frame",
    "fmi2",
    "fmi3",
    "fmu",
    "gnumakefile",
    "help",
    "install",
    "main_udp",
    "makefile",
    "memory",
    "nul",
    "package",
    "plain_arithmetic",
    "prn",
    "proc_macro",
    "std",
    "test",
    "test_vectors",
    "tests",
    "tick",
    "vectors",
    "yield",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_has_small_letters() {
        assert_eq!(Name::new("beam_2").unwrap().of_crate().unwrap(), "beam_2");
        assert!(Name::new("Beam").unwrap().of_crate().is_err());
    }

    #[test]
    fn identifiers_pass_and_others_say_why() {
        for good in ["beam", "Beam2", "b", "a_b_", &"x".repeat(40)] {
            assert_eq!(Name::new(good).unwrap().as_str(), good);
        }
        for (bad, reason) in [
            ("", "no identifier"),
            ("2beam", "no identifier"),
            ("_beam", "no identifier"),
            ("beam-1", "no identifier"),
            ("../beam", "no identifier"),
            ("b\u{e4}r", "no identifier"),
            ("int", "keyword"),
            ("fn", "keyword"),
            ("Stdio", "header"),
            ("vectors", "taken"),
            ("test", "taken"),
            ("NUL", "taken"),
            ("byte", "taken"),
            ("flexbeam", "taken"),
            ("Makefile", "taken"),
            (&"x".repeat(41), "too long"),
        ] {
            let message = Name::new(bad).unwrap_err().to_string();
            assert!(message.contains(reason) && message.contains("\nhint: "), "{message}");
        }
    }
}
