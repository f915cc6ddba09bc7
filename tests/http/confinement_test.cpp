// The confinement of a render worker: a process in it tries what an exploited driver would try, on
// its first thread and on another one, as root and as an ordinary user; and every thread of the
// workers of a real server.
#include "server/worker/confinement.h"

#include "scene/import/sandbox/jail.h"
#include "tests/bench/process_tree.h"
#include "tests/support/confinement.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/sysmacros.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace clerestory::test {
namespace {

enum class By { filter, landlock, landlock6 };

const char* nameOf(By by) {
    return by == By::filter ? "seccomp" : "landlock";
}

struct Attempt {
    const char* name;
    By by;
    bool (*succeeds)();
};

int handleOfParent = -1;  // opened before the confinement

// Of a call that makes a process: ends it at once if this is the new one.
bool makesProcess(long result) {
    if (result == 0) _exit(0);
    if (result > 0) waitpid(static_cast<pid_t>(result), nullptr, 0);
    return result > 0;
}

const Attempt kAttempts[] = {
    {"a ring of system calls", By::filter,
     [] {
         char parameters[120] = {};
         return syscall(SYS_io_uring_setup, 1, parameters) >= 0;
     }},
    {"a handle of the parent", By::filter,
     [] { return syscall(SYS_pidfd_open, getppid(), 0) >= 0; }},
    {"a descriptor of the parent", By::filter,
     [] { return syscall(SYS_pidfd_getfd, handleOfParent, 0, 0) >= 0; }},
    {"a signal by the handle", By::filter,
     [] { return syscall(SYS_pidfd_send_signal, handleOfParent, 0, nullptr, 0) == 0; }},
    {"the parent's memory as a file", By::landlock,
     [] {
         const std::string file = "/proc/" + std::to_string(getppid()) + "/mem";
         return open(file.c_str(), O_RDONLY) >= 0;
     }},
    {"the parent's descriptors as files", By::landlock,
     [] {
         const std::string file = "/proc/" + std::to_string(getppid()) + "/fd/0";
         return open(file.c_str(), O_RDONLY) >= 0;
     }},
    {"trace the parent", By::filter, [] { return ptrace(PTRACE_SEIZE, getppid(), 0, 0) == 0; }},
    {"read the parent's memory", By::filter,
     [] {
         char byte = 0;
         iovec here{&byte, 1}, there{&handleOfParent, 1};
         return process_vm_readv(getppid(), &here, 1, &there, 1, 0) == 1;
     }},
    {"a signal to the parent", By::filter, [] { return kill(getppid(), 0) == 0; }},
    {"a signal to a thread of the parent", By::filter,
     [] { return syscall(SYS_tgkill, getppid(), getppid(), 0) == 0; }},
    {"a signal to another process", By::landlock6, [] { return kill(1, 0) == 0; }},
    {"a file's signals for the parent", By::filter,
     [] { return fcntl(0, F_SETOWN, getppid()) == 0 || fcntl(0, F_SETSIG, SIGKILL) == 0; }},
    {"a user namespace", By::filter, [] { return unshare(CLONE_NEWUSER) == 0; }},
    {"a user namespace by clone", By::filter,
     [] { return makesProcess(syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, 0, 0, 0, 0)); }},
    {"a user namespace by clone3", By::filter,
     [] {
         std::uint64_t arguments[8] = {CLONE_NEWUSER, 0, 0, 0, SIGCHLD, 0, 0, 0};
         return makesProcess(syscall(SYS_clone3, arguments, sizeof arguments));
     }},
    {"a socket of any family but local", By::filter,
     [] {
         for (int family = 0; family < 64; ++family) {
             for (const int type : {SOCK_STREAM, SOCK_DGRAM, SOCK_RAW, SOCK_SEQPACKET}) {
                 if (family != AF_UNIX && socket(family, type, 0) >= 0) return true;
             }
         }
         return false;
     }},
    {"a device", By::landlock,
     [] {
         const std::string file = "/tmp/clerestory-device-" + std::to_string(getpid());
         const bool made = mknod(file.c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0;
         unlink(file.c_str());
         return made;
     }},
    {"mount", By::filter, [] { return mount("none", "/mnt", "tmpfs", 0, nullptr) == 0; }},
    {"a kernel program", By::filter,
     [] {
         char attributes[64] = {1, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 1};  // a small array
         return syscall(SYS_bpf, 0, attributes, sizeof attributes) >= 0;
     }},
    {"handling of page faults", By::filter, [] { return syscall(SYS_userfaultfd, 0) >= 0; }},
    {"keys of the kernel", By::filter,
     [] { return syscall(SYS_keyctl, 0 /* get id */, -3, 1) >= 0; }},
};

// Runs `work` in a child and gives its exit code.
template <class Work>
int inChild(Work work) {
    const pid_t child = fork();
    if (child == 0) _exit(work());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

bool isEnforced(By by, const JailSupport& support) {
    switch (by) {
        case By::filter:
            return support.systemCallFilter;
        case By::landlock:
            return support.landlock > 0;
        case By::landlock6:
            return support.landlock >= 6;
    }
    return false;
}

void tryAll(const Circumstances& circumstances) {
    JailSupport support = jailSupport();
    if (circumstances.withoutLandlock) support.landlock = 0;
    int openBefore = 0, tried = 0;
    for (const Attempt& attempt : kAttempts) {
        if (!isEnforced(attempt.by, support)) continue;
        ++tried;
        const auto attemptIn = [&](bool confined) {
            return inChild([&] {
                handleOfParent = static_cast<int>(syscall(SYS_pidfd_open, getppid(), 0));
                if (!enter(circumstances)) return 4;
                // A thread that exists before, as those of libraries may.
                std::atomic<int> state{0};
                bool succeedsInThread = false;
                std::thread early([&] {
                    while (state == 0) std::this_thread::yield();
                    succeedsInThread = attempt.by == By::filter && attempt.succeeds();
                });
                try {
                    if (confined && confine(0).landlock != support.landlock) return 7;
                } catch (const std::exception&) {
                    return 5;
                }
                state = 1;
                early.join();
                if (attempt.succeeds()) return 1;
                bool succeedsLater = false;
                std::thread([&] { succeedsLater = attempt.succeeds(); }).join();
                return succeedsInThread ? 2 : succeedsLater ? 3 : 0;
            });
        };
        const bool open = attemptIn(false) != 0;
        openBefore += open;
        EXPECT_EQ(attemptIn(true), 0) << attempt.name;
        std::printf("%-10s %-36s %s\n", nameOf(attempt.by), attempt.name,
                    open ? "denied; possible without" : "denied");
    }
    std::printf("%d attempts, %d of them possible without the confinement\n", tried, openBefore);
}

TEST(Confinement, AWorkerReachesNoOtherProcess) {
    tryAll({});
}

TEST(Confinement, AWorkerOfAnOrdinaryUserReachesNoOtherProcess) {
    if (getuid() != 0) GTEST_SKIP() << "not root: the other test is this one";
    tryAll({.asOrdinaryUser = true});
}

// What the filter of system calls forbids stays forbidden; the rest is said, not enforced.
TEST(Confinement, WithoutLandlockTheFilterRemains) {
    if (!jailSupport().systemCallFilter) GTEST_SKIP() << "no seccomp here";
    tryAll({.withoutLandlock = true});
}

// A6 of the catalogue of attacks: one thread of each renderer started before the filter.
TEST(Confinement, EveryThreadOfEveryWorkerIsFiltered) {
    if (!jailSupport().systemCallFilter) GTEST_SKIP() << "no seccomp here";
    const ServerProcess server({"--scene", "six-walls"});
    ASSERT_TRUE(server.waitUntilReady());
    std::vector<pid_t> workers;
    ASSERT_TRUE(within(std::chrono::seconds(30), [&] {
        workers = bench::workersOf(server.id());
        return workers.size() == 2;
    })) << workers.size();
    int threads = 0;
    const auto filtered = [&](pid_t worker) {
        threads = 0;
        for (const auto& task :
             std::filesystem::directory_iterator("/proc/" + std::to_string(worker) + "/task")) {
            std::ifstream status(task.path() / "status");
            ++threads;
            bool isFiltered = false;
            for (std::string line; std::getline(status, line);) {
                isFiltered = isFiltered || line == "Seccomp:\t2";
            }
            if (!isFiltered) return false;
        }
        return threads > 2;
    };
    for (const pid_t worker : workers) {
        // The standby may just have started.
        EXPECT_TRUE(soon([&] { return filtered(worker); }));
        std::printf("a worker: %d threads, all filtered\n", threads);
    }
}

}  // namespace
}  // namespace clerestory::test
