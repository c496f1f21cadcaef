//! The memory that the system lets this process use: the free memory of the machine, and the limits of its
//! control groups (Linux "Control Group v2" and v1 memory controllers) and resource limits (`setrlimit(2)`).
//! Systems that report none of these set no bound.

use std::path::{Path, PathBuf};

/// The stack of a thread, which is all it takes besides its data where its allocations come
/// [from the arena of all](restrain_allocator).
const THREAD_BYTES: u64 = 2 << 20;

/// How the allocator of the GNU C library is told the most arenas that it may have, and the bytes from which on a block
/// is given back to the system as it is freed (`mallopt(3)`).
const ARENAS: &str = "MALLOC_ARENA_MAX";
const GIVEN_BACK_FROM: (&str, &str) = ("MALLOC_MMAP_THRESHOLD_", "131072");

/// Starts the program again with one arena for the allocations of all threads, and none of them kept once it is freed,
/// if its address space is limited (`ulimit -v`). By itself the allocator of the GNU C library reserves 64 MiB of
/// address space for each thread, and where it cannot, tries again at each allocation with up to 128 MiB for a moment,
/// in which an allocation of another thread fails and ends the program; and it keeps freed blocks of up to 32 MiB.
/// It reads these settings as the program starts.
pub fn restrain_allocator() {
    #[cfg(target_os = "linux")]
    if std::env::var_os(ARENAS).is_none() && address_space_is_limited() {
        use std::os::unix::process::CommandExt;
        let mut words = std::env::args_os();
        let (Ok(program), Some(name)) = (std::env::current_exe(), words.next()) else { return };
        // It returns if the system refuses, and the program goes on as it is.
        let mut again = std::process::Command::new(program);
        again.arg0(name).args(words).env(ARENAS, "1").env(GIVEN_BACK_FROM.0, GIVEN_BACK_FROM.1);
        let _refused = again.exec();
    }
}

/// The bytes still available, as far as the system reports them.
pub fn available_bytes(threads: usize) -> Option<u64> {
    let machine = read("/proc/meminfo").and_then(|text| kib(&text, "MemAvailable:"));
    [machine, control_groups(), process(threads)].into_iter().flatten().min()
}

/// The bytes left by the resource limits of the process, once `threads` have started.
pub fn process(threads: usize) -> Option<u64> {
    let (limits, status) = (read("/proc/self/limits")?, read("/proc/self/status")?);
    within_limits(&limits, &status, threads as u64)
}

fn read(path: impl AsRef<Path>) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The number of KiB after a key at the start of a line, in bytes.
fn kib(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The memory left by `/proc/self/limits` after that reported as used by `/proc/self/status`.
fn within_limits(limits: &str, status: &str, threads: u64) -> Option<u64> {
    let left = |name: &str, taken: &str| {
        let taken = kib(status, taken).unwrap_or(0).saturating_add(threads.saturating_mul(THREAD_BYTES));
        soft_limit(limits, name).map(|limit| limit.saturating_sub(taken))
    };
    [left(ADDRESS_SPACE, "VmSize:"), left("Max data size", "VmData:")].into_iter().flatten().min()
}

#[cfg(target_os = "linux")]
fn address_space_is_limited() -> bool {
    read("/proc/self/limits").and_then(|limits| soft_limit(&limits, ADDRESS_SPACE)).is_some()
}

/// The name of this limit in `/proc/self/limits`.
const ADDRESS_SPACE: &str = "Max address space";

/// A soft limit in bytes, if there is one.
fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The memory left by the control groups of the process, up to the root.
fn control_groups() -> Option<u64> {
    let groups = read("/proc/self/cgroup")?;
    folders(&groups).iter().filter_map(|folder| left_in_group(&|file| read(folder.join(file)))).min()
}

/// The folders of the groups named by `/proc/self/cgroup` and of all above them.
fn folders(groups: &str) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let roots: &[&str] = match controllers {
            "" => &["/sys/fs/cgroup", "/sys/fs/cgroup/unified"],
            _ if controllers.split(',').any(|name| name == "memory") => &["/sys/fs/cgroup/memory"],
            _ => continue,
        };
        for root in roots {
            let inside = Path::new(path.trim_start_matches('/'));
            folders.extend(inside.ancestors().map(|above| Path::new(root).join(above)));
        }
    }
    folders
}

/// The memory left by one group; `file` reads a file of its folder. Cached files that can be dropped count as
/// free.
fn left_in_group(file: &dyn Fn(&str) -> Option<String>) -> Option<u64> {
    // Words such as `max` set no bound.
    let number = |name: &str| file(name)?.trim().parse::<u64>().ok();
    let limits = ["memory.max", "memory.high", "memory.limit_in_bytes"];
    let limit = limits.into_iter().filter_map(number).min()?;
    let taken = number("memory.current").or_else(|| number("memory.usage_in_bytes")).unwrap_or(0);
    let inactive = file("memory.stat").and_then(|text| {
        let find =
            |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse::<u64>().ok());
        find("total_inactive_file ").or_else(|| find("inactive_file "))
    });
    Some(limit.saturating_sub(taken.saturating_sub(inactive.unwrap_or(0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: &str = "Limit                     Soft Limit           Hard Limit           Units     \n\
        Max data size             unlimited            unlimited            bytes     \n\
        Max address space         1073741824           unlimited            bytes     \n";
    const STATUS: &str = "Name:\trelume\nVmSize:\t   51200 kB\nVmData:\t   10240 kB\n";

    #[test]
    fn limits_of_the_process_count_with_its_threads() {
        let left = (1u64 << 30) - (50 << 20);
        assert_eq!(within_limits(LIMITS, STATUS, 0), Some(left));
        assert_eq!(within_limits(LIMITS, STATUS, 2), Some(left - 2 * THREAD_BYTES));
        assert_eq!(within_limits(LIMITS, STATUS, 1000), Some(0));
        let data = LIMITS.replace("data size             unlimited", "data size             209715200");
        assert_eq!(within_limits(&data, STATUS, 0), Some(190 << 20));
        assert_eq!(within_limits(&LIMITS.replace("1073741824", "unlimited "), STATUS, 2), None);
        assert_eq!(within_limits("", "", 2), None);
    }

    #[test]
    fn free_memory_is_read_from_its_line() {
        assert_eq!(kib("MemFree: 1 kB\nMemAvailable:    2048 kB\n", "MemAvailable:"), Some(2 << 20));
        assert_eq!(kib("MemAvailable: many kB\n", "MemAvailable:"), None);
    }

    #[test]
    fn groups_are_looked_for_up_to_the_root() {
        let paths = |text: &str| folders(text).iter().map(|p| p.display().to_string()).collect::<Vec<_>>();
        assert_eq!(
            paths("4:cpu,memory:/a\n3:cpuset:/x\n"),
            ["/sys/fs/cgroup/memory/a", "/sys/fs/cgroup/memory/"]
        );
        assert_eq!(
            paths("0::/user.slice/b:c\n")[..3],
            ["/sys/fs/cgroup/user.slice/b:c", "/sys/fs/cgroup/user.slice", "/sys/fs/cgroup/"]
        );
        assert!(paths("nonsense").is_empty());
    }

    #[test]
    fn a_group_leaves_what_is_below_its_least_limit() {
        let group = |files: &[(&str, &str)]| {
            left_in_group(&|name| {
                files.iter().find(|(file, _)| *file == name).map(|(_, text)| (*text).to_owned())
            })
        };
        let second = [("memory.max", "1000\n"), ("memory.high", "max\n"), ("memory.current", "400\n")];
        assert_eq!(group(&second), Some(600));
        assert_eq!(group(&[("memory.max", "max\n"), ("memory.current", "400\n")]), None);
        assert_eq!(group(&[("memory.high", "300\n"), ("memory.current", "400\n")]), Some(0));
        let cached = "anon 100\ninactive_file 250\nactive_file 50\n";
        let files = [("memory.max", "1000"), ("memory.current", "400"), ("memory.stat", cached)];
        assert_eq!(group(&files), Some(850));
        let first = [("memory.limit_in_bytes", "1000"), ("memory.usage_in_bytes", "900")];
        assert_eq!(group(&first), Some(100));
    }
}
