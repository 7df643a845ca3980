//! The `pelage` command: everything it does is in the library, see [`pelage::cli`].

fn main() -> std::process::ExitCode {
    pelage::cli::run()
}
