// What the server process records of a renderer in another process: its jobs, and that its queue
// was full. The renderer is a function here.
#include "server/api/job_routes.h"
#include "server/worker/worker_backend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <set>

namespace clerestory::test {
namespace {

using nlohmann::json;

// Jobs that never end, in a renderer that can be ended.
class Renderers {
public:
    Answer operator()(const Call& call) {
        Answer answer = answerTo(call);
        answer.worker = number_;
        return answer;
    }
    void end() {
        ++number_;
        jobs_.clear();
    }
    void letResultsGo() { jobs_.clear(); }
    void refuseWith(std::optional<Problem> problem) { refusal_ = std::move(problem); }
    int begun() const { return begun_; }

private:
    Answer answerTo(const Call& call) {
        if (call.method == "POST") {
            if (refusal_) return problemAnswer(*refusal_, "");
            ++begun_;
            const std::string id = call.job.empty() ? "job-" + std::to_string(begun_) : call.job;
            jobs_.insert(id);
            EXPECT_EQ(call.body, "the work");
            return jobStarted({.id = id});
        }
        const std::string id = call.path.substr(call.path.rfind('/') + 1);
        if (!jobs_.contains(id)) return jobUnknown(id, "");
        return jobAnswer({.id = id, .state = JobState::running, .progress = 0.5});
    }
    std::uint64_t number_ = 1;
    int begun_ = 0;
    std::optional<Problem> refusal_;
    std::set<std::string> jobs_;
};

class JobJournalTest : public testing::Test {
protected:
    Answer ask(const std::string& method, const std::string& path, const std::string& body = "") {
        return book.ask({.method = method, .path = path, .body = body},
                        [this](const Call& call) { return renderers(call); });
    }
    std::string post() {
        const Answer answer = ask("POST", "/v1/comparisons", "the work");
        EXPECT_EQ(answer.status, 202);
        return json::parse(answer.body).at("id");
    }
    json jobOf(const std::string& id) {
        const Answer answer = ask("GET", "/v1/jobs/" + id);
        EXPECT_EQ(answer.status, 200);
        return answer.status == 200 ? json::parse(answer.body) : json{{"state", ""}};
    }
    Renderers renderers;
    JobJournal book;
};

TEST_F(JobJournalTest, AJobRestartsInTheNextRendererWithItsId) {
    const std::string id = post(), other = post();
    renderers.end();
    for (const std::string& one : {id, other, id}) EXPECT_EQ(jobOf(one).at("state"), "running");
    EXPECT_EQ(renderers.begun(), 4) << "each started again";
}

TEST_F(JobJournalTest, AJobThatCrashesRenderersFails) {
    const std::string id = post();
    for (int run = 1; run < JobJournal::kMaxRuns; ++run) {
        renderers.end();
        EXPECT_EQ(jobOf(id).at("state"), "running");
    }
    renderers.end();
    const json job = jobOf(id);
    EXPECT_EQ(job.at("state"), "failed");
    EXPECT_THAT(job.at("failure").get<std::string>(), testing::HasSubstr("Post it again"));
    EXPECT_EQ(renderers.begun(), JobJournal::kMaxRuns);
}

TEST_F(JobJournalTest, AJobWaitsUntilTheRendererIsReady) {
    const std::string id = post();
    renderers.end();
    renderers.refuseWith(stillLoading("It is loading."));
    EXPECT_EQ(jobOf(id).at("state"), "queued");
    EXPECT_EQ(jobOf(id).at("state"), "queued");
    renderers.refuseWith(std::nullopt);
    EXPECT_EQ(jobOf(id).at("state"), "running");
    renderers.end();
    renderers.refuseWith(invalidFields({}));
    EXPECT_EQ(jobOf(id).at("state"), "failed");
}

TEST_F(JobJournalTest, JobsEvictedByTheSameRendererAreNotFound) {
    const std::string id = post();
    renderers.letResultsGo();
    EXPECT_EQ(ask("GET", "/v1/jobs/" + id).status, 404);
    EXPECT_EQ(ask("GET", "/v1/jobs/unknown").status, 404);
    EXPECT_EQ(renderers.begun(), 1);
}

TEST_F(JobJournalTest, ALostJobCanBeCancelled) {
    const std::string id = post();
    renderers.end();
    const Answer answer = ask("DELETE", "/v1/jobs/" + id);
    EXPECT_EQ(json::parse(answer.body).at("state"), "cancelled");
    EXPECT_EQ(ask("GET", "/v1/jobs/" + id).status, 404);
    EXPECT_EQ(renderers.begun(), 1);
}

TEST_F(JobJournalTest, TheNumberOfJobsIsBounded) {
    const std::string first = post();
    for (std::size_t i = 0; i < JobJournal::kMaxJobs; ++i) post();
    renderers.end();
    EXPECT_EQ(ask("GET", "/v1/jobs/" + first).status, 404);
}

// ---- a full line ---------------------------------------------------------------------------

const std::optional<Problem> kNoProblem;

TEST(OverloadCache, RejectsAgainUntilAResponseArrives) {
    const Clock::time_point now{};
    OverloadCache line;
    EXPECT_FALSE(line.refusalFor("a", now));
    line.end(line.begin(), "a", queueFull(7), now);
    ASSERT_TRUE(line.refusalFor("a", now));
    EXPECT_EQ(line.refusalFor("a", now)->retryAfterSeconds, 7);
    EXPECT_FALSE(line.refusalFor("b", now)) << "who has fewer frames there may push in";
    line.end(line.begin(), "b", kNoProblem, now);
    EXPECT_FALSE(line.refusalFor("a", now));
}

TEST(OverloadCache, ARejectionFromBeforeAPlaceWasFreeIsStale) {
    const Clock::time_point now{};
    OverloadCache line;
    const OverloadCache::Moment begun = line.begin();
    line.end(line.begin(), "b", kNoProblem, now);
    line.end(begun, "a", queueFull(1), now);
    EXPECT_FALSE(line.refusalFor("a", now));
}

TEST(OverloadCache, RejectionsExpire) {
    const Clock::time_point now{};
    OverloadCache line;
    line.end(line.begin(), "a", queueFull(1), now);
    EXPECT_TRUE(
        line.refusalFor("a", now + OverloadCache::kLifetime - std::chrono::milliseconds(1)));
    EXPECT_FALSE(line.refusalFor("a", now + OverloadCache::kLifetime));
}

}  // namespace
}  // namespace clerestory::test
