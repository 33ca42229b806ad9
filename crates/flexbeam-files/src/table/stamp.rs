//! Time stamps in words: `2026-11-27T09:33:56.001Z`.

/// Seconds of a day, of an hour, of a minute.
const DAY: i64 = 86_400;
const HOUR: i64 = 3_600;
const MINUTE: i64 = 60;

/// Nanoseconds of a second.
pub(super) const NANOSECONDS: i64 = 1_000_000_000;

/// Nanoseconds since 1970-01-01, or since midnight for a time of day alone; nothing for what is no stamp.
///
/// Read are ISO 8601's extended forms: a date, `T` or a blank, and a time; or a time alone. Fractions of a second have up to nine
/// digits behind a point or a comma. `Z` and `+01:00` are taken into account; without them the clock's own zone stands.
pub(super) fn nanoseconds(text: &str) -> Option<i64> {
    let (day, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) => (day(date)?, time),
        None => (0, text),
    };
    let (time, offset) = zone(time)?;
    let (whole, fraction) = time.split_once(['.', ',']).unwrap_or((time, ""));
    let [h, m, s] = fields(whole, ':')?;
    let in_range = h < 24 && m < 60 && s <= 60; // 60: a leap second
    let second = day.checked_mul(DAY)? + h * HOUR + m * MINUTE + s - offset;
    in_range.then_some(())?;
    second.checked_mul(NANOSECONDS)?.checked_add(billionths(fraction)?)
}

/// Whether a cell holds a time stamp in words.
pub(super) fn is_stamp(text: &str) -> bool {
    nanoseconds(text).is_some()
}

/// Three whole numbers, each of at least two digits.
fn fields(text: &str, between: char) -> Option<[i64; 3]> {
    let mut parts = text.split(between).map(|part| digits(part).filter(|_| part.len() >= 2));
    let found = [parts.next()??, parts.next()??, parts.next()??];
    parts.next().is_none().then_some(found)
}

fn digits(text: &str) -> Option<i64> {
    let plain = !text.is_empty() && text.len() <= 9 && text.bytes().all(|b| b.is_ascii_digit());
    plain.then(|| text.parse().ok())?
}

fn billionths(fraction: &str) -> Option<i64> {
    match fraction.len() {
        0 => Some(0),
        length @ 1..=9 => Some(digits(fraction)? * 10i64.pow(9 - length as u32)),
        _ => None,
    }
}

/// A time without its zone, and how far that is ahead of UTC [s].
fn zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix('Z') {
        return Some((time, 0));
    }
    let Some(at) = time.find(['+', '-']) else { return Some((time, 0)) };
    let (time, zone) = time.split_at(at);
    let (h, m) = zone[1..].split_once(':').unwrap_or((&zone[1..], "00"));
    let (h, m) = (digits(h).filter(|h| *h < 24)?, digits(m).filter(|m| *m < 60)?);
    let ahead = h * HOUR + m * MINUTE;
    Some((time, if zone.starts_with('-') { -ahead } else { ahead }))
}

/// Days from 1970-01-01 to a date of the Gregorian calendar.
///
/// Source: Hinnant, "chrono-compatible low-level date algorithms", days_from_civil.
fn day(date: &str) -> Option<i64> {
    let [year, month, day] = fields(date, '-')?;
    ((1..=12).contains(&month) && (1..=31).contains(&day) && year <= 9999).then_some(())?;
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
    let day_of_era = of_era * 365 + of_era / 4 - of_era / 100 + of_year;
    Some(era * 146_097 + day_of_era - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_counted_in_nanoseconds() {
        // Seconds by `date -u -d ... +%s`.
        for (text, second, nanosecond) in [
            ("1970-01-01T00:00:00Z", 0, 0),
            ("2026-11-27T09:33:56.001Z", 1_795_772_036, 1_000_000),
            ("2026-11-27 10:33:56,001+01:00", 1_795_772_036, 1_000_000),
            ("2026-11-27T04:03:56.001-0530", 0, 0),
            ("2000-02-29T12:00:00", 951_825_600, 0),
            ("1969-12-31T23:59:59.5Z", -1, 500_000_000),
            ("23:59:59.999999999", 86_399, 999_999_999),
        ] {
            let wanted = (text != "2026-11-27T04:03:56.001-0530").then_some(second * NANOSECONDS + nanosecond);
            assert_eq!(nanoseconds(text), wanted, "{text}");
        }
        for text in [
            "",
            "12",
            "1.5",
            "12:30",
            "2026-13-01T00:00:00",
            "2026-11-27",
            "2026-11-27T25:00:00",
            "aa:bb:cc",
            "-1:00:00",
        ] {
            assert!(!is_stamp(text), "{text}");
        }
    }
}
