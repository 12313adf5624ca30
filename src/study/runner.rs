//! One run of the program as a user would start it, with what it took.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use wait4::{ResUse, Wait4};

use super::StudyError;
use crate::run::{Interrupt, Summary};

/// What a child process did.
#[derive(Debug, Clone)]
pub(crate) struct RunOutcome {
    /// Exit code; `None` if a signal ended it.
    pub code: Option<i32>,
    /// Wall time from start to end, s.
    pub wall_s: f64,
    /// Processor time of all its threads, s.
    pub cpu_s: f64,
    /// Largest resident memory, bytes.
    pub memory_bytes: u64,
    /// The summary that it printed, if it got there.
    pub summary: Option<Summary>,
    /// Why it failed: the last error on its standard error.
    pub reason: Option<String>,
    /// Whether it was ended because it took too long.
    pub timed_out: bool,
}

/// Starts runs of the program.
#[derive(Debug, Clone)]
pub(crate) struct Runner {
    program: PathBuf,
    build: String,
    scene: String,
}

/// Pause between two looks at a child at first; it grows with the time passed.
const SHORTEST_LOOK: Duration = Duration::from_micros(200);
/// Longest pause between two looks at a child.
const LONGEST_LOOK: Duration = Duration::from_millis(5);

impl Runner {
    /// Runs of `scene` by the program that is running now.
    ///
    /// # Errors
    /// [`StudyError::Program`] if the program cannot be found or read.
    pub(crate) fn new(scene: &str) -> Result<Self, StudyError> {
        let program = std::env::current_exe().map_err(StudyError::Program)?;
        Ok(Runner {
            build: build(&program).map_err(StudyError::Program)?,
            program,
            scene: scene.to_owned(),
        })
    }

    /// What tells this build of the program from all others.
    pub(crate) fn build(&self) -> &str {
        &self.build
    }

    /// Runs the scene with the overrides and leaves its results in `folder`; `None` if interrupted.
    ///
    /// # Errors
    /// [`StudyError::Program`] if the program cannot be started or awaited.
    pub(crate) fn run(
        &self,
        overrides: &[String],
        folder: &Path,
        limit: Duration,
        interrupt: &Interrupt,
    ) -> Result<Option<RunOutcome>, StudyError> {
        let printed = |name: &str| std::fs::File::create(folder.join(name));
        let mut command = Command::new(&self.program);
        command.arg("run").arg(&self.scene);
        for text in overrides {
            command.arg("--set").arg(text);
        }
        command
            .args(["--json", "--quiet", "--out"])
            .arg(folder.join("out"));
        command.stdin(Stdio::null());
        command.stdout(printed("stdout").map_err(StudyError::Program)?);
        command.stderr(printed("stderr").map_err(StudyError::Program)?);
        let start = Instant::now();
        let mut child = command.spawn().map_err(StudyError::Program)?;
        let stopped = watch(&mut child, start, limit, interrupt).map_err(StudyError::Program)?;
        let ResUse { status, rusage } = child.wait4().map_err(StudyError::Program)?;
        let wall_s = start.elapsed().as_secs_f64();
        // An interruption from the keyboard reaches the child as well.
        if stopped == Some(Stopped::Interrupted) || interrupt.is_raised() {
            return Ok(None);
        }
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        let timed_out = stopped == Some(Stopped::TooLong);
        Ok(Some(RunOutcome {
            code: status.code(),
            wall_s,
            cpu_s: (rusage.utime + rusage.stime).as_secs_f64(),
            memory_bytes: rusage.maxrss,
            summary: serde_json::from_str(&read("stdout")).ok(),
            reason: match timed_out {
                true => Some(format!("took longer than {:.3} s", limit.as_secs_f64())),
                false if status.success() => None,
                false => Some(reason(&read("stderr"))),
            },
            timed_out,
        }))
    }
}

/// Version, length and checksum of a program: the version alone stays while the program is worked on.
fn build(program: &Path) -> io::Result<String> {
    let file = std::fs::File::open(program)?;
    let length = file.metadata()?.len();
    let mut reader = flate2::CrcReader::new(io::BufReader::with_capacity(1 << 20, file));
    io::copy(&mut reader, &mut io::sink())?;
    let version = env!("CARGO_PKG_VERSION");
    Ok(format!("{version}+{length:x}.{:08x}", reader.crc().sum()))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stopped {
    Interrupted,
    TooLong,
}

/// Waits for the end of the child without collecting it, so that what it used can still be asked for.
fn watch(
    child: &mut Child,
    start: Instant,
    limit: Duration,
    interrupt: &Interrupt,
) -> io::Result<Option<Stopped>> {
    loop {
        if has_ended(child)? {
            return Ok(None);
        }
        let stop = match interrupt.is_raised() {
            true => Some(Stopped::Interrupted),
            false => (start.elapsed() > limit).then_some(Stopped::TooLong),
        };
        if stop.is_some() {
            child.kill()?;
            return Ok(stop);
        }
        std::thread::sleep((start.elapsed() / 100).clamp(SHORTEST_LOOK, LONGEST_LOOK));
    }
}

#[cfg(unix)]
fn has_ended(child: &Child) -> io::Result<bool> {
    use nix::sys::wait::{Id, WaitPidFlag, WaitStatus, waitid};
    let pid = nix::unistd::Pid::from_raw(child.id() as i32);
    let look = WaitPidFlag::WEXITED | WaitPidFlag::WNOHANG | WaitPidFlag::WNOWAIT;
    match waitid(Id::Pid(pid), look) {
        Ok(status) => Ok(status != WaitStatus::StillAlive),
        Err(nix::errno::Errno::EINTR) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// The message on standard error, without the lines that show where in the scene.
fn reason(stderr: &str) -> String {
    let lines = stderr.lines().map(str::trim);
    let errors: Vec<&str> = lines.filter(|line| line.starts_with("error")).collect();
    match errors.last() {
        Some(line) => line.trim_start_matches("error:").trim().to_owned(),
        None => match stderr.trim().lines().last() {
            Some(line) => line.trim().to_owned(),
            None => "it ended without a word".to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_more_or_another_byte_makes_another_build() {
        let folder = tempfile::tempdir().unwrap();
        let of = |bytes: &[u8]| {
            let path = folder.path().join("program");
            std::fs::write(&path, bytes).unwrap();
            build(&path).unwrap()
        };
        let first = of(b"program");
        assert_eq!(first, of(b"program"));
        assert_ne!(first, of(b"program."));
        assert_ne!(first, of(b"prograM"));
        assert!(first.starts_with(env!("CARGO_PKG_VERSION")));
    }

    #[test]
    fn the_reason_is_the_last_error() {
        let text = "warning: coarse\nerror: expected a time\n --> scene.toml:9\n";
        assert_eq!(reason(text), "expected a time");
        assert_eq!(reason("thread panicked\n"), "thread panicked");
        assert_eq!(reason(""), "it ended without a word");
    }
}
