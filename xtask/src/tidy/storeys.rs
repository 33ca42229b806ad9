//! The storeys of DESIGN section 1: a crate imports only from lower storeys, never within its own, dev-dependencies
//! included.

use crate::metadata::{Dependency, Kind, Package};

/// Ground, first, second, third, roof, above.
const STOREYS: [(&str, u8); 13] = [
    ("flexbeam-kernel", 0),
    ("flexbeam-lti", 0),
    ("flexbeam-files", 1),
    ("flexbeam-rig", 1),
    ("flexbeam-ident", 2),
    ("flexbeam-design", 2),
    ("flexbeam-verify", 2),
    ("flexbeam-codegen", 2),
    ("flexbeam-runtime", 2),
    ("flexbeam-report", 3),
    ("flexbeam", 4),
    ("flexbeam-python", 5),
    // Outside the house, so that nothing can lean on it.
    ("xtask", u8::MAX),
];

/// Crates from outside that one room alone may use, with that room.
const RESERVED: [(&str, &str); 2] = [("faer", "flexbeam-ident"), ("serde_derive", "flexbeam-files")];

/// One sentence for each broken rule.
pub fn broken(packages: &[Package]) -> Vec<String> {
    packages.iter().flat_map(|package| of_package(package, packages)).collect()
}

fn of_package(package: &Package, members: &[Package]) -> Vec<String> {
    let Some(own) = storey(&package.name) else {
        return vec![format!("{}: has no storey in xtask/src/tidy/storeys.rs (DESIGN section 1)", package.name)];
    };
    let member = |dependency: &&Dependency| members.iter().any(|p| p.name == dependency.name);
    let upwards = package.dependencies.iter().filter(member).filter_map(|dependency| {
        let other = storey(&dependency.name)?;
        let sentence = || format!("{} (storey {own}) imports {} (storey {other})", package.name, dependency.name);
        (other >= own || package.name == "xtask").then(sentence)
    });
    let reserved = package.dependencies.iter().filter_map(|dependency| {
        let (name, room) = RESERVED.iter().find(|(name, _)| *name == dependency.name)?;
        (*room != package.name).then(|| format!("{} depends on {name}, which is {room}'s alone", package.name))
    });
    upwards.chain(reserved).chain(kernel_dependencies(package)).collect()
}

/// The kernel runs where there is nothing else.
fn kernel_dependencies(package: &Package) -> impl Iterator<Item = String> {
    let inside = |dependency: &&Dependency| package.name == "flexbeam-kernel" && dependency.kind != Kind::Dev;
    let sentence = |dependency: &Dependency| format!("flexbeam-kernel depends on {}; it stands alone", dependency.name);
    package.dependencies.iter().filter(inside).map(sentence)
}

fn storey(name: &str) -> Option<u8> {
    STOREYS.iter().find(|(member, _)| *member == name).map(|(_, storey)| *storey)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, dependencies: &[(&str, Kind)]) -> Package {
        let dependency = |(name, kind): &(&str, Kind)| Dependency { name: (*name).to_owned(), kind: *kind };
        let dependencies = dependencies.iter().map(dependency).collect();
        Package { name: name.to_owned(), dependencies, benches: Vec::new() }
    }

    /// What is broken when `name` depends on `dependency` in a house that has every room.
    fn planted(name: &str, dependency: &str, kind: Kind) -> Vec<String> {
        let mut packages: Vec<Package> = STOREYS.iter().map(|(name, _)| package(name, &[])).collect();
        packages.retain(|p| p.name != name);
        packages.push(package(name, &[(dependency, kind)]));
        broken(&packages)
    }

    #[test]
    fn downwards_is_allowed() {
        for (name, dependency) in [
            ("flexbeam-rig", "flexbeam-kernel"),
            ("flexbeam-verify", "flexbeam-rig"),
            ("flexbeam", "flexbeam-report"),
            ("flexbeam-ident", "faer"),
            ("flexbeam-lti", "nalgebra"),
        ] {
            assert_eq!(planted(name, dependency, Kind::Normal), [""; 0]);
        }
    }

    #[test]
    fn upwards_and_sideways_are_found_in_every_kind() {
        for (name, dependency) in [
            ("flexbeam-lti", "flexbeam-kernel"),
            ("flexbeam-kernel", "flexbeam-rig"),
            ("flexbeam-verify", "flexbeam-design"),
            ("flexbeam-design", "flexbeam-report"),
            ("flexbeam", "xtask"),
            ("xtask", "flexbeam-lti"),
        ] {
            for kind in [Kind::Normal, Kind::Build, Kind::Dev] {
                let found = planted(name, dependency, kind);
                assert!(found.iter().any(|s| s.starts_with(name) && s.contains(dependency)), "{name} -> {dependency}");
            }
        }
    }

    #[test]
    fn a_crate_without_a_storey_is_found() {
        assert_eq!(broken(&[package("flexbeam-attic", &[])]).len(), 1);
    }

    #[test]
    fn reserved_crates_stay_in_their_room() {
        assert_eq!(planted("flexbeam-design", "faer", Kind::Normal).len(), 1);
        assert_eq!(planted("flexbeam-rig", "serde_derive", Kind::Dev).len(), 1);
    }

    #[test]
    fn the_kernel_may_have_dev_dependencies_only() {
        assert_eq!(planted("flexbeam-kernel", "libm", Kind::Normal).len(), 1);
        assert_eq!(planted("flexbeam-kernel", "criterion", Kind::Dev), [""; 0]);
    }
}
