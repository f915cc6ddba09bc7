#include "server/worker/confinement.h"

#include "scene/import/sandbox/jail.h"
#include "server/base/log.h"

#include <seccomp.h>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>

namespace clerestory {
namespace {

// Forbidden calls fail with "permission denied", which drivers handle.
bool forbidNetwork() {
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    if (!filter) return false;
    bool made = true;
    const auto forbid = [&](int call, auto... conditions) {
        made = made && seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), call, sizeof...(conditions),
                                        conditions...) == 0;
    };
    // Local sockets are allowed: the driver may connect to a display server.
    forbid(SCMP_SYS(socket), SCMP_A0(SCMP_CMP_NE, AF_UNIX));
    forbid(SCMP_SYS(ptrace));
    forbid(SCMP_SYS(process_vm_readv));
    forbid(SCMP_SYS(process_vm_writev));
    forbid(SCMP_SYS(mount));
    forbid(SCMP_SYS(bpf));
    forbid(SCMP_SYS(kexec_load));
    forbid(SCMP_SYS(init_module));
    forbid(SCMP_SYS(finit_module));
    made = made && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return made;
}

// Constant-initialised: allocations happen before main().
constinit std::atomic<bool> endWhenOutOfMemory{false};

}  // namespace

void endWithoutMemory() {
    endWhenOutOfMemory = true;
}

bool endsWithoutMemory() {
    return endWhenOutOfMemory;
}

void endWithParent() {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
}

void confine(std::uint64_t addressSpaceBytes) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    if (addressSpaceBytes > 0 && !kSanitized) {
        // The soft limit: the importer, a child process, may set a larger one.
        rlimit space{};
        getrlimit(RLIMIT_AS, &space);
        space.rlim_cur = std::min<rlim_t>(addressSpaceBytes, space.rlim_max);
        setrlimit(RLIMIT_AS, &space);
    }
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || !forbidNetwork()) {
        logWarning({"the render worker runs without a filter of system calls"});
    }
}

}  // namespace clerestory
