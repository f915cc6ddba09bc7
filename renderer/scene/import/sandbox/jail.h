// What a process that reads strangers' files may still do: read below one folder, compute, and
// write into what it has open already.
#pragma once

#include <filesystem>

namespace clerestory {

// What the kernel here can enforce; 0 and false where it cannot.
struct JailSupport {
    int landlock = 0;               // its ABI: files
    bool systemCallFilter = false;  // seccomp: everything else
};
JailSupport jailSupport();

// Confines this process and all its threads to come, for good. Files: only those below `folder` can
// be opened, and only for reading. System calls: those that reading and computing take; others fail
// with "operation not permitted". Best effort: what the kernel lacks is left out, and told.
JailSupport enterJail(const std::filesystem::path& folder);

}  // namespace clerestory
