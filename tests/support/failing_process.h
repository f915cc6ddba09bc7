// Fault injection into a process that a test started: memory that failing_process.cpp, preloaded
// into it, shares with the test.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace clerestory::test {

struct ProcessFaults {
    // The n-th allocation from now on fails once, in any code: program, library or
    // driver. 0: none.
    std::atomic<std::int64_t> failingAllocation{0};
    // The n-th allocation of the next process that starts fails once. 0: none.
    std::atomic<std::int64_t> failingFromStart{0};
    // Smaller allocations neither count nor fail.
    std::atomic<std::size_t> leastBytes{0};
    // The driver reports a GPU reset once to the process of this id. 0: none.
    std::atomic<std::int64_t> resetProcess{0};
};

// Names of environment variables: the file that holds a ProcessFaults, and in which processes it
// counts: those with that first word on their command line.
inline constexpr const char* kFaultsFile = "CLERESTORY_TEST_FAULTS";
inline constexpr const char* kFaultsRole = "CLERESTORY_TEST_FAULTS_ROLE";

}  // namespace clerestory::test
