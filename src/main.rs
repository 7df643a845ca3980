//! The `pelage` command.

mod cli;

fn main() -> std::process::ExitCode {
    #[cfg(unix)]
    without_desktop();
    cli::run()
}

/// Mesa's Vulkan layer that asks the desktop for its device prints an error where there is no
/// desktop. It reads a variable of the environment to be left out, which can only be set safely
/// before the process begins: so the process begins again.
#[cfg(unix)]
fn without_desktop() {
    use std::os::unix::process::CommandExt;
    const OFF: &str = "NODEVICE_SELECT";
    let set = |name: &str| std::env::var_os(name).is_some();
    if set("XDG_RUNTIME_DIR") || set("DISPLAY") || set(OFF) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut command = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        command.arg0(name);
    }
    // Returns only if it fails; then the error line is all that there is to lose.
    let _ = command.args(arguments).env(OFF, "1").exec();
}
