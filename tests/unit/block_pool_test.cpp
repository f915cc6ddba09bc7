// Pools of blocks of one size, and the program's allocator, which uses them; this test program is
// linked with it.
#include "server/base/block_pool.h"
#include "server/base/process.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <set>
#include <thread>
#include <vector>

namespace clerestory {
namespace {

constexpr std::size_t kBytes = 32 << 10;
constexpr std::uint32_t kCount = 100;
constexpr const char* kLargePages = "pages of this machine do not divide a block";

// Null if pages of this machine do not divide a block.
std::unique_ptr<BlockPool> openPool(Written written = Written::partly) {
    auto pool = std::make_unique<BlockPool>(kBytes, kCount, written);
    EXPECT_EQ(pool->take(), nullptr) << "it is not open";
    pool->open();
    void* const block = pool->take();
    if (!block) return nullptr;
    pool->give(block);
    return pool;
}

std::size_t residentPages(const BlockPool& pool, void* block) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    std::vector<unsigned char> pages(pool.blockBytes() / page);
    EXPECT_EQ(mincore(block, pool.blockBytes(), pages.data()), 0);
    return static_cast<std::size_t>(
        std::count_if(pages.begin(), pages.end(), [](unsigned char p) { return p & 1; }));
}

TEST(BlockPool, UntouchedPagesOfAUsedBlockTakeNoMemory) {
    const auto pool = openPool();
    if (!pool) GTEST_SKIP() << kLargePages;
    void* const block = pool->take();
    EXPECT_EQ(residentPages(*pool, block), 0u);
    std::memset(block, 1, pool->blockBytes());
    EXPECT_GT(residentPages(*pool, block), 1u);
    pool->give(block);
    pool->releasePages();
    ASSERT_EQ(pool->take(), block);
    *static_cast<char*>(block) = 1;
    EXPECT_EQ(residentPages(*pool, block), 1u);
    pool->give(block);
}

TEST(BlockPool, ABlockThatIsWrittenWholeHasItsPages) {
    const auto pool = openPool(Written::whole);
    if (!pool) GTEST_SKIP() << kLargePages;
    void* const block = pool->take();
    const std::size_t all = residentPages(*pool, block);
    if (all == 0) GTEST_SKIP() << "this system does not make pages resident (Linux 5.14)";
    EXPECT_EQ(all, pool->blockBytes() / static_cast<std::size_t>(sysconf(_SC_PAGESIZE)));
    pool->give(block);
    pool->releasePages();
    EXPECT_EQ(residentPages(*pool, block), 0u);
    ASSERT_EQ(pool->take(), block);
    EXPECT_EQ(residentPages(*pool, block), all);
    pool->give(block);
}

TEST(BlockPool, KeepsPagesUntilTheyAreReleased) {
    const auto pool = openPool();
    if (!pool) GTEST_SKIP() << kLargePages;
    std::vector<void*> given;
    for (int i = 0; i < 5; ++i) given.push_back(pool->take());
    void* const held = pool->take();
    std::memset(held, 1, pool->blockBytes());
    for (void* block : given) {
        std::memset(block, 1, pool->blockBytes());
        pool->give(block);
    }
    const std::size_t all = residentPages(*pool, held);
    for (void* block : given) EXPECT_EQ(residentPages(*pool, block), all);
    pool->releasePages();
    for (void* block : given) EXPECT_EQ(residentPages(*pool, block), 0u);
    EXPECT_EQ(residentPages(*pool, held), all) << "it is in use";
    std::set<void*> again;
    for (std::size_t i = 0; i < given.size(); ++i) again.insert(pool->take());
    EXPECT_EQ(again, std::set<void*>(given.begin(), given.end()));
}

TEST(BlockPool, BlocksAreDistinctAndLimited) {
    const auto pool = openPool();
    if (!pool) GTEST_SKIP() << kLargePages;
    std::set<void*> taken;
    while (void* const block = pool->take()) {
        ASSERT_TRUE(taken.insert(block).second);
        ASSERT_TRUE(pool->owns(block));
    }
    EXPECT_EQ(taken.size(), kCount);
    EXPECT_EQ(pool->takenBytes(), kCount * pool->blockBytes());
    EXPECT_FALSE(pool->owns(nullptr));
    EXPECT_FALSE(pool->owns(&taken));
    for (void* const block : taken) pool->give(block);
    EXPECT_EQ(pool->takenBytes(), 0u);
    EXPECT_TRUE(taken.contains(pool->take()));
}

// Each thread writes its number into the blocks that it holds, and finds it there later, while
// another one releases the pages of the rest.
TEST(BlockPool, ABlockBelongsToOneThreadAtATime) {
    const auto pool = openPool();
    if (!pool) GTEST_SKIP() << kLargePages;
    std::atomic<int> mixedUp = 0;
    std::vector<std::thread> threads;
    for (int number = 0; number < 8; ++number) {
        threads.emplace_back([&, number] {
            for (int round = 0; round < 500; ++round) {
                if (number == 0) pool->releasePages();
                std::vector<int*> held;
                for (int i = 0; i < 1 + (round + number) % 7; ++i) {
                    if (void* const block = pool->take()) held.push_back(static_cast<int*>(block));
                }
                for (int* block : held) *block = number;
                std::this_thread::yield();
                for (int* block : held) {
                    if (*block != number) ++mixedUp;
                    pool->give(block);
                }
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(mixedUp, 0);
    EXPECT_EQ(pool->takenBytes(), 0u);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

constexpr std::size_t kShader = (32 << 10) - 16, kCommands = (64 << 10) + 16;  // as Mesa asks

class Allocator : public testing::Test {
protected:
    void SetUp() override {
        if (!openPool()) GTEST_SKIP() << kLargePages;
        shaderBlocks.open();
        commandBlocks.open();
    }
};

TEST_F(Allocator, TakesBlocksOfTheirSizesFromThePools) {
    for (BlockPool* pool : {&shaderBlocks, &commandBlocks}) {
        const std::size_t size = pool == &shaderBlocks ? kShader : kCommands;
        const std::size_t before = pool->takenBytes();
        void* const block = std::malloc(size);
        EXPECT_TRUE(pool->owns(block));
        EXPECT_EQ(pool->takenBytes(), before + pool->blockBytes());
        EXPECT_GE(malloc_usable_size(block), size);
        std::memset(block, 1, size);
        errno = 7;
        std::free(block);
        EXPECT_EQ(errno, 7);
        EXPECT_EQ(pool->takenBytes(), before);
        auto* const zeros = static_cast<unsigned char*>(std::calloc(size / 8, 8));
        EXPECT_TRUE(pool->owns(zeros));
        EXPECT_TRUE(std::all_of(zeros, zeros + size, [](unsigned char byte) { return byte == 0; }));
        std::free(zeros);
    }
    for (const std::size_t other : {0, 1, 16 << 10, 48 << 10, 128 << 10, 8 << 20}) {
        void* const memory = std::malloc(other);
        EXPECT_FALSE(shaderBlocks.owns(memory) || commandBlocks.owns(memory)) << other;
        EXPECT_TRUE(!memory || malloc_usable_size(memory) >= other) << other;
        std::free(memory);
    }
    std::free(nullptr);
}

TEST_F(Allocator, MovesABlockThatChangesItsSize) {
    for (const std::size_t size :
         {std::size_t{100}, kShader + 8, kCommands, std::size_t{1} << 20}) {
        const std::size_t before = shaderBlocks.takenBytes();
        auto* const block = static_cast<unsigned char*>(std::malloc(kShader));
        ASSERT_TRUE(shaderBlocks.owns(block));
        for (std::size_t i = 0; i < kShader; ++i) block[i] = static_cast<unsigned char>(i % 251);
        auto* const moved = static_cast<unsigned char*>(std::realloc(block, size));
        ASSERT_NE(moved, nullptr);
        for (std::size_t i = 0; i < std::min(size, kShader); ++i)
            ASSERT_EQ(moved[i], i % 251) << size;
        std::free(moved);
        EXPECT_EQ(shaderBlocks.takenBytes(), before) << size;
    }
}

// Blocks of all sizes keep what is written into them, also where they move.
TEST_F(Allocator, LargeBlocksHaveTheirPages) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    for (const std::size_t size : {std::size_t{300} << 10, std::size_t{3} << 20, kMappedBlock,
                                   std::size_t{9} << 20, std::size_t{80} << 20}) {
        auto* block = static_cast<unsigned char*>(std::malloc(size));
        ASSERT_NE(block, nullptr);
        const std::size_t skipped = page - reinterpret_cast<std::uintptr_t>(block) % page;
        std::vector<unsigned char> pages((size - skipped) / page);
        ASSERT_EQ(mincore(block + skipped, pages.size() * page, pages.data()), 0);
        const auto resident =
            std::count_if(pages.begin(), pages.end(), [](unsigned char p) { return (p & 1) != 0; });
        if (size == std::size_t{80} << 20) {
            EXPECT_LT(resident, 600) << "it may be a reserve";
        } else if (resident > 0) {  // Linux 5.14
            EXPECT_EQ(resident, static_cast<std::ptrdiff_t>(pages.size())) << size;
        }
        for (std::size_t i = 0; i < size; i += 1000) block[i] = static_cast<unsigned char>(i % 251);
        block = static_cast<unsigned char*>(std::realloc(block, 2 * size));
        ASSERT_NE(block, nullptr);
        for (std::size_t i = 0; i < size; i += 1000) ASSERT_EQ(block[i], i % 251) << size;
        std::free(block);
        auto* const zeros = static_cast<unsigned char*>(std::calloc(size, 1));
        EXPECT_TRUE(std::all_of(zeros, zeros + size, [](unsigned char byte) { return byte == 0; }));
        std::free(zeros);
    }
    for (const std::size_t alignment : {std::size_t{64}, std::size_t{8} << 20}) {
        void* const block = std::aligned_alloc(alignment, std::size_t{16} << 20);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % alignment, 0u);
        std::free(block);
    }
}

#endif

}  // namespace
}  // namespace clerestory
