// The importer's sandbox: a process in it tries what exploited reader code would try.
#include "scene/import/sandbox/jail.h"
#include "tests/support/confinement.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

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

struct Attempt {
    const char* name;
    bool byFilter;  // otherwise by landlock
    bool (*succeeds)();
};

bool opens(const char* path, int flags) {
    const int file = open(path, flags, 0600);
    if (file >= 0) close(file);
    return file >= 0;
}

// Of a call that makes a process: ends it at once if this is the new one.
bool succeedsInChild(long result) {
    if (result == 0) _exit(0);
    return result > 0;
}

// In the jail's folder, which is the working directory.
const Attempt kAttempts[] = {
    {"read a file of the system", false, [] { return opens("/etc/passwd", O_RDONLY); }},
    {"read a file above the folder", false, [] { return opens("../outside.txt", O_RDONLY); }},
    {"list the root", false, [] { return opens("/", O_RDONLY | O_DIRECTORY); }},
    {"read a device", false, [] { return opens("/dev/zero", O_RDONLY); }},
    {"read its own memory map", false, [] { return opens("/proc/self/maps", O_RDONLY); }},
    {"write a file inside", false, [] { return opens("inside.txt", O_WRONLY); }},
    {"make a file inside", false, [] { return opens("new.txt", O_CREAT | O_WRONLY); }},
    {"cut a file inside", false, [] { return opens("inside.txt", O_RDWR | O_TRUNC); }},
    {"remove a file", true, [] { return unlink("inside.txt") == 0; }},
    {"rename a file", true, [] { return rename("inside.txt", "other.txt") == 0; }},
    {"make a folder", true, [] { return mkdir("folder", 0700) == 0; }},
    {"make a link", true, [] { return symlink("/etc/passwd", "link") == 0; }},
    {"a socket of the network", true, [] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }},
    {"a socket of the machine", true, [] { return socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }},
    {"a pair of sockets", true,
     [] {
         int ends[2];
         return socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0;
     }},
    {"another program", true,
     [] {
         char name[] = "true";
         char* arguments[] = {name, nullptr};
         execv("/bin/true", arguments);
         return false;  // it would not come back here
     }},
    {"trace the parent", true, [] { return ptrace(PTRACE_ATTACH, getppid(), 0, 0) == 0; }},
    {"a signal to the parent", true, [] { return kill(getppid(), 0) == 0; }},
    {"read the parent's memory", true,
     [] {
         char byte = 0;
         iovec here{&byte, 1}, there{&byte, 1};
         return process_vm_readv(getppid(), &here, 1, &there, 1, 0) == 1;
     }},
    {"a signal to a thread of the parent", true,
     [] { return syscall(SYS_tgkill, getppid(), getppid(), 0) == 0; }},
    {"a signal to a thread by its number", true,
     [] { return syscall(SYS_tkill, getppid(), 0) == 0; }},
    {"a file's signals for the parent", true,
     [] { return fcntl(0, F_SETOWN, getppid()) == 0 || fcntl(0, F_SETSIG, SIGKILL) == 0; }},
    {"a handle of the parent", true, [] { return syscall(SYS_pidfd_open, getppid(), 0) >= 0; }},
    {"the parent's memory as a file", false,
     [] { return opens(("/proc/" + std::to_string(getppid()) + "/mem").c_str(), O_RDONLY); }},
    {"a process that outlives it", true, [] { return succeedsInChild(syscall(SYS_fork)); }},
    {"a process by vfork", true,
     [] { return succeedsInChild(syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0)); }},
    {"a user namespace", true,
     [] { return succeedsInChild(syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, 0, 0, 0, 0)); }},
    {"a user namespace by clone3", true,
     [] {
         std::uint64_t arguments[8] = {CLONE_NEWUSER, 0, 0, 0, SIGCHLD, 0, 0, 0};
         return succeedsInChild(syscall(SYS_clone3, arguments, sizeof arguments));
     }},
    {"a user namespace by unshare", true, [] { return unshare(CLONE_NEWUSER) == 0; }},
    {"a ring of system calls", true,
     [] {
         char parameters[120] = {};
         return syscall(SYS_io_uring_setup, 1, parameters) >= 0;
     }},
    {"mount", true, [] { return mount("none", "/mnt", "tmpfs", 0, nullptr) == 0; }},
    {"another root", true, [] { return chroot(".") == 0; }},
    {"another user", true, [] { return setuid(65534) == 0; }},
    {"shared memory", true, [] { return shmget(IPC_PRIVATE, 4096, IPC_CREAT | 0600) >= 0; }},
    {"a hidden file", true, [] { return memfd_create("x", 0) >= 0; }},
    {"a kernel program", true, [] { return syscall(SYS_bpf, 0, nullptr, 0) >= 0; }},
    {"higher limits", true,
     [] { return syscall(SYS_prlimit64, 0, 7 /* descriptors */, nullptr, nullptr) == 0; }},
};

class ImportSandbox : public testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directories(folder);
        std::ofstream(folder / "inside.txt") << "inside";
        std::ofstream(folder.parent_path() / "outside.txt") << "outside";
    }
    // Runs `work` in a child and gives its exit code.
    template <class Work>
    static int inChild(Work work) {
        const pid_t child = fork();
        if (child == 0) _exit(work());
        int status = 0;
        waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    }
    const std::filesystem::path folder =
        std::filesystem::path(CLERESTORY_TEST_OUTPUT) / "jail" / "scene";
};

class ImportSandboxIn : public ImportSandbox, public testing::WithParamInterface<Circumstances> {};
INSTANTIATE_TEST_SUITE_P(, ImportSandboxIn,
                         testing::Values(Circumstances{}, Circumstances{.asOrdinaryUser = true},
                                         Circumstances{.withoutLandlock = true}),
                         [](const auto& row) {
                             return row.param.asOrdinaryUser    ? "AsOrdinaryUser"
                                    : row.param.withoutLandlock ? "WithoutLandlock"
                                                                : "AsItIs";
                         });

TEST_P(ImportSandboxIn, EverythingElseIsDenied) {
    JailSupport support = jailSupport();
    if (GetParam().withoutLandlock) support.landlock = 0;
    if (GetParam().asOrdinaryUser && getuid() != 0) GTEST_SKIP() << "the tests run as one";
    if (support.landlock == 0) std::printf("this kernel has no landlock\n");
    int tried = 0;
    for (const Attempt& attempt : kAttempts) {
        const bool enforced = attempt.byFilter ? support.systemCallFilter : support.landlock > 0;
        if (!enforced) continue;
        ++tried;
        const int code = inChild([&] {
            if (chdir(folder.c_str()) != 0 || !enter(GetParam())) return 3;
            if (enterJail(folder).landlock != support.landlock) return 4;
            if (attempt.succeeds()) return 1;
            // Threads that start later are confined, too.
            bool succeedsInThread = false;
            std::thread([&] { succeedsInThread = attempt.succeeds(); }).join();
            return succeedsInThread ? 2 : 0;
        });
        EXPECT_EQ(code, 0) << attempt.name;
        if (code != 0) continue;
        std::printf("denied by %s: %s\n", attempt.byFilter ? "seccomp" : "landlock", attempt.name);
    }
    std::printf("%d of %zu attempts were tried, and refused\n", tried, std::size(kAttempts));
    if (!support.systemCallFilter && support.landlock == 0) GTEST_SKIP() << "no jail here";
}

TEST_F(ImportSandbox, AllowsReadingAndComputing) {
    const int code = inChild([&] {
        if (chdir(folder.c_str()) != 0) return 3;
        enterJail(folder);
        std::ifstream file("inside.txt");
        std::string word;
        file >> word;
        std::vector<char> memory(64 << 20, 1);
        return word == "inside" && memory.back() == 1 ? 0 : 1;
    });
    EXPECT_EQ(code, 0);
}

}  // namespace
}  // namespace clerestory::test
