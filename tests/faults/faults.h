// Fault injection: the n-th OpenGL call, or the n-th allocation of our own code, fails. A test
// program that links faults.cpp has these functions in place of the driver's and the library's.
#pragma once

#include <cstdint>

namespace clerestory::test {

enum class Fault { driverCall, allocation };

// From now on the n-th (from 1) fails, once. A driver's call that fails does nothing, returns 0 and
// leaves "out of memory" as the error, as the specification allows for any of them; an
// allocation throws std::bad_alloc. What a driver allocates within its calls is not ours and does
// not count.
void failAt(Fault fault, std::uint64_t n);
// From now on the driver says that the GPU was reset, or not.
void resetGpu(bool wasReset);
// Ends it. Whether it has happened.
bool endFault();
// The number of calls since failAt().
std::uint64_t counted(Fault fault);

}  // namespace clerestory::test
