//! Parts of the library that the command line calls and that are made elsewhere. This file goes away when they are
//! there: each module is then `crate::` with the path in its comment.

use crate::{Error, Result};

fn absent<T>(what: &str) -> Result<T> {
    Err(Error::Check(format!("{what} is not part of this build")))
}

/// `crate::bench`
pub(super) mod bench {
    use crate::Result;
    use std::path::PathBuf;
    pub struct Options {
        pub scenes: Vec<PathBuf>,
        pub sizes: Vec<[u32; 2]>,
        pub runs: u32,
        pub memory: Option<u64>,
        pub json: Option<PathBuf>,
    }
    pub fn run(o: &Options) -> Result<()> {
        let cells = (o.scenes.len() * o.sizes.len()) as u64 * u64::from(o.runs) + o.memory.unwrap_or(0);
        super::absent(&format!("the bench ({cells}, {:?})", o.json))
    }
}

/// `crate::figure`
pub(super) mod figure {
    use crate::Result;
    use std::path::PathBuf;
    pub struct Options {
        /// `None`: list them.
        pub name: Option<String>,
        pub out: Option<PathBuf>,
        pub quick: bool,
    }
    pub fn run(o: &Options) -> Result<()> {
        super::absent(&format!("the figure {:?} ({:?}, quick: {})", o.name, o.out, o.quick))
    }
}
