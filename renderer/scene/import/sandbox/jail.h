// Confines a process that reads untrusted files: it can read files below one folder, compute, and
// write to descriptors that are already open.
#pragma once

#include <filesystem>

namespace clerestory {

// What this kernel can enforce.
struct JailSupport {
    int landlock = 0;               // ABI version for file access; 0: not available
    bool systemCallFilter = false;  // seccomp
};
JailSupport jailSupport();

// Confines this process and its future threads permanently. Only files below `folder` can be
// opened, for reading. System calls that are not needed for reading and computing fail with EPERM.
// Returns what is enforced; less than jailSupport() is a failure.
JailSupport enterJail(const std::filesystem::path& folder);

// From now on this thread and its future threads and children can neither trace processes outside,
// nor read their memory or take their descriptors, nor (ABI 6) send them signals. Call it before
// there are other threads. Returns the ABI version; 0: not enforced.
int separateFromOtherProcesses();

// Whether this build uses a sanitizer, which reserves terabytes of address space and makes
// additional system calls, and fails if either is limited.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace clerestory
