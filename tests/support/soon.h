// Waiting for something that another thread or process is about to do.
//
//     ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 2; }));
#pragma once

#include <chrono>
#include <thread>

namespace clerestory::test {

// For what takes long on a busy machine: shaders are compiled, a renderer starts.
inline constexpr std::chrono::minutes kPatience(5);

// Whether the condition holds within the limit and what its own calls take. It is not called again
// once it holds, since a call may be a request.
template <class Condition>
bool within(std::chrono::milliseconds limit, Condition condition) {
    constexpr std::chrono::milliseconds kPause(5);
    for (; limit.count() > 0; limit -= kPause) {
        if (condition()) return true;
        std::this_thread::sleep_for(kPause);
    }
    return condition();
}

template <class Condition>
bool soon(Condition condition) {
    return within(std::chrono::seconds(10), condition);
}

}  // namespace clerestory::test
