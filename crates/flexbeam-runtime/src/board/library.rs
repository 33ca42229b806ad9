//! A board's library, opened at run time, so that flexbeam needs none of them to be installed.

use crate::back_end::OpenError;
use libloading::os::unix::{Library as Loaded, RTLD_GLOBAL, RTLD_LOCAL, RTLD_NOW};
use std::ffi::CString;
use std::mem::ManuallyDrop;

/// A shared library that stays loaded until the program ends: a vendor's library may have threads and exit handlers of its
/// own, which do not survive being unmapped.
pub(crate) struct Library {
    loaded: ManuallyDrop<Loaded>,
    name: String,
}

/// What to say when no library is found.
pub(crate) struct Missing {
    /// Whose library it is: `Quanser's HIL library`.
    pub library: &'static str,
    /// How a user gets it.
    pub hint: &'static str,
}

impl Library {
    /// The first of `names` that opens. All symbols are bound now, so that none is looked up in the loop.
    ///
    /// Errors: what the loader said to each name.
    pub(crate) fn open(names: &[&str], missing: &Missing) -> Result<Library, OpenError> {
        let mut said = Vec::new();
        for name in names {
            match load(name, RTLD_LOCAL) {
                Ok(library) => return Ok(library),
                Err(error) => said.push(format!("{name} ({error})")),
            }
        }
        Err(OpenError {
            found: format!("none of {}", said.join(", ")),
            needed: missing.library.into(),
            hint: missing.hint.into(),
        })
    }

    /// The first of `names` that opens, its symbols offered to the libraries that are opened later; nothing when there is none.
    pub(crate) fn companion(names: &[&str]) -> Option<Library> {
        names.iter().find_map(|name| load(name, RTLD_GLOBAL).ok())
    }

    /// Address of a function.
    ///
    /// Errors: the library has none of this name: it is another one, or too old.
    ///
    /// # Safety
    /// `F` is the type of that function, as its vendor documents it.
    pub(crate) unsafe fn function<F: Copy>(&self, name: &str, hint: &str) -> Result<F, OpenError> {
        // SAFETY: the caller vouches for the type; the library is never unloaded, so that the copied address stays valid.
        let symbol = unsafe { self.loaded.get::<F>(name) };
        symbol.map(|symbol| *symbol).map_err(|_| OpenError {
            found: format!("{} without a function {name}", self.name),
            needed: format!("a library that has {name}"),
            hint: hint.into(),
        })
    }
}

/// A word as C takes it.
///
/// Errors: a NUL byte within.
pub(crate) fn c_text(word: &str) -> Result<CString, OpenError> {
    CString::new(word).map_err(|_| OpenError {
        found: format!("a NUL byte in {word:?}"),
        needed: "a name without one".into(),
        hint: "check the port's text".into(),
    })
}

fn load(name: &str, visibility: std::ffi::c_int) -> Result<Library, String> {
    // SAFETY: the start-up code of a vendor's library runs; naming it is the user's consent to that.
    let loaded = unsafe { Loaded::open(Some(name), RTLD_NOW | visibility) };
    loaded
        .map(|loaded| Library { loaded: ManuallyDrop::new(loaded), name: name.into() })
        .map_err(|error| detail(&error).replace(&format!("{name}: "), ""))
}

/// What the loader itself said, without the crate's words around it.
fn detail(error: &libloading::Error) -> String {
    match error {
        libloading::Error::DlOpen { source } => source.to_string(),
        other => other.to_string(),
    }
}
