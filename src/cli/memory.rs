//! Memory that a run needs, against what is free: a run that does not fit is refused before it begins,
//! where the system would end it without a word.

use std::path::{Path, PathBuf};

use crate::explain::{Memory, bytes};

use super::exit::Failure;

/// Memory that may still be used, and what bounds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Free {
    /// Bytes.
    pub bytes: u64,
    /// What bounds them, for messages.
    pub bound: &'static str,
}

/// Refuses a run that needs more than is free, or than `limit` where the user gave one.
///
/// # Errors
/// [`Failure::Memory`], with what is needed, for what, and what to do.
pub(super) fn check(need: &Memory, limit: Option<u64>) -> Result<(), Failure> {
    match shortage(need, limit) {
        Some(message) => Err(Failure::Memory(message)),
        None => Ok(()),
    }
}

/// What is told of a run that needs more than is free, or than `limit` where the user gave one.
pub(super) fn shortage(need: &Memory, limit: Option<u64>) -> Option<String> {
    let free = match limit {
        Some(bytes) => Free {
            bytes,
            bound: "--memory",
        },
        None => free(Path::new("/"))?,
    };
    (need.peak > free.bytes).then(|| {
        format!(
            "the run needs about {} of memory at its highest (bonds {}, gradients {}, matrices {}, \
             factor {}, fields {}, and their working copies), and {} are free ({}); {}, or set the limit \
             by hand with --memory SIZE",
            bytes(need.peak),
            bytes(need.bonds),
            bytes(need.gradients),
            bytes(need.matrices),
            bytes(need.factor),
            bytes(need.fields),
            bytes(free.bytes),
            free.bound,
            remedy(need)
        )
    })
}

/// What makes the largest part smaller.
fn remedy(need: &Memory) -> &'static str {
    let rest = need.total - need.factor;
    match need.factor > rest {
        true => {
            "choose a solver without a factor, such as --solver faer-cg:preconditioner=amg or \
             fgmres:preconditioner=schur, or a coarser cloud"
        }
        false => "choose a coarser cloud or a smaller horizon",
    }
}

/// The least of what the machine has left and what limits leave; `None` where the system tells nothing.
pub(super) fn free(root: &Path) -> Option<Free> {
    let bound = |bytes: Option<u64>, bound| {
        Some(Free {
            bytes: bytes?,
            bound,
        })
    };
    [
        bound(available(root), "memory of the machine"),
        bound(
            left(root, "Max address space", "VmSize:"),
            "limit of the address space",
        ),
        bound(
            left(root, "Max data size", "VmData:"),
            "limit of the data size",
        ),
        bound(group(root), "limit of the control group"),
    ]
    .into_iter()
    .flatten()
    .min_by_key(|free| free.bytes)
}

fn read(path: PathBuf) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The first number after `key` in lines of `key number …`.
fn entry(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find(|line| line.starts_with(key))?;
    line[key.len()..].split_whitespace().next()?.parse().ok()
}

fn available(root: &Path) -> Option<u64> {
    let text = read(root.join("proc/meminfo"))?;
    Some(entry(&text, "MemAvailable:")? << 10)
}

/// What a limit of the process leaves; `None` without one.
fn left(root: &Path, limit: &str, used: &str) -> Option<u64> {
    let limit = entry(&read(root.join("proc/self/limits"))?, limit)?;
    let used = entry(&read(root.join("proc/self/status"))?, used)? << 10;
    Some(limit.saturating_sub(used))
}

/// What the control groups of the process leave, of version 2 or 1.
fn group(root: &Path) -> Option<u64> {
    let text = read(root.join("proc/self/cgroup"))?;
    let own = |line: &str| {
        let mut parts = line.splitn(3, ':');
        let (_, controllers, path) = (parts.next()?, parts.next()?, parts.next()?);
        match controllers {
            "" => Some(("sys/fs/cgroup", path.to_owned(), V2)),
            _ if controllers.split(',').any(|name| name == "memory") => {
                Some(("sys/fs/cgroup/memory", path.to_owned(), V1))
            }
            _ => None,
        }
    };
    let groups = text.lines().filter_map(own);
    groups
        .filter_map(|(mount, path, files)| bounded(&root.join(mount), &path, files))
        .min()
}

/// Names of a limit, of what is used, and of what is used but can be taken back.
type Files = [&'static str; 3];
const V2: Files = ["memory.max", "memory.current", "inactive_file"];
const V1: Files = [
    "memory.limit_in_bytes",
    "memory.usage_in_bytes",
    "total_inactive_file",
];

/// The least that a group and those above it leave.
fn bounded(mount: &Path, path: &str, [limit, used, idle]: Files) -> Option<u64> {
    let own = Path::new(path.trim_start_matches('/'));
    let left = |group: &Path| {
        let folder = mount.join(group);
        let number = |name: &str| read(folder.join(name))?.trim().parse::<u64>().ok();
        let idle =
            read(folder.join("memory.stat")).and_then(|text| entry(&text, &format!("{idle} ")));
        let used = number(used)?.saturating_sub(idle.unwrap_or(0));
        Some(number(limit)?.saturating_sub(used))
    };
    own.ancestors().filter_map(left).min()
}

/// Reads a size: `8 GiB`, `500 MB`, `6g`, `6442450944`.
///
/// # Errors
/// What is wrong with the text.
pub(super) fn size(text: &str) -> Result<u64, String> {
    let digits = text.trim().find(|c: char| !c.is_ascii_digit() && c != '.');
    let (number, unit) = text.trim().split_at(digits.unwrap_or(text.trim().len()));
    let factor = match unit.trim().to_lowercase().as_str() {
        "" | "b" => 1.0,
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        "k" | "kib" => 1024.0,
        "m" | "mib" => 1024.0 * 1024.0,
        "g" | "gib" => 1024.0 * 1024.0 * 1024.0,
        "t" | "tib" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
        _ => {
            return Err(format!(
                "unknown unit \"{}\", write it like 8GiB or 500MB",
                unit.trim()
            ));
        }
    };
    match number.parse::<f64>() {
        Ok(number) if number * factor >= 1.0 && number * factor < 1e18 => {
            Ok((number * factor) as u64)
        }
        _ => Err("expected a size such as 8GiB or 500MB".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine of 16 GiB of which 8 are available, and limits beside it.
    fn machine(files: &[(&str, &str)]) -> Option<Free> {
        let root = tempfile::tempdir().unwrap();
        let usual = [
            (
                "proc/meminfo",
                "MemTotal: 16777216 kB\nMemAvailable:    8388608 kB\n",
            ),
            (
                "proc/self/status",
                "VmSize:\t 1048576 kB\nVmData:\t 524288 kB\n",
            ),
        ];
        for (name, text) in usual.iter().chain(files) {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        free(root.path())
    }

    const GIB: u64 = 1 << 30;

    #[test]
    fn without_limits_it_is_what_the_machine_has_left() {
        let limits = "Max address space  unlimited  unlimited  bytes\n";
        let free =
            machine(&[("proc/self/limits", limits), ("proc/self/cgroup", "0::/\n")]).unwrap();
        assert_eq!((free.bytes, free.bound), (8 * GIB, "memory of the machine"));
    }

    #[test]
    fn a_limit_of_the_process_counts_what_it_uses_already() {
        let limits = "Max data size  unlimited unlimited bytes\nMax address space  6442450944  unlimited  bytes\n";
        let free = machine(&[("proc/self/limits", limits)]).unwrap();
        assert_eq!(
            (free.bytes, free.bound),
            (5 * GIB, "limit of the address space")
        );
    }

    #[test]
    fn the_tightest_of_the_groups_above_counts_less_what_can_be_taken_back() {
        let files = [
            ("proc/self/cgroup", "0::/work/job\n"),
            ("sys/fs/cgroup/work/job/memory.max", "max\n"),
            ("sys/fs/cgroup/work/job/memory.current", "100\n"),
            ("sys/fs/cgroup/work/memory.max", "4294967296\n"),
            ("sys/fs/cgroup/work/memory.current", "3221225472\n"),
            (
                "sys/fs/cgroup/work/memory.stat",
                "anon 1\ninactive_file 1073741824\n",
            ),
        ];
        let free = machine(&files).unwrap();
        assert_eq!(
            (free.bytes, free.bound),
            (2 * GIB, "limit of the control group")
        );
        let files = [
            ("proc/self/cgroup", "5:cpu,memory:/job\n1:name=systemd:/\n"),
            (
                "sys/fs/cgroup/memory/job/memory.limit_in_bytes",
                "1073741824\n",
            ),
            ("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "0\n"),
        ];
        assert_eq!(machine(&files).unwrap().bytes, GIB);
    }

    #[test]
    fn sizes_are_read_with_their_units() {
        for (text, bytes) in [
            ("8GiB", 8 * GIB),
            ("8 g", 8 * GIB),
            ("1.5 MB", 1_500_000),
            ("77", 77),
        ] {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in ["", "GiB", "-1", "3 parsecs", "1e99", "0"] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_run_that_does_not_fit_is_told_what_it_needs_and_what_to_do() {
        let need = Memory {
            bonds: 1_000_000_000,
            gradients: 0,
            matrices: 2_000_000_000,
            factor: 6_000_000_000,
            fields: 0,
            total: 9_000_000_000,
            peak: 14_400_000_000,
        };
        assert_eq!(shortage(&need, Some(14 * GIB)), None);
        let told = shortage(&need, Some(8 * GIB)).unwrap();
        for words in [
            "14.40 GB of memory at its highest",
            "factor 6.00 GB",
            "(--memory)",
            "preconditioner=amg",
        ] {
            assert!(told.contains(words), "{words}: {told}");
        }
    }
}
