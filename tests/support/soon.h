// Waiting for something that another thread or process is about to do.
//
//     ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 2; }));
#pragma once

#include <chrono>
#include <thread>

namespace clerestory::test {

// Whether the condition holds within 10 s and what its own calls take. It is not called again once
// it holds, since a call may be a request.
template <class Condition>
bool soon(Condition condition) {
    for (int i = 0; i < 2000; ++i) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return condition();
}

}  // namespace clerestory::test
