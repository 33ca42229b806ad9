//! What a project says, in words and tables.

use flexbeam_files::{Project, Scope};
use flexbeam_report::{Cell, Table};

use super::holds::{DIGITS, facts};

/// Its files, how it runs, its settings, scopes and panels. Numbers as in the file, in SI.
pub(super) fn project(project: &Project) -> String {
    let path = |path: &Option<std::path::PathBuf>| path.as_ref().map(|path| path.display().to_string());
    let mut text = facts([
        ("name", project.name.clone()),
        ("rig", path(&project.rig)),
        ("recording", path(&project.recording)),
        ("model", path(&project.model)),
        ("controller", path(&project.controller)),
    ]);
    let stated = project.stated();
    if !stated.is_empty() {
        text += &format!("\n{}", facts(stated.iter().map(|(key, value)| (key.as_str(), Some(value.to_string())))));
    }
    let list = |names: &[String]| Cell::from(names.join(", "));
    if !project.scopes.is_empty() {
        let heads = Table::new(&[("scope", ""), ("signals", ""), ("span", "s"), ("trigger", "")]);
        let row = |table: Table, scope: &Scope| {
            let trigger = scope.trigger.as_ref().map_or(String::new(), |t| format!("{} at {}", t.signal, t.level));
            table.row([
                scope.title.as_str().into(),
                list(&scope.signals),
                Cell::number(scope.span_s, DIGITS),
                trigger.into(),
            ])
        };
        text += &format!("\n{}", project.scopes.iter().fold(heads, row).text());
    }
    if !project.panels.is_empty() {
        let heads = Table::new(&[("panel", ""), ("settings", "")]);
        let panels = project.panels.iter().map(|panel| [panel.title.as_str().into(), list(&panel.settings)]);
        text += &format!("\n{}", panels.fold(heads, Table::row).text());
    }
    text
}
