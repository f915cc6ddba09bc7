// Work on the rows of a picture, on all processors that this thread may use.
//
//     forEachBand(height, 8, [&](std::uint32_t first, std::uint32_t end) { ... });
#pragma once

#include <cstdint>
#include <functional>

namespace clerestory {

// Calls work(first, end) for bands of `rowsAtOnce` rows (the last may be shorter) that cover
// 0..rows, from several threads at the same time. work must not throw.
void forEachBand(std::uint32_t rows, std::uint32_t rowsAtOnce,
                 const std::function<void(std::uint32_t first, std::uint32_t end)>& work);

// Threads of each later call of this process, at least 1; 0: as many as there are processors.
void limitBandThreads(std::uint32_t threads);

}  // namespace clerestory
