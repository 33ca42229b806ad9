//! Bytes of stack that a function and all that it calls may take, read from what compilers and disassemblers say.
#![allow(dead_code)]

use std::collections::{BTreeMap, BTreeSet};

/// Functions with their own bytes and what they call or fall into.
#[derive(Debug, Default)]
pub struct Frames {
    own: BTreeMap<String, u64>,
    calls: BTreeMap<String, BTreeSet<String>>,
}

impl Frames {
    /// Of assembly for x86-64: the call frame's largest offset, which counts the return address, too.
    pub fn of_assembly(text: &str) -> Frames {
        let (mut frames, mut name) = (Frames::default(), String::new());
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [label] | [label, "#", ..] if label.ends_with(':') && !label.starts_with('.') => {
                    name = label.trim_end_matches(':').to_owned();
                    frames.own.insert(name.clone(), 8);
                }
                [".cfi_def_cfa_offset", bytes] => frames.at_least(&name, bytes.parse().unwrap()),
                [".cfi_def_cfa_register" | ".cfi_def_cfa", ..] => panic!("{name}: a frame whose size is not known"),
                [word, target, ..] if word.starts_with("call") || (*word == "jmp" && !target.starts_with('.')) => {
                    frames.call(&name, target);
                }
                _ => {}
            }
        }
        frames
    }

    /// Of a disassembly for ARM: everything that moves the stack pointer down, whatever the branches between do.
    pub fn of_arm(text: &str) -> Frames {
        let (mut frames, mut name, mut ended) = (Frames::default(), String::new(), true);
        for line in text.lines() {
            if let Some((_, label)) = line.trim_end().strip_suffix(">:").and_then(|line| line.split_once(" <")) {
                if !ended {
                    frames.call(&name, label);
                }
                name = label.to_owned();
                frames.own.entry(name.clone()).or_insert(0);
            } else if let Some(instruction) = line.split('\t').nth(2).map(|_| line.splitn(3, '\t').nth(2).unwrap()) {
                let (word, operands) = instruction.split_once('\t').unwrap_or((instruction, ""));
                *frames.own.get_mut(&name).unwrap() += lowered(word, operands);
                if let Some((_, target)) = operands.split_once('<') {
                    let target = target.split(['+', '>']).next().unwrap();
                    if word.starts_with('b') && target != name {
                        frames.call(&name, target);
                    }
                }
                // Alignment and constants behind the end are never reached.
                ended = match word.trim_end_matches(".n").trim_end_matches(".w") {
                    word if word == "nop" || word.starts_with('.') => ended,
                    "b" => true,
                    "bx" => operands.trim() == "lr",
                    "pop" | "ldmia" => operands.contains("pc}"),
                    "ldr" => operands.starts_with("pc, [sp]"),
                    _ => false,
                };
            }
        }
        frames
    }

    /// Its own.
    pub fn own(&self, name: &str) -> u64 {
        *self.own.get(name).unwrap_or_else(|| panic!("{name} is none of {:?}", self.own.keys()))
    }

    /// What it calls takes; zero when it calls nothing.
    pub fn below<'a>(&'a self, name: &'a str) -> u64 {
        self.deepest(name, &mut vec![name])
    }

    /// Routines of one text that jump into each other take their bytes once: a jump back into what is on the way adds nothing.
    fn deepest<'a>(&'a self, name: &str, way: &mut Vec<&'a str>) -> u64 {
        let mut deepest = 0;
        for callee in self.calls.get(name).into_iter().flatten().map(String::as_str) {
            if !way.contains(&callee) {
                way.push(callee);
                deepest = deepest.max(self.own(callee) + self.deepest(callee, way));
                way.pop();
            }
        }
        deepest
    }

    /// The one function whose mangled name holds these words.
    pub fn named(&self, words: &str) -> String {
        let found: Vec<&String> = self.own.keys().filter(|name| name.contains(words)).collect();
        assert_eq!(found.len(), 1, "{words}: {found:?}");
        found[0].clone()
    }

    fn at_least(&mut self, name: &str, bytes: u64) {
        let own = self.own.entry(name.to_owned()).or_insert(0);
        *own = bytes.max(*own);
    }

    fn call(&mut self, caller: &str, callee: &str) {
        self.calls.entry(caller.to_owned()).or_default().insert(callee.to_owned());
    }
}

/// Bytes by which an instruction lowers the stack pointer.
fn lowered(word: &str, operands: &str) -> u64 {
    let listed = |size: u64| {
        let list = operands.split(['{', '}']).nth(1).expect("a list");
        let number = |name: &str| name.trim()[1..].parse::<u64>().expect("a numbered register");
        let part = |part: &str| part.split_once('-').map_or(1, |(from, to)| number(to) - number(from) + 1);
        size * list.split(',').map(part).sum::<u64>()
    };
    let immediate = |after: &str| -> u64 {
        let text = operands.split(after).nth(1).expect("a number").split([']', ' ', '\t', '@']).next().unwrap();
        text.parse().expect("a whole number")
    };
    let plain = word.trim_end_matches(".w");
    match plain {
        "push" | "stmdb" if plain == "push" || operands.starts_with("sp!") => listed(4),
        "vpush" => listed(if operands.contains("{d") { 8 } else { 4 }),
        "sub" | "subw" if operands.starts_with("sp, sp, #") => immediate("sp, sp, #"),
        "sub" if operands.starts_with("sp, #") => immediate("sp, #"),
        "str" | "strd" if operands.contains("[sp, #-") && operands.contains("]!") => immediate("[sp, #-"),
        _ if operands.starts_with("sp, ") && !["add", "addw", "mov", "cmp", "stmia", "ldmia"].contains(&plain) => {
            panic!("{word} {operands}: what does it do to the stack pointer?")
        }
        _ => 0,
    }
}
