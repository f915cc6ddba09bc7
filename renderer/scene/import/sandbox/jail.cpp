#include "scene/import/sandbox/jail.h"

#include <linux/landlock.h>
#include <seccomp.h>

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
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

// As in newer kernels' headers.
struct RulesetAttributes {
    std::uint64_t files = 0;
    std::uint64_t network = 0;
    std::uint64_t scoped = 0;
};
constexpr int kFirstAbiWithScopes = 6;
constexpr std::uint64_t kScopeAbstractSockets = 1, kScopeSignals = 2;

// A new ruleset, or -1. `scoped`: left out where the kernel does not know it.
int rulesetFor(std::uint64_t files, std::uint64_t scoped, int abi) {
    const RulesetAttributes all{
        .files = files, .network = 0, .scoped = abi >= kFirstAbiWithScopes ? scoped : 0};
    const std::size_t size =
        abi >= kFirstAbiWithScopes ? sizeof all : offsetof(RulesetAttributes, network);
    return static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0));
}

// Allows the rights below the path.
bool addRule(int rules, const char* path, std::uint64_t rights) {
    landlock_path_beneath_attr below{};
    below.allowed_access = rights;
    below.parent_fd = open(path, O_PATH | O_CLOEXEC);
    if (below.parent_fd < 0) return false;
    const bool added =
        syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0) == 0;
    close(below.parent_fd);
    return added;
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
    const int rules = rulesetFor(allRights(abi), kScopeAbstractSockets | kScopeSignals, abi);
    if (rules < 0) return false;
    constexpr std::uint64_t kRead = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;
    addRule(rules, folder.c_str(), kRead);  // without the folder nothing can be read
    const bool made = syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    close(rules);
    return made;
}

// Commands of fcntl that concern the descriptor only: not those that choose who gets signals.
constexpr int kFcntlCommands[] = {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD,
                                  F_GETFL, F_GET_SEALS,     F_SETFL};

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
                            SCMP_SYS(rt_sigaction),
                            SCMP_SYS(rt_sigprocmask),
                            SCMP_SYS(rt_sigreturn),
                            SCMP_SYS(sigaltstack),
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
    const auto allow = [&](int call, scmp_arg_cmp condition) {
        made = made && seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, condition) == 0;
    };
    for (const int command : kFcntlCommands) {
        allow(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_EQ, static_cast<scmp_datum_t>(command)));
    }
    // Threads, but no processes. The flags of clone3 lie in memory, where a filter cannot see
    // them; the C library uses clone instead.
    allow(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
    made = made && seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0) == 0;
    // abort() sends itself a signal.
    allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));
    made = made && seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1) == 0 &&
           seccomp_load(filter) == 0;
    seccomp_release(filter);
    return made;
}

}  // namespace

JailSupport jailSupport() {
    return {.landlock = landlockAbi(),
            .systemCallFilter = prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0 && !kSanitized};
}

int separateFromOtherProcesses() {
    const int abi = landlockAbi();
    if (abi == 0) return 0;
    // Any domain separates. Renaming between folders is denied unless a rule allows it.
    constexpr std::uint64_t kDevices = LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_CHAR;
    constexpr std::uint64_t kRefer = 1ull << 13;
    const int rules = rulesetFor(abi >= 2 ? kDevices | kRefer : kDevices, kScopeSignals, abi);
    const bool made = rules >= 0 && (abi < 2 || addRule(rules, "/", kRefer)) &&
                      prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
                      syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    if (rules >= 0) close(rules);
    return made ? abi : 0;
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
