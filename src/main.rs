//! The program `pars`.

#![forbid(unsafe_code)]

use std::process::ExitCode;

/// Terms are many small shared pieces: this one takes them in less time than the system's.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Terms may be deep, and what walks down them needs room.
const STACK: usize = 1 << 30;

fn main() -> ExitCode {
    let work = std::thread::Builder::new().name("pars".to_string()).stack_size(STACK).spawn(|| {
        pars::term::room::tell(STACK);
        pars::cli::run()
    });
    match work.map(std::thread::JoinHandle::join) {
        Ok(Ok(code)) => ExitCode::from(code),
        // The panic has been printed.
        Ok(Err(_)) => ExitCode::from(101),
        Err(error) => {
            pars::script::complain(&format!("pars cannot start: {error}\n"));
            ExitCode::from(101)
        }
    }
}
