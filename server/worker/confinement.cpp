#include "server/worker/confinement.h"

#include "scene/import/sandbox/jail.h"
#include "server/base/log.h"

#include <seccomp.h>

#include <fcntl.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <stdexcept>

namespace clerestory {
namespace {

// Forbidden calls fail with "permission denied", which drivers handle.
bool filterSystemCalls() {
    scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
    if (!filter) return false;
    bool made = true;
    const auto forbid = [&](int call, auto... conditions) {
        made = made && seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), call, sizeof...(conditions),
                                        conditions...) == 0;
    };
    // Local sockets are allowed: the driver may connect to a display server.
    forbid(SCMP_SYS(socket), SCMP_A0(SCMP_CMP_NE, AF_UNIX));
    // A ring performs calls that no filter sees.
    for (const int call :
         {SCMP_SYS(io_uring_setup), SCMP_SYS(io_uring_enter), SCMP_SYS(io_uring_register)}) {
        forbid(call);
    }
    for (const int call :
         {SCMP_SYS(ptrace), SCMP_SYS(process_vm_readv), SCMP_SYS(process_vm_writev),
          SCMP_SYS(process_madvise), SCMP_SYS(pidfd_open), SCMP_SYS(pidfd_getfd),
          SCMP_SYS(pidfd_send_signal), SCMP_SYS(kcmp)}) {
        forbid(call);
    }
    for (const int call :
         {SCMP_SYS(mount), SCMP_SYS(umount2), SCMP_SYS(pivot_root), SCMP_SYS(unshare),
          SCMP_SYS(setns), SCMP_SYS(bpf), SCMP_SYS(perf_event_open), SCMP_SYS(userfaultfd),
          SCMP_SYS(add_key), SCMP_SYS(request_key), SCMP_SYS(keyctl), SCMP_SYS(kexec_load),
          SCMP_SYS(init_module), SCMP_SYS(finit_module)}) {
        forbid(call);
    }
    // New namespaces. The flags of clone3 lie in memory, where a filter cannot see them; the C
    // library uses clone instead.
    for (const scmp_datum_t flag : {CLONE_NEWUSER, CLONE_NEWNS, CLONE_NEWNET, CLONE_NEWPID,
                                    CLONE_NEWIPC, CLONE_NEWUTS, CLONE_NEWCGROUP}) {
        forbid(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, flag, flag));
    }
    made = made && seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0) == 0;
    // Signals of files to other processes, and any to the server; its own children get some.
    for (const scmp_datum_t command : {F_SETOWN, F_SETSIG, F_SETOWN_EX}) {
        forbid(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_EQ, command));
    }
    const auto server = static_cast<scmp_datum_t>(getppid());
    for (const int call : {SCMP_SYS(kill), SCMP_SYS(tkill), SCMP_SYS(tgkill),
                           SCMP_SYS(rt_sigqueueinfo), SCMP_SYS(rt_tgsigqueueinfo)}) {
        forbid(call, SCMP_A0(SCMP_CMP_EQ, server));
    }
    // All threads, those of libraries, too.
    made = made && seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1) == 0 &&
           seccomp_load(filter) == 0;
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

Confinement confine(std::uint64_t addressSpaceBytes) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    if (addressSpaceBytes > 0 && !kSanitized) {
        // The soft limit: the importer, a child process, may set a larger one.
        rlimit space{};
        getrlimit(RLIMIT_AS, &space);
        space.rlim_cur = std::min<rlim_t>(addressSpaceBytes, space.rlim_max);
        setrlimit(RLIMIT_AS, &space);
    }
    const JailSupport possible = jailSupport();
    Confinement enforced{.landlock = separateFromOtherProcesses(), .systemCallFilter = false};
    enforced.systemCallFilter = prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && filterSystemCalls();
    if (enforced.landlock < possible.landlock ||
        (possible.systemCallFilter && !enforced.systemCallFilter)) {
        throw std::runtime_error("the render worker could not be confined");
    }
    if (enforced.landlock == 0) {
        logWarning({"this kernel has no landlock: renderers and importers are confined less"});
    }
    if (!enforced.systemCallFilter) {
        logWarning({"the render worker runs without a filter of system calls"});
    }
    return enforced;
}

}  // namespace clerestory
