//! The workspace as cargo sees it. Leaves: packages with their direct dependencies of every kind, and their benches.

use crate::step::Stop;
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// The workspace: its root and its packages.
#[derive(Debug)]
pub struct Workspace {
    /// Where the root Cargo.toml stands.
    pub root: PathBuf,
    /// The members.
    pub packages: Vec<Package>,
}

/// One member.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package {
    /// Name of the package.
    pub name: String,
    /// Direct dependencies: normal, build and dev.
    pub dependencies: Vec<Dependency>,
    /// Names of its bench targets.
    pub benches: Vec<String>,
}

/// One direct dependency.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Name of the package depended upon.
    pub name: String,
    /// What it is for.
    pub kind: Kind,
}

/// What a dependency is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The library or binary itself.
    Normal,
    /// Its build script.
    Build,
    /// Tests, examples, benches.
    Dev,
}

impl Workspace {
    /// Asks `cargo metadata`, without resolving anything outside.
    pub fn read() -> Result<Self, Stop> {
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
        let said = Command::new(cargo)
            .args(["metadata", "--no-deps", "--format-version", "1"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .map_err(|e| Stop::failed(format!("xtask: cargo metadata did not start: {e}")))?;
        if !said.status.success() {
            return Err(Stop::failed(format!("xtask: cargo metadata: {}", String::from_utf8_lossy(&said.stderr))));
        }
        let value = serde_json::from_slice(&said.stdout)
            .map_err(|e| Stop::failed(format!("xtask: cargo metadata is no JSON: {e}")))?;
        Self::from_json(&value).ok_or_else(|| Stop::failed("xtask: cargo metadata lacks a field of format version 1"))
    }

    fn from_json(value: &Value) -> Option<Self> {
        let packages = value["packages"].as_array()?.iter().map(package).collect::<Option<_>>()?;
        Some(Self { root: value["workspace_root"].as_str()?.into(), packages })
    }
}

fn package(value: &Value) -> Option<Package> {
    let dependencies = value["dependencies"].as_array()?.iter().map(dependency).collect::<Option<_>>()?;
    let is_bench = |target: &&Value| target["kind"].as_array().is_some_and(|kinds| kinds.iter().any(|k| k == "bench"));
    let benches = value["targets"].as_array()?.iter().filter(is_bench).map(name).collect::<Option<_>>()?;
    Some(Package { name: name(value)?, dependencies, benches })
}

fn dependency(value: &Value) -> Option<Dependency> {
    let kind = match value["kind"].as_str() {
        None => Kind::Normal,
        Some("build") => Kind::Build,
        Some(_) => Kind::Dev,
    };
    Some(Dependency { name: name(value)?, kind })
}

fn name(value: &Value) -> Option<String> {
    value["name"].as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn kinds_and_benches_are_told_apart() {
        let value = json!({ "workspace_root": "/w", "packages": [{
            "name": "a",
            "dependencies": [
                { "name": "n", "kind": null }, { "name": "b", "kind": "build" }, { "name": "d", "kind": "dev" }
            ],
            "targets": [{ "name": "a", "kind": ["lib"] }, { "name": "time", "kind": ["bench"] }],
        }]});
        let workspace = Workspace::from_json(&value).unwrap();
        let package = &workspace.packages[0];
        let kinds: Vec<_> = package.dependencies.iter().map(|d| (d.name.as_str(), d.kind)).collect();
        assert_eq!(kinds, [("n", Kind::Normal), ("b", Kind::Build), ("d", Kind::Dev)]);
        assert_eq!(package.benches, ["time"]);
    }

    #[test]
    fn this_workspace_is_read() {
        let workspace = Workspace::read().unwrap();
        let kernel = workspace.packages.iter().find(|p| p.name == "flexbeam-kernel").unwrap();
        assert_eq!(kernel.benches, ["tick"]);
        assert!(workspace.root.join("Cargo.toml").exists());
    }
}
