//! How the program ends.

use std::process::ExitCode;

/// Exit codes. A script may rely on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Code {
    /// Something was found that somebody has to look at: an error in a program, a failed expectation.
    Findings = 1,
    /// The command line makes no sense (clap uses this code too).
    Usage = 2,
    /// A port cannot be opened, or the module behind it does not answer.
    Connection = 3,
    /// The module answered with an error status.
    TmclStatus = 4,
    /// The time is up, and something is undecided.
    Timeout = 42,
}

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub(crate) struct Failure {
    code: Code,
    message: String,
}

impl Failure {
    pub(crate) fn new(code: Code, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    pub(crate) fn code(&self) -> Code {
        self.code
    }

    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    /// The same, with more to say at its end.
    pub(crate) fn and_says(self, more: &str) -> Self {
        Self { message: self.message + more, ..self }
    }
}

/// What failed with some of several files; the others are seen to nevertheless.
#[derive(Debug, Default)]
pub(crate) struct Failures {
    worst: Option<Code>,
}

impl Failures {
    /// Says at once what failed.
    pub(crate) fn note<T>(&mut self, result: Result<T, Failure>) -> Option<T> {
        result
            .inspect_err(|failure| {
                crate::print::error(&failure.message);
                self.worst.get_or_insert(failure.code);
            })
            .ok()
    }

    /// How the command ends because of it, once everything is done.
    pub(crate) fn finish(self) -> Outcome {
        self.worst.map_or(Ok(()), |code| Err(code.into()))
    }
}

/// What a command returns.
pub(crate) type Outcome = Result<(), Ending>;

/// How a command ends when it does not simply end.
#[derive(Debug)]
pub(crate) enum Ending {
    /// With a message and a code.
    Failure(Failure),
    /// Writing its output failed.
    Output(std::io::Error),
    /// With a code; all that is to be said has been.
    Code(Code),
}

impl From<Code> for Ending {
    fn from(code: Code) -> Self {
        Self::Code(code)
    }
}

impl From<Failure> for Ending {
    fn from(failure: Failure) -> Self {
        Self::Failure(failure)
    }
}

impl From<std::io::Error> for Ending {
    fn from(error: std::io::Error) -> Self {
        Self::Output(error)
    }
}

/// Says what went wrong, if anything, and with which code the process ends.
pub(crate) fn finish(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads us has read enough, as in `tmcl params tmcm-1311 | head`.
        Err(Ending::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(Ending::Output(error)) => {
            crate::print::error(&format!("cannot write the output: {error}"));
            ExitCode::FAILURE
        }
        Err(Ending::Code(code)) => ExitCode::from(code as u8),
        Err(Ending::Failure(failure)) => {
            crate::print::error(&failure.message);
            ExitCode::from(failure.code as u8)
        }
    }
}
