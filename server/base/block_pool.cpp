#include "server/base/block_pool.h"

#include "server/base/pages.h"

#include <sys/mman.h>
#include <unistd.h>

namespace clerestory {

constinit BlockPool shaderBlocks(32 << 10, 8192, Written::partly);
constinit BlockPool commandBlocks(64 << 10, 2048, Written::whole);

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
    // A huge page makes all of its blocks resident.
    madvise(memory, bytes, written_ == Written::whole ? MADV_HUGEPAGE : MADV_NOHUGEPAGE);
    region_ = static_cast<std::byte*>(memory);
}

std::uint32_t BlockPool::pop(Stack& stack) noexcept {
    std::uint64_t head = stack;
    while (true) {
        const auto entry = static_cast<std::uint32_t>(head & kLowerHalf);
        if (entry == 0) return count_;
        if (stack.compare_exchange_weak(head, headWith(head, next_[entry - 1]))) return entry - 1;
    }
}

void BlockPool::push(Stack& stack, std::uint32_t block) noexcept {
    std::uint64_t head = stack;
    do {
        next_[block] = static_cast<std::uint32_t>(head & kLowerHalf);
    } while (!stack.compare_exchange_weak(head, headWith(head, block + 1)));
}

std::uint32_t BlockPool::popNew() noexcept {
    std::uint32_t block = unused_;
    while (block < count_ && !unused_.compare_exchange_weak(block, block + 1)) {
    }
    return block;
}

void* BlockPool::take() noexcept {
    std::byte* const first = region_.load(std::memory_order_relaxed);
    if (!first) return nullptr;
    std::uint32_t block = pop(given_);
    if (block == count_) {
        block = pop(released_);
        if (block == count_) block = popNew();
        if (block == count_) return nullptr;
        if (written_ == Written::whole) makeResident(first + block * stride_, stride_);
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
    --taken_;
    push(given_, static_cast<std::uint32_t>((static_cast<std::byte*>(block) - region_) / stride_));
}

void BlockPool::releasePages() noexcept {
    for (std::uint32_t block = pop(given_); block != count_; block = pop(given_)) {
        madvise(region_ + block * stride_, stride_, MADV_DONTNEED);
        push(released_, block);
    }
}

}  // namespace clerestory
