//! Where the program keeps built models.

use std::ffi::OsString;
use std::path::PathBuf;

use super::arguments::Models;
use crate::run::{CacheLimit, CrownStore, ModelCache};

/// A store of crowns with the cache that the flags ask for; without one where there is no folder.
///
/// `golden` and `explain` have none: what judges what this program builds has to build it.
pub(super) fn store(models: &Models) -> CrownStore {
    let folder = match (&models.cache, models.no_cache) {
        (_, true) => None,
        (Some(folder), false) => Some(folder.clone()),
        (None, false) => users_folder(std::env::var_os("XDG_CACHE_HOME"), std::env::var_os("HOME")),
    };
    match folder {
        Some(folder) if !cfg!(target_family = "wasm") => {
            CrownStore::with_cache(ModelCache::new(folder, CacheLimit::USUAL))
        }
        Some(_) | None => CrownStore::new(),
    }
}

/// The folder in the user's cache; a path that starts nowhere counts as none, as the XDG base
/// directory specification has it.
fn users_folder(cache: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let whole = |path: Option<OsString>| path.map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = whole(cache).or_else(|| whole(home).map(|home| home.join(".cache")));
    cache.map(|cache| cache.join("spinney"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_users_folder_is_that_of_the_environment_or_none() {
        let folder = |cache: Option<&str>, home: Option<&str>| {
            users_folder(cache.map(OsString::from), home.map(OsString::from))
        };
        let (cache, home) = (Some("/cache"), Some("/home/me"));
        assert_eq!(folder(cache, home), Some(PathBuf::from("/cache/spinney")));
        let of_home = Some(PathBuf::from("/home/me/.cache/spinney"));
        for nowhere in [None, Some(""), Some("cache")] {
            assert_eq!(folder(nowhere, home), of_home);
            assert_eq!(folder(nowhere, nowhere), None);
        }
    }
}
