//! The files of flexbeam: recordings, models, controllers, certificates, projects, and where they came from.
//!
//! Enters: paths, bytes and plain values with units in their names. Leaves: the same, checked and located: a fault
//! names the file, the line and the column, what was found and what was needed.
//! Deliberately absent: mathematics, the rig, the clock.
//!
//! This is the only crate that derives serde; JSON answers are plain types of this crate, too.

mod archive;
mod certificate;
mod chunks;
mod clock;
mod columns;
mod controller;
mod csv;
mod document;
mod edit;
mod emit;
mod error;
mod excitation;
mod extended;
mod fault;
mod folder;
mod foreign;
pub mod frame;
mod friction_result;
mod gathered;
mod hash;
mod identify_result;
mod json_document;
mod mat;
mod mat_document;
mod mat_file;
mod matrices;
mod misfit;
mod model;
mod note;
mod project;
mod project_file;
mod provenance;
mod recording;
mod resample;
mod results;
mod rig;
mod run_file;
mod run_result;
mod scope_wire;
mod screen;
mod settings;
mod source_result;
mod stiffness;
mod summary;
mod system_result;
mod table;
mod timed_table;
mod tree;
mod wire;
mod write;

pub use archive::zip_bytes;
pub use certificate::{Certificate, LoopFigures};
pub use chunks::{CHUNK_SAMPLES, Chunks};
pub use clock::STEP_TOLERANCE;
pub use columns::{ColumnName, nearest};
pub use controller::{Controller, Design};
pub use csv::csv_text;
pub use document::{Document, place_of, schema_of};
pub use emit::quoted as toml_string;
pub use error::{Error, FAR, Place, Tried};
pub use excitation::Excitation;
pub use extended::Extended;
pub use fault::Fault;
pub use folder::{check_free_folder, write_folder};
pub use friction_result::{FrictionResult, Quantity, RepeatedBreakaway};
pub use hash::sha256_hex;
pub use identify_result::{IdentifyResult, ModeResult, OrderResult, RefinedResult};
pub use json_document::json_document;
pub use mat::{MatVariable, is_mat_name, mat_bytes, mat_name, mat_variables};
pub use mat_document::{SCRIPT_HEAD, mat_of_controller, mat_of_model};
pub use mat_file::MatFault;
pub use matrices::{Matrices, Rows, pairs};
pub use misfit::Misfit;
pub use model::{Axis, BoundOrigin, Identification, Innovations, Model, Physical, Refinement, Uncertainty, Validation};
pub use note::Note;
pub use project::{Project, ProjectLimits, ProjectReference, ProjectRun};
pub use project_file::ProjectFile;
pub use provenance::{Parent, Provenance, State, Step, trace};
pub use recording::{FEWEST_ROWS, Layout, PERIOD_TOLERANCE, Recording, write_signals};
pub use results::{
    ColumnSummary, DesignResult, DistributedBeam, ExportResult, Figure, MonteCarlo, NewResult, RationalCoefficients,
    RecordResult, RecordingSummary, ReferenceModel, RigTestResult, SampledRadius, ShowResult, SimulateResult,
    SolvabilityResult, Spread, VerifyResult, json_text,
};
pub use rig::{Rig, RigActuator, RigEncoder, RigFriction, RigGauge, RigLink, RigLumped, RigPhysical, Sees};
pub use run_file::{
    CutOff, LiveSettings, RUN_SCHEMA, RunColumns, RunEvent, RunFault, RunFile, RunHeader, RunPhase, RunRecording,
    RunReference, RunSample, RunShape, RunSummary, RunTopic, RunWriter, SettingValue, Stretch,
};
pub use run_result::{LinkCounts, RunResult, ServeResult, TimeQuantiles};
pub use scope_wire::{
    Asking, Attendance, Attendant, CertificateFigure, CertificateSummary, Deed, DeedRequest, Enter, Hello, Knob,
    PageMessage, SCOPE_PROTOCOL, ScopeRun, ScopeSignal, ScopeState, ScopeTiming, ServerMessage, SignalKind, TokenFound,
    ViewerMay,
};
pub use screen::{AmplitudeAxis, Edge, FrequencyAxis, Panel, Scope, ScopeKind, Screen, Trigger, TriggerMode};
pub use settings::{Channel, Law, Settings};
pub use source_result::{SingleBoundResult, SingleErrorResult, SourceResult, UnitResult};
pub use stiffness::{NoStiffness, Stiffness};
pub use summary::{DirectionSummary, IdentificationSummary, LawSummary, PlantTable, ReproduceSummary};
pub use system_result::SystemResult;
pub use table::{LEFT_OUT, TableFault};
pub use wire::{Reading, ReferenceChange, Reply, Request, request_of_changes, request_of_values};
pub use write::{
    Overwrite, Written, check_free, check_free_for_json, check_free_for_mat, check_free_for_script, read_bytes,
    write_bytes,
};
