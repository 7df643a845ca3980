//! Parts of the library that the command line calls and that are made elsewhere. This file goes away when they are
//! there: each module is then `crate::` with the path in its comment.

use crate::{Error, Result};

fn absent<T>(what: &str) -> Result<T> {
    Err(Error::Check(format!("{what} is not part of this build")))
}

/// `crate::gpu`
pub(super) mod gpu {
    #[derive(serde::Serialize)]
    pub struct AdapterSummary {
        pub name: String,
        pub backend: String,
        pub driver: String,
        pub device_type: String,
        pub binding_bytes: u64,
        pub timestamps: bool,
        pub lacks: Option<String>,
    }
    pub fn list_adapters() -> Vec<AdapterSummary> {
        Vec::new()
    }
}

/// `crate::render::strands`
pub(super) mod render {
    use crate::{Result, World, hair::HairFile};
    pub fn strands(_world: &World) -> Result<HairFile> {
        super::absent("making strands")
    }
}
