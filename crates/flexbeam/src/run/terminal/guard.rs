//! The terminal in raw mode with its alternate screen, given back in every case.

use std::io;
use std::os::fd::AsFd;
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use nix::sys::termios::{FlushArg, tcflush};
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode};

/// Holds the terminal until it is dropped.
#[derive(Debug)]
pub struct Guard {
    held: Arc<AtomicBool>,
    panics: Arc<Mutex<Vec<String>>>,
}

impl Guard {
    /// Takes the terminal.
    ///
    /// A panic of this thread gives it back before it is told. One of another thread is told when the terminal is given back:
    /// it may be the loop's, which must not wait for a terminal on its way to 0 V.
    /// Errors: what the system says.
    pub fn take() -> io::Result<Guard> {
        let guard = Guard { held: Arc::new(AtomicBool::new(true)), panics: Arc::default() };
        guard.listen_to_panics();
        enable_raw_mode()?;
        execute!(io::stderr(), EnterAlternateScreen)?;
        Ok(guard)
    }

    /// The hook stays for the rest of the program; without the terminal it passes everything on.
    fn listen_to_panics(&self) {
        let (held, panics, owner) = (self.held.clone(), self.panics.clone(), std::thread::current().id());
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !held.load(Ordering::Acquire) {
                before(info);
            } else if std::thread::current().id() == owner {
                give_back(&held);
                before(info);
            } else {
                panics.lock().unwrap_or_else(PoisonError::into_inner).push(info.to_string());
            }
        }));
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        give_back(&self.held);
        for panic in self.panics.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            super::say(&panic);
        }
    }
}

/// Once. A terminal that is gone needs nothing any more, so errors are passed over.
fn give_back(held: &AtomicBool) {
    if held.swap(false, Ordering::AcqRel) {
        let _ = execute!(io::stderr(), LeaveAlternateScreen, Show);
        // Keys that were hit in a hurry are not meant for the shell.
        let _ = tcflush(io::stdin().as_fd(), FlushArg::TCIFLUSH);
        let _ = disable_raw_mode();
    }
}
