// The circumstances in which tests of confinement try their attempts.
#pragma once

#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <iterator>

namespace clerestory::test {

struct Circumstances {
    bool asOrdinaryUser = false;
    bool withoutLandlock = false;
};

// From now on this process is on a kernel without landlock, as older ones and some containers are.
inline bool removeLandlock() {
    sock_filter program[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_landlock_create_ruleset, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog filter{.len = std::size(program), .filter = program};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter, 0, 0) == 0;
}

// Of this process. Returns false if they cannot be had.
inline bool enter(const Circumstances& circumstances) {
    return (!circumstances.asOrdinaryUser || setuid(65534) == 0) &&
           (!circumstances.withoutLandlock || removeLandlock());
}

}  // namespace clerestory::test
