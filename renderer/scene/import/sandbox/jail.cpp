#include "scene/import/sandbox/jail.h"

#include <linux/landlock.h>
#include <seccomp.h>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace {

bool jailed = false;

}  // namespace

// Called by LeakSanitizer at exit. The leak check needs /proc, which is not accessible in the jail,
// and would make every import fail.
extern "C" int __lsan_is_turned_off() {
    return jailed ? 1 : 0;
}

namespace clerestory {
namespace {

int landlockAbi() {
    const long abi =
        syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    return abi > 0 ? static_cast<int>(abi) : 0;
}

// All file access rights of this ABI version.
std::uint64_t allRights(int abi) {
    constexpr std::uint64_t kRefer = 1ull << 13, kTruncate = 1ull << 14,
                            kDeviceControl = 1ull << 15;
    std::uint64_t rights = (1ull << 13) - 1;
    if (abi >= 2) rights |= kRefer;
    if (abi >= 3) rights |= kTruncate;
    if (abi >= 5) rights |= kDeviceControl;
    return rights;
}

bool restrictFiles(const std::filesystem::path& folder, int abi) {
    landlock_ruleset_attr all{};
    all.handled_access_fs = allRights(abi);
    const int rules = static_cast<int>(
        syscall(SYS_landlock_create_ruleset, &all, sizeof all.handled_access_fs, 0));
    if (rules < 0) return false;
    landlock_path_beneath_attr below{};
    below.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
    below.parent_fd = open(folder.c_str(), O_PATH | O_CLOEXEC);
    const bool made =
        below.parent_fd >= 0 &&
        syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0) == 0 &&
        syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    if (below.parent_fd >= 0) close(below.parent_fd);
    close(rules);
    return made;
}

// For reading files, memory, time, threads and exit.
constexpr int kAllowed[] = {SCMP_SYS(read),
                            SCMP_SYS(pread64),
                            SCMP_SYS(readv),
                            SCMP_SYS(preadv),
                            SCMP_SYS(write),
                            SCMP_SYS(pwrite64),
                            SCMP_SYS(writev),
                            SCMP_SYS(open),
                            SCMP_SYS(openat),
                            SCMP_SYS(openat2),
                            SCMP_SYS(close),
                            SCMP_SYS(lseek),
                            SCMP_SYS(fstat),
                            SCMP_SYS(stat),
                            SCMP_SYS(lstat),
                            SCMP_SYS(newfstatat),
                            SCMP_SYS(statx),
                            SCMP_SYS(access),
                            SCMP_SYS(faccessat),
                            SCMP_SYS(faccessat2),
                            SCMP_SYS(readlink),
                            SCMP_SYS(readlinkat),
                            SCMP_SYS(getcwd),
                            SCMP_SYS(getdents64),
                            SCMP_SYS(fcntl),
                            SCMP_SYS(dup),
                            SCMP_SYS(fadvise64),
                            SCMP_SYS(poll),
                            SCMP_SYS(ppoll),
                            SCMP_SYS(mmap),
                            SCMP_SYS(munmap),
                            SCMP_SYS(mprotect),
                            SCMP_SYS(mremap),
                            SCMP_SYS(madvise),
                            SCMP_SYS(brk),
                            SCMP_SYS(futex),
                            SCMP_SYS(clock_gettime),
                            SCMP_SYS(clock_nanosleep),
                            SCMP_SYS(nanosleep),
                            SCMP_SYS(gettimeofday),
                            SCMP_SYS(time),
                            SCMP_SYS(getrandom),
                            SCMP_SYS(getpid),
                            SCMP_SYS(gettid),
                            SCMP_SYS(getuid),
                            SCMP_SYS(geteuid),
                            SCMP_SYS(getgid),
                            SCMP_SYS(getegid),
                            SCMP_SYS(sysinfo),
                            SCMP_SYS(uname),
                            SCMP_SYS(getrusage),
                            SCMP_SYS(getrlimit),
                            SCMP_SYS(sched_yield),
                            SCMP_SYS(sched_getaffinity),
                            SCMP_SYS(getcpu),
                            SCMP_SYS(set_robust_list),
                            SCMP_SYS(rseq),
                            SCMP_SYS(clone),
                            SCMP_SYS(clone3),
                            SCMP_SYS(rt_sigaction),
                            SCMP_SYS(rt_sigprocmask),
                            SCMP_SYS(rt_sigreturn),
                            SCMP_SYS(sigaltstack),
                            SCMP_SYS(tgkill),
                            SCMP_SYS(restart_syscall),
                            SCMP_SYS(exit),
                            SCMP_SYS(exit_group)};

bool filterSystemCalls() {
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    if (!filter) return false;
    bool made = true;
    for (const int call : kAllowed) {
        // Calls that this architecture does not have are skipped.
        const int added = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0);
        made = made && (added == 0 || added == -EDOM || added == -EINVAL);
    }
    made = made && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return made;
}

}  // namespace

JailSupport jailSupport() {
    return {.landlock = landlockAbi(),
            .systemCallFilter = prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0 && !kSanitized};
}

JailSupport enterJail(const std::filesystem::path& folder) {
    JailSupport got;
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return got;
    const int abi = landlockAbi();
    if (abi > 0 && restrictFiles(folder, abi)) got.landlock = abi;
    jailed = true;
    if (!kSanitized) got.systemCallFilter = filterSystemCalls();
    return got;
}

}  // namespace clerestory
