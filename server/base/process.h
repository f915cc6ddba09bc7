// This process: the clock for its deadlines and durations, the version and build id of its program,
// and its memory.
#pragma once

#include <chrono>
#include <string>

namespace clerestory {

using Clock = std::chrono::steady_clock;

inline double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::string versionText();  // "0.1.0"

// The GNU build id of the running program in hex, a hash of its code; "none" if the linker did not
// write one.
std::string buildId();

double residentBytes();  // in RAM; 0 if unknown
// Allocated by the program and its libraries, without the free memory of the allocator.
double allocatedBytes();

// Freed blocks of at least so many bytes go back to the system; see keepHeapsSmall().
constexpr std::size_t kMappedBlock = 4 << 20;

// For a process that draws. Freed blocks of kMappedBlock and more, and as much at the end of a
// heap, go back to the system at once; by default the C library keeps up to 32 and 64 MB of them,
// in every heap, depending on what was freed before. The blocks of Mesa get memory of their own;
// see BlockPool.
void keepHeapsSmall();

// Returns the free memory of the allocator to the system, and the pages of the shader compiler's
// code, which are read again from its file on demand.
void releaseUnusedMemory();

}  // namespace clerestory
