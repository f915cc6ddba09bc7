// G5, M2: GPU resets, and allocation failures one at a time in the renderer's process, with its
// driver and all libraries, and in the server's. CLERESTORY_FAULTS=all injects every fault;
// CLERESTORY_FAULTS=N one in N.
#include "scene/import/sandbox/jail.h"
#include "tests/bench/process_tree.h"
#include "tests/support/failing_process.h"
#include "tests/support/plain_effects.h"
#include "tests/support/raw_client.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

namespace clerestory::test {
namespace {

// "first 500 allocation points of a request" (reliability.md, M2).
constexpr std::int64_t kPoints = 500;
// Allocations of a renderer until it stands, measured: 21,240.
constexpr std::int64_t kStart = 21'240;

std::int64_t stride(std::int64_t usually) {
    const char* wanted = std::getenv("CLERESTORY_FAULTS");
    if (!wanted) return usually;
    return std::string_view(wanted) == "all" ? 1 : std::max(1l, std::strtol(wanted, nullptr, 10));
}

// The requested faults, in a file that the processes map too.
class SharedFaults {
public:
    explicit SharedFaults(const char* role) {
        const std::filesystem::path file = std::filesystem::path(CLERESTORY_TEST_OUTPUT) / role;
        std::filesystem::create_directories(file.parent_path());
        const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        EXPECT_EQ(::ftruncate(fd, sizeof(ProcessFaults)), 0);
        void* memory =
            ::mmap(nullptr, sizeof(ProcessFaults), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        ::close(fd);
        faults_ = new (memory) ProcessFaults;
        // The servers that are started from here on have these.
        ::setenv(kFaultsFile, file.c_str(), 1);
        ::setenv(kFaultsRole, role, 1);
    }
    ~SharedFaults() { ::munmap(faults_, sizeof(ProcessFaults)); }
    SharedFaults(const SharedFaults&) = delete;
    SharedFaults& operator=(const SharedFaults&) = delete;
    ProcessFaults* operator->() { return faults_; }

private:
    ProcessFaults* faults_ = nullptr;
};

void preload() {
    ::setenv("LD_PRELOAD", CLERESTORY_FAILING_PROCESS, 1);
}

class ProcessFault : public testing::Test {
protected:
    void SetUp() override {
        if (kSanitized) GTEST_SKIP() << "a sanitizer has an allocator of its own";
    }
};

std::string frame() {
    return post(
        "/v1/frames",
        R"({"width": 96, "height": 64, "output": {"format": "png"}, )" + kPlainEffects + "}",
        "Connection: close\r\n");
}

std::string numberOf(const std::string& answer) {
    return headerOf(answer, "Clerestory-Worker");
}

// After a failure: the frame, once a renderer is available again.
std::string pictureSoon(int port) {
    std::string answer;
    soon([&] {
        answer = ask(port, frame(), 60.0);
        return statusOf(answer) == 200;
    });
    return std::string(bodyOf(answer));
}

bool standbyWaits(int port) {
    return within(std::chrono::seconds(30),
                  [&] { return metric(port, "clerestory_workers{role=\"warmStandby\"}") == 1; });
}

// Never less than 1, which kill() would take for many processes.
pid_t answeringWorker(const ServerProcess& server) {
    std::vector<pid_t> workers;
    const bool areTwo = soon([&] {  // and a standby, or one that starts
        workers = bench::workersOf(server.id());
        return workers.size() > 1;
    });
    if (!areTwo) throw std::runtime_error("no two workers");
    return workers.front();
}

TEST_F(ProcessFault, AGpuResetEndsTheRendererAndLosesNothing) {
    SharedFaults faults("worker");
    const ServerProcess server({"--scene", "six-walls"}, preload);
    ASSERT_TRUE(server.waitUntilReady());
    const std::string renderer = ask(server.port(), get("/v1/renderer"));
    if (renderer.find("\"tellsOfResets\":true") == std::string::npos) {
        GTEST_SKIP() << "this driver does not report resets";
    }
    const std::string before = ask(server.port(), frame(), 60.0);
    ASSERT_EQ(statusOf(before), 200) << before;
    std::string number = numberOf(before);
    for (int i = 0; i < 5; ++i) {
        ASSERT_TRUE(standbyWaits(server.port()));
        faults->resetProcess = answeringWorker(server);
        const std::string answer = ask(server.port(), frame(), 60.0);
        EXPECT_EQ(statusOf(answer), 200) << answer.substr(0, 400);
        EXPECT_TRUE(bodyOf(answer) == bodyOf(before));
        EXPECT_NE(numberOf(answer), number) << "another renderer drew it";
        number = numberOf(answer);
    }
}

// The outcome of a frame for each allocation that failed.
std::map<int, int> failEach(const ServerProcess& server, SharedFaults& faults, std::int64_t step) {
    const std::string right = pictureSoon(server.port());
    EXPECT_FALSE(right.empty());
    std::map<int, int> outcomes;
    for (std::int64_t n = 1; n <= kPoints; n += step) {
        EXPECT_TRUE(standbyWaits(server.port()));  // the failure is not for one that starts
        faults->failingAllocation = n;
        const std::string answer = ask(server.port(), frame(), 60.0);
        faults->failingAllocation = 0;
        const int status = statusOf(answer);
        ++outcomes[status];
        if (status == 200) {
            EXPECT_TRUE(bodyOf(answer) == right) << "allocation " << n;
        }
        EXPECT_EQ(::kill(server.id(), 0), 0) << "allocation " << n;
        EXPECT_TRUE(pictureSoon(server.port()) == right) << "after allocation " << n;
        if (testing::Test::HasFailure()) break;
    }
    return outcomes;
}

void tell(const char* where, const std::map<int, int>& outcomes) {
    std::printf("allocations that failed in %s:", where);
    for (const auto& [status, count] : outcomes) {
        std::printf(" %d x %s", count, status == 0 ? "no answer" : std::to_string(status).c_str());
    }
    std::printf("\n");
}

TEST_F(ProcessFault, AllocationFailuresInARendererAreHandled) {
    SharedFaults faults("worker");
    // A driver that waits for ever for what it could not make is a hang (G2).
    const ServerProcess server({"--scene", "six-walls", "--hang", "5"}, preload);
    ASSERT_TRUE(server.waitUntilReady());
    const std::map<int, int> outcomes = failEach(server, faults, stride(97));
    for (const auto& [status, count] : outcomes) {
        EXPECT_EQ(status, 200) << "the standby answers what the renderer could not";
    }
    tell("the renderer's process", outcomes);
}

// The response of the next renderer if the n-th allocation of at least this many bytes fails while
// it starts.
void failStart(const ServerProcess& server, SharedFaults& faults, const std::string& right,
               std::int64_t n, std::size_t leastBytes) {
    ASSERT_TRUE(standbyWaits(server.port()));
    faults->leastBytes = leastBytes;
    faults->failingFromStart = n;
    ::kill(answeringWorker(server), SIGKILL);  // the standby answers, and the next one starts
    ASSERT_TRUE(within(std::chrono::seconds(30), [&] { return faults->failingFromStart == 0; }))
        << "it never started";
    ASSERT_TRUE(standbyWaits(server.port()));
    ::kill(answeringWorker(server), SIGKILL);
    EXPECT_TRUE(pictureSoon(server.port()) == right) << "after allocation " << n << " of a start";
}

// A standby that could not load its scene once would say so for ever, when its turn comes.
TEST_F(ProcessFault, AllocationFailuresInAStartingRendererAreHandled) {
    SharedFaults faults("worker");
    const ServerProcess server({"--scene", "six-walls"}, preload);
    ASSERT_TRUE(server.waitUntilReady());
    const std::string right = pictureSoon(server.port());
    ASSERT_FALSE(right.empty());
    for (std::int64_t n = 1; n <= kStart && !HasFailure(); n += stride(3001)) {
        failStart(server, faults, right, n, 0);
    }
}

// No renderer ends for these, so that it has to try again.
TEST_F(ProcessFault, ASceneIsLoadedAgainAfterMemoryWasExhausted) {
    SharedFaults faults("worker");
    const ServerProcess server({"--scene", "teapots"}, preload);
    ASSERT_TRUE(server.waitUntilReady());
    const std::string right = pictureSoon(server.port());
    ASSERT_FALSE(right.empty());
    for (std::int64_t n = 1; n <= 3 && !HasFailure(); ++n) {
        failStart(server, faults, right, n, 1 << 20);
    }
}

// Here the connection may be what it costs.
TEST_F(ProcessFault, AllocationFailuresInTheServerAreHandled) {
    SharedFaults faults("serve");
    const ServerProcess server({"--scene", "six-walls"}, preload);
    ASSERT_TRUE(server.waitUntilReady());
    tell("the server's process", failEach(server, faults, stride(7)));
}

}  // namespace
}  // namespace clerestory::test
