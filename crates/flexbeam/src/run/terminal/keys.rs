//! What a key asks for, and how it is done.

use flexbeam_runtime::{Phase, Refused, Steering};

use super::keyboard::{Arrow, Key, Shift};
use super::panel::{Panel, Way, Width};

/// What a person can ask for by key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// The emergency stop.
    Emergency,
    /// To 0 V and to the end.
    Stop,
    /// From armed to running.
    Start,
    /// The setting before or after the selected one.
    Select(Way),
    /// The selected setting, by a wide or a fine step.
    Change(Way, Width),
    /// The next law.
    NextLaw,
    /// The next shape of the reference.
    NextShape,
}

impl Act {
    /// Whether it takes the voltage away: done even when the key was pressed before the view was there.
    pub fn stops(self) -> bool {
        matches!(self, Act::Emergency | Act::Stop)
    }
}

/// What the key asks for.
pub fn act_of(key: Key) -> Option<Act> {
    Some(match key {
        Key::Char(' ') => Act::Emergency,
        Key::Char('q') | Key::Escape | Key::Interrupt => Act::Stop,
        Key::Char('s') | Key::Enter => Act::Start,
        Key::Char('k') | Key::Arrow(Arrow::Up, _) => Act::Select(Way::Back),
        Key::Char('j') | Key::Arrow(Arrow::Down, _) => Act::Select(Way::On),
        Key::Char('-') => Act::Change(Way::Back, Width::Wide),
        Key::Char('+' | '=') => Act::Change(Way::On, Width::Wide),
        Key::Char(',') => Act::Change(Way::Back, Width::Fine),
        Key::Char('.') => Act::Change(Way::On, Width::Fine),
        Key::Arrow(Arrow::Left, shift) => Act::Change(Way::Back, width(shift)),
        Key::Arrow(Arrow::Right, shift) => Act::Change(Way::On, width(shift)),
        Key::Char('l') => Act::NextLaw,
        Key::Char('r') => Act::NextShape,
        Key::Char(_) => return None,
    })
}

fn width(shift: Shift) -> Width {
    match shift {
        Shift::Held => Width::Fine,
        Shift::Free => Width::Wide,
    }
}

/// Does it.
///
/// Errors: what the kernel or the run refuses; everything stays as it was.
pub fn apply(act: Act, steering: &Steering, panel: &mut Panel) -> Result<(), Refused> {
    match act {
        Act::Emergency => steering.controls.emergency(),
        Act::Stop => steering.controls.stop(),
        Act::Start if steering.controls.phase() == Phase::Armed => steering.controls.start(),
        Act::Start => {}
        Act::Select(way) => panel.select(way),
        Act::Change(way, width) => panel.change(way, width, steering)?,
        Act::NextLaw => panel.next_law(steering)?,
        Act::NextShape => panel.next_shape(steering)?,
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_ask_for_what_the_book_says() {
        let wide = |way| Some(Act::Change(way, Width::Wide));
        let fine = |way| Some(Act::Change(way, Width::Fine));
        let table = [
            (Key::Char(' '), Some(Act::Emergency)),
            (Key::Char('q'), Some(Act::Stop)),
            (Key::Escape, Some(Act::Stop)),
            (Key::Interrupt, Some(Act::Stop)),
            (Key::Char('s'), Some(Act::Start)),
            (Key::Enter, Some(Act::Start)),
            (Key::Arrow(Arrow::Up, Shift::Free), Some(Act::Select(Way::Back))),
            (Key::Char('k'), Some(Act::Select(Way::Back))),
            (Key::Arrow(Arrow::Down, Shift::Held), Some(Act::Select(Way::On))),
            (Key::Char('j'), Some(Act::Select(Way::On))),
            (Key::Arrow(Arrow::Left, Shift::Free), wide(Way::Back)),
            (Key::Arrow(Arrow::Right, Shift::Free), wide(Way::On)),
            (Key::Char('-'), wide(Way::Back)),
            (Key::Char('+'), wide(Way::On)),
            (Key::Arrow(Arrow::Left, Shift::Held), fine(Way::Back)),
            (Key::Arrow(Arrow::Right, Shift::Held), fine(Way::On)),
            (Key::Char(','), fine(Way::Back)),
            (Key::Char('.'), fine(Way::On)),
            (Key::Char('l'), Some(Act::NextLaw)),
            (Key::Char('r'), Some(Act::NextShape)),
            (Key::Char('x'), None),
        ];
        for (key, act) in table {
            assert_eq!(act_of(key), act, "{key:?}");
        }
        let stopping = table.into_iter().filter_map(|(_, act)| act).filter(|act| act.stops()).count();
        assert_eq!(stopping, 4, "space, q, Esc, Ctrl-C");
    }
}
