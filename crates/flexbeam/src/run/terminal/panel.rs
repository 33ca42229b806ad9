//! The settings that a person changes by key: which one is selected, what a step is, what it says.
//!
//! What may be set is the kernel's affair: a step beyond it is refused there.

use flexbeam_kernel::Law;
use flexbeam_runtime::{Live, Refused, Shape, Steering};

/// Steps end on millionths of the unit that is shown: 30 degrees stay 30 after their way through radians.
const GRAINS: f64 = 1e6;

/// Backwards or onwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Back,
    On,
}

/// Size of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    Wide,
    Fine,
}

/// A setting of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    Shape,
    Amplitude,
    Offset,
    Period,
    Smooth,
    Law,
    UpPlus,
    UpMinus,
    EpsU,
    EpsE,
}

/// How a number is shown and changed.
struct Scale {
    /// What is shown, for each unit of what is set.
    per_unit: f64,
    wide: f64,
    fine: f64,
    decimals: usize,
    unit: &'static str,
}

impl Setting {
    /// All of them, the reference's first.
    pub const ALL: [Setting; 10] = [
        Setting::Shape,
        Setting::Amplitude,
        Setting::Offset,
        Setting::Period,
        Setting::Smooth,
        Setting::Law,
        Setting::UpPlus,
        Setting::UpMinus,
        Setting::EpsU,
        Setting::EpsE,
    ];

    /// As the panel names it.
    pub fn name(self) -> &'static str {
        match self {
            Setting::Shape => "shape",
            Setting::Amplitude => "amplitude",
            Setting::Offset => "offset",
            Setting::Period => "period",
            Setting::Smooth => "smooth",
            Setting::Law => "law",
            Setting::UpPlus => "u_p+",
            Setting::UpMinus => "u_p-",
            Setting::EpsU => "eps_u",
            Setting::EpsE => "eps_e",
        }
    }

    /// Its value, for a person.
    pub fn text(self, live: &Live, period_s: f64) -> String {
        match self.number(&mut live.clone(), period_s) {
            Some((number, Scale { per_unit, decimals, unit, .. })) => {
                format!("{:.decimals$}{unit}", *number * per_unit)
            }
            None if self == Setting::Law => law_word(live.settings.law).into(),
            None => shape_word(live.reference.shape).into(),
        }
    }

    /// Where its number stands, and how it is shown; nothing for a word.
    fn number(self, live: &mut Live, period_s: f64) -> Option<(&mut f64, Scale)> {
        let degrees = |wide, fine| Scale { per_unit: 1f64.to_degrees(), wide, fine, decimals: 2, unit: "°" };
        let seconds = |per_unit, wide, fine| Scale { per_unit, wide, fine, decimals: 2, unit: " s" };
        let volts = |wide, fine| Scale { per_unit: 1.0, wide, fine, decimals: 4, unit: " V" };
        // A file has its own angles; the amplitude scales them.
        let factor = Scale { per_unit: 1.0, wide: 0.1, fine: 0.01, decimals: 2, unit: " ×" };
        let is_file = live.reference.shape == Shape::File;
        let (settings, reference) = (&mut live.settings, &mut live.reference);
        Some(match self {
            Setting::Shape | Setting::Law => return None,
            Setting::Amplitude if is_file => (&mut reference.amplitude_rad, factor),
            Setting::Amplitude => (&mut reference.amplitude_rad, degrees(5.0, 0.5)),
            Setting::Offset => (&mut reference.offset_rad, degrees(5.0, 0.5)),
            Setting::Period => (&mut reference.period_s, seconds(1.0, 0.5, 0.1)),
            Setting::Smooth => (&mut settings.smooth_ticks, seconds(period_s, 0.05, 0.01)),
            Setting::UpPlus => (&mut settings.u_p_plus_v, volts(0.01, 0.001)),
            Setting::UpMinus => (&mut settings.u_p_minus_v, volts(0.01, 0.001)),
            Setting::EpsU => (&mut settings.eps_u_v, volts(0.005, 0.0005)),
            Setting::EpsE => (&mut settings.eps_e_rad, degrees(0.05, 0.01)),
        })
    }

    /// A step of its number.
    fn step(self, way: Way, width: Width, live: &mut Live, period_s: f64) {
        if let Some((number, scale)) = self.number(live, period_s) {
            let size = if width == Width::Wide { scale.wide } else { scale.fine };
            let step = if way == Way::On { size } else { -size };
            *number = ((*number * scale.per_unit + step) * GRAINS).round() / GRAINS / scale.per_unit;
        }
    }
}

/// Which setting is selected.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    selected: usize,
    /// The amplitude of the other kind of reference: a file's is a factor, any other's an angle [rad].
    spare_amplitude: f64,
}

impl Panel {
    /// The amplitude selected. A run that begins with a file goes on, when its shape changes, with the file's largest angle.
    pub fn new(live: &Live) -> Panel {
        let reference = &live.reference;
        let other = if reference.shape == Shape::File { Shape::Step } else { Shape::File };
        Panel { selected: 1, spare_amplitude: reference.amplitude_as(other) }
    }

    /// The setting that Left and Right change.
    pub fn selected(&self) -> Setting {
        Setting::ALL[self.selected]
    }

    /// Selects the next one, or the one before; at the ends it goes round.
    pub fn select(&mut self, way: Way) {
        self.selected = neighbour(Setting::ALL.len(), self.selected, way);
    }

    /// Changes the selected setting.
    ///
    /// Errors: what the kernel refuses.
    pub fn change(&mut self, way: Way, width: Width, steering: &Steering) -> Result<(), Refused> {
        match self.selected() {
            Setting::Shape => self.other_shape(way, steering),
            Setting::Law => other_law(way, steering),
            number => changed(steering, |live| number.step(way, width, live, steering.period_s)),
        }
    }

    /// Errors: what the kernel refuses.
    pub fn next_law(&mut self, steering: &Steering) -> Result<(), Refused> {
        other_law(Way::On, steering)
    }

    /// Errors: what the run refuses.
    pub fn next_shape(&mut self, steering: &Steering) -> Result<(), Refused> {
        self.other_shape(Way::On, steering)
    }

    fn other_shape(&mut self, way: Way, steering: &Steering) -> Result<(), Refused> {
        let reference = steering.live.current().reference;
        let shapes = if reference.samples.is_empty() { &SHAPES[..SHAPES.len() - 1] } else { &SHAPES[..] };
        let next = other(shapes, reference.shape, way);
        let crosses = (next == Shape::File) != (reference.shape == Shape::File);
        let amplitude = if crosses { self.spare_amplitude } else { reference.amplitude_rad };
        changed(steering, |live| (live.reference.shape, live.reference.amplitude_rad) = (next, amplitude))?;
        if crosses {
            self.spare_amplitude = reference.amplitude_rad;
        }
        Ok(())
    }
}

/// In the order in which a key takes them; the file last, because most runs have none.
const SHAPES: [Shape; 5] = [Shape::Step, Shape::Square, Shape::Sine, Shape::Sawtooth, Shape::File];
const LAWS: [Law; 3] = [Law::None, Law::Switched, Law::Inverse];

fn other_law(way: Way, steering: &Steering) -> Result<(), Refused> {
    changed(steering, |live| live.settings.law = other(&LAWS, live.settings.law, way))
}

fn changed(steering: &Steering, change: impl FnOnce(&mut Live)) -> Result<(), Refused> {
    steering.live.change(change).map(drop)
}

fn other<T: Copy + PartialEq>(all: &[T], present: T, way: Way) -> T {
    let at = all.iter().position(|one| *one == present).unwrap_or(0);
    all[neighbour(all.len(), at, way)]
}

fn neighbour(count: usize, at: usize, way: Way) -> usize {
    match way {
        Way::On => (at + 1) % count,
        Way::Back => (at + count - 1) % count,
    }
}

fn shape_word(shape: Shape) -> &'static str {
    match shape {
        Shape::Step => "step",
        Shape::Square => "square",
        Shape::Sine => "sine",
        Shape::Sawtooth => "sawtooth",
        Shape::File => "file",
    }
}

fn law_word(law: Law) -> &'static str {
    match law {
        Law::None => "none",
        Law::Switched => "switched",
        Law::Inverse => "inverse",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flexbeam_kernel as kernel;
    use flexbeam_runtime::{Controls, Latest, Reference, live};

    fn steering(reference: Reference) -> Steering {
        let first = Live { revision: 0, settings: kernel::Settings::default(), reference };
        let (live, _) = live(first).unwrap();
        Steering { controls: Controls::default(), live, latest: Latest::default(), period_s: 0.001 }
    }

    fn step(degrees: f64) -> Reference {
        Reference { amplitude_rad: degrees.to_radians(), ..Reference::default() }
    }

    fn text(setting: Setting, steering: &Steering) -> String {
        setting.text(&steering.live.current(), steering.period_s)
    }

    #[test]
    fn steps_are_round_numbers_in_the_unit_that_is_shown() {
        let steering = steering(step(30.0));
        let mut panel = Panel::new(&steering.live.current());
        assert_eq!((panel.selected(), text(Setting::Amplitude, &steering)), (Setting::Amplitude, "30.00°".into()));
        (0..3).for_each(|_| panel.change(Way::On, Width::Wide, &steering).unwrap());
        assert!((steering.live.current().reference.amplitude_rad - 45f64.to_radians()).abs() < 1e-15);
        panel.change(Way::Back, Width::Fine, &steering).unwrap();
        assert_eq!(text(Setting::Amplitude, &steering), "44.50°");
    }

    #[test]
    fn each_number_moves_and_says_so() {
        for setting in Setting::ALL {
            let steering = steering(step(30.0));
            let mut panel = Panel::new(&steering.live.current());
            while panel.selected() != setting {
                panel.select(Way::On);
            }
            let before = text(setting, &steering);
            panel.change(Way::On, Width::Fine, &steering).unwrap();
            assert_ne!(text(setting, &steering), before, "{setting:?}");
            panel.change(Way::Back, Width::Fine, &steering).unwrap();
            assert_eq!(text(setting, &steering), before);
            assert_eq!(steering.live.current().revision, 2, "one change each");
        }
    }

    #[test]
    fn what_the_kernel_refuses_stays() {
        let steering = steering(step(30.0));
        let mut panel = Panel::new(&steering.live.current());
        while panel.selected() != Setting::UpPlus {
            panel.select(Way::Back);
        }
        let refused = panel.change(Way::Back, Width::Wide, &steering).unwrap_err();
        assert!(refused.to_string().contains("u_p_plus_v"), "{refused}");
        assert_eq!(steering.live.current().revision, 0);
    }

    #[test]
    fn shapes_go_round_without_a_file_that_is_not_there() {
        let steering = steering(step(30.0));
        let mut panel = Panel::new(&steering.live.current());
        let seen: Vec<String> = (0..4)
            .map(|_| {
                panel.next_shape(&steering).unwrap();
                text(Setting::Shape, &steering)
            })
            .collect();
        assert_eq!(seen, ["square", "sine", "sawtooth", "step"]);
    }

    /// The amplitude of a file is a factor; taken for an angle, a factor of 1 would be a step of 57 degrees.
    #[test]
    fn a_file_and_an_angle_keep_their_own_amplitudes() {
        let samples = [0.0, 0.2, -0.3].into();
        let steering = steering(Reference { shape: Shape::File, amplitude_rad: 1.0, samples, ..Reference::default() });
        let mut panel = Panel::new(&steering.live.current());
        assert_eq!(text(Setting::Amplitude, &steering), "1.00 ×");
        panel.next_shape(&steering).unwrap();
        let reference = steering.live.current().reference;
        assert_eq!((reference.shape, reference.amplitude_rad), (Shape::Step, 0.3));
        panel.change(Way::On, Width::Wide, &steering).unwrap();
        let angle = steering.live.current().reference.amplitude_rad;
        (0..4).for_each(|_| panel.next_shape(&steering).unwrap());
        assert_eq!(
            (text(Setting::Shape, &steering), text(Setting::Amplitude, &steering)),
            ("file".into(), "1.00 ×".into())
        );
        panel.next_shape(&steering).unwrap();
        assert_eq!(steering.live.current().reference.amplitude_rad, angle);
    }
}
