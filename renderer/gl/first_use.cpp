#include "gl/first_use.h"

#include <chrono>

namespace clerestory::gl {
namespace {

std::int64_t nanoseconds() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

FirstUse::Timed::Timed(FirstUse& use) : use_(use), begin_(nanoseconds()) {
    if (use_.whenCompiling) use_.whenCompiling(true);
}

FirstUse::Timed::~Timed() {
    use_.counters_.milliseconds += 1e-6 * static_cast<double>(nanoseconds() - begin_);
    if (use_.whenCompiling) use_.whenCompiling(false);
}

}  // namespace clerestory::gl
