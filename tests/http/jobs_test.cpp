// The queue of long work: order, progress, cancellation, failures, stored results, limits.
#include "server/jobs/jobs.h"
#include "server/base/problem.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>

namespace clerestory::test {
namespace {

using namespace std::chrono_literals;

// A result that differs from others.
JobResult resultOf(double number) {
    return {.value = Curve{.points = {}, .relMseNoise = number}, .pictures = {}};
}

double numberOf(const JobResult& result) {
    return std::get<Curve>(result.value).relMseNoise;
}

Jobs::Work saying(double number) {
    return [number](const JobControl&) { return resultOf(number); };
}

std::function<Jobs::Work(const std::string&)> simply(Jobs::Work work) {
    return [work](const std::string&) { return work; };
}

JobStatus ended(const Jobs& jobs, const std::string& id) {
    JobStatus status;
    EXPECT_TRUE(within(kPatience, [&] {
        status = jobs.find(id);
        return status.state != JobState::queued && status.state != JobState::running;
    }));
    return status;
}

// Work that waits for a signal to continue, and the values that it received from its control.
struct BlockingWork {
    std::promise<void> open, entered;
    std::shared_future<void> opened{open.get_future().share()};
    Jobs::Work work() {
        return [this](const JobControl& control) {
            control.proceed(0.25);
            entered.set_value();
            opened.wait();
            const bool wanted = control.proceed(0.125);
            return resultOf(wanted ? 1 : 0);
        };
    }
};

TEST(Jobs, AResultIsStoredUnderItsId) {
    Jobs jobs(2);
    std::string observedId;
    const JobStatus started = jobs.start(
        [&](const std::string& id) {
            observedId = id;
            return saying(42);
        },
        "");
    EXPECT_EQ(started.id, observedId);
    EXPECT_EQ(started.id.size(), 32u);
    const JobStatus status = ended(jobs, started.id);
    EXPECT_EQ(status.state, JobState::done);
    EXPECT_EQ(status.progress, 1.0);
    ASSERT_TRUE(status.result);
    EXPECT_EQ(numberOf(*status.result), 42);
    EXPECT_EQ(jobs.cancel(started.id).state, JobState::done) << "what is done stays done";
}

TEST(Jobs, ProgressIsMonotonicAndTheQueueIsBounded) {
    Jobs jobs(2);
    BlockingWork gate;
    const std::string running = jobs.start(simply(gate.work()), "").id;
    gate.entered.get_future().wait();
    const std::string waiting = jobs.start(simply(saying(2)), "b").id;
    EXPECT_EQ(jobs.find(waiting).state, JobState::queued);
    try {
        jobs.start(simply(saying(3)), "c");
        FAIL() << "a third job was taken";
    } catch (const RequestError& error) {
        EXPECT_EQ(error.problem().status, 503);
        EXPECT_GT(error.problem().retryAfterSeconds, 0);
    }
    EXPECT_EQ(jobs.cancel(waiting).state, JobState::cancelled);
    gate.open.set_value();
    const JobStatus status = ended(jobs, running);
    EXPECT_EQ(status.state, JobState::done);
    EXPECT_EQ(numberOf(*status.result), 1);
    EXPECT_EQ(jobs.find(waiting).state, JobState::cancelled) << "it ran although cancelled";
}

// One client fills its share; the next one finds room, and its job runs second.
TEST(Jobs, ClientsHaveSharesAndTurns) {
    Jobs jobs(8);
    BlockingWork gate;
    std::vector<std::string> order;
    const auto noting = [&](const std::string& name) {
        return simply([&order, name](const JobControl&) {
            order.push_back(name);
            return JobResult{};
        });
    };
    jobs.start(simply(gate.work()), "heavy");
    gate.entered.get_future().wait();
    std::string last;
    for (const char* name : {"heavy 2", "heavy 3", "heavy 4"}) {
        last = jobs.start(noting(name), "heavy").id;
    }
    EXPECT_THROW(jobs.start(noting("heavy 5"), "heavy"), RequestError) << "half of the places";
    jobs.start(noting("moderate 1"), "moderate");
    jobs.start(noting("moderate 2"), "moderate");
    const Holdings::Usage open = jobs.usage();
    EXPECT_EQ(open.total, 6u);
    EXPECT_EQ(open.clients, 2u);
    EXPECT_EQ(open.greatest, 4u);
    const std::string cancelled = jobs.start(noting("other"), "other").id;
    jobs.cancel(cancelled);
    EXPECT_EQ(jobs.usage().clients, 2u) << "a cancelled job holds no place";
    // A job that continues after a failover has its place.
    jobs.start(noting("heavy 6"), "heavy", "known");
    gate.open.set_value();
    ended(jobs, last);
    ended(jobs, "known");
    EXPECT_EQ(order, (std::vector<std::string>{"moderate 1", "heavy 2", "moderate 2", "heavy 3",
                                               "heavy 4", "heavy 6"}));
    EXPECT_EQ(jobs.usage().total, 0u);
}

TEST(Jobs, CancelledWorkIsNotified) {
    Jobs jobs(1);
    BlockingWork gate;
    const std::string id = jobs.start(simply(gate.work()), "").id;
    gate.entered.get_future().wait();
    EXPECT_EQ(jobs.cancel(id).state, JobState::running);
    EXPECT_EQ(jobs.find(id).progress, 0.25);
    gate.open.set_value();
    const JobStatus status = ended(jobs, id);
    EXPECT_EQ(status.state, JobState::cancelled);
    EXPECT_EQ(status.progress, 0.25);
    EXPECT_FALSE(status.result);
}

TEST(Jobs, AFailureHasAMessageWithoutInternals) {
    Jobs jobs(2);
    const std::string ours = jobs.start(simply([](const JobControl&) -> JobResult {
                                            throw std::runtime_error("secret path");
                                        }),
                                        "")
                                 .id;
    EXPECT_EQ(ended(jobs, ours).state, JobState::failed);
    EXPECT_EQ(ended(jobs, ours).failure.find("secret"), std::string::npos);
    const std::string theirs = jobs.start(simply([](const JobControl&) -> JobResult {
                                              throw RequestError(notFound("No such thing."));
                                          }),
                                          "")
                                   .id;
    EXPECT_EQ(ended(jobs, theirs).failure, "No such thing.");
}

TEST(Jobs, OldResultsAreEvicted) {
    Jobs jobs(1);
    const std::string first = jobs.start(simply(saying(0)), "").id;
    ended(jobs, first);
    for (int i = 0; i < 16; ++i) ended(jobs, jobs.start(simply(saying(1)), "").id);
    EXPECT_THROW(jobs.find(first), RequestError);
}

// By their size as well: pictures can be large. The newest one stays whatever its size.
TEST(Jobs, OldResultsAreEvictedBySize) {
    Jobs jobs(1);
    const auto withPicture = [](std::size_t megabytes) {
        return simply([megabytes](const JobControl&) {
            return JobResult{.value = {},
                             .pictures = {{"image/png", std::string(megabytes << 20, 'x')}}};
        });
    };
    const std::string small = jobs.start(withPicture(1), "").id;
    ended(jobs, small);
    const std::string first = jobs.start(withPicture(100), "").id;
    ended(jobs, first);
    const std::string second = jobs.start(withPicture(100), "").id;
    ended(jobs, second);
    EXPECT_TRUE(jobs.lookUp(small)) << "201 MB";
    const std::string third = jobs.start(withPicture(100), "").id;
    ended(jobs, third);
    EXPECT_FALSE(jobs.lookUp(small)) << "more than 256 MB";
    EXPECT_FALSE(jobs.lookUp(first));
    EXPECT_TRUE(jobs.lookUp(second));
    const std::string huge = jobs.start(withPicture(300), "").id;
    EXPECT_EQ(ended(jobs, huge).state, JobState::done);
    EXPECT_TRUE(jobs.lookUp(huge));
    EXPECT_FALSE(jobs.lookUp(third));
}

TEST(Jobs, StoppingCancelsRunningJobs) {
    BlockingWork gate;
    bool cancelled = false;
    {
        Jobs jobs(2);
        jobs.start(simply([&](const JobControl& control) {
                       gate.entered.set_value();
                       while (control.proceed(0.0)) std::this_thread::sleep_for(1ms);
                       cancelled = true;
                       return JobResult{};
                   }),
                   "");
        gate.entered.get_future().wait();
    }
    EXPECT_TRUE(cancelled);
}

}  // namespace
}  // namespace clerestory::test
