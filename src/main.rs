//! The `landscape` command; everything it does lives in [`landscape::cli`].

fn main() -> std::process::ExitCode {
    landscape::cli::run()
}
