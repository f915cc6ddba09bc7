// Accuracy by budget: chooses the settings with which a frame meets a limit of time or error, from
// a curve that is measured once for each scene, as a job. Thread-safe.
#pragma once

#include "server/jobs/jobs.h"

#include "comparison/curve.h"

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace clerestory {

// Measured curves on disk, so that a budget does not wait again after a worker or a server has
// ended. A damaged or truncated file is ignored. Thread-safe; any number of processes may share a
// folder.
class CurveStore {
public:
    explicit CurveStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

    // key: all that a curve depends on, the program and the driver included.
    std::optional<Curve> find(const std::string& key) const;
    // A curve over curveSettings(). Errors of writing are only logged. The least recently used
    // curves are removed to make room.
    void keep(const std::string& key, const Curve& curve) const;

private:
    std::filesystem::path fileOf(const std::string& key) const;

    const std::filesystem::path folder_;
};

class Budgets {
public:
    struct Pick {
        Accuracy accuracy;
        std::string words;  // for users: the settings, their predicted cost, what was not met
        std::string curve;  // for drawn()
        std::size_t point = 0;
    };

    struct Requester {
        std::string client;
        bool mayMeasure = true;  // begin a measurement
    };

    // `store`: keeps curves on disk; null: in memory only. `jobs` must end before this.
    Budgets(Jobs& jobs, const JobResources& resources, std::shared_ptr<const CurveStore> store);

    // The settings for the request's budget. A curve belongs to a scene with its overrides,
    // lighting, effects and size, not to a view: the first view that is requested is measured.
    // Throws RequestError 409 with the progress of the job while the curve is measured, 403 if the
    // requester may not begin it, 503 if there are too many jobs.
    Pick pick(const FrameRequest& request, const Requester& requester);

    // A frame with these settings took that many milliseconds: corrects the curve.
    void drawn(const Pick& pick, double milliseconds);

private:
    struct Measured {
        std::string job;  // that measures the curve, or measured it
        std::shared_ptr<Curve> curve;
        int corrections = 0;  // since the curve was last written to disk
    };
    std::string keyOf(const FrameRequest& request) const;
    std::optional<Curve> measured(const FrameRequest& request, const JobControl& control) const;

    Jobs& jobs_;
    const JobResources resources_;
    const std::shared_ptr<const CurveStore> store_;
    std::mutex mutex_;
    std::map<std::string, Measured> curves_;
};

}  // namespace clerestory
