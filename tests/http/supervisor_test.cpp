// Workers that end while they work, any number of times: this program acts as the worker, and
// crashes or stops on command.
#include "server/worker/supervisor.h"
#include "server/worker/messages.h"
#include "server/worker/worker.h"

#include "server/base/problem.h"
#include "tests/support/soon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>

#include <sys/wait.h>
#include <unistd.h>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;

// ---- the worker that this program plays ----------------------------------------------------

void beatFor(MessagePipe& pipe, std::chrono::milliseconds time) {
    for (const auto end = Clock::now() + time; Clock::now() < end;) {
        pipe.send({.kind = MessageKind::alive});
        std::this_thread::sleep_for(10ms);
    }
}

// Ends the process in a piece of background work, unless that is left out.
void work(MessagePipe& pipe, const std::vector<std::string>& leftOut) {
    const std::string name = "the light of a scene";
    if (std::find(leftOut.begin(), leftOut.end(), name) != leftOut.end()) return;
    pipe.send({.kind = MessageKind::workBegins, .id = 1, .bytes = "other work"});
    pipe.send({.kind = MessageKind::workEnds, .id = 1});
    pipe.send({.kind = MessageKind::workBegins, .id = 2, .bytes = name});
    std::abort();
}

int playWorker(int argc, char** argv) {
    MessagePipe pipe(kWorkerSocket);
    const std::vector<std::string> leftOut = unpackedTexts(pipe.receive()->bytes);
    if (argc > 2 && std::strcmp(argv[2], "unable") == 0) {
        pipe.send({.kind = MessageKind::failed, .bytes = "no driver here"});
        return 2;
    }
    if (argc > 2 && std::strcmp(argv[2], "never ready") == 0) beatFor(pipe, 1h);
    pipe.send({.kind = MessageKind::ready});
    // Before it is warm, so that no standby starts meanwhile.
    if (argc > 2 && std::strcmp(argv[2], "works") == 0) work(pipe, leftOut);
    pipe.send({.kind = MessageKind::warm});
    std::thread([&pipe] { beatFor(pipe, 1h); }).detach();
    std::set<std::uint64_t> cancelled;
    std::mutex mutex;
    while (auto message = pipe.receive()) {
        if (message->kind == MessageKind::role) {
            if (argc > 2 && std::strchr(argv[2], '/'))
                std::ofstream(argv[2], std::ios::app) << getpid() << ' ' << message->id << '\n';
            continue;
        }
        if (message->kind == MessageKind::cancel) {
            const std::lock_guard lock(mutex);
            cancelled.insert(message->id);
            continue;
        }
        std::thread([&, id = message->id, call = unpackedCall(message->bytes)] {
            const std::string& word = call.body;
            if (word == "crash") std::abort();
            if (word == "stop") raise(SIGSTOP);
            if (word == "hang") {  // after its answer, as a frame that is over its deadline
                pipe.send({.kind = MessageKind::answer,
                           .id = id,
                           .bytes = packed(Answer{.status = 504, .body = "late"})});
                std::this_thread::sleep_for(100ms);
                pipe.send({.kind = MessageKind::hangs, .id = id});
                std::_Exit(3);
            }
            if (word.starts_with("once ")) {  // crashes the first worker that receives it
                const std::string mark = word.substr(5);
                if (access(mark.c_str(), F_OK) != 0) {
                    std::ofstream(mark) << "x";
                    std::abort();
                }
            }
            if (word == "nonsense") {
                pipe.send({.kind = MessageKind::answer, .id = id, .bytes = "?"});
                return;
            }
            if (word == "until cancelled") {
                for (;; std::this_thread::sleep_for(1ms)) {
                    const std::lock_guard lock(mutex);
                    if (cancelled.contains(id)) break;
                }
            }
            // "not ID MARK": worker ID appends to the file MARK and does not answer.
            if (word.starts_with("not " + std::to_string(getpid()) + " ")) {
                std::ofstream(word.substr(word.rfind(' ') + 1), std::ios::app) << "x";
                return;
            }
            if (word == "slow") std::this_thread::sleep_for(100ms);
            pipe.send({.kind = MessageKind::answer,
                       .id = id,
                       .bytes = packed(Answer{.body = word + " by " + std::to_string(getpid())})});
        }).detach();
    }
    std::_Exit(0);
}

// ---- the tests -----------------------------------------------------------------------------

SupervisorOptions options(const char* word = "able", bool standby = true) {
    return {.program = {.file = {}, .arguments = {word}, .silence = 500ms},
            .standby = standby,
            .standbyIdle = 0ms,
            .calm = 0ms};
}

Call callWith(const std::string& body) {
    return {.method = "POST", .path = "/v1/frames", .body = body, .arrived = Clock::now()};
}

std::string refusalOf(Supervisor& supervisor, const std::string& body) {
    try {
        return "answered: " + supervisor.ask(callWith(body)).body;
    } catch (const RequestError& error) {
        return std::string(nameOf(error.problem().code));
    }
}

void awaitBoth(const Supervisor& supervisor) {
    ASSERT_TRUE(within(30s, [&] { return supervisor.processes().second != 0; }));
}

std::string contentOf(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::string freshMark(const char* name) {
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    const std::string mark = std::string(CLERESTORY_TEST_OUTPUT) + "/" + name;
    std::remove(mark.c_str());
    return mark;
}

TEST(ExclusiveGate, ExclusiveCallsRunAloneAndAreNotStarved) {
    ExclusiveGate gate;
    std::atomic<int> inside{0};
    std::atomic<bool> ending{false}, wasAlone{false};
    std::vector<std::thread> crowd;
    for (int i = 0; i < 8; ++i) {
        crowd.emplace_back([&] {
            while (!ending) {
                const ExclusiveGate::Entry entry = gate.enter();
                ++inside;
                std::this_thread::sleep_for(1ms);
                --inside;
            }
        });
    }
    {
        std::this_thread::sleep_for(20ms);
        const ExclusiveGate::Entry entry = gate.enterAlone();
        wasAlone = inside == 0;
        std::this_thread::sleep_for(20ms);
        wasAlone = wasAlone && inside == 0;
    }
    ending = true;
    for (std::thread& one : crowd) one.join();
    EXPECT_TRUE(wasAlone);
}

TEST(Supervisor, CallsAreAnsweredByTheWorker) {
    Supervisor supervisor(options());
    const std::string answer = supervisor.ask(callWith("hello")).body;
    EXPECT_EQ(answer, "hello by " + std::to_string(supervisor.processes().first));
}

TEST(Supervisor, AFailedStartIsExplained) {
    try {
        Supervisor supervisor(options("unable"));
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "no driver here");
    }
}

// A13 of the catalogue of attacks.
TEST(Supervisor, AWorkerThatLivesAndIsNeverReadyIsGivenUp) {
    SupervisorOptions never = options("never ready");
    never.program.start = 700ms;  // longer than the silence
    try {
        const Supervisor supervisor(never);
        ADD_FAILURE() << "it started";
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("was not ready"));
    }
}

// The standby releases memory while it has this role.
TEST(Supervisor, WorkersKnowTheirRole) {
    const std::string roles = freshMark("roles");
    const auto awaitLine = [&](const std::string& line) {
        EXPECT_TRUE(within(30s, [&] { return contentOf(roles).find(line) != std::string::npos; }))
            << line << " is not in " << contentOf(roles);
    };
    Supervisor supervisor(options(roles.c_str()));
    awaitBoth(supervisor);
    const std::string second = std::to_string(supervisor.processes().second);
    awaitLine(second + " 1\n");
    EXPECT_EQ(contentOf(roles), second + " 1\n") << "the first draws from the start";
    refusalOf(supervisor, "once " + freshMark("crash of the first"));
    awaitBoth(supervisor);
    const std::string third = std::to_string(supervisor.processes().second);
    EXPECT_EQ(std::to_string(supervisor.processes().first), second);
    awaitLine(second + " 0\n");
    awaitLine(third + " 1\n");
}

TEST(Supervisor, TheStandbyAnswersPendingCalls) {
    Supervisor supervisor(options());
    awaitBoth(supervisor);
    const auto [first, second] = supervisor.processes();
    const std::string mark = freshMark("pending-calls");
    const std::string word = "not " + std::to_string(first) + " " + mark;
    std::vector<std::future<std::string>> answers;
    for (int i = 0; i < 20; ++i) {
        answers.push_back(
            std::async(std::launch::async, [&] { return supervisor.ask(callWith(word)).body; }));
    }
    const auto pending = [&] {
        std::error_code missing;
        const auto size = std::filesystem::file_size(mark, missing);
        return missing ? 0 : size;
    };
    ASSERT_TRUE(within(30s, [&] { return pending() == 20; })) << pending();
    kill(first, SIGKILL);
    for (auto& answer : answers) EXPECT_EQ(answer.get(), word + " by " + std::to_string(second));
    awaitBoth(supervisor);
    EXPECT_EQ(supervisor.processes().first, second);
    EXPECT_EQ(supervisor.counters().ended, 1u);
    EXPECT_LE(supervisor.counters().repeated, 20u);
    EXPECT_GT(supervisor.counters().repeated, 0u);
}

TEST(Supervisor, TheFirstStandbyWaitsForTheFirstFrames) {
    SupervisorOptions patient = options();
    patient.standbyIdle = 500ms;
    patient.standbyDelayLimit = 1h;
    Supervisor supervisor(patient);
    Call frame = callWith("until cancelled");
    frame.cancellation = std::make_shared<CancellationToken>();
    auto answer = std::async(std::launch::async, [&] { return supervisor.ask(frame).body; });
    std::this_thread::sleep_for(700ms);
    EXPECT_EQ(supervisor.processes().second, 0) << "a frame is being drawn";
    frame.cancellation->cancel();
    answer.get();
    std::atomic<bool> ending{false};
    std::thread health([&] {
        const Call ping{.method = "GET", .path = "/metrics", .body = "hello"};
        for (; !ending; std::this_thread::sleep_for(5ms)) supervisor.ask(ping);
    });
    awaitBoth(supervisor);
    ending = true;
    health.join();
}

TEST(Supervisor, TheFirstStandbyDoesNotWaitForEver) {
    SupervisorOptions bounded = options();
    bounded.standbyIdle = 1h;
    bounded.standbyDelayLimit = 100ms;
    Supervisor supervisor(bounded);
    awaitBoth(supervisor);
}

TEST(Supervisor, WithoutAStandbyANewWorkerAnswers) {
    Supervisor supervisor(options("able", false));
    const std::string mark = freshMark("crashed-once");
    EXPECT_THAT(supervisor.ask(callWith("once " + mark)).body, testing::HasSubstr("once"));
    EXPECT_EQ(supervisor.processes().second, 0);
}

TEST(Supervisor, AStoppedWorkerIsReplaced) {
    Supervisor supervisor(options());
    awaitBoth(supervisor);
    kill(supervisor.processes().first, SIGSTOP);
    const auto stopped = Clock::now();
    EXPECT_THAT(supervisor.ask(callWith("hello")).body, testing::StartsWith("hello by "));
    std::printf("answered %.0f ms after the worker stopped, of 500 ms of silence\n",
                millisecondsSince(stopped));
    EXPECT_EQ(supervisor.counters().silent, 1u);
}

// As after a suspended laptop, or a paused virtual machine.
TEST(Supervisor, SuspendingTheMachineEndsNoWorker) {
    Supervisor supervisor(options());
    awaitBoth(supervisor);
    const auto [first, second] = supervisor.processes();
    const pid_t all[] = {first, second, getpid()};
    const pid_t sleep = fork();
    if (sleep == 0) {
        for (const pid_t id : all) kill(id, SIGSTOP);
        usleep(1'000'000);  // twice as long as a worker may be silent
        for (const pid_t id : all) kill(id, SIGCONT);
        _exit(0);
    }
    waitpid(sleep, nullptr, 0);
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(supervisor.counters().silent, 0u);
    EXPECT_EQ(supervisor.processes(), std::pair(first, second));
    EXPECT_THAT(supervisor.ask(callWith("hello")).body, testing::StartsWith("hello by "));
}

TEST(Supervisor, AnIdleWorkerThatEndsIsReplaced) {
    Supervisor supervisor(options());
    awaitBoth(supervisor);
    const auto [first, second] = supervisor.processes();
    kill(first, SIGKILL);
    EXPECT_TRUE(soon([&, standby = second] { return supervisor.processes().first == standby; }));
    awaitBoth(supervisor);
}

TEST(Supervisor, BackgroundWorkThatEndsWorkersIsLeftOut) {
    SupervisorOptions patient = options("works");
    patient.program.silence = 60s;  // a slow start ends no worker
    Supervisor supervisor(patient);
    EXPECT_TRUE(
        within(60s, [&] { return refusalOf(supervisor, "hello").starts_with("answered"); }));
    awaitBoth(supervisor);
    EXPECT_EQ(supervisor.counters().started, EndedWork::kMaxEnds + 2u);
}

TEST(EndedWork, IsLeftOutForLongerEachTime) {
    EndedWork work;
    const Clock::time_point start{};
    using testing::ElementsAre;
    using testing::IsEmpty;
    for (int i = 0; i < EndedWork::kMaxEnds; ++i) {
        EXPECT_THAT(work.leftOut(start), IsEmpty());
        work.add("a", start);
    }
    work.add("b", start);
    EXPECT_THAT(work.leftOut(start), ElementsAre("a"));
    EXPECT_THAT(work.leftOut(start + 59min), ElementsAre("a"));
    EXPECT_THAT(work.leftOut(start + 61min), IsEmpty());
    work.add("a", start + 61min);
    EXPECT_THAT(work.leftOut(start + 180min), ElementsAre("a"));
    EXPECT_THAT(work.leftOut(start + 182min), IsEmpty());
    for (int i = 0; i < 100; ++i) work.add("a", start + 182min);
    EXPECT_THAT(work.leftOut(start + 182min + 25h), IsEmpty());
    // No more than so many are kept: the oldest is removed.
    for (std::size_t i = 0; i < EndedWork::kMax; ++i) {
        for (int end = 0; end < EndedWork::kMaxEnds; ++end)
            work.add(std::to_string(i), start + 200h);
    }
    EXPECT_EQ(work.leftOut(start + 200h).size(), EndedWork::kMax);
}

TEST(Supervisor, CallsThatCrashEveryWorkerAreQuarantined) {
    Supervisor supervisor(options());
    std::vector<std::future<std::string>> others;
    for (int i = 0; i < 10; ++i) {
        others.push_back(std::async(std::launch::async, [&, i] {
            return refusalOf(supervisor, "slow").substr(0, 9) + std::to_string(i);
        }));
    }
    std::this_thread::sleep_for(20ms);
    EXPECT_EQ(refusalOf(supervisor, "crash"), "quarantined");
    for (int i = 0; i < 10; ++i) EXPECT_EQ(others[i].get(), "answered:" + std::to_string(i));
    const std::uint64_t ended = supervisor.counters().ended;
    EXPECT_EQ(refusalOf(supervisor, "crash"), "quarantined");
    EXPECT_EQ(supervisor.counters().ended, ended) << "no worker is spent on it again";
    EXPECT_THAT(refusalOf(supervisor, "hello"), testing::StartsWith("answered: hello"));
}

TEST(Quarantine, LastsTenMinutesAndIsBounded) {
    Quarantine quarantine;
    const Clock::time_point now{};
    quarantine.add(1, now);
    EXPECT_TRUE(quarantine.contains(1, now + 10min - 1s));
    EXPECT_FALSE(quarantine.contains(1, now + 10min + 1s));
    EXPECT_FALSE(quarantine.contains(2, now));
    for (std::uint64_t i = 0; i < 2 * Quarantine::kMax; ++i) {
        quarantine.add(100 + i, now + std::chrono::milliseconds(i));
    }
    EXPECT_FALSE(quarantine.contains(1, now)) << "the oldest entries are removed";
    EXPECT_FALSE(quarantine.contains(100, now + 1s));
    EXPECT_TRUE(quarantine.contains(99 + 2 * Quarantine::kMax, now + 10s));
}

// A3 of the catalogue of attacks: the client had its 504 long before the watchdog ended the worker.
TEST(Supervisor, ARequestOnWhichTheRendererHangsAfterItsAnswerIsQuarantined) {
    Supervisor supervisor(options());
    awaitBoth(supervisor);
    EXPECT_EQ(supervisor.ask(callWith("hang")).body, "late");
    EXPECT_TRUE(soon([&] { return supervisor.counters().ended == 1; }));
    EXPECT_EQ(refusalOf(supervisor, "hang"), "quarantined");
    EXPECT_EQ(supervisor.counters().ended, 1u) << "it reached no worker";
    EXPECT_THAT(refusalOf(supervisor, "plain"), testing::StartsWith("answered"));
}

TEST(Supervisor, InvalidOutputEndsTheWorker) {
    Supervisor supervisor(options());
    EXPECT_EQ(refusalOf(supervisor, "nonsense"), "quarantined");
    EXPECT_THAT(refusalOf(supervisor, "hello"), testing::StartsWith("answered: hello"));
}

TEST(Supervisor, ADisconnectIsForwardedToTheWorker) {
    Supervisor supervisor(options());
    Call call = callWith("until cancelled");
    call.cancellation = std::make_shared<CancellationToken>();
    auto answer = std::async(std::launch::async, [&] { return supervisor.ask(call).body; });
    EXPECT_EQ(answer.wait_for(50ms), std::future_status::timeout);
    call.cancellation->cancel();
    EXPECT_THAT(answer.get(), testing::StartsWith("until cancelled"));
}

TEST(Supervisor, AHundredKillsLoseNoRequest) {
    Supervisor supervisor(options());
    std::atomic<bool> ending{false};
    std::atomic<int> answered{0}, lost{0};
    std::vector<std::thread> clients;
    for (int i = 0; i < 4; ++i) {
        clients.emplace_back([&, i] {
            for (int n = 0; !ending; ++n) {
                const std::string body = std::to_string(i) + "/" + std::to_string(n);
                try {
                    const bool right = supervisor.ask(callWith(body)).body.starts_with(body + " ");
                    ++(right ? answered : lost);
                } catch (const RequestError&) {
                    ++lost;
                }
            }
        });
    }
    // Some calls find only workers that are ending.
    for (int i = 0; i < 1000 && supervisor.counters().ended < 100; ++i) {
        awaitBoth(supervisor);
        kill(supervisor.processes().first, SIGKILL);
        std::this_thread::sleep_for(5ms);
    }
    ending = true;
    for (std::thread& client : clients) client.join();
    EXPECT_EQ(lost, 0);
    EXPECT_GT(answered, 100);
    EXPECT_GE(supervisor.counters().ended, 100u);
}

}  // namespace
}  // namespace clerestory::test

int main(int argc, char** argv) {
    if (argc > 1 && std::strcmp(argv[1], clerestory::kWorkerCommand) == 0) {
        return clerestory::test::playWorker(argc, argv);
    }
    testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
