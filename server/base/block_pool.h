// Blocks of one size for the program's allocator, in memory of their own.
//
// Mesa allocates two sizes by the thousand: 32 KB for shaders, one block for each size of
// instruction, of which most stay almost empty; and 64 KB for the commands of a picture, all of
// which are freed after it. In the heap of the C library the former get memory that was used
// before, so that all of their pages are resident, and the latter leave holes and a long end. See
// docs/architecture/workers.md for what the pools save.
//
//     shaderBlocks.open();  // at the start of a worker; before that and elsewhere it is empty
//     if (void* block = shaderBlocks.take()) ...;
//     if (shaderBlocks.owns(block)) shaderBlocks.give(block);
//
// Safe to use from several threads, before main() and in a forked child: there are no locks, no
// other allocations and no constructors at run time.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace clerestory {

// What those who take a block write: a part of it, or all of it.
enum class Written { partly, whole };

class BlockPool {
public:
    static constexpr std::uint32_t kMaxCount = 8192;

    // `count` blocks, at most kMaxCount, for allocations from 128 bytes less than `bytes`, a
    // multiple of 4096, to 64 more: with and without headers.
    constexpr BlockPool(std::size_t bytes, std::uint32_t count, Written written)
        : bytes_(bytes), stride_(bytes + 4096), count_(count), written_(written) {}
    BlockPool(const BlockPool&) = delete;
    BlockPool& operator=(const BlockPool&) = delete;

    bool fits(std::size_t bytes) const noexcept {
        return bytes + 128 >= bytes_ && bytes <= bytes_ + 64;
    }
    std::size_t blockBytes() const noexcept { return stride_; }

    // Reserves the address space. Without it, or if pages of this machine do not divide a block,
    // the pool stays empty.
    void open() noexcept;
    // blockBytes() at the start of a page, with any content; nullptr if all are taken.
    void* take() noexcept;
    bool owns(const void* memory) const noexcept;
    void give(void* block) noexcept;  // one that take() returned
    // Returns the pages of blocks that were given back to the system. Until then they stay for the
    // next blocks: compiling a shader takes and gives back hundreds.
    void releasePages() noexcept;

    std::size_t takenBytes() const noexcept { return taken_ * stride_; }

private:
    // A stack of blocks. The upper half of its head counts changes, so that a thread notices when
    // others have removed and returned the same block; the lower half and each entry of next_ are
    // one more than a block's number, or zero at the end.
    using Stack = std::atomic<std::uint64_t>;
    std::uint32_t pop(Stack& stack) noexcept;
    void push(Stack& stack, std::uint32_t block) noexcept;
    std::uint32_t popNew() noexcept;

    const std::size_t bytes_, stride_;
    const std::uint32_t count_;
    const Written written_;
    std::atomic<std::byte*> region_{nullptr};
    std::atomic<std::uint32_t> unused_{0};  // the first block that was never taken
    std::atomic<std::size_t> taken_{0};
    Stack given_{0}, released_{0};  // blocks that were given back: with their pages, without
    std::array<std::atomic<std::uint32_t>, kMaxCount> next_{};
};

// Those of this process.
extern BlockPool shaderBlocks, commandBlocks;

}  // namespace clerestory
