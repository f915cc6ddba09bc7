// Accuracy by budget: chooses the settings with which a frame meets a limit of time or error, from
// a curve that is measured once for each scene, as a job. Thread-safe.
#pragma once

#include "comparison/curve.h"
#include "server/jobs/curve_store.h"
#include "server/jobs/job_work.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace clerestory {

class Budgets {
public:
    struct Pick {
        Accuracy accuracy;
        std::string words;  // for people: the settings, their predicted cost, what was not met
        std::string curve;  // for drawn()
        std::size_t point = 0;
    };

    // `store`: keeps curves on disk; null: in memory only. `jobs` must end before this.
    Budgets(Jobs& jobs, const JobResources& resources, std::shared_ptr<const CurveStore> store);

    // The settings for the request's budget. A curve belongs to a scene with its overrides,
    // lighting, effects and size, not to a view: the first view that is requested is measured.
    // Throws RequestError 409 with the progress of the job while the curve is measured, 503 if
    // there are too many jobs.
    Pick pick(const Scene& scene, const FrameRequest& request);

    // A frame with these settings took that many milliseconds: corrects the curve.
    void drawn(const Pick& pick, double milliseconds);

private:
    struct Measured {
        std::string job;  // that measures the curve, or measured it
        std::shared_ptr<Curve> curve;
        int corrections = 0;  // since the curve was last written to disk
    };
    std::string keyOf(const Scene& scene, const FrameRequest& request) const;
    std::optional<Curve> measured(const FrameRequest& request, const JobControl& control) const;

    Jobs& jobs_;
    const JobResources resources_;
    const std::shared_ptr<const CurveStore> store_;
    std::mutex mutex_;
    std::map<std::string, Measured> curves_;
};

}  // namespace clerestory
