// How many answers may be sent piece by piece at once: each holds a connection's thread for as long
// as it lasts. Thread-safe.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>

namespace clerestory {

class Streams {
public:
    explicit Streams(std::size_t most) : count_(std::make_shared<Count>()), most_(most) {}

    // Held for as long as the answer is sent. Throws RequestError 503 when there is none.
    std::shared_ptr<void> take();

private:
    struct Count {
        std::mutex mutex;
        std::size_t taken = 0;
    };
    std::shared_ptr<Count> count_;
    std::size_t most_;
};

}  // namespace clerestory
