//! The `oslcl` command.
//!
//! In: arguments. Out: what the command does, an exit code: 0 success, 1 failure, 2 wrong usage. The commands stand in `cli`.

#![forbid(unsafe_code)]

mod cli;

use anyhow::Context;
use clap::Parser;
use cli::args::Cli;
use cli::terminal;
use std::io;
use std::process::ExitCode;
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::fmt::time::uptime;

fn main() -> ExitCode {
    let args: Vec<_> = std::env::args_os().collect();
    if let Some(result) = cli::tools::dispatch(&args) {
        return result.unwrap_or_else(|error| end(&error.into()));
    }
    let cli = Cli::parse_from(args);
    match start(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => end(&error),
    }
}

fn start(cli: &Cli) -> anyhow::Result<()> {
    // The first `-v` of `plan` makes its table longer.
    let told = u8::from(matches!(cli.command, cli::args::Command::Plan(_)));
    log(cli.verbose.saturating_sub(told)).context("cannot start the log")?;
    cli::run(cli)?;
    Ok(())
}

/// Says why, and finds the exit code.
fn end(error: &anyhow::Error) -> ExitCode {
    match error.downcast_ref::<cli::Error>() {
        Some(cli::Error::Reported) => ExitCode::FAILURE,
        // Whoever read our output has seen enough, as in `oslcl devices | head -1`.
        Some(cli::Error::Print(cause)) if cause.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Some(cli::Error::Usage(_)) => {
            terminal::say_error(format!("{error}\n\nFor more information, try '--help'."));
            ExitCode::from(2)
        }
        _ => {
            terminal::say_error(format!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}

/// Starts the log on standard error: warnings, from `-v` on the time that each stage took.
fn log(verbose: u8) -> anyhow::Result<()> {
    let level = match verbose {
        0 => tracing::Level::WARN,
        1 => tracing::Level::DEBUG,
        _ => tracing::Level::TRACE,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(io::stderr)
        .with_ansi(terminal::is_fancy())
        .with_span_events(FmtSpan::CLOSE)
        .with_target(false)
        .with_timer(uptime())
        .log_internal_errors(false)
        .try_init()
        .map_err(|e| anyhow::anyhow!(e))
}
