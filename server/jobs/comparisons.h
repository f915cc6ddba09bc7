// Comparisons as jobs: what accuracies cost in one view, and how far each is from the path-traced
// reference. Thread-safe.
#pragma once

#include "comparison/comparison.h"
#include "server/jobs/jobs.h"

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

namespace clerestory {

// The path-traced references of the last comparisons, so that a comparison of other settings in the
// same view starts at once. Thread-safe.
class ReferenceCache {
public:
    // The reference with this key, or else the result of `trace`, which is added unless it is null.
    std::shared_ptr<const ReferenceRender> find(
        const std::string& key,
        const std::function<std::shared_ptr<const ReferenceRender>()>& trace);

private:
    struct Entry {
        std::string key;
        std::shared_ptr<const ReferenceRender> reference;
    };
    std::mutex mutex_;
    std::list<Entry> entries_;  // most recently used first
};

class Comparisons {
public:
    // `jobs` must end before this.
    Comparisons(Jobs& jobs, const JobResources& resources) : jobs_(jobs), resources_(resources) {}

    // request.frame.scene is the id of a loaded scene. `knownId`: see Jobs::start(). Throws
    // RequestError 503 if there are too many jobs.
    JobStatus start(const ComparisonRequest& request, const std::string& client,
                    const std::string& knownId = "");

private:
    JobResult run(const ComparisonRequest& request, const JobControl& control);

    Jobs& jobs_;
    const JobResources resources_;
    ReferenceCache references_;
};

}  // namespace clerestory
