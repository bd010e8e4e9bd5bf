//! Entry point of the program `tatu`.

fn main() -> std::process::ExitCode {
    tatu_cli::main(std::env::args_os())
}
