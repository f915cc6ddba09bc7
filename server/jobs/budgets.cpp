#include "server/jobs/budgets.h"

#include "server/api/comparison_json.h"
#include "server/api/frames.h"
#include "server/base/problem.h"
#include "server/jobs/curve_store.h"
#include "server/jobs/job_work.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

// A few kilobytes each; the scenes and sizes that one server is asked for are few.
constexpr std::size_t kMaxCurves = 256;
// Frames whose milliseconds go to the disk together.
constexpr int kCorrectionsKept = 50;

std::string keyOf(Service& service, const Scene& scene, const FrameRequest& request) {
    FrameRequest frame = request;
    frame.camera = {};
    frame.accuracy = {};
    frame.output = {};
    frame.toneMap = {};
    frame.exposure = 0.0;
    frame.filters.clear();
    return contentText(service, scene, frame);
}

std::optional<Curve> measured(Service& service, const FrameRequest& request,
                              const JobControl& control) {
    const auto trace = [&](const FrameRequest& frame,
                           std::uint32_t samples) -> std::optional<ReferenceImage> {
        const auto truth = tracedReference(
            service, frame, ReferenceMode::effects, samples, 1,
            [&](double share) { return control.proceed(kCurveTracingShare * share); });
        if (!truth) return std::nullopt;
        return truth->image;
    };
    const auto draw = [&](const FrameRequest& frame) {
        return drawnBetween(service, frame, control);
    };
    try {
        return measureCurve(request, trace, draw,
                            [&](double share) { return control.proceed(share); });
    } catch (const JobCancelled&) {
        return std::nullopt;
    }
}

// Of a job that waits or runs; none otherwise.
std::optional<double> progressOf(const Jobs& jobs, const std::string& id) {
    if (id.empty()) return std::nullopt;
    try {
        const JobStatus status = jobs.find(id);
        const bool underWay = status.state == JobState::queued || status.state == JobState::running;
        return underWay ? std::optional(status.progress) : std::nullopt;
    } catch (const RequestError&) {  // let go
        return std::nullopt;
    }
}

}  // namespace

Budgets::Pick Budgets::pick(Service& service, const Scene& scene, const FrameRequest& request) {
    const std::string key = keyOf(service, scene, request);
    const std::lock_guard lock(mutex_);
    if (curves_.size() >= kMaxCurves && curves_.count(key) == 0) curves_.clear();
    Measured& found = curves_[key];
    const CurveStore* store = service.config().curves.get();
    if (!found.curve && found.job.empty() && store) {
        if (auto kept = store->find(key)) found.curve = std::make_shared<Curve>(*std::move(kept));
    }
    if (found.curve) {
        const Chosen chosen = choose(*found.curve, request.accuracy);
        return {found.curve->points[chosen.point].accuracy, chosen.words, key, chosen.point};
    }
    if (const auto progress = progressOf(service.jobs(), found.job)) {
        throw RequestError(stillMeasuring(found.job, *progress));
    }
    const auto work = [this, &service, request, key](const JobControl& control) {
        auto curve = measured(service, request, control);
        if (!curve) return JobResult{};
        if (const auto& kept = service.config().curves) kept->keep(key, *curve);
        JobResult result{.json = curveJson(*curve).dump(), .pictures = {}};
        const std::lock_guard keeping(mutex_);
        curves_[key].curve = std::make_shared<Curve>(*std::move(curve));
        return result;
    };
    found.job = service.jobs().start([&](const std::string&) { return work; }).id;
    throw RequestError(stillMeasuring(found.job, 0.0));
}

void Budgets::drawn(Service& service, const Pick& pick, double milliseconds) {
    const std::lock_guard lock(mutex_);
    const auto found = curves_.find(pick.curve);
    if (found == curves_.end() || !found->second.curve) return;
    Measured& measured = found->second;
    refine(measured.curve->points[pick.point], milliseconds);
    const CurveStore* store = service.config().curves.get();
    if (!store || ++measured.corrected < kCorrectionsKept) return;
    measured.corrected = 0;
    store->keep(pick.curve, *measured.curve);
}

}  // namespace clerestory
