//! Changes that a viewer asks for in vain.

/// Why nothing was changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum NotSet {
    /// These.
    #[error(
        "found a viewer's change of {}, needed a run that viewers may change\nhint: `flexbeam tell` changes it over the control socket; --foxglove-set lets every viewer do it",
        .0.join(", ")
    )]
    ReadOnly(Vec<String>),
    /// These.
    #[error("found a viewer's change of {} before the run was armed, needed an armed one\nhint: wait until the topics move", .0.join(", "))]
    NotArmed(Vec<String>),
    /// These, and what the table of settings has to say.
    #[error(
        "found a viewer's change of {} that no setting takes ({reason}), needed the keys of /settings\nhint: a word for law and reference.shape, a number for all others",
        .names.join(", ")
    )]
    NoSetting {
        /// These.
        names: Vec<String>,
        /// In serde's words.
        reason: String,
    },
    /// This one.
    #[error("found {0:?} without a number or a word, needed one of them\nhint: a setting cannot be deleted")]
    Value(String),
    /// The run's own words.
    #[error("{0}")]
    Refused(String),
}
