//! Column names and the units in them: `theta_rad` is `theta` in `rad`.

/// Suffixes that name a unit, with the SI unit and how many of it one is; longer ones first.
const UNITS: &[(&str, &str, f64)] = &[
    ("rad_s2", "rad_s2", 1.0),
    ("deg_s2", "rad_s2", DEGREE),
    ("rad_s", "rad_s", 1.0),
    ("deg_s", "rad_s", DEGREE),
    ("mm_s", "m_s", 1e-3),
    ("m_s2", "m_s2", 1.0),
    ("m_s", "m_s", 1.0),
    ("rad", "rad", 1.0),
    ("mrad", "rad", 1e-3),
    ("deg", "rad", DEGREE),
    ("rpm", "rad_s", std::f64::consts::TAU / 60.0),
    ("ms", "s", 1e-3),
    ("us", "s", 1e-6),
    ("s", "s", 1.0),
    ("mv", "v", 1e-3),
    ("v", "v", 1.0),
    ("ma", "a", 1e-3),
    ("a", "a", 1.0),
    ("nm", "nm", 1.0),
    ("n", "n", 1.0),
    ("mm", "m", 1e-3),
    ("m", "m", 1.0),
    ("hz", "hz", 1.0),
    ("w", "w", 1.0),
];

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The suffix for a unit as people write it over a column, whatever its case: `rad_s` for `rad/s`, `deg` for `°`. Nothing for what is
/// no unit known here; the empty text for a dash, which says that there is none.
pub(crate) fn unit_written(text: &str) -> Option<&'static str> {
    let plain = text.trim().to_lowercase().replace(['/', '*', '·', ' '], "_").replace(['^'], "").replace('²', "2");
    let known = |wanted: &str| UNITS.iter().map(|(unit, ..)| *unit).find(|unit| *unit == wanted);
    known(&plain).or_else(|| match plain.as_str() {
        "-" => Some(""),
        "sec" | "second" | "seconds" => known("s"),
        "msec" | "millisecond" | "milliseconds" => known("ms"),
        "µs" | "μs" | "usec" | "microsecond" | "microseconds" => known("us"),
        "volt" | "volts" => known("v"),
        "°" | "degree" | "degrees" => known("deg"),
        "°_s" | "degree_s" => known("deg_s"),
        "radian" | "radians" => known("rad"),
        "n_m" => known("nm"),
        "ampere" | "amp" => known("a"),
        _ => None,
    })
}

/// A column's name, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnName<'a> {
    /// What is measured: `theta`.
    pub quantity: &'a str,
    /// The unit as written in lower case, empty when the name does not say: `deg`.
    pub unit: &'static str,
    /// The SI unit: `rad`.
    pub si_unit: &'static str,
    /// How many SI units one unit is: pi/180.
    pub si_factor: f64,
}

impl<'a> ColumnName<'a> {
    /// Takes a name apart: the unit is the longest known suffix after an underscore, whatever its case.
    pub fn of(name: &'a str) -> ColumnName<'a> {
        let known = UNITS.iter().find_map(|&(unit, si_unit, si_factor)| {
            let quantity = strip_unit(name, unit)?;
            Some(ColumnName { quantity, unit, si_unit, si_factor })
        });
        known.unwrap_or(ColumnName { quantity: name, unit: "", si_unit: "", si_factor: 1.0 })
    }

    /// Whether this is the time axis: `time_s`, `t_ms`, or plainly `time` (in seconds); `timestamp`, too.
    pub fn is_time(&self) -> bool {
        let named = ["time", "t", "timestamp"].iter().any(|name| self.quantity.eq_ignore_ascii_case(name));
        named && matches!(self.unit, "" | "s" | "ms" | "us")
    }
}

fn strip_unit<'a>(name: &'a str, unit: &str) -> Option<&'a str> {
    let cut = name.len().checked_sub(unit.len() + 1).filter(|&k| k > 0)?;
    let suffix = name.get(cut + 1..)?;
    (name.as_bytes()[cut] == b'_' && suffix.eq_ignore_ascii_case(unit)).then(|| &name[..cut])
}

/// The candidate most similar to `name`, if one is similar enough to be a slip of the pen.
///
/// Numerics: Levenshtein distance without regard to case, at most a third of the name's length (2 at least), or one
/// name contained in the other.
pub fn nearest<S: AsRef<str>>(name: &str, candidates: &[S]) -> Option<String> {
    let name = name.to_lowercase();
    let allowed = (name.chars().count() / 3).max(2);
    let distance = |candidate: &str| {
        let candidate = candidate.to_lowercase();
        let contained = name.len().min(candidate.len()) > 2 && (candidate.contains(&name) || name.contains(&candidate));
        if contained { 1 } else { edit_distance(&name, &candidate) }
    };
    let best = candidates.iter().map(|c| (distance(c.as_ref()), c.as_ref())).min_by_key(|&(d, _)| d)?;
    (best.0 <= allowed && best.0 < name.chars().count()).then(|| best.1.to_string())
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_the_longest_known_suffix() {
        for (name, quantity, unit) in [
            ("theta_rad", "theta", "rad"),
            ("theta_rad_s", "theta", "rad_s"),
            ("voltage_V", "voltage", "v"),
            ("torque_nm", "torque", "nm"),
            ("tip_mm", "tip", "mm"),
            ("speed_m_s", "speed", "m_s"),
            ("y_filtered", "y_filtered", ""),
            ("u", "u", ""),
            ("_s", "_s", ""),
            ("größe_m", "größe", "m"),
        ] {
            let column = ColumnName::of(name);
            assert_eq!((column.quantity, column.unit), (quantity, unit), "{name}");
        }
    }

    #[test]
    fn time_is_known_by_its_name_and_unit() {
        for (name, expected) in
            [("time_s", true), ("time", true), ("t", true), ("T_ms", true), ("t_deg", false), ("top_s", false)]
        {
            assert_eq!(ColumnName::of(name).is_time(), expected, "{name}");
        }
    }

    #[test]
    fn the_nearest_name_is_offered_only_when_it_is_near() {
        let names = ["voltage_v", "theta_rad", "alpha_rad"];
        assert_eq!(nearest("voltag_v", &names).as_deref(), Some("voltage_v"));
        assert_eq!(nearest("Theta_Rad", &names).as_deref(), Some("theta_rad"));
        assert_eq!(nearest("theta", &names).as_deref(), Some("theta_rad"));
        assert_eq!(nearest("current_a", &names), None);
        assert_eq!(nearest("x", &["y", "u"]), None);
    }
}
