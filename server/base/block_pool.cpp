#include "server/base/block_pool.h"

#include <sys/mman.h>
#include <unistd.h>

namespace clerestory {

constinit BlockPool shaderBlocks(32 << 10, 8192, GivenPages::returned);
constinit BlockPool commandBlocks(64 << 10, 2048, GivenPages::kept);

namespace {

constexpr std::uint64_t kLowerHalf = 0xffffffff;

std::uint64_t headWith(std::uint64_t before, std::uint32_t entry) {
    return ((before >> 32) + 1) << 32 | entry;
}

}  // namespace

void BlockPool::open() noexcept {
    if (region_ || stride_ % static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) != 0) return;
    const std::size_t bytes = stride_ * count_;
    void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                              MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) return;
    madvise(memory, bytes, MADV_NOHUGEPAGE);  // one would make many blocks resident
    region_ = static_cast<std::byte*>(memory);
}

std::uint32_t BlockPool::pop() noexcept {
    std::uint64_t head = head_;
    while (true) {
        const auto entry = static_cast<std::uint32_t>(head & kLowerHalf);
        if (entry == 0) return count_;
        if (head_.compare_exchange_weak(head, headWith(head, next_[entry - 1]))) return entry - 1;
    }
}

void BlockPool::push(std::uint32_t block) noexcept {
    std::uint64_t head = head_;
    do {
        next_[block] = static_cast<std::uint32_t>(head & kLowerHalf);
    } while (!head_.compare_exchange_weak(head, headWith(head, block + 1)));
}

void* BlockPool::take() noexcept {
    std::byte* const first = region_.load(std::memory_order_relaxed);
    if (!first) return nullptr;
    std::uint32_t block = pop();
    if (block == count_) {
        block = unused_;
        while (block < count_ && !unused_.compare_exchange_weak(block, block + 1)) {
        }
        if (block == count_) return nullptr;
    }
    ++taken_;
    return first + block * stride_;
}

bool BlockPool::owns(const void* memory) const noexcept {
    const std::byte* const first = region_.load(std::memory_order_relaxed);
    const auto* const at = static_cast<const std::byte*>(memory);
    return first && at >= first && at < first + stride_ * count_;
}

void BlockPool::give(void* block) noexcept {
    if (given_ == GivenPages::returned) madvise(block, stride_, MADV_DONTNEED);
    --taken_;
    push(static_cast<std::uint32_t>((static_cast<std::byte*>(block) - region_) / stride_));
}

void BlockPool::releasePages() noexcept {
    if (given_ == GivenPages::returned) return;
    // Taken out first, so that no other thread has one of them.
    std::uint32_t chain = 0;
    for (std::uint32_t block = pop(); block != count_; block = pop()) {
        madvise(region_ + block * stride_, stride_, MADV_DONTNEED);
        next_[block] = chain;
        chain = block + 1;
    }
    while (chain != 0) {
        const std::uint32_t block = chain - 1;
        chain = next_[block];
        push(block);
    }
}

}  // namespace clerestory
