//! Finds, opens and checks the library.

use std::ffi::c_int;

use libloading::Library;

use crate::PetscError;
use crate::ffi::{self, Api};

/// Environment variable that names the file of the library.
pub const PATH_VARIABLE: &str = "PERIFRAC_PETSC";
/// Minor versions of PETSc 3 whose interface is known to be the one declared.
const MINORS: std::ops::RangeInclusive<c_int> = 18..=23;

/// The library, open and checked.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) library: Library,
    pub(crate) api: Api,
    pub(crate) path: String,
    pub(crate) version: String,
}

/// Opens the library named by [`PATH_VARIABLE`], or else the first found under the usual names.
pub(crate) fn load() -> Result<Loaded, PetscError> {
    let names = names();
    let opened = names
        .iter()
        .find_map(|name| open(name).map(|library| (library, name)));
    let Some((library, name)) = opened else {
        let tried = names.join(", ");
        return Err(PetscError::NotFound { tried });
    };
    let api = Api::load(&library)?;
    let path = mapped_path(name).unwrap_or_else(|| name.clone());
    let version = check_version(&api, &path)?;
    check_numbers(&api, &path)?;
    Ok(Loaded {
        library,
        api,
        path,
        version,
    })
}

/// Names to try, in order.
fn names() -> Vec<String> {
    if let Ok(path) = std::env::var(PATH_VARIABLE) {
        return vec![path];
    }
    let mut names = Vec::new();
    for stem in ["libpetsc_real.so", "libpetsc.so"] {
        names.extend(MINORS.rev().map(|minor| format!("{stem}.3.{minor}")));
        names.push(stem.into());
    }
    names
}

#[cfg(unix)]
fn open(name: &str) -> Option<Library> {
    use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_NOW};
    // The plugins of Open MPI look for the symbols of MPI among the global ones.
    // SAFETY: the initialisers of PETSc and MPI libraries do nothing but set up their own data.
    let library = unsafe { Library::open(Some(name), RTLD_NOW | RTLD_GLOBAL) };
    library.ok().map(Into::into)
}

#[cfg(not(unix))]
fn open(_name: &str) -> Option<Library> {
    None
}

/// Full path under which the system has mapped the library, where it can be told.
fn mapped_path(name: &str) -> Option<String> {
    let stem = name.rsplit('/').next()?.split(".so").next()?;
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    let paths = maps
        .lines()
        .filter_map(|line| line.find('/').map(|at| &line[at..]));
    let mut named =
        paths.filter(|path| path.rsplit('/').next().is_some_and(|f| f.starts_with(stem)));
    named.next().map(Into::into)
}

fn check_version(api: &Api, path: &str) -> Result<String, PetscError> {
    // Each place is wide enough for the integers of any build.
    let mut places = [0_i64; 4];
    let [major, minor, subminor, release] = &mut places;
    let place = |place: &mut i64| std::ptr::from_mut(place).cast::<c_int>();
    // SAFETY: four valid places; the function stores constants and needs no initialisation.
    let code = unsafe {
        (api.PetscGetVersionNumber)(place(major), place(minor), place(subminor), place(release))
    };
    let parts = places.map(|place| place as c_int);
    let version = format!("{}.{}.{}", parts[0], parts[1], parts[2]);
    if code != 0 || parts[0] != 3 || !MINORS.contains(&parts[1]) {
        return Err(PetscError::Version {
            path: path.into(),
            found: version,
        });
    }
    Ok(version)
}

/// Integers must have 32 bits and scalars must be real doubles.
fn check_numbers(api: &Api, path: &str) -> Result<(), PetscError> {
    let (mut bytes, mut kind, mut known) = (0, 0, ffi::PETSC_FALSE);
    // SAFETY: valid places and a C string; both functions only read tables.
    let codes = unsafe {
        [
            (api.PetscDataTypeGetSize)(ffi::PETSC_INT, &mut bytes),
            (api.PetscDataTypeFromString)(c"scalar".as_ptr(), &mut kind, &mut known),
        ]
    };
    let wrong = |found: String| {
        Err(PetscError::Build {
            path: path.into(),
            found,
        })
    };
    if codes != [0, 0] || bytes != size_of::<ffi::PetscInt>() {
        return wrong(format!("integers of {} bits", 8 * bytes));
    }
    if known == ffi::PETSC_FALSE || kind != ffi::PETSC_DOUBLE {
        return wrong("complex or single-precision numbers".into());
    }
    Ok(())
}
