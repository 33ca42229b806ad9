//! Excitation, recordings and identification: Figures 5 and 6, (18) recovered.

use std::path::Path;

use flexbeam_files::{
    Document, IdentificationSummary, Matrices, Model, Note, Overwrite, Physical, PlantTable, Validation, csv_text,
    write_bytes,
};
use flexbeam_ident::excitation::white_gaussian;
use flexbeam_ident::physical::physical_form;
use flexbeam_ident::structured::{BeamDamping, LinkFit, Measured, structured_fit};
use flexbeam_ident::{Identified, Options, Order, identify as subspace};
use flexbeam_lti::{Signals, StateSpace};
use flexbeam_rig::{Lumped, Output, RigParameters};

use crate::Failure;
use crate::output::provenance;
use crate::record::excited;
use crate::response::linear_rig;

/// Length of the recordings [s].
const DURATION_S: f64 = 10.0;

/// Rms of the white Gaussian voltage on the linear rig [V].
const RMS_V: f64 = 2.0;

/// On the nonlinear rig, whose friction matters less the harder it is driven [V].
const NONLINEAR_RMS_V: f64 = 4.0;

/// Output noise of the recording, as a part of each output's rms.
const NOISE: f64 = 0.01;

/// What the recordings gave.
pub struct Plant {
    /// The recording with noise: voltage, theta, alpha.
    pub recording: Signals,
    /// Subspace model of the recording with noise.
    pub identified: Identified,
    /// Subspace model of the rig with its modes, without friction.
    pub modes_identified: Option<StateSpace>,
    /// The design's nominal plant: the structured fit of the recording with noise.
    pub nominal: Lumped,
    noise_free: Lumped,
    noisy: LinkFit,
    nonlinear: LinkFit,
}

/// Records and identifies; leaves recording.csv and model.toml in the folder.
pub fn identify(rig: &RigParameters, seed: u64, folder: &Path) -> Result<Plant, Failure> {
    let clean = record(&linear_rig(rig), RMS_V, seed)?;
    let noise_free = unstructured(&identified(&clean, Order::Auto)?)?;
    let recording = with_noise(clean, seed);
    let noisy_model = identified(&recording, Order::Auto)?;
    let noisy = structured(&recording, unstructured(&noisy_model)?)?;
    let nonlinear = structured(&record(rig, NONLINEAR_RMS_V, seed)?, noise_free)?;
    let plant = Plant {
        nominal: noisy.parameters,
        modes_identified: identified(&record(&rig.linear(), RMS_V, seed)?, Order::Auto)?.continuous.ok(),
        recording,
        identified: noisy_model,
        noise_free,
        noisy,
        nonlinear,
    };
    plant.write(folder)?;
    Ok(plant)
}

fn record(rig: &RigParameters, rms_v: f64, seed: u64) -> Result<Signals, Failure> {
    excited(rig, DURATION_S, rms_v, seed).map_err(|error| Failure::Input { tried: "record".into(), error })
}

/// White Gaussian noise on both outputs.
fn with_noise(mut signals: Signals, seed: u64) -> Signals {
    for row in 1..signals.channels() {
        let rms = (signals.data.row(row).norm_squared() / signals.samples() as f64).sqrt();
        let stream = seed.wrapping_add(NOISE_STREAM * row as u64);
        for (k, e) in white_gaussian(signals.samples(), NOISE * rms, f64::INFINITY, stream).into_iter().enumerate() {
            signals.data[(row, k)] += e;
        }
    }
    signals
}

/// Noise of each channel is drawn from a seed this far from the excitation's.
const NOISE_STREAM: u64 = 1_000_003;

fn identified(signals: &Signals, order: Order) -> Result<Identified, Failure> {
    let (inputs, outputs) = (rows(signals, 0..1), rows(signals, 1..3));
    subspace(&inputs, &outputs, &Options { order, ..Options::default() })
        .map_err(Failure::while_trying("identify the recording"))
}

fn rows(signals: &Signals, range: std::ops::Range<usize>) -> Signals {
    Signals {
        names: signals.names[range.clone()].to_vec(),
        units: signals.units[range.clone()].to_vec(),
        period_s: signals.period_s,
        data: signals.data.rows_range(range).into_owned(),
    }
}

fn unstructured(found: &Identified) -> Result<Lumped, Failure> {
    let tried = "bring the model into physical coordinates";
    let continuous = found.continuous.as_ref().map_err(|e| Failure::while_trying(tried)(e.clone()))?;
    Ok(physical_form(continuous, 0, 1).map_err(Failure::while_trying(tried))?.parameters)
}

fn structured(signals: &Signals, start: Lumped) -> Result<LinkFit, Failure> {
    let row = |k: usize| signals.data.row(k).iter().copied().collect::<Vec<f64>>();
    let (theta, alpha) = (row(1), row(2));
    let measured = [(Output::Theta, &theta), (Output::Alpha, &alpha)];
    let measured = measured.map(|(output, samples)| Measured { output, samples });
    structured_fit(&row(0), &measured, signals.period_s, start, BeamDamping::None)
        .map_err(Failure::while_trying("fit the physical parameters"))
}

fn exact(p: Lumped) -> Physical {
    Physical { k1: p.k1, k2: p.k2, c: p.c, b: p.b, ..Physical::default() }
}

fn with_errors(fit: &LinkFit) -> Physical {
    let std = fit.standard_errors;
    Physical {
        k1_std: Some(std.k1),
        k2_std: Some(std.k2),
        c_std: Some(std.c),
        b_std: Some(std.b),
        ..exact(fit.parameters)
    }
}

impl Plant {
    /// (18) printed and recovered.
    pub fn table(&self) -> PlantTable {
        let printed = Lumped::PAPER;
        let pairs = printed.to_array().into_iter().zip(self.noise_free.to_array());
        PlantTable {
            printed: exact(printed),
            noise_free: exact(self.noise_free),
            noise_free_error: pairs.map(|(p, x)| (x / p - 1.0).abs()).fold(0.0, f64::max),
            noisy: with_errors(&self.noisy),
            nonlinear: with_errors(&self.nonlinear),
        }
    }

    /// Order, singular values, fits.
    pub fn identification(&self) -> IdentificationSummary {
        IdentificationSummary {
            samples: self.recording.samples(),
            block_rows: self.identified.block_rows,
            order: self.identified.order,
            singular_values: self.identified.singular_values.clone(),
            fit_percent: self.fits(),
        }
    }

    fn fits(&self) -> std::collections::BTreeMap<String, f64> {
        let fits = self.identified.fit_percent.iter().flatten().copied();
        self.recording.names[1..].iter().cloned().zip(fits).collect()
    }

    fn write(&self, folder: &Path) -> Result<(), Failure> {
        let csv = folder.join("recording.csv");
        let bytes = csv_text(&self.recording, None).into_bytes();
        write_bytes(&csv, &bytes, Overwrite::Allow)?;
        let note = Note::path_for(&csv);
        Note::new(&self.recording, &bytes, provenance(&[], &note)?).write(&note, Overwrite::SameKind)?;
        let path = folder.join("model.toml");
        let names = &self.recording.names;
        let mut model = Model::new(&self.identified.model, names[..1].to_vec(), names[1..].to_vec());
        model.continuous = self.identified.continuous.as_ref().ok().map(Matrices::from);
        model.physical = Some(with_errors(&self.noisy));
        model.validation = Some(Validation { fit_percent: self.fits(), samples: None });
        model.provenance = Some(provenance(&[&csv], &path)?);
        model.write(&path, Overwrite::SameKind)?;
        Ok(())
    }
}
