// Work that takes longer than a request may: one thread does it, one piece after the other, behind
// a bounded line. What came out is kept for a while, under an id that cannot be guessed.
//
// Does not: know what the work is, nor HTTP.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace clerestory {

enum class JobState { queued, running, done, failed, cancelled };
std::string_view nameOf(JobState state);

struct JobPicture {
    std::string type;  // media type
    std::string bytes;
};

struct JobResult {
    std::string json;                  // one JSON value
    std::vector<JobPicture> pictures;  // asked for by their number, from 0
};

struct JobStatus {
    std::string id;
    JobState state = JobState::queued;
    double progress = 0.0;                    // 0..1, never less than before
    std::string failure;                      // words for people, when failed
    std::shared_ptr<const JobResult> result;  // when done
};

// The work's side of a job.
class JobControl {
public:
    // Tells how far the work is, 0..1. False: nobody wants it any more; end soon, with any result.
    bool proceed(double progress) const;

private:
    friend class Jobs;
    explicit JobControl(std::function<bool(double)> told) : told_(std::move(told)) {}
    std::function<bool(double)> told_;
};

class Jobs {
public:
    using Work = std::function<JobResult(const JobControl&)>;

    // `capacity`: jobs that may wait or run at once, at least 1.
    explicit Jobs(std::size_t capacity);
    ~Jobs();  // cancels everything and waits for the work that runs
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;

    // `id` is the job's own, so that its result can name it; `known`: the one that it must have,
    // and where there is such a job already, that one is meant. Throws RequestError 503 when the
    // line is full. An exception of the work makes the job failed, in the words of a RequestError
    // or an InvalidRequest, or none of the inside.
    JobStatus start(std::function<Work(const std::string& id)> work, const std::string& known = "");

    // Throws RequestError 404 when there is no such job, or no longer.
    JobStatus find(const std::string& id) const;

    // What is done stays done. Throws like find().
    JobStatus cancel(const std::string& id);

private:
    struct Job {
        JobStatus status;
        Work work;
        bool unwanted = false;
    };
    void serve();
    void run(Job& job);
    Job* find(std::string_view id, const std::lock_guard<std::mutex>&) const;
    Job& jobFor(const std::string& id, const std::lock_guard<std::mutex>& lock) const;

    const std::size_t capacity_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<std::shared_ptr<Job>> jobs_;  // oldest first; the finished ones are kept a while
    bool ending_ = false;
    std::thread thread_;
};

}  // namespace clerestory
