// A file of a curve: a line with the checksum of the rest, a line of figures, the key.
#include "server/jobs/budgets.h"

#include "server/base/log.h"
#include "server/base/problem.h"

#include "scene/cache_file.h"
#include "scene/hash.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>

namespace clerestory {
namespace {

constexpr const char* kExtension = ".curve";
constexpr std::uint64_t kMaxCurveBytes = 1 << 20;  // of one; a few kilobytes as a rule
constexpr std::uint64_t kMaxBytesOfAll = 64ull << 20;

// Its settings are those of curveSettings(), which another program (and so another key) may have
// changed.
std::string figuresOf(const Curve& curve) {
    char number[40];
    std::string text;
    const auto add = [&](double value) {
        std::snprintf(number, sizeof number, "%.17g ", value);
        text += number;
    };
    add(curve.relMseNoise);
    for (const CurvePoint& p : curve.points) {
        add(p.milliseconds);
        add(p.relMse);
    }
    return text;
}

std::optional<Curve> curveFrom(const std::string& figures) {
    std::istringstream text(figures);
    Curve curve;
    bool sound = static_cast<bool>(text >> curve.relMseNoise);
    const auto good = [](double value) { return std::isfinite(value) && value >= 0.0; };
    for (const Accuracy& accuracy : curveSettings()) {
        CurvePoint p{.accuracy = accuracy};
        sound =
            sound && text >> p.milliseconds >> p.relMse && good(p.milliseconds) && good(p.relMse);
        curve.points.push_back(p);
    }
    if (!sound || !(text >> std::ws).eof()) return std::nullopt;
    return curve;
}

// A few kilobytes each; a server sees few combinations of scene and size.
constexpr std::size_t kMaxCurves = 256;
// Corrected curves are written to disk after this many corrections.
constexpr int kCorrectionsPerWrite = 50;

// Of a job that waits or runs; empty for any other, and for a job whose result was discarded.
std::optional<double> progressOf(const Jobs& jobs, const std::string& id) {
    const auto status = id.empty() ? std::nullopt : jobs.lookUp(id);
    const bool unfinished =
        status && (status->state == JobState::queued || status->state == JobState::running);
    return unfinished ? std::optional(status->progress) : std::nullopt;
}

}  // namespace

std::filesystem::path CurveStore::fileOf(const std::string& key) const {
    return folder_ / (hashWordOf(key) + kExtension);
}

std::optional<Curve> CurveStore::find(const std::string& key) const {
    const auto content = readCacheFile(fileOf(key), kMaxCurveBytes);
    if (!content) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(content->bytes.get()), content->size);
    const std::size_t first = text.find('\n');
    const std::size_t second = first == text.npos ? first : text.find('\n', first + 1);
    if (second == text.npos || text.substr(0, first) != hashWordOf(text.substr(first + 1)) ||
        text.substr(second + 1) != key) {
        return std::nullopt;
    }
    return curveFrom(std::string(text.substr(first + 1, second - first - 1)));
}

void CurveStore::keep(const std::string& key, const Curve& curve) const {
    const std::string rest = figuresOf(curve) + '\n' + key;
    const std::string text = hashWordOf(rest) + '\n' + rest;
    if (text.size() > kMaxCurveBytes) return;
    if (writeCacheFile(fileOf(key), {std::as_bytes(std::span(text))})) {
        trimCacheFolder(folder_, kExtension, kMaxBytesOfAll);
    } else {
        logDebug({"a curve cannot be kept: ", std::strerror(errno)});
    }
}

Budgets::Budgets(Jobs& jobs, const JobResources& resources, std::shared_ptr<const CurveStore> store)
    : jobs_(jobs), resources_(resources), store_(std::move(store)) {}

std::string Budgets::keyOf(const FrameRequest& request) const {
    FrameRequest frame = request;
    frame.camera = {};
    frame.accuracy = {};
    frame.output = {};
    frame.toneMap = {};
    frame.exposure = 0.0;
    frame.filters.clear();
    return resources_.contentText(frame);
}

std::optional<Curve> Budgets::measured(const FrameRequest& request,
                                       const JobControl& control) const {
    // A picture without these effects is compared with a truth without them.
    const bool full = request.effects.shadows && request.effects.indirectLight;
    const ReferenceMode mode = full ? ReferenceMode::full : ReferenceMode::effects;
    const auto trace = [&](const FrameRequest& frame,
                           std::uint32_t samples) -> std::optional<ReferenceImage> {
        const auto truth = traceReference(
            resources_.library.environments(), wholeScene(resources_.library, frame), frame, mode,
            samples, 1, [&](double share) { return control.proceed(kCurveTracingShare * share); });
        if (!truth) return std::nullopt;
        return truth->image;
    };
    const auto draw = [&](const FrameRequest& frame) {
        return drawInQueue(resources_, frame, control);
    };
    try {
        return measureCurve(request, trace, draw,
                            [&](double share) { return control.proceed(share); });
    } catch (const JobCancelled&) {
        return std::nullopt;
    }
}

Budgets::Pick Budgets::pick(const FrameRequest& request, const Requester& requester) {
    const std::string key = keyOf(request);
    const std::lock_guard lock(mutex_);
    if (curves_.size() >= kMaxCurves && curves_.count(key) == 0) curves_.clear();
    Measured& found = curves_[key];
    if (!found.curve && found.job.empty() && store_) {
        if (auto stored = store_->find(key)) {
            found.curve = std::make_shared<Curve>(*std::move(stored));
        }
    }
    if (found.curve) {
        const Chosen chosen = choose(*found.curve, request.accuracy);
        return {found.curve->points[chosen.point].accuracy, chosen.words, key, chosen.point};
    }
    if (const auto progress = progressOf(jobs_, found.job)) {
        throw RequestError(stillMeasuring(found.job, *progress));
    }
    if (!requester.mayMeasure) {
        throw RequestError(
            forbidden("A page of another site cannot start the measurement of a budget. Open the "
                      "link itself first, or send the frame by POST."));
    }
    const auto work = [this, request, key](const JobControl& control) {
        auto curve = measured(request, control);
        if (!curve) return JobResult{};
        if (store_) store_->keep(key, *curve);
        JobResult result{.value = *curve};
        const std::lock_guard inner(mutex_);
        curves_[key].curve = std::make_shared<Curve>(*std::move(curve));
        return result;
    };
    found.job = jobs_.start([&](const std::string&) { return work; }, requester.client).id;
    throw RequestError(stillMeasuring(found.job, 0.0));
}

void Budgets::drawn(const Pick& pick, double milliseconds) {
    const std::lock_guard lock(mutex_);
    const auto found = curves_.find(pick.curve);
    if (found == curves_.end() || !found->second.curve) return;
    Measured& measured = found->second;
    refine(measured.curve->points[pick.point], milliseconds);
    if (!store_ || ++measured.corrections < kCorrectionsPerWrite) return;
    measured.corrections = 0;
    store_->keep(pick.curve, *measured.curve);
}

}  // namespace clerestory
