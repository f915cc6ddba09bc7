#include "image/bands.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace clerestory {
namespace {

std::atomic<std::uint32_t> threadLimit{0};

// Those that this thread may use; std::thread::hardware_concurrency() counts others, too.
std::uint32_t processors() {
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return 1;
    return static_cast<std::uint32_t>(std::max(1, CPU_COUNT(&allowed)));
}

}  // namespace

void forEachBand(std::uint32_t rows, std::uint32_t rowsAtOnce,
                 const std::function<void(std::uint32_t first, std::uint32_t end)>& work) {
    std::atomic<std::uint32_t> next{0};
    const auto loop = [&] {
        for (std::uint32_t first; (first = next.fetch_add(rowsAtOnce)) < rows;) {
            work(first, std::min(first + rowsAtOnce, rows));
        }
    };
    std::vector<std::jthread> others;
    const std::uint32_t allowed = threadLimit > 0 ? threadLimit.load() : processors();
    const std::uint32_t threads = std::min(allowed, rows / rowsAtOnce + 1);
    for (std::uint32_t i = 1; i < threads; ++i) others.emplace_back(loop);
    loop();
}

void limitBandThreads(std::uint32_t threads) {
    threadLimit = threads;
}

}  // namespace clerestory
