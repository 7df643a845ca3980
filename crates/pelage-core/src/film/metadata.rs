//! Metadata of an image: how it was made.

use crate::stats::Stats;
use sha2::{Digest, Sha256};

/// Entries that are written into EXR attributes and PNG text chunks, each under `pelage.KEY`.
///
/// Keys are short ASCII words; values are UTF-8 text of any length. Times differ between runs: for
/// reproducible files, leave [`Metadata::with_stats`] out.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Metadata {
    /// Key and value, in order.
    pub entries: Vec<(String, String)>,
    /// Name and value of further attributes, which other programs define; only in EXR files.
    pub attributes: Vec<(String, String)>,
}

impl Metadata {
    /// `version` of the program and the `commit` it was built from (the environment variable
    /// PELAGE_COMMIT at build time, or `unknown`).
    pub fn of_program() -> Self {
        Self::default()
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("commit", option_env!("PELAGE_COMMIT").unwrap_or("unknown"))
    }

    /// Sets an entry; an earlier one with the same key is replaced.
    pub fn with(mut self, key: &str, value: impl Into<String>) -> Self {
        self.entries.retain(|(k, _)| k != key);
        self.entries.push((key.to_owned(), value.into()));
        self
    }

    /// Sets an attribute of EXR files, under its own name.
    pub fn with_attribute(mut self, name: &str, value: impl Into<String>) -> Self {
        self.attributes.retain(|(n, _)| n != name);
        self.attributes.push((name.to_owned(), value.into()));
        self
    }

    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    /// `scene`: the scene as text, and `scene_sha256`: its hash in hexadecimal.
    pub fn with_scene(self, text: &str) -> Self {
        let hash =
            Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        self.with("scene", text).with("scene_sha256", hash)
    }

    /// `seed` of all random numbers.
    pub fn with_seed(self, seed: u32) -> Self {
        self.with("seed", seed.to_string())
    }

    /// `adapter` and `driver` of the GPU.
    pub fn with_adapter(self, adapter: &str, driver: &str) -> Self {
        self.with("adapter", adapter).with("driver", driver)
    }

    /// `command_line`: the program without its folder, then the arguments, those with blanks in
    /// double quotes.
    pub fn with_command_line<S: AsRef<str>>(self, arguments: impl IntoIterator<Item = S>) -> Self {
        let quoted = |(i, argument): (usize, S)| {
            let mut argument = argument.as_ref();
            if i == 0 {
                // An image that is shared should not reveal where the program is installed.
                argument = argument.rsplit(['/', '\\']).next().unwrap_or_default();
            }
            if argument.is_empty() || argument.contains(char::is_whitespace) {
                format!("{argument:?}")
            } else {
                argument.to_owned()
            }
        };
        let words: Vec<String> = arguments.into_iter().enumerate().map(quoted).collect();
        self.with("command_line", words.join(" "))
    }

    /// Adapter and driver of a rendering, `total_ms`, and `pass_ms`: one line `PASS MS` for each
    /// pass, `n/a` where the adapter has no timestamps.
    pub fn with_stats(self, stats: &Stats) -> Self {
        let passes = stats
            .passes
            .iter()
            .map(|p| match p.ms {
                Some(ms) => format!("{} {ms:.3}", p.pass),
                None => format!("{} n/a", p.pass),
            })
            .collect::<Vec<_>>();
        self.with_adapter(&stats.adapter, &stats.driver)
            .with("total_ms", format!("{:.3}", stats.total_ms))
            .with("pass_ms", passes.join("\n"))
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }
}
