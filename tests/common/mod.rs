//! Helpers of several tests: the command and its output, temporary folders, assets.

pub mod beams;
pub mod films;
pub mod gpu;
pub mod hairs;
pub mod lit;
pub mod marched;
pub mod mesh_files;
pub mod shapes;
pub mod shellfins;
pub mod sources;
pub mod worlds;

use proptest::test_runner::Config;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Outcome of a command.
#[derive(Debug)]
pub struct Run {
    /// Exit code; -1 if a signal ended it.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Run {
    /// Asserts the exit code and that stderr holds every one of `parts`.
    pub fn expect(self, code: i32, parts: &[&str]) -> Self {
        assert_eq!(self.code, code, "exit code\nstdout: {}\nstderr: {}", self.out, self.err);
        for part in parts {
            assert!(self.err.contains(part), "no {part:?} in stderr:\n{}", self.err);
        }
        self
    }
}

/// The command in the repository's root, without the variables that change its behaviour, and with
/// a cache folder of the tests in place of the user's.
pub fn command() -> Command {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache");
    std::fs::create_dir_all(&cache).expect("a cache folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_pelage"));
    command.current_dir(root()).env_remove("PELAGE_ASSETS").env_remove("RUST_LOG");
    command.env("XDG_CACHE_HOME", cache);
    command
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Run {
    command.output().expect("the command starts").into()
}

/// Runs `pelage` to its end.
pub fn pelage<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> Run {
    run(command().args(args))
}

/// Runs `pelage` in an environment without an adapter.
pub fn pelage_without_adapter<S: AsRef<std::ffi::OsStr>>(args: &[S]) -> Run {
    let backend = if cfg!(target_vendor = "apple") { "vulkan" } else { "metal" };
    run(command().env("WGPU_BACKEND", backend).env("VK_DRIVER_FILES", "/nonexistent").args(args))
}

/// Runs `body`, the whole of the test that this program calls `name`, in a process of its own: what
/// the process measures of itself is then not mixed with the tests that run beside it.
pub fn alone(name: &str, body: impl FnOnce()) {
    const ALONE: &str = "PELAGE_TEST_ALONE";
    if std::env::var_os(ALONE).is_some() {
        return body();
    }
    let mut command = Command::new(std::env::current_exe().expect("this program"));
    command.args([name, "--exact", "--nocapture"]).env(ALONE, "1");
    let run = run(&mut command).expect(0, &[]);
    assert!(run.out.contains("1 passed"), "no test {name}: {}", run.out);
    print!("{}", run.out);
}

/// The repository.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The folder of downloaded assets; `None`, with a note, if PELAGE_ASSETS is not set.
pub fn assets() -> Option<PathBuf> {
    let folder = std::env::var_os("PELAGE_ASSETS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("note: skipped, PELAGE_ASSETS is not set");
    }
    folder
}

/// A temporary folder, removed at the end of the test.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// An empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A path in it, as text.
    pub fn at(&self, name: &str) -> String {
        self.path().join(name).display().to_string()
    }

    /// Writes a file into it and returns its path.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path().join(name), content).expect("a file in the temporary folder");
        self.at(name)
    }

    /// The names of its entries, sorted, including hidden ones.
    pub fn names(&self) -> Vec<String> {
        names(self.path())
    }
}

/// The names of a folder's entries, sorted, including hidden ones.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<_> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A JSON file.
pub fn json(path: impl AsRef<Path>) -> Value {
    let path = path.as_ref();
    let text = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The message of an error.
#[track_caller]
pub fn message<T: std::fmt::Debug>(result: pelage_core::Result<T>) -> String {
    result.expect_err("expected an error").to_string()
}

/// Runs `work` on a pool of `threads` threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(work)
}

/// Settings of property tests: `usual` cases where `PROPTEST_CASES` asks for no other number. A
/// failure is not written to a file, since the seed is fixed.
pub fn cases(usual: u32) -> Config {
    let mut config = Config { failure_persistence: None, ..Config::default() };
    if std::env::var_os("PROPTEST_CASES").is_none() {
        config.cases = usual;
    }
    config
}
